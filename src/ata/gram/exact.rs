//! Sums of rows in integers on a grid that is chosen before the first row: the same for any order
//! of the rows.

use std::ops::Range;

use faer::MatRef;

use super::grid::{Grid, RowBounds, Shift};
use super::moments::check_weight;
use super::pass::Pass;
use super::wide;
use crate::ata::exact::{Columns, Flags, Signs, triangle_len};
use crate::base::{Error, Par, Real, Result, reserved};
use crate::blas::BlasReal;
use crate::kernel::int8::scaled;

/// Rows that one thread takes at a time.
const PIECE: usize = 512;

/// `C = sum of w_i x_i x_i^T` of shifted rows, as integers in units of the grid; some rows of the
/// lower triangle.
#[derive(Debug)]
pub(crate) struct ExactSums<T> {
    pub(super) grid: Grid<T>,
    pub(super) strip: Range<usize>,
    /// Whether the end is to be about the mean.
    pub(super) centered: bool,
    /// Rows so far.
    pub(super) rows: u64,
    /// Sum of the weights, and of their absolute values, as integers.
    pub(super) weights: [i128; 2],
    /// Sums of the weighted columns; none without centring.
    pub(super) sums: Vec<i128>,
    /// The rows of the triangle, one after another.
    pub(super) entries: Vec<i128>,
    /// For each entry which terms are not finite; empty while all are.
    pub(super) flags: Vec<u8>,
}

/// What one thread finds in its rows.
struct Found {
    /// Sums of the weighted columns.
    sums: Vec<i128>,
    /// The first entry beyond its bounds: column and value.
    beyond: Option<(usize, f64)>,
    /// Whether the columns are finite on both sides; empty if all are.
    finite: [Vec<bool>; 2],
}

/// The rows that one thread works on at a time.
struct Piece<'p, T> {
    rows: &'p mut [T],
    weights: Option<&'p [T]>,
    /// Where the rows go times their weights; empty without weights.
    weighted: &'p mut [T],
    found: Found,
}

impl<T: BlasReal> ExactSums<T> {
    /// Of no rows.
    pub fn new(bounds: &RowBounds<T>, strip: Range<usize>, shift: Shift<'_, T>) -> Result<Self> {
        let centered = matches!(shift, Shift::Near);
        Self::on(Grid::new(bounds, shift)?, strip, centered)
    }

    /// Of no rows, on a grid.
    pub(super) fn on(grid: Grid<T>, strip: Range<usize>, centered: bool) -> Result<Self> {
        let len = triangle_len(strip.end) - triangle_len(strip.start);
        let sums = integers(if centered { grid.ncols() } else { 0 })?;
        let entries = integers(len)?;
        let flags = Vec::new();
        Ok(Self { grid, strip, centered, rows: 0, weights: [0; 2], sums, entries, flags })
    }

    /// Sum of the weights.
    pub fn weight(&self) -> f64 {
        scaled(self.weights[0] as f64, -self.grid.weight_power)
    }

    /// The (weighted) mean row; empty without centring.
    pub fn mean(&self) -> Vec<f64> {
        let weight = self.weight();
        let mean = |(j, &sum): (usize, &i128)| {
            self.grid.shift_of(j).to_f64() + scaled(sum as f64, self.grid.sum_exponent(j)) / weight
        };
        self.sums.iter().enumerate().map(mean).collect()
    }

    /// Adds a block of `count` rows, or subtracts it. Its entries are overwritten; nothing else is
    /// changed by an error but [`Error::Cancelled`] and [`Error::OutOfMemory`].
    pub fn add(
        &mut self,
        count: usize,
        block: &mut [T],
        weights: Option<&[T]>,
        subtract: bool,
        pass: &mut Pass<'_, T>,
    ) -> Result<()> {
        let n = self.grid.ncols();
        let slab = self.check(count, weights, subtract)?;
        let (options, engine, memory) = pass.parts();
        // Weights were declared: rows without have weight 1.
        let ones;
        let weights = match (weights, self.grid.weight) {
            (None, Some(_)) => {
                ones = vec![T::ONE; count];
                Some(&ones[..])
            }
            (weights, _) => weights,
        };
        let len = if weights.is_some() { block.len() } else { 0 };
        memory.reserve(len)?;
        let weighted = &mut memory.as_mut_slice()[..len];
        let found = options.on_cores(|| self.prepare(block, weights, weighted, options.par))?;
        let sign = if subtract { -1 } else { 1 };
        if n > 0 {
            if found.finite.iter().any(|finite| !finite.is_empty()) {
                if subtract {
                    return Err(first_non_finite(block, n));
                }
                let right = weights.map(|_| &*weighted);
                options.on_cores(|| self.take_flags(count, block, right, &found, options.par))?;
                for x in block.iter_mut().chain(weighted.iter_mut()).filter(|x| !x.is_finite()) {
                    *x = T::ZERO;
                }
            }
            let powers = [false, true].map(|side| self.grid.powers(side).collect::<Vec<_>>());
            for first in (0..count).step_by(slab) {
                let rows = first..count.min(first + slab);
                let share = |row: usize| row as f64 / count as f64;
                let progress = options.progress.part(share(rows.start)..share(rows.end));
                let options = options.clone().progress(progress);
                let entries = rows.start * n..rows.end * n;
                let x = MatRef::from_row_major_slice(&block[entries.clone()], rows.len(), n);
                let y = weights
                    .map(|_| MatRef::from_row_major_slice(&weighted[entries], rows.len(), n));
                let sums = (&mut self.entries[..], &self.strip);
                engine.integers(x, y, &powers, sums, subtract, &options)?;
            }
        }
        for (sum, part) in self.sums.iter_mut().zip(found.sums) {
            *sum += sign * part;
        }
        let mut add = |weight: i128| {
            self.weights[0] += sign * weight;
            self.weights[1] += sign * weight.abs();
        };
        match weights {
            None => add(count as i128),
            Some(weights) => weights.iter().for_each(|&w| add(self.grid.weight_integer(w))),
        }
        self.rows = if subtract { self.rows - count as u64 } else { self.rows + count as u64 };
        Ok(())
    }

    /// Whether so many rows with these weights can be added or subtracted, and how many at a time.
    fn check(&self, count: usize, weights: Option<&[T]>, subtract: bool) -> Result<usize> {
        let refuse = |what, why| Err(Error::Argument { what, why });
        let (slab, room, column) = self.grid.capacity();
        if subtract && self.rows < count as u64 {
            let why = format!("{count} rows can't be removed from {}", self.rows);
            return refuse("block", why);
        }
        if !subtract && (slab == 0 || self.rows + count as u64 > room) {
            let why = format!(
                "{} rows, where the grid of column {column} has room for {room}: declare more",
                self.rows + count as u64
            );
            return refuse("bounds", why);
        }
        let bound = match (weights, self.grid.weight) {
            (None, None) => return Ok(slab),
            (Some(_), None) => {
                return refuse("weights", "no bound was declared for them".into());
            }
            (_, Some(bound)) => bound,
        };
        let one = [T::ONE];
        let beyond = weights.unwrap_or(&one).iter().find(|w| w.abs() > bound);
        match beyond {
            Some(w) => refuse("weights", format!("{w} is beyond the bound {bound}")),
            None => Ok(slab),
        }
    }

    /// Checks the bounds of rows, shifts them, multiplies them by their weights, and adds up the
    /// columns.
    fn prepare(
        &self,
        block: &mut [T],
        weights: Option<&[T]>,
        weighted: &mut [T],
        par: Par,
    ) -> Result<Found> {
        let n = self.grid.ncols();
        let none = |sums| Found { sums, beyond: None, finite: Default::default() };
        if n == 0 {
            return Ok(none(Vec::new()));
        }
        let mut weighted = weighted.chunks_mut(PIECE * n);
        let mut weights = weights.map(|w| w.chunks(PIECE));
        let mut pieces: Vec<_> = block
            .chunks_mut(PIECE * n)
            .map(|rows| {
                let weights = weights.as_mut().and_then(Iterator::next);
                let weighted = weighted.next().unwrap_or_default();
                Piece { rows, weights, weighted, found: none(vec![0; self.sums.len()]) }
            })
            .collect();
        let factors: Vec<_> = (0..self.sums.len()).map(|j| self.grid.factors(j)).collect();
        let arch = pulp::Arch::new();
        par.for_each(pieces.iter_mut(), |_, piece| {
            // Dispatched once, so that the loops inside use the widest registers there are.
            arch.dispatch(
                #[inline(always)]
                || self.prepare_piece(piece, &factors),
            );
        });
        let mut all = none(vec![0; self.sums.len()]);
        for Piece { found, .. } in pieces {
            if let Some((j, x)) = found.beyond {
                let (lower, upper) = (self.grid.lower[j], self.grid.upper[j]);
                let why = format!("{x} in column {j} is beyond its bounds {lower}..={upper}");
                return Err(Error::Argument { what: "rows", why });
            }
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
    fn prepare_piece(&self, piece: &mut Piece<'_, T>, factors: &[[f64; 2]]) {
        let Grid { lower, upper, shift, .. } = &self.grid;
        let n = lower.len();
        let Piece { rows, weights, weighted, found } = piece;
        let infinity = T::from_f64(f64::INFINITY);
        let (mut inside, mut finite) = (true, true);
        for row in rows.chunks_exact(n) {
            for ((&x, &lower), &upper) in row.iter().zip(lower).zip(upper) {
                finite &= x.abs() < infinity;
                inside &= x >= lower && x <= upper;
            }
        }
        if !inside {
            let beyond = |(i, x): (usize, &T)| {
                let j = i % n;
                (x.is_finite() && !(lower[j] <= *x && *x <= upper[j])).then(|| (j, x.to_f64()))
            };
            found.beyond = rows.iter().enumerate().find_map(beyond);
        }
        if found.beyond.is_some() {
            return;
        }
        for (i, row) in rows.chunks_exact_mut(n).enumerate() {
            for (x, &shift) in row.iter_mut().zip(shift) {
                *x -= shift;
            }
            if let Some(weights) = weights {
                for (out, &x) in weighted[i * n..].iter_mut().zip(row.iter()) {
                    *out = weights[i] * x;
                }
            }
        }
        if self.centered {
            let right = if weights.is_some() { &**weighted } else { &**rows };
            add_columns(right, factors, &mut found.sums);
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

    /// Takes in which terms of a block are not finite.
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
            Columns { exponents: Vec::new(), non_finite: non_finite.collect() }
        };
        let matrix = |rows| MatRef::from_row_major_slice(rows, count, n);
        let left = columns(&found.finite[0]);
        let right = columns(&found.finite[1]);
        let left = (matrix(block), &left);
        let right = weighted.map_or(left, |weighted| (matrix(weighted), &right));
        let Some(signs) = Signs::of_product(left, right, par)? else { return Ok(()) };
        if self.flags.is_empty() {
            self.flags = reserved(self.entries.len())?;
            self.flags.resize(self.entries.len(), 0);
        }
        let mut rows: Vec<_> = Vec::new();
        let mut rest = &mut self.flags[..];
        for i in self.strip.clone() {
            let (row, others) = rest.split_at_mut(i + 1);
            rows.push((i, row));
            rest = others;
        }
        par.for_each(rows.into_iter(), |_, (i, row)| {
            for (j, flags) in row.iter_mut().enumerate() {
                *flags |= signs.flags(i, j).0;
            }
        });
        Ok(())
    }

    /// Adds the sums of other rows of the same columns and strip: on another grid after both have
    /// moved to the finer one, exactly.
    pub fn merge(&mut self, mut other: Self) -> Result<()> {
        if self.grid != other.grid {
            let grid = self.grid.join(&other.grid)?;
            self.move_to(&grid)?;
            other.move_to(&grid)?;
        }
        let overflow = |i: usize| {
            let why = format!("column {i}: the merged sums have more than 128 bits");
            Error::Argument { what: "accumulator", why }
        };
        // Nothing is changed before everything is known to fit.
        let sums = |own: &[i128], others: &[i128]| -> Option<Vec<i128>> {
            own.iter().zip(others).map(|(a, b)| a.checked_add(*b)).collect()
        };
        self.rows += other.rows;
        for (weight, others) in self.weights.iter_mut().zip(other.weights) {
            *weight += others;
        }
        self.sums = sums(&self.sums, &other.sums).ok_or_else(|| overflow(0))?;
        let mut at = 0;
        for i in self.strip.clone() {
            for (own, others) in self.entries[at..=at + i].iter_mut().zip(&other.entries[at..]) {
                *own = own.checked_add(*others).ok_or_else(|| overflow(i))?;
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

    /// Moves to a finer grid: every integer is multiplied by a power of two, and rows that are
    /// shifted by `d` less, `x + d`, have `C + d t^T + t d^T + w d d^T` and `t + w d`.
    fn move_to(&mut self, fine: &Grid<T>) -> Result<()> {
        let refuse = |j: usize, why: &str| {
            let why = format!("column {j}: the grids are too far apart: {why}");
            Err(Error::Argument { what: "accumulator", why })
        };
        let n = self.grid.ncols();
        let more = (self.grid.weight_exponent - fine.weight_exponent) as u32;
        let finer: Vec<u32> = (0..n).map(|j| self.grid.finer(j, fine)).collect();
        let mut shifts = Vec::with_capacity(n);
        // One weight is 2^unit of these.
        let unit = (fine.weight_power + fine.weight_exponent) as u32;
        for j in 0..n {
            match self.grid.shift_difference(j, fine) {
                Some(d) if d >> unit << unit == d => shifts.push(d),
                _ => return refuse(j, "their shifts do not meet"),
            }
        }
        let Some(weights) =
            shifted(&self.weights, (fine.weight_power - self.grid.weight_power) as u32)
        else {
            return refuse(0, "weights");
        };
        self.weights = [weights[0], weights[1]];
        let w = self.weights[0];
        let mut at = 0;
        for (j, sum) in self.sums.iter_mut().enumerate() {
            match shift_left(*sum, finer[j] + more) {
                Some(fine) => *sum = fine,
                None => return refuse(j, "a sum has more than 128 bits"),
            }
        }
        for i in self.strip.clone() {
            let row = &mut self.entries[at..=at + i];
            for (j, c) in row.iter_mut().enumerate() {
                let moved = || {
                    let c = shift_left(*c, finer[i] + finer[j] + more)?;
                    if shifts[i] == 0 && shifts[j] == 0 {
                        return Some(c);
                    }
                    let left = shifts[i].checked_mul(self.sums[j])?;
                    let right = shifts[j].checked_mul(self.sums[i])?;
                    let both = w.checked_mul(shifts[i] >> unit)?.checked_mul(shifts[j])?;
                    c.checked_add(left)?.checked_add(right)?.checked_add(both)
                };
                match moved() {
                    Some(moved) => *c = moved,
                    None => return refuse(i, "a sum has more than 128 bits"),
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
            // A damaged file may have made it negative.
            let size = scaled(self.weights[1].unsigned_abs() as f64, -self.grid.weight_power);
            let weight = if self.weights[0] == 0 { 0.0 } else { self.weight() };
            check_weight(self.rows as f64, weight, size)?;
        }
        for i in self.strip.clone() {
            for j in 0..=i {
                let (c, flags) = self.entry(i, j);
                let value = match flags.sum() {
                    // An infinite mean leaves nothing.
                    Some(_) if centered => f64::NAN,
                    None if centered => self.centered(c, i, j)?,
                    _ => self.value(i, j, c, flags),
                };
                visit(i, j, value);
            }
        }
        Ok(())
    }

    /// Entry (i, j) in units of the grid, and which of its terms are not finite.
    pub fn entry(&self, i: usize, j: usize) -> (i128, Flags) {
        let at = triangle_len(i) + j - triangle_len(self.strip.start);
        (self.entries[at], Flags(self.flags.get(at).copied().unwrap_or(0)))
    }

    /// The value of `c` as entry (i, j), rounded once.
    pub fn value(&self, i: usize, j: usize, c: i128, flags: Flags) -> f64 {
        flags.sum().unwrap_or_else(|| scaled(c as f64, self.grid.exponent(i, j)))
    }

    /// The value of `c` as entry (i, j) about the mean, rounded once.
    fn centered(&self, c: i128, i: usize, j: usize) -> Result<f64> {
        let shift = (self.grid.weight_power + self.grid.weight_exponent) as u32;
        let (sums, exponent) = ([self.sums[i], self.sums[j]], self.grid.exponent(i, j));
        wide::centered(c, sums, shift, self.weights[0], exponent).ok_or_else(|| {
            let why = format!("column {i}: the sums have more than 256 bits");
            Error::Argument { what: "accumulator", why }
        })
    }
}

/// Adds the integers that the entries of each column become when they are multiplied by these
/// factors.
#[inline(always)]
fn add_columns<T: Real>(rows: &[T], factors: &[[f64; 2]], sums: &mut [i128]) {
    /// Rows whose sums fit 64 bits: integers have at most 58 (`Grid::capacity`).
    const RUN: usize = 16;
    let n = sums.len();
    let mut part = vec![0_i64; n];
    for rows in rows.chunks(RUN * n) {
        part.fill(0);
        for row in rows.chunks_exact(n) {
            for ((part, &x), [first, second]) in part.iter_mut().zip(row).zip(factors) {
                // What is not finite counts by its flags.
                let x = if x.is_finite() { x.to_f64() } else { 0.0 };
                *part += (x * first * second).round_ties_even() as i64;
            }
        }
        for (sum, &part) in sums.iter_mut().zip(&part) {
            *sum += i128::from(part);
        }
    }
}

/// `len` zeros.
pub(super) fn integers(len: usize) -> Result<Vec<i128>> {
    let mut zeros = reserved(len)?;
    zeros.resize(len, 0);
    Ok(zeros)
}

/// `v 2^bits`.
fn shift_left(v: i128, bits: u32) -> Option<i128> {
    let fits = v == 0 || v.unsigned_abs().leading_zeros() > bits;
    fits.then(|| if v == 0 { 0 } else { v << bits })
}

fn shifted(values: &[i128], bits: u32) -> Option<Vec<i128>> {
    values.iter().map(|&v| shift_left(v, bits)).collect()
}

fn first_non_finite<T: Real>(block: &[T], n: usize) -> Error {
    let at = block.iter().position(|x| !x.is_finite()).unwrap_or(0);
    Error::NonFinite { what: "rows", index: (at / n, at % n) }
}
