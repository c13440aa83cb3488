//! Columns of A whose squared lengths, the diagonal of C, are too small for its scalars.

use anyhow::Result;
use catamaran::Real;
use catamaran::base::zeros;
use catamaran::blas::BlasReal;
use catamaran::faer::prelude::ReborrowMut;
use catamaran::faer::{MatMut, MatRef};
use catamaran::rows::RowBlocks;

use crate::report::note;

/// Entries of A that are read at a time.
const BLOCK: usize = 1 << 20;

/// Most entries of A that are read: a file larger than memory is not read again for a column that
/// may be zero.
const MOST: usize = 1 << 23;

/// The columns whose entry on the diagonal of C is less than a normal number: zero, or with fewer
/// digits than others.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct Faint {
    columns: Vec<usize>,
}

impl Faint {
    /// Finds the columns of C (n x n).
    pub fn of<T: BlasReal>(c: MatRef<'_, T>) -> Self {
        let mut found = Self::default();
        found.add(c, 0);
        found
    }

    /// Adds the columns of further rows of C, the first of which is row `first`.
    pub fn add<T: BlasReal>(&mut self, rows: MatRef<'_, T>, first: usize) {
        let least = least_normal::<T>();
        let is_faint = |i: &usize| rows[(*i, first + i)].to_f64().abs() < least;
        self.columns.extend((0..rows.nrows()).filter(is_faint).map(|i| first + i));
    }

    /// Returns whether there are none.
    pub fn is_none(&self) -> bool {
        self.columns.is_empty()
    }

    /// Returns the column whose squared length is not zero in truth, the first one that shows it in
    /// the first rows of A, [`MOST`] entries of them: it has an entry other than 0, or of
    /// `centered` columns, two that differ. Rows of weight 0 do not count, and with negative
    /// weights, under which squares may cancel, no column is returned.
    pub fn first_in(
        &self,
        rows: &mut dyn RowBlocks<f64>,
        weights: Option<&[f64]>,
        centered: bool,
    ) -> Result<Option<usize>> {
        if weights.is_some_and(|weights| weights.iter().any(|weight| *weight < 0.0)) {
            return Ok(None);
        }
        let (m, n) = (rows.nrows(), rows.ncols());
        let m = m.min((MOST / n.max(1)).max(1));
        let height = (BLOCK / n.max(1)).clamp(1, m.max(1));
        let mut entries = zeros::<f64>(height * n)?;
        // What entries must differ from.
        let mut from = (!centered).then(|| vec![0.0; self.columns.len()]);
        for first in (0..m).step_by(height) {
            let count = height.min(m - first);
            let mut block = MatMut::from_row_major_slice_mut(&mut entries[..count * n], count, n);
            rows.read(first, block.rb_mut())?;
            let counts = |i: &usize| weights.is_none_or(|weights| weights[first + i] != 0.0);
            for i in (0..count).filter(counts) {
                let row = || self.columns.iter().map(|&j| block[(i, j)]);
                let from = from.get_or_insert_with(|| row().collect());
                if let Some(place) = row().zip(from.iter()).position(|(x, from)| x != *from) {
                    return Ok(Some(self.columns[place]));
                }
            }
        }
        Ok(None)
    }
}

/// Notes that the squared length of a column of a file has underflowed.
pub fn note_faint<T: BlasReal>(file: &str, column: usize, centered: bool) {
    let what = if centered { "constant" } else { "zero" };
    let double = if T::NAME == f32::NAME { ", or use --f64" } else { "" };
    note(format_args!(
        "{file}: column {column} (counted from 0) is not {what}, but its entry on the diagonal of \
         C is too small for {}: multiply the column by a power of ten{double}",
        T::NAME
    ));
}

/// Returns the least normal number of T.
fn least_normal<T: BlasReal>() -> f64 {
    match size_of::<T>() {
        4 => f64::from(f32::MIN_POSITIVE),
        _ => f64::MIN_POSITIVE,
    }
}

#[cfg(test)]
mod tests {
    use catamaran::faer::{Mat, mat};
    use catamaran::rows::DenseRows;

    use super::*;

    /// Returns the column that is found if the diagonal of C shows none.
    fn found(a: &Mat<f64>, weights: Option<&[f64]>, centered: bool) -> Option<usize> {
        let all = Faint { columns: (0..a.ncols()).collect() };
        all.first_in(&mut DenseRows(a.as_ref()), weights, centered).unwrap()
    }

    #[test]
    fn entries_on_the_diagonal_below_normal_numbers_are_found() {
        let c = mat![[1.0, 0.0, 0.0], [0.0, 1e-310, 0.0], [0.0, 0.0, 0.0]];
        assert_eq!(Faint::of(c.as_ref()).columns, [1, 2]);
        let mut strips = Faint::default();
        strips.add(c.as_ref().subrows(0, 2), 0);
        strips.add(c.as_ref().subrows(2, 1), 2);
        assert_eq!(strips, Faint::of(c.as_ref()));
        let single = mat![[1e-37f32, 0.0], [0.0, 1e-39]];
        assert_eq!(Faint::of(single.as_ref()).columns, [1]);
    }

    #[test]
    fn columns_of_zeros_and_centred_constants_are_no_news() {
        let a = mat![[0.0, 1e-200, 5.0], [0.0, 1e-200, 5.0]];
        assert_eq!(found(&a, None, false), Some(1));
        assert_eq!(found(&a, None, true), None);
        assert_eq!(found(&a, Some(&[0.0, 0.0]), false), None);
        assert_eq!(found(&a, Some(&[1.0, -1.0]), false), None);
        let b = mat![[1.0, 2.0], [1.0, 2.0], [1.0, 3.0]];
        assert_eq!(found(&b, None, true), Some(1));
        assert_eq!(found(&b, Some(&[1.0, 1.0, 0.0]), true), None);
        assert_eq!(found(&mat![[0.0, -0.0]], None, false), None);
    }
}
