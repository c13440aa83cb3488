use crate::base::{Error, Par, Progress, Result, options};

options! {
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
    pub struct EigenOptions<'a> {
        /// Number of eigenpairs.
        k: usize = 100, range "at most the number of rows";
        /// The k eigenvalues nearest to this number, which may be an eigenvalue; `None`: the k
        /// smallest.
        shift: Option<f64> = None, range "finite", setter into;
        /// Largest residual of a pair (as [`Eigenpairs::residuals`](super::Eigenpairs::residuals)
        /// defines it). Where a few roundings of the vector alone exceed it (`eps | |W| |phi| |`:
        /// huge weights), residuals of that size are accepted. Problems of few rows are solved as
        /// dense ones, as accurately as rounding allows.
        /// [`Eigenpairs::worst`](super::Eigenpairs::worst) returns the largest residual.
        tolerance: f64 = 1e-9, range "from 1e-14 to 1e-2";
        /// Counts the eigenvalues by the inertia of other factorizations (Sylvester), and
        /// continues until none is missing: below the last gap of the result or, with a shift,
        /// nearer to it than the farthest value of the result.
        verify_count: bool = false;
        /// Threads. Their number does not change the result.
        par: Par = Par::all();
        /// Seed of the starting block.
        seed: u64 = 0;
        /// Restarts after which [`Error::NotConverged`] is returned.
        max_restarts: usize = 60;
        /// Progress callback, which may cancel.
        progress: Progress<'a> = Progress::none(), setter into;
    }
}

impl EigenOptions<'_> {
    /// Checks the options for a matrix of `n` rows.
    pub(crate) fn check(&self, n: usize) -> Result<()> {
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
