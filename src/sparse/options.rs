use crate::base::{Error, Par, Progress, Result, builder};

/// Options of [`eigs`](super::eigs()).
///
/// ```
/// use catamaran::sparse::{CsMat, EigenOptions, Mass, eigs};
///
/// // The eigenvalue of diag(1, 2, 4) nearest to 2.2.
/// let w = CsMat::new((3, 3), vec![0, 1, 2, 3], vec![0, 1, 2], vec![1.0, 2.0, 4.0]);
/// let options = EigenOptions::new().k(1).shift(2.2);
/// let pairs = eigs(w.view(), &Mass::identity(3), &options)?;
/// assert!((pairs.values[0] - 2.0).abs() < 1e-12);
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct EigenOptions<'a> {
    /// Number of eigenpairs, at most the number of rows. Default 100.
    pub k: usize,
    /// The k eigenvalues nearest to this number, which may be an eigenvalue; `None` (default): the
    /// k smallest.
    pub shift: Option<f64>,
    /// Largest residual of a pair (as [`Eigenpairs::residuals`](super::Eigenpairs::residuals)
    /// defines it), between 1e-14 and 1e-2; default 1e-9. Where a few roundings of the vector alone
    /// exceed it (`eps | |W| |phi| |`: huge weights), residuals of that size are accepted. Problems
    /// of few rows are solved as dense ones, as accurately as rounding allows.
    /// [`Eigenpairs::worst`](super::Eigenpairs::worst) returns the largest residual.
    pub tolerance: f64,
    /// Counts the eigenvalues by the inertia of other factorizations (Sylvester), and continues
    /// until none is missing: below the last gap of the result or, with a shift, nearer to it than
    /// the farthest value of the result. Default false.
    pub verify_count: bool,
    /// Threads; default [`Par::all`]. Does not change the result.
    pub par: Par,
    /// Seed of the starting block. Default 0.
    pub seed: u64,
    /// Restarts after which [`Error::NotConverged`] is returned; default 60.
    pub max_restarts: usize,
    /// Progress callback, which may cancel.
    pub progress: Progress<'a>,
}

impl Default for EigenOptions<'_> {
    fn default() -> Self {
        Self {
            k: 100,
            shift: None,
            tolerance: 1e-9,
            verify_count: false,
            par: Par::all(),
            seed: 0,
            max_restarts: 60,
            progress: Progress::none(),
        }
    }
}

builder! { EigenOptions<'a> {
    k: usize,
    #[into] shift: Option<f64>,
    tolerance: f64,
    verify_count: bool,
    par: Par,
    seed: u64,
    max_restarts: usize,
    #[into] progress: Progress<'a>,
}}

impl EigenOptions<'_> {
    /// Checks the options for a matrix of `n` rows.
    pub(super) fn check(&self, n: usize) -> Result<()> {
        let refuse = |what, why: String| Err(Error::Argument { what, why });
        if self.k > n {
            return refuse("k", format!("{} eigenpairs of a matrix of {n} rows", self.k));
        }
        if !(1e-14..=1e-2).contains(&self.tolerance) {
            return refuse(
                "tolerance",
                format!("{:e} is not between 1e-14 and 1e-2", self.tolerance),
            );
        }
        match self.shift {
            Some(shift) if !shift.is_finite() => refuse("shift", format!("{shift} is not finite")),
            _ => Ok(()),
        }
    }
}
