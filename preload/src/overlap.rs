//! Whether two matrices share an element.

/// The elements of a matrix that is stored by columns: where it begins, as a number of bytes, and
/// its sides and leading dimension (at least `rows`, and 1) in elements.
#[derive(Debug, Clone, Copy)]
pub struct Extent {
    pub address: usize,
    pub rows: usize,
    pub cols: usize,
    pub leading: usize,
}

impl Extent {
    /// Returns the number of elements from the first to the last.
    fn span(&self) -> usize {
        (self.cols - 1) * self.leading + self.rows
    }
}

/// Returns whether `a` and `b`, of elements of `size` bytes, share an element. Parts of one larger
/// matrix are told apart. Where leading dimensions differ, interleaved matrices count as
/// overlapping.
pub fn overlap(a: Extent, b: Extent, size: usize) -> bool {
    if a.rows.min(a.cols).min(b.rows).min(b.cols) == 0 {
        return false;
    }
    let end = |x: &Extent| x.address.saturating_add(x.span() * size);
    if end(&a) <= b.address || end(&b) <= a.address {
        return false;
    }
    let distance = b.address as i128 - a.address as i128;
    let (size, leading) = (size as i128, a.leading as i128);
    if a.leading != b.leading || distance % size != 0 {
        return true;
    }
    // In columns of `leading` elements from the beginning of `a` on, `a` takes the first rows of
    // the first columns. The rows of `b` may continue in the next column.
    let (column, row) =
        ((distance / size).div_euclid(leading), (distance / size).rem_euclid(leading));
    let meets = |first_row: i128, rows: i128, first_col: i128| {
        rows > 0
            && first_row < a.rows as i128
            && first_col < a.cols as i128
            && first_col + b.cols as i128 > 0
    };
    let rows = b.rows as i128;
    meets(row, rows.min(leading - row), column) || meets(0, row + rows - leading, column + 1)
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    fn elements(x: Extent) -> HashSet<usize> {
        (0..x.cols)
            .flat_map(|j| (0..x.rows).map(move |i| x.address + 8 * (i + j * x.leading)))
            .collect()
    }

    #[test]
    fn parts_of_one_matrix_are_told_apart() {
        const LEADING: usize = 5;
        for rows in 0..=LEADING {
            for cols in 0..3 {
                let a = Extent { address: 800, rows, cols, leading: LEADING };
                for start in 60..160 {
                    for (rows, cols) in [(1, 1), (2, 3), (5, 1), (5, 2), (3, 0), (4, 2)] {
                        let b = Extent { address: 8 * start, rows, cols, leading: LEADING };
                        let shared = !elements(a).is_disjoint(&elements(b));
                        assert_eq!(overlap(a, b, 8), shared, "{a:?} {b:?}");
                        assert_eq!(overlap(b, a, 8), shared, "{b:?} {a:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn matrices_apart_do_not_overlap_whatever_their_leading_dimensions() {
        let a = Extent { address: 0, rows: 3, cols: 3, leading: 4 };
        let b = Extent { address: 8 * 11, rows: 2, cols: 3, leading: 7 };
        assert!(!overlap(a, b, 8) && !overlap(b, a, 8));
        let inside = Extent { address: 8 * 9, ..b };
        assert!(overlap(a, inside, 8) && overlap(inside, a, 8));
        let shifted = Extent { address: 4, ..a };
        assert!(overlap(a, shifted, 8));
    }
}
