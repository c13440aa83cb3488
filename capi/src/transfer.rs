use super::basis::{cata_basis, cata_basis_params, with_basis_options};
use super::boundary::boundary;
use super::pointer::{Layout, known, matrix, matrix_mut, mesh, slice, slice_mut};
use super::progress::reported;
use super::status::cata_status;
use catamaran_geometry::spectral::functional_map::map_from_points;
use catamaran_geometry::spectral::{Transfer, transfer_details};

/// Carries functions over along points, through the products of eigenfunctions: the same as
/// cata_basis_products of both, cata_map_from_points and cata_transfer_map in turn.
///
/// - `source`, `target`: of cata_basis_new, the constant among the eigenfunctions.
/// - `points`: n_target elements: the vertex of the source of each vertex of the target.
/// - `f`: F, n_source x count; `g`: G, n_target x count, written.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_transfer(
    source: *const cata_basis,
    target: *const cata_basis,
    points: *const u32,
    layout: i32,
    count: usize,
    f: *const f64,
    ldf: usize,
    g: *mut f64,
    ldg: usize,
    params: *const cata_basis_params,
) -> cata_status {
    boundary(|| {
        let layout = Layout::new(layout)?;
        // SAFETY: clause `handles` (`source`, `target`).
        let (source, target) = unsafe { (known("source", source)?, known("target", target)?) };
        let (source, target) = (source.eigen("source")?, target.eigen("target")?);
        let (n, m) = (source.basis().vertices(), target.basis().vertices());
        // SAFETY: clause `memory` (`points`, `m` elements; `f`, n x `count`; `g`, m x `count`).
        let (points, f, mut g) = unsafe {
            (
                slice("points", points, m)?,
                matrix("f", layout, n, count, f, ldf)?,
                matrix_mut("g", layout, m, count, g, ldg)?,
            )
        };
        // SAFETY: clause `structs` (`params`).
        g.copy_from(&unsafe {
            with_basis_options(params, |options| {
                let progress = options.progress;
                let source = options.products(source, progress.part(0.0..0.45))?.into_basis();
                let target = options.products(target, progress.part(0.45..0.9))?.into_basis();
                let map = map_from_points(points, &source, &target, options.par)?;
                let found = Transfer::new(&source, &target, map)?.apply(f, options.par)?;
                progress.report(1.0)?;
                Ok(found)
            })
        }?);
        Ok(())
    })
}

/// Carries functions over by a map C (r_target x r_source) between any bases: F, n_source x
/// count, to G, n_target x count, written.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_transfer_map(
    source: *const cata_basis,
    target: *const cata_basis,
    layout: i32,
    c: *const f64,
    ldc: usize,
    count: usize,
    f: *const f64,
    ldf: usize,
    g: *mut f64,
    ldg: usize,
    params: *const cata_basis_params,
) -> cata_status {
    boundary(|| {
        let layout = Layout::new(layout)?;
        // SAFETY: clause `handles` (`source`, `target`).
        let (source, target) =
            unsafe { (known("source", source)?.basis(), known("target", target)?.basis()) };
        // SAFETY: clause `memory` (`c`, `target.len()` x `source.len()`; `f`, `source.vertices()` x
        // `count`; `g`, `target.vertices()` x `count`).
        let (c, f, mut g) = unsafe {
            (
                matrix("c", layout, target.len(), source.len(), c, ldc)?,
                matrix("f", layout, source.vertices(), count, f, ldf)?,
                matrix_mut("g", layout, target.vertices(), count, g, ldg)?,
            )
        };
        // SAFETY: clause `structs` (`params`).
        g.copy_from(&unsafe {
            with_basis_options(params, |options| {
                reported(options.progress, || {
                    Transfer::new(source, target, c.to_owned())?.apply(f, options.par)
                })
            })
        }?);
        Ok(())
    })
}

/// Gives the target mesh the details of the source mesh: heights over the smooth part of the
/// source, carried over by C, along normals in place of its own.
///
/// - `smooth_source`, `smooth_target`: bases of few functions, whose spans have the smooth
///   parts.
/// - `source`, `target`, `c`: as in cata_transfer_map.
/// - `positions`: 3 target_n_vertices elements, written: the vertices of the target, moved.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_transfer_details(
    n_vertices: usize,
    vertices: *const f64,
    n_faces: usize,
    faces: *const u32,
    target_n_vertices: usize,
    target_vertices: *const f64,
    target_n_faces: usize,
    target_faces: *const u32,
    smooth_source: *const cata_basis,
    smooth_target: *const cata_basis,
    source: *const cata_basis,
    target: *const cata_basis,
    layout: i32,
    c: *const f64,
    ldc: usize,
    positions: *mut f64,
    params: *const cata_basis_params,
) -> cata_status {
    boundary(|| {
        let layout = Layout::new(layout)?;
        // SAFETY: clause `memory` (the mesh, 3 numbers a vertex and 3 indices a face), clause
        // `handles` (`smooth_source`, `smooth_target`, `source`, `target`).
        let (meshes, smooth, source, target) = unsafe {
            (
                (
                    mesh(n_vertices, vertices, n_faces, faces)?,
                    mesh(target_n_vertices, target_vertices, target_n_faces, target_faces)
                        .map_err(|failure| failure.of("target"))?,
                ),
                (
                    known("smooth_source", smooth_source)?.basis(),
                    known("smooth_target", smooth_target)?.basis(),
                ),
                known("source", source)?.basis(),
                known("target", target)?.basis(),
            )
        };
        // SAFETY: clause `memory` (`c`, `target.len()` x `source.len()`; `positions`, `3 *
        // target_n_vertices` elements).
        let (c, positions) = unsafe {
            (
                matrix("c", layout, target.len(), source.len(), c, ldc)?,
                slice_mut("positions", positions, 3 * target_n_vertices)?,
            )
        };
        // SAFETY: clause `structs` (`params`).
        let found = unsafe {
            with_basis_options(params, |options| {
                reported(options.progress, || {
                    let transfer = Transfer::new(source, target, c.to_owned())?;
                    transfer_details(&meshes.0, &meshes.1, smooth, &transfer, options.par)
                })
            })
        }?;
        positions.copy_from_slice(found.vertices().as_flattened());
        Ok(())
    })
}
