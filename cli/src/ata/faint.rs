//! Columns of A whose squared lengths, the diagonal of C, are lost to its scalars.

use anyhow::Result;
use catamaran::Real;
use catamaran::base::zeros;
use catamaran::blas::BlasReal;
use catamaran::faer::prelude::ReborrowMut;
use catamaran::faer::{MatMut, MatRef};
use catamaran::rows::RowBlocks;

use crate::report::note;
use crate::rows::Source;

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

    /// Returns the columns whose squared length is not zero in truth, as the first rows of A show,
    /// [`MOST`] entries of them: those that have an entry other than 0, or of `centered` columns,
    /// two that differ. Rows of weight 0 do not count, and with negative weights, under which
    /// squares may cancel, there are none.
    pub fn lost_in<T: BlasReal>(
        &self,
        rows: &mut dyn RowBlocks<f64>,
        weights: Option<&[f64]>,
        centered: bool,
    ) -> Result<Lost> {
        if weights.is_some_and(|weights| weights.iter().any(|weight| *weight < 0.0)) {
            return Ok(Lost::default());
        }
        let (m, n) = (rows.nrows(), rows.ncols());
        let m = m.min((MOST / n.max(1)).max(1));
        let height = (BLOCK / n.max(1)).clamp(1, m.max(1));
        let mut entries = zeros::<f64>(height * n)?;
        // What the entries of centred columns must differ from is in the first row that counts.
        let mut seen: Vec<Seen> = self.columns.iter().map(|_| Seen::new(!centered)).collect();
        for first in (0..m).step_by(height) {
            let count = height.min(m - first);
            let mut block = MatMut::from_row_major_slice_mut(&mut entries[..count * n], count, n);
            rows.read(first, block.rb_mut())?;
            let counts = |i: &usize| weights.is_none_or(|weights| weights[first + i] != 0.0);
            for i in (0..count).filter(counts) {
                for (seen, &j) in seen.iter_mut().zip(&self.columns) {
                    seen.add::<T>(block[(i, j)]);
                }
            }
            if seen.iter().all(|seen| seen.differs_rounded) {
                break;
            }
        }
        let mut lost = Lost::default();
        for (seen, &column) in seen.iter().zip(&self.columns) {
            match seen.differs {
                true if centered && !seen.differs_rounded => lost.rounded.push(column),
                true => lost.underflowed.push(column),
                false => {}
            }
        }
        Ok(lost)
    }
}

/// What is known of the entries of a column.
struct Seen {
    /// What entries are compared with.
    from: Option<f64>,
    differs: bool,
    /// Whether entries differ when they are rounded to the scalars of C.
    differs_rounded: bool,
}

impl Seen {
    /// Returns what is known before the first entry, of a column to be compared with 0 or with its
    /// first entry.
    fn new(with_zero: bool) -> Self {
        Self { from: with_zero.then_some(0.0), differs: false, differs_rounded: false }
    }

    fn add<T: BlasReal>(&mut self, entry: f64) {
        let from = *self.from.get_or_insert(entry);
        self.differs |= entry != from;
        self.differs_rounded |= T::from_f64(entry) != T::from_f64(from);
    }
}

/// The columns whose squared lengths are lost, by the cause.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct Lost {
    /// Their squares are too small.
    pub underflowed: Vec<usize>,
    /// Their entries are equal when they are rounded to the scalars of C.
    pub rounded: Vec<usize>,
}

impl Lost {
    /// Notes these columns of a file, and what helps.
    pub fn note<T: BlasReal>(&self, source: &Source, centered: bool) {
        let file = source.path().display();
        let (what, scalar) = (if centered { "constant" } else { "zero" }, T::NAME);
        let is = |columns: &[usize]| {
            let verb = if columns.len() == 1 { "is" } else { "are" };
            format!("{} {verb}", source.described(columns))
        };
        if !self.underflowed.is_empty() {
            let columns = is(&self.underflowed);
            let double = if T::NAME == f32::NAME { ", or use --f64" } else { "" };
            let (entries, them) = match self.underflowed.len() {
                1 => ("its entry on the diagonal of C is", "column"),
                _ => ("their entries on the diagonal of C are", "columns"),
            };
            note(format_args!(
                "{file}: {columns} not {what}, but {entries} too small for {scalar}: multiply the \
                 {them} by a power of ten{double}"
            ));
        }
        if !self.rounded.is_empty() {
            let columns = is(&self.rounded);
            note(format_args!(
                "{file}: rounded to {scalar}, {columns} constant, which makes the diagonal of C 0 \
                 there: leave --f32 out"
            ));
        }
    }
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

    /// Returns the columns that are found if the diagonal of C shows none, as scalars T.
    fn lost<T: BlasReal>(a: &Mat<f64>, weights: Option<&[f64]>, centered: bool) -> Lost {
        let all = Faint { columns: (0..a.ncols()).collect() };
        all.lost_in::<T>(&mut DenseRows(a.as_ref()), weights, centered).unwrap()
    }

    fn found(a: &Mat<f64>, weights: Option<&[f64]>, centered: bool) -> Vec<usize> {
        let lost = lost::<f64>(a, weights, centered);
        assert!(lost.rounded.is_empty());
        lost.underflowed
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
        assert_eq!(found(&a, None, false), [1, 2]);
        assert!(found(&a, None, true).is_empty());
        assert!(found(&a, Some(&[0.0, 0.0]), false).is_empty());
        assert!(found(&a, Some(&[1.0, -1.0]), false).is_empty());
        let b = mat![[1.0, 2.0], [1.0, 2.0], [1.0, 3.0]];
        assert_eq!(found(&b, None, true), [1]);
        assert!(found(&b, Some(&[1.0, 1.0, 0.0]), true).is_empty());
        assert!(found(&mat![[0.0, -0.0]], None, false).is_empty());
    }

    #[test]
    fn digits_that_are_lost_beside_the_mean_are_no_underflow() {
        let a = mat![[1e9, 1.0, 1e12], [1e9 + 1.0, 2.0, 1e12 + 3.0]];
        let expected = Lost { underflowed: vec![1], rounded: vec![0, 2] };
        assert_eq!(lost::<f32>(&a, None, true), expected);
        // About zero nothing is lost beside a mean.
        let tiny = lost::<f32>(&mat![[1e-50], [2e-50]], None, false);
        assert_eq!(tiny, Lost { underflowed: vec![0], rounded: vec![] });
    }
}
