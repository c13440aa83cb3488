//! # Curves
//!
//! Closed or open curves along the edges of a mesh through samples of them, whose order is found
//! (thesis, chapter 6): a solver for each mesh, for many curves.
//!
//! ```c
//! double v[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, .5, .5, 0}, length;
//! uint32_t f[] = {0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4}, samples[] = {0, 2, 1, 3};
//! cata_curve_solver *solver;
//! cata_curves *curves;
//! cata_curve_solver_new(5, v, 4, f, &solver);
//! cata_curve_solver_find(solver, 4, samples, NULL, &curves);
//! cata_curves_size(curves, 0, NULL, NULL, NULL, &length);
//! printf("%g\n", length); // 4
//! cata_curves_free(curves);
//! cata_curve_solver_free(solver);
//! ```

use std::ffi::c_void;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};

use super::boundary::boundary;
use super::outputs::{copy, copy_wanted, element, tell};
use super::params::{flag, init, or_default, params, with_params};
use super::pointer::{
    free, hand_over, known, known_mut, mesh, optional_output, output, put, slice, slice_mut,
};
use super::progress::cata_progress;
use super::status::{CATA_ERR_ARGUMENT, Failure, cata_status};
use catamaran::base::{Error, Progress};
use catamaran_geometry::curve::{
    Count, Curve, CurveOptions, CurveSolver, Mode, Outcome, Placement, Reconstruction, Site, place,
    places, with_steiner,
};
use catamaran_geometry::mesh::{Refined, SurfacePoint, TriMesh};

/// `outcome`: the curve is closed, or all curves are.
pub const CATA_CURVE_CLOSED: i32 = 0;
/// `outcome`: the curve is open, as requested.
pub const CATA_CURVE_OPEN: i32 = 1;
/// `outcome`: no path leaves one of the samples.
pub const CATA_CURVE_BLOCKED: i32 = 2;
/// `outcome`: no path leads back to the first sample.
pub const CATA_CURVE_CLOSE_BLOCKED: i32 = 3;
/// `outcome`: samples are on several components.
pub const CATA_CURVE_DISCONNECTED: i32 = 4;

/// `points`: vertices, and new ones on edges where needed.
pub const CATA_CURVE_STEINER: i32 = 0;
/// `points`: vertices of the mesh alone.
pub const CATA_CURVE_VERTICES: i32 = 1;

/// Instead of a face: the place is a point in space.
pub const CATA_IN_SPACE: u32 = u32::MAX;

/// How curves are found. They are found on the calling thread.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cata_curve_params {
    /// sizeof(cata_curve_params).
    pub struct_size: usize,
    /// Ignored.
    pub threads: usize,
    /// Progress callback; NULL: none.
    pub progress: cata_progress,
    /// Passed to `progress`.
    pub progress_user: *mut c_void,
    /// With `faithful` 1: among how many of the nearest samples the next one is chosen; 0: 5.
    pub candidates: usize,
    /// With `faithful` 1: the number of the sample that the curve starts at.
    pub start: usize,
    /// 1: algorithm 6.1 of the thesis, from sample to sample. 0: the order first, then paths
    /// that do not meet.
    pub faithful: i32,
    /// 1: an open curve; 0: closed.
    pub open: i32,
    /// 1: one curve, even where there are gaps as between several; 0: as many as there are gaps
    /// for.
    pub single: i32,
    /// CATA_CURVE_STEINER or CATA_CURVE_VERTICES.
    pub points: i32,
    /// 1: curves are shortened to geodesics between their samples. 0: they are along edges.
    pub smooth: i32,
    /// 0.
    pub reserved: i32,
    /// 1: outliers are dropped: one or two successive samples to which the curve makes a detour
    /// of more than three times the median distance between successive samples (at the ends of an
    /// open curve, six times). At least half of the samples stay. Not with `faithful` 1.
    pub drop_outliers: i32,
}

params!(cata_curve_params, smooth: i32);

/// A mesh, prepared for the search for curves. Made by cata_curve_solver_new.
pub struct cata_curve_solver {
    solver: CurveSolver<'static>,
    /// The mesh of the caller and its refinement to the mesh of the solver, if places cut it.
    input: Option<(TriMesh, Refined)>,
    /// A number that no other solver of the process has.
    number: u64,
}

impl cata_curve_solver {
    fn new(mesh: TriMesh, input: Option<(TriMesh, Refined)>) -> Result<Self, Error> {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        Ok(Self { solver: CurveSolver::owning(mesh)?, input, number })
    }

    /// Returns where the points of all curves are on the mesh of the caller.
    fn places(&self, found: &Reconstruction) -> Result<Vec<Vec<SurfacePoint>>, Error> {
        let finer = with_steiner(self.solver.mesh(), &found.steiner)?;
        match &self.input {
            Some((mesh, refined)) => places(&found.curves, &refined.then(finer), mesh),
            None => places(&found.curves, &finer, self.solver.mesh()),
        }
    }
}

/// Curves that were found. Made by cata_curve_solver_find; constant.
pub struct cata_curves {
    found: Reconstruction,
    /// The number of the solver that found them.
    solver: u64,
    /// The points of all curves on the mesh of the caller, once asked for.
    places: OnceLock<Vec<Vec<SurfacePoint>>>,
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
    // SAFETY: clause `structs` (`params`).
    unsafe { init(params, struct_size) }
}

/// Creates a solver for a mesh of any kind, of which it keeps a copy.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_curve_solver_new(
    n_vertices: usize,
    vertices: *const f64,
    n_faces: usize,
    faces: *const u32,
    solver: *mut *mut cata_curve_solver,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (the mesh, 3 numbers a vertex and 3 indices a face; `solver`, one
        // value).
        let (mesh, place) =
            unsafe { (mesh(n_vertices, vertices, n_faces, faces)?, output("solver", solver)?) };
        hand_over(place, cata_curve_solver::new(mesh, None)?);
        Ok(())
    })
}

/// Creates a solver as cata_curve_solver_new, for samples that need not be vertices: those inside
/// of faces become vertices, numbered from n_vertices on, which cut their faces.
///
/// - `count`: number of places.
/// - `places`: `count` elements, read: the face of each, or CATA_IN_SPACE: the nearest vertex.
/// - `weights`: 3 `count` elements, read: barycentric coordinates in the face, or x, y, z.
/// - `samples`: `count` elements, written: the vertices that stand for the places.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_curve_solver_new_at(
    n_vertices: usize,
    vertices: *const f64,
    n_faces: usize,
    faces: *const u32,
    count: usize,
    places: *const u32,
    weights: *const f64,
    samples: *mut u32,
    solver: *mut *mut cata_curve_solver,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (the mesh, 3 numbers a vertex and 3 indices a face; `places`,
        // `count` elements; `weights`, `3 * count` elements; `samples`, `count` elements; `solver`,
        // one value).
        let (mesh, places, weights, samples, to) = unsafe {
            (
                mesh(n_vertices, vertices, n_faces, faces)?,
                slice("places", places, count)?,
                slice("weights", weights.cast::<[f64; 3]>(), count)?,
                slice_mut("samples", samples, count)?,
                output("solver", solver)?,
            )
        };
        let sites: Vec<Site> = places
            .iter()
            .zip(weights)
            .map(|(&face, &weights)| match face {
                CATA_IN_SPACE => Site::Near(weights),
                face => Site::Face(SurfacePoint { face, weights }),
            })
            .collect();
        let placed = place(&mesh, &sites, Placement::Insert).map_err(|error| match error {
            Error::Argument { what: "sites", why } => Error::Argument { what: "places", why },
            error => error,
        })?;
        let solver = match placed.mesh {
            Some(refined) => cata_curve_solver::new(refined.mesh.clone(), Some((mesh, refined)))?,
            None => cata_curve_solver::new(mesh, None)?,
        };
        samples.copy_from_slice(&placed.vertices);
        hand_over(to, solver);
        Ok(())
    })
}

/// Frees a solver.
///
/// # Safety
/// The pointer is as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_curve_solver_free(solver: *mut cata_curve_solver) {
    // SAFETY: clause `handles` (`solver`).
    unsafe { free(solver) };
}

/// Finds the curves through unordered samples; they meet neither themselves nor each other. The
/// same samples give the same curves, bit for bit. CATA_OK also when there is no complete curve:
/// see cata_curves_outcome.
///
/// - `samples`: `count` elements, read: vertices, at least 3, none twice.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_curve_solver_find(
    solver: *mut cata_curve_solver,
    count: usize,
    samples: *const u32,
    params: *const cata_curve_params,
    curves: *mut *mut cata_curves,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`samples`, `count` elements; `curves`, one value), clause
        // `handles` (`solver`).
        let (own, samples, curves) = unsafe {
            let own = known_mut("solver", solver)?;
            (own, slice("samples", samples, count)?, output("curves", curves)?)
        };
        let (solver, number) = (&mut own.solver, own.number);
        let work = |params: &cata_curve_params, progress: Progress<'_>| {
            let smooth = flag("params.smooth", params.smooth)?;
            let mut found = solver.reconstruct(samples, &options(params)?.progress(progress))?;
            if smooth {
                found.smooth(solver.mesh(), samples)?;
            }
            Ok(found)
        };
        // SAFETY: clause `structs` (`params`).
        let found = unsafe { with_params(params, work) }?;
        hand_over(curves, cata_curves { found, solver: number, places: OnceLock::new() });
        Ok(())
    })
}

/// Returns the options of the caller.
pub(super) fn options(params: &cata_curve_params) -> Result<CurveOptions<'static>, Failure> {
    let default = CurveOptions::default();
    Ok(CurveOptions::new()
        .mode(if flag("params.faithful", params.faithful)? { Mode::Faithful } else { default.mode })
        .count(if flag("params.single", params.single)? { Count::One } else { default.count })
        .open(flag("params.open", params.open)?)
        .steiner(match params.points {
            CATA_CURVE_STEINER => true,
            CATA_CURVE_VERTICES => false,
            other => {
                let any = "CATA_CURVE_STEINER or CATA_CURVE_VERTICES";
                return Err(Failure::argument("params.points", any, other));
            }
        })
        .drop_outliers(flag("params.drop_outliers", params.drop_outliers)?)
        .start(params.start)
        .candidates(or_default(params.candidates, default.candidates)))
}

/// Frees curves.
///
/// # Safety
/// The pointer is as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_curves_free(curves: *mut cata_curves) {
    // SAFETY: clause `handles` (`curves`).
    unsafe { free(curves) };
}

/// Gets how the search ended, CATA_CURVE_*; the number of curves; and the number of samples that no
/// curve is through, because their components of the mesh have fewer than three. NULL where not
/// wanted.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_curves_outcome(
    curves: *const cata_curves,
    outcome: *mut i32,
    count: *mut usize,
    left_out: *mut usize,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`outcome`, one value; `count`, one value; `left_out`, one
        // value), clause `handles` (`curves`).
        unsafe {
            let found = &known("curves", curves)?.found;
            tell! {
                outcome: outcome_value(found.outcome),
                count: found.curves.len(),
                left_out: found.left_out.len(),
            }
        }
        Ok(())
    })
}

/// Gets the numbers of samples, of vertices and of points of a curve, from 0, and its length. NULL
/// where not wanted.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_curves_size(
    curves: *const cata_curves,
    curve: usize,
    n_samples: *mut usize,
    n_vertices: *mut usize,
    n_points: *mut usize,
    length: *mut f64,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`n_samples`, one value; `n_vertices`, one value; `n_points`, one
        // value; `length`, one value), clause `handles` (`curves`).
        unsafe {
            let curve = one(known("curves", curves)?, curve)?;
            tell! {
                n_samples: curve.order.len(),
                n_vertices: curve.path.len(),
                n_points: curve.points.len(),
                length: curve.length,
            }
        }
        Ok(())
    })
}

/// Gets a curve; NULL where not wanted.
///
/// - `order`: n_samples elements, written: numbers of samples in the order of the curve.
/// - `path`: n_vertices elements, written: its vertices, the first one not repeated; those from
///   the number of vertices of the mesh on were added.
/// - `points`: 3 n_points elements, written: where the curve goes, those of `path` unless it is
///   smooth.
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
        // SAFETY: clause `memory` (`order`, `curve.order.len()` elements; `path`,
        // `curve.path.len()` elements; `points`, `3 * curve.points.len()` elements), clause
        // `handles` (`curves`).
        unsafe {
            let curve = one(known("curves", curves)?, curve)?;
            copy_wanted! {
                order: &curve.order,
                path: &curve.path,
                points: curve.points.as_flattened(),
            }
        }
        Ok(())
    })
}

/// Gets where the points of a curve are on the mesh of `solver`, which found the curves. NULL
/// where not wanted. The first call takes time in proportion to the size of the mesh.
///
/// - `faces`: n_points elements, written: a face of the mesh, as it was given, for each point.
/// - `weights`: 3 n_points elements, written: barycentric coordinates in that face.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_curves_places(
    curves: *const cata_curves,
    solver: *const cata_curve_solver,
    curve: usize,
    faces: *mut u32,
    weights: *mut f64,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`faces`, one element for each point of the curve; `weights`,
        // three), clause `handles` (`curves`, `solver`).
        unsafe {
            let (curves, solver) = (known("curves", curves)?, known("solver", solver)?);
            if curves.solver != solver.number {
                let why = "solver: must be the one that found the curves";
                return Err(Failure::new(CATA_ERR_ARGUMENT, why));
            }
            let places = match curves.places.get() {
                Some(places) => places,
                None => {
                    let found = solver.places(&curves.found)?;
                    curves.places.get_or_init(|| found)
                }
            };
            let places = element("curve", places, "curves", curve)?;
            let of: Vec<u32> = places.iter().map(|place| place.face).collect();
            let shares: Vec<[f64; 3]> = places.iter().map(|place| place.weights).collect();
            copy_wanted! {
                faces: &of,
                weights: shares.as_flattened(),
            }
        }
        Ok(())
    })
}

/// Gets how many samples were dropped as outliers, and which, ascending. NULL where not wanted.
///
/// - `samples`: as many elements as `count` tells, written.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_curves_outliers(
    curves: *const cata_curves,
    count: *mut usize,
    samples: *mut u32,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`count`, one value; `samples`, one element for each), clause
        // `handles` (`curves`).
        unsafe {
            let outliers = &known("curves", curves)?.found.outliers;
            let count = optional_output("count", count)?;
            copy_wanted! {
                samples: outliers,
            }
            put(count, outliers.len());
        }
        Ok(())
    })
}

/// Gets the numbers of samples that no curve is through: components with fewer than three.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_curves_left_out(
    curves: *const cata_curves,
    samples: *mut u32,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`samples`, one element for each), clause `handles` (`curves`).
        unsafe { copy("samples", samples, &known("curves", curves)?.found.left_out) }
    })
}

/// Returns the constant that stands for an outcome.
pub(super) fn outcome_value(outcome: Outcome) -> i32 {
    match outcome {
        Outcome::Closed => CATA_CURVE_CLOSED,
        Outcome::Open => CATA_CURVE_OPEN,
        Outcome::Blocked { .. } => CATA_CURVE_BLOCKED,
        Outcome::CloseBlocked => CATA_CURVE_CLOSE_BLOCKED,
        Outcome::Disconnected { .. } => CATA_CURVE_DISCONNECTED,
        _ => unreachable!("an outcome without a value of its own: {outcome:?}"),
    }
}

fn one(curves: &cata_curves, curve: usize) -> Result<&Curve, Failure> {
    element("curve", &curves.found.curves, "curves", curve)
}
