//! The grid of exact sums: the unit that each column is rounded to, chosen before the first row.

use super::blocks::{CodedRows, check_block_rows, for_each_block};
use super::coding::Coding;
use super::source::RowBlocks;
use crate::base::{Error, Par, Real, Result, push, widest, zeros};
use crate::kernel::int8::{IntegerModuli, WIDE_BITS, power_of_two, scaled};
use crate::product::AtaOptions;

/// Returns the most bits of the integers that entries become: as few as an f64 shifted near its
/// column needs (see [`Grid::new`]), so that 2^26 rows fit in 128 bits and 2^16 in the residues.
const fn most_bits<T>() -> i32 {
    if size_of::<T>() == 8 { 50 } else { 24 }
}

/// Returns the number of moduli of the products: one more than `A^T A` takes by default, for
/// columns whose largest entry is far above the others.
pub(super) const fn moduli<T>() -> usize {
    if size_of::<T>() == 8 { 15 } else { 8 }
}

/// Bits of a sum.
const SUM_BITS: i32 = 126;

/// Bits of a sum in extended precision.
const EXTENDED_SUM_BITS: i32 = 250;

/// Least log2 of the rows that are multiplied at a time in extended precision.
const EXTENDED_SLAB_BITS: i32 = 14;

/// A column is shifted to within this many bits of its largest entry and no further: its unit is
/// then below the last bit of an f64, and grids of several files stay near each other.
const MOST_SHIFT: i32 = 5;

/// Power of a column of zeros, which are multiples of any unit.
const ZEROS: i32 = i32::MIN;

/// Bounds of the entries of each column, of the weights, and of the number of rows: what exact sums
/// must know before the first row ([`Accumulator::exact`](super::Accumulator::exact)).
///
/// They are declared ([`RowBounds::new`]), or found by a pass over the rows ([`RowBounds::of`]), in
/// any order, and may be joined. Sums with the same bounds are the same bytes for any cut and order
/// of the rows.
///
/// ```
/// use catamaran::{AtaOptions, rows::{DenseRows, RowBounds}, faer::mat};
///
/// let a = mat![[1.0, -2.0], [3.0, 0.5]];
/// let mut bounds = RowBounds::of(&mut DenseRows(a.as_ref()), None, 64, &AtaOptions::new())?;
/// bounds.join(&RowBounds::new(vec![0.0, 0.0], vec![9.0, 0.0], 100)?)?;
/// assert_eq!((bounds.lower(), bounds.upper()), (&[0.0, -2.0][..], &[9.0, 0.5][..]));
/// assert_eq!(bounds.rows(), 102);
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct RowBounds<T> {
    lower: Vec<T>,
    upper: Vec<T>,
    /// Powers of two, or less, that all entries of a column are multiples of; infinite for zeros,
    /// and 0 where nothing is known.
    units: Vec<f64>,
    weight: Option<T>,
    pub(super) rows: u64,
}

impl<T: Real> RowBounds<T> {
    /// Declares bounds for at most `rows` rows, whose entries in column j are between `lower[j]`
    /// and `upper[j]`.
    ///
    /// ```
    /// use catamaran::rows::RowBounds;
    ///
    /// let bounds = RowBounds::new(vec![0.0, -1.0], vec![9.0, 1.0], 100)?.with_weights(2.0)?;
    /// assert_eq!((bounds.ncols(), bounds.rows(), bounds.weight()), (2, 100, Some(2.0)));
    /// assert!(RowBounds::new(vec![1.0], vec![0.0], 100).is_err());
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Shape`], [`Error::NonFinite`], and [`Error::Argument`] when a lower bound is above
    /// the upper one.
    pub fn new(lower: Vec<T>, upper: Vec<T>, rows: u64) -> Result<Self> {
        Error::check_shape("upper bounds", (lower.len(), 1), (upper.len(), 1))?;
        for (j, (low, high)) in lower.iter().zip(&upper).enumerate() {
            if !low.is_finite() || !high.is_finite() {
                return Err(Error::NonFinite { what: "bounds", index: (0, j) });
            }
            if low > high {
                let why =
                    format!("column {j}: the lower bound {low} is above the upper bound {high}");
                return Err(Error::Argument { what: "bounds", why });
            }
        }
        let units = zeros(lower.len())?;
        Ok(Self { lower, upper, units, weight: None, rows })
    }

    /// Sets the bound of the weights: no absolute value is larger.
    ///
    /// # Errors
    /// [`Error::Argument`] when it is negative or not finite.
    pub fn with_weights(self, largest: T) -> Result<Self> {
        if !largest.is_finite() || largest < T::ZERO {
            let why = format!("the bound {largest} is negative or not finite");
            return Err(Error::Argument { what: "weights", why });
        }
        Ok(Self { weight: Some(largest), ..self })
    }

    /// Returns the bounds of no rows, which [`RowBounds::join`] extends.
    pub(super) fn none(n: usize) -> Result<Self> {
        let (mut lower, mut upper) = (zeros::<T>(n)?, zeros::<T>(n)?);
        lower.fill(T::from_f64(f64::INFINITY));
        upper.fill(T::from_f64(f64::NEG_INFINITY));
        let mut units = zeros::<f64>(n)?;
        units.fill(f64::INFINITY);
        Ok(Self { lower, upper, units, weight: None, rows: 0 })
    }

    /// Reads all rows once, in blocks of `block_rows`, and returns the bounds of the finite
    /// entries, of the weights, and the number of rows. `options.progress` receives the fraction
    /// that has been read.
    ///
    /// ```
    /// use catamaran::{AtaOptions, rows::{DenseRows, RowBounds}, faer::mat};
    ///
    /// let a = mat![[1.0, f64::NAN], [-3.0, 0.5]];
    /// let options = AtaOptions::new();
    /// let bounds = RowBounds::<f64>::of(&mut DenseRows(a.as_ref()), None, 64, &options)?;
    /// assert_eq!((bounds.lower(), bounds.upper()), (&[-3.0, 0.5][..], &[1.0, 0.5][..]));
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Argument`] for `block_rows` 0; those of the source, [`Error::OutOfMemory`],
    /// [`Error::Cancelled`].
    pub fn of(
        rows: &mut (dyn RowBlocks<T> + Send),
        weights: Option<&[T]>,
        block_rows: usize,
        options: &AtaOptions<'_>,
    ) -> Result<Self> {
        Self::read(rows, weights, block_rows, false, options)
    }

    /// Reads bounds as [`RowBounds::of`] does; [`Error::NonFinite`] names the first non-finite
    /// entry.
    pub(crate) fn of_finite(
        rows: &mut (dyn RowBlocks<T> + Send),
        weights: Option<&[T]>,
        block_rows: usize,
        options: &AtaOptions<'_>,
    ) -> Result<Self> {
        Self::read(rows, weights, block_rows, true, options)
    }

    fn read(
        rows: &mut (dyn RowBlocks<T> + Send),
        weights: Option<&[T]>,
        block_rows: usize,
        refuse: bool,
        options: &AtaOptions<'_>,
    ) -> Result<Self> {
        check_block_rows(block_rows)?;
        if let Some(coding) = rows.coding() {
            let rows = &mut CodedRows::new(rows, &coding);
            return match Self::read(rows, weights, block_rows, refuse, options) {
                Ok(bounds) => bounds.decoded(&coding),
                Err(Error::NonFinite { what, index: (i, j) }) => {
                    Err(Error::NonFinite { what, index: (i, coding.column(j)) })
                }
                Err(other) => Err(other),
            };
        }
        let (m, n) = (rows.nrows(), rows.ncols());
        let mut bounds = Self::none(n)?;
        bounds.rows = m as u64;
        if let Some(weights) = weights {
            let larger = |x: T, w: &T| if w.abs() > x { w.abs() } else { x };
            bounds.weight = Some(weights.iter().fold(T::ZERO, larger));
        }
        if n == 0 {
            return Ok(bounds);
        }
        for_each_block(rows, 0, block_rows, options.par, |first, block| {
            let finite = options.on_cores(|| bounds.widen(block, n, options.par))?;
            if refuse && !finite {
                return Err(first_non_finite(block, n, first));
            }
            options.progress.report((first + block.len() / n) as f64 / m as f64)
        })?;
        Ok(bounds)
    }

    /// Returns the bounds of all columns, from those of coded rows.
    fn decoded(&self, coding: &Coding) -> Result<Self> {
        let mut sources = vec![None; coding.ncols()];
        coding.numbers.iter().enumerate().for_each(|(own, &j)| sources[j] = Some(own));
        self.arranged(sources.into_iter())
    }

    /// Returns the bounds of other columns, each the column here with this number, or one of zeros
    /// and ones.
    pub(super) fn arranged(&self, sources: impl Iterator<Item = Option<usize>>) -> Result<Self> {
        let mut all = Self { weight: self.weight, rows: self.rows, ..Self::none(0)? };
        for source in sources {
            let (lower, upper, unit) = match source {
                Some(j) => (self.lower[j], self.upper[j], self.units[j]),
                None => (T::ZERO, T::ONE, lowest_bit(1.0)),
            };
            push(&mut all.lower, lower)?;
            push(&mut all.upper, upper)?;
            push(&mut all.units, unit)?;
        }
        Ok(all)
    }

    /// Extends the bounds to the finite entries of rows; returns whether all entries are finite.
    pub(super) fn widen(&mut self, block: &[T], n: usize, par: Par) -> Result<bool> {
        /// Entries that one thread reads at a time.
        const PIECE: usize = 1 << 18;
        let rows = (PIECE / n).max(1);
        let none = Self::none(n)?;
        let pieces = par.map_blocks(block.len() / n, rows, |rows| {
            let block = &block[rows.start * n..rows.end * n];
            let mut bounds = none.clone();
            let finite = widest(
                #[inline(always)]
                || bounds.include(block),
            );
            (bounds, finite)
        });
        let mut finite = true;
        for (bounds, all) in &pieces {
            self.hull(bounds);
            finite &= all;
        }
        Ok(finite)
    }

    /// Extends the bounds on one thread; returns whether all entries are finite.
    #[inline(always)]
    pub(super) fn include(&mut self, block: &[T]) -> bool {
        let infinity = T::from_f64(f64::INFINITY);
        let Self { lower, upper, units, .. } = self;
        let mut all = true;
        for row in block.chunks_exact(lower.len()) {
            for (((&x, lower), upper), unit) in
                row.iter().zip(&mut *lower).zip(&mut *upper).zip(&mut *units)
            {
                // False for NaN.
                let finite = x.abs() < infinity;
                all &= finite;
                *lower = if finite && x < *lower { x } else { *lower };
                *upper = if finite && x > *upper { x } else { *upper };
                let own = lowest_bit(x.to_f64());
                *unit = if finite && own > 0.0 && own < *unit { own } else { *unit };
            }
        }
        all
    }

    /// Extends the bounds to the smallest that contain both.
    fn hull(&mut self, other: &Self) {
        let Self { lower, upper, units, .. } = other;
        for j in 0..self.lower.len() {
            self.lower[j] = if lower[j] < self.lower[j] { lower[j] } else { self.lower[j] };
            self.upper[j] = if upper[j] > self.upper[j] { upper[j] } else { self.upper[j] };
            self.units[j] = self.units[j].min(units[j]);
        }
    }

    /// Extends the bounds to those of all rows, with the `other` rows of the same columns. The
    /// numbers of rows add up.
    ///
    /// # Errors
    /// [`Error::Argument`] when they have another number of columns, or only one of them has
    /// weights.
    pub fn join(&mut self, other: &Self) -> Result<()> {
        let refuse = |why: &str| Err(Error::Argument { what: "bounds", why: why.into() });
        if self.ncols() != other.ncols() {
            return refuse("the numbers of columns differ");
        }
        self.weight = match (self.weight, other.weight) {
            (Some(a), Some(b)) => Some(if a > b { a } else { b }),
            (None, None) => None,
            _ => return refuse("only one of the two has weights"),
        };
        self.hull(other);
        self.rows = self.rows.saturating_add(other.rows);
        Ok(())
    }

    /// Returns the number of columns.
    pub fn ncols(&self) -> usize {
        self.lower.len()
    }

    /// Returns the largest number of rows.
    pub fn rows(&self) -> u64 {
        self.rows
    }

    /// Returns the lower bounds; infinite for a column without finite entries.
    pub fn lower(&self) -> &[T] {
        &self.lower
    }

    /// Returns the upper bounds; minus infinity for a column without finite entries.
    pub fn upper(&self) -> &[T] {
        &self.upper
    }

    /// Returns the bound of the absolute values of the weights; `None` without weights.
    pub fn weight(&self) -> Option<T> {
        self.weight
    }

    /// Returns what all entries of each column are multiples of (see the field).
    #[cfg(feature = "mpi")]
    pub(crate) fn units(&self) -> &[f64] {
        &self.units
    }

    /// Creates bounds from parts that other ranks have sent.
    #[cfg(feature = "mpi")]
    pub(crate) fn from_parts(
        [lower, upper]: [Vec<T>; 2],
        units: Vec<f64>,
        weight: Option<T>,
        rows: u64,
    ) -> Self {
        Self { lower, upper, units, weight, rows }
    }
}

/// Returns the error for the first non-finite entry of rows of `n` columns from `first` on.
pub(super) fn first_non_finite<T: Real>(block: &[T], n: usize, first: usize) -> Error {
    let at = block.iter().position(|x| !x.is_finite()).unwrap_or(0);
    Error::NonFinite { what: "rows", index: (first + at / n, at % n) }
}

/// Returns the value of the last one bit of a finite number, half of it for a power of two, 0 for
/// 0.
#[inline(always)]
fn lowest_bit(x: f64) -> f64 {
    let bits = x.to_bits();
    (x - f64::from_bits(bits & bits.wrapping_sub(1))).abs()
}

/// The shift and the unit of every entry. A row x with weight w becomes the integers `rint((x_j -
/// s_j) 2^p_j)` on the left and `rint(w (x_j - s_j) 2^(p_j - e))` on the right side, where e is
/// that of the weights; so entry (i, j) of the product counts units of `2^-(p_i + p_j - e)`.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Grid<T> {
    /// Bounds of the entries.
    pub lower: Vec<T>,
    pub upper: Vec<T>,
    /// Subtracted from the rows: n entries, or none.
    pub shift: Vec<T>,
    /// p; [`ZEROS`] for a column of zeros.
    pub powers: Vec<i32>,
    /// Whether the integers are wide, and their sums have 256 bits.
    pub extended: bool,
    /// Bound of the weights; none without weights.
    pub weight: Option<T>,
    /// e: no weight is above 2^e; 0 without weights.
    pub weight_exponent: i32,
    /// Weights become `rint(w 2^weight_power)`; 0 without weights.
    pub weight_power: i32,
}

/// How rows are shifted.
pub(crate) enum Shift<'s, T> {
    /// Not at all.
    No,
    /// By something near the middle of their bounds: the sums are to be about the mean.
    Near,
    /// By this row.
    Given(&'s [T]),
}

impl<T: Real> Grid<T> {
    /// Creates the grid for rows within bounds.
    ///
    /// About a mean, column j is shifted by a multiple of its radius near the middle of its bounds:
    /// x - s then has no more bits than x, and what is left of them fits the integers, however
    /// large the mean is beside the deviations.
    ///
    /// # Errors
    /// [`Error::Argument`] when rows, or rows times weights, are too large or too many.
    pub fn new(bounds: &RowBounds<T>, shift: Shift<'_, T>, extended: bool) -> Result<Self> {
        let n = bounds.ncols();
        let rows = bounds.rows.max(1);
        let rows_bits = (u64::BITS - (rows - 1).leading_zeros()) as i32;
        let bits = match extended {
            true => WIDE_BITS,
            false => most_bits::<T>().min((SUM_BITS - rows_bits) / 2),
        };
        let mut grid = Self {
            lower: zeros(n)?,
            upper: zeros(n)?,
            shift: match shift {
                Shift::No => Vec::new(),
                Shift::Near => zeros(n)?,
                Shift::Given(shift) => shift.to_vec(),
            },
            powers: vec![ZEROS; n],
            extended,
            weight: bounds.weight,
            weight_exponent: 0,
            weight_power: 0,
        };
        if let Some(weight) = bounds.weight {
            // Below the limit columns may be subnormal too.
            let least = if size_of::<T>() == 8 { -800 } else { -76 };
            grid.weight_exponent = exponent(weight.to_f64()).max(least);
            grid.weight_power = bits - 1 - grid.weight_exponent;
        }
        for j in 0..n {
            // Columns without finite entries keep their bounds of zero. -0 becomes 0.
            if bounds.lower[j] <= bounds.upper[j] {
                grid.lower[j] = bounds.lower[j] + T::ZERO;
                grid.upper[j] = bounds.upper[j] + T::ZERO;
            }
            if matches!(shift, Shift::Near) {
                grid.shift[j] = middle(grid.lower[j], grid.upper[j]);
            }
            let radius = grid.radius(j);
            if radius == 0.0 && !matches!(shift, Shift::Near) {
                continue;
            }
            let mut exponent = exponent(radius);
            if matches!(shift, Shift::Near) {
                // The unit must divide the shift even where the radius is small.
                let size = grid.lower[j].abs().to_f64().max(grid.upper[j].abs().to_f64());
                if size == 0.0 {
                    continue;
                }
                exponent = exponent.max(self::exponent(size) - MOST_SHIFT + 1);
            }
            if !radius.is_finite() || exponent + grid.weight_exponent > most_exponent::<T>() {
                let why =
                    format!("column {j}: its range times the weights exceeds that of {}", T::NAME);
                return Err(Error::Argument { what: "bounds", why });
            }
            grid.powers[j] = bits - exponent;
            // If all entries are multiples of a larger unit, that unit rounds nothing.
            let unit = bounds.units[j];
            if extended && grid.weight.is_none() && unit > 0.0 && unit.is_finite() {
                grid.powers[j] = grid.powers[j].min(1 - self::exponent(unit));
            }
        }
        Ok(grid)
    }

    /// Returns whether [`Grid::new`] or [`Grid::join`] may have made this grid.
    pub fn is_sound(&self) -> bool {
        let range = if size_of::<T>() == 8 { -1100..=1300 } else { -160..=250 };
        let power = |p: i32| p == ZEROS || range.contains(&p);
        let bounded = |j: usize| {
            let ordered = self.lower[j] <= self.upper[j];
            ordered
                && self.radius(j).is_finite()
                && (self.powers[j] != ZEROS || self.radius(j) == 0.0)
        };
        self.powers.iter().all(|&p| power(p))
            && (0..self.ncols()).all(bounded)
            && self.weight.is_none_or(|w| w.is_finite() && w >= T::ZERO)
            && (-860..=1024).contains(&self.weight_exponent)
            && (-1100..=1000).contains(&self.weight_power)
            && (0..=WIDE_BITS).contains(&(self.weight_exponent + self.weight_power))
            && self.powers(true).all(|p| (-2000..=2000).contains(&p))
    }

    /// Returns the number of columns.
    pub fn ncols(&self) -> usize {
        self.powers.len()
    }

    /// Returns the grid of some of the columns.
    pub fn of_columns(&self, columns: &[usize]) -> Self {
        let some = |of: &[T]| columns.iter().filter_map(|&j| of.get(j).copied()).collect();
        let powers = columns.iter().map(|&j| self.powers[j]).collect();
        let (lower, upper, shift) = (some(&self.lower), some(&self.upper), some(&self.shift));
        Self { lower, upper, shift, powers, ..*self }
    }

    /// Returns what is subtracted from column j.
    pub fn shift_of(&self, j: usize) -> T {
        self.shift.get(j).copied().unwrap_or(T::ZERO)
    }

    /// Returns the largest absolute value of a shifted entry of column j.
    fn radius(&self, j: usize) -> f64 {
        let shift = self.shift_of(j);
        let ends = [self.lower[j] - shift, self.upper[j] - shift];
        ends[0].abs().to_f64().max(ends[1].abs().to_f64())
    }

    /// Returns the bits of the integers that entries of column j become.
    pub fn bits(&self, j: usize) -> i32 {
        match self.powers[j] {
            ZEROS => 0,
            power => (exponent(self.radius(j)) + power).max(0),
        }
    }

    /// Returns how many rows the sums have room for.
    pub fn capacity(&self) -> Capacity {
        let column = (0..self.ncols()).max_by_key(|&j| self.bits(j)).unwrap_or(0);
        let bits = if self.ncols() == 0 { 0 } else { self.bits(column) };
        let rows = |room: i32| if room < 0 { 0 } else { 1_u64 << room.min(62) };
        let (moduli, sum_bits) = match self.extended {
            // Larger integers than conversion takes have no moduli.
            true if bits > WIDE_BITS => (None, EXTENDED_SUM_BITS),
            true => (IntegerModuli::count_for(2 * bits + EXTENDED_SLAB_BITS), EXTENDED_SUM_BITS),
            false => (Some(moduli::<T>()), SUM_BITS),
        };
        let room = |count| (IntegerModuli::bits(count) - 1.01).floor() as i32 - 2 * bits;
        Capacity {
            moduli: moduli.unwrap_or(2),
            slab: moduli.map_or(0, |count| rows(room(count).min(30)) as usize),
            rows: rows(sum_bits - 2 * bits),
            column,
        }
    }

    /// Returns the powers that columns are multiplied by: on the left side, or `weighted` on the
    /// right.
    pub fn powers(&self, weighted: bool) -> impl Iterator<Item = i32> {
        let less = if weighted { self.weight_exponent } else { 0 };
        self.powers.iter().map(move |&power| if power == ZEROS { 0 } else { power - less })
    }

    /// Returns what entries are multiplied by before they are rounded, on the left or the right
    /// side (`weighted`), in two factors for each column.
    pub fn factors(&self, weighted: bool) -> Vec<[f64; 2]> {
        let factors = |(j, power): (usize, i32)| match self.powers[j] {
            ZEROS => [0.0; 2],
            _ => [power >> 1, power - (power >> 1)].map(power_of_two),
        };
        self.powers(weighted).enumerate().map(factors).collect()
    }

    /// Returns the integer that a weight becomes.
    pub fn weight_integer(&self, weight: T) -> i128 {
        scaled(weight.to_f64(), self.weight_power).round_ties_even() as i128
    }

    /// Returns log2 of the unit of entry (i, j) of the product; anything for a column of zeros.
    pub fn exponent(&self, i: usize, j: usize) -> i32 {
        match (self.powers[i], self.powers[j]) {
            (ZEROS, _) | (_, ZEROS) => 0,
            (p, q) => self.weight_exponent - p - q,
        }
    }

    /// Returns log2 of the unit of the sum of column j.
    pub fn sum_exponent(&self, j: usize) -> i32 {
        match self.powers[j] {
            ZEROS => 0,
            power => self.weight_exponent - power,
        }
    }

    /// Returns the grid that contains both. Each column takes the finer unit and the shift of that
    /// grid; of equally fine grids, the lower shift. The result is the same for any order of grids.
    pub fn join(&self, other: &Self) -> Result<Self> {
        let refuse = |why: String| Err(Error::Argument { what: "accumulator", why });
        if self.weight.is_some() != other.weight.is_some() {
            return refuse("grid: sums with and without weights can't be merged".into());
        }
        let mut joined = self.clone();
        for j in 0..self.ncols() {
            let key = |grid: &Self| (grid.powers[j], -grid.shift_of(j).to_f64());
            if key(other) > key(self) {
                joined.powers[j] = other.powers[j];
                if !self.shift.is_empty() {
                    joined.shift[j] = other.shift[j];
                }
            }
            joined.lower[j] =
                if other.lower[j] < self.lower[j] { other.lower[j] } else { self.lower[j] };
            joined.upper[j] =
                if other.upper[j] > self.upper[j] { other.upper[j] } else { self.upper[j] };
        }
        if let (Some(a), Some(b)) = (self.weight, other.weight) {
            joined.weight = Some(if a > b { a } else { b });
        }
        joined.weight_exponent = self.weight_exponent.min(other.weight_exponent);
        joined.weight_power = self.weight_power.max(other.weight_power);
        Ok(joined)
    }

    /// Returns how many bits finer column j is in `fine`; 0 where the column is zero here.
    pub fn finer(&self, j: usize, fine: &Self) -> u32 {
        match self.powers[j] {
            ZEROS => 0,
            power => (fine.powers[j] - power) as u32,
        }
    }

    /// Returns the shift of column j here less that in `fine`, in units of `fine`; `None` when the
    /// difference is no integer.
    pub fn shift_difference(&self, j: usize, fine: &Self) -> Option<i128> {
        let (own, others) = (self.shift_of(j), fine.shift_of(j));
        if own == others {
            return Some(0);
        }
        let units = |x: T| {
            let units = scaled(x.to_f64(), fine.powers[j]);
            let fits = units.abs() < power_of_two(120) && units == units.round_ties_even();
            fits.then_some(units as i128)
        };
        Some(units(own)? - units(others)?)
    }
}

/// The capacity of sums on a grid.
pub(super) struct Capacity {
    /// Moduli of a product.
    pub moduli: usize,
    /// Rows whose product is determined by its residues.
    pub slab: usize,
    /// Rows whose sums fit.
    pub rows: u64,
    /// The column that limits the rows.
    pub column: usize,
}

/// Returns the least e with `x <= 2^e`, for x >= 0; that of the least number for 0.
fn exponent(x: f64) -> i32 {
    const MANTISSA: u32 = f64::MANTISSA_DIGITS - 1;
    let bits = x.to_bits();
    match (bits >> MANTISSA) as i32 {
        0 => -1074 + (u64::BITS - bits.saturating_sub(1).leading_zeros()) as i32,
        biased => biased - 1023 + i32::from(bits & ((1 << MANTISSA) - 1) != 0),
    }
}

/// Returns a multiple of a power of two near the radius of an interval that is near its middle.
fn middle<T: Real>(lower: T, upper: T) -> T {
    let (lower, upper) = (lower.to_f64(), upper.to_f64());
    let size = exponent(lower.abs().max(upper.abs()));
    let unit = exponent(upper / 2.0 - lower / 2.0).max(size - MOST_SHIFT);
    // Near the end of the range the multiple may be infinite.
    if size >= most_exponent::<T>() {
        return T::ZERO;
    }
    let middle = upper / 2.0 + lower / 2.0;
    T::from_f64(scaled(scaled(middle, -unit).round_ties_even(), unit))
}

/// Returns the exponent e of the upper limit 2^e of all numbers.
const fn most_exponent<T>() -> i32 {
    if size_of::<T>() == 8 { 1024 } else { 128 }
}
