use std::ops::ControlFlow;

use faer::{MatMut, MatRef};

use crate::base::{Disjoint, Error, Par, Result, zeros};

/// A symmetric matrix C (n x n) in extended precision: every entry is an unevaluated sum of three
/// f64, the largest first, each at most half a unit in the last place of the one before.
///
/// The first two parts are C in double-double, about 106 bits; all three hold 159 bits.
/// `Accumulator::extended` computes C from rows.
#[derive(Debug, Clone)]
pub struct ExtendedGram {
    n: usize,
    /// Lower triangles by columns (n x n); zero above the diagonal.
    parts: [Vec<f64>; 3],
    about: About,
}

/// What is known of the rows that the matrix is made of.
#[derive(Debug, Clone)]
pub(crate) struct About {
    /// Whether no entry of the rows was rounded.
    pub exact: bool,
    pub rows: u64,
    /// Sum of the weights.
    pub weight: f64,
    /// Means of the columns; none unless the matrix is about them.
    pub mean: Vec<[f64; 2]>,
}

impl ExtendedGram {
    /// A matrix with these entries of its lower triangle, `entry(i, j)` for `j <= i`.
    pub(crate) fn from_entries(
        n: usize,
        about: About,
        par: Par,
        entry: impl Fn(usize, usize) -> [f64; 3] + Sync,
    ) -> Result<Self> {
        /// Side of a tile: its rows and columns stay in the first-level cache.
        const TILE: usize = 16;
        let len = n.saturating_mul(n);
        let mut parts = [zeros(len)?, zeros(len)?, zeros(len)?];
        let shared = parts
            .each_mut()
            .map(|part| Disjoint::new(MatMut::from_column_major_slice_mut(part, n, n)));
        par.tickets(n.div_ceil(TILE), |ticket| {
            let columns = ticket * TILE..n.min((ticket + 1) * TILE);
            // SAFETY: each range of columns is visited once.
            let mut own =
                shared.each_ref().map(|part| unsafe { part.block(0..n, columns.clone()) });
            for first in (columns.start..n).step_by(TILE) {
                for j in columns.clone() {
                    for i in first.max(j)..n.min(first + TILE) {
                        for (part, value) in own.iter_mut().zip(entry(i, j)) {
                            part[(i, j - columns.start)] = value;
                        }
                    }
                }
            }
            ControlFlow::Continue(())
        });
        Ok(Self { n, parts, about })
    }

    /// Returns the Gram matrix C (n x n) of `rows` rows whose lower triangle is exact as it is,
    /// with the means of the n columns if C is about them, or none.
    ///
    /// ```
    /// use catamaran::{ata::ExtendedGram, faer::mat};
    ///
    /// let gram = ExtendedGram::from_f64(mat![[5.0, 0.0], [3.0, 2.0]].as_ref(), 2, &[])?;
    /// assert_eq!(gram.entry(0, 1), [3.0, 0.0, 0.0]);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Shape`] when C is not square or the means are not n, [`Error::OutOfMemory`].
    pub fn from_f64(c: MatRef<'_, f64>, rows: u64, mean: &[f64]) -> Result<Self> {
        let n = c.nrows();
        Error::check_shape("C", (n, n), c.shape())?;
        if !mean.is_empty() {
            Error::check_shape("mean", (n, 1), (mean.len(), 1))?;
        }
        let mean = mean.iter().map(|&mean| [mean, 0.0]).collect();
        let about = About { exact: true, rows, weight: rows as f64, mean };
        Self::from_entries(n, about, Par::Seq, |i, j| [c[(i, j)], 0.0, 0.0])
    }

    /// Side n of C.
    pub fn n(&self) -> usize {
        self.n
    }

    /// Entry (i, j), in three parts.
    pub fn entry(&self, i: usize, j: usize) -> [f64; 3] {
        assert!(i < self.n && j < self.n, "({i}, {j}) of {0} x {0} entries", self.n);
        let at = i.max(j) + i.min(j) * self.n;
        self.parts.each_ref().map(|part| part[at])
    }

    /// Part 0, 1 or 2 of all entries: the lower triangle, zero above the diagonal. Part 0 is C
    /// rounded to f64.
    ///
    /// # Panics
    /// When there is no such part.
    pub fn part(&self, part: usize) -> MatRef<'_, f64> {
        MatRef::from_column_major_slice(&self.parts[part], self.n, self.n)
    }

    /// Whether the sums are exact: no entry of the rows was rounded. C itself is then rounded once,
    /// to 159 bits.
    pub fn is_exact(&self) -> bool {
        self.about.exact
    }

    /// Rows that C is the sum of.
    pub fn rows(&self) -> u64 {
        self.about.rows
    }

    /// Sum of the weights of the rows; their number without weights.
    pub fn weight(&self) -> f64 {
        self.about.weight
    }

    /// The (weighted) mean of each column in double-double, 0 for no rows; empty unless C is about the
    /// mean.
    pub fn mean(&self) -> &[[f64; 2]] {
        &self.about.mean
    }
}
