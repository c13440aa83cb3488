//! The condition number of A, from its triangular factor.

use faer::Mat;

use super::cholesky::PivotedCholesky;
use super::double::scaled;
use crate::base::{Result, Rng};
use crate::dense::{lower_solve_in_place, upper_solve_in_place};

/// Steps of the power method; each costs two solves.
const STEPS: usize = 16;

impl PivotedCholesky {
    /// Returns an estimate of the condition number of A in the 2-norm: that of the columns that do
    /// not depend on others, `|R| |R^-1|`; 1 if there are none.
    ///
    /// Both norms come from 16 steps of the power method with `R^T R` and its inverse in f64, from
    /// a seeded random vector: they are lower bounds, too small by a few percent as a rule.
    ///
    /// ```
    /// use catamaran::rows::ExtendedGram;
    /// use catamaran::solve::{PivotedCholesky, Pivoting};
    /// use catamaran::{Par, faer::mat};
    ///
    /// // Orthogonal columns of norms 1 and 1/1000.
    /// let gram = ExtendedGram::from_f64(mat![[1.0, 0.0], [0.0, 1e-6]].as_ref(), 2, &[])?;
    /// let factor = PivotedCholesky::from_gram(&gram, Pivoting::Scaled, Par::Seq)?;
    /// assert!((factor.condition()? / 1000.0 - 1.0).abs() < 0.05);
    /// assert!(factor.scaled_condition()? < 1.1);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::OutOfMemory`](crate::Error::OutOfMemory).
    pub fn condition(&self) -> Result<f64> {
        let largest = self.order[..self.rank].iter().map(|&j| self.exponents[j]).max();
        let largest = largest.unwrap_or(0);
        self.estimate(|j| self.exponents[j].saturating_sub(largest))
    }

    /// Returns the condition number of A with columns scaled by powers of two to norms between 1
    /// and 2: at most about sqrt(n) times the least one of all column scalings (van der Sluis
    /// 1969). The accuracy of solutions depends on this number.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`](crate::Error::OutOfMemory).
    pub fn scaled_condition(&self) -> Result<f64> {
        self.estimate(|_| 0)
    }

    fn estimate(&self, exponent: impl Fn(usize) -> i32) -> Result<f64> {
        let n = self.rank;
        if n == 0 {
            return Ok(1.0);
        }
        let mut lower = crate::dense::zeros(n, n)?;
        for j in 0..n {
            for i in j..n {
                lower[(i, j)] = scaled(self.lower.get(i, j)[0], exponent(self.order[i]));
            }
        }
        let mut rng = Rng::new(n as u64);
        let start = Mat::from_fn(n, 1, |_, _| rng.normal());
        let mut norms = [0.0_f64; 2];
        for (inverse, norm) in norms.iter_mut().enumerate() {
            let mut x = start.clone();
            for _ in 0..STEPS {
                let length = x.norm_l2();
                if length == 0.0 || !length.is_finite() {
                    break;
                }
                x.col_mut(0).iter_mut().for_each(|x| *x /= length);
                // Half a step yields the norm of R^-T x or R x, the whole one the next vector.
                if inverse == 1 {
                    lower_solve_in_place(lower.as_ref(), x.as_mut());
                    *norm = norm.max(x.norm_l2());
                    upper_solve_in_place(lower.transpose(), x.as_mut());
                } else {
                    x = lower.transpose() * &x;
                    *norm = norm.max(x.norm_l2());
                    x = &lower * &x;
                }
            }
        }
        Ok((norms[0] * norms[1]).max(1.0))
    }
}
