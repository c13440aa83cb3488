//! # Curves
//!
//! Curves on a mesh through samples of them, in an order that is found (thesis, chapter 6).

use std::ffi::c_void;
use std::mem::offset_of;

use super::boundary::boundary;
use super::params::{Versioned, flag, init, read};
use super::pointer::{mesh, optional_output, output, slice, slice_mut};
use super::progress::{cata_progress, watcher};
use super::status::{CATA_ERR_ARGUMENT, Failure, cata_status};
use crate::base::Progress;
use crate::curve::{Count, CurveOptions, CurveSolver, Mode, Outcome, Reconstruction};

/// The curve is closed, or all curves are.
pub const CATA_CURVE_CLOSED: i32 = 0;
/// The curve is open, as was asked for.
pub const CATA_CURVE_OPEN: i32 = 1;
/// From a sample no way led on.
pub const CATA_CURVE_BLOCKED: i32 = 2;
/// All samples are connected, but no way led back to the first one.
pub const CATA_CURVE_CLOSE_BLOCKED: i32 = 3;
/// Samples are on different components of the mesh.
pub const CATA_CURVE_DISCONNECTED: i32 = 4;

/// How curves are found.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cata_curve_params {
    /// sizeof(cata_curve_params).
    pub struct_size: usize,
    /// With `faithful` 1: among how many of the nearest samples the next one is chosen; 0: 5.
    pub candidates: usize,
    /// With `faithful` 1: the number of the sample that the curve starts at.
    pub start: usize,
    /// Told of progress; NULL: nobody.
    pub progress: cata_progress,
    /// Handed to `progress`.
    pub progress_user: *mut c_void,
    /// 1: algorithm 6.1 of the thesis, from sample to sample. 0: the order first, then paths that
    /// do not meet.
    pub faithful: i32,
    /// 1: an open curve; 0: closed.
    pub open: i32,
    /// 1: one curve, even where there are gaps as between several; 0: as many as there are gaps
    /// for.
    pub single: i32,
    /// 1: vertices of the mesh alone; 0: points in the middle of edges are added where there is
    /// no other way.
    pub no_steiner: i32,
}

impl Versioned for cata_curve_params {
    const NAME: &'static str = "cata_curve_params";
    const FIRST_SIZE: usize = offset_of!(Self, no_steiner) + size_of::<i32>();
}

/// Curves that were found. Made by cata_curves_new; for one thread at a time unless it is only
/// read.
pub struct cata_curves {
    found: Reconstruction,
}

/// Fills a struct with the defaults.
///
/// # Safety
/// `params` points to `struct_size` writable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_curve_params_init(
    params: *mut cata_curve_params,
    struct_size: usize,
) -> cata_status {
    // SAFETY: the promises are the same.
    unsafe { init(params, struct_size) }
}

/// The curve on a triangle mesh, along its edges, that samples without an order are of.
///
/// - `positions`: 3 `vertices` elements, read: x, y, z of each vertex.
/// - `triangles`: 3 `faces` elements, read: three vertices of each face, from 0.
/// - `samples`: `sample_count` elements, read: vertices, at least 3, none twice.
/// - `curves`: one pointer, not NULL, written: the result, to be given to cata_curves_free.
///
/// Returns CATA_OK also when there is no complete curve, as cata_curves_outcome then says.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_curves_new(
    n_vertices: usize,
    vertices: *const f64,
    n_faces: usize,
    faces: *const u32,
    sample_count: usize,
    samples: *const u32,
    params: *const cata_curve_params,
    curves: *mut *mut cata_curves,
) -> cata_status {
    boundary(|| {
        // SAFETY: the caller's promise.
        let (mesh, samples, curves) = unsafe {
            (
                mesh(n_vertices, vertices, n_faces, faces)?,
                slice("samples", samples, sample_count)?,
                output("curves", curves)?,
            )
        };
        let mut options = CurveOptions::default();
        let mut watch = None;
        if !params.is_null() {
            // SAFETY: the caller's promise.
            let params = unsafe { read(params) }?;
            if flag("params.faithful", params.faithful)? {
                options.mode = Mode::Faithful;
            }
            if flag("params.single", params.single)? {
                options.count = Count::One;
            }
            options.open = flag("params.open", params.open)?;
            options.steiner = !flag("params.no_steiner", params.no_steiner)?;
            options.start = params.start;
            if params.candidates > 0 {
                options.candidates = params.candidates;
            }
            watch = watcher(params.progress, params.progress_user);
        }
        options.progress = watch.as_ref().map_or(Progress::none(), Progress::from);
        let found = CurveSolver::new(&mesh)?.reconstruct(samples, &options)?;
        *curves = Box::into_raw(Box::new(cata_curves { found }));
        Ok(())
    })
}

/// Gives curves back.
///
/// `curves`: from cata_curves_new, not used any more afterwards; NULL is ignored.
///
/// # Safety
/// `curves` is NULL or from cata_curves_new, and was not given back before.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_curves_free(curves: *mut cata_curves) {
    if !curves.is_null() {
        // SAFETY: from Box::into_raw, and the caller's promise.
        drop(unsafe { Box::from_raw(curves) });
    }
}

/// How a reconstruction ended.
///
/// - `curves`: from cata_curves_new, not NULL.
/// - `outcome`: one element, written: CATA_CURVE_CLOSED, CATA_CURVE_OPEN, CATA_CURVE_BLOCKED,
///   CATA_CURVE_CLOSE_BLOCKED or CATA_CURVE_DISCONNECTED. NULL where not wanted.
/// - `count`: one element, written: the number of curves, or of what there is of them. NULL where
///   not wanted.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_curves_outcome(
    curves: *const cata_curves,
    outcome: *mut i32,
    count: *mut usize,
) -> cata_status {
    boundary(|| {
        // SAFETY: the caller's promise.
        let (found, outcome, count) = unsafe {
            (
                &known(curves)?.found,
                optional_output("outcome", outcome)?,
                optional_output("count", count)?,
            )
        };
        if let Some(outcome) = outcome {
            *outcome = match found.outcome {
                Outcome::Closed => CATA_CURVE_CLOSED,
                Outcome::Open => CATA_CURVE_OPEN,
                Outcome::Blocked { .. } => CATA_CURVE_BLOCKED,
                Outcome::CloseBlocked => CATA_CURVE_CLOSE_BLOCKED,
                Outcome::Disconnected { .. } => CATA_CURVE_DISCONNECTED,
            };
        }
        if let Some(count) = count {
            *count = found.curves.len();
        }
        Ok(())
    })
}

/// How large a curve is.
///
/// - `curves`: from cata_curves_new, not NULL.
/// - `curve`: its number, from 0.
/// - `sample_count`, `vertex_count`: one element each, written: samples in its order, and
///   vertices on its path. NULL where not wanted.
/// - `length`: one element, written: the sum of the lengths of its edges. NULL where not wanted.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_curves_size(
    curves: *const cata_curves,
    curve: usize,
    sample_count: *mut usize,
    vertex_count: *mut usize,
    length: *mut f64,
) -> cata_status {
    boundary(|| {
        // SAFETY: the caller's promise.
        let (curve, sample_count, vertex_count, length) = unsafe {
            (
                one(known(curves)?, curve)?,
                optional_output("sample_count", sample_count)?,
                optional_output("vertex_count", vertex_count)?,
                optional_output("length", length)?,
            )
        };
        if let Some(sample_count) = sample_count {
            *sample_count = curve.order.len();
        }
        if let Some(vertex_count) = vertex_count {
            *vertex_count = curve.path.len();
        }
        if let Some(length) = length {
            *length = curve.length;
        }
        Ok(())
    })
}

/// A curve.
///
/// - `curves`: from cata_curves_new, not NULL.
/// - `curve`: its number, from 0.
/// - `order`: as many elements as it has samples, written: numbers of samples in its order. NULL
///   where not wanted.
/// - `path`: as many elements as it has vertices, written: the vertices, the first one not
///   repeated at the end; those from the number of vertices of the mesh on are points that were
///   added. NULL where not wanted.
/// - `points`: three times as many elements, written: x, y, z of the vertices. NULL where not
///   wanted.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_curves_get(
    curves: *const cata_curves,
    curve: usize,
    order: *mut u32,
    path: *mut u32,
    points: *mut f64,
) -> cata_status {
    boundary(|| {
        // SAFETY: the caller's promise.
        unsafe {
            let curve = one(known(curves)?, curve)?;
            if !order.is_null() {
                slice_mut("order", order, curve.order.len())?.copy_from_slice(&curve.order);
            }
            if !path.is_null() {
                slice_mut("path", path, curve.path.len())?.copy_from_slice(&curve.path);
            }
            if !points.is_null() {
                let points = slice_mut("points", points, 3 * curve.points.len())?;
                points.copy_from_slice(curve.points.as_flattened());
            }
        }
        Ok(())
    })
}

/// The handle, which must not be NULL.
///
/// # Safety
/// `curves` is NULL or from cata_curves_new, and not given back while the reference lives.
unsafe fn known<'a>(curves: *const cata_curves) -> Result<&'a cata_curves, Failure> {
    // SAFETY: the caller's promise.
    unsafe { curves.as_ref() }.ok_or_else(|| Failure::null("curves"))
}

fn one(curves: &cata_curves, curve: usize) -> Result<&crate::curve::Curve, Failure> {
    let all = &curves.found.curves;
    all.get(curve).ok_or_else(|| {
        let why = format!("curve: {curve} of {} (numbered from 0)", all.len());
        Failure::new(CATA_ERR_ARGUMENT, why)
    })
}
