use std::ops::Range;

use faer::MatRef;
use faer::mat::AsMatRef;

use super::coded::for_each_block_as;
use super::coding::Coding;
use super::exact::ExactSums;
use super::extended::ExtendedGram;
use super::float::FloatSums;
use super::grid::{Grid, RowBounds, Shift};
use super::pass::Pass;
use super::source::{DenseRows, RowBlocks};
use super::strip::Strip;
use crate::base::{Error, Par, Result, block_rows, finite_weights};
use crate::blas::BlasReal;
use crate::kernel::int8::I256;
use crate::product::combine::{mirror_lower, scale_lower};
use crate::product::{AtaOptions, Uplo};

/// A sum `C = sum of w_i (x_i - s)(x_i - s)^T` over rows `x_i` of n columns that come in blocks,
/// where s is zero or the mean of the rows. The sum can be saved, continued elsewhere, and merged
/// with others.
///
/// There are three kinds. [`Accumulator::new`] adds in floating point: the last bits depend on the
/// blocks and their order. [`Accumulator::exact`] adds integers on a grid that is chosen before the
/// first row: C is the same bytes for any blocks, order, threads, machines and merges, and rows can
/// be removed again. [`Accumulator::extended`] does so with longer integers, from which C comes in
/// extended precision. See docs/algorithms/ata.md, "Streaming".
///
/// C may be a strip of rows of the whole matrix, when all of it is too large.
///
/// ```
/// use catamaran::rows::{Accumulator, RowBounds};
/// use catamaran::{AtaOptions, Uplo, faer::mat};
///
/// let bounds = RowBounds::new(vec![-1.0, 0.0], vec![1.0, 9.0], 1000)?;
/// let options = AtaOptions::default();
/// let mut sum = Accumulator::<f64>::exact(&bounds, false)?;
/// sum.add_block(mat![[1.0, 2.0], [0.5, 4.0]], None, &options)?;
/// sum.remove_block(mat![[1.0, 2.0]], None, &options)?;
/// let c = sum.finish(1.0, Uplo::Both)?;
/// assert_eq!(c.as_ref()[(1, 0)], 2.0);
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug)]
pub struct Accumulator<T> {
    /// Columns of the rows.
    pub(super) ncols: usize,
    pub(super) sums: Sums<T>,
    /// Number of rows of all sources that were streamed into this accumulator.
    pub(super) expected_rows: u64,
    /// Rows of its blocks; 0 before the first source.
    pub(super) block_rows: u64,
    /// Labels that the caller wants to find again: name and value.
    pub(super) labels: Vec<(String, String)>,
}

/// The sums, of one of three kinds.
#[derive(Debug)]
pub(super) enum Sums<T> {
    Float(FloatSums<T>),
    Exact(ExactSums<T>),
    Extended(ExactSums<T, I256>),
}

impl<T: BlasReal> Accumulator<T> {
    /// Creates an empty accumulator for all of C, in floating point; C is about the mean when
    /// `centered`.
    ///
    /// ```
    /// use catamaran::{AtaOptions, Uplo, rows::Accumulator, faer::mat};
    ///
    /// let mut sum = Accumulator::<f64>::new(2, true)?;
    /// sum.add_block(mat![[1.0, 1.0], [3.0, 5.0]], None, &AtaOptions::new())?;
    /// assert_eq!(sum.mean(), [2.0, 3.0]);
    /// assert_eq!(sum.finish(1.0, Uplo::Lower)?.as_ref()[(1, 0)], 4.0);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::OutOfMemory`].
    pub fn new(ncols: usize, centered: bool) -> Result<Self> {
        Self::of_strip(ncols, 0..ncols, centered)
    }

    /// Creates an accumulator as [`Accumulator::new`] does, for these rows of C.
    ///
    /// ```
    /// use catamaran::{AtaOptions, Uplo, rows::Accumulator, faer::mat};
    ///
    /// let mut sum = Accumulator::<f64>::of_strip(3, 1..3, false)?;
    /// sum.add_block(mat![[1.0, 2.0, 3.0]], None, &AtaOptions::new())?;
    /// let strip = sum.finish(1.0, Uplo::Lower)?;
    /// // Row 2 of C is row 1 of the strip.
    /// assert_eq!((strip.rows(), strip.as_ref()[(1, 1)]), (1..3, 6.0));
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Argument`] when the rows are not in `0..ncols`, [`Error::OutOfMemory`].
    pub fn of_strip(ncols: usize, rows: Range<usize>, centered: bool) -> Result<Self> {
        check_strip(&rows, ncols)?;
        Ok(Self::of(ncols, Sums::Float(FloatSums::new(ncols, rows, centered)?)))
    }

    /// Creates an empty accumulator for all of C, in integers; C is about the mean when `centered`.
    /// All rows must be within the bounds.
    ///
    /// Entries are rounded once, relative to the bounds of their column, products of entries with
    /// weights once more, and C once at the end: `|C_ij - exact| <= 4 m u |x_i| |x_j|` for m rows
    /// and columns x (less their mean) that reach their bounds.
    ///
    /// # Errors
    /// [`Error::Argument`] when the bounds are too far apart, [`Error::OutOfMemory`].
    pub fn exact(bounds: &RowBounds<T>, centered: bool) -> Result<Self> {
        Self::exact_strip(bounds, 0..bounds.ncols(), centered)
    }

    /// Creates an accumulator as [`Accumulator::exact`] does, for these rows of C.
    ///
    /// # Errors
    /// As [`Accumulator::exact`] and [`Accumulator::of_strip`].
    pub fn exact_strip(bounds: &RowBounds<T>, rows: Range<usize>, centered: bool) -> Result<Self> {
        check_strip(&rows, bounds.ncols())?;
        let shift = if centered { Shift::Near } else { Shift::No };
        Ok(Self::of(bounds.ncols(), Sums::Exact(ExactSums::new(bounds, rows, shift)?)))
    }

    /// Creates an empty accumulator for all of C, in integers of 256 bits; C is about the mean when
    /// `centered`. All rows must be within the bounds. [`Accumulator::finish_extended`] returns C
    /// in extended precision; all else is as for [`Accumulator::exact`].
    ///
    /// Entries are rounded to multiples of 2^-80 of the bounds of their column, which leaves the
    /// entries of most data unchanged. Where [`RowBounds::of`] has found that all entries of the
    /// columns are multiples of larger numbers, such as integers, shorter integers are enough, and
    /// the sums take less time. Products with weights are not rounded.
    ///
    /// ```
    /// use catamaran::rows::{Accumulator, RowBounds};
    /// use catamaran::{AtaOptions, Par, faer::mat};
    ///
    /// let bounds = RowBounds::new(vec![-1.0], vec![1.0], 10)?;
    /// let mut sum = Accumulator::<f64>::extended(&bounds, false)?;
    /// sum.add_block(mat![[1.0], [2f64.powi(-40)]], None, &AtaOptions::new())?;
    /// let c = sum.finish_extended(Par::Seq)?;
    /// assert_eq!(c.entry(0, 0), [1.0, 2f64.powi(-80), 0.0]);
    /// assert!(c.is_exact());
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Accumulator::exact`].
    pub fn extended(bounds: &RowBounds<T>, centered: bool) -> Result<Self> {
        // Rows that are shifted may have more bits than an f64. No shift is needed: a column that
        // is far from zero beside its deviations has entries of few bits below them.
        let (n, grid) = (bounds.ncols(), Grid::new(bounds, Shift::No, true)?);
        Ok(Self::of(n, Sums::Extended(ExactSums::on(grid, 0..n, centered)?)))
    }

    pub(super) fn of(ncols: usize, sums: Sums<T>) -> Self {
        Self { ncols, sums, expected_rows: 0, block_rows: 0, labels: Vec::new() }
    }

    /// Makes an empty accumulator exact, if it is not; only then `bounds` is called.
    pub(super) fn make_exact(
        &mut self,
        bounds: impl FnOnce() -> Result<RowBounds<T>>,
    ) -> Result<()> {
        if self.is_exact() {
            return Ok(());
        }
        if self.rows() > 0 {
            let why = "floating-point sums can't be continued exactly: create it with `exact`";
            return Err(Error::Argument { what: "accumulator", why: why.into() });
        }
        let shift = if self.is_centered() { Shift::Near } else { Shift::No };
        self.sums = Sums::Exact(ExactSums::new(&bounds()?, self.strip(), shift)?);
        Ok(())
    }

    /// Returns a copy, bit for bit.
    ///
    /// ```
    /// use catamaran::{AtaOptions, rows::Accumulator, faer::mat};
    ///
    /// let mut sum = Accumulator::<f64>::new(1, false)?;
    /// let copy = sum.try_clone()?;
    /// sum.add_block(mat![[2.0]], None, &AtaOptions::new())?;
    /// assert_eq!((copy.rows(), sum.rows()), (0, 1));
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::OutOfMemory`].
    pub fn try_clone(&self) -> Result<Self> {
        let sums = match &self.sums {
            Sums::Float(sums) => Sums::Float(sums.try_clone()?),
            Sums::Exact(sums) => Sums::Exact(sums.try_clone()?),
            Sums::Extended(sums) => Sums::Extended(sums.try_clone()?),
        };
        Ok(Self { sums, labels: self.labels.clone(), ..*self })
    }

    /// Returns the number of columns n of the rows.
    pub fn ncols(&self) -> usize {
        self.ncols
    }

    /// Returns the rows of C that the accumulator sums.
    pub fn strip(&self) -> Range<usize> {
        match &self.sums {
            Sums::Float(sums) => sums.c.rows(),
            Sums::Exact(sums) => sums.strip.clone(),
            Sums::Extended(sums) => sums.strip.clone(),
        }
    }

    /// Returns the number of rows so far.
    pub fn rows(&self) -> u64 {
        match &self.sums {
            Sums::Float(sums) => sums.moments.rows,
            Sums::Exact(sums) => sums.rows,
            Sums::Extended(sums) => sums.rows,
        }
    }

    /// Returns the number of rows of all sources that were streamed into the accumulator. It is
    /// larger than [`Accumulator::rows`] until the last source is complete.
    pub fn expected_rows(&self) -> u64 {
        self.expected_rows.max(self.rows())
    }

    /// Sets the number of rows of the source that [`stream`](super::stream()) continues: one that
    /// begins with the rows that are summed already, in any order, as merged exact sums have.
    #[doc(hidden)]
    pub fn set_expected_rows(&mut self, rows: u64) {
        self.expected_rows = rows;
    }

    /// Returns the sum of the weights of the rows so far; without weights, their number.
    pub fn weight(&self) -> f64 {
        match &self.sums {
            Sums::Float(sums) => sums.moments.weight,
            Sums::Exact(sums) => sums.weight(),
            Sums::Extended(sums) => sums.weight(),
        }
    }

    /// Returns whether C is about the mean.
    pub fn is_centered(&self) -> bool {
        match &self.sums {
            Sums::Float(sums) => sums.moments.centered,
            Sums::Exact(sums) => sums.centered,
            Sums::Extended(sums) => sums.centered,
        }
    }

    /// Returns whether the sums are integers, which are the same for any order of the rows.
    pub fn is_exact(&self) -> bool {
        !matches!(self.sums, Sums::Float(_))
    }

    /// Returns whether [`Accumulator::finish_extended`] can return C in extended precision.
    pub fn is_extended(&self) -> bool {
        matches!(self.sums, Sums::Extended(_))
    }

    /// Returns the (weighted) mean row so far; empty without centring.
    pub fn mean(&self) -> Vec<f64> {
        match &self.sums {
            Sums::Float(sums) => sums.moments.mean(),
            Sums::Exact(sums) => sums.mean(),
            Sums::Extended(sums) => sums.mean(),
        }
    }

    /// Returns the labels, names and values that the accumulator keeps for the caller.
    pub fn labels(&self) -> &[(String, String)] {
        &self.labels
    }

    /// Replaces the labels. A file has room for about 1 MiB of them.
    pub fn set_labels(&mut self, labels: Vec<(String, String)>) {
        self.labels = labels;
    }

    /// Checks that the labels are equal to `wanted`.
    ///
    /// ```
    /// use catamaran::rows::Accumulator;
    ///
    /// let label = |file: &str| vec![("file".to_owned(), file.to_owned())];
    /// let mut sum = Accumulator::<f64>::new(2, false)?;
    /// sum.set_labels(label("a.npy"));
    /// sum.check_labels(&label("a.npy"))?;
    /// let error = sum.check_labels(&label("b.npy")).unwrap_err();
    /// assert!(error.to_string().ends_with("file was a.npy, and is b.npy now"));
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Argument`] that names the first label that differs, and both values.
    pub fn check_labels(&self, wanted: &[(String, String)]) -> Result<()> {
        let value = |labels: &[(String, String)], name: &str| {
            labels.iter().find(|l| l.0 == name).map(|l| l.1.clone())
        };
        for (name, _) in wanted.iter().chain(&self.labels) {
            let (was, is) = (value(&self.labels, name), value(wanted, name));
            if was != is {
                let [was, is] = [was, is].map(|v| v.unwrap_or_else(|| "nothing".into()));
                let why = format!("{name} was {was}, and is {is} now");
                return Err(Error::Argument { what: "accumulator", why });
            }
        }
        Ok(())
    }

    /// Adds a block of rows, a matrix of n columns and any strides, with their weights if they have
    /// any. `options.uplo` does not matter. [`stream`](super::stream()) plans once for all blocks
    /// of a source.
    ///
    /// The rows are copied, [`block_rows`] of them at a time, and each copy is added as a block.
    /// `MatRef::from_row_major_slice` makes a matrix of rows in a slice.
    ///
    /// ```
    /// use catamaran::{AtaOptions, Uplo, rows::Accumulator, faer::MatRef};
    ///
    /// let rows = [1.0, 2.0];
    /// let mut sum = Accumulator::<f64>::new(1, false)?;
    /// let block = MatRef::from_row_major_slice(&rows, 2, 1);
    /// sum.add_block(block, Some(&[10.0, 1.0]), &AtaOptions::new())?;
    /// assert_eq!((sum.rows(), sum.weight()), (2, 11.0));
    /// assert_eq!(sum.finish(1.0, Uplo::Lower)?.as_ref()[(0, 0)], 14.0);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Shape`] for the block and the weights, [`Error::NonFinite`] for a weight;
    /// [`Error::Argument`] for a row or a weight beyond the bounds of an exact accumulator, which
    /// is left as it was; else as [`ata_into`](crate::ata_into), after which the sums may contain a
    /// part of the block, so the accumulator must not be used.
    pub fn add_block(
        &mut self,
        rows: impl AsMatRef<T = T, Rows = usize, Cols = usize>,
        weights: Option<&[T]>,
        options: &AtaOptions<'_>,
    ) -> Result<()> {
        self.change_block(rows.as_mat_ref(), weights, false, self.height(weights), options)
    }

    /// Removes rows that were added, in any blocks, with the same weights. The sums that remain
    /// have the bytes of sums that never had these rows. Otherwise as [`Accumulator::add_block`].
    ///
    /// # Errors
    /// [`Error::Argument`] when the accumulator is not exact, or has fewer rows;
    /// [`Error::NonFinite`] for rows that are not finite; else as [`Accumulator::add_block`].
    pub fn remove_block(
        &mut self,
        rows: impl AsMatRef<T = T, Rows = usize, Cols = usize>,
        weights: Option<&[T]>,
        options: &AtaOptions<'_>,
    ) -> Result<()> {
        self.change_block(rows.as_mat_ref(), weights, true, self.height(weights), options)
    }

    /// Adds rows or removes them, in copies of `height` rows.
    pub(super) fn change_block(
        &mut self,
        rows: MatRef<'_, T>,
        weights: Option<&[T]>,
        remove: bool,
        height: usize,
        options: &AtaOptions<'_>,
    ) -> Result<()> {
        Error::check_shape("block", (rows.nrows(), self.ncols), rows.shape())?;
        finite_weights(rows.nrows(), weights)?;
        match &self.sums {
            Sums::Float(_) => {}
            Sums::Exact(sums) => sums.check_block(rows, weights, remove, height, options.par)?,
            Sums::Extended(sums) => {
                sums.check_block(rows, weights, remove, height, options.par)?;
            }
        }
        self.change_rows(&mut DenseRows(rows), weights, remove, height, options)
    }

    /// Adds the rows of a source, with their weights if they have any, in blocks;
    /// `options.progress` receives the fraction of its rows. [`stream`](super::stream()) adds one
    /// source and can continue after a stop; this function adds any number of them.
    ///
    /// ```
    /// use catamaran::rows::{Accumulator, DenseRows};
    /// use catamaran::{AtaOptions, Uplo, faer::Mat};
    ///
    /// let a = Mat::<f64>::from_fn(10, 2, |i, j| (i + j) as f64);
    /// let mut sum = Accumulator::<f64>::new(2, false)?;
    /// for part in [a.subrows(0, 3), a.subrows(3, 7)] {
    ///     sum.add_rows(&mut DenseRows(part), None, &AtaOptions::new())?;
    /// }
    /// assert_eq!(sum.finish(1.0, Uplo::Both)?.as_ref(), a.transpose() * &a);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Shape`] for columns and weights; those of the source; else as
    /// [`Accumulator::add_block`]. Blocks before the one that failed have been added, as
    /// [`Accumulator::rows`] shows.
    pub fn add_rows(
        &mut self,
        rows: &mut (dyn RowBlocks<T> + Send),
        weights: Option<&[T]>,
        options: &AtaOptions<'_>,
    ) -> Result<()> {
        self.change_rows(rows, weights, false, self.height(weights), options)
    }

    /// Removes the rows of a source, as [`Accumulator::remove_block`] does.
    ///
    /// ```
    /// use catamaran::rows::{Accumulator, DenseRows, RowBounds};
    /// use catamaran::{AtaOptions, Uplo, faer::Mat};
    ///
    /// let a = Mat::<f64>::from_fn(10, 2, |i, j| (i + j) as f64);
    /// let options = AtaOptions::new();
    /// let bounds = RowBounds::<f64>::of(&mut DenseRows(a.as_ref()), None, 64, &options)?;
    /// let mut sum = Accumulator::exact(&bounds, false)?;
    /// sum.add_rows(&mut DenseRows(a.as_ref()), None, &options)?;
    /// sum.remove_rows(&mut DenseRows(a.subrows(0, 4)), None, &options)?;
    /// let kept = a.subrows(4, 6);
    /// assert_eq!(sum.finish(1.0, Uplo::Both)?.as_ref(), kept.transpose() * kept);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Accumulator::add_rows`] and [`Accumulator::remove_block`].
    pub fn remove_rows(
        &mut self,
        rows: &mut (dyn RowBlocks<T> + Send),
        weights: Option<&[T]>,
        options: &AtaOptions<'_>,
    ) -> Result<()> {
        self.change_rows(rows, weights, true, self.height(weights), options)
    }

    /// Returns the rows of the blocks in which rows are added.
    fn height(&self, weights: Option<&[T]>) -> usize {
        block_rows::<T>(self.ncols, weights.is_some())
    }

    /// Adds the rows of a source or removes them, in blocks of `height` rows.
    pub(super) fn change_rows(
        &mut self,
        rows: &mut (dyn RowBlocks<T> + Send),
        weights: Option<&[T]>,
        remove: bool,
        height: usize,
        options: &AtaOptions<'_>,
    ) -> Result<()> {
        let (m, n) = (rows.nrows(), rows.ncols());
        Error::check_shape("rows", (m, self.ncols), (m, n))?;
        finite_weights(m, weights)?;
        let coding = rows.coding().filter(|_| self.is_extended());
        let coding = coding.as_ref();
        for_each_block_as(coding, rows, weights, height, 0, options, |count, block, w, pass| {
            self.change(coding, count, block, w, remove, pass)
        })
    }

    /// Adds a block of `count` rows, one after another, in a pass; coded ones if there is a coding.
    /// Their entries are overwritten.
    pub(super) fn add(
        &mut self,
        coding: Option<&Coding>,
        count: usize,
        block: &mut [T],
        weights: Option<&[T]>,
        pass: &mut Pass<'_>,
    ) -> Result<()> {
        self.change(coding, count, block, weights, false, pass)
    }

    fn change(
        &mut self,
        coding: Option<&Coding>,
        count: usize,
        block: &mut [T],
        weights: Option<&[T]>,
        remove: bool,
        pass: &mut Pass<'_>,
    ) -> Result<()> {
        match &mut self.sums {
            Sums::Float(_) if remove => {
                let why = "rows can be removed from exact sums only: create it with `exact`";
                Err(Error::Argument { what: "accumulator", why: why.into() })
            }
            Sums::Float(sums) => sums.add(count, block, weights, pass),
            Sums::Exact(sums) => sums.add(count, block, weights, remove, pass),
            Sums::Extended(sums) => match coding {
                Some(coding) => sums.add_coded(coding, count, block, weights, remove, pass),
                None => sums.add(count, block, weights, remove, pass),
            },
        }
    }

    /// Adds the rows of `other`. Labels that differ are dropped.
    ///
    /// Exact sums with the same bounds merge to the same bytes in any order. With other bounds both
    /// move to the finer grid of each column first, exactly.
    ///
    /// ```
    /// use catamaran::rows::{Accumulator, RowBounds};
    /// use catamaran::{AtaOptions, Uplo, faer::Mat};
    ///
    /// let bounds = RowBounds::new(vec![0.0, 0.0], vec![9.0, 9.0], 100)?;
    /// let of = |row: [f64; 2]| {
    ///     let mut sum = Accumulator::exact(&bounds, false)?;
    ///     sum.add_block(Mat::from_fn(1, 2, |_, j| row[j]), None, &AtaOptions::new())?;
    ///     Ok::<_, catamaran::Error>(sum)
    /// };
    /// let mut sum = of([1.0, 2.0])?;
    /// sum.merge(of([3.0, 4.0])?)?;
    /// assert_eq!(sum.rows(), 2);
    /// assert_eq!(sum.finish(1.0, Uplo::Lower)?.as_ref()[(1, 0)], 14.0);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Argument`] when they differ in kind, columns, strip or centring, which leaves the
    /// accumulator as it was, or when the grids of exact sums are too far apart for 128 bits, after
    /// which it must not be used.
    pub fn merge(&mut self, other: Self) -> Result<()> {
        let different = |what, own: String, others: String| {
            let why = format!("{what}: {own} and {others} can't be merged");
            Err(Error::Argument { what: "accumulator", why })
        };
        if self.ncols != other.ncols {
            return different("columns", self.ncols.to_string(), other.ncols.to_string());
        }
        if self.strip() != other.strip() {
            let strips = [&*self, &other].map(|sum| format!("{:?}", sum.strip()));
            let [own, others] = strips;
            return different("rows of C", own, others);
        }
        if self.is_centered() != other.is_centered() {
            let name = |c: bool| if c { "centred" } else { "not centred" }.to_owned();
            return different("centring", name(self.is_centered()), name(other.is_centered()));
        }
        let expected_rows = self.expected_rows().saturating_add(other.expected_rows());
        match (&mut self.sums, other.sums) {
            (Sums::Float(own), Sums::Float(others)) => own.merge(others),
            (Sums::Exact(own), Sums::Exact(others)) => own.merge(others)?,
            (Sums::Extended(own), Sums::Extended(others)) => own.merge(others)?,
            (own, others) => return different("sums", own.name().into(), others.name().into()),
        }
        self.expected_rows = expected_rows;
        self.block_rows = 0;
        self.labels.retain(|label| other.labels.contains(label));
        Ok(())
    }

    /// Returns `alpha C`, about the mean when centred. An accumulator for all of C returns the
    /// triangle or triangles of `uplo`, and zeros in the other one. A strip has its part of the
    /// lower triangle and zeros above the diagonal, whatever `uplo` is. The result takes over the
    /// memory of the accumulator, unless that is exact.
    ///
    /// ```
    /// use catamaran::{AtaOptions, Uplo, rows::Accumulator, faer::mat};
    ///
    /// let mut sum = Accumulator::<f64>::new(2, false)?;
    /// sum.add_block(mat![[1.0, 2.0]], None, &AtaOptions::new())?;
    /// assert_eq!(sum.finish(10.0, Uplo::Upper)?.as_ref(), mat![[10.0, 20.0], [0.0, 40.0]]);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Argument`] when the weights of a mean sum to zero; of an exact accumulator
    /// [`Error::OutOfMemory`].
    pub fn finish(self, alpha: f64, uplo: Uplo) -> Result<Strip<T>> {
        let ncols = self.ncols;
        let mut c = match self.sums {
            Sums::Float(sums) => sums.finish(alpha)?,
            Sums::Exact(sums) => sums.finish(alpha)?,
            Sums::Extended(sums) => sums.finish(alpha)?,
        };
        if c.rows() == (0..ncols) && uplo != Uplo::Lower {
            mirror_lower(c.as_mut());
            if uplo == Uplo::Upper {
                // The strict lower triangle is the strict upper one of the transpose: the diagonal
                // is skipped.
                let below = c.as_mut().submatrix_mut(
                    1.min(ncols),
                    0,
                    ncols.saturating_sub(1),
                    ncols.saturating_sub(1),
                );
                scale_lower(below, T::ZERO);
            }
        }
        Ok(c)
    }

    /// Returns C in extended precision, about the mean when centred. The result is the same, bit
    /// for bit, for every `par`.
    ///
    /// # Errors
    /// [`Error::Argument`] when the accumulator is not one of [`Accumulator::extended`], or when
    /// the weights of a mean sum to zero; [`Error::NonFinite`] for the first column (as index (0,
    /// j)) with a NaN or an infinity; [`Error::OutOfMemory`].
    pub fn finish_extended(self, par: Par) -> Result<ExtendedGram> {
        match self.sums {
            Sums::Extended(sums) => sums.parts(par),
            sums => {
                let why = format!("{} sums have no extended precision", sums.name());
                Err(Error::Argument { what: "accumulator", why })
            }
        }
    }
}

impl<T> Sums<T> {
    fn name(&self) -> &'static str {
        match self {
            Self::Float(_) => "floating-point",
            Self::Exact(_) => "exact",
            Self::Extended(_) => "extended",
        }
    }
}

pub(super) fn check_strip(rows: &Range<usize>, ncols: usize) -> Result<()> {
    if rows.start <= rows.end && rows.end <= ncols {
        return Ok(());
    }
    let why = format!("{}..{} is not inside 0..{ncols}", rows.start, rows.end);
    Err(Error::Argument { what: "strip", why })
}
