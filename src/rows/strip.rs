use std::ops::Range;

use faer::{MatMut, MatRef};

use crate::base::{Real, Result, Workspace};

/// Some rows of a symmetric n x n matrix C, each up to the last column that the strip has on the
/// diagonal.
#[derive(Debug)]
pub struct Strip<T> {
    rows: Range<usize>,
    values: Workspace<T>,
}

impl<T: Real> Strip<T> {
    pub(super) fn new(rows: Range<usize>) -> Result<Self> {
        let values = Workspace::new(rows.len().saturating_mul(rows.end))?;
        Ok(Self { rows, values })
    }

    /// Creates the strip from all entries, row after row.
    pub(super) fn from_rows(rows: Range<usize>, values: Vec<T>) -> Self {
        debug_assert_eq!(values.len(), rows.len() * rows.end);
        Self { rows, values: Workspace::from_vec(values) }
    }

    pub(super) fn try_clone(&self) -> Result<Self> {
        let mut copy = Self::new(self.rows.clone())?;
        copy.values.as_mut_slice().copy_from_slice(self.values.as_slice());
        Ok(copy)
    }

    /// Returns the rows of C that the strip has.
    pub fn rows(&self) -> Range<usize> {
        self.rows.clone()
    }

    /// Returns the entries as a matrix, `rows().len()` x `rows().end`, whose entry `(i, j)` is
    /// `C(rows().start + i, j)`.
    pub fn as_ref(&self) -> MatRef<'_, T> {
        let (count, end) = (self.rows.len(), self.rows.end);
        MatRef::from_row_major_slice(&self.values.as_slice()[..count * end], count, end)
    }

    pub(super) fn as_mut(&mut self) -> MatMut<'_, T> {
        let (count, end) = (self.rows.len(), self.rows.end);
        MatMut::from_row_major_slice_mut(&mut self.values.as_mut_slice()[..count * end], count, end)
    }

    /// Returns row `i` of the strip up to the diagonal of C.
    pub(super) fn lower_row(&self, i: usize) -> &[T] {
        let (first, end) = (self.rows.start + i, self.rows.end);
        &self.values.as_slice()[i * end..][..=first]
    }

    /// Returns what [`Strip::lower_row`] returns, mutable.
    pub(super) fn lower_row_mut(&mut self, i: usize) -> &mut [T] {
        let (first, end) = (self.rows.start + i, self.rows.end);
        &mut self.values.as_mut_slice()[i * end..][..=first]
    }
}
