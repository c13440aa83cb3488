//! # Spectra and maps
//!
//! Eigenfunctions of two shapes and their products as bases; functional maps between them,
//! functions and details carried over; ShapeDNA (thesis, chapter 1).
//!
//! ```c
//! double masses[] = {0.5, 0.5}, values[] = {0, 1}, vectors[] = {1, 1, 1, -1};
//! double f[] = {3, 1}, gains[] = {1, 0}, g[2];
//! cata_basis *basis;
//! cata_basis_new(2, 2, masses, values, vectors, 2, NULL, &basis);
//! cata_basis_filter(basis, CATA_COL_MAJOR, 1, f, 2, gains, 0, g, 2);
//! printf("%g %g\n", g[0], g[1]); // 2 2
//! cata_basis_free(basis);
//! ```

use std::ffi::c_void;
use std::sync::Arc;

use super::boundary::boundary;
use super::ortho::{
    CATA_ORTHO_RANK_REVEALING, CATA_ORTHO_REORTHOGONALIZED, CATA_ORTHO_SINGLE_PASS, known_method,
};
use super::outputs::tell;
use super::params::{Params, init, or_default, params, with_params};
use super::pointer::{
    Layout, check_leading, free, hand_over, known, matrix, matrix_mut, output, slice, slice_mut,
};
use super::progress::{cata_progress, reported};
use super::status::{CATA_ERR_ARGUMENT, Failure, cata_status};
use catamaran::Par;
use catamaran::base::Progress;
use catamaran::sparse::Mass;
use catamaran_geometry::spectral::{
    Basis, Eigenbasis, Orthogonalization, ProductBasis, ProductBasisOptions, add_coefficient,
    filter, split,
};

/// Functions on the vertices of a mesh, r linearly independent ones, with the inner product of
/// its masses: eigenfunctions (cata_basis_new) or their products (cata_basis_products).
pub struct cata_basis {
    pub(super) functions: Arc<Functions>,
    pub(super) par: Par,
}

/// The kinds of functions of a basis.
pub(super) enum Functions {
    Eigen(Eigenbasis),
    Products(ProductBasis),
}

impl cata_basis {
    fn new(functions: Functions, par: Par) -> Self {
        Self { functions: Arc::new(functions), par }
    }

    pub(super) fn basis(&self) -> &Basis {
        match &*self.functions {
            Functions::Eigen(eigen) => eigen.basis(),
            Functions::Products(products) => products.basis(),
        }
    }

    /// Returns the eigenfunctions, or an error for a basis of products.
    pub(super) fn eigen(&self, what: &str) -> Result<&Eigenbasis, Failure> {
        self.functions.eigen(what)
    }

    /// Returns the products, or an error for a basis of eigenfunctions.
    pub(super) fn products(&self, what: &str) -> Result<&ProductBasis, Failure> {
        match &*self.functions {
            Functions::Products(products) => Ok(products),
            Functions::Eigen(_) => Err(Failure::new(
                CATA_ERR_ARGUMENT,
                format!("{what}: needs a basis of cata_basis_products, not of cata_basis_new"),
            )),
        }
    }
}

impl Functions {
    pub(super) fn eigen(&self, what: &str) -> Result<&Eigenbasis, Failure> {
        match self {
            Self::Eigen(eigen) => Ok(eigen),
            Self::Products(_) => Err(Failure::new(
                CATA_ERR_ARGUMENT,
                format!("{what}: must be a basis of cata_basis_new, not of products"),
            )),
        }
    }
}

/// Options of bases of products, and of the other calls of this chapter.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cata_basis_params {
    /// sizeof(cata_basis_params).
    pub struct_size: usize,
    /// Threads, at most; 0: all. A basis keeps this for its own calls.
    pub threads: usize,
    /// Progress callback; NULL: none. A basis does not keep it: its own calls are short.
    pub progress: cata_progress,
    /// Passed to `progress`.
    pub progress_user: *mut c_void,
    /// For products: most factors, at most 255; 1: eigenfunctions alone; 0: 2.
    pub order: usize,
    /// For products: CATA_ORTHO_*; 0: CATA_ORTHO_SINGLE_PASS, which is stabler under transfer.
    pub method: i32,
}

params!(cata_basis_params, method: i32);

/// Fills a struct with the defaults.
///
/// # Safety
/// `params` points to `struct_size` writable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_basis_params_init(
    params: *mut cata_basis_params,
    struct_size: usize,
) -> cata_status {
    // SAFETY: clause `structs` (`params`).
    unsafe { init(params, struct_size) }
}

/// Creates the basis of k eigenfunctions, as cata_mesh_eigs computes them, which are copied.
///
/// - `masses`: n elements, positive: those of the vertices.
/// - `eigenvalues`: k elements, ascending.
/// - `eigenvectors`: n x k, column-major: orthonormal in the inner product of the masses. The
///   constant, where it is in the span of those of eigenvalue 0, becomes the first one.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_basis_new(
    n: usize,
    k: usize,
    masses: *const f64,
    eigenvalues: *const f64,
    eigenvectors: *const f64,
    ldv: usize,
    params: *const cata_basis_params,
    basis: *mut *mut cata_basis,
) -> cata_status {
    boundary(|| {
        check_leading("ldv", "eigenvectors", Layout::ColMajor, [n, k], ldv)?;
        // SAFETY: clause `memory` (`masses`, `n` elements; `eigenvalues`, `k` elements;
        // `eigenvectors`, n x k; `basis`, one value).
        let (masses, values, vectors, place) = unsafe {
            (
                slice("masses", masses, n)?,
                slice("eigenvalues", eigenvalues, k)?,
                matrix("eigenvectors", Layout::ColMajor, n, k, eigenvectors, ldv)?,
                output("basis", basis)?,
            )
        };
        let work = |options: &BasisOptions<'_>| {
            let eigen = reported(options.progress, || {
                let mass = Mass::Lumped(masses.to_vec());
                Eigenbasis::new(values.to_vec(), vectors.to_owned(), mass)
            })?;
            Ok(cata_basis::new(Functions::Eigen(eigen), options.par))
        };
        // SAFETY: clause `structs` (`params`).
        hand_over(place, unsafe { with_basis_options(params, work) }?);
        Ok(())
    })
}

/// Computes the products of at most `order` eigenfunctions, each divided by the constant, made
/// orthonormal (CATA_ORTHO_SINGLE_PASS: nearly) and without those that depend on others: B = Q R, B
/// being all products in the order 1, phi_1, ..., phi_1 phi_1, phi_1 phi_2, ..., and Q the basis.
///
/// `eigenfunctions`: of cata_basis_new, the constant among them.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_basis_products(
    eigenfunctions: *const cata_basis,
    params: *const cata_basis_params,
    basis: *mut *mut cata_basis,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`basis`, one value), clause `handles` (`eigenfunctions`).
        let (eigen, place) =
            unsafe { (known("eigenfunctions", eigenfunctions)?, output("basis", basis)?) };
        let eigen = eigen.eigen("eigenfunctions")?;
        let work = |options: &BasisOptions<'_>| {
            let products = options.products(eigen, options.progress)?;
            Ok(cata_basis::new(Functions::Products(products), options.par))
        };
        // SAFETY: clause `structs` (`params`).
        hand_over(place, unsafe { with_basis_options(params, work) }?);
        Ok(())
    })
}

/// Frees a basis; a cata_map_fit that uses it stays valid.
///
/// # Safety
/// The pointer is as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_basis_free(basis: *mut cata_basis) {
    // SAFETY: clause `handles` (`basis`).
    unsafe { free(basis) };
}

/// Gets the sizes of a basis: vertices, functions, and all products that they were made of, 0 for a
/// basis of cata_basis_new. Each is NULL where not wanted.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_basis_size(
    basis: *const cata_basis,
    n: *mut usize,
    r: *mut usize,
    products: *mut usize,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`n`, `r`, `products`, one value each), clause `handles`
        // (`basis`).
        unsafe {
            let own = known("basis", basis)?;
            let all = match &*own.functions {
                Functions::Eigen(_) => 0,
                Functions::Products(products) => products.products().len(),
            };
            tell!(n: own.basis().vertices(), r: own.basis().len(), products: all);
        }
        Ok(())
    })
}

/// Copies a basis, each part NULL where not wanted: `q`: n x r, its functions; `triangle`: r x
/// products, R; `kept`: r elements, ascending: the product, from 0, that each function comes
/// from. The last two are of products only.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_basis_copy(
    basis: *const cata_basis,
    layout: i32,
    q: *mut f64,
    ldq: usize,
    triangle: *mut f64,
    ldtriangle: usize,
    kept: *mut usize,
) -> cata_status {
    boundary(|| {
        let layout = Layout::new(layout)?;
        // SAFETY: clause `handles` (`basis`).
        let basis = unsafe { known("basis", basis) }?;
        let functions = basis.basis().functions();
        let (n, r) = functions.shape();
        let mut parts = Vec::new();
        // SAFETY: clause `memory` (`q`, n x r; `triangle`, r x `from.ncols()`; `kept`, `r`
        // elements).
        unsafe {
            if !q.is_null() {
                parts.push((matrix_mut("q", layout, n, r, q, ldq)?, functions));
            }
            if !triangle.is_null() {
                let from = basis.products("triangle")?.r();
                let to = matrix_mut("triangle", layout, r, from.ncols(), triangle, ldtriangle)?;
                parts.push((to, from));
            }
            if !kept.is_null() {
                let from = basis.products("kept")?.kept();
                slice_mut("kept", kept, r)?.copy_from_slice(from);
            }
        }
        parts.into_iter().for_each(|(mut to, from)| to.copy_from(from));
        Ok(())
    })
}

/// Computes the coefficients C (r x count) of the functions in the span that are nearest to the
/// columns of F (n x count).
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_basis_analysis(
    basis: *const cata_basis,
    layout: i32,
    count: usize,
    f: *const f64,
    ldf: usize,
    c: *mut f64,
    ldc: usize,
) -> cata_status {
    boundary(|| {
        let layout = Layout::new(layout)?;
        // SAFETY: clause `memory` (`f`, `basis.basis().vertices()` x `count`; `c`,
        // `basis.basis().len()` x `count`), clause `handles` (`basis`).
        let (basis, f, mut c) = unsafe {
            let basis = known("basis", basis)?;
            let f = matrix("f", layout, basis.basis().vertices(), count, f, ldf)?;
            (basis, f, matrix_mut("c", layout, basis.basis().len(), count, c, ldc)?)
        };
        c.copy_from(&basis.basis().analysis(f, basis.par)?);
        Ok(())
    })
}

/// Computes the functions F (n x count) with the coefficients C (r x count).
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_basis_synthesis(
    basis: *const cata_basis,
    layout: i32,
    count: usize,
    c: *const f64,
    ldc: usize,
    f: *mut f64,
    ldf: usize,
) -> cata_status {
    boundary(|| {
        let layout = Layout::new(layout)?;
        // SAFETY: clause `memory` (`c`, `basis.basis().len()` x `count`; `f`,
        // `basis.basis().vertices()` x `count`), clause `handles` (`basis`).
        let (basis, c, mut f) = unsafe {
            let basis = known("basis", basis)?;
            let c = matrix("c", layout, basis.basis().len(), count, c, ldc)?;
            (basis, c, matrix_mut("f", layout, basis.basis().vertices(), count, f, ldf)?)
        };
        f.copy_from(&basis.basis().synthesis(c, basis.par)?);
        Ok(())
    })
}

/// Computes G: the columns of F (both n x count) with their coefficients multiplied by `gains`, r
/// elements (exp(-t eigenvalue): what heat does in the time t), and what is outside of the span by
/// `rest`: 0 leaves it out, 1 keeps it.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_basis_filter(
    basis: *const cata_basis,
    layout: i32,
    count: usize,
    f: *const f64,
    ldf: usize,
    gains: *const f64,
    rest: f64,
    g: *mut f64,
    ldg: usize,
) -> cata_status {
    boundary(|| {
        let layout = Layout::new(layout)?;
        // SAFETY: clause `memory` (`f`, n x `count`; `gains`, `basis.basis().len()` elements; `g`,
        // n x `count`), clause `handles` (`basis`).
        let (basis, f, gains, mut g) = unsafe {
            let basis = known("basis", basis)?;
            let n = basis.basis().vertices();
            (
                basis,
                matrix("f", layout, n, count, f, ldf)?,
                slice("gains", gains, basis.basis().len())?,
                matrix_mut("g", layout, n, count, g, ldg)?,
            )
        };
        g.copy_from(&filter(basis.basis(), f, gains, rest, basis.par)?);
        Ok(())
    })
}

/// Adds `amount` times the function `index`, from 0, to the columns of F (n x count).
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_basis_add_coefficient(
    basis: *const cata_basis,
    index: usize,
    amount: f64,
    layout: i32,
    count: usize,
    f: *mut f64,
    ldf: usize,
) -> cata_status {
    boundary(|| {
        let layout = Layout::new(layout)?;
        // SAFETY: clause `memory` (`f`, `basis.basis().vertices()` x `count`), clause `handles`
        // (`basis`).
        let (basis, mut f) = unsafe {
            let basis = known("basis", basis)?;
            (basis, matrix_mut("f", layout, basis.basis().vertices(), count, f, ldf)?)
        };
        let sum = add_coefficient(basis.basis(), f.as_ref(), index, amount)?;
        f.copy_from(&sum);
        Ok(())
    })
}

/// Splits the columns of F into LOW + HIGH (all n x count): their part in the span, and the detail
/// that is left.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_basis_split(
    basis: *const cata_basis,
    layout: i32,
    count: usize,
    f: *const f64,
    ldf: usize,
    low: *mut f64,
    ldlow: usize,
    high: *mut f64,
    ldhigh: usize,
) -> cata_status {
    boundary(|| {
        let layout = Layout::new(layout)?;
        // SAFETY: clause `memory` (`f`, n x `count`; `low`, n x `count`; `high`, n x `count`),
        // clause `handles` (`basis`).
        let (basis, f, mut low, mut high) = unsafe {
            let basis = known("basis", basis)?;
            let n = basis.basis().vertices();
            (
                basis,
                matrix("f", layout, n, count, f, ldf)?,
                matrix_mut("low", layout, n, count, low, ldlow)?,
                matrix_mut("high", layout, n, count, high, ldhigh)?,
            )
        };
        let parts = split(basis.basis(), f, basis.par)?;
        low.copy_from(&parts.low);
        high.copy_from(&parts.high);
        Ok(())
    })
}

/// The options of the caller.
pub(super) struct BasisOptions<'a> {
    pub order: usize,
    pub method: i32,
    pub par: Par,
    pub progress: Progress<'a>,
}

impl BasisOptions<'_> {
    /// Returns the products of eigenfunctions.
    pub fn products(
        &self,
        eigen: &Eigenbasis,
        progress: Progress<'_>,
    ) -> Result<ProductBasis, Failure> {
        let orthogonalization = match self.method {
            CATA_ORTHO_REORTHOGONALIZED => Orthogonalization::Reorthogonalized,
            CATA_ORTHO_RANK_REVEALING => Orthogonalization::RankRevealing,
            _ => Orthogonalization::SinglePass,
        };
        let options = ProductBasisOptions::new()
            .orthogonalization(orthogonalization)
            .par(self.par)
            .progress(progress);
        Ok(ProductBasis::new(eigen, self.order, &options)?)
    }
}

/// Returns what `work` returns for the options of the caller.
///
/// # Safety
/// `params` is NULL or points to a struct as the header describes it.
pub(super) unsafe fn with_basis_options<X>(
    params: *const cata_basis_params,
    work: impl FnOnce(&BasisOptions<'_>) -> Result<X, Failure>,
) -> Result<X, Failure> {
    // SAFETY: clause `structs` (`params`).
    unsafe {
        with_params(params, |params, progress| {
            let order = or_default(params.order, 2);
            let method = known_method(params.method, CATA_ORTHO_SINGLE_PASS)?;
            work(&BasisOptions { order, method, par: params.par(), progress })
        })
    }
}
