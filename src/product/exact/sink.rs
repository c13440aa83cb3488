//! Where the blocks of a product go once their residues are known.

use std::ops::Range;

use faer::prelude::ReborrowMut;
use faer::{MatMut, RowMut};

use super::columns::Columns;
use crate::base::{Disjoint, triangle_len};
use crate::kernel::int8::{
    Integer, IntegerModuli, IntegerOperand, Kernel, MOST_MODULI, Moduli, Next, PANEL, PanelBlock,
    Recombination, Square, WIDTH, integers, transpose,
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
        residues: &[&PanelBlock<i8>],
        next: usize,
    );
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

impl<T: IntegerOperand> Sink for Floats<'_, T> {
    fn is_by_rows(&self) -> bool {
        self.c.col_stride().unsigned_abs() <= self.c.row_stride().unsigned_abs()
    }

    unsafe fn take(
        &self,
        kernel: &dyn Kernel,
        (i, j): (usize, usize),
        residues: &[&PanelBlock<i8>],
        next: usize,
    ) {
        let extent = |panel, len: usize| PANEL * panel..len.min(PANEL * (panel + 1));
        let (rows, cols) = (extent(i, self.c.nrows()), extent(j, self.c.ncols()));
        // SAFETY: the contract: no other thread uses block (i, j), and blocks of different panels
        // are disjoint. `extent` ends at the last row and column of C.
        let c = unsafe { self.c.block(rows, cols) };
        let (across, along) = match self.is_by_rows() {
            true => (c.row_stride(), c.col_stride()),
            false => (c.col_stride(), c.row_stride()),
        };
        let next = Next {
            residues: next,
            line: c.as_ptr().wrapping_offset(PANEL as isize * along).cast(),
            stride: across * size_of::<T>() as isize,
            len: PANEL * size_of::<T>(),
        };
        let powers = |columns: &Columns, panel| columns.exponents_of_panel(panel).map(|e| -e);
        let (rows, columns) = (&powers(self.left, i), &powers(self.right, j));
        let mut values = [[0.0; PANEL]; PANEL];
        let moduli = self.moduli;
        let it = Recombination { residues, moduli, rows, columns, next };
        kernel.recombine(it, &mut values);
        self.store(&values, self.symmetric && i == j, c);
    }
}

impl<T: IntegerOperand> Floats<'_, T> {
    /// Stores at most 32 x 32 values, or their lower triangle.
    fn store(&self, values: &Square<f64>, triangle: bool, c: MatMut<'_, T>) {
        let (rows, cols) = c.shape();
        if c.row_stride() == 1 {
            let mut columns = [[0.0; PANEL]; PANEL];
            transpose(values.each_ref(), &mut columns);
            for (j, (values, c)) in columns.iter().zip(c.col_iter_mut()).enumerate() {
                let first = if triangle { j } else { 0 };
                self.store_line(values, c.transpose_mut(), first..rows);
            }
        } else {
            for (i, (values, c)) in values.iter().zip(c.row_iter_mut()).enumerate() {
                let end = if triangle { cols.min(i + 1) } else { cols };
                self.store_line(values, c, 0..end);
            }
        }
    }

    /// Stores the values in `range` to these elements of a line of C.
    fn store_line(&self, values: &[f64; PANEL], c: RowMut<'_, T>, range: Range<usize>) {
        let (alpha, beta) = (self.alpha, self.beta);
        let write = |(c, &value): (&mut T, &f64)| write_entry(alpha, beta, value, c);
        let values = &values[range.clone()];
        let mut c = c.subcols_mut(range.start, range.len());
        match c.rb_mut().try_as_row_major_mut() {
            Some(adjacent) => adjacent.as_slice_mut().iter_mut().zip(values).for_each(write),
            None => c.iter_mut().zip(values).for_each(write),
        }
    }
}

/// Computes `c := alpha value + beta c`; c is not read when beta is zero.
#[inline(always)]
pub(super) fn write_entry<T: IntegerOperand>(alpha: T, beta: T, value: f64, c: &mut T) {
    let value = T::from_f64(value);
    let scaled = if alpha == T::ONE { value } else { alpha * value };
    *c = if beta == T::ZERO { scaled } else { scaled + beta * *c };
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
        // SAFETY: the contract is that of `Disjoint::get`: no other thread uses this entry. The
        // index is checked there.
        unsafe { self.entries.get(triangle_len(i) + j - self.skipped) }
    }
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
        (i, j): (usize, usize),
        residues: &[&PanelBlock<i8>],
        next: usize,
    ) {
        let (n, k) = self.shape;
        let next = Next { residues: next, ..Next::NONE };
        let mut values = [[I::default(); WIDTH]; WIDTH];
        for quarter in 0..4 {
            let (row, col) = (i * PANEL + quarter / 2 * WIDTH, j * PANEL + quarter % 2 * WIDTH);
            if row >= n || col >= k || self.symmetric && row < col {
                continue;
            }
            let mut of_quarter = [&residues[0][quarter]; MOST_MODULI];
            for (of_quarter, residues) in of_quarter.iter_mut().zip(residues) {
                *of_quarter = &residues[quarter];
            }
            for part in 8 * quarter..8 * (quarter + 1) {
                next.fetch(residues, part);
            }
            integers(&of_quarter[..residues.len()], self.moduli, &mut values);
            for (i, values) in values.iter().enumerate().take(n - row) {
                let triangle = self.symmetric && row == col;
                let count = if triangle { i + 1 } else { WIDTH.min(k - col) };
                for (j, &value) in values.iter().enumerate().take(count) {
                    let (i, j) = (self.corner.0 + row + i, self.corner.1 + col + j);
                    // SAFETY: the contract: no other thread uses block (i, j) of X, to whose
                    // quarters the entries belong; each is taken once, and the reference ends with
                    // this iteration.
                    let sum = unsafe { self.sums.get(i, j) };
                    *sum = sum.plus(if self.subtract { value.negated() } else { value });
                }
            }
        }
    }
}
