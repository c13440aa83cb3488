//! Where the blocks of a product go once their residues are known.

use std::ops::Range;

use faer::MatMut;
use faer::prelude::ReborrowMut;

use super::columns::Columns;
use crate::base::Disjoint;
use crate::kernel::int8::{
    Block, Integer, IntegerModuli, Kernel, MOST_MODULI, Moduli, Operand, PANEL, Quarter, WIDTH,
    fetch_lines, integers,
};

/// Takes the blocks of a product.
pub(super) trait Sink: Sync {
    /// Returns whether rows of the product lie side by side, so that blocks are best taken by rows.
    fn is_by_rows(&self) -> bool;

    /// Takes the block of panels (i, j) from its residues, modulus by modulus. Those of the block
    /// that follows are `next` blocks further on in memory.
    ///
    /// # Safety
    /// No two calls at a time are for the same block.
    unsafe fn take(
        &self,
        kernel: &dyn Kernel,
        block: (usize, usize),
        residues: &[&Block<i8>],
        next: usize,
    );
}

/// Calls `visit(row, col, triangle, residues)` for each of the four quarters of the block of panels
/// (i, j) that is inside an n x k matrix. `row` and `col` are those of its first entry; with
/// `triangle` only its lower triangle is needed.
fn for_quarters(
    (i, j): (usize, usize),
    (n, k): (usize, usize),
    symmetric: bool,
    residues: &[&Block<i8>],
    next: usize,
    mut visit: impl FnMut(usize, usize, bool, &[&Quarter<i8>]),
) {
    for quarter in 0..4 {
        let (row, col) = (i * PANEL + quarter / 2 * WIDTH, j * PANEL + quarter % 2 * WIDTH);
        if row >= n || col >= k || symmetric && row < col {
            continue;
        }
        let mut of_quarter = [&residues[0][quarter]; MOST_MODULI];
        for (of_quarter, residues) in of_quarter.iter_mut().zip(residues) {
            *of_quarter = &residues[quarter];
            // The residues of the next block are prefetched.
            let next = std::ptr::from_ref::<Block<i8>>(residues).wrapping_add(next);
            fetch_lines(next.cast::<Quarter<i8>>().wrapping_add(quarter), 4);
        }
        visit(row, col, symmetric && row == col, &of_quarter[..residues.len()]);
    }
}

/// A sink that computes `C := alpha X + beta C` for the product X.
pub(super) struct Floats<'c, T> {
    pub alpha: T,
    pub beta: T,
    pub moduli: &'c Moduli,
    pub left: &'c Columns,
    pub right: &'c Columns,
    /// Whether only the lower triangle of C is touched.
    pub symmetric: bool,
    pub c: Disjoint<'c, T>,
}

impl<T: Operand> Sink for Floats<'_, T> {
    fn is_by_rows(&self) -> bool {
        self.c.col_stride().unsigned_abs() <= self.c.row_stride().unsigned_abs()
    }

    unsafe fn take(
        &self,
        kernel: &dyn Kernel,
        block: (usize, usize),
        residues: &[&Block<i8>],
        next: usize,
    ) {
        let (n, k) = (self.c.nrows(), self.c.ncols());
        let mut values = [[0.0; WIDTH]; WIDTH];
        for_quarters(
            block,
            (n, k),
            self.symmetric,
            residues,
            next,
            |row, col, triangle, residues| {
                let rows = self.left.exponents_of(row / WIDTH).map(|e| -e);
                let cols = self.right.exponents_of(col / WIDTH).map(|e| -e);
                kernel.recombine(residues, self.moduli, &rows, &cols, &mut values);
                let (rows, cols) = (row..n.min(row + WIDTH), col..k.min(col + WIDTH));
                // SAFETY: the caller's promise; quarters are disjoint.
                let c = unsafe { self.c.block(rows, cols) };
                self.store(&values, triangle, c);
            },
        );
    }
}

impl<T: Operand> Floats<'_, T> {
    /// Stores at most 16 x 16 values, or their lower triangle.
    fn store(&self, values: &Quarter<f64>, triangle: bool, mut c: MatMut<'_, T>) {
        if c.row_stride() == 1 {
            let columns: Quarter<f64> =
                std::array::from_fn(|j| std::array::from_fn(|i| values[i][j]));
            for (j, values) in columns.iter().enumerate().take(c.ncols()) {
                let first = if triangle { j } else { 0 };
                let (values, end) = (&values[first..], c.nrows());
                self.store_line(
                    values,
                    c.rb_mut().col_mut(j).subrows_mut(first, end - first).iter_mut(),
                );
            }
        } else {
            for (i, values) in values.iter().enumerate().take(c.nrows()) {
                let count = if triangle { i + 1 } else { WIDTH };
                self.store_line(&values[..count], c.rb_mut().row_mut(i).iter_mut());
            }
        }
    }

    fn store_line<'c>(&self, values: &[f64], c: impl Iterator<Item = &'c mut T>)
    where
        T: 'c,
    {
        let (alpha, beta) = (self.alpha, self.beta);
        let scaled = |value: &f64| match alpha == T::ONE {
            true => T::from_f64(*value),
            false => alpha * T::from_f64(*value),
        };
        if beta == T::ZERO {
            values.iter().zip(c).for_each(|(value, c)| *c = scaled(value));
        } else {
            values.iter().zip(c).for_each(|(value, c)| *c = scaled(value) + beta * *c);
        }
    }
}

/// Rows of a lower triangle of integers, one after another, row i with i + 1 entries.
pub(crate) struct TriangleRows<'s, I> {
    entries: Disjoint<'s, I>,
    /// Entries of the triangle before the first of these.
    skipped: usize,
}

impl<'s, I> TriangleRows<'s, I> {
    /// Creates the view of the rows of a triangle from row `first` on.
    pub fn new(entries: &'s mut [I], first: usize) -> Self {
        Self { entries: Disjoint::of_slice(entries), skipped: triangle_len(first) }
    }

    /// Returns entry (i, j).
    ///
    /// # Safety
    /// No other thread uses it meanwhile.
    #[allow(clippy::mut_from_ref)]
    unsafe fn get(&self, i: usize, j: usize) -> &mut I {
        // SAFETY: the caller's promise.
        unsafe { self.entries.get(triangle_len(i) + j - self.skipped) }
    }
}

/// Returns the number of entries of the first `rows` rows of a lower triangle.
pub(crate) fn triangle_len(rows: usize) -> usize {
    rows * (rows + 1) / 2
}

/// Returns these rows of a triangle, whose entries lie one after another from those of the first
/// row on, and their numbers.
pub(crate) fn rows_of_triangle<T>(
    mut entries: &mut [T],
    rows: Range<usize>,
) -> impl Iterator<Item = (usize, &mut [T])> {
    rows.map(move |i| {
        let (row, rest) = std::mem::take(&mut entries).split_at_mut(i + 1);
        entries = rest;
        (i, row)
    })
}

/// A sink that computes `S += X` or `S -= X`; the integer product X is a part of the triangle S.
pub(super) struct Integers<'s, I> {
    pub moduli: &'s IntegerModuli,
    pub sums: &'s TriangleRows<'s, I>,
    /// The place in S of the first entry of X.
    pub corner: (usize, usize),
    /// Rows and columns of X.
    pub shape: (usize, usize),
    /// Whether only the lower triangle of X is used.
    pub symmetric: bool,
    pub subtract: bool,
}

impl<I: Integer> Sink for Integers<'_, I> {
    fn is_by_rows(&self) -> bool {
        true
    }

    unsafe fn take(
        &self,
        _kernel: &dyn Kernel,
        block: (usize, usize),
        residues: &[&Block<i8>],
        next: usize,
    ) {
        let (n, k) = self.shape;
        let mut values = [[I::default(); WIDTH]; WIDTH];
        for_quarters(
            block,
            self.shape,
            self.symmetric,
            residues,
            next,
            |row, col, triangle, residues| {
                integers(residues, self.moduli, &mut values);
                for (i, values) in values.iter().enumerate().take(n - row) {
                    let count = if triangle { i + 1 } else { WIDTH.min(k - col) };
                    for (j, &value) in values.iter().enumerate().take(count) {
                        let (i, j) = (self.corner.0 + row + i, self.corner.1 + col + j);
                        // SAFETY: the caller's promise; quarters are disjoint.
                        let sum = unsafe { self.sums.get(i, j) };
                        *sum = sum.plus(if self.subtract { value.negated() } else { value });
                    }
                }
            },
        );
    }
}
