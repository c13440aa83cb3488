//! # Descriptors
//!
//! Numbers for each vertex that tell the points of a shape apart: from eigenpairs (heat and wave
//! kernel signatures, global point signatures), and from the surface around it (SHOT, rings).
//!
//! ```c
//! double values[] = {0, 1}, vectors[] = {1, 1, 1, -1}, times[] = {0, 100}, found[4];
//! cata_descriptor_heat(CATA_COL_MAJOR, 2, 2, values, vectors, 2, 2, times, 0, found, 2, NULL);
//! printf("%g at first, %g in the end\n", found[0], found[2]); // 2 at first, 1 in the end
//! ```

use std::ffi::c_void;

use faer::MatRef;

use super::boundary::boundary;
use super::outputs::fill;
use super::params::{Params, flag, init, params, read_or_zeros};
use super::pointer::{Layout, check_leading, matrix, matrix_mut, mesh, output, slice, slice_mut};
use super::progress::cata_progress;
use super::status::{Failure, cata_status};
use catamaran_geometry::spectral::descriptors::{
    RingOptions, SHOT_BINS, ShotOptions, WaveScales, geodesic_rings, global_point_signature,
    heat_kernel, heat_kernel_signature, heat_times, heat_trace, shot, wave_kernel_signature,
    wave_scales,
};

/// Numbers of a descriptor of cata_descriptor_shot.
pub const CATA_SHOT_BINS: usize = 352;

const _: () = assert!(CATA_SHOT_BINS == SHOT_BINS);

/// Threads and progress of descriptors.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cata_descriptor_params {
    /// sizeof(cata_descriptor_params).
    pub struct_size: usize,
    /// Threads, at most; 0: all.
    pub threads: usize,
    /// Progress callback; NULL: none.
    pub progress: cata_progress,
    /// Passed to `progress`.
    pub progress_user: *mut c_void,
}

params!(cata_descriptor_params, progress_user: *mut c_void);

/// Fills a struct with the defaults.
///
/// # Safety
/// `params` points to `struct_size` writable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_descriptor_params_init(
    params: *mut cata_descriptor_params,
    struct_size: usize,
) -> cata_status {
    // SAFETY: clause `structs` (`params`).
    unsafe { init(params, struct_size) }
}

/// Computes heat kernel signatures (Sun, Ovsjanikov and Guibas 2009): for each vertex and time t
/// the sum of exp(-t eigenvalue) times the square of the eigenfunction there.
///
/// - `k`, `eigenvalues`, `eigenvectors`: as cata_mesh_eigs computes them, n x k.
/// - `count`, `times`: at least 0, in units of length^2; those of cata_descriptor_heat_times are
///   usual.
/// - `scaled`: 1: each column is divided by the heat trace, so that times compare; 0: it is not.
/// - `signature`: n x count, written, in units of 1 / area, or of 1 where scaled.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_descriptor_heat(
    layout: i32,
    n: usize,
    k: usize,
    eigenvalues: *const f64,
    eigenvectors: *const f64,
    ldv: usize,
    count: usize,
    times: *const f64,
    scaled: i32,
    signature: *mut f64,
    ldsignature: usize,
    params: *const cata_descriptor_params,
) -> cata_status {
    boundary(|| {
        let layout = Layout::new(layout)?;
        // SAFETY: clause `memory` (`times`, `count` elements; `signature`, n x `count`), clause
        // `structs` (`params`), clause `passed on` (`Pairs::new`).
        let (pairs, times, mut signature, params) = unsafe {
            (
                Pairs::new(layout, n, k, eigenvalues, eigenvectors, ldv)?,
                slice("times", times, count)?,
                matrix_mut("signature", layout, n, count, signature, ldsignature)?,
                read_or_zeros("params", params)?,
            )
        };
        let scaled = flag("scaled", scaled)?;
        let mut found = params.caller().reported(|_| {
            let threads = params.par();
            Ok(heat_kernel_signature(pairs.values, pairs.vectors, times, threads)?)
        })?;
        if scaled {
            for (j, &time) in times.iter().enumerate() {
                let trace = heat_trace(pairs.values, time);
                // Where it is 0, so is the column.
                if trace > 0.0 {
                    (0..n).for_each(|i| found[(i, j)] /= trace);
                }
            }
        }
        signature.copy_from(&found);
        Ok(())
    })
}

/// Computes times for cata_descriptor_heat: from 4 ln 10 / the largest eigenvalue to 4 ln 10 / the
/// smallest one that is not 0, in equal ratios. `times`: `count` elements, written, ascending.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_descriptor_heat_times(
    k: usize,
    eigenvalues: *const f64,
    count: usize,
    times: *mut f64,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`eigenvalues`, `k` elements; `times`, `count` elements).
        let (values, times) =
            unsafe { (slice("eigenvalues", eigenvalues, k)?, slice_mut("times", times, count)?) };
        times.copy_from_slice(&heat_times(values, count)?);
        Ok(())
    })
}

/// Computes the heat at each vertex, per area, after the time `time` when it was all at the vertex
/// `source` at first: `heat`, n elements, written. The rest as in cata_descriptor_heat.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_descriptor_heat_kernel(
    layout: i32,
    n: usize,
    k: usize,
    eigenvalues: *const f64,
    eigenvectors: *const f64,
    ldv: usize,
    source: u32,
    time: f64,
    heat: *mut f64,
) -> cata_status {
    boundary(|| {
        let layout = Layout::new(layout)?;
        // SAFETY: clause `memory` (`heat`, `n` elements), clause `passed on` (`Pairs::new`).
        let (pairs, heat) = unsafe {
            (Pairs::new(layout, n, k, eigenvalues, eigenvectors, ldv)?, slice_mut("heat", heat, n)?)
        };
        let found = heat_kernel(pairs.values, pairs.vectors, source as usize, time)?;
        heat.copy_from_slice(&found);
        Ok(())
    })
}

/// Computes wave kernel signatures (Aubry, Schlickewei and Cremers 2011): for each vertex and
/// energy the mean of the squares of eigenfunctions there, with weights that fall with the distance
/// of the logarithm of the eigenvalue from the energy.
///
/// - `count`, `energies`: logarithms of eigenvalues; `sigma`: the width of the weights, positive:
///   both usually of cata_descriptor_wave_scales.
/// - `signature`: n x count, written, in units of 1 / area. The rest as in cata_descriptor_heat.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_descriptor_wave(
    layout: i32,
    n: usize,
    k: usize,
    eigenvalues: *const f64,
    eigenvectors: *const f64,
    ldv: usize,
    count: usize,
    energies: *const f64,
    sigma: f64,
    signature: *mut f64,
    ldsignature: usize,
    params: *const cata_descriptor_params,
) -> cata_status {
    boundary(|| {
        let layout = Layout::new(layout)?;
        // SAFETY: clause `memory` (`energies`, `count` elements; `signature`, n x `count`), clause
        // `structs` (`params`), clause `passed on` (`Pairs::new`).
        let (pairs, energies, mut signature, params) = unsafe {
            (
                Pairs::new(layout, n, k, eigenvalues, eigenvectors, ldv)?,
                slice("energies", energies, count)?,
                matrix_mut("signature", layout, n, count, signature, ldsignature)?,
                read_or_zeros("params", params)?,
            )
        };
        let scales = WaveScales { energies: energies.to_vec(), sigma };
        let found = params.caller().reported(|_| {
            let threads = params.par();
            Ok(wave_kernel_signature(pairs.values, pairs.vectors, &scales, threads)?)
        })?;
        signature.copy_from(&found);
        Ok(())
    })
}

/// Computes energies and their width for cata_descriptor_wave, at equal distances. `energies`:
/// `count` elements, written, ascending; `sigma`: written.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_descriptor_wave_scales(
    k: usize,
    eigenvalues: *const f64,
    count: usize,
    energies: *mut f64,
    sigma: *mut f64,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`eigenvalues`, `k` elements; `energies`, `count` elements;
        // `sigma`, one value).
        let (values, energies, sigma) = unsafe {
            (
                slice("eigenvalues", eigenvalues, k)?,
                slice_mut("energies", energies, count)?,
                output("sigma", sigma)?,
            )
        };
        let found = wave_scales(values, count)?;
        energies.copy_from_slice(&found.energies);
        *sigma = found.sigma;
        Ok(())
    })
}

/// Computes global point signatures (Rustamov 2007): eigenfunctions divided by the root of their
/// eigenvalues, for those that are not 0. Signs are those of the eigenfunctions.
///
/// - `count`: written: the number of these eigenvalues.
/// - `signature`: n x k, written: n x count, and zeros. The rest as in cata_descriptor_heat.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_descriptor_points(
    layout: i32,
    n: usize,
    k: usize,
    eigenvalues: *const f64,
    eigenvectors: *const f64,
    ldv: usize,
    count: *mut usize,
    signature: *mut f64,
    ldsignature: usize,
) -> cata_status {
    boundary(|| {
        let layout = Layout::new(layout)?;
        // SAFETY: clause `memory` (`count`, one value; `signature`, n x k), clause `passed on`
        // (`Pairs::new`).
        let (pairs, count, signature) = unsafe {
            (
                Pairs::new(layout, n, k, eigenvalues, eigenvectors, ldv)?,
                output("count", count)?,
                matrix_mut("signature", layout, n, k, signature, ldsignature)?,
            )
        };
        let found = global_point_signature(pairs.values, pairs.vectors)?;
        *count = found.ncols();
        fill(signature, found.as_ref());
        Ok(())
    })
}

/// Computes signatures of histograms of orientations, SHOT (Tombari, Salti and Di Stefano 2010):
/// the normals in the parts of a ball around each vertex. They stay the same when the mesh is moved
/// or, with the radius, scaled. Zeros where fewer than five other vertices are in the ball.
///
/// - `radius`: of the ball, in the unit of the mesh, positive.
/// - `signature`: n_vertices x CATA_SHOT_BINS, written: rows of norm 1.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_descriptor_shot(
    n_vertices: usize,
    vertices: *const f64,
    n_faces: usize,
    faces: *const u32,
    radius: f64,
    layout: i32,
    signature: *mut f64,
    ldsignature: usize,
    params: *const cata_descriptor_params,
) -> cata_status {
    boundary(|| {
        let layout = Layout::new(layout)?;
        // SAFETY: clause `memory` (the mesh, 3 numbers a vertex and 3 indices a face; `signature`,
        // `n_vertices` x `SHOT_BINS`), clause `structs` (`params`).
        let (mesh, mut signature, params) = unsafe {
            (
                mesh(n_vertices, vertices, n_faces, faces)?,
                matrix_mut("signature", layout, n_vertices, SHOT_BINS, signature, ldsignature)?,
                read_or_zeros("params", params)?,
            )
        };
        let found = params.caller().reported(|progress| {
            let options = ShotOptions::new(radius).par(params.par()).progress(progress);
            Ok(shot(&mesh, &options)?)
        })?;
        signature.copy_from(&found);
        Ok(())
    })
}

/// Computes means of functions over rings around each vertex, by distances along edges: a
/// descriptor that bending leaves the same.
///
/// - `radius`: of the outermost ring, in the unit of the mesh, positive; `rings`: at least 1.
/// - `count`, `f`: functions, n_vertices x count.
/// - `signature`: n_vertices x (rings (1 + count)), written: for each ring, from the middle, its
///   share of the area of all, and the means of the functions.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_descriptor_rings(
    n_vertices: usize,
    vertices: *const f64,
    n_faces: usize,
    faces: *const u32,
    radius: f64,
    rings: usize,
    layout: i32,
    count: usize,
    f: *const f64,
    ldf: usize,
    signature: *mut f64,
    ldsignature: usize,
    params: *const cata_descriptor_params,
) -> cata_status {
    boundary(|| {
        let layout = Layout::new(layout)?;
        // More columns than that exceed the address space, which is then said.
        let columns = count.saturating_add(1).saturating_mul(rings);
        // SAFETY: clause `memory` (the mesh, 3 numbers a vertex and 3 indices a face; `f`,
        // `n_vertices` x `count`; `signature`, `n_vertices` x `columns`), clause `structs`
        // (`params`).
        let (mesh, f, mut signature, params) = unsafe {
            (
                mesh(n_vertices, vertices, n_faces, faces)?,
                matrix("f", layout, n_vertices, count, f, ldf)?,
                matrix_mut("signature", layout, n_vertices, columns, signature, ldsignature)?,
                read_or_zeros("params", params)?,
            )
        };
        let found = params.caller().reported(|progress| {
            let options = RingOptions::new(radius, rings);
            let options = options.par(params.par()).progress(progress);
            Ok(geodesic_rings(&mesh, f, &options)?)
        })?;
        signature.copy_from(&found);
        Ok(())
    })
}

/// Eigenpairs of the caller.
struct Pairs<'a> {
    values: &'a [f64],
    vectors: MatRef<'a, f64>,
}

impl Pairs<'_> {
    /// Creates eigenpairs from pointers.
    ///
    /// # Safety
    /// The pointers are as the header describes them, during the life of the result.
    unsafe fn new(
        layout: Layout,
        n: usize,
        k: usize,
        eigenvalues: *const f64,
        eigenvectors: *const f64,
        ldv: usize,
    ) -> Result<Self, Failure> {
        check_leading("ldv", "eigenvectors", layout, [n, k], ldv)?;
        // SAFETY: clause `memory` (`eigenvalues`, `k` elements; `eigenvectors`, n x k).
        unsafe {
            Ok(Self {
                values: slice("eigenvalues", eigenvalues, k)?,
                vectors: matrix("eigenvectors", layout, n, k, eigenvectors, ldv)?,
            })
        }
    }
}
