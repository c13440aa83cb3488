//! One supernode of a factor, applied to rows of right-hand sides.

use std::ops::Range;

use faer::{MatMut, MatRef};

/// Right-hand sides that are solved for together.
pub(super) const WIDTH: usize = 8;

/// One row of [`WIDTH`] right-hand sides.
pub(super) type Row = [f64; WIDTH];

/// Columns of L with the same pattern below a dense triangle. Their values are stored by columns,
/// with `columns + below` rows.
#[derive(Debug, Clone, Copy)]
pub(super) struct Supernode {
    /// Its first column.
    pub start: usize,
    pub columns: usize,
    /// Rows below the triangle.
    pub below: usize,
    /// Where its values begin in those of the factor.
    pub values: usize,
}

impl Supernode {
    /// Returns the number of rows of its values.
    pub fn rows(&self) -> usize {
        self.columns + self.below
    }

    /// Returns where its values are in those of the factor.
    pub fn range(&self) -> Range<usize> {
        self.values..self.values + self.rows() * self.columns
    }

    /// Returns its own values as a matrix.
    pub fn panel<'v>(&self, values: &'v [f64]) -> MatRef<'v, f64> {
        MatRef::from_column_major_slice(values, self.rows(), self.columns)
    }

    /// Returns its own values as the triangle and the rows below.
    pub fn parts<'v>(&self, values: &'v mut [f64]) -> (MatMut<'v, f64>, MatMut<'v, f64>) {
        let panel = MatMut::from_column_major_slice_mut(values, self.rows(), self.columns);
        panel.split_at_row_mut(self.columns)
    }

    /// Returns its part of the values of the factor.
    fn of<'v>(&self, values: &'v [f64]) -> &'v [f64] {
        &values[self.range()]
    }

    /// Computes `x := L^-1 x` for the triangle and rows `first..` of x, and updates the rows of x
    /// that `targets` names, one for each row below. With `UNIT` the diagonal of L is 1; with
    /// `FUSED` products are added without rounding them first, where the processor can.
    #[inline(always)]
    pub fn down<const UNIT: bool, const FUSED: bool>(
        &self,
        values: &[f64],
        first: usize,
        targets: &[u32],
        x: &mut [Row],
    ) {
        let panel = Panel::<FUSED> { values: self.of(values), rows: self.rows() };
        let n = self.columns;
        let own = &mut x[first..first + n];
        let mut i = 0;
        while i < n {
            let (known, rows) = own.split_at_mut(i);
            i += match n - i {
                8.. => panel.forward::<8, UNIT>(known, rows),
                4.. => panel.forward::<4, UNIT>(known, rows),
                2.. => panel.forward::<2, UNIT>(known, rows),
                _ => panel.forward::<1, UNIT>(known, rows),
            };
        }
        let mut i = n;
        let (eights, rest) = targets.as_chunks::<8>();
        let (fours, ones) = rest.as_chunks::<4>();
        for targets in eights {
            i += panel.subtract(i, first..first + n, targets, x);
        }
        for targets in fours {
            i += panel.subtract(i, first..first + n, targets, x);
        }
        for target in ones {
            i += panel.subtract(i, first..first + n, &[*target], x);
        }
    }

    /// Computes `x := L^-T x` for the rows of the triangle, which are the first of x; the rows
    /// below follow them in x.
    #[inline(always)]
    pub fn up<const UNIT: bool, const FUSED: bool>(&self, values: &[f64], x: &mut [Row]) {
        let panel = Panel::<FUSED> { values: self.of(values), rows: self.rows() };
        let mut i = self.columns;
        while i > 0 {
            i -= match i {
                8.. => panel.backward::<8, UNIT>(i, x),
                4.. => panel.backward::<4, UNIT>(i, x),
                2.. => panel.backward::<2, UNIT>(i, x),
                _ => panel.backward::<1, UNIT>(i, x),
            };
        }
    }

    /// Returns the blocks of B in `L B L^T`, of one row or two: their first row in the triangle,
    /// the diagonal, and, for two rows, the entry below it.
    pub fn blocks<'v>(
        &self,
        values: &'v [f64],
        subdiagonal: &'v [f64],
    ) -> impl Iterator<Item = (usize, Block)> + use<'v> {
        let (n, rows, values) = (self.columns, self.rows(), self.of(values));
        let subdiagonal = &subdiagonal[self.start..][..n];
        let mut i = 0;
        std::iter::from_fn(move || {
            let at = i;
            (at < n).then(|| {
                let diagonal = |i: usize| values[i * rows + i];
                let block = match subdiagonal[at] {
                    0.0 => Block::One(diagonal(at)),
                    below => Block::Two([diagonal(at), diagonal(at + 1)], below),
                };
                i += match block {
                    Block::One(_) => 1,
                    Block::Two(..) => 2,
                };
                (at, block)
            })
        })
    }
}

/// A symmetric block on the diagonal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Block {
    One(f64),
    /// The diagonal, and the entry beside it.
    Two([f64; 2], f64),
}

impl Block {
    /// Returns the number of its negative eigenvalues.
    pub fn negative(self) -> usize {
        match self {
            Self::One(d) => usize::from(d < 0.0),
            // Not by products, which overflow and underflow.
            Self::Two([d, next], below) if (d / below) * (next / below) < 1.0 => 1,
            Self::Two([d, _], _) => 2 * usize::from(d < 0.0),
        }
    }

    /// Returns whether it is a zero: a singular matrix leaves such a pivot.
    pub fn is_singular(self) -> bool {
        matches!(self, Self::One(0.0))
    }

    /// Computes `X := X B` for the columns of X from `first` on that belong to the block.
    pub fn multiply_columns(self, mut x: MatMut<'_, f64>, first: usize) {
        for i in 0..x.nrows() {
            match self {
                Self::One(d) => x[(i, first)] *= d,
                Self::Two([d, next], below) => {
                    let (p, q) = (x[(i, first)], x[(i, first + 1)]);
                    x[(i, first)] = p * d + q * below;
                    x[(i, first + 1)] = p * below + q * next;
                }
            }
        }
    }

    /// Computes `X := X B^-1` for the columns of X from `first` on that belong to the block.
    pub fn divide_columns(self, mut x: MatMut<'_, f64>, first: usize) {
        for i in 0..x.nrows() {
            match self {
                Self::One(d) => x[(i, first)] /= d,
                Self::Two(diagonal, below) => {
                    let pair = [x[(i, first)], x[(i, first + 1)]];
                    [x[(i, first)], x[(i, first + 1)]] = Self::divided(diagonal, below, pair);
                }
            }
        }
    }

    /// Returns `B^-1 x` for a block of two rows with this diagonal and the entry `below` beside it.
    /// By Cramer's rule, in units of that entry, which is the largest.
    fn divided(diagonal: [f64; 2], below: f64, [x, next]: [f64; 2]) -> [f64; 2] {
        let [a, b] = diagonal.map(|d| d / below);
        let determinant = a * b - 1.0;
        let [p, q] = [x / below, next / below];
        [(b * p - q) / determinant, (a * q - p) / determinant]
    }

    /// Computes `x := B^-1 x` for the first rows of x.
    pub fn solve(self, x: &mut [Row]) {
        match self {
            Self::One(d) => x[0] = x[0].map(|x| x / d),
            Self::Two(diagonal, below) => {
                for j in 0..WIDTH {
                    [x[0][j], x[1][j]] = Self::divided(diagonal, below, [x[0][j], x[1][j]]);
                }
            }
        }
    }
}

/// The values of a supernode.
struct Panel<'v, const FUSED: bool> {
    values: &'v [f64],
    rows: usize,
}

impl<const FUSED: bool> Panel<'_, FUSED> {
    /// Returns `a b + c`.
    #[inline(always)]
    fn add(a: f64, b: &Row, c: Row) -> Row {
        std::array::from_fn(|j| if FUSED { a.mul_add(b[j], c[j]) } else { a * b[j] + c[j] })
    }

    /// Solves for the first N rows, which come after the known ones. Returns N.
    #[inline(always)]
    fn forward<const N: usize, const UNIT: bool>(&self, known: &[Row], rows: &mut [Row]) -> usize {
        let i = known.len();
        let mut sums = self.product::<N>(i, known);
        for r in 0..N {
            let column = &self.values[(i + r) * self.rows + i..][..N];
            rows[r] = Self::divided::<UNIT>(&rows[r], &sums[r], column[r]);
            for k in r + 1..N {
                sums[k] = Self::add(column[k], &rows[r], sums[k]);
            }
        }
        N
    }

    /// Subtracts rows from i on, N of them, of L times the rows `known` of x from the rows
    /// `targets`. Returns N.
    #[inline(always)]
    fn subtract<const N: usize>(
        &self,
        i: usize,
        known: Range<usize>,
        targets: &[u32; N],
        x: &mut [Row],
    ) -> usize {
        let sums = self.product::<N>(i, &x[known]);
        for (&target, sum) in targets.iter().zip(&sums) {
            let row = &mut x[target as usize];
            *row = std::array::from_fn(|j| row[j] - sum[j]);
        }
        N
    }

    /// Returns rows from i on, N of them, of L times x.
    #[inline(always)]
    fn product<const N: usize>(&self, i: usize, x: &[Row]) -> [Row; N] {
        let mut sums = [[0.0; WIDTH]; N];
        for (k, x) in x.iter().enumerate() {
            let column = &self.values[k * self.rows + i..][..N];
            for r in 0..N {
                sums[r] = Self::add(column[r], x, sums[r]);
            }
        }
        sums
    }

    /// Solves for the N rows that end before `end`; those from there on are known. Returns N.
    #[inline(always)]
    fn backward<const N: usize, const UNIT: bool>(&self, end: usize, x: &mut [Row]) -> usize {
        let i = end - N;
        let (rows, known) = x.split_at_mut(end);
        let columns: [&[f64]; N] =
            std::array::from_fn(|r| &self.values[(i + r) * self.rows + end..][..known.len()]);
        let mut sums = [[0.0; WIDTH]; N];
        for k in 0..known.len() {
            for r in 0..N {
                sums[r] = Self::add(columns[r][k], &known[k], sums[r]);
            }
        }
        for r in (0..N).rev() {
            let column = &self.values[(i + r) * self.rows + i..][..N];
            for k in r + 1..N {
                sums[r] = Self::add(column[k], &rows[i + k], sums[r]);
            }
            rows[i + r] = Self::divided::<UNIT>(&rows[i + r], &sums[r], column[r]);
        }
        N
    }

    /// Returns `(x - sum) / d`, or `x - sum` with a unit diagonal.
    #[inline(always)]
    fn divided<const UNIT: bool>(x: &Row, sum: &Row, d: f64) -> Row {
        std::array::from_fn(|j| if UNIT { x[j] - sum[j] } else { (x[j] - sum[j]) / d })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn negative_eigenvalues_of_blocks_are_counted_at_any_scale() {
        // 1e-200 and 1e200 have squares that underflow and overflow.
        for scale in [1e-300, 1e-200, 1.0, -1.0, 1e200, 1e300] {
            let two = |a: f64, b: f64| Block::Two([scale * a, scale * b], scale).negative();
            assert_eq!((two(0.0, 0.0), two(0.5, 0.5), two(-0.5, 0.5)), (1, 1, 1), "{scale:e}");
            let definite = if scale > 0.0 { 0 } else { 2 };
            assert_eq!((two(2.0, 3.0), two(-2.0, -3.0)), (definite, 2 - definite), "{scale:e}");
        }
        let one = |d: f64| (Block::One(d).negative(), Block::One(d).is_singular());
        assert_eq!([one(-3.0), one(0.0), one(3.0)], [(1, false), (0, true), (0, false)]);
    }
}
