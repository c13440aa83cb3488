use std::sync::Arc;

use faer::MatRef;

use super::basis::{Functions, cata_basis, cata_basis_params, with_basis_options};
use super::boundary::boundary;
use super::outputs::fill_slice;
use super::params::flag;
use super::pointer::{
    Layout, free, hand_over, known, known_mut, matrix, matrix_mut, mesh, optional_output, output,
    put, slice, slice_mut,
};
use super::progress::reported;
use super::status::{Failure, cata_status};
use catamaran::Par;
use catamaran_geometry::spectral::functional_map::{
    Correspondences, FoundMap, MapFit, Refined, icp, map_from_points, points_from_map, search_map,
    zoomout,
};
use catamaran_geometry::spectral::{
    Eigenbasis, ProductMap, transform_by_columns, transform_of_all_products,
};

/// A functional map C between two bases of cata_basis_new that is being fitted: r_target x
/// r_source, it takes coefficients of functions on the source to those of functions on the
/// target.
pub struct cata_map_fit {
    source: Arc<Functions>,
    target: Arc<Functions>,
    par: Par,
    known: Correspondences,
}

/// Creates an empty fit, with the threads of `source`.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_map_fit_new(
    source: *const cata_basis,
    target: *const cata_basis,
    fit: *mut *mut cata_map_fit,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`fit`, one value), clause `handles` (`source`, `target`).
        let (source, target, place) =
            unsafe { (known("source", source)?, known("target", target)?, output("fit", fit)?) };
        source.eigen("source")?;
        target.eigen("target")?;
        let [from, to] = [source, target].map(|basis| Arc::clone(&basis.functions));
        let known = Correspondences::default();
        let fit = cata_map_fit { source: from, target: to, par: source.par, known };
        hand_over(place, fit);
        Ok(())
    })
}

/// Frees a fit.
///
/// # Safety
/// The pointer is as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_map_fit_free(fit: *mut cata_map_fit) {
    // SAFETY: clause `handles` (`fit`).
    unsafe { free(fit) };
}

/// Adds functions that correspond: columns of F (n_source x count) and G (n_target x count).
/// Each pair counts the same.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_map_fit_functions(
    fit: *mut cata_map_fit,
    layout: i32,
    count: usize,
    f: *const f64,
    ldf: usize,
    g: *const f64,
    ldg: usize,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `passed on` (`pair`).
        let (fit, f, g) = unsafe { pair(fit, layout, count, f, ldf, g, ldg) }?;
        fit.add(|fit| fit.functions(f, g))
    })
}

/// Adds that C commutes with multiplications by such functions, with this weight; 0.1 is usual.
/// A function constrains the map far more in this way.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_map_fit_operators(
    fit: *mut cata_map_fit,
    layout: i32,
    count: usize,
    f: *const f64,
    ldf: usize,
    g: *const f64,
    ldg: usize,
    weight: f64,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `passed on` (`pair`).
        let (fit, f, g) = unsafe { pair(fit, layout, count, f, ldf, g, ldg) }?;
        fit.add(|fit| fit.operators(f, g, weight))
    })
}

/// Adds vertices that correspond, by heat kernels around them. `pairs`: 2 count elements, a
/// vertex of the source and one of the target each.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_map_fit_landmarks(
    fit: *mut cata_map_fit,
    count: usize,
    pairs: *const u32,
) -> cata_status {
    boundary(|| {
        let pairs = pairs.cast::<[u32; 2]>();
        // SAFETY: clause `memory` (`pairs`, `2 * count` elements), clause `handles` (`fit`).
        let (fit, pairs) = unsafe { (known_mut("fit", fit)?, slice("pairs", pairs, count)?) };
        let pairs: Vec<(u32, u32)> = pairs.iter().map(|&[x, y]| (x, y)).collect();
        fit.add(|fit| fit.landmarks(&pairs))
    })
}

/// Adds segments that correspond: a label for each vertex of the source and of the target. Every
/// label, 0 too, must be on both.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_map_fit_segments(
    fit: *mut cata_map_fit,
    source_labels: *const u32,
    target_labels: *const u32,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `handles` (`fit`).
        let fit = unsafe { known_mut("fit", fit) }?;
        let [n, m] = [fit.source("source")?, fit.target("target")?].map(|b| b.basis().vertices());
        // SAFETY: clause `memory` (`source_labels`, `n` elements; `target_labels`, `m` elements).
        let (source, target) = unsafe {
            (slice("source_labels", source_labels, n)?, slice("target_labels", target_labels, m)?)
        };
        fit.add(|fit| fit.segments(source, target))
    })
}

/// Adds heat and wave kernel signatures: of `source` and `target`, of cata_basis_new for the same
/// meshes, with more functions than the fit, or as many.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_map_fit_signatures(
    fit: *mut cata_map_fit,
    source: *const cata_basis,
    target: *const cata_basis,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `handles` (`fit`), clause `passed on` (`eigenbases`).
        let (fit, (source, target)) =
            unsafe { (known_mut("fit", fit)?, eigenbases(source, target)?) };
        fit.add(|fit| fit.signatures(source, target))
    })
}

/// Computes the map C (r_target x r_source, written) that fits best what was added and commutes
/// with the Laplacians; `commutativity` >= 0, usually 1e-3, weighs that. It keeps the constant.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_map_fit_solve(
    fit: *mut cata_map_fit,
    commutativity: f64,
    layout: i32,
    c: *mut f64,
    ldc: usize,
    params: *const cata_basis_params,
) -> cata_status {
    boundary(|| {
        let layout = Layout::new(layout)?;
        // SAFETY: clause `handles` (`fit`).
        let fit = unsafe { known_mut("fit", fit) }?;
        let (source, target) = (Arc::clone(&fit.source), Arc::clone(&fit.target));
        let (source, target) = (source.eigen("source")?, target.eigen("target")?);
        let (rows, cols) = (target.len(), source.len());
        // SAFETY: clause `memory` (`c`, `rows` x `cols`).
        let mut c = unsafe { matrix_mut("c", layout, rows, cols, c, ldc) }?;
        // SAFETY: clause `structs` (`params`).
        let found = unsafe {
            with_basis_options(params, |options| {
                let known = std::mem::take(&mut fit.known);
                let solver =
                    MapFit::resumed(source, target, options.par, known).progress(options.progress);
                let found = solver.solve(commutativity);
                fit.known = solver.into_known();
                Ok(found?)
            })
        }?;
        c.copy_from(&found);
        Ok(())
    })
}

/// Iterates closest points: in turns the points of C (r_target x r_source, read and written) and
/// the orthogonal map along them, until these stay the same or `iterations` >= 1 are done.
///
/// - `source`, `target`: of cata_basis_new.
/// - `points`: n_target elements, written: the vertex of the source for each of the target; NULL
///   where not wanted.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_map_icp(
    source: *const cata_basis,
    target: *const cata_basis,
    iterations: usize,
    layout: i32,
    c: *mut f64,
    ldc: usize,
    points: *mut u32,
    params: *const cata_basis_params,
) -> cata_status {
    boundary(|| {
        let layout = Layout::new(layout)?;
        // SAFETY: clause `passed on` (`eigenbases`).
        let (source, target) = unsafe { eigenbases(source, target) }?;
        // SAFETY: clause `memory` (`c`, `target.len()` x `source.len()`), clause `passed on`
        // (`points_out`).
        let (mut c, points) = unsafe {
            let c = matrix_mut("c", layout, target.len(), source.len(), c, ldc)?;
            (c, points_out(points, target)?)
        };
        // SAFETY: clause `structs` (`params`).
        let Refined { map, points: found } = unsafe {
            with_basis_options(params, |options| {
                Ok(icp(
                    c.as_ref(),
                    source.basis(),
                    target.basis(),
                    iterations,
                    options.par,
                    options.progress,
                )?)
            })
        }?;
        c.copy_from(&map);
        fill_slice(points, &found);
        Ok(())
    })
}

/// Refines by ZoomOut: in turns the points of a map and the map along them between `step` >= 1
/// functions more, from C (rows x cols, read), a map between the first functions, to the whole MAP
/// (r_target x r_source, written). `source`, `target` and `points` are as in cata_map_icp.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_map_zoomout(
    source: *const cata_basis,
    target: *const cata_basis,
    step: usize,
    layout: i32,
    rows: usize,
    cols: usize,
    c: *const f64,
    ldc: usize,
    map: *mut f64,
    ldmap: usize,
    points: *mut u32,
    params: *const cata_basis_params,
) -> cata_status {
    boundary(|| {
        let layout = Layout::new(layout)?;
        // SAFETY: clause `passed on` (`eigenbases`).
        let (source, target) = unsafe { eigenbases(source, target) }?;
        // SAFETY: clause `memory` (`c`, `rows` x `cols`; `map`, `target.len()` x `source.len()`),
        // clause `passed on` (`points_out`).
        let (c, mut map, points) = unsafe {
            let c = matrix("c", layout, rows, cols, c, ldc)?;
            let map = matrix_mut("map", layout, target.len(), source.len(), map, ldmap)?;
            (c, map, points_out(points, target)?)
        };
        // SAFETY: clause `structs` (`params`).
        let found = unsafe {
            with_basis_options(params, |options| {
                Ok(zoomout(c, source.basis(), target.basis(), step, options.par, options.progress)?)
            })
        }?;
        map.copy_from(&found.map);
        fill_slice(points, &found.points);
        Ok(())
    })
}

/// Searches for the map of two nearly isometric meshes of which no correspondence is known, and
/// refines it by ZoomOut to the whole MAP (r_target x r_source, written): the one that commutes
/// best with the Laplacians among those that keep the orientation, left and right.
///
/// - `source`, `target`, `points`: as in cata_map_icp; 40 functions or more are best.
/// - `source_vertices`, `target_vertices`: 3 elements for each vertex of a basis; the faces: 3 for
///   each.
/// - `is_ambiguous`: written: 1 where another map may be the true one, so that the map is to be
///   checked, or found from landmarks; 0 otherwise. It is required.
/// - `commutativity`: written: |C L - L' C|^2 / |L|^2 for area 1; `next`: that of the next best
///   map, infinite without one; `orientation`: written: from -1 to 1, of a map that keeps it near
///   1. Each is NULL where not wanted.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_map_search(
    source: *const cata_basis,
    target: *const cata_basis,
    source_vertices: *const f64,
    n_source_faces: usize,
    source_faces: *const u32,
    target_vertices: *const f64,
    n_target_faces: usize,
    target_faces: *const u32,
    layout: i32,
    map: *mut f64,
    ldmap: usize,
    points: *mut u32,
    is_ambiguous: *mut i32,
    commutativity: *mut f64,
    next: *mut f64,
    orientation: *mut f64,
    params: *const cata_basis_params,
) -> cata_status {
    boundary(|| {
        let layout = Layout::new(layout)?;
        // SAFETY: clause `passed on` (`eigenbases`).
        let (source, target) = unsafe { eigenbases(source, target) }?;
        let [n, m] = [source, target].map(|eigen| eigen.basis().vertices());
        // SAFETY: clause `memory` (`is_ambiguous`, `commutativity`, `next`, `orientation`, one
        // value each).
        let (ambiguous, commutativity, next, orientation) = unsafe {
            (
                output("is_ambiguous", is_ambiguous)?,
                optional_output("commutativity", commutativity)?,
                optional_output("next", next)?,
                optional_output("orientation", orientation)?,
            )
        };
        // SAFETY: clause `memory` (the meshes, 3 numbers a vertex and 3 indices a face; `map`,
        // `target.len()` x `source.len()`), clause `passed on` (`points_out`).
        let (from, to, mut map, points) = unsafe {
            let from = mesh(n, source_vertices, n_source_faces, source_faces)
                .map_err(|failure| failure.of("source"))?;
            let to = mesh(m, target_vertices, n_target_faces, target_faces)
                .map_err(|failure| failure.of("target"))?;
            let map = matrix_mut("map", layout, target.len(), source.len(), map, ldmap)?;
            (from, to, map, points_out(points, target)?)
        };
        // SAFETY: clause `structs` (`params`).
        let (found, refined) = unsafe {
            with_basis_options(params, |options| {
                let (par, progress) = (options.par, options.progress);
                let searching = progress.part(0.0..0.5);
                let found = search_map((&from, source), (&to, target), par, searching)?;
                let (c, progress) = (found.map.as_ref(), progress.part(0.5..1.0));
                let all = (source.basis(), target.basis());
                let refined = zoomout(c, all.0, all.1, FoundMap::STEP, par, progress)?;
                Ok((found, refined))
            })
        }?;
        *ambiguous = i32::from(found.is_ambiguous());
        put(commutativity, found.commutativity);
        put(next, found.next.unwrap_or(f64::INFINITY));
        put(orientation, found.orientation);
        map.copy_from(&refined.map);
        fill_slice(points, &refined.points);
        Ok(())
    })
}

/// Computes the points of the map C (r_target x r_source) between any bases: n_target elements,
/// written: for each vertex of the target that of the source whose image is nearest.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_map_points(
    source: *const cata_basis,
    target: *const cata_basis,
    layout: i32,
    c: *const f64,
    ldc: usize,
    points: *mut u32,
    params: *const cata_basis_params,
) -> cata_status {
    boundary(|| {
        let layout = Layout::new(layout)?;
        // SAFETY: clause `handles` (`source`, `target`).
        let (source, target) =
            unsafe { (known("source", source)?.basis(), known("target", target)?.basis()) };
        // SAFETY: clause `memory` (`c`, `target.len()` x `source.len()`; `points`,
        // `target.vertices()` elements).
        let (c, points) = unsafe {
            let c = matrix("c", layout, target.len(), source.len(), c, ldc)?;
            (c, slice_mut("points", points, target.vertices())?)
        };
        // SAFETY: clause `structs` (`params`).
        points.copy_from_slice(&unsafe {
            with_basis_options(params, |options| {
                Ok(points_from_map(c, source, target, options.par, options.progress)?)
            })
        }?);
        Ok(())
    })
}

/// Computes the map O of products of eigenfunctions, r_target x r_source, that a map C of the
/// eigenfunctions implies, since T(f g) = T(f) T(g) (thesis, section 1.3.3). The matrix of all
/// products is not in memory. C must be nearly exact; from points, cata_map_from_points of the
/// products is more accurate.
///
/// - `source_eigen`, `target_eigen`: of cata_basis_new, the constants among them; `c`: between
///   them.
/// - `source`, `target`: of cata_basis_products of these, with the same order; `o`: written.
/// - `of_all`: 0: column by column, of the products that are kept (equation 1.18). 1: the least
///   squares over all products (equation 1.16).
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_product_map(
    source_eigen: *const cata_basis,
    target_eigen: *const cata_basis,
    source: *const cata_basis,
    target: *const cata_basis,
    layout: i32,
    c: *const f64,
    ldc: usize,
    of_all: i32,
    o: *mut f64,
    ldo: usize,
    params: *const cata_basis_params,
) -> cata_status {
    boundary(|| {
        let layout = Layout::new(layout)?;
        // SAFETY: clause `handles` (`source_eigen`, `target_eigen`, `source`, `target`).
        let (from, to, source, target) = unsafe {
            (
                known("source_eigen", source_eigen)?.eigen("source_eigen")?,
                known("target_eigen", target_eigen)?.eigen("target_eigen")?,
                known("source", source)?.products("source")?,
                known("target", target)?.products("target")?,
            )
        };
        // SAFETY: clause `memory` (`c`, `to.len()` x `from.len()`; `o`, `target.len()` x
        // `source.len()`).
        let (c, mut o) = unsafe {
            let c = matrix("c", layout, to.len(), from.len(), c, ldc)?;
            (c, matrix_mut("o", layout, target.len(), source.len(), o, ldo)?)
        };
        let transform =
            if flag("of_all", of_all)? { transform_of_all_products } else { transform_by_columns };
        // SAFETY: clause `structs` (`params`).
        o.copy_from(&unsafe {
            with_basis_options(params, |options| {
                reported(options.progress, || {
                    let map = ProductMap::new(c, from, to, source.products().order())?;
                    transform(&map, source, target, options.par)
                })
            })
        }?);
        Ok(())
    })
}

/// Computes the map C (r_target x r_source, written) between any bases along points (read).
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_map_from_points(
    source: *const cata_basis,
    target: *const cata_basis,
    points: *const u32,
    layout: i32,
    c: *mut f64,
    ldc: usize,
    params: *const cata_basis_params,
) -> cata_status {
    boundary(|| {
        let layout = Layout::new(layout)?;
        // SAFETY: clause `handles` (`source`, `target`).
        let (source, target) =
            unsafe { (known("source", source)?.basis(), known("target", target)?.basis()) };
        // SAFETY: clause `memory` (`points`, `target.vertices()` elements; `c`, `target.len()` x
        // `source.len()`).
        let (points, mut c) = unsafe {
            let points = slice("points", points, target.vertices())?;
            (points, matrix_mut("c", layout, target.len(), source.len(), c, ldc)?)
        };
        // SAFETY: clause `structs` (`params`).
        c.copy_from(&unsafe {
            with_basis_options(params, |options| {
                reported(options.progress, || map_from_points(points, source, target, options.par))
            })
        }?);
        Ok(())
    })
}

impl cata_map_fit {
    fn source(&self, what: &str) -> Result<&Eigenbasis, Failure> {
        self.source.eigen(what)
    }

    fn target(&self, what: &str) -> Result<&Eigenbasis, Failure> {
        self.target.eigen(what)
    }

    /// Adds constraints to the fit.
    fn add(
        &mut self,
        more: impl FnOnce(&mut MapFit<'_>) -> catamaran::Result<()>,
    ) -> Result<(), Failure> {
        let known = std::mem::take(&mut self.known);
        let (source, target) = (self.source("source")?, self.target("target")?);
        let mut fit = MapFit::resumed(source, target, self.par, known);
        let outcome = more(&mut fit);
        self.known = fit.into_known();
        Ok(outcome?)
    }
}

/// Returns the fit, and functions on both meshes.
///
/// # Safety
/// The pointers are as the header describes them, during `'a`.
unsafe fn pair<'a>(
    fit: *mut cata_map_fit,
    layout: i32,
    count: usize,
    f: *const f64,
    ldf: usize,
    g: *const f64,
    ldg: usize,
) -> Result<(&'a mut cata_map_fit, MatRef<'a, f64>, MatRef<'a, f64>), Failure> {
    let layout = Layout::new(layout)?;
    // SAFETY: clause `memory` (`f`, n x `count`; `g`, m x `count`), clause `handles` (`fit`).
    unsafe {
        let fit = known_mut("fit", fit)?;
        let [n, m] = [fit.source("source")?, fit.target("target")?].map(|b| b.basis().vertices());
        let f = matrix("f", layout, n, count, f, ldf)?;
        Ok((fit, f, matrix("g", layout, m, count, g, ldg)?))
    }
}

/// Returns the eigenfunctions of both shapes.
///
/// # Safety
/// NULL or alive during `'a`.
unsafe fn eigenbases<'a>(
    source: *const cata_basis,
    target: *const cata_basis,
) -> Result<(&'a Eigenbasis, &'a Eigenbasis), Failure> {
    // SAFETY: clause `handles` (`source`, `target`).
    let (source, target) = unsafe { (known("source", source)?, known("target", target)?) };
    Ok((source.eigen("source")?, target.eigen("target")?))
}

/// Returns the place for the points of a map.
///
/// # Safety
/// NULL, or a place for each vertex of the target during `'a`.
unsafe fn points_out<'a>(
    points: *mut u32,
    target: &Eigenbasis,
) -> Result<Option<&'a mut [u32]>, Failure> {
    // SAFETY: clause `memory` (`points`, `target.basis().vertices()` elements).
    unsafe { super::pointer::optional_slice_mut("points", points, target.basis().vertices()) }
}
