//! Sums of rows in integers on a grid that is chosen before the first row: the same for any order
//! of the rows.

use std::fmt::Display;
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

use faer::MatRef;

use super::blocks::for_each_block;
use super::extended::{About, ExtendedGram};
use super::grid::{Capacity, Grid, RowBounds, Shift, first_non_finite};
use super::moments::check_weight;
use super::pass::{Engine, Pass, Scaling};
use super::pieces::{Piece, block_pieces};
use super::source::DenseRows;
use super::strip::Strip;
use super::wide::{self, SumInteger};
use crate::base::{
    Error, Par, Real, Result, repeated, reserved, triangle_len, triangle_rows, widest, zeros,
};
use crate::blas::BlasReal;
use crate::kernel::int8::{I256, Integer, WIDE_BITS, power_of_two, scaled};
use crate::product::AtaOptions;
use crate::product::exact::{Columns, Flags, Signs};

/// Rows that one thread takes at a time.
const PIECE: usize = 512;

/// A sum `C = sum of w_i x_i x_i^T` of shifted rows, as integers in units of the grid; some rows of
/// the lower triangle. In extended precision the integers have 256 bits.
#[derive(Debug)]
pub(crate) struct ExactSums<T, I = i128> {
    pub(super) grid: Grid<T>,
    pub(super) strip: Range<usize>,
    /// Whether the result is about the mean.
    pub(super) centered: bool,
    /// Rows so far.
    pub(super) rows: u64,
    /// Those of weight 0.
    pub(super) weightless: u64,
    /// Sum of the weights, and of their absolute values, as integers.
    pub(super) weights: [i128; 2],
    /// Sums of the weighted columns; none without centring.
    pub(super) sums: Vec<i128>,
    /// The rows of the triangle, one after another.
    pub(super) entries: Vec<I>,
    /// For each entry which terms are not finite; empty while all are.
    pub(super) flags: Vec<u8>,
    /// Whether an entry was rounded; in extended precision only.
    pub(super) rounded: bool,
}

/// The results of one thread for its rows.
struct Found {
    /// Sums of the weighted columns.
    sums: Vec<i128>,
    /// The first entry beyond its bounds: column and value.
    beyond: Option<(usize, f64)>,
    /// Whether the columns are finite on both sides; empty if all are.
    finite: [Vec<bool>; 2],
    /// Whether an entry is not on the grid.
    rounded: bool,
    /// Whether all products of rows and weights are exact in f64.
    no_tail: bool,
}

impl<T: BlasReal, I: SumInteger> ExactSums<T, I> {
    /// Returns a copy, bit for bit.
    pub fn try_clone(&self) -> Result<Self> {
        let mut entries = reserved(self.entries.len())?;
        entries.extend_from_slice(&self.entries);
        let (grid, strip) = (self.grid.clone(), self.strip.clone());
        let mut flags = reserved(self.flags.len())?;
        flags.extend_from_slice(&self.flags);
        let sums = self.sums.clone();
        Ok(Self { grid, strip, sums, entries, flags, ..*self })
    }

    /// Creates the sums of no rows.
    pub fn new(bounds: &RowBounds<T>, strip: Range<usize>, shift: Shift<'_, T>) -> Result<Self> {
        let centered = matches!(shift, Shift::Near);
        Self::on(Grid::new(bounds, shift, I::EXTENDED)?, strip, centered)
    }

    /// Creates the sums of no rows, on a grid.
    pub(super) fn on(grid: Grid<T>, strip: Range<usize>, centered: bool) -> Result<Self> {
        let len = triangle_len(strip.end) - triangle_len(strip.start);
        let sums = zeros(if centered { grid.ncols() } else { 0 })?;
        let entries = zeros(len)?;
        Ok(Self {
            grid,
            strip,
            centered,
            rows: 0,
            weightless: 0,
            weights: [0; 2],
            sums,
            entries,
            flags: Vec::new(),
            rounded: false,
        })
    }

    /// Returns whether rows within the bounds may have these sums: as many numbers of as many bits
    /// as the grid says. Such sums have room for as many rows as [`Grid::capacity`] says.
    pub fn is_sound(&self) -> bool {
        // Twice, for the rounding of products with weights.
        let most = |bits: i32| 2.0 * self.rows as f64 * f64::from(bits).exp2();
        let of_weights = most(self.grid.weight_exponent + self.grid.weight_power);
        let bits: Vec<i32> = (0..self.grid.ncols()).map(|j| self.grid.bits(j)).collect();
        let first = triangle_len(self.strip.start);
        let row_is_sound = |i: usize| {
            let row = &self.entries[triangle_len(i) - first..][..=i];
            row.iter().zip(&bits).all(|(c, b)| c.to_f64().abs() <= most(bits[i] + b))
        };
        let [weight, size] = self.weights;
        self.weightless <= self.rows
            && weight.checked_abs().is_some_and(|weight| weight <= size)
            && size as f64 <= of_weights
            && self.sums.iter().zip(&bits).all(|(&sum, &b)| (sum as f64).abs() <= most(b))
            && self.strip.clone().all(row_is_sound)
    }

    /// Returns the sum of the weights.
    pub fn weight(&self) -> f64 {
        scaled(self.weights[0] as f64, -self.grid.weight_power)
    }

    /// Returns the (weighted) mean row; empty without centring.
    pub fn mean(&self) -> Vec<f64> {
        let weight = self.weight();
        let mean = |(j, &sum): (usize, &i128)| {
            let (sum, exponent) = (sum as f64, self.grid.sum_exponent(j));
            let whole = scaled(sum, exponent);
            let rest = match whole.is_finite() && weight.is_finite() {
                true => whole / weight,
                // Sums may overflow where means do not.
                false => scaled(sum / self.weights[0] as f64, exponent + self.grid.weight_power),
            };
            self.grid.shift_of(j).to_f64() + rest
        };
        self.sums.iter().enumerate().map(mean).collect()
    }

    /// Adds a block of `count` rows, or subtracts it. Its entries are overwritten; nothing else is
    /// changed by an error except [`Error::Cancelled`] and [`Error::OutOfMemory`].
    pub fn add(
        &mut self,
        count: usize,
        block: &mut [T],
        weights: Option<&[T]>,
        subtract: bool,
        pass: &mut Pass<'_>,
    ) -> Result<()> {
        let n = self.grid.ncols();
        let capacity = self.check(count, weights, subtract)?;
        let first = pass.first;
        let (options, engine, memory) = pass.parts();
        // Weights were declared: rows without weights have weight 1.
        let ones;
        let weights = match (weights, self.grid.weight) {
            (None, Some(_)) => {
                ones = repeated(T::ONE, count)?;
                Some(&ones[..])
            }
            (weights, _) => weights,
        };
        let len = if weights.is_some() { block.len() } else { 0 };
        let tail_len = if I::EXTENDED { len } else { 0 };
        memory.reserve::<T>(len + tail_len)?;
        let (weighted, rest) = memory.as_mut_slice::<T>().split_at_mut(len);
        let tail = &mut rest[..tail_len];
        let sides = [&mut *weighted, &mut *tail];
        let found = options.on_cores(|| self.prepare(block, weights, sides, options.par))?;
        let sign = if subtract { -1 } else { 1 };
        if n > 0 {
            if found.finite.iter().any(|finite| !finite.is_empty()) {
                if subtract {
                    return Err(first_non_finite(block, n, first));
                }
                let right = weights.map(|_| &*weighted);
                options.on_cores(|| self.take_flags(count, block, right, &found, options.par))?;
                for x in block.iter_mut().chain(weighted.iter_mut()).filter(|x| !x.is_finite()) {
                    *x = T::ZERO;
                }
            }
            // Without weights the right side is the left one.
            let mut sides: Vec<Option<&[T]>> = vec![weights.map(|_| &*weighted)];
            if !found.no_tail {
                sides.push(Some(tail));
            }
            self.add_products(count, block, &sides, capacity, subtract, (&options, engine))?;
        }
        self.rounded |= found.rounded;
        for (sum, part) in self.sums.iter_mut().zip(found.sums) {
            *sum = sum.wrapping_add(sign * part);
        }
        let mut add = |weight: i128| {
            self.weights[0] = self.weights[0].wrapping_add(sign * weight);
            self.weights[1] = self.weights[1].wrapping_add(sign * weight.abs());
        };
        match weights {
            None => add(count as i128),
            Some(weights) => weights.iter().for_each(|&w| add(self.grid.weight_integer(w))),
        }
        let weightless = weightless(weights);
        (self.rows, self.weightless) = match subtract {
            true => (self.rows - count as u64, self.weightless - weightless),
            false => (self.rows + count as u64, self.weightless + weightless),
        };
        Ok(())
    }

    /// Adds to C, or subtracts from it, the products of a block of `count` rows with each of these
    /// sides (`None`: itself), in slabs of rows.
    fn add_products(
        &mut self,
        count: usize,
        block: &[T],
        sides: &[Option<&[T]>],
        Capacity { slab, moduli, .. }: Capacity,
        subtract: bool,
        (options, engine): (&AtaOptions<'_>, &mut Engine),
    ) -> Result<()> {
        let n = self.grid.ncols();
        let powers = [false, true].map(|side| self.grid.powers(side).collect());
        let scaling = Scaling { powers, wide: I::EXTENDED, moduli };
        let pieces = sides.len() as f64;
        for (side, right) in sides.iter().enumerate() {
            for first in (0..count).step_by(slab) {
                let rows = first..count.min(first + slab);
                let share = |row: usize| (side as f64 + row as f64 / count as f64) / pieces;
                let progress = options.progress.part(share(rows.start)..share(rows.end));
                let options = options.clone().progress(progress);
                let entries = rows.start * n..rows.end * n;
                let matrix = |side| MatRef::from_row_major_slice(side, rows.len(), n);
                let x = matrix(&block[entries.clone()]);
                let y = right.map(|right| matrix(&right[entries]));
                let sums = (&mut self.entries[..], &self.strip);
                engine.integers(x, y, &scaling, sums, subtract, &options)?;
            }
        }
        Ok(())
    }

    /// Checks that so many rows with these weights can be added or subtracted.
    pub(super) fn check(
        &self,
        count: usize,
        weights: Option<&[T]>,
        subtract: bool,
    ) -> Result<Capacity> {
        let refuse = |what, why| Err(Error::Argument { what, why });
        let capacity = self.grid.capacity();
        let Capacity { slab, rows: room, column, .. } = capacity;
        if subtract && self.rows < count as u64 {
            let why = format!("{count} rows can't be removed from a sum of {}", self.rows);
            return refuse("block", why);
        }
        let weightless = weightless(weights);
        if subtract && self.weightless < weightless {
            let why = format!(
                "{weightless} rows of weight 0 can't be removed from a sum with {} of them",
                self.weightless
            );
            return refuse("weights", why);
        }
        let rows = self.rows.saturating_add(count as u64);
        if !subtract && (slab == 0 || rows > room) {
            let why = format!(
                "{rows} rows, but the grid of column {column} has room for {room}: declare more"
            );
            return refuse("bounds", why);
        }
        let bound = match (weights, self.grid.weight) {
            (None, None) => return Ok(capacity),
            (Some(_), None) => {
                return refuse("weights", "no bound was declared for them".into());
            }
            (_, Some(bound)) => bound,
        };
        let one = [T::ONE];
        let beyond = weights.unwrap_or(&one).iter().find(|w| w.abs() > bound);
        match beyond {
            Some(w) => refuse("weights", format!("{w} is beyond the bound {bound}")),
            None => Ok(capacity),
        }
    }

    /// Checks, before the first of several pieces of `height` rows is added or subtracted, that all
    /// of them can be. [`ExactSums::add`] checks a single piece.
    pub fn check_block(
        &self,
        rows: MatRef<'_, T>,
        weights: Option<&[T]>,
        subtract: bool,
        height: usize,
        par: Par,
    ) -> Result<()> {
        let (m, n) = rows.shape();
        if n == 0 || m <= height {
            return Ok(());
        }
        self.check(m, weights, subtract)?;
        for_each_block(&mut DenseRows(rows), 0, height, par, |first, block| {
            if let Some((j, x)) = first_beyond(block, &self.grid.lower, &self.grid.upper) {
                return Err(self.beyond(j, x));
            }
            match subtract && block.iter().any(|x| !x.is_finite()) {
                true => Err(first_non_finite(block, n, first)),
                false => Ok(()),
            }
        })
    }

    /// Returns the error for the entry x in column j.
    pub(super) fn beyond(&self, j: usize, x: f64) -> Error {
        let (lower, upper) = (self.grid.lower[j], self.grid.upper[j]);
        let why = format!("{x} in column {j} is beyond its bounds {lower}..={upper}");
        Error::Argument { what: "rows", why }
    }

    /// Checks the bounds of rows, shifts them, multiplies them by their weights, and adds up the
    /// columns. The products go to the first of `sides`, which is empty without weights, their
    /// rounding errors to the second, which is empty but in extended precision.
    fn prepare(
        &self,
        block: &mut [T],
        weights: Option<&[T]>,
        sides: [&mut [T]; 2],
        par: Par,
    ) -> Result<Found> {
        let n = self.grid.ncols();
        let none = |sums| Found {
            sums,
            beyond: None,
            finite: Default::default(),
            rounded: false,
            no_tail: true,
        };
        if n == 0 {
            return Ok(none(Vec::new()));
        }
        let nothing = || none(vec![0; self.sums.len()]);
        let pieces = block_pieces(block, n, PIECE, weights, sides);
        let mut pieces: Vec<_> = pieces.map(|piece| (piece, nothing())).collect();
        let factors = [false, true].map(|side| self.grid.factors(side));
        par.for_each(pieces.iter_mut(), |_, (piece, found)| {
            widest(
                #[inline(always)]
                || self.prepare_piece(piece, found, &factors),
            );
        });
        let mut all = nothing();
        for (_, found) in pieces {
            if let Some((j, x)) = found.beyond {
                return Err(self.beyond(j, x));
            }
            all.rounded |= found.rounded;
            all.no_tail &= found.no_tail;
            for (sum, part) in all.sums.iter_mut().zip(found.sums) {
                *sum += part;
            }
            for (all, part) in all.finite.iter_mut().zip(found.finite) {
                match all.is_empty() {
                    true => *all = part,
                    false => all.iter_mut().zip(part).for_each(|(a, b)| *a &= b),
                }
            }
        }
        Ok(all)
    }

    #[inline(always)]
    fn prepare_piece(
        &self,
        piece: &mut Piece<'_, T, 2>,
        found: &mut Found,
        factors: &[Vec<[f64; 2]>; 2],
    ) {
        let Grid { lower, upper, shift, .. } = &self.grid;
        let n = lower.len();
        let Piece { rows, weights, outputs: [weighted, tail] } = piece;
        let infinity = T::from_f64(f64::INFINITY);
        let (mut inside, mut finite) = (true, true);
        for row in rows.chunks_exact(n) {
            for ((&x, &lower), &upper) in row.iter().zip(lower).zip(upper) {
                finite &= x.abs() < infinity;
                inside &= x >= lower && x <= upper;
            }
        }
        if !inside {
            found.beyond = first_beyond(rows, lower, upper);
        }
        if found.beyond.is_some() {
            return;
        }
        for (i, row) in rows.chunks_exact_mut(n).enumerate() {
            for (x, &shift) in row.iter_mut().zip(shift) {
                *x -= shift;
            }
            let Some(weights) = weights else { continue };
            let weight = weights[i];
            for (out, &x) in weighted[i * n..].iter_mut().zip(row.iter()) {
                *out = weight * x;
            }
            if I::EXTENDED {
                let products = weighted[i * n..].iter().zip(row.iter());
                for (tail, (&product, &x)) in tail[i * n..].iter_mut().zip(products) {
                    let (weight, x) = (weight.to_f64(), x.to_f64());
                    let rest = weight.mul_add(x, -product.to_f64());
                    // A product that is not finite has no rounding error.
                    *tail = if product.abs() < infinity { T::from_f64(rest) } else { T::ZERO };
                    found.no_tail &= *tail == T::ZERO;
                }
            }
        }
        let mut right: [&[T]; 2] = [if weights.is_some() { weighted } else { rows }, &[]];
        if !found.no_tail {
            right[1] = tail;
        }
        if self.centered {
            for side in right {
                add_columns(side, &factors[1], &mut found.sums);
            }
        }
        // One rounded entry is enough.
        if I::EXTENDED && !self.rounded {
            found.rounded = is_rounded(rows, &factors[0]);
            if weights.is_some() {
                found.rounded |= right.iter().any(|side| is_rounded(side, &factors[1]));
            }
        }
        if !finite {
            let columns = |side: &[T]| {
                let mut finite = vec![true; n];
                for (i, x) in side.iter().enumerate() {
                    finite[i % n] &= x.is_finite();
                }
                finite
            };
            found.finite = [columns(rows), columns(weighted)];
        }
    }

    /// Records which terms of a block are not finite.
    fn take_flags(
        &mut self,
        count: usize,
        block: &[T],
        weighted: Option<&[T]>,
        found: &Found,
        par: Par,
    ) -> Result<()> {
        let n = self.grid.ncols();
        let columns = |finite: &[bool]| {
            let non_finite = (0..n).filter(|&j| finite.get(j) == Some(&false));
            let non_finite = non_finite.collect();
            Columns { exponents: Vec::new(), non_finite, wide: false }
        };
        let matrix = |rows| MatRef::from_row_major_slice(rows, count, n);
        let left = columns(&found.finite[0]);
        let right = columns(&found.finite[1]);
        let left = (matrix(block), &left);
        let right = weighted.map_or(left, |weighted| (matrix(weighted), &right));
        let Some(signs) = Signs::of_product(left, right, par)? else { return Ok(()) };
        if self.flags.is_empty() {
            self.flags = zeros(self.entries.len())?;
        }
        let rows = triangle_rows(&mut self.flags, self.strip.clone());
        par.for_each(rows, |_, (i, row)| {
            for (j, flags) in row.iter_mut().enumerate() {
                *flags |= signs.flags(i, j).0;
            }
        });
        Ok(())
    }

    /// Adds the sums of other rows of the same columns and strip. If the grids differ, both sums
    /// first move to the finer grid, exactly.
    pub fn merge(&mut self, mut other: Self) -> Result<()> {
        if self.grid != other.grid {
            let grid = self.grid.join(&other.grid)?;
            self.move_to(&grid)?;
            other.move_to(&grid)?;
        }
        self.rows = self.rows.saturating_add(other.rows);
        self.weightless = self.weightless.saturating_add(other.weightless);
        self.rounded |= other.rounded;
        for (own, other) in self.weights.iter_mut().zip(other.weights) {
            *own = own.checked_add(other).ok_or_else(|| too_long::<i128>("weights"))?;
        }
        for (j, (own, other)) in self.sums.iter_mut().zip(other.sums).enumerate() {
            let too_long = || too_long::<i128>(format_args!("column {j}"));
            *own = own.checked_add(other).ok_or_else(too_long)?;
        }
        let mut at = 0;
        for i in self.strip.clone() {
            for (own, others) in self.entries[at..=at + i].iter_mut().zip(&other.entries[at..]) {
                let too_long = || too_long::<I>(format_args!("column {i}"));
                *own = own.checked_plus(*others).ok_or_else(too_long)?;
            }
            at += i + 1;
        }
        if self.flags.is_empty() {
            self.flags = other.flags;
        } else {
            self.flags.iter_mut().zip(other.flags).for_each(|(own, others)| *own |= others);
        }
        Ok(())
    }

    /// Moves to a finer grid: every integer is multiplied by a power of two. Rows whose shift is
    /// less by `d`, `x + d`, have `C + d t^T + t d^T + w d d^T` and `t + w d`.
    fn move_to(&mut self, fine: &Grid<T>) -> Result<()> {
        let refuse = |j: usize, why: &str| {
            let why = format!("column {j}: the grids are too far apart: {why}");
            Err(Error::Argument { what: "accumulator", why })
        };
        let n = self.grid.ncols();
        let more = (self.grid.weight_exponent - fine.weight_exponent) as u32;
        let finer: Vec<u32> = (0..n).map(|j| self.grid.finer(j, fine)).collect();
        let mut shifts = Vec::with_capacity(n);
        // A weight of 1 is 2^unit in these units.
        let unit = (fine.weight_power + fine.weight_exponent) as u32;
        for j in 0..n {
            match self.grid.shift_difference(j, fine) {
                Some(d) if d >> unit << unit == d => shifts.push(d),
                _ => return refuse(j, "their shifts do not differ by whole units"),
            }
        }
        let Some(weights) =
            shifted(&self.weights, (fine.weight_power - self.grid.weight_power) as u32)
        else {
            return refuse(0, "the weights have more than 128 bits");
        };
        self.weights = [weights[0], weights[1]];
        let w = self.weights[0];
        let mut at = 0;
        for (j, sum) in self.sums.iter_mut().enumerate() {
            match sum.shifted_left(finer[j] + more) {
                Some(fine) => *sum = fine,
                None => return refuse(j, "a sum has more than 128 bits"),
            }
        }
        for i in self.strip.clone() {
            let row = &mut self.entries[at..=at + i];
            for (j, c) in row.iter_mut().enumerate() {
                let moved = || {
                    let c = c.shifted_left(finer[i] + finer[j] + more)?;
                    if shifts[i] == 0 && shifts[j] == 0 {
                        return Some(c);
                    }
                    let left = I::product(shifts[i], self.sums[j])?;
                    let right = I::product(shifts[j], self.sums[i])?;
                    let both = I::product(w.checked_mul(shifts[i] >> unit)?, shifts[j])?;
                    c.checked_plus(left)?.checked_plus(right)?.checked_plus(both)
                };
                match moved() {
                    Some(moved) => *c = moved,
                    None => return refuse(i, "a sum has too many bits"),
                }
            }
            at += i + 1;
        }
        for (j, sum) in self.sums.iter_mut().enumerate() {
            let moved = w.checked_mul(shifts[j] >> unit).and_then(|more| sum.checked_add(more));
            match moved {
                Some(moved) => *sum = moved,
                None => return refuse(j, "a sum has more than 128 bits"),
            }
        }
        self.grid = fine.clone();
        Ok(())
    }

    /// Calls `visit(i, j, value)` for every entry of the strip of C, about the mean when centred,
    /// rounded once.
    ///
    /// # Errors
    /// [`Error::Argument`] when the weights of a mean sum to zero.
    pub fn for_each_value(&self, mut visit: impl FnMut(usize, usize, f64)) -> Result<()> {
        let centered = self.centered && self.rows > 0;
        if centered {
            self.check_mean()?;
        }
        for i in self.strip.clone() {
            for j in 0..=i {
                let (c, flags) = self.entry(i, j);
                let value = match flags.sum() {
                    // An infinite mean makes every entry NaN.
                    Some(_) if centered => f64::NAN,
                    None if centered => self.centered(c, i, j)?,
                    _ => self.value(i, j, c, flags),
                };
                visit(i, j, value);
            }
        }
        Ok(())
    }

    /// Computes `alpha C`, about the mean when centred.
    ///
    /// # Errors
    /// As [`ExactSums::for_each_value`], and [`Error::OutOfMemory`].
    pub fn finish(&self, alpha: f64) -> Result<Strip<T>> {
        let mut c = Strip::new(self.strip.clone())?;
        let mut out = c.as_mut();
        self.for_each_value(|i, j, value| {
            out[(i - self.strip.start, j)] = T::from_f64(alpha * value);
        })?;
        Ok(c)
    }

    /// Returns entry (i, j) in units of the grid, and which of its terms are not finite.
    pub fn entry(&self, i: usize, j: usize) -> (I, Flags) {
        let at = triangle_len(i) + j - triangle_len(self.strip.start);
        (self.entries[at], Flags(self.flags.get(at).copied().unwrap_or(0)))
    }

    /// Returns the value of `c` as entry (i, j), rounded once.
    pub fn value(&self, i: usize, j: usize, c: I, flags: Flags) -> f64 {
        flags.sum().unwrap_or_else(|| scaled(c.to_f64(), self.grid.exponent(i, j)))
    }

    /// Returns the value of `c` as entry (i, j) about the mean, rounded once.
    fn centered(&self, c: I, i: usize, j: usize) -> Result<f64> {
        let (sums, exponent) = ([self.sums[i], self.sums[j]], self.grid.exponent(i, j));
        let value = c.centered(sums, self.weight_shift(), self.weights[0], exponent);
        value.ok_or_else(|| too_long::<I256>(format_args!("column {i}")))
    }

    /// Returns log2 of the units of weights in one of the grid.
    fn weight_shift(&self) -> u32 {
        (self.grid.weight_power + self.grid.weight_exponent) as u32
    }

    /// Checks that there is a mean.
    fn check_mean(&self) -> Result<()> {
        // A damaged file may have made it negative.
        let size = scaled(self.weights[1].unsigned_abs() as f64, -self.grid.weight_power);
        let weight = if self.weights[0] == 0 { 0.0 } else { self.weight() };
        check_weight(self.rows as f64, weight, size)
    }
}

/// Returns the number of weights that are 0.
fn weightless<T: Real>(weights: Option<&[T]>) -> u64 {
    weights.unwrap_or_default().iter().filter(|&&weight| weight == T::ZERO).count() as u64
}

/// Returns the first finite entry beyond the bounds of its column: column and value.
pub(super) fn first_beyond<T: Real>(rows: &[T], lower: &[T], upper: &[T]) -> Option<(usize, f64)> {
    let beyond = |(j, x): (usize, &T)| {
        (x.is_finite() && !(lower[j] <= *x && *x <= upper[j])).then(|| (j, x.to_f64()))
    };
    rows.chunks_exact(lower.len()).find_map(|row| row.iter().enumerate().find_map(beyond))
}

/// Returns the error of sums of `what` that do not fit the integers I.
fn too_long<I>(what: impl Display) -> Error {
    let why = format!("{what}: the sums have more than {} bits", 8 * size_of::<I>());
    Error::Argument { what: "accumulator", why }
}

impl<T: BlasReal> ExactSums<T, I256> {
    /// Computes all of C in three parts, about the mean when centred.
    ///
    /// # Errors
    /// [`Error::NonFinite`] for the first column that is not finite; [`Error::Argument`] when the
    /// weights of a mean sum to zero, or are so fine that numbers get too long.
    pub fn parts(mut self, par: Par) -> Result<ExtendedGram> {
        let n = self.grid.ncols();
        if let Some(at) = self.flags.iter().position(|&flags| flags != 0) {
            let row = (0..n).find(|&i| triangle_len(i + 1) > at).unwrap_or(0);
            return Err(Error::NonFinite { what: "rows", index: (0, row) });
        }
        let centered = self.centered && self.rows > 0;
        if centered {
            self.check_mean()?;
        }
        let w = self.weights[0];
        let mean = |j: usize| {
            let exponent = self.grid.sum_exponent(j) + self.grid.weight_power;
            if centered { wide::mean_parts(self.sums[j], w, exponent) } else { [0.0; 2] }
        };
        let entries = std::mem::take(&mut self.entries);
        let parts = |i: usize, j: usize, c: I256, exponent: i32| match centered {
            true => {
                let sums = [self.sums[i], self.sums[j]];
                wide::centered_parts(c, sums, self.weight_shift(), w, exponent)
            }
            false => Some(c.parts(exponent)),
        };
        let vanishes = |&j: &usize| {
            let c = entries[triangle_len(j) + j];
            let square = |exponent| parts(j, j, c, exponent).map_or(0.0, |[first, ..]| first);
            square(self.grid.exponent(j, j)) == 0.0 && square(0) != 0.0
        };
        let about = About {
            exact: !self.rounded,
            rows: self.rows,
            observations: self.rows.saturating_sub(self.weightless),
            weight: self.weight(),
            mean: if self.centered { (0..n).map(mean).collect() } else { Vec::new() },
            vanished: (0..n).filter(vanishes).collect(),
        };
        // The first column whose numbers are too long.
        let refused = AtomicUsize::new(usize::MAX);
        let gram = ExtendedGram::from_sums(n, entries, about, par, |i, j, c| {
            parts(i, j, c, self.grid.exponent(i, j)).unwrap_or_else(|| {
                refused.fetch_min(i, Ordering::Relaxed);
                [f64::NAN; 3]
            })
        });
        match refused.into_inner() {
            usize::MAX => Ok(gram),
            i => Err(too_long::<I256>(format_args!("column {i}"))),
        }
    }
}

/// Returns whether rounding to integers, after a multiplication by these factors, changes an entry.
#[inline(always)]
pub(super) fn is_rounded<T: Real>(rows: &[T], factors: &[[f64; 2]]) -> bool {
    let mut rounded = false;
    for row in rows.chunks_exact(factors.len()) {
        for (&x, [first, second]) in row.iter().zip(factors) {
            let x = x.to_f64() * first * second;
            // False for NaN, which is not rounded.
            rounded |= (x - x.round_ties_even()).abs() > 0.0;
        }
    }
    rounded
}

/// Adds the integers that the entries of each column become when they are multiplied by these
/// factors.
#[inline(always)]
fn add_columns<T: Real>(rows: &[T], factors: &[[f64; 2]], sums: &mut [i128]) {
    /// Rows whose sums fit 64 bits.
    const RUN: usize = 16;
    let n = sums.len();
    let mut parts = vec![[0_i64; 2]; n];
    for rows in rows.chunks(RUN * n) {
        parts.fill([0; 2]);
        for row in rows.chunks_exact(n) {
            for (([low, high], &x), [first, second]) in parts.iter_mut().zip(row).zip(factors) {
                // Terms that are not finite are counted by their flags.
                let x = if x.is_finite() { x.to_f64() } else { 0.0 };
                let [lower, upper] = halves(x * first * second);
                *low += lower;
                *high += upper;
            }
        }
        for (sum, &parts) in sums.iter_mut().zip(&parts) {
            *sum += joined(parts);
        }
    }
}

/// Bits of the lower half of an integer.
const HALF: i32 = 40;

/// Returns the integer nearest to x (ties to even), of at most [`WIDE_BITS`] bits and a sign, in
/// two parts: both are short, and a conversion to 128 bits is a call of a function.
#[inline(always)]
pub(super) fn halves(x: f64) -> [i64; 2] {
    const { assert!(WIDE_BITS < HALF + 50) };
    let upper = (x * power_of_two(-HALF)).round_ties_even();
    // The lower part is exact before it is rounded, and the upper one is even.
    let lower = (x - upper * power_of_two(HALF)).round_ties_even();
    [lower as i64, upper as i64]
}

/// Returns the integer of these [`halves`], or of sums of them.
#[inline(always)]
pub(super) fn joined([lower, upper]: [i64; 2]) -> i128 {
    i128::from(lower) + (i128::from(upper) << HALF)
}

fn shifted(values: &[i128], bits: u32) -> Option<Vec<i128>> {
    values.iter().map(|v| v.shifted_left(bits)).collect()
}
