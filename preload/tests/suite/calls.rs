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
    let op = match (trans, T::IS_COMPLEX) {
        (false, _) => Trans::No,
        (true, false) => Trans::Transposed,
        (true, true) => Trans::Conjugated,
    };
    let (n, k) = if trans { (a.cols, a.rows) } else { (a.rows, a.cols) };
    let (alpha, beta) = (T::real(alpha), T::real(beta));
    with_integer!(wide, Int, {
        let [n, k, lda, ldc] = [n, k, a.leading, c.leading].map(|x| x as Int);
        // SAFETY: the signatures of BLAS; the matrices have the sides and leading dimensions named.
        unsafe {
            match convention {
                Convention::Fortran => {
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
                    let f = std::mem::transmute::<*mut c_void, F<T::Real, T, Int>>(f);
                    let (uplo, trans) = (letter(part), letter_trans(op));
                    f(
                        &uplo,
                        &trans,
                        &n,
                        &k,
                        &alpha,
                        a.data.as_ptr(),
                        &lda,
                        &beta,
                        c.data.as_mut_ptr(),
                        &ldc,
                    );
                }
                Convention::Cblas => {
                    type F<S, T, I> =
                        unsafe extern "C" fn(i32, i32, i32, I, I, S, *const T, I, S, *mut T, I);
                    let f = std::mem::transmute::<*mut c_void, F<T::Real, T, Int>>(f);
                    f(
                        order(c.by_rows),
                        number(part),
                        number_trans(op),
                        n,
                        k,
                        alpha,
                        a.data.as_ptr(),
                        lda,
                        beta,
                        c.data.as_mut_ptr(),
                        ldc,
                    );
                }
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
    let [alpha, beta] = [alpha, beta].map(|x| T::of(T::factor(x)));
    let (ta, tb) = (letter_trans(trans_a), letter_trans(trans_b));
    let (pa, pb, pc) = (a.data.as_ptr(), b.data.as_ptr(), c.data.as_mut_ptr());
    with_integer!(wide, Int, {
        let sides = [c.rows, c.cols, k, a.leading, b.leading, c.leading];
        let [m, n, k, lda, ldb, ldc] = sides.map(|x| x as Int);
        // SAFETY: as in `syrk`.
        unsafe {
            match convention {
                Convention::Fortran if part == Part::All => {
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
                    let f = std::mem::transmute::<*mut c_void, F<T, Int>>(f);
                    f(&ta, &tb, &m, &n, &k, &alpha, pa, &lda, pb, &ldb, &beta, pc, &ldc, 1, 1);
                }
                Convention::Fortran => {
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
                    let f = std::mem::transmute::<*mut c_void, F<T, Int>>(f);
                    let uplo = letter(part);
                    f(
                        &uplo, &ta, &tb, &n, &k, &alpha, pa, &lda, pb, &ldb, &beta, pc, &ldc, 1, 1,
                        1,
                    );
                }
                Convention::Cblas => {
                    let order = order(c.by_rows);
                    let (ta, tb) = (number_trans(trans_a), number_trans(trans_b));
                    if T::IS_COMPLEX {
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
                        let f = std::mem::transmute::<*mut c_void, F<T, Int>>(f);
                        f(order, ta, tb, m, n, k, &alpha, pa, lda, pb, ldb, &beta, pc, ldc);
                    } else if part == Part::All {
                        type F<T, I> = unsafe extern "C" fn(
                            i32,
                            i32,
                            i32,
                            I,
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
                        let f = std::mem::transmute::<*mut c_void, F<T, Int>>(f);
                        f(order, ta, tb, m, n, k, alpha, pa, lda, pb, ldb, beta, pc, ldc);
                    } else {
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
                        let f = std::mem::transmute::<*mut c_void, F<T, Int>>(f);
                        let uplo = number(part);
                        f(order, uplo, ta, tb, n, k, alpha, pa, lda, pb, ldb, beta, pc, ldc);
                    }
                }
            }
        }
    });
}
