use faer::MatRef;

use crate::base::{Error, Par, Result, triangle_len, triangle_rows, widest, zeros};
use crate::kernel::int8::I256;

/// A symmetric matrix C (n x n) in extended precision: every entry is an unevaluated sum of three
/// f64, the largest first, each at most half a unit in the last place of the one before.
///
/// The first two parts are C in double-double, about 106 bits; all three hold 159 bits.
/// `Accumulator::extended` computes C from rows.
///
/// ```
/// use catamaran::rows::{DenseRows, RowOptions, ata_extended};
/// use catamaran::{AtaOptions, faer::mat};
///
/// // 1 + 2^-60 has more bits than an f64.
/// let a = mat![[1.0], [2f64.powi(-30)]];
/// let (plain, options) = (RowOptions::<f64>::new(), AtaOptions::new());
/// let gram = ata_extended(&mut DenseRows(a.as_ref()), &plain, &options)?;
/// assert_eq!(gram.entry(0, 0), [1.0, 2f64.powi(-60), 0.0]);
/// assert!(gram.is_exact());
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct ExtendedGram {
    n: usize,
    /// The rows of the lower triangle, one after another. The bits of the parts of each entry take
    /// the place of its integer, so that no memory is needed beside the sums.
    entries: Vec<I256>,
    about: About,
}

/// Properties of the rows that the matrix is made of.
#[derive(Debug, Clone)]
pub(crate) struct About {
    /// Whether no entry of the rows was rounded.
    pub exact: bool,
    pub rows: u64,
    /// Rows whose weight is not 0.
    pub observations: u64,
    /// Sum of the weights.
    pub weight: f64,
    /// Means of the columns; none unless the matrix is about them.
    pub mean: Vec<[f64; 2]>,
    /// Columns that are not zero, but whose squared length rounds to 0; ascending.
    pub vanished: Vec<usize>,
}

impl ExtendedGram {
    /// Creates a matrix (n x n) of sums, the rows of the lower triangle one after another: entry
    /// (i, j), for `j <= i`, is `parts(i, j, sum)`.
    pub(crate) fn from_sums(
        n: usize,
        mut sums: Vec<I256>,
        about: About,
        par: Par,
        parts: impl Fn(usize, usize, I256) -> [f64; 3] + Sync,
    ) -> Self {
        /// Entries that keep one thread busy for less time than another takes to wake up.
        const SMALL: usize = 1 << 12;
        let par = if sums.len() < SMALL { Par::Seq } else { par };
        par.for_each(triangle_rows(&mut sums, 0..n), |_, (i, row)| {
            widest(
                #[inline(always)]
                || {
                    for (j, entry) in row.iter_mut().enumerate() {
                        *entry = packed(parts(i, j, *entry));
                    }
                },
            );
        });
        Self { n, entries: sums, about }
    }

    /// Creates a matrix with these entries of its lower triangle, `entry(i, j)` for `j <= i`.
    pub(crate) fn from_entries(
        n: usize,
        about: About,
        par: Par,
        entry: impl Fn(usize, usize) -> [f64; 3] + Sync,
    ) -> Result<Self> {
        let sums = zeros(triangle_len(n))?;
        Ok(Self::from_sums(n, sums, about, par, |i, j, _| entry(i, j)))
    }

    /// Returns the Gram matrix C (n x n) of `rows` rows whose lower triangle is exact as it is,
    /// with the means of the n columns if C is about them, or none.
    ///
    /// ```
    /// use catamaran::{rows::ExtendedGram, faer::mat};
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
        let about = About {
            exact: true,
            rows,
            observations: rows,
            weight: rows as f64,
            mean,
            vanished: Vec::new(),
        };
        Self::from_entries(n, about, Par::Seq, |i, j| [c[(i, j)], 0.0, 0.0])
    }

    /// Returns the number n of rows, and of columns, of C.
    pub fn n(&self) -> usize {
        self.n
    }

    /// Returns entry (i, j) in three parts, the largest first.
    pub fn entry(&self, i: usize, j: usize) -> [f64; 3] {
        assert!(i < self.n && j < self.n, "({i}, {j}) of {0} x {0} entries", self.n);
        unpacked(self.entries[triangle_len(i.max(j)) + i.min(j)])
    }

    /// Returns whether the sums are exact, so that no entry of the rows was rounded. C itself is
    /// then rounded once, to 159 bits.
    pub fn is_exact(&self) -> bool {
        self.about.exact
    }

    /// Returns the number of rows that C is the sum of.
    pub fn rows(&self) -> u64 {
        self.about.rows
    }

    /// Returns the number of rows whose weight is not 0: those that least squares count.
    ///
    /// ```
    /// use catamaran::rows::{DenseRows, RowOptions, ata_extended};
    /// use catamaran::{AtaOptions, faer::mat};
    ///
    /// let a = mat![[1.0], [2.0], [3.0]];
    /// let weighted = RowOptions::new().weights(&[1.0, 0.0, 2.0][..]);
    /// let gram = ata_extended(&mut DenseRows(a.as_ref()), &weighted, &AtaOptions::new())?;
    /// assert_eq!((gram.rows(), gram.observations(), gram.weight()), (3, 2, 3.0));
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    pub fn observations(&self) -> u64 {
        self.about.observations
    }

    /// Returns the sum of the weights of the rows; without weights, their number.
    pub fn weight(&self) -> f64 {
        self.about.weight
    }

    /// Returns the (weighted) mean of each column in double-double, 0 for no rows; empty unless C
    /// is about the mean.
    pub fn mean(&self) -> &[[f64; 2]] {
        &self.about.mean
    }

    /// Returns the columns, ascending, of which parts of the squared length are out of the range of
    /// f64: those that are not zero but shorter than 2^-450, and those whose square overflows. The
    /// functions of the module [`solve`](crate::solve) refuse them.
    ///
    /// ```
    /// use catamaran::rows::{DenseRows, RowOptions, ata_extended};
    /// use catamaran::{AtaOptions, faer::mat};
    ///
    /// let a = mat![[1e-200, 1.0, 0.0, 1e170]];
    /// let (plain, options) = (RowOptions::<f64>::new(), AtaOptions::new());
    /// let gram = ata_extended(&mut DenseRows(a.as_ref()), &plain, &options)?;
    /// assert_eq!(gram.out_of_range(), [0, 3]);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    pub fn out_of_range(&self) -> Vec<usize> {
        /// A squared length from which on all three parts of it are in range.
        const LEAST: f64 = f64::from_bits((1023 - 900) << 52);
        let is_out = |&j: &usize| {
            let square = self.entry(j, j)[0];
            let short = square != 0.0 && square.abs() < LEAST;
            short || square == f64::INFINITY || self.about.vanished.contains(&j)
        };
        (0..self.n).filter(is_out).collect()
    }

    /// Returns the columns that are not zero, but whose squared length rounds to 0; ascending.
    pub(crate) fn vanished(&self) -> &[usize] {
        &self.about.vanished
    }
}

/// Returns the bits of three numbers in the place of an integer.
#[inline(always)]
fn packed([first, second, third]: [f64; 3]) -> I256 {
    let low = u128::from(first.to_bits()) | u128::from(second.to_bits()) << u64::BITS;
    I256 { high: third.to_bits().into(), low }
}

/// Returns the three numbers.
#[inline(always)]
fn unpacked(I256 { high, low }: I256) -> [f64; 3] {
    [low as u64, (low >> u64::BITS) as u64, high as u64].map(f64::from_bits)
}
