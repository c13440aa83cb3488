//! # Spectra and maps
//!
//! Functions carried from one shape to another over eigenproducts; ShapeDNA (thesis, chapter 1).

use std::ffi::c_void;
use std::mem::offset_of;

use faer::MatRef;

use super::boundary::boundary;
use super::params::{Versioned, flag, init, read};
use super::pointer::{Layout, matrix, matrix_mut, slice};
use super::progress::{cata_progress, par, watcher};
use super::status::{Failure, cata_status};
use crate::Par;
use crate::base::Progress;
use crate::sparse::Mass;
use crate::spectral::functional_map::map_from_points;
use crate::spectral::{Eigenbasis, Orthogonalization, ProductBasis, ProductBasisOptions, Transfer};

/// How functions are transferred.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cata_transfer_params {
    /// sizeof(cata_transfer_params).
    pub struct_size: usize,
    /// Threads, at most; 0: all.
    pub threads: usize,
    /// Told of progress, once for each basis; NULL: nobody.
    pub progress: cata_progress,
    /// Handed to `progress`.
    pub progress_user: *mut c_void,
    /// Most factors of a product, at most 255; 1: eigenfunctions alone; 0: 2.
    pub order: usize,
    /// 0: products are orthogonalised once, and dropped when less than 1e-2 of them is left,
    /// which is stabler. 1: until they are orthogonal to rounding, and dropped below 1e-9: more
    /// functions.
    pub reorthogonalised: i32,
}

impl Versioned for cata_transfer_params {
    const NAME: &'static str = "cata_transfer_params";
    const FIRST_SIZE: usize = offset_of!(Self, reorthogonalised) + size_of::<i32>();
}

/// Fills a struct with the defaults.
///
/// # Safety
/// `params` points to `struct_size` writable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_transfer_params_init(
    params: *mut cata_transfer_params,
    struct_size: usize,
) -> cata_status {
    // SAFETY: the promises are the same.
    unsafe { init(params, struct_size) }
}

/// Transfers functions from a source mesh to a target mesh, through the orthogonalised products
/// of their first eigenfunctions (as cata_eigs computes them, without a shift).
///
/// - `n`, `m`: vertices of source and target.
/// - `k`, `l`: eigenfunctions of source and target, the constant among them: at least 1.
/// - `source_masses`, `target_masses`: n and m elements, read: the masses of vertices; positive.
/// - `source_values`, `target_values`: k and l elements, read: eigenvalues, ascending.
/// - `source_vectors`, `target_vectors`: n x k and m x l, read, column-major with leading
///   dimensions n and m: eigenvectors, orthonormal in the inner products of the masses.
/// - `points`: m elements, read: the vertex of the source, below n, of each vertex of the target.
/// - `functions`: number of functions, 0 included.
/// - `f`: F, n x functions, read, with leading dimension `ldf`, as A in cata_ata_f64.
/// - `g`: G, m x functions, written, with leading dimension `ldg`.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_transfer(
    n: usize,
    k: usize,
    source_masses: *const f64,
    source_values: *const f64,
    source_vectors: *const f64,
    m: usize,
    l: usize,
    target_masses: *const f64,
    target_values: *const f64,
    target_vectors: *const f64,
    points: *const u32,
    layout: i32,
    functions: usize,
    f: *const f64,
    ldf: usize,
    g: *mut f64,
    ldg: usize,
    params: *const cata_transfer_params,
) -> cata_status {
    boundary(|| {
        let layout = Layout::new(layout)?;
        let columns = Layout::ColMajor;
        // SAFETY: the caller's promise.
        let (source, target, points, f, mut g) = unsafe {
            let masses = slice("source_masses", source_masses, n)?;
            let values = slice("source_values", source_values, k)?;
            let vectors = matrix("source_vectors", columns, n, k, source_vectors, n.max(1))?;
            let source = eigenbasis(masses, values, vectors)?;
            let masses = slice("target_masses", target_masses, m)?;
            let values = slice("target_values", target_values, l)?;
            let vectors = matrix("target_vectors", columns, m, l, target_vectors, m.max(1))?;
            let target = eigenbasis(masses, values, vectors)?;
            (
                source,
                target,
                slice("points", points, m)?,
                matrix("f", layout, n, functions, f, ldf)?,
                matrix_mut("g", layout, m, functions, g, ldg)?,
            )
        };
        let (mut order, mut threads, mut orthogonalization) =
            (2, Par::all(), Orthogonalization::SinglePass);
        let mut watch = None;
        if !params.is_null() {
            // SAFETY: the caller's promise.
            let params = unsafe { read(params) }?;
            threads = par(params.threads);
            if params.order > 0 {
                order = params.order;
            }
            if flag("params.reorthogonalised", params.reorthogonalised)? {
                orthogonalization = Orthogonalization::Reorthogonalized;
            }
            watch = watcher(params.progress, params.progress_user);
        }
        let progress = watch.as_ref().map_or(Progress::none(), Progress::from);
        let options = ProductBasisOptions { orthogonalization, par: threads, progress };
        let source = ProductBasis::new(&source, order, &options)?.into_basis();
        let target = ProductBasis::new(&target, order, &options)?.into_basis();
        let map = map_from_points(points, &source, &target, threads)?;
        g.copy_from(&Transfer::new(&source, &target, map)?.apply(f, threads)?);
        Ok(())
    })
}

/// A copy of the caller's eigenpairs.
fn eigenbasis(
    masses: &[f64],
    values: &[f64],
    vectors: MatRef<'_, f64>,
) -> Result<Eigenbasis, Failure> {
    let mass = Mass::Lumped(masses.to_vec());
    Ok(Eigenbasis::new(values.to_vec(), vectors.to_owned(), mass)?)
}
