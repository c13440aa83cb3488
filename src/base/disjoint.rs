//! Shared access to memory of which each thread writes its own part.

use std::marker::PhantomData;
use std::ops::Range;

use faer::MatMut;

/// A pointer that threads may share. Using the pointer is unsafe: the caller keeps the parts of
/// different threads disjoint.
#[derive(Debug)]
pub(crate) struct SharedPtr<T>(*mut T);

impl<T> Clone for SharedPtr<T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T> Copy for SharedPtr<T> {}

// SAFETY: only an address. Every access through it is unsafe and asks for disjointness; elements
// move between threads, hence `T: Send`.
unsafe impl<T: Send> Send for SharedPtr<T> {}
// SAFETY: only an address, as for `Send`: every access through a shared one is unsafe and asks for
// disjointness; elements move between threads, hence `T: Send`.
unsafe impl<T: Send> Sync for SharedPtr<T> {}

impl<T> SharedPtr<T> {
    /// Creates a pointer that threads may share.
    pub fn new(start: *mut T) -> Self {
        Self(start)
    }

    /// Returns the address `offset` elements after this one, which need not lie inside the memory.
    #[inline(always)]
    pub fn at(self, offset: isize) -> *mut T {
        self.0.wrapping_offset(offset)
    }
}

/// A matrix (or a slice, which is one column) whose disjoint parts are written from several
/// threads.
///
/// The borrow of the matrix lasts as long as this view. Each access is unsafe: the caller promises
/// that no two parts that are alive at a time overlap, usually because tickets hand out each part
/// once.
pub(crate) struct Disjoint<'a, T> {
    start: SharedPtr<T>,
    rows: usize,
    cols: usize,
    row_stride: isize,
    col_stride: isize,
    borrow: PhantomData<MatMut<'a, T>>,
}

impl<'a, T> Disjoint<'a, T> {
    /// Creates a view of a matrix that threads may share.
    pub fn new(matrix: MatMut<'a, T>) -> Self {
        Self {
            start: SharedPtr::new(matrix.as_ptr_mut()),
            rows: matrix.nrows(),
            cols: matrix.ncols(),
            row_stride: matrix.row_stride(),
            col_stride: matrix.col_stride(),
            borrow: PhantomData,
        }
    }

    /// Creates a view of a slice as one column.
    pub fn of_slice(slice: &'a mut [T]) -> Self {
        let len = slice.len();
        Self::new(MatMut::from_column_major_slice_mut(slice, len, 1))
    }

    /// Returns the number of rows.
    pub fn nrows(&self) -> usize {
        self.rows
    }

    /// Returns the number of columns.
    pub fn ncols(&self) -> usize {
        self.cols
    }

    /// Returns the distance between rows, in elements.
    pub fn row_stride(&self) -> isize {
        self.row_stride
    }

    /// Returns the distance between columns, in elements.
    pub fn col_stride(&self) -> isize {
        self.col_stride
    }

    /// Returns the address of the first entry of a block inside the matrix.
    fn corner(&self, rows: &Range<usize>, cols: &Range<usize>) -> *mut T {
        assert!(rows.start <= rows.end && rows.end <= self.rows, "rows {rows:?} of {}", self.rows);
        assert!(cols.start <= cols.end && cols.end <= self.cols, "cols {cols:?} of {}", self.cols);
        let (row, col) = (rows.start as isize, cols.start as isize);
        self.start.at(row * self.row_stride + col * self.col_stride)
    }

    /// Returns the address of the block of these rows and columns, for kernels that compute
    /// addresses.
    pub fn pointer(&self, rows: &Range<usize>, cols: &Range<usize>) -> SharedPtr<T> {
        SharedPtr::new(self.corner(rows, cols))
    }

    /// Returns the block of these rows and columns.
    ///
    /// # Safety
    /// No other part that is alive meanwhile overlaps it.
    #[allow(clippy::mut_from_ref)]
    pub unsafe fn block(&self, rows: Range<usize>, cols: Range<usize>) -> MatMut<'_, T> {
        let corner = self.corner(&rows, &cols);
        // SAFETY: `corner` asserts that the block lies inside the borrowed matrix; no other part
        // that is alive overlaps it, by the contract.
        unsafe {
            let (down, across) = (self.row_stride, self.col_stride);
            MatMut::from_raw_parts_mut(corner, rows.len(), cols.len(), down, across)
        }
    }

    /// Returns entry `i` of the first column: element `i` of a slice.
    ///
    /// # Safety
    /// No other part that is alive meanwhile overlaps it.
    #[allow(clippy::mut_from_ref)]
    pub unsafe fn get(&self, i: usize) -> &mut T {
        assert!(i < self.rows, "element {i} of {}", self.rows);
        // SAFETY: the entry is inside the borrowed matrix, as asserted; no other part that is alive
        // overlaps it, by the contract.
        unsafe { &mut *self.start.at(i as isize * self.row_stride) }
    }

    /// Returns the given elements of a slice.
    ///
    /// # Safety
    /// No other part that is alive meanwhile overlaps them.
    #[allow(clippy::mut_from_ref)]
    pub unsafe fn range(&self, elements: Range<usize>) -> &mut [T] {
        assert!(self.cols == 1 && self.row_stride == 1, "not a slice");
        let (start, count) = (self.corner(&elements, &(0..1)), elements.len());
        // SAFETY: the elements are adjacent and inside the borrowed slice, as asserted; no other
        // part that is alive overlaps them, by the contract.
        unsafe { std::slice::from_raw_parts_mut(start, count) }
    }

    /// Returns entry `i` of the first column for reading.
    ///
    /// # Safety
    /// No thread writes it meanwhile.
    pub unsafe fn read(&self, i: usize) -> &T {
        assert!(i < self.rows, "element {i} of {}", self.rows);
        // SAFETY: `i` is below `rows`, as asserted, so the entry is inside the borrowed matrix; no
        // thread writes it meanwhile, by the contract.
        unsafe { &*self.start.at(i as isize * self.row_stride) }
    }
}

#[cfg(test)]
mod tests {
    use faer::Mat;
    use faer::prelude::ReborrowMut;

    use super::*;
    use crate::base::Par;

    /// `scripts/test --sanitize` runs this test under ThreadSanitizer.
    #[test]
    fn blocks_written_by_many_threads_arrive_whole_and_once() {
        for (n, k, side) in [(0, 3, 2), (1, 1, 4), (37, 53, 8), (64, 64, 16)] {
            let mut matrix = Mat::<f64>::zeros(n, k);
            let (down, across) = (n.div_ceil(side), k.div_ceil(side));
            let shared = Disjoint::new(matrix.as_mut());
            Par::Threads(4).for_each(0..down * across, |_, block| {
                let (i, j) = (block / across * side, block % across * side);
                // SAFETY: each block of the grid is visited once.
                let mut part = unsafe { shared.block(i..n.min(i + side), j..k.min(j + side)) };
                for row in 0..part.nrows() {
                    for col in 0..part.ncols() {
                        part.rb_mut()[(row, col)] += ((i + row) * k + j + col) as f64;
                    }
                }
            });
            assert_eq!(matrix, Mat::from_fn(n, k, |i, j| (i * k + j) as f64));
        }
    }

    #[test]
    fn elements_of_a_slice_are_its_own() {
        let mut values = vec![0_usize; 1000];
        let shared = Disjoint::of_slice(&mut values);
        // SAFETY: each element is visited once.
        Par::Threads(3).for_each(0..1000, |_, i| unsafe { *shared.get(i) = i });
        Par::Threads(3).for_each(0..10, |_, i| {
            // SAFETY: each range is visited once.
            unsafe { shared.range(100 * i..100 * (i + 1)) }.reverse();
        });
        Par::Threads(3).for_each(0..10, |_, i| {
            // SAFETY: each range is visited once.
            unsafe { shared.range(100 * i..100 * (i + 1)) }.sort_unstable();
        });
        // SAFETY: no thread writes any more.
        assert!((0..1000).all(|i| unsafe { *shared.read(i) } == i));
    }

    #[test]
    #[should_panic(expected = "rows 3..5 of 4")]
    fn a_block_beyond_the_matrix_is_refused() {
        let mut matrix = Mat::<f64>::zeros(4, 4);
        let shared = Disjoint::new(matrix.as_mut());
        // SAFETY: the call panics before it makes the block.
        let _ = unsafe { shared.block(3..5, 0..1) };
    }
}
