//! Lower triangles that are stored row after row, row i with i + 1 entries.

use std::ops::Range;

/// Returns the number of entries of a lower triangle of `n` rows, the diagonal included. Row `n` of
/// a larger triangle begins at this entry.
///
/// ```
/// use catamaran::base::triangle_len;
///
/// assert_eq!(triangle_len(4), 10);
/// ```
#[inline]
pub fn triangle_len(n: usize) -> usize {
    // Of n and n + 1 the even one is halved; the other is `n | 1`.
    n.div_ceil(2) * (n | 1)
}

/// Returns the row of a triangle that its entry number `entry` is in.
pub(crate) fn triangle_row_of(entry: usize) -> usize {
    // i (i + 1) / 2 <= e, i the largest
    ((8 * entry as u128 + 1).isqrt() as usize - 1) / 2
}

/// Returns these rows of a triangle, whose entries lie one after another from those of the first
/// row on, and their numbers.
pub(crate) fn triangle_rows<T>(
    mut entries: &mut [T],
    rows: Range<usize>,
) -> impl Iterator<Item = (usize, &mut [T])> {
    rows.map(move |i| {
        let (row, rest) = std::mem::take(&mut entries).split_at_mut(i + 1);
        entries = rest;
        (i, row)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_know_their_row() {
        let mut entry = 0;
        for row in 0..200 {
            assert_eq!(triangle_len(row), entry);
            for _ in 0..=row {
                assert_eq!(triangle_row_of(entry), row);
                entry += 1;
            }
        }
        // Beyond the precision of f64.
        let n = 3_000_000_019;
        assert_eq!(triangle_row_of(triangle_len(n)), n);
        assert_eq!(triangle_row_of(triangle_len(n) - 1), n - 1);
    }

    #[test]
    fn rows_of_a_part_of_a_triangle_follow_each_other() {
        let mut entries: Vec<usize> = (triangle_len(2)..triangle_len(5)).collect();
        for (i, row) in triangle_rows(&mut entries, 2..5) {
            assert_eq!(row, (triangle_len(i)..triangle_len(i + 1)).collect::<Vec<_>>());
        }
    }
}
