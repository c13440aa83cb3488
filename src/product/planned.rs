//! Products by a plan that the caller has made, once for many products of one shape, in scratch
//! that the caller may keep.

use faer::prelude::Reborrow;
use faer::{MatMut, MatRef};

use super::execute::{Product, execute, scratch_len};
use super::options::{AtaOptions, Uplo};
use super::plan::{Op, Plan};
use crate::base::{Error, Par, Result, Scratch};
use crate::blas::BlasReal;

/// Computes [`ata_into`](super::ata_into) by a plan of [`Plan::ata`] for the shape of A, in
/// `scratch` of at least [`Plan::scratch_len`] elements with any contents; `None` allocates it.
///
/// Of the options only triangle, threads, pinning, back end and progress matter: the rest is in the
/// plan.
///
/// ```
/// use catamaran::{AtaOptions, Plan, product::ata_planned, faer::Mat};
///
/// let options = AtaOptions::new();
/// let plan = Plan::ata::<f64>(300, 200, &options)?;
/// let mut scratch = vec![f64::NAN; plan.scratch_len::<f64>(options.par)];
/// let mut c = Mat::zeros(200, 200);
/// for a in [Mat::<f64>::ones(300, 200), Mat::full(300, 200, 2.0)] {
///     ata_planned(&plan, 1.0, a.as_ref(), 1.0, c.as_mut(), &options, Some(&mut scratch))?;
/// }
/// assert_eq!(c[(199, 0)], 1500.0);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Argument`] for a plan of another product or scalar, [`Error::Shape`] for one of another
/// shape, and when the scratch is short; else as [`ata_into`](super::ata_into).
pub fn ata_planned<T: BlasReal>(
    plan: &Plan,
    alpha: T,
    a: MatRef<'_, T>,
    beta: T,
    c: MatMut<'_, T>,
    options: &AtaOptions<'_>,
    scratch: Option<&mut [T]>,
) -> Result<()> {
    if plan.problem.op != Op::Syrk {
        return Err(of_another("A^T A"));
    }
    check::<T>(plan, a, a, c.rb())?;
    run(plan, Product { alpha, a, b: None, beta, c, uplo: Some(options.uplo) }, options, scratch)
}

/// Computes [`atb_into`](super::atb_into) by a plan of [`Plan::atb`] for the shapes of A and B, or
/// the triangle `options.uplo` of `C := alpha A^T B + beta C` by a plan of [`Plan::atb_triangle`].
/// Scratch as in [`ata_planned`].
///
/// Of the options only triangle, threads, pinning, back end and progress matter: the rest is in the
/// plan.
///
/// ```
/// use catamaran::{AtaOptions, Plan, Uplo, product::atb_planned, faer::mat};
///
/// let options = AtaOptions::new().uplo(Uplo::Upper);
/// let plan = Plan::atb_triangle::<f64>(1, 2, &options)?;
/// let (a, b) = (mat![[1.0, 2.0]], mat![[3.0, 4.0]]);
/// let mut c = mat![[0.0, 0.0], [7.0, 0.0]];
/// atb_planned(&plan, 1.0, a.as_ref(), b.as_ref(), 0.0, c.as_mut(), &options, None)?;
/// assert_eq!(c, mat![[3.0, 4.0], [7.0, 8.0]]);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Argument`] for a plan of another product or scalar, or [`Uplo::Both`] of a triangle;
/// [`Error::Shape`] for a plan of another shape, and when the scratch is short; else as
/// [`atb_into`](super::atb_into).
pub fn atb_planned<T: BlasReal>(
    plan: &Plan,
    alpha: T,
    a: MatRef<'_, T>,
    b: MatRef<'_, T>,
    beta: T,
    c: MatMut<'_, T>,
    options: &AtaOptions<'_>,
    scratch: Option<&mut [T]>,
) -> Result<()> {
    check::<T>(plan, a, b, c.rb())?;
    let product = match (plan.problem.op, options.uplo) {
        (Op::Syrk, _) => return Err(of_another("A^T B")),
        (Op::Gemm, _) => Product { alpha, a, b: Some(b), beta, c, uplo: None },
        (Op::Gemmt, Uplo::Lower) => {
            Product { alpha, a, b: Some(b), beta, c, uplo: Some(Uplo::Lower) }
        }
        // The lower triangle of the transposed product.
        (Op::Gemmt, Uplo::Upper) => {
            Product { alpha, a: b, b: Some(a), beta, c: c.transpose_mut(), uplo: Some(Uplo::Lower) }
        }
        (Op::Gemmt, Uplo::Both) => {
            let why = "must be lower or upper for one triangle of A^T B".into();
            return Err(Error::Argument { what: "uplo", why });
        }
    };
    run(plan, product, options, scratch)
}

impl Plan {
    /// Returns the elements of scratch that a product by this plan takes on so many threads.
    ///
    /// ```
    /// use catamaran::{AtaOptions, Par, Plan};
    ///
    /// let plan = Plan::ata::<f64>(3000, 2000, &AtaOptions::new().memory(32 << 20))?;
    /// assert!(plan.scratch_len::<f64>(Par::Threads(2)) * 8 <= 32 << 20);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    pub fn scratch_len<T: BlasReal>(&self, par: Par) -> usize {
        scratch_len::<T>(self, par)
    }
}

/// Returns the error for a plan of another product or scalar than `wanted`.
pub(super) fn of_another(wanted: &str) -> Error {
    Error::Argument { what: "plan", why: format!("is not a plan of {wanted}") }
}

fn check<T: BlasReal>(
    plan: &Plan,
    a: MatRef<'_, T>,
    b: MatRef<'_, T>,
    c: MatRef<'_, T>,
) -> Result<()> {
    let problem = &plan.problem;
    if !plan.is_of::<T>() {
        return Err(of_another(T::NAME));
    }
    Error::check_shape("A", (problem.m, problem.n), a.shape())?;
    Error::check_shape("B", (problem.m, problem.k), b.shape())?;
    Error::check_shape("C", (problem.n, problem.k), c.shape())
}

/// Executes a plan in `scratch`, or in scratch that it allocates.
pub(super) fn run<T: BlasReal>(
    plan: &Plan,
    product: Product<'_, T>,
    options: &AtaOptions<'_>,
    scratch: Option<&mut [T]>,
) -> Result<()> {
    let len = scratch_len::<T>(plan, options.par);
    let mut own;
    let scratch: &mut [T] = match scratch {
        Some(short) if short.len() < len => {
            return Err(Error::Shape {
                what: "scratch",
                expected: (len, 1),
                got: (short.len(), 1),
            });
        }
        Some(scratch) => scratch,
        None if len == 0 => &mut [],
        None => {
            own = Scratch::new::<T>(len)?;
            own.as_mut_slice()
        }
    };
    execute(plan, product, options, scratch)
}
