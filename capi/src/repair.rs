//! # Repair
//!
//! Meshes without seams, repeated faces, faces without area, edges of many faces, holes and specks,
//! with their attributes; and a report of what was done.
//!
//! ```c
//! double v[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 0, 0, 1, 1, 0, 0, 1, 0}; // two triangles, apart
//! uint32_t f[] = {0, 1, 2, 3, 4, 5};
//! cata_mesh_file *soup, *square;
//! cata_repair *repair;
//! cata_repair_params params = {.struct_size = sizeof params, .everything = 1};
//! size_t n_vertices;
//! cata_mesh_file_new(6, v, 2, f, &soup);
//! cata_repair_new(soup, &params, &repair);
//! cata_repair_file(repair, &square);
//! cata_mesh_file_size(square, &n_vertices, NULL);
//! printf("%zu of 6 vertices\n", n_vertices); // 4 of 6 vertices
//! cata_mesh_file_free(soup);
//! cata_mesh_file_free(square);
//! cata_repair_free(repair);
//! ```

use std::ffi::{c_char, c_void};

use super::boundary::boundary;
use super::mesh_file::cata_mesh_file;
use super::outputs::{element, tell, write_text};
use super::params::{Params, flag, init, params, read_or_zeros};
use super::pointer::{free, hand_over, known, mesh, output, slice_mut};
use super::progress::cata_progress;
use super::status::{Failure, cata_status};
use catamaran_geometry::mesh::{RepairOptions, RepairStep, Repaired, Weld, needs_repair, repair};

/// `weld`: no vertices.
pub const CATA_WELD_NEVER: i32 = 0;
/// `weld`: vertices in the same place.
pub const CATA_WELD_EXACT: i32 = 1;
/// `weld`: vertices at most `tolerance` apart.
pub const CATA_WELD_WITHIN: i32 = 2;
/// `weld`: along seams, where exactly two boundary edges coincide.
pub const CATA_WELD_SEAMS: i32 = 3;

/// A step: vertices were joined.
pub const CATA_REPAIR_WELDED: i32 = 0;
/// A step: seams were closed.
pub const CATA_REPAIR_SEAMS: i32 = 1;
/// A step: repeated faces were left out.
pub const CATA_REPAIR_DUPLICATES: i32 = 2;
/// A step: faces without area were removed.
pub const CATA_REPAIR_DEGENERATE: i32 = 3;
/// A step: vertices without a face were left out.
pub const CATA_REPAIR_COMPACTED: i32 = 4;
/// A step: the mesh was cut into a manifold.
pub const CATA_REPAIR_CUT: i32 = 5;
/// A step: all but the largest components were left out.
pub const CATA_REPAIR_LARGEST: i32 = 6;
/// A step: small components were left out.
pub const CATA_REPAIR_SPECKS: i32 = 7;
/// A step: holes were filled.
pub const CATA_REPAIR_HOLES: i32 = 8;
/// A step: faces were flipped.
pub const CATA_REPAIR_ORIENTED: i32 = 9;

/// The steps of a repair, in their order; by default there are none.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cata_repair_params {
    /// sizeof(cata_repair_params).
    pub struct_size: usize,
    /// Ignored.
    pub threads: usize,
    /// Progress callback; NULL: none.
    pub progress: cata_progress,
    /// Passed to `progress`.
    pub progress_user: *mut c_void,
    /// For CATA_WELD_WITHIN: in the unit of the mesh. Otherwise ignored.
    pub tolerance: f64,
    /// Components to keep, those with the most faces; 0: all.
    pub keep_largest: usize,
    /// Components with less than this share of the area, from 0 to 1, are left out.
    pub drop_specks: f64,
    /// Holes of at most this many edges are filled.
    pub fill_holes: usize,
    /// 1: as if all fields after `weld` were 1, and `weld` CATA_WELD_SEAMS where it is
    /// CATA_WELD_NEVER. 0: they say what is done.
    pub everything: i32,
    /// CATA_WELD_*: the vertices that are joined.
    pub weld: i32,
    /// 1: faces with the vertices of an earlier one are left out. 0: they stay.
    pub drop_duplicates: i32,
    /// 1: faces without area are removed. 0: they stay.
    pub drop_degenerate: i32,
    /// 1: vertices without a face are left out. 0: they stay.
    pub compact: i32,
    /// 1: the mesh is cut along edges of more than two faces, and where it meets itself. 0: it is
    /// not.
    pub cut: i32,
    /// 1: faces are flipped to agree with their neighbours, and in closed components so that they
    /// are counter-clockwise as seen from outside. 0: they stay.
    pub orient: i32,
}

params!(cata_repair_params, orient: i32);

/// A repaired mesh, and what was done. Made by cata_repair_new; constant.
pub struct cata_repair {
    repaired: Repaired,
    /// Number of vertices of the input.
    n_vertices: usize,
}

/// Fills a struct with the defaults.
///
/// # Safety
/// `params` points to `struct_size` writable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_repair_params_init(
    params: *mut cata_repair_params,
    struct_size: usize,
) -> cata_status {
    // SAFETY: clause `structs` (`params`).
    unsafe { init(params, struct_size) }
}

/// Repairs a mesh by the steps of `params`. Attributes follow their vertices and corners.
///
/// - `file`: stays as it is.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_repair_new(
    file: *const cata_mesh_file,
    params: *const cata_repair_params,
    repair: *mut *mut cata_repair,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`repair`, one value), clause `handles` (`file`), clause
        // `structs` (`params`).
        let (file, params, place) = unsafe {
            let file = &known("file", file)?.file;
            (file, read_or_zeros("params", params)?, output("repair", repair)?)
        };
        let options = options(&params)?;
        let n_vertices = file.mesh.vertices().len();
        let repaired = params.caller().reported(|_| Ok(self::repair(file.clone(), &options)?))?;
        hand_over(place, cata_repair { repaired, n_vertices });
        Ok(())
    })
}

/// Frees a repair.
///
/// # Safety
/// The pointer is as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_repair_free(repair: *mut cata_repair) {
    // SAFETY: clause `handles` (`repair`).
    unsafe { free(repair) };
}

/// Copies the repaired mesh: `file`, one pointer, written.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_repair_file(
    repair: *const cata_repair,
    file: *mut *mut cata_mesh_file,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`file`, one value), clause `handles` (`repair`).
        let (own, place) = unsafe { (known("repair", repair)?, output("file", file)?) };
        hand_over(place, cata_mesh_file { file: own.repaired.file.clone() });
        Ok(())
    })
}

/// Gets for each vertex of the input the lowest vertex of the result that comes from it, UINT32_MAX
/// where it was left out: `vertices`, as many elements as the input has vertices, written.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_repair_vertices(
    repair: *const cata_repair,
    vertices: *mut u32,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`vertices`, `own.n_vertices` elements), clause `handles`
        // (`repair`).
        let (own, vertices) = unsafe {
            let own = known("repair", repair)?;
            (own, slice_mut("vertices", vertices, own.n_vertices)?)
        };
        match &own.repaired.vertices {
            Some(found) => vertices.copy_from_slice(found),
            None => vertices.iter_mut().zip(0..).for_each(|(place, v)| *place = v),
        }
        Ok(())
    })
}

/// Gets the number of steps that were taken, in the order of the fields of cata_repair_params, and
/// whether any changed the mesh: 1, or 0. NULL where not wanted.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_repair_steps(
    repair: *const cata_repair,
    count: *mut usize,
    changed: *mut i32,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`count`, one value; `changed`, one value), clause `handles`
        // (`repair`).
        unsafe {
            let report = &known("repair", repair)?.repaired.report;
            tell!(count: report.steps.len(), changed: report.changed().into());
        }
        Ok(())
    })
}

/// Gets what a step did, from 0; NULL where not wanted, 0 where a step has no such number.
///
/// - `kind`: CATA_REPAIR_*.
/// - `vertices`: that joined others, were left out, or were split.
/// - `edges`: that were flipped or cut; of CATA_REPAIR_SEAMS: that stay, because more than two
///   coincide.
/// - `faces`: that were left out; of CATA_REPAIR_HOLES: new ones; of CATA_REPAIR_ORIENTED: flipped.
/// - `parts`: components that were left out, or holes that were filled.
/// - `left`: boundary loops that stay, or parts that are not orientable and stay as they were; of
///   joined vertices: those that lost their colour, because the first one has another.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_repair_step(
    repair: *const cata_repair,
    step: usize,
    kind: *mut i32,
    vertices: *mut usize,
    edges: *mut usize,
    faces: *mut usize,
    parts: *mut usize,
    left: *mut usize,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (one value for each output), clause `handles` (`repair`).
        unsafe {
            let (found, [a, b, c, d, e]) = described(*one(known("repair", repair)?, step)?);
            tell!(kind: found, vertices: a, edges: b, faces: c, parts: d, left: e);
        }
        Ok(())
    })
}

/// Gets what a step did, from 0, as a line of text: `size` elements of `text`, cut to fit, with a
/// NUL.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_repair_step_text(
    repair: *const cata_repair,
    step: usize,
    size: usize,
    text: *mut c_char,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`text`, `size` elements), clause `handles` (`repair`).
        let (step, text) =
            unsafe { (one(known("repair", repair)?, step)?, slice_mut("text", text, size)?) };
        write_text(text, &step.to_string());
        Ok(())
    })
}

/// Gets whether a mesh has seams, repeated faces or faces without area, whose repair has a single
/// sensible result: 1, or 0; and a line about the first: `size` elements of `text`, cut to fit, and
/// NUL; NULL where not wanted.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_repair_needed(
    n_vertices: usize,
    vertices: *const f64,
    n_faces: usize,
    faces: *const u32,
    needed: *mut i32,
    size: usize,
    text: *mut c_char,
) -> cata_status {
    boundary(|| {
        let size = if text.is_null() { 0 } else { size };
        // SAFETY: clause `memory` (the mesh, 3 numbers a vertex and 3 indices a face; `needed`, one
        // value; `text`, `size` elements).
        let (mesh, needed, text) = unsafe {
            (
                mesh(n_vertices, vertices, n_faces, faces)?,
                output("needed", needed)?,
                slice_mut("text", text, size)?,
            )
        };
        let found = needs_repair(&mesh);
        *needed = i32::from(found.is_some());
        write_text(text, found.as_deref().unwrap_or_default());
        Ok(())
    })
}

/// Returns a step of the report.
fn one(repair: &cata_repair, step: usize) -> Result<&RepairStep, Failure> {
    element("step", &repair.repaired.report.steps, "steps", step)
}

/// Returns the kind of a step, and its numbers: vertices, edges, faces, parts, left.
fn described(step: RepairStep) -> (i32, [usize; 5]) {
    match step {
        RepairStep::Welded { vertices, faces, colors, .. } => {
            (CATA_REPAIR_WELDED, [vertices, 0, faces, 0, colors])
        }
        RepairStep::ClosedSeams { vertices, colors, ambiguous } => {
            (CATA_REPAIR_SEAMS, [vertices, ambiguous, 0, 0, colors])
        }
        RepairStep::DroppedDuplicates { faces, .. } => {
            (CATA_REPAIR_DUPLICATES, [0, 0, faces, 0, 0])
        }
        RepairStep::DroppedDegenerate { joined, flipped, faces, .. } => {
            (CATA_REPAIR_DEGENERATE, [joined, flipped, faces, 0, 0])
        }
        RepairStep::Compacted { vertices } => (CATA_REPAIR_COMPACTED, [vertices, 0, 0, 0, 0]),
        RepairStep::Cut { edges, vertices } => (CATA_REPAIR_CUT, [vertices, edges, 0, 0, 0]),
        RepairStep::KeptLargest { components, faces } => {
            (CATA_REPAIR_LARGEST, [0, 0, faces, components, 0])
        }
        RepairStep::DroppedSpecks { components, faces, .. } => {
            (CATA_REPAIR_SPECKS, [0, 0, faces, components, 0])
        }
        RepairStep::FilledHoles { holes, faces, left } => {
            (CATA_REPAIR_HOLES, [0, 0, faces, holes, left])
        }
        RepairStep::Oriented { faces, not_orientable, .. } => {
            (CATA_REPAIR_ORIENTED, [0, 0, faces, 0, not_orientable])
        }
        _ => unreachable!("a step without a value of its own: {step:?}"),
    }
}

/// Returns the options of the caller.
pub(super) fn options(params: &cata_repair_params) -> Result<RepairOptions, Failure> {
    let everything = flag("params.everything", params.everything)?;
    let chosen = |what: &str, value: i32| Ok::<_, Failure>(flag(what, value)? || everything);
    let weld = match params.weld {
        CATA_WELD_NEVER if everything => Weld::Seams,
        CATA_WELD_NEVER => Weld::Never,
        CATA_WELD_EXACT => Weld::Exact,
        CATA_WELD_WITHIN => Weld::Within(params.tolerance),
        CATA_WELD_SEAMS => Weld::Seams,
        other => return Err(Failure::argument("params.weld", "a CATA_WELD_* value", other)),
    };
    Ok(RepairOptions::new()
        .weld(weld)
        .drop_duplicates(chosen("params.drop_duplicates", params.drop_duplicates)?)
        .drop_degenerate(chosen("params.drop_degenerate", params.drop_degenerate)?)
        .compact(chosen("params.compact", params.compact)?)
        .cut(chosen("params.cut", params.cut)?)
        .orient(chosen("params.orient", params.orient)?)
        .keep_largest((params.keep_largest > 0).then_some(params.keep_largest))
        .drop_specks((params.drop_specks != 0.0).then_some(params.drop_specks))
        .fill_holes((params.fill_holes > 0).then_some(params.fill_holes)))
}
