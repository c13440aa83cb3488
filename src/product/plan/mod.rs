//! Plans, as data: shapes and counts, without threads or matrices. The plan that is printed is the
//! object that [`execute`](super::execute()) runs.

mod choose;
mod cost;
mod explain;
mod fused;
mod problem;
mod recursion;
mod scratch;
mod strategy;
mod tree;

pub(crate) use choose::direct_kernels;
pub(crate) use fused::{FusedProduct, SignedBlock};
pub(crate) use problem::{Op, Problem};
#[cfg(test)]
pub(crate) use recursion::Base;
pub(crate) use recursion::Recursion;
#[cfg(test)]
pub(crate) use scratch::scratch_len;
pub(crate) use scratch::{Extent, LevelScratch, cheapest_update, leading};
pub(crate) use strategy::{Exact, Fused, Slab, Strategy, Tasks};
pub(crate) use tree::rectangle_levels;
pub use tree::{Node, Task, thread_levels};

use super::options::AtaOptions;
use crate::base::Result;
use crate::blas::BlasReal;

/// A plan for `C := alpha A^T A + beta C` or `C := alpha A^T B + beta C`.
///
/// It depends on the shape, the precision and the options, but never on the number of threads, so
/// the result does not depend on that either. What is printed is what runs.
///
/// ```
/// use catamaran::{AtaOptions, Plan};
///
/// let plan = Plan::ata::<f64>(100_000, 500, &AtaOptions::new())?;
/// assert!(plan.to_string().starts_with("C = A^T A, A 100000 x 500, f64"));
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    pub(crate) problem: Problem,
    pub(crate) strategy: Strategy,
    scalar: &'static str,
    /// Expected seconds on one core, and those of classical products in floating point.
    seconds: f64,
    classical_seconds: f64,
}

impl Plan {
    /// Plans [`ata_into`](super::ata_into) for A m x n.
    ///
    /// ```
    /// use catamaran::{AtaOptions, Plan};
    ///
    /// // The plan does not depend on the number of threads.
    /// let plan = |threads| Plan::ata::<f64>(5000, 1000, &AtaOptions::new().threads(threads));
    /// assert_eq!(plan(1)?, plan(8)?);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Argument`](crate::Error::Argument) for options out of range,
    /// [`Error::OutOfMemory`](crate::Error::OutOfMemory) for matrices that no memory holds.
    pub fn ata<T: BlasReal>(m: usize, n: usize, options: &AtaOptions<'_>) -> Result<Self> {
        Self::new::<T>(Op::Syrk, m, n, n, options)
    }

    /// Plans [`atb_into`](super::atb_into) for A m x n and B m x k.
    ///
    /// ```
    /// use catamaran::{AtaOptions, Plan, product::atb_planned, faer::mat};
    ///
    /// let options = AtaOptions::new();
    /// let plan = Plan::atb::<f64>(2, 2, 1, &options)?;
    /// let (a, b, mut c) = (mat![[1.0, 2.0], [3.0, 4.0]], mat![[1.0], [10.0]], mat![[0.0], [0.0]]);
    /// atb_planned(&plan, 1.0, a.as_ref(), b.as_ref(), 0.0, c.as_mut(), &options, None)?;
    /// assert_eq!(c, mat![[31.0], [42.0]]);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Plan::ata`].
    pub fn atb<T: BlasReal>(
        m: usize,
        n: usize,
        k: usize,
        options: &AtaOptions<'_>,
    ) -> Result<Self> {
        Self::new::<T>(Op::Gemm, m, n, k, options)
    }

    /// Plans [`atb_planned`](super::atb_planned) for one triangle of A^T B, where A and B are
    /// m x n.
    ///
    /// # Errors
    /// As [`Plan::ata`].
    pub fn atb_triangle<T: BlasReal>(m: usize, n: usize, options: &AtaOptions<'_>) -> Result<Self> {
        Self::new::<T>(Op::Gemmt, m, n, n, options)
    }

    /// Creates the plan for `op` with A m x n and B m x k.
    pub(crate) fn new<T: BlasReal>(
        op: Op,
        m: usize,
        n: usize,
        k: usize,
        options: &AtaOptions<'_>,
    ) -> Result<Self> {
        options.check()?;
        let problem = Problem::new(op, m, n, k)?;
        let choose::Choice { strategy, seconds, classical_seconds } =
            choose::choose::<T>(problem, options);
        Ok(Self { problem, strategy, scalar: T::NAME, seconds, classical_seconds })
    }

    /// Returns whether the plan is for matrices of T.
    pub(crate) fn is_of<T: BlasReal>(&self) -> bool {
        self.scalar == T::NAME
    }

    /// Returns the expected seconds on one core over those of a plan without fast levels and exact
    /// products: at most 1 where the planner chose freely.
    pub fn expected_ratio(&self) -> f64 {
        if self.classical_seconds > 0.0 { self.seconds / self.classical_seconds } else { 1.0 }
    }

    /// Returns whether the plan takes the exact path, which returns the same bytes on every
    /// machine.
    pub fn is_exact(&self) -> bool {
        matches!(self.strategy, Strategy::Exact(_))
    }

    /// Returns whether the calling thread computes all of the product, however many threads there
    /// are: it ends before they could share it.
    pub fn is_direct(&self) -> bool {
        matches!(self.strategy, Strategy::Direct(_))
    }

    /// Returns whether some product is computed with fewer multiplications than the classical
    /// count. At run time the norms of the columns may still forbid that.
    ///
    /// ```
    /// use catamaran::{AtaOptions, Plan, SchemeChoice};
    ///
    /// let is_fast = |scheme| {
    ///     let options = AtaOptions::new().scheme(scheme).leaf(64);
    ///     Ok::<_, catamaran::Error>(Plan::ata::<f64>(1000, 1000, &options)?.is_fast())
    /// };
    /// assert!(is_fast(SchemeChoice::Winograd)? && !is_fast(SchemeChoice::Classical)?);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    pub fn is_fast(&self) -> bool {
        match &self.strategy {
            Strategy::Fused(fused) => fused.is_fast(),
            Strategy::Tasks(tasks) => tasks.fast,
            Strategy::Direct(_) | Strategy::Exact(_) => false,
        }
    }
}

#[cfg(test)]
mod tests;
