use faer::Mat;

use super::columns::{Columns, LANES};
use super::double::{DoubleDouble, scaled};
use super::slices::{PairColumns, PairsMut};
use crate::base::{Error, Par, Result, widest, zeros};
use crate::rows::ExtendedGram;

/// Which of the columns that do not depend on earlier ones is factored next.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Pivoting {
    /// The column of which most is left relative to its own norm: the rank does not depend on the
    /// scales of the columns.
    #[default]
    Scaled,
    /// The column of which most is left: singular values of columns of different scales come out
    /// with a small relative error.
    Largest,
    /// The first column: R is that of A with its columns in their order, the dependent ones last. A
    /// column that depends on others by large coefficients may count as independent.
    Natural,
}

/// Columns of a panel.
const PANEL: usize = 64;

/// Columns of the trailing matrix that one thread updates at a time, a multiple of [`LANES`].
const TASK: usize = 32;

/// Operations that a product takes in twice the precision, and the sum with it.
const SUBTRACTED: f64 = 20.0;

/// Rows of the columns of a panel that stay in the first-level cache, a multiple of [`LANES`].
const ROWS: usize = 32;

/// The pivoted Cholesky factor `P^T C P = R^T R` of a Gram matrix `C = A^T A` (n x n) in
/// double-double: R is that of a QR decomposition of A P.
///
/// The columns are scaled by powers of two first, so that the diagonal of C is between 1 and 4 and
/// nothing is rounded. A column depends on those before it when what is left of its square is below
/// [`PivotedCholesky::tolerance`]; R has `rank` rows. The work is blocked as in LAPACK's `dpstrf`
/// (Lucas 2004), and the result is the same, bit for bit, for every `par`.
///
/// ```
/// use catamaran::rows::ExtendedGram;
/// use catamaran::solve::{PivotedCholesky, Pivoting};
/// use catamaran::{Par, faer::mat};
///
/// // The third column is the sum of the others.
/// let a = mat![[1.0, 2.0, 3.0], [0.0, 1.0, 1.0], [4.0, 0.0, 4.0]];
/// let c = a.transpose() * &a;
/// let gram = ExtendedGram::from_f64(c.as_ref(), 3, &[])?;
/// let factor = PivotedCholesky::from_gram(&gram, Pivoting::Natural, Par::Seq)?;
/// assert_eq!((factor.rank(), factor.dependent()), (2, &[2][..]));
/// let r = factor.r()?;
/// assert!((r[(0, 0)] * r[(0, 1)] - c[(0, 1)]).abs() < 1e-14);
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct PivotedCholesky {
    /// R^T of the scaled matrix; n rows, of which the first `rank` columns count.
    pub(super) lower: Columns<2>,
    pub(super) order: Vec<usize>,
    pub(super) rank: usize,
    /// Column j of A is that of the scaled matrix times 2 to this power.
    pub(super) exponents: Vec<i32>,
    tolerance: f64,
}

/// Returns the largest remainder of the square of a dependent column, relative to that square.
///
/// Rounding to double-double leaves a few units of 2^-106 for each column that is eliminated; where
/// the entries of A were rounded, they are wrong by 2^-80 of their column.
pub(super) fn tolerance(n: usize, exact: bool) -> f64 {
    n.max(1) as f64 * if exact { 2f64.powi(-102) } else { 2f64.powi(-79) }
}

/// Returns the exponent by which a column of this squared norm is divided.
pub(super) fn exponent(square: f64) -> i32 {
    if square <= 0.0 {
        return 0;
    }
    // Subnormal numbers have no exponent of their own.
    let (square, offset) =
        if square < f64::MIN_POSITIVE { (scaled(square, 200), 200) } else { (square, 0) };
    let exponent = ((square.to_bits() >> 52) & 0x7ff) as i32 - 1023 - offset;
    exponent.div_euclid(2)
}

/// Returns an error for a Gram matrix with an entry that is not finite, or a negative diagonal.
pub(super) fn check(gram: &ExtendedGram) -> Result<()> {
    for i in 0..gram.n() {
        if let Some(j) = (0..=i).find(|&j| !gram.entry(i, j)[0].is_finite()) {
            return Err(Error::NonFinite { what: "gram", index: (i, j) });
        }
        let square = gram.entry(i, i)[0];
        if square < 0.0 {
            let why = format!("entry {i} of its diagonal is negative: {square:e}");
            return Err(Error::Argument { what: "gram", why });
        }
    }
    Ok(())
}

/// Returns the error of [`check`] for the Gram matrix of `[A B]`, A of n columns, or one that names
/// the first column whose squared length is out of range.
pub(super) fn check_lengths(gram: &ExtendedGram, n: usize) -> Result<()> {
    let Some(&j) = gram.out_of_range().first() else { return check(gram) };
    let (what, j) = if j < n { ("A", j) } else { ("B", j - n) };
    let why = format!(
        "the squared length of column {j} is out of the range of f64: multiply the column by a \
         power of ten"
    );
    Err(Error::Argument { what, why })
}

impl PivotedCholesky {
    /// Factors a Gram matrix.
    ///
    /// ```
    /// use catamaran::rows::ExtendedGram;
    /// use catamaran::solve::{PivotedCholesky, Pivoting};
    /// use catamaran::{Par, faer::mat};
    ///
    /// let gram = ExtendedGram::from_f64(mat![[1.0, 0.0], [0.0, 9.0]].as_ref(), 2, &[])?;
    /// let natural = PivotedCholesky::from_gram(&gram, Pivoting::Natural, Par::Seq)?;
    /// let largest = PivotedCholesky::from_gram(&gram, Pivoting::Largest, Par::Seq)?;
    /// assert_eq!((natural.order(), largest.order()), (&[0, 1][..], &[1, 0][..]));
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::NonFinite`] and [`Error::Argument`] for a matrix that is no Gram matrix;
    /// [`Error::Argument`] of "A" for the first of the columns that [`ExtendedGram::out_of_range`]
    /// lists; [`Error::OutOfMemory`].
    pub fn from_gram(gram: &ExtendedGram, pivoting: Pivoting, par: Par) -> Result<Self> {
        check_lengths(gram, gram.n())?;
        let entry = |i, j| gram.entry(i, j);
        Self::of(gram.n(), tolerance(gram.n(), gram.is_exact()), pivoting, par, entry)
    }

    /// Factors the matrix with these entries of its lower triangle, which satisfy [`check`].
    pub(super) fn of(
        n: usize,
        tolerance: f64,
        pivoting: Pivoting,
        par: Par,
        entry: impl Fn(usize, usize) -> [f64; 3],
    ) -> Result<Self> {
        let exponents: Vec<i32> = (0..n).map(|j| exponent(entry(j, j)[0])).collect();
        let mut lower = Columns::new(n, n)?;
        for j in 0..n {
            for i in j..n {
                let [hi, mid, low] = entry(i, j);
                let value = DoubleDouble::new(hi, mid + low);
                lower.set_double(i, j, value.scaled(-exponents[i] - exponents[j]));
            }
        }
        let order = (0..n).collect();
        let mut factor = Self { lower, order, rank: n, exponents, tolerance };
        factor.eliminate(pivoting, par)?;
        Ok(factor)
    }

    fn eliminate(&mut self, pivoting: Pivoting, par: Par) -> Result<()> {
        let n = self.n();
        let mut left = Left::new(&self.lower, pivoting, &self.exponents, self.tolerance)?;
        let mut first = 0;
        while first < n {
            let end = n.min(first + PANEL);
            for j in first..end {
                let Some(pivot) = left.pivot(j) else {
                    self.rank = j;
                    return self.clear();
                };
                self.exchange(j, pivot);
                left.exchange(j, pivot);
                self.eliminate_column(first, j, &mut left);
            }
            self.update(first, end, par)?;
            first = end;
        }
        self.clear()
    }

    /// Exchanges two rows and columns of the trailing matrix, and two rows of the factor.
    fn exchange(&mut self, j: usize, pivot: usize) {
        if j == pivot {
            return;
        }
        self.order.swap(j, pivot);
        (0..j).for_each(|k| self.lower.swap((j, k), (pivot, k)));
        self.lower.swap((j, j), (pivot, pivot));
        (j + 1..pivot).for_each(|i| self.lower.swap((i, j), (pivot, i)));
        (pivot + 1..self.n()).for_each(|i| self.lower.swap((i, j), (i, pivot)));
    }

    /// Turns column j, minus its columns before `first`, into column j of the factor.
    fn eliminate_column(&mut self, first: usize, j: usize, left: &mut Left) {
        let from = j / LANES * LANES;
        let root = left.get(j).sqrt();
        let (before, mut column, _) = self.lower.around(j, from);
        let panel = before.starting(0, first);
        column.subtract(
            panel.starting(from, 0),
            j - first,
            #[inline(always)]
            |k| panel.get(j, k),
        );
        widest(
            #[inline(always)]
            || {
                let mut column = self.lower.pairs_mut(j, from);
                column.normalize();
                column.scale(DoubleDouble::ONE / root);
                left.squares(from).subtract_squares(self.lower.pairs(j, from));
            },
        );
        self.lower.set_double(j, j, root);
    }

    /// Subtracts the product of columns `first..end` from the trailing matrix.
    ///
    /// The entries that it writes above the diagonal are never read.
    fn update(&mut self, first: usize, end: usize, par: Par) -> Result<()> {
        let stride = self.lower.stride;
        let [hi, lo] = &mut self.lower.parts;
        let (done_hi, rest_hi) = hi.split_at_mut(end * stride);
        let (done_lo, rest_lo) = lo.split_at_mut(end * stride);
        let panel = first * stride..end * stride;
        let panel = PairColumns { hi: &done_hi[panel.clone()], lo: &done_lo[panel], stride };
        let tasks = rest_hi.chunks_mut(TASK * stride).zip(rest_lo.chunks_mut(TASK * stride));
        let operations = SUBTRACTED * (TASK * (stride - end) * (end - first)) as f64;
        par.for_each_asking(tasks, operations, |task, (hi, lo)| {
            let start = end + task * TASK;
            widest(
                #[inline(always)]
                || {
                    for from in (start..stride).step_by(ROWS) {
                        let to = stride.min(from + ROWS);
                        let columns = hi.chunks_mut(stride).zip(lo.chunks_mut(stride));
                        for (j, (hi, lo)) in columns.enumerate() {
                            let mut rows =
                                PairsMut { hi: &mut hi[from..to], lo: &mut lo[from..to] };
                            rows.subtract(
                                panel.starting(from, 0),
                                end - first,
                                #[inline(always)]
                                |k| panel.get(start + j, k),
                            );
                            rows.normalize();
                        }
                    }
                },
            );
        })
    }

    /// Clears what is above the diagonal of the factor, and behind its last column.
    fn clear(&mut self) -> Result<()> {
        let (n, stride) = (self.n(), self.lower.stride);
        for part in &mut self.lower.parts {
            for (j, column) in part.chunks_mut(stride).enumerate() {
                let unused = if j < self.rank { j } else { n };
                column[..unused].fill(0.0);
                column[n..].fill(0.0);
            }
        }
        Ok(())
    }

    /// Returns the number n of rows, and of columns, of the matrix.
    pub fn n(&self) -> usize {
        self.lower.rows
    }

    /// Returns the number of columns of A that do not depend on others, as far as the precision can
    /// tell.
    pub fn rank(&self) -> usize {
        self.rank
    }

    /// Returns the columns of A in their order in A P.
    pub fn order(&self) -> &[usize] {
        &self.order
    }

    /// Returns the columns of A that depend on those before them in the order.
    pub fn dependent(&self) -> &[usize] {
        &self.order[self.rank..]
    }

    /// Returns the share of the square of a column that elimination may leave when the column
    /// depends on others: n 2^-102, or n 2^-79 where the entries of A were rounded.
    pub fn tolerance(&self) -> f64 {
        self.tolerance
    }

    /// Returns entry (i, j) of R, which is zero below the diagonal.
    ///
    /// # Panics
    /// When R, which is rank x n, has no such entry.
    pub fn entry(&self, i: usize, j: usize) -> DoubleDouble {
        assert!(i < self.rank && j < self.n(), "({i}, {j}) is not in R");
        self.lower.double(j, i).scaled(self.exponents[self.order[j]])
    }

    /// Returns R (rank x n), rounded to f64.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`].
    pub fn r(&self) -> Result<Mat<f64>> {
        let mut r = crate::dense::zeros(self.rank, self.n())?;
        for j in 0..self.n() {
            for i in 0..self.rank.min(j + 1) {
                r[(i, j)] = self.entry(i, j).hi;
            }
        }
        Ok(r)
    }
}

impl PivotedCholesky {
    /// Returns R^T (n x rank) of A with scaled columns: row c is that of column c of the scaled
    /// matrix times `factor 2^exponent`, with both from `factor(c)`.
    ///
    /// Columns are divided by 2 to the power of the exponents that are returned, those of their
    /// pivots: nothing that counts is out of range, whatever the sizes of the columns of A.
    pub(super) fn transposed(
        &self,
        factor: impl Fn(usize) -> (f64, i32),
    ) -> Result<(Mat<f64>, Vec<i32>)> {
        let mut transposed = crate::dense::zeros(self.n(), self.rank)?;
        let exponents: Vec<_> = self.order[..self.rank].iter().map(|&c| factor(c).1).collect();
        for (i, &c) in self.order.iter().enumerate() {
            let (factor, exponent) = factor(c);
            for j in 0..self.rank.min(i + 1) {
                let value = self.lower.get(i, j)[0] * factor;
                transposed[(c, j)] = scaled(value, exponent - exponents[j]);
            }
        }
        Ok((transposed, exponents))
    }
}

/// Returns an error unless the matrix is about the mean.
pub(super) fn check_centered(gram: &ExtendedGram) -> Result<()> {
    if gram.mean().len() == gram.n() {
        return Ok(());
    }
    let why = "must be about the mean, but is not".into();
    Err(Error::Argument { what: "gram", why })
}

/// Returns the numbers of the first few of these columns, as words of a message.
pub(super) fn named(columns: &[usize]) -> String {
    const MOST: usize = 8;
    let mut columns = columns.to_vec();
    columns.sort_unstable();
    let names: Vec<_> = columns.iter().take(MOST).map(ToString::to_string).collect();
    let more = if columns.len() > MOST { ", ..." } else { "" };
    let noun = if columns.len() == 1 { "column" } else { "columns" };
    format!("{noun} {}{more}", names.join(", "))
}

/// The diagonal of the trailing matrix, by which pivots are chosen.
struct Left {
    values: Columns<2>,
    /// A column whose square is below this depends on others.
    least: Vec<f64>,
    /// Weights by which columns are compared.
    exponents: Vec<i32>,
    pivoting: Pivoting,
}

impl Left {
    fn new(
        lower: &Columns<2>,
        pivoting: Pivoting,
        exponents: &[i32],
        tolerance: f64,
    ) -> Result<Self> {
        let n = lower.rows;
        let (mut values, mut least) = (Columns::new(n, 1)?, zeros(n)?);
        for j in 0..n {
            values.set(j, 0, lower.get(j, j));
            least[j] = tolerance * lower.get(j, j)[0];
        }
        Ok(Self { values, least, exponents: exponents.to_vec(), pivoting })
    }

    fn get(&self, j: usize) -> DoubleDouble {
        self.values.double(j, 0)
    }

    fn squares(&mut self, from: usize) -> PairsMut<'_> {
        self.values.pairs_mut(0, from)
    }

    fn exchange(&mut self, i: usize, j: usize) {
        self.values.swap((i, 0), (j, 0));
        self.least.swap(i, j);
        self.exponents.swap(i, j);
    }

    /// Returns the next pivot: the largest column at `from` or behind it, the first of several.
    /// Returns `None` when all of them depend on others.
    fn pivot(&self, from: usize) -> Option<usize> {
        let value = |j: usize| self.get(j).hi;
        let larger = |a: usize, b: usize| match self.pivoting {
            Pivoting::Natural => false,
            // Scaled diagonals begin between 1 and 4.
            Pivoting::Scaled => value(a) * self.least[b] > value(b) * self.least[a],
            Pivoting::Largest => {
                let difference = 2 * self.exponents[a].saturating_sub(self.exponents[b]);
                scaled(value(a), difference) > value(b)
            }
        };
        let independent = (from..self.least.len()).filter(|&j| value(j) > self.least[j]);
        independent.reduce(|best, j| if larger(j, best) { j } else { best })
    }
}
