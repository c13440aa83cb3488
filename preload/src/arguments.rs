//! The arguments of Fortran and CBLAS, checked as the reference implementation does.
//!
//! Matrices stored by rows are their transposes stored by columns, so that a call by rows becomes
//! one by columns with the triangle turned over and the sides exchanged.

use catamaran::Uplo;

use crate::element::Element;
use crate::request::{Request, Side, Stored};

/// The number of an argument that is wrong, from 1, in the order in which the symbol takes them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Wrong(pub usize);

/// An integer of LP64 or ILP64.
pub trait Integer: Copy + Into<i64> {
    /// Returns the value as an extent, unless it is negative.
    fn extent(self) -> Option<usize> {
        usize::try_from(self.into()).ok()
    }
}

impl Integer for i32 {}
impl Integer for i64 {}

/// `TRANS`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Trans {
    No,
    Transposed,
    Conjugated,
}

impl Trans {
    fn transposes(self) -> bool {
        self != Self::No
    }

    /// Returns whether elements of this kind are conjugated.
    fn conjugates<T: Element>(self) -> bool {
        T::IS_COMPLEX && self == Self::Conjugated
    }
}

fn letter_trans(letter: u8) -> Option<Trans> {
    match letter.to_ascii_uppercase() {
        b'N' => Some(Trans::No),
        b'T' => Some(Trans::Transposed),
        b'C' => Some(Trans::Conjugated),
        _ => None,
    }
}

fn letter_triangle(letter: u8) -> Option<Uplo> {
    match letter.to_ascii_uppercase() {
        b'L' => Some(Uplo::Lower),
        b'U' => Some(Uplo::Upper),
        _ => None,
    }
}

// The values of the CBLAS enumerations (BLAST forum standard, annex C.1).
fn order_is_by_rows(order: i32) -> Option<bool> {
    match order {
        101 => Some(true),
        102 => Some(false),
        _ => None,
    }
}

fn number_trans(number: i32) -> Option<Trans> {
    match number {
        111 => Some(Trans::No),
        112 => Some(Trans::Transposed),
        113 => Some(Trans::Conjugated),
        _ => None,
    }
}

fn number_triangle(number: i32) -> Option<Uplo> {
    match number {
        121 => Some(Uplo::Upper),
        122 => Some(Uplo::Lower),
        _ => None,
    }
}

fn other_triangle(uplo: Uplo) -> Uplo {
    if uplo == Uplo::Lower { Uplo::Upper } else { Uplo::Lower }
}

/// Scalars and matrices of `syrk`, or of `herk` where elements T are complex, as the caller gave
/// them. Scalars S are real.
#[derive(Debug, Clone, Copy)]
pub struct Syrk<S, T, I> {
    pub n: I,
    pub k: I,
    pub alpha: S,
    pub a: *const T,
    pub lda: I,
    pub beta: S,
    pub c: *mut T,
    pub ldc: I,
}

impl<S: Into<T>, T: Element, I: Integer> Syrk<S, T, I> {
    /// Returns the request of Fortran with these letters.
    pub fn fortran(self, uplo: u8, trans: u8) -> Result<Request<T>, Wrong> {
        self.request(0, false, letter_triangle(uplo), letter_trans(trans))
    }

    /// Returns the request of CBLAS with these numbers.
    pub fn cblas(self, order: i32, uplo: i32, trans: i32) -> Result<Request<T>, Wrong> {
        let by_rows = order_is_by_rows(order).ok_or(Wrong(1))?;
        self.request(1, by_rows, number_triangle(uplo), number_trans(trans))
    }

    /// Returns the request; `before` is the number of arguments before `uplo`.
    fn request(
        self,
        before: usize,
        by_rows: bool,
        uplo: Option<Uplo>,
        trans: Option<Trans>,
    ) -> Result<Request<T>, Wrong> {
        let wrong = |number| Wrong(before + number);
        let uplo = uplo.ok_or(wrong(1))?;
        // `herk` has no transposes without conjugates.
        let trans = trans.filter(|&trans| !(T::IS_COMPLEX && trans == Trans::Transposed));
        let trans = trans.ok_or(wrong(2))?.transposes() != by_rows;
        let n = self.n.extent().ok_or(wrong(3))?;
        let k = self.k.extent().ok_or(wrong(4))?;
        // A^T A of A k x n, or A A^T of A n x k; A^H A, or A A^H, which is (A^T)^T conj(A^T).
        let (rows, cols) = if trans { (k, n) } else { (n, k) };
        let leading = leading(self.lda, rows).ok_or(wrong(7))?;
        let c_leading = self::leading(self.ldc, n).ok_or(wrong(10))?;
        let stored = Stored { pointer: self.a, rows, cols, leading };
        Ok(Request {
            alpha: self.alpha.into(),
            left: Side { stored, transposed: !trans, conjugated: T::IS_COMPLEX && trans },
            right: None,
            beta: self.beta.into(),
            c: self.c,
            c_leading,
            triangle: Some(if by_rows { other_triangle(uplo) } else { uplo }),
        })
    }
}

/// Scalars and matrices of `gemm` and `gemmt`, as the caller gave them; `m` of `gemmt` is `n`.
#[derive(Debug, Clone, Copy)]
pub struct Gemm<T, I> {
    pub m: I,
    pub n: I,
    pub k: I,
    pub alpha: T,
    pub a: *const T,
    pub lda: I,
    pub b: *const T,
    pub ldb: I,
    pub beta: T,
    pub c: *mut T,
    pub ldc: I,
}

/// Numbers of the arguments that can be wrong.
struct Numbers {
    trans: [usize; 2],
    sides: [usize; 3],
    leading: [usize; 3],
}

impl<T: Element, I: Integer> Gemm<T, I> {
    const GEMM: Numbers = Numbers { trans: [1, 2], sides: [3, 4, 5], leading: [8, 10, 13] };
    const GEMMT: Numbers = Numbers { trans: [2, 3], sides: [4, 4, 5], leading: [8, 10, 13] };

    /// Returns the request of Fortran's `gemm` with these letters.
    pub fn fortran(self, trans_a: u8, trans_b: u8) -> Result<Request<T>, Wrong> {
        self.request(0, Self::GEMM, false, None, [trans_a, trans_b].map(letter_trans))
    }

    /// Returns the request of CBLAS' `gemm` with these numbers.
    pub fn cblas(self, order: i32, trans_a: i32, trans_b: i32) -> Result<Request<T>, Wrong> {
        let by_rows = order_is_by_rows(order).ok_or(Wrong(1))?;
        self.request(1, Self::GEMM, by_rows, None, [trans_a, trans_b].map(number_trans))
    }

    /// Returns the request of Fortran's `gemmt` with these letters.
    pub fn fortran_triangle(self, uplo: u8, trans_a: u8, trans_b: u8) -> Result<Request<T>, Wrong> {
        let uplo = letter_triangle(uplo).ok_or(Wrong(1))?;
        self.request(0, Self::GEMMT, false, Some(uplo), [trans_a, trans_b].map(letter_trans))
    }

    /// Returns the request of CBLAS' `gemmt` with these numbers.
    pub fn cblas_triangle(
        self,
        order: i32,
        uplo: i32,
        trans_a: i32,
        trans_b: i32,
    ) -> Result<Request<T>, Wrong> {
        let by_rows = order_is_by_rows(order).ok_or(Wrong(1))?;
        let uplo = number_triangle(uplo).ok_or(Wrong(2))?;
        self.request(1, Self::GEMMT, by_rows, Some(uplo), [trans_a, trans_b].map(number_trans))
    }

    /// Returns the request; `before` is the number of arguments before those that `numbers` counts.
    fn request(
        self,
        before: usize,
        numbers: Numbers,
        by_rows: bool,
        uplo: Option<Uplo>,
        [trans_a, trans_b]: [Option<Trans>; 2],
    ) -> Result<Request<T>, Wrong> {
        let wrong = |number: usize| Wrong(before + number);
        let trans_a = trans_a.ok_or(wrong(numbers.trans[0]))?;
        let trans_b = trans_b.ok_or(wrong(numbers.trans[1]))?;
        let [conj_a, conj_b] = [trans_a, trans_b].map(Trans::conjugates::<T>);
        let [trans_a, trans_b] = [trans_a, trans_b].map(Trans::transposes);
        let m = self.m.extent().ok_or(wrong(numbers.sides[0]))?;
        let n = self.n.extent().ok_or(wrong(numbers.sides[1]))?;
        let k = self.k.extent().ok_or(wrong(numbers.sides[2]))?;
        // The sides are those of a matrix by columns; for a matrix by rows they are exchanged.
        let stored = |pointer, transposed: bool, rows, cols, given: I, number| {
            let (rows, cols) = if transposed != by_rows { (cols, rows) } else { (rows, cols) };
            let leading = leading(given, rows).ok_or(wrong(number))?;
            Ok(Stored { pointer, rows, cols, leading })
        };
        let a = stored(self.a, trans_a, m, k, self.lda, numbers.leading[0])?;
        let b = stored(self.b, trans_b, k, n, self.ldb, numbers.leading[1])?;
        let c_rows = if by_rows { n } else { m };
        let c_leading = leading(self.ldc, c_rows).ok_or(wrong(numbers.leading[2]))?;
        // By columns L^T R is op(A) op(B); by rows that is the transpose of op(B)^T op(A)^T.
        let side = |stored, transposed, conjugated| Side { stored, transposed, conjugated };
        let (left, right) = if by_rows {
            (side(b, !trans_b, conj_b), side(a, trans_a, conj_a))
        } else {
            (side(a, !trans_a, conj_a), side(b, trans_b, conj_b))
        };
        Ok(Request {
            alpha: self.alpha,
            left,
            right: Some(right),
            beta: self.beta,
            c: self.c,
            c_leading,
            triangle: uplo.map(|uplo| if by_rows { other_triangle(uplo) } else { uplo }),
        })
    }
}

/// Returns the leading dimension of columns of so many rows, if it is large enough.
fn leading<I: Integer>(given: I, rows: usize) -> Option<usize> {
    given.extent().filter(|&leading| leading >= rows.max(1))
}

#[cfg(test)]
mod tests {
    use std::ptr;

    use catamaran::faer::c32;

    use super::*;

    fn syrk(n: i32, k: i32, lda: i32, ldc: i32) -> Syrk<f64, f64, i32> {
        let (a, c) = (ptr::null(), ptr::null_mut());
        Syrk { n, k, alpha: 1.0, a, lda, beta: 0.0, c, ldc }
    }

    fn gemm(sides: [i64; 3], [lda, ldb, ldc]: [i64; 3]) -> Gemm<f32, i64> {
        let ([m, n, k], a, c) = (sides, ptr::null(), ptr::null_mut());
        Gemm { m, n, k, alpha: 1.0, a, lda, b: a, ldb, beta: 0.0, c, ldc }
    }

    #[test]
    fn wrong_arguments_of_syrk_have_the_numbers_of_the_reference() {
        let number =
            |call: Syrk<f64, f64, i32>, uplo, trans| call.fortran(uplo, trans).map(|_| ()).err();
        assert_eq!(number(syrk(3, 2, 3, 3), b'l', b'n'), None);
        assert_eq!(number(syrk(3, 2, 3, 3), b'/', b'N'), Some(Wrong(1)));
        assert_eq!(number(syrk(3, 2, 3, 3), b'U', b'/'), Some(Wrong(2)));
        assert_eq!(number(syrk(-1, 2, 3, 3), b'U', b'T'), Some(Wrong(3)));
        assert_eq!(number(syrk(3, -1, 3, 3), b'U', b'C'), Some(Wrong(4)));
        assert_eq!(number(syrk(3, 2, 2, 3), b'U', b'N'), Some(Wrong(7)));
        assert_eq!(number(syrk(3, 2, 2, 3), b'U', b'T'), None);
        assert_eq!(number(syrk(3, 2, 3, 2), b'U', b'N'), Some(Wrong(10)));
        assert_eq!(number(syrk(0, 0, 0, 1), b'U', b'N'), Some(Wrong(7)));
        assert_eq!(syrk(3, 2, 3, 3).cblas(100, 121, 111).err(), Some(Wrong(1)));
        assert_eq!(syrk(3, 2, 3, 3).cblas(102, 121, 114).err(), Some(Wrong(3)));
        // By rows A is n x k, with rows of k.
        assert!(syrk(3, 2, 2, 3).cblas(101, 121, 111).is_ok());
    }

    #[test]
    fn herk_has_conjugates_and_no_transposes() {
        let (a, c) = (ptr::null(), ptr::null_mut());
        let herk =
            Syrk::<f32, c32, i32> { n: 3, k: 2, alpha: 2.0, a, lda: 3, beta: 0.0, c, ldc: 3 };
        assert_eq!(herk.fortran(b'U', b'T').err(), Some(Wrong(2)));
        assert_eq!(herk.cblas(102, 121, 112).err(), Some(Wrong(3)));
        let shape = |request: Result<Request<c32>, Wrong>| request.unwrap().shape();
        // A^H A, A A^H = (A^T)^T conj(A^T), and by rows the transposes of these.
        for (right, letter, number) in [(false, b'C', 113), (true, b'N', 111)] {
            assert_eq!(shape(herk.fortran(b'L', letter)).conjugated, [!right, right]);
            assert_eq!(shape(herk.cblas(101, 122, number)).conjugated, [right, !right]);
        }
        assert!(herk.fortran(b'L', b'C').unwrap().is_hermitian());
    }

    #[test]
    fn gemm_keeps_the_conjugates_of_complex_matrices_alone() {
        let complex = Gemm::<c32, i64> {
            m: 2,
            n: 3,
            k: 4,
            alpha: c32::new(0.0, 1.0),
            a: ptr::null(),
            lda: 9,
            b: ptr::null(),
            ldb: 9,
            beta: c32::new(0.0, 0.0),
            c: ptr::null_mut(),
            ldc: 9,
        };
        let of = |request: Result<Request<c32>, Wrong>| request.unwrap().shape().conjugated;
        assert_eq!(of(complex.fortran(b'c', b'n')), [true, false]);
        assert_eq!(of(complex.fortran(b't', b'C')), [false, true]);
        assert_eq!(of(complex.cblas(101, 113, 112)), [false, true]);
        let real = gemm([2, 3, 4], [9, 9, 9]).fortran(b'C', b'C').unwrap();
        assert_eq!(real.shape().conjugated, [false, false]);
    }

    #[test]
    fn wrong_arguments_of_gemm_have_the_numbers_of_the_reference() {
        let number = |call: Gemm<f32, i64>, a, b| call.fortran(a, b).map(|_| ()).err();
        assert_eq!(number(gemm([2, 3, 4], [2, 4, 2]), b'N', b'N'), None);
        assert_eq!(number(gemm([2, 3, 4], [2, 4, 2]), b'/', b'N'), Some(Wrong(1)));
        assert_eq!(number(gemm([2, 3, 4], [2, 4, 2]), b'N', b'/'), Some(Wrong(2)));
        assert_eq!(number(gemm([-2, 3, 4], [2, 4, 2]), b'N', b'N'), Some(Wrong(3)));
        assert_eq!(number(gemm([2, -3, 4], [2, 4, 2]), b'N', b'N'), Some(Wrong(4)));
        assert_eq!(number(gemm([2, 3, -4], [2, 4, 2]), b'N', b'N'), Some(Wrong(5)));
        assert_eq!(number(gemm([2, 3, 4], [2, 4, 2]), b'T', b'N'), Some(Wrong(8)));
        assert_eq!(number(gemm([2, 3, 4], [2, 2, 2]), b'N', b'T'), Some(Wrong(10)));
        assert_eq!(number(gemm([2, 3, 4], [2, 4, 1]), b'N', b'N'), Some(Wrong(13)));
        let by_rows = gemm([2, 3, 4], [4, 3, 3]);
        assert!(by_rows.cblas(101, 111, 111).is_ok());
        assert_eq!(by_rows.cblas(102, 111, 111).err(), Some(Wrong(11)));
        assert_eq!(by_rows.cblas_triangle(101, 120, 111, 111).err(), Some(Wrong(2)));
    }

    #[test]
    fn calls_by_rows_are_transposed_calls_by_columns() {
        let request = gemm([2, 3, 4], [4, 3, 3]).cblas(101, 111, 111).unwrap();
        assert_eq!(request.sides(), [3, 2, 4]);
        let triangle = gemm([3, 3, 4], [3, 3, 3]).cblas_triangle(101, 122, 112, 111).unwrap();
        assert_eq!((triangle.sides(), triangle.triangle), ([3, 3, 4], Some(Uplo::Upper)));
        let request = syrk(3, 2, 2, 3).cblas(101, 121, 111).unwrap();
        assert_eq!((request.sides(), request.triangle), ([3, 3, 2], Some(Uplo::Lower)));
    }
}
