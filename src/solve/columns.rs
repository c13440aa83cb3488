//! Matrices of extended numbers: columns, each part in memory of its own.

use super::double::DoubleDouble;
use super::slices::{PairColumns, Pairs, PairsMut};
use crate::base::{Result, zeros};

/// Elements that a vector register holds at most: lengths of columns are multiples of them.
pub(super) const LANES: usize = 8;

/// Returns the distance of columns of `rows` elements.
fn stride(rows: usize) -> usize {
    /// Columns a multiple of so many elements apart share sets of the first-level cache.
    const CONFLICT: usize = 64;
    let rows = rows.next_multiple_of(LANES);
    if rows.is_multiple_of(CONFLICT) { rows + LANES } else { rows }
}

/// A matrix of which each entry is a sum of `PARTS` f64. There are zeros below the last row, until
/// its stride.
#[derive(Debug, Clone)]
pub(super) struct Columns<const PARTS: usize> {
    pub rows: usize,
    pub cols: usize,
    pub stride: usize,
    pub parts: [Vec<f64>; PARTS],
}

impl<const PARTS: usize> Columns<PARTS> {
    /// Returns zeros.
    pub fn new(rows: usize, cols: usize) -> Result<Self> {
        let stride = stride(rows);
        let mut parts = [const { Vec::new() }; PARTS];
        for part in &mut parts {
            *part = zeros(stride.saturating_mul(cols))?;
        }
        Ok(Self { rows, cols, stride, parts })
    }

    /// Returns the parts of entry (i, j).
    pub fn get(&self, i: usize, j: usize) -> [f64; PARTS] {
        let at = j * self.stride + i;
        std::array::from_fn(|part| self.parts[part][at])
    }

    /// Sets the parts of entry (i, j).
    pub fn set(&mut self, i: usize, j: usize, value: [f64; PARTS]) {
        let at = j * self.stride + i;
        self.parts.iter_mut().zip(value).for_each(|(part, value)| part[at] = value);
    }

    /// Exchanges two entries.
    pub fn swap(&mut self, a: (usize, usize), b: (usize, usize)) {
        let [a, b] = [a, b].map(|(i, j)| j * self.stride + i);
        self.parts.iter_mut().for_each(|part| part.swap(a, b));
    }

    /// Returns the parts of a column from row `from` on.
    #[inline(always)]
    pub fn col(&self, j: usize, from: usize) -> [&[f64]; PARTS] {
        let at = j * self.stride;
        std::array::from_fn(|part| &self.parts[part][at + from..at + self.stride])
    }
}

impl Columns<2> {
    /// Returns entry (i, j).
    pub fn double(&self, i: usize, j: usize) -> DoubleDouble {
        let [hi, lo] = self.get(i, j);
        DoubleDouble { hi, lo }
    }

    /// Sets entry (i, j).
    pub fn set_double(&mut self, i: usize, j: usize, value: DoubleDouble) {
        self.set(i, j, [value.hi, value.lo]);
    }

    /// Returns a column from row `from` on.
    #[inline(always)]
    pub fn pairs(&self, j: usize, from: usize) -> Pairs<'_> {
        let [hi, lo] = self.col(j, from);
        Pairs { hi, lo }
    }

    /// Returns a column from row `from` on, for writing.
    #[inline(always)]
    pub fn pairs_mut(&mut self, j: usize, from: usize) -> PairsMut<'_> {
        let at = j * self.stride;
        let [hi, lo] = &mut self.parts;
        let range = at + from..at + self.stride;
        PairsMut { hi: &mut hi[range.clone()], lo: &mut lo[range] }
    }

    /// Returns all columns.
    #[inline(always)]
    pub fn columns(&self) -> PairColumns<'_> {
        let [hi, lo] = &self.parts;
        PairColumns { hi, lo, stride: self.stride }
    }

    /// Returns the columns before column j, that column from row `from` on, for writing, and the
    /// columns behind it.
    #[inline(always)]
    pub fn around(
        &mut self,
        j: usize,
        from: usize,
    ) -> (PairColumns<'_>, PairsMut<'_>, PairColumns<'_>) {
        let stride = self.stride;
        let [hi, lo] = &mut self.parts;
        let ((before_hi, hi), (before_lo, lo)) =
            (hi.split_at_mut(j * stride), lo.split_at_mut(j * stride));
        let ((hi, after_hi), (lo, after_lo)) = (hi.split_at_mut(stride), lo.split_at_mut(stride));
        (
            PairColumns { hi: before_hi, lo: before_lo, stride },
            PairsMut { hi: &mut hi[from..], lo: &mut lo[from..] },
            PairColumns { hi: after_hi, lo: after_lo, stride },
        )
    }
}
