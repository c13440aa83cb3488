use std::ffi::c_char;

use super::boundary::{boundary, utf8};
use super::measures::cata_mesh_params;
use super::mesh_file::cata_mesh_file;
use super::params::{Params, flag, with_params};
use super::pointer::{array, hand_over, output, slice};
use super::status::{CATA_ERR_SHAPE, Failure, cata_status};
use catamaran_geometry::mesh::{Lattice, Rim, families, isosurface, label_surface};

/// Makes the surface of the region where values, interpolated between the points of a lattice,
/// exceed `level`: a manifold without attributes.
///
/// - `counts`, `origin`, `step`: 3 elements each, of x, y and z: the number of points, the place of
///   the first one, and the distance from one to the next, positive.
/// - `values`: one for each point, x first, then y, then z; none is NaN.
/// - `open`: 0: the region ends half a step outside of the outermost points, and the surface is
///   closed. 1: the surface is cut at these points.
/// - `file`: one pointer, written.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_mesh_isosurface(
    counts: *const usize,
    origin: *const f64,
    step: *const f64,
    values: *const f32,
    level: f32,
    open: i32,
    params: *const cata_mesh_params,
    file: *mut *mut cata_mesh_file,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`values`, `points` elements; `file`, one value), clause `passed
        // on` (`lattice`).
        let (lattice, values, place) = unsafe {
            let (lattice, points) = lattice(counts, origin, step)?;
            (lattice, slice("values", values, points)?, output("file", file)?)
        };
        let rim = rim(open)?;
        // SAFETY: clause `structs` (`params`).
        let found = unsafe {
            with_params(params, |params, progress| {
                Ok(isosurface(&lattice, values, level, rim, params.par(), progress)?)
            })
        }?;
        hand_over(place, cata_mesh_file { file: found.into() });
        Ok(())
    })
}

/// Makes the surface of the points of a lattice that have a label, as cata_mesh_isosurface does of
/// values, halfway between points with the label and others: `labels`, one for each point.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_mesh_label_surface(
    counts: *const usize,
    origin: *const f64,
    step: *const f64,
    labels: *const u16,
    label: u16,
    open: i32,
    params: *const cata_mesh_params,
    file: *mut *mut cata_mesh_file,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`labels`, `points` elements; `file`, one value), clause `passed
        // on` (`lattice`).
        let (lattice, labels, place) = unsafe {
            let (lattice, points) = lattice(counts, origin, step)?;
            (lattice, slice("labels", labels, points)?, output("file", file)?)
        };
        let rim = rim(open)?;
        // SAFETY: clause `structs` (`params`).
        let found = unsafe {
            with_params(params, |params, progress| {
                Ok(label_surface(&lattice, labels, label, rim, params.par(), progress)?)
            })
        }?;
        hand_over(place, cata_mesh_file { file: found.into() });
        Ok(())
    })
}

/// Generates a mesh by its name, with these counts and sizes:
/// - "icosphere": subdivisions; "figure": cells, and the pose as a size;
/// - "torus": vertices around the axis and the tube, and the two radii; "knot": p, q, vertices
///   along and around, and a radius; "genus": holes and cells;
/// - "grid": columns and rows; "disk": rings and sectors; "cylinder": vertices around and along,
///   and its radius and height; "terrain": columns, rows and a seed.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_mesh_shape(
    name: *const c_char,
    n_counts: usize,
    counts: *const usize,
    n_sizes: usize,
    sizes: *const f64,
    file: *mut *mut cata_mesh_file,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`counts`, `n_counts` elements; `sizes`, `n_sizes` elements;
        // `file`, one value), clause `texts` (`name`).
        let (name, counts, sizes, place) = unsafe {
            let name = utf8("name", name)?;
            let counts = slice("counts", counts, n_counts)?;
            (name, counts, slice("sizes", sizes, n_sizes)?, output("file", file)?)
        };
        let found = families::by_name(&name, counts, sizes)?;
        hand_over(place, cata_mesh_file { file: found.into() });
        Ok(())
    })
}

/// Returns a lattice of the caller, and the number of its points.
///
/// # Safety
/// The elements can be read, and no thread writes them.
unsafe fn lattice(
    counts: *const usize,
    origin: *const f64,
    step: *const f64,
) -> Result<(Lattice, usize), Failure> {
    // SAFETY: clause `memory` (`counts`, `3` elements; `origin`, `3` elements; `step`, `3`
    // elements).
    let lattice = unsafe {
        let (counts, origin) = (array("counts", counts)?, array("origin", origin)?);
        Lattice { counts, origin, step: array("step", step)? }
    };
    let mut counts = lattice.counts.into_iter();
    let points = counts.try_fold(1, |points: usize, count| points.checked_mul(count));
    let points = points.ok_or_else(|| {
        Failure::new(CATA_ERR_SHAPE, "counts: the points exceed the address space")
    })?;
    Ok((lattice, points))
}

fn rim(open: i32) -> Result<Rim, Failure> {
    Ok(if flag("open", open)? { Rim::Open } else { Rim::Closed })
}
