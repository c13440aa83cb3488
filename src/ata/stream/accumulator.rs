use std::ops::Range;

use faer::{MatMut, MatRef};

use super::super::combine::{mirror_lower, scale_lower};
use super::super::options::{AtaOptions, Uplo};
use super::super::{atb, weighted_gram};
use super::moments::Moments;
use crate::base::{Error, Real, Result, Workspace};
use crate::blas::BlasReal;

/// Some rows of a symmetric n x n matrix C, each up to the last column that the strip has on the diagonal.
#[derive(Debug)]
pub struct Strip<T> {
    rows: Range<usize>,
    values: Workspace<T>,
}

impl<T: Real> Strip<T> {
    fn new(rows: Range<usize>) -> Result<Self> {
        let values = Workspace::new(rows.len().saturating_mul(rows.end))?;
        Ok(Self { rows, values })
    }

    /// Which rows of C.
    pub fn rows(&self) -> Range<usize> {
        self.rows.clone()
    }

    /// The entries: `rows().len()` x `rows().end`, entry `(i, j)` is `C(rows().start + i, j)`.
    pub fn as_ref(&self) -> MatRef<'_, T> {
        let (count, end) = (self.rows.len(), self.rows.end);
        MatRef::from_row_major_slice(&self.values.as_slice()[..count * end], count, end)
    }

    pub(super) fn as_mut(&mut self) -> MatMut<'_, T> {
        let (count, end) = (self.rows.len(), self.rows.end);
        MatMut::from_row_major_slice_mut(&mut self.values.as_mut_slice()[..count * end], count, end)
    }

    /// The part left of the diagonal square, and that square.
    fn parts(&mut self) -> (MatMut<'_, T>, MatMut<'_, T>) {
        let start = self.rows.start;
        self.as_mut().split_at_col_mut(start)
    }

    /// Row `i` of the strip as far as C's lower triangle goes.
    pub(super) fn lower_row(&self, i: usize) -> &[T] {
        let (first, end) = (self.rows.start + i, self.rows.end);
        &self.values.as_slice()[i * end..][..=first]
    }

    /// As [`Strip::lower_row`].
    pub(super) fn lower_row_mut(&mut self, i: usize) -> &mut [T] {
        let (first, end) = (self.rows.start + i, self.rows.end);
        &mut self.values.as_mut_slice()[i * end..][..=first]
    }
}

/// `C = sum of w_i (x_i - s)(x_i - s)^T` over rows `x_i` of n columns that come in blocks, with what it takes to go
/// on later, elsewhere, or together with another one.
///
/// Without centring the shift s is zero. With centring it is the mean of the first block, and
/// [`Accumulator::finish`] moves it to the mean of all rows: nothing is lost to a mean that is large beside the
/// deviations, and the rows are read once. See docs/algorithms/ata.md, "Streaming".
///
/// C may be a strip of rows of the whole matrix, when all of it is too large.
#[derive(Debug)]
pub struct Accumulator<T> {
    /// Columns of the rows.
    pub(super) ncols: usize,
    /// The lower triangle of C, about the shift.
    pub(super) c: Strip<T>,
    pub(super) moments: Moments<T>,
    /// Rows that a source had which was streamed into this.
    pub(super) expected_rows: u64,
    /// Rows of its blocks; 0 before the first source.
    pub(super) block_rows: u64,
    /// What the caller wants to find again: name and value.
    pub(super) labels: Vec<(String, String)>,
    /// Rows times weights: memory only.
    weighted: Workspace<T>,
}

impl<T: BlasReal> Accumulator<T> {
    /// Of no rows, for all of C; about the mean when `centered`.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`].
    pub fn new(ncols: usize, centered: bool) -> Result<Self> {
        Self::of_strip(ncols, 0..ncols, centered)
    }

    /// As [`Accumulator::new`], for these rows of C.
    ///
    /// # Errors
    /// [`Error::Argument`] when the rows are not in `0..ncols`, [`Error::OutOfMemory`].
    pub fn of_strip(ncols: usize, rows: Range<usize>, centered: bool) -> Result<Self> {
        if rows.start > rows.end || rows.end > ncols {
            let why = format!("{}..{} is not inside 0..{ncols}", rows.start, rows.end);
            return Err(Error::Argument { what: "strip", why });
        }
        Ok(Self {
            ncols,
            c: Strip::new(rows)?,
            moments: Moments::new(ncols, centered),
            expected_rows: 0,
            block_rows: 0,
            labels: Vec::new(),
            weighted: Workspace::new(0)?,
        })
    }

    /// Columns n of the rows.
    pub fn ncols(&self) -> usize {
        self.ncols
    }

    /// The rows of C that it is of.
    pub fn strip(&self) -> Range<usize> {
        self.c.rows()
    }

    /// Rows so far.
    pub fn rows(&self) -> u64 {
        self.moments.rows
    }

    /// Rows of all sources that were streamed into it; more than [`Accumulator::rows`] while one is on its way.
    pub fn expected_rows(&self) -> u64 {
        self.expected_rows.max(self.rows())
    }

    /// Sum of the weights of the rows so far; their number without weights.
    pub fn weight(&self) -> f64 {
        self.moments.weight
    }

    /// Whether C is to be about the mean.
    pub fn is_centered(&self) -> bool {
        self.moments.centered
    }

    /// The (weighted) mean row so far; empty without centring.
    pub fn mean(&self) -> Vec<f64> {
        self.moments.mean()
    }

    /// Names and values that are kept with it, for the caller's use.
    pub fn labels(&self) -> &[(String, String)] {
        &self.labels
    }

    /// Replaces the labels.
    pub fn set_labels(&mut self, labels: Vec<(String, String)>) {
        self.labels = labels;
    }

    /// Whether the labels are these.
    ///
    /// # Errors
    /// [`Error::Argument`] that names the first one that differs, and both values.
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

    /// Adds a block of `count` rows, one after another, with their weights if they have any. Their entries are
    /// overwritten. `options.uplo` does not matter.
    ///
    /// # Errors
    /// [`Error::Shape`] for the block and the weights, [`Error::NonFinite`] for a weight; else as
    /// [`ata`](super::super::ata), after which the accumulator is of no use any more.
    pub fn add_block(
        &mut self,
        count: usize,
        block: &mut [T],
        weights: Option<&[T]>,
        options: &AtaOptions<'_>,
    ) -> Result<()> {
        let n = self.ncols;
        if Some(block.len()) != count.checked_mul(n) {
            return Err(Error::Shape {
                what: "block",
                expected: (count, n),
                got: (block.len(), 1),
            });
        }
        check_weights(count, weights)?;
        let len = if weights.is_some() { block.len() } else { 0 };
        self.weighted.reserve(len)?;
        let weighted = &mut self.weighted.as_mut_slice()[..len];
        let beta = if self.moments.rows == 0 { T::ZERO } else { T::ONE };
        self.moments.take(count, block, weights, weighted, options.par);

        let x = MatRef::from_row_major_slice(block, count, n);
        let wx = weights.map(|_| MatRef::from_row_major_slice(weighted, count, n));
        let own = self.c.rows();
        let (left, square) = self.c.parts();
        let options = AtaOptions { uplo: Uplo::Lower, ..options.clone() };
        if own.start > 0 {
            let wx = columns(wx.unwrap_or(x), &own);
            atb(T::ONE, wx, columns(x, &(0..own.start)), beta, left, &options)?;
        }
        let wx = wx.map(|wx| columns(wx, &own));
        weighted_gram(T::ONE, columns(x, &own), wx, beta, square, &options)
    }

    /// Adds the rows of `other`, which are about another shift:
    /// `x - s = (x - s') + d` with `d = s' - s`, so that `C += C' + t' d^T + d t'^T + w' d d^T` and
    /// `t += t' + w' d`, t the sum of the shifted rows and w their weight. The shift of the heavier side stays, for
    /// the corrections to be small. Labels that differ are dropped.
    ///
    /// # Errors
    /// [`Error::Argument`] when they differ in columns, strip or centring.
    pub fn merge(&mut self, mut other: Self) -> Result<()> {
        let different = |what, own: String, others: String| {
            let why = format!("{what}: {own} and {others} can't be merged");
            Err(Error::Argument { what: "accumulator", why })
        };
        if self.ncols != other.ncols {
            return different("columns", self.ncols.to_string(), other.ncols.to_string());
        }
        if self.c.rows != other.c.rows {
            return different(
                "rows of C",
                format!("{:?}", self.c.rows),
                format!("{:?}", other.c.rows),
            );
        }
        if self.is_centered() != other.is_centered() {
            let name = |c: bool| if c { "centred" } else { "not centred" }.to_owned();
            return different("centring", name(self.is_centered()), name(other.is_centered()));
        }
        let heavier = other.moments.weight_size > self.moments.weight_size;
        if heavier || self.moments.shift.is_empty() {
            std::mem::swap(self, &mut other);
        }
        self.expected_rows = self.expected_rows() + other.expected_rows();
        self.block_rows = 0;
        self.labels.retain(|label| other.labels.contains(label));
        let first = self.c.rows.start;
        let (own, others) = (&mut self.moments, &other.moments);
        own.rows += others.rows;
        own.weight += others.weight;
        own.weight_size += others.weight_size;
        if others.shift.is_empty() {
            // Not centred, or without rows.
            return self.add_c(&other, first, |_, _| 0.0);
        }
        let difference = |(s, t): (&T, &T)| s.to_f64() - t.to_f64();
        let d: Vec<f64> = others.shift.iter().zip(&own.shift).map(difference).collect();
        for ((t, u), d) in own.sum.iter_mut().zip(&others.sum).zip(&d) {
            *t += u + others.weight * d;
        }
        let t = &others.sum;
        self.add_c(&other, first, |i, j| t[i] * d[j] + d[i] * (t[j] + others.weight * d[j]))
    }

    /// `C += C' + correction`.
    fn add_c(
        &mut self,
        other: &Self,
        first: usize,
        correction: impl Fn(usize, usize) -> f64,
    ) -> Result<()> {
        for i in 0..self.c.rows.len() {
            let own = self.c.lower_row_mut(i);
            for (j, (c, d)) in own.iter_mut().zip(other.c.lower_row(i)).enumerate() {
                *c = T::from_f64(c.to_f64() + d.to_f64() + correction(first + i, j));
            }
        }
        Ok(())
    }

    /// `alpha C`, about the mean when centred, in the memory of the accumulator. Of all of C the triangle or triangles
    /// of `uplo`, the other one zero. A strip has its part of the lower triangle and zeros above the diagonal,
    /// whatever `uplo` says.
    ///
    /// # Errors
    /// [`Error::Argument`] when the weights of a mean sum to zero.
    pub fn finish(self, alpha: f64, uplo: Uplo) -> Result<Strip<T>> {
        let Self { ncols, mut c, moments, .. } = self;
        let first = c.rows.start;
        moments.correct(1.0, first, c.as_mut())?;
        if alpha != 1.0 {
            for i in 0..c.rows.len() {
                for x in c.lower_row_mut(i) {
                    *x = T::from_f64(alpha * x.to_f64());
                }
            }
        }
        if c.rows == (0..ncols) && uplo != Uplo::Lower {
            mirror_lower(c.as_mut());
            if uplo == Uplo::Upper {
                // The strict lower triangle is the strict upper one of the transpose: spare the diagonal.
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
}

fn columns<'a, T>(x: MatRef<'a, T>, columns: &Range<usize>) -> MatRef<'a, T> {
    x.subcols(columns.start, columns.len())
}

/// `count` finite weights, if any.
pub(crate) fn check_weights<T: Real>(count: usize, weights: Option<&[T]>) -> Result<()> {
    let Some(weights) = weights else { return Ok(()) };
    Error::check_shape("weights", (count, 1), (weights.len(), 1))?;
    match weights.iter().position(|w| !w.is_finite()) {
        Some(i) => Err(Error::NonFinite { what: "weights", index: (i, 0) }),
        None => Ok(()),
    }
}
