//! Memory of messages, whose allocation may fail, and copies of matrices in it.

use std::marker::PhantomData;
use std::ops::{Deref, DerefMut};

use faer::prelude::ReborrowMut;
use faer::{MatMut, MatRef};

use crate::base::{Real, Result, Scratch, reserved};

/// A list of entries in memory that stays with the process for later calls: to touch fresh memory
/// may take as long as what arrives in it.
pub(super) struct Buffer<T> {
    memory: Scratch,
    len: usize,
    entry: PhantomData<T>,
}

impl<T: Real> Buffer<T> {
    /// Creates an empty list with room for `room` entries.
    pub(super) fn with_room(room: usize) -> Result<Self> {
        let mut memory = Scratch::new::<T>(room)?;
        // So that tests see what is read before it is written.
        if cfg!(debug_assertions) {
            memory.as_mut_slice().fill(T::from_f64(f64::NAN));
        }
        Ok(Self { memory, ..Self::default() })
    }

    /// Creates a list of `len` unspecified entries.
    pub(super) fn of_len(len: usize) -> Result<Self> {
        Ok(Self { len, ..Self::with_room(len)? })
    }

    /// Changes the number of entries, within the room; new ones are unspecified.
    pub(super) fn set_len(&mut self, len: usize) {
        assert!(len <= self.memory.as_slice::<T>().len(), "no room for {len} entries");
        self.len = len;
    }

    /// Appends entries, within the room.
    pub(super) fn extend_from_slice(&mut self, entries: &[T]) {
        let start = self.len;
        self.set_len(start + entries.len());
        self[start..].copy_from_slice(entries);
    }
}

impl<T> Default for Buffer<T> {
    fn default() -> Self {
        Self { memory: Scratch::default(), len: 0, entry: PhantomData }
    }
}

impl From<Vec<f64>> for Buffer<f64> {
    fn from(entries: Vec<f64>) -> Self {
        Self { len: entries.len(), memory: Scratch::from_vec(entries), entry: PhantomData }
    }
}

impl<T: Real> Deref for Buffer<T> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        &self.memory.as_slice()[..self.len]
    }
}

impl<T: Real> DerefMut for Buffer<T> {
    fn deref_mut(&mut self) -> &mut [T] {
        &mut self.memory.as_mut_slice()[..self.len]
    }
}

/// Appends the rows of `matrix`, one after another.
pub(super) fn append_rows<T: Real>(buffer: &mut Buffer<T>, matrix: MatRef<'_, T>) {
    /// Rows copied together: a cache line or two of each column.
    const ROWS: usize = 16;
    let width = matrix.ncols();
    if matrix.col_stride() == 1 {
        for i in 0..matrix.nrows() {
            if let Some(row) = matrix.row(i).try_as_row_major() {
                buffer.extend_from_slice(row.as_slice());
            }
        }
        return;
    }
    for first in (0..matrix.nrows()).step_by(ROWS) {
        let rows = matrix.subrows(first, ROWS.min(matrix.nrows() - first));
        let start = buffer.len();
        buffer.set_len(start + rows.nrows() * width);
        let copy = &mut buffer[start..];
        for j in 0..width {
            for i in 0..rows.nrows() {
                copy[i * width + j] = rows[(i, j)];
            }
        }
    }
}

/// Returns the columns of a matrix, one after another.
pub(super) fn entries(matrix: MatRef<'_, f64>) -> Result<Vec<f64>> {
    let mut entries = reserved(matrix.nrows() * matrix.ncols())?;
    for column in matrix.col_iter() {
        entries.extend(column.iter());
    }
    Ok(entries)
}

/// Undoes [`entries`].
pub(super) fn put_entries(mut matrix: MatMut<'_, f64>, entries: &[f64]) {
    for (j, column) in entries.chunks_exact(matrix.nrows().max(1)).enumerate() {
        matrix.rb_mut().col_mut(j).iter_mut().zip(column).for_each(|(to, from)| *to = *from);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_are_appended_within_the_room() {
        let matrix = MatRef::from_column_major_slice(&[1.0_f32, 2.0, 3.0, 4.0, 5.0, 6.0], 2, 3);
        for room in [6, 7, 1 << 21] {
            let mut buffer = Buffer::<f32>::with_room(room).unwrap();
            assert!(buffer.is_empty());
            append_rows(&mut buffer, matrix.subrows(0, 1));
            append_rows(&mut buffer, matrix.transpose().subcols(1, 1).transpose());
            assert_eq!(*buffer, [1.0, 3.0, 5.0, 2.0, 4.0, 6.0]);
            buffer.set_len(2);
            buffer.extend_from_slice(&[9.0]);
            assert_eq!(*buffer, [1.0, 3.0, 9.0]);
        }
        assert_eq!(*Buffer::from(vec![1.0, 2.0]), [1.0, 2.0]);
        assert!(Buffer::<f64>::default().is_empty());
    }

    #[test]
    #[should_panic(expected = "no room for")]
    fn no_more_entries_than_there_is_room_for() {
        Buffer::<f64>::of_len(300_000).unwrap().set_len(usize::MAX);
    }
}
