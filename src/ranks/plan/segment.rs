use std::ops::Range;

use crate::base::{triangle_len, triangle_row_of};

/// A piece of one row of the lower triangle: entries `(row, j)` for `j` in `cols`, all `<= row`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Segment {
    /// Row of C.
    pub row: usize,
    /// Columns of C, not empty.
    pub cols: Range<usize>,
}

impl Segment {
    /// Returns the segments of the packed entries `entries` (row by row).
    pub(super) fn of_packed(entries: Range<usize>) -> impl Iterator<Item = Self> {
        let mut row = triangle_row_of(entries.start);
        let mut at = entries.start;
        std::iter::from_fn(move || {
            if at >= entries.end {
                return None;
            }
            let start = triangle_len(row);
            let end = triangle_len(row + 1).min(entries.end);
            let segment = Self { row, cols: at - start..end - start };
            (row, at) = (row + 1, end);
            Some(segment)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_range_of_entries_is_cut_at_the_ends_of_rows() {
        for start in 0..30 {
            for end in start..30 {
                let mut at = start;
                for segment in Segment::of_packed(start..end) {
                    assert!(segment.cols.end <= segment.row + 1 && !segment.cols.is_empty());
                    assert_eq!(triangle_len(segment.row) + segment.cols.start, at);
                    at += segment.cols.len();
                }
                assert_eq!(at, end);
            }
        }
    }
}
