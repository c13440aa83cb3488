//! Executors of a [`Plan`] on matrices, one for each strategy. They make no decisions.

mod balance;
mod fused;
mod product;
mod recursive;
mod tasks;

pub(crate) use product::Product;

use super::exact;
use super::options::AtaOptions;
use super::plan::{Exact, Op, Plan, Strategy};
use crate::base::{Par, Result};
use crate::blas::{BlasReal, Kernels, Native};

/// Returns the elements of scratch that [`execute`] needs.
pub(crate) fn scratch_len<T: BlasReal>(plan: &Plan, par: Par) -> usize {
    let problem = &plan.problem;
    match &plan.strategy {
        Strategy::Direct(_) => 0,
        Strategy::Fused(fused) => fused::scratch_len::<T>(fused, problem, par),
        Strategy::Tasks(tasks) => tasks::scratch_len(tasks, problem, par),
        Strategy::Exact(exact) => {
            let extents = [problem.m, problem.n, problem.k];
            match exact.small {
                true => exact::small::scratch_len::<T>(extents, exact.layout.same),
                false => exact::scratch_len::<T>(extents, &exact.layout, par.threads()),
            }
        }
    }
}

/// Computes `product`, of the shape that `plan` is for, in scratch of [`scratch_len`] elements with
/// any contents. Of the options only threads and their cores, back end and progress matter: the
/// rest is in the plan.
///
/// The path to a small product is inlined, because such a product takes no longer than a few calls;
/// the other executors are not inlined.
#[inline]
pub(crate) fn execute<T: BlasReal>(
    plan: &Plan,
    product: Product<'_, T>,
    options: &AtaOptions<'_>,
    scratch: &mut [T],
) -> Result<()> {
    of_lower(
        product,
        options,
        #[inline(always)]
        |product| match &plan.strategy {
            Strategy::Direct(_) => {
                direct(T::kernels(options.backend.as_ref()), plan.problem.op, product);
                options.progress.report(1.0)
            }
            Strategy::Fused(it) => {
                options.on_cores(|| fused::execute(it, &plan.problem, product, options, scratch))
            }
            Strategy::Tasks(it) => {
                options.on_cores(|| tasks::execute(it, &plan.problem, product, options, scratch))
            }
            Strategy::Exact(it) => exactly(it, product, options, scratch),
        },
    )
}

/// Computes a product whose plan would be [`Strategy::Direct`], without making the plan, on our own
/// kernels. Reports no progress.
#[inline(always)]
pub(crate) fn execute_direct<T: BlasReal>(
    native: &Native,
    op: Op,
    product: Product<'_, T>,
) -> Result<()> {
    if product.is_scaling() {
        return product.scale();
    }
    product.into_lower(
        #[inline(always)]
        |product| {
            direct(native, op, product);
            Ok(())
        },
    )
}

/// Calls `work` with the product for the lower triangle, unless it only scales C.
#[inline(always)]
fn of_lower<T: BlasReal>(
    product: Product<'_, T>,
    options: &AtaOptions<'_>,
    work: impl FnOnce(Product<'_, T>) -> Result<()>,
) -> Result<()> {
    if product.is_scaling() {
        product.scale()?;
        return options.progress.report(1.0);
    }
    product.into_lower(work)
}

#[inline(never)]
fn exactly<T: BlasReal>(
    plan: &Exact,
    product: Product<'_, T>,
    options: &AtaOptions<'_>,
    scratch: &mut [T],
) -> Result<()> {
    let Product { alpha, a, b, beta, c, .. } = product;
    if plan.small {
        let (moduli, symmetric) = (plan.layout.moduli, plan.layout.symmetric);
        let kernel = plan.isa.kernel();
        return exact::small::execute(
            kernel, moduli, symmetric, alpha, a, b, beta, c, options, scratch,
        );
    }
    options.on_cores(|| {
        exact::execute(plan.isa.kernel(), &plan.layout, alpha, a, b, beta, c, options, scratch)
    })
}

/// Computes one product on the calling thread.
#[inline(always)]
fn direct<T: BlasReal>(kernels: &dyn Kernels<T>, op: Op, product: Product<'_, T>) {
    let right = product.b.unwrap_or(product.a);
    let Product { alpha, a, beta, c, .. } = product;
    match op {
        Op::Syrk => kernels.syrk(alpha, a, beta, c),
        Op::Gemmt => kernels.gemmt(alpha, a, right, beta, c),
        Op::Gemm => kernels.gemm(alpha, a, right, beta, c),
    }
}
