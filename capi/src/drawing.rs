use super::boundary::boundary;
use super::curve::{cata_curve_params, options, outcome_value};
use super::outputs::{copy_wanted, element, fill_room, fill_slice, tell};
use super::params::{Params, flag, read_or_zeros};
use super::pointer::{
    free, hand_over, known, known_mut, mask, mesh, optional_output, optional_slice_mut, output,
    put, slice, slice_mut,
};
use super::status::{CATA_ERR_ARGUMENT, Failure, cata_status};
use catamaran_geometry::curve::{Drawing, Drawn};

/// Layers of curves on one mesh: those of one layer do not meet, those of several may cross. Made
/// by cata_drawing_new.
pub struct cata_drawing {
    drawing: Drawing,
    /// Number of faces of the mesh.
    n_faces: usize,
}

/// A mesh with the curves of a drawing along its edges. Made by cata_drawing_inscribe; constant.
pub struct cata_drawn {
    drawn: Drawn,
    /// Number of faces of the mesh of the drawing.
    n_faces: usize,
}

/// Creates a drawing without curves on a mesh, of which it keeps a copy.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_drawing_new(
    n_vertices: usize,
    vertices: *const f64,
    n_faces: usize,
    faces: *const u32,
    drawing: *mut *mut cata_drawing,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (the mesh, 3 numbers a vertex and 3 indices a face; `drawing`,
        // one value).
        let (mesh, place) =
            unsafe { (mesh(n_vertices, vertices, n_faces, faces)?, output("drawing", drawing)?) };
        let drawing = Drawing::new(mesh)?;
        hand_over(place, cata_drawing { drawing, n_faces });
        Ok(())
    })
}

/// Frees a drawing; a cata_drawn of it stays valid.
///
/// # Safety
/// The pointer is as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_drawing_free(drawing: *mut cata_drawing) {
    // SAFETY: clause `handles` (`drawing`).
    unsafe { free(drawing) };
}

/// Finds the curves through samples, as cata_curve_solver_find does, and adds them as a layer.
///
/// - `count`, `samples`: vertices of the mesh, at least 3, none twice.
/// - `outcome`: written: CATA_CURVE_*. NULL where not wanted.
/// - `params`: `smooth` must be 0: cata_drawing_inscribe shortens all curves.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_drawing_add(
    drawing: *mut cata_drawing,
    count: usize,
    samples: *const u32,
    outcome: *mut i32,
    params: *const cata_curve_params,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`samples`, `count` elements; `outcome`, one value), clause
        // `handles` (`drawing`), clause `structs` (`params`).
        let (own, samples, outcome, params) = unsafe {
            (
                known_mut("drawing", drawing)?,
                slice("samples", samples, count)?,
                optional_output("outcome", outcome)?,
                read_or_zeros("params", params)?,
            )
        };
        let options = options(&params)?;
        if flag("params.smooth", params.smooth)? {
            let why = "params.smooth: must be 0: cata_drawing_inscribe shortens all curves";
            return Err(Failure::new(CATA_ERR_ARGUMENT, why));
        }
        let drawing = &mut own.drawing;
        let found = params.caller().watch(|progress| {
            drawing.add(samples, &options.progress(progress)).map(|layer| layer.outcome)
        })?;
        put(outcome, outcome_value(found));
        Ok(())
    })
}

/// Makes a mesh of the same surface with the curves of all layers along its edges: vertices where
/// curves cross edges and each other follow those of the mesh.
///
/// - `smooth`: 1: all curves are shortened to geodesics between their samples first; no layer can
///   be added after that. 0: they are along edges.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_drawing_inscribe(
    drawing: *mut cata_drawing,
    smooth: i32,
    drawn: *mut *mut cata_drawn,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`drawn`, one value), clause `handles` (`drawing`).
        let (own, place) = unsafe { (known_mut("drawing", drawing)?, output("drawn", drawn)?) };
        if flag("smooth", smooth)? {
            own.drawing.smooth()?;
        }
        let drawn = own.drawing.inscribe()?;
        hand_over(place, cata_drawn { drawn, n_faces: own.n_faces });
        Ok(())
    })
}

/// Gets the numbers of vertices and faces of the mesh, and of layers. NULL where not wanted.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_drawn_size(
    drawn: *const cata_drawn,
    n_vertices: *mut usize,
    n_faces: *mut usize,
    layers: *mut usize,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`n_vertices`, `n_faces`, `layers`, one value each), clause
        // `handles` (`drawn`).
        unsafe {
            let found = &known("drawn", drawn)?.drawn;
            let mesh = &found.refined.mesh;
            tell! {
                n_vertices: mesh.vertices().len(),
                n_faces: mesh.faces().len(),
                layers: found.layers.len(),
            }
        }
        Ok(())
    })
}

/// Gets the mesh, and where it lies on that of the drawing; NULL where not wanted.
///
/// - `vertices`, `faces`: as many as cata_drawn_size tells, written.
/// - `of_faces`: for each face the one of the drawing's mesh that contains it, written.
/// - `corners`, `weights`: for each vertex 3 vertices of a face of the drawing's mesh and their
///   weights, whose mean it is, written.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_drawn_get(
    drawn: *const cata_drawn,
    vertices: *mut f64,
    faces: *mut u32,
    of_faces: *mut u32,
    corners: *mut u32,
    weights: *mut f64,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`vertices`, `corners`, `weights`, 3 elements a vertex; `faces`,
        // 3 a face; `of_faces`, one), clause `handles` (`drawn`).
        unsafe {
            let found = &known("drawn", drawn)?.drawn.refined;
            let origins = &found.vertices;
            let around: Vec<[u32; 3]> = origins.iter().map(|origin| origin.vertices).collect();
            let shares: Vec<[f64; 3]> = origins.iter().map(|origin| origin.weights).collect();
            copy_wanted! {
                vertices: found.mesh.vertices().as_flattened(),
                faces: found.mesh.faces().as_flattened(),
                of_faces: &found.faces,
                corners: around.as_flattened(),
                weights: shares.as_flattened(),
            }
        }
        Ok(())
    })
}

/// Gets the edges of the curves of a layer, from 0, for cata_region_enclosed and cata_region_cut.
///
/// - `room`: the number of edges that `along` has room for; CATA_ERR_SHAPE where there are more.
/// - `along`: 2 vertices for each edge, written. NULL where not wanted.
/// - `count`: written: the number of edges.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_drawn_edges(
    drawn: *const cata_drawn,
    layer: usize,
    room: usize,
    along: *mut u32,
    count: *mut usize,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`along`, `2 * room` elements; `count`, one value), clause
        // `handles` (`drawn`).
        let (found, along, count) = unsafe {
            (
                &known("drawn", drawn)?.drawn,
                optional_slice_mut("along", along.cast::<[u32; 2]>(), room)?,
                output("count", count)?,
            )
        };
        let curves = element("layer", &found.layers, "layers", layer)?;
        let edges: Vec<[u32; 2]> = curves.iter().flat_map(|curve| curve.edges()).collect();
        fill_room("edges", along, &edges)?;
        *count = edges.len();
        Ok(())
    })
}

/// Computes the share of each face of the drawing's mesh that a region of the mesh of `drawn`
/// covers.
///
/// - `inside`: one element for each face of the mesh of `drawn`: 1 inside of the region, 0 outside.
/// - `shares`: one element for each face of the drawing's mesh, written: exactly 0 or 1 where none
///   or all of it is inside.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_drawn_shares(
    drawn: *const cata_drawn,
    inside: *const u8,
    shares: *mut f64,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`inside`, `found.faces.len()` elements; `shares`, `own.n_faces`
        // elements), clause `handles` (`drawn`).
        let (found, inside, shares) = unsafe {
            let own = known("drawn", drawn)?;
            let found = &own.drawn.refined;
            let inside = mask("inside", inside, found.faces.len())?;
            (found, inside, slice_mut("shares", shares, own.n_faces)?)
        };
        fill_slice(Some(shares), &found.shares(&inside)?);
        Ok(())
    })
}

/// Frees a mesh with curves.
///
/// # Safety
/// The pointer is as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_drawn_free(drawn: *mut cata_drawn) {
    // SAFETY: clause `handles` (`drawn`).
    unsafe { free(drawn) };
}
