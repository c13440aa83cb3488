//! Calls of the exported functions by their names.

use std::ffi::{CString, c_void};

use super::oracle::{Matrix, Part, Scalar, Trans};

/// How a function takes its arguments.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Convention {
    Fortran,
    Cblas,
}

/// A spelling of all routines.
#[derive(Debug, Clone, Copy)]
pub struct Spelling {
    pub prefix: &'static str,
    pub suffix: &'static str,
    pub convention: Convention,
    pub wide: bool,
}

const fn spelling(
    prefix: &'static str,
    suffix: &'static str,
    convention: Convention,
    wide: bool,
) -> Spelling {
    Spelling { prefix, suffix, convention, wide }
}

/// All spellings.
pub const SPELLINGS: [Spelling; 10] = [
    spelling("", "_", Convention::Fortran, false),
    spelling("scipy_", "_", Convention::Fortran, false),
    spelling("", "_64_", Convention::Fortran, true),
    spelling("", "_64", Convention::Fortran, true),
    spelling("scipy_", "_64_", Convention::Fortran, true),
    spelling("cblas_", "", Convention::Cblas, false),
    spelling("scipy_cblas_", "", Convention::Cblas, false),
    spelling("cblas_", "64_", Convention::Cblas, true),
    spelling("cblas_", "_64", Convention::Cblas, true),
    spelling("scipy_cblas_", "64_", Convention::Cblas, true),
];

/// Returns the address of a symbol, as a program that links with it gets it.
pub fn symbol(name: &str) -> *mut c_void {
    let text = CString::new(name).unwrap();
    // SAFETY: a string that ends.
    let address = unsafe { libc::dlsym(libc::RTLD_DEFAULT, text.as_ptr()) };
    assert!(!address.is_null(), "no symbol {name}");
    address
}

fn letter_trans(trans: Trans) -> u8 {
    match trans {
        Trans::No => b'N',
        Trans::Transposed => b't',
        Trans::Conjugated => b'C',
    }
}

fn number_trans(trans: Trans) -> i32 {
    match trans {
        Trans::No => 111,
        Trans::Transposed => 112,
        Trans::Conjugated => 113,
    }
}

fn letter(part: Part) -> u8 {
    if part == Part::Lower { b'l' } else { b'U' }
}

fn number(part: Part) -> i32 {
    if part == Part::Lower { 122 } else { 121 }
}

fn order(by_rows: bool) -> i32 {
    if by_rows { 101 } else { 102 }
}

macro_rules! with_integer {
    ($wide:expr, $int:ident, $body:block) => {
        if $wide {
            type $int = i64;
            $body
        } else {
            type $int = i32;
            $body
        }
    };
}

/// Computes `C := alpha op(A) op(A)^T + beta C`, the triangle `part`; with the conjugate transpose
/// where elements are complex.
pub fn syrk<T: Scalar>(
    spelling: Spelling,
    part: Part,
    (a, trans): (&Matrix<T>, bool),
    [alpha, beta]: [f64; 2],
    c: &mut Matrix<T>,
) {
    let Spelling { prefix, suffix, convention, wide } = spelling;
    let routine = if T::IS_COMPLEX { "herk" } else { "syrk" };
    let f = symbol(&format!("{prefix}{}{routine}{suffix}", T::NAME));
    let trans_a = match (trans, T::IS_COMPLEX) {
        (false, _) => Trans::No,
        (true, false) => Trans::Transposed,
        (true, true) => Trans::Conjugated,
    };
    let sides = if trans { [a.cols, a.rows] } else { [a.rows, a.cols] };
    with_integer!(wide, Int, {
        let call = Syrk {
            part,
            trans: trans_a,
            by_rows: c.by_rows,
            sides: sides.map(|x| x as Int),
            factors: [alpha, beta].map(T::real),
            a: Operand { data: a.data.as_ptr(), leading: a.leading as Int },
            c: Target { data: c.data.as_mut_ptr(), leading: c.leading as Int },
        };
        // SAFETY: the signatures of BLAS; the matrices have the sides and leading dimensions named.
        unsafe {
            match convention {
                Convention::Fortran => call.fortran(f),
                Convention::Cblas => call.cblas(f),
            }
        }
    });
}

/// Computes `C := alpha op(A) op(B) + beta C`, all of it by `gemm`, or a triangle by `triangle`.
pub fn gemm<T: Scalar, O: Into<Trans> + Copy>(
    spelling: Spelling,
    (part, triangle): (Part, &str),
    sides: [(&Matrix<T>, O); 2],
    [alpha, beta]: [f64; 2],
    c: &mut Matrix<T>,
) {
    let Spelling { prefix, suffix, convention, wide } = spelling;
    let routine = if part == Part::All { "gemm" } else { triangle };
    let f = symbol(&format!("{prefix}{}{routine}{suffix}", T::NAME));
    let [(a, trans_a), (b, trans_b)] = sides.map(|(matrix, trans)| (matrix, trans.into()));
    let k = if trans_a.transposes() { a.rows } else { a.cols };
    with_integer!(wide, Int, {
        let call = Gemm {
            part,
            trans: [trans_a, trans_b],
            by_rows: c.by_rows,
            sides: [c.rows, c.cols, k].map(|x| x as Int),
            factors: [alpha, beta].map(|x| T::of(T::factor(x))),
            a: Operand { data: a.data.as_ptr(), leading: a.leading as Int },
            b: Operand { data: b.data.as_ptr(), leading: b.leading as Int },
            c: Target { data: c.data.as_mut_ptr(), leading: c.leading as Int },
        };
        // SAFETY: as in `syrk`.
        unsafe {
            match convention {
                Convention::Fortran if part == Part::All => call.fortran(f),
                Convention::Fortran => call.fortran_triangle(f),
                Convention::Cblas if T::IS_COMPLEX => call.cblas_complex(f),
                Convention::Cblas if part == Part::All => call.cblas(f),
                Convention::Cblas => call.cblas_triangle(f),
            }
        }
    });
}

/// A matrix that a routine reads.
struct Operand<T, I> {
    data: *const T,
    leading: I,
}

/// A matrix that a routine writes.
struct Target<T, I> {
    data: *mut T,
    leading: I,
}

/// The arguments of `syrk` or `herk`, with integers of type `I`.
struct Syrk<T: Scalar, I> {
    part: Part,
    trans: Trans,
    by_rows: bool,
    /// n and k.
    sides: [I; 2],
    /// alpha and beta.
    factors: [T::Real; 2],
    a: Operand<T, I>,
    c: Target<T, I>,
}

impl<T: Scalar, I: Copy> Syrk<T, I> {
    /// # Safety
    /// `f` is the routine of Fortran for `T` and `I`, and the matrices have their sides.
    unsafe fn fortran(&self, f: *mut c_void) {
        type F<S, T, I> = unsafe extern "C" fn(
            *const u8,
            *const u8,
            *const I,
            *const I,
            *const S,
            *const T,
            *const I,
            *const S,
            *mut T,
            *const I,
        );
        let Self { sides: [n, k], factors: [alpha, beta], a, c, .. } = self;
        let (uplo, trans) = (letter(self.part), letter_trans(self.trans));
        // SAFETY: `f` is the routine of this type, and the sides are those of the matrices.
        unsafe {
            let f = std::mem::transmute::<*mut c_void, F<T::Real, T, I>>(f);
            f(&uplo, &trans, n, k, alpha, a.data, &a.leading, beta, c.data, &c.leading);
        }
    }

    /// # Safety
    /// `f` is the routine of CBLAS for `T` and `I`, and the matrices have their sides.
    unsafe fn cblas(&self, f: *mut c_void) {
        type F<S, T, I> = unsafe extern "C" fn(i32, i32, i32, I, I, S, *const T, I, S, *mut T, I);
        let Self { sides: [n, k], factors: [alpha, beta], ref a, ref c, .. } = *self;
        let (order, uplo) = (order(self.by_rows), number(self.part));
        let trans = number_trans(self.trans);
        // SAFETY: `f` is the routine of this type, and the sides are those of the matrices.
        unsafe {
            let f = std::mem::transmute::<*mut c_void, F<T::Real, T, I>>(f);
            f(order, uplo, trans, n, k, alpha, a.data, a.leading, beta, c.data, c.leading);
        }
    }
}

/// The arguments of `gemm` or of a product of which a triangle is computed, with integers of type
/// `I`.
struct Gemm<T, I> {
    part: Part,
    /// Of A and B.
    trans: [Trans; 2],
    by_rows: bool,
    /// m, n and k.
    sides: [I; 3],
    /// alpha and beta.
    factors: [T; 2],
    a: Operand<T, I>,
    b: Operand<T, I>,
    c: Target<T, I>,
}

impl<T: Scalar, I: Copy> Gemm<T, I> {
    /// # Safety
    /// `f` is the routine of Fortran for `T` and `I`, and the matrices have their sides.
    unsafe fn fortran(&self, f: *mut c_void) {
        type F<T, I> = unsafe extern "C" fn(
            *const u8,
            *const u8,
            *const I,
            *const I,
            *const I,
            *const T,
            *const T,
            *const I,
            *const T,
            *const I,
            *const T,
            *mut T,
            *const I,
            usize,
            usize,
        );
        let Self { sides: [m, n, k], factors: [alpha, beta], a, b, c, .. } = self;
        let (lda, ldb, ldc) = (&a.leading, &b.leading, &c.leading);
        let [ta, tb] = self.trans.map(letter_trans);
        // SAFETY: `f` is the routine of this type, and the sides are those of the matrices.
        unsafe {
            let f = std::mem::transmute::<*mut c_void, F<T, I>>(f);
            f(&ta, &tb, m, n, k, alpha, a.data, lda, b.data, ldb, beta, c.data, ldc, 1, 1);
        }
    }

    /// # Safety
    /// `f` is the routine of Fortran for a triangle, `T` and `I`, and the matrices have their
    /// sides.
    unsafe fn fortran_triangle(&self, f: *mut c_void) {
        type F<T, I> = unsafe extern "C" fn(
            *const u8,
            *const u8,
            *const u8,
            *const I,
            *const I,
            *const T,
            *const T,
            *const I,
            *const T,
            *const I,
            *const T,
            *mut T,
            *const I,
            usize,
            usize,
            usize,
        );
        let Self { sides: [_, n, k], factors: [alpha, beta], a, b, c, .. } = self;
        let (lda, ldb, ldc) = (&a.leading, &b.leading, &c.leading);
        let (uplo, [ta, tb]) = (letter(self.part), self.trans.map(letter_trans));
        // SAFETY: `f` is the routine of this type, and the sides are those of the matrices.
        unsafe {
            let f = std::mem::transmute::<*mut c_void, F<T, I>>(f);
            f(&uplo, &ta, &tb, n, k, alpha, a.data, lda, b.data, ldb, beta, c.data, ldc, 1, 1, 1);
        }
    }

    /// # Safety
    /// `f` is the routine of CBLAS for the complex type `T` and `I`, and the matrices have their
    /// sides.
    unsafe fn cblas_complex(&self, f: *mut c_void) {
        type F<T, I> = unsafe extern "C" fn(
            i32,
            i32,
            i32,
            I,
            I,
            I,
            *const T,
            *const T,
            I,
            *const T,
            I,
            *const T,
            *mut T,
            I,
        );
        let Self { sides: [m, n, k], factors: [alpha, beta], a, b, c, .. } = self;
        let (lda, ldb, ldc) = (a.leading, b.leading, c.leading);
        let (order, [ta, tb]) = (order(self.by_rows), self.trans.map(number_trans));
        // SAFETY: `f` is the routine of this type, and the sides are those of the matrices.
        unsafe {
            let f = std::mem::transmute::<*mut c_void, F<T, I>>(f);
            f(order, ta, tb, *m, *n, *k, alpha, a.data, lda, b.data, ldb, beta, c.data, ldc);
        }
    }

    /// # Safety
    /// `f` is the routine of CBLAS for the real type `T` and `I`, and the matrices have their
    /// sides.
    unsafe fn cblas(&self, f: *mut c_void) {
        type F<T, I> =
            unsafe extern "C" fn(i32, i32, i32, I, I, I, T, *const T, I, *const T, I, T, *mut T, I);
        let Self { sides: [m, n, k], factors: [alpha, beta], a, b, c, .. } = self;
        let (lda, ldb, ldc) = (a.leading, b.leading, c.leading);
        let (order, [ta, tb]) = (order(self.by_rows), self.trans.map(number_trans));
        // SAFETY: `f` is the routine of this type, and the sides are those of the matrices.
        unsafe {
            let f = std::mem::transmute::<*mut c_void, F<T, I>>(f);
            f(order, ta, tb, *m, *n, *k, *alpha, a.data, lda, b.data, ldb, *beta, c.data, ldc);
        }
    }

    /// # Safety
    /// `f` is the routine of CBLAS for a triangle, the real type `T` and `I`, and the matrices
    /// have their sides.
    unsafe fn cblas_triangle(&self, f: *mut c_void) {
        type F<T, I> = unsafe extern "C" fn(
            i32,
            i32,
            i32,
            i32,
            I,
            I,
            T,
            *const T,
            I,
            *const T,
            I,
            T,
            *mut T,
            I,
        );
        let Self { sides: [_, n, k], factors: [alpha, beta], a, b, c, .. } = self;
        let (lda, ldb, ldc) = (a.leading, b.leading, c.leading);
        let (order, uplo) = (order(self.by_rows), number(self.part));
        let [ta, tb] = self.trans.map(number_trans);
        // SAFETY: `f` is the routine of this type, and the sides are those of the matrices.
        unsafe {
            let f = std::mem::transmute::<*mut c_void, F<T, I>>(f);
            f(order, uplo, ta, tb, *n, *k, *alpha, a.data, lda, b.data, ldb, *beta, c.data, ldc);
        }
    }
}
