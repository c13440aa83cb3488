//! A call in one form, whatever its spelling: `C := alpha L^T R + beta C`, all stored by columns,
//! with L, R or both conjugated.

use std::ptr::NonNull;

use catamaran::Uplo;
use catamaran::faer::{MatMut, MatRef};

use crate::element::Element;
use crate::overlap::{Extent, overlap};

/// An operand as it is stored, by columns.
#[derive(Debug, Clone, Copy)]
pub struct Stored<T> {
    pub pointer: *const T,
    pub rows: usize,
    pub cols: usize,
    pub leading: usize,
}

/// A side of the product: an operand or its transpose.
#[derive(Debug, Clone, Copy)]
pub struct Side<T> {
    pub stored: Stored<T>,
    pub transposed: bool,
    /// For complex elements: whether they are conjugated.
    pub conjugated: bool,
}

/// Which products a request is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A triangle of `A^T A`, or of `A^H A`: `syrk`, `herk`.
    Symmetric,
    /// `gemm`.
    General,
    /// A triangle of `A^T B`: `gemmt`.
    Triangle,
}

/// What a plan depends on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shape {
    pub kind: Kind,
    /// m, n and k.
    pub sides: [usize; 3],
    /// Whether L and R are conjugated; of complex symmetric products exactly one is.
    pub conjugated: [bool; 2],
}

/// A call whose arguments are valid.
#[derive(Debug, Clone, Copy)]
pub struct Request<T> {
    pub alpha: T,
    /// L, k x m.
    pub left: Side<T>,
    /// R, k x n; `None` when it is L, or the conjugate of L where elements are complex.
    pub right: Option<Side<T>>,
    pub beta: T,
    /// C, m x n.
    pub c: *mut T,
    pub c_leading: usize,
    /// The triangle of C that is wanted; `None` for all of it.
    pub triangle: Option<Uplo>,
}

impl<T> Stored<T> {
    fn extent(&self) -> Extent {
        let Self { rows, cols, leading, .. } = *self;
        Extent { address: self.pointer.addr(), rows, cols, leading }
    }
}

impl<T> Side<T> {
    /// Returns the rows of the side, k.
    fn depth(&self) -> usize {
        if self.transposed { self.stored.cols } else { self.stored.rows }
    }

    /// Returns the columns of the side.
    fn width(&self) -> usize {
        if self.transposed { self.stored.rows } else { self.stored.cols }
    }

    /// Returns a view of the side.
    ///
    /// # Safety
    /// The memory of the operand is readable for `'a`, unless a side is 0.
    unsafe fn view<'a>(&self) -> MatRef<'a, T> {
        let Stored { pointer, rows, cols, leading } = self.stored;
        let pointer = if pointer.is_null() { NonNull::dangling().as_ptr() } else { pointer };
        // SAFETY: by the contract the operand is readable for `'a`; `arguments` has checked the
        // sides and the leading dimension, which is at most isize::MAX, and a pointer that is NULL
        // has no elements to read.
        let stored =
            unsafe { MatRef::from_raw_parts(pointer, rows, cols, 1, leading.cast_signed()) };
        if self.transposed { stored.transpose() } else { stored }
    }
}

impl<T: Element> Request<T> {
    /// Returns what a plan depends on.
    pub fn shape(&self) -> Shape {
        let kind = match (&self.right, self.triangle) {
            (None, _) => Kind::Symmetric,
            (Some(_), None) => Kind::General,
            (Some(_), Some(_)) => Kind::Triangle,
        };
        let left = self.left.conjugated;
        let right = self.right.map_or(T::IS_COMPLEX && !left, |right| right.conjugated);
        Shape { kind, sides: self.sides(), conjugated: [left, right] }
    }

    /// Returns whether C is Hermitian: imaginary parts of its diagonal are not read, and become
    /// zero.
    pub fn is_hermitian(&self) -> bool {
        T::IS_COMPLEX && self.right.is_none()
    }

    /// Returns m, n and k.
    pub fn sides(&self) -> [usize; 3] {
        let right = self.right.as_ref().unwrap_or(&self.left);
        [self.left.width(), right.width(), self.left.depth()]
    }

    /// Returns the products of real numbers, both triangles of a symmetric result counted.
    pub fn work(&self) -> f64 {
        let products: f64 = self.sides().iter().map(|&side| side as f64).product();
        if T::IS_COMPLEX { 4.0 * products } else { products }
    }

    /// Returns whether nothing is multiplied: `C := beta C`.
    pub fn is_trivial(&self) -> bool {
        self.alpha == T::ZERO || self.sides().contains(&0)
    }

    /// Returns whether all pointers are aligned for their elements.
    pub fn is_aligned(&self) -> bool {
        self.left.stored.pointer.is_aligned()
            && self.right.is_none_or(|right| right.stored.pointer.is_aligned())
            && self.c.is_aligned()
    }

    /// Returns whether C shares memory with an operand.
    pub fn overlaps(&self) -> bool {
        let [rows, cols, _] = self.sides();
        let c = Extent { address: self.c.addr(), rows, cols, leading: self.c_leading };
        [Some(self.left), self.right]
            .iter()
            .flatten()
            .any(|side| overlap(side.stored.extent(), c, size_of::<T>()))
    }

    /// Returns L, and R when it is another matrix.
    ///
    /// # Safety
    /// The caller of BLAS owns the memory that it named for the length of the call, `'a`.
    pub unsafe fn operands<'a>(&self) -> (MatRef<'a, T>, Option<MatRef<'a, T>>) {
        // SAFETY: the contract is that of `view`: the caller of BLAS owns the memory for `'a`.
        unsafe { (self.left.view(), self.right.map(|right| right.view())) }
    }

    /// Returns C.
    ///
    /// # Safety
    /// As [`Request::operands`]; and there is no other view of C.
    pub unsafe fn result<'a>(&self) -> MatMut<'a, T> {
        let [rows, cols, _] = self.sides();
        let c = if self.c.is_null() { NonNull::dangling().as_ptr() } else { self.c };
        // SAFETY: by the contract the caller of BLAS owns C for `'a`, and this is the only view;
        // `arguments` has checked the sides and the leading dimension, and a pointer that is NULL
        // has no elements.
        unsafe { MatMut::from_raw_parts_mut(c, rows, cols, 1, self.c_leading.cast_signed()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn product(a: &[f64], transposed: bool, c: &mut [f64]) -> Request<f64> {
        let stored = Stored { pointer: a.as_ptr(), rows: 3, cols: 2, leading: 4 };
        Request {
            alpha: 1.0,
            left: Side { stored, transposed, conjugated: false },
            right: None,
            beta: 0.0,
            c: c.as_mut_ptr(),
            c_leading: 3,
            triangle: Some(Uplo::Lower),
        }
    }

    #[test]
    fn sides_are_those_of_the_product() {
        let (a, mut c) = ([0.0; 8], [0.0; 9]);
        let plain = product(&a, false, &mut c);
        assert_eq!((plain.sides(), plain.work()), ([2, 2, 3], 12.0));
        assert_eq!(product(&a, true, &mut c).sides(), [3, 3, 2]);
        assert!(!plain.is_trivial() && Request { alpha: 0.0, ..plain }.is_trivial());
    }

    #[test]
    fn views_are_of_the_elements_named() {
        let a: Vec<f64> = (0..8).map(f64::from).collect();
        let mut c = [0.0; 9];
        let request = product(&a, true, &mut c);
        assert!(request.is_aligned() && !request.overlaps());
        // SAFETY: `a` and `c` live on, and are long enough.
        let (left, c) = unsafe { (request.operands().0, request.result()) };
        assert_eq!((left.shape(), left[(1, 2)], c.shape()), ((2, 3), 6.0, (3, 3)));
        let inside = Request { c: a.as_ptr().cast_mut(), ..request };
        assert!(inside.overlaps());
        // SAFETY: the pointer stays inside of `a`.
        let odd = unsafe { a.as_ptr().byte_add(1) }.cast_mut();
        assert!(!Request { c: odd, ..request }.is_aligned());
    }
}
