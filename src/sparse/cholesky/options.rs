use crate::base::{Error, Par, Progress, Result, options, repeated};

/// Which triangle of a symmetric matrix is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Triangle {
    /// The lower one: entries (i, j) with `i >= j`. Entries above the diagonal are ignored.
    Lower,
    /// The upper one. Entries below the diagonal are ignored.
    Upper,
    /// Both, which are checked to agree up to rounding.
    Both,
}

options! {
    /// Options of [`Cholesky`](super::Cholesky).
    ///
    /// ```
    /// use catamaran::faer::mat;
    /// use catamaran::sparse::{Cholesky, CholeskyOptions, CsMat, Triangle};
    ///
    /// // The Laplacian of an edge, its upper triangle by rows. One of the rows is held at zero.
    /// let w = CsMat::new((2, 2), vec![0, 2, 3], vec![0, 1, 1], vec![1.0, -1.0, 1.0]);
    /// let options = CholeskyOptions::new().triangle(Triangle::Upper).semidefinite(true);
    /// let cholesky = Cholesky::new(w.view(), &options)?;
    /// let x = cholesky.solve(mat![[3.0], [-3.0]].as_ref())?;
    /// assert_eq!((cholesky.held().len(), x[(0, 0)] - x[(1, 0)]), (1, 3.0));
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    #[derive(Debug, Clone)]
    pub struct CholeskyOptions<'a> {
        /// Which triangle of the matrix is read.
        triangle: Triangle = Triangle::Both;
        /// Whether pivots may be zero up to rounding. The rows of such pivots are held: their
        /// unknowns are 0, and their equations follow from the others if there is a solution.
        semidefinite: bool = false;
        /// Largest pivot that is zero, relative to the diagonal entry of its row. `None`: 8 n eps
        /// for semidefinite matrices of n rows, 0 for definite ones.
        tolerance: Option<f64> = None, range "from 0 to 0.01", setter into;
        /// The rows in the order of elimination, as that of METIS or Scotch: row `order[0]` is the
        /// first. `None`: approximate minimum degree, from 100,000 rows on after nested dissection
        /// (docs/decisions/0007).
        order: Option<&'a [usize]> = None, range "every row once", setter into;
        /// Threads of solutions, and of large supernodes of factorizations. Their number does not
        /// change the result.
        par: Par = Par::all();
        /// Progress callback of [`Cholesky::new`](super::Cholesky::new) and
        /// [`Cholesky::analyse`](super::Cholesky::analyse), which may cancel.
        progress: Progress<'a> = Progress::none(), setter into;
    }
}

impl CholeskyOptions<'_> {
    /// Checks that the order has each of `n` rows once.
    pub(super) fn check_order(&self, n: usize) -> Result<()> {
        let Some(order) = self.order else { return Ok(()) };
        Error::check_shape("order", (n, 1), (order.len(), 1))?;
        let mut is_there = repeated(false, n)?;
        for (i, &row) in order.iter().enumerate() {
            if row >= n || std::mem::replace(&mut is_there[row], true) {
                let why = format!("must have every row once, but entry {i} is {row}");
                return Err(Error::Argument { what: "order", why });
            }
        }
        Ok(())
    }

    /// Returns the tolerance for a matrix of `n` rows.
    pub(super) fn tolerance_for(&self, n: usize) -> Result<f64> {
        let usual = if self.semidefinite { (8.0 * n as f64 * f64::EPSILON).min(0.01) } else { 0.0 };
        let tolerance = self.tolerance.unwrap_or(usual);
        if (0.0..=0.01).contains(&tolerance) {
            return Ok(tolerance);
        }
        let why = format!("must be from 0 to 0.01, is {tolerance:e}");
        Err(Error::Argument { what: "tolerance", why })
    }
}
