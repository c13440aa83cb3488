//! # Decimation
//!
//! A mesh with a given number of vertices, spread evenly (thesis, chapter 5).

use std::ffi::c_void;
use std::mem::offset_of;

use super::boundary::boundary;
use super::params::{Versioned, flag, init, read};
use super::pointer::{check_size, optional_output, output, slice, slice_mut};
use super::progress::{cata_progress, par, watcher};
use super::status::{CATA_ERR_ARGUMENT, CATA_ERR_SHAPE, Failure, cata_status};
use crate::base::Progress;
use crate::decimate::{DecimateOptions, decimate};
use crate::mesh::TriMesh;

/// How a mesh is decimated.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cata_decimate_params {
    /// sizeof(cata_decimate_params).
    pub struct_size: usize,
    /// Threads, at most; 0: all.
    pub threads: usize,
    /// Told of progress; NULL: nobody.
    pub progress: cata_progress,
    /// Handed to `progress`.
    pub progress_user: *mut c_void,
    /// Passes that move samples to the centroids of their cells, at least 0.
    pub lloyd: i32,
    /// Passes that flip edges and move vertices of the result; 0: the default, 12; -1: none.
    pub relaxation: i32,
    /// With `has_first` 1: the vertex that the first sample is. Else not looked at.
    pub first: u32,
    /// 1: `first` counts; 0: the lowest vertex that a face has.
    pub has_first: i32,
    /// 1: handles too narrow for the triangles of the result are cut, and their ends closed. 0:
    /// they are kept.
    pub cut_narrow_handles: i32,
}

impl Versioned for cata_decimate_params {
    const NAME: &'static str = "cata_decimate_params";
    const FIRST_SIZE: usize = offset_of!(Self, cut_narrow_handles) + size_of::<i32>();
}

/// Fills a struct with the defaults.
///
/// # Safety
/// `params` points to `struct_size` writable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_decimate_params_init(
    params: *mut cata_decimate_params,
    struct_size: usize,
) -> cata_status {
    // SAFETY: the promises are the same.
    unsafe { init(params, struct_size) }
}

/// The number of faces that cata_decimate never exceeds for a result of `n` vertices of a mesh of
/// `n_faces` faces, whatever its topology: 2 n + n_faces; SIZE_MAX where that overflows.
#[unsafe(no_mangle)]
pub extern "C" fn cata_decimate_faces_bound(n: usize, n_faces: usize) -> usize {
    n.saturating_mul(2).saturating_add(n_faces)
}

/// Decimates a triangle mesh to exactly n vertices, uniformly: a manifold with the components,
/// boundary loops and genus of the input. The input is cut along edges of more than two faces
/// first, and edges longer than those of the result will be are split, so that n may also be more
/// than the input has. No step makes faces intersect that did not. What can't be is refused, and
/// the message says why.
///
/// - `vertices`: 3 n_vertices elements, read: x, y, z of each vertex, finite.
/// - `faces`: 3 n_faces elements, read: the vertices of each face, from 0, counter-clockwise as
///   seen from outside.
/// - `n`: vertices of the result.
/// - `new_vertices`: 3 n elements, written.
/// - `new_faces`: 3 faces_capacity elements, the first 3 `*n_new_faces` written.
/// - `faces_capacity`: cata_decimate_faces_bound(n, n_faces) is always enough; with too few,
///   CATA_ERR_SHAPE, and the message tells how many it takes.
/// - `n_new_faces`: one element, written: the number of faces of the result.
/// - `cells`: n_vertices elements, written: for each vertex of the input the nearest one of the
///   result along edges, UINT32_MAX for those that no face has; NULL where not wanted.
/// - `changed`: one element, written: 1 when the input had to be repaired (repeated faces and
///   vertices without a face left out, faces flipped, the mesh cut), 0 else; NULL where not
///   wanted.
///
/// Returns CATA_ERR_ARGUMENT also for an n that is fewer than the topology needs.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_decimate(
    n_vertices: usize,
    vertices: *const f64,
    n_faces: usize,
    faces: *const u32,
    n: usize,
    new_vertices: *mut f64,
    new_faces: *mut u32,
    faces_capacity: usize,
    n_new_faces: *mut usize,
    cells: *mut u32,
    changed: *mut i32,
    params: *const cata_decimate_params,
) -> cata_status {
    boundary(|| {
        check_size::<f64>("vertices", n_vertices, 3)?;
        check_size::<u32>("faces", n_faces, 3)?;
        check_size::<f64>("new_vertices", n, 3)?;
        check_size::<u32>("new_faces", faces_capacity, 3)?;
        // SAFETY: the caller's promise.
        let (vertices, faces, outputs) = unsafe {
            let cells = match cells.is_null() {
                true => None,
                false => Some(slice_mut("cells", cells, n_vertices)?),
            };
            let outputs = Outputs {
                vertices: slice_mut("new_vertices", new_vertices, 3 * n)?,
                faces: slice_mut("new_faces", new_faces, 3 * faces_capacity)?,
                face_count: output("n_new_faces", n_new_faces)?,
                cells,
                changed: optional_output("changed", changed)?,
            };
            (
                slice("vertices", vertices, 3 * n_vertices)?,
                slice("faces", faces, 3 * n_faces)?,
                outputs,
            )
        };
        let mesh =
            TriMesh::new(vertices.as_chunks::<3>().0.to_vec(), faces.as_chunks::<3>().0.to_vec())?;
        // SAFETY: the caller's promise.
        unsafe { decimated(&mesh, n, outputs, params) }
    })
}

/// Where results go.
struct Outputs<'a> {
    vertices: &'a mut [f64],
    faces: &'a mut [u32],
    face_count: &'a mut usize,
    cells: Option<&'a mut [u32]>,
    changed: Option<&'a mut i32>,
}

/// Computes and writes the mesh.
///
/// # Safety
/// `params` is NULL or points to a struct as the header describes it.
unsafe fn decimated(
    mesh: &TriMesh,
    n: usize,
    outputs: Outputs<'_>,
    params: *const cata_decimate_params,
) -> Result<(), Failure> {
    let mut options = DecimateOptions::default();
    let mut watch = None;
    if !params.is_null() {
        // SAFETY: the caller's promise.
        let params = unsafe { read(params) }?;
        options.par = par(params.threads);
        options.lloyd = passes("params.lloyd", params.lloyd, options.lloyd)?;
        options.cut_narrow_handles = flag("params.cut_narrow_handles", params.cut_narrow_handles)?;
        options.relaxation = passes("params.relaxation", params.relaxation, options.relaxation)?;
        options.first = flag("params.has_first", params.has_first)?.then_some(params.first);
        watch = watcher(params.progress, params.progress_user);
    }
    options.progress = watch.as_ref().map_or(Progress::none(), Progress::from);
    let found = decimate(mesh, n, &options)?;
    let (vertices, faces) = (found.mesh.vertices(), found.mesh.faces().as_flattened());
    let Some(place) = outputs.faces.get_mut(..faces.len()) else {
        let (needed, given) = (faces.len() / 3, outputs.faces.len() / 3);
        let message = format!("new_faces: {needed} faces, but faces_capacity is {given}");
        return Err(Failure::new(CATA_ERR_SHAPE, message));
    };
    place.copy_from_slice(faces);
    outputs.vertices.copy_from_slice(vertices.as_flattened());
    *outputs.face_count = faces.len() / 3;
    if let Some(cells) = outputs.cells {
        cells.copy_from_slice(found.cells.of_vertices());
    }
    if let Some(changed) = outputs.changed {
        *changed = i32::from(found.repairs != Default::default());
    }
    Ok(())
}

/// 0 for the default, -1 for none.
fn passes(what: &str, value: i32, default: usize) -> Result<usize, Failure> {
    match value {
        0 => Ok(default),
        -1 => Ok(0),
        _ => usize::try_from(value).map_err(|_| {
            let message = format!("{what}: {value}, where -1, 0 or a positive number is needed");
            Failure::new(CATA_ERR_ARGUMENT, message)
        }),
    }
}
