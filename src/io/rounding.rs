//! Integers that are no f64 and are rounded to the nearest one. Every reader counts them, or knows
//! the first.

use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Integers beyond 2^53 that are no f64, so that they were rounded to the nearest one.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct RoundedIntegers {
    /// How many there are.
    pub count: u64,
    /// Where the first one is, as messages say it: `line 4, column 2 (id)` of text, where both
    /// count from 1, or `row 3, column 0 (counted from 0)`.
    pub place: String,
}

impl RoundedIntegers {
    /// Adds `count` integers, the first of which is at `place`.
    pub(super) fn add(found: &mut Option<Self>, count: u64, place: impl FnOnce() -> String) {
        if count > 0 {
            found.get_or_insert_with(|| Self { count: 0, place: place() }).count += count;
        }
    }
}

impl fmt::Display for RoundedIntegers {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { count, place } = self;
        match count {
            1 => write!(f, "an integer beyond 2^53 rounded, in {place}"),
            _ => write!(f, "{count} integers beyond 2^53 rounded, the first in {place}"),
        }
    }
}

/// Returns whether an integer of this magnitude is no f64.
#[inline]
pub(super) fn is_rounded(magnitude: u128) -> bool {
    magnitude > 1 << f64::MANTISSA_DIGITS
        && u128::BITS - magnitude.leading_zeros() - magnitude.trailing_zeros()
            > f64::MANTISSA_DIGITS
}

/// Returns the message for an entry of a matrix.
pub(super) fn place(row: usize, column: usize) -> String {
    format!("row {row}, column {column} (counted from 0)")
}

/// The first of the integers that were rounded while rows were read, in any order and by several
/// readers.
#[derive(Debug, Clone)]
pub(super) struct FirstRounded {
    /// The number of the entry, row by row; [`u64::MAX`] before there is one.
    entry: Arc<AtomicU64>,
    ncols: usize,
}

impl FirstRounded {
    /// Creates the place for a matrix of this many columns.
    pub(super) fn new(ncols: usize) -> Self {
        Self { entry: Arc::new(AtomicU64::new(u64::MAX)), ncols }
    }

    /// Records that an entry was rounded.
    pub(super) fn add(&self, row: usize, column: usize) {
        let entry = (row as u64).saturating_mul(self.ncols as u64).saturating_add(column as u64);
        self.entry.fetch_min(entry, Ordering::Relaxed);
    }

    /// Returns a note, if an entry was rounded.
    pub(super) fn note(&self) -> Option<String> {
        let entry = self.entry.load(Ordering::Relaxed);
        (entry != u64::MAX).then(|| {
            let (row, column) = (entry / self.ncols as u64, entry % self.ncols as u64);
            let place = place(row as usize, column as usize);
            format!("integers beyond 2^53 rounded, the first in {place}")
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integers_that_are_no_f64_are_known() {
        let large = 1_u128 << 53;
        for exact in [0, 1, large - 1, large, large + 2, 3 << 80, u128::from(u64::MAX) + 1] {
            assert!(!is_rounded(exact) && exact as f64 as u128 == exact, "{exact}");
        }
        for rounded in [large + 1, large + 3, u128::from(u64::MAX), (1 << 80) + 1] {
            assert!(is_rounded(rounded) && rounded as f64 as u128 != rounded, "{rounded}");
        }
    }

    #[test]
    fn the_first_entry_is_found_in_any_order() {
        let first = FirstRounded::new(7);
        assert_eq!(first.note(), None);
        first.add(4, 6);
        first.clone().add(2, 5);
        first.add(2, 6);
        let note = "integers beyond 2^53 rounded, the first in row 2, column 5 (counted from 0)";
        assert_eq!(first.note().as_deref(), Some(note));
    }
}
