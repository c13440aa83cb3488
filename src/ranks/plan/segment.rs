use std::ops::Range;

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
        let mut row = row_of(entries.start);
        let mut at = entries.start;
        std::iter::from_fn(move || {
            if at >= entries.end {
                return None;
            }
            let start = packed_len(row);
            let end = packed_len(row + 1).min(entries.end);
            let segment = Self { row, cols: at - start..end - start };
            (row, at) = (row + 1, end);
            Some(segment)
        })
    }
}

/// Returns the number of entries of a lower triangle of `n` rows, the diagonal included. Row `n`
/// begins at this entry of the packed triangle.
///
/// ```
/// use catamaran::ranks::plan::packed_len;
///
/// assert_eq!(packed_len(4), 10);
/// ```
pub fn packed_len(n: usize) -> usize {
    // One of the two is even, and halved before they overflow.
    if n.is_multiple_of(2) { n / 2 * (n + 1) } else { n.div_ceil(2) * n }
}

/// Returns the row that a packed entry is in.
fn row_of(entry: usize) -> usize {
    // i (i + 1) / 2 <= e, i the largest
    ((8 * entry as u128 + 1).isqrt() as usize - 1) / 2
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packed_entries_know_their_row() {
        let mut entry = 0;
        for row in 0..200 {
            assert_eq!(packed_len(row), entry);
            for _ in 0..=row {
                assert_eq!(row_of(entry), row);
                entry += 1;
            }
        }
        // Beyond the precision of f64.
        let n = 3_000_000_019;
        assert_eq!(row_of(packed_len(n)), n);
        assert_eq!(row_of(packed_len(n) - 1), n - 1);
    }

    #[test]
    fn any_range_of_entries_is_cut_at_the_ends_of_rows() {
        for start in 0..30 {
            for end in start..30 {
                let mut at = start;
                for segment in Segment::of_packed(start..end) {
                    assert!(segment.cols.end <= segment.row + 1 && !segment.cols.is_empty());
                    assert_eq!(packed_len(segment.row) + segment.cols.start, at);
                    at += segment.cols.len();
                }
                assert_eq!(at, end);
            }
        }
    }
}
