//! Calls of the exported functions by their names.

use std::ffi::{CString, c_void};

use super::oracle::{Matrix, Part, Scalar};

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

/// All of them.
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

/// The address of a symbol, as a program that links with it gets it.
pub fn symbol(name: &str) -> *mut c_void {
    let text = CString::new(name).unwrap();
    // SAFETY: a string that ends.
    let address = unsafe { libc::dlsym(libc::RTLD_DEFAULT, text.as_ptr()) };
    assert!(!address.is_null(), "no symbol {name}");
    address
}

const TRANS: [u8; 2] = [b'N', b't'];
const NUMBER_TRANS: [i32; 2] = [111, 112];

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

/// `C := alpha op(A) op(A)^T + beta C`, the triangle `part`.
pub fn syrk<T: Scalar>(
    spelling: Spelling,
    part: Part,
    (a, trans): (&Matrix<T>, bool),
    [alpha, beta]: [f64; 2],
    c: &mut Matrix<T>,
) {
    let Spelling { prefix, suffix, convention, wide } = spelling;
    let f = symbol(&format!("{prefix}{}syrk{suffix}", T::NAME));
    let (n, k) = if trans { (a.cols, a.rows) } else { (a.rows, a.cols) };
    let (alpha, beta) = (T::of(alpha), T::of(beta));
    with_integer!(wide, Int, {
        let [n, k, lda, ldc] = [n, k, a.leading, c.leading].map(|x| x as Int);
        // SAFETY: the signatures of BLAS; the matrices have the sides and leading dimensions named.
        unsafe {
            match convention {
                Convention::Fortran => {
                    type F<T, I> = unsafe extern "C" fn(
                        *const u8,
                        *const u8,
                        *const I,
                        *const I,
                        *const T,
                        *const T,
                        *const I,
                        *const T,
                        *mut T,
                        *const I,
                    );
                    let f = std::mem::transmute::<*mut c_void, F<T, Int>>(f);
                    let (uplo, trans) = (letter(part), TRANS[usize::from(trans)]);
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
                    type F<T, I> =
                        unsafe extern "C" fn(i32, i32, i32, I, I, T, *const T, I, T, *mut T, I);
                    let f = std::mem::transmute::<*mut c_void, F<T, Int>>(f);
                    f(
                        order(c.by_rows),
                        number(part),
                        NUMBER_TRANS[usize::from(trans)],
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

/// `C := alpha op(A) op(B) + beta C`, all of it by `gemm`, or a triangle by the routine `triangle`.
pub fn gemm<T: Scalar>(
    spelling: Spelling,
    (part, triangle): (Part, &str),
    [(a, trans_a), (b, trans_b)]: [(&Matrix<T>, bool); 2],
    [alpha, beta]: [f64; 2],
    c: &mut Matrix<T>,
) {
    let Spelling { prefix, suffix, convention, wide } = spelling;
    let routine = if part == Part::All { "gemm" } else { triangle };
    let f = symbol(&format!("{prefix}{}{routine}{suffix}", T::NAME));
    let k = if trans_a { a.rows } else { a.cols };
    let (alpha, beta) = (T::of(alpha), T::of(beta));
    let (ta, tb) = (usize::from(trans_a), usize::from(trans_b));
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
                    f(
                        &TRANS[ta], &TRANS[tb], &m, &n, &k, &alpha, pa, &lda, pb, &ldb, &beta, pc,
                        &ldc, 1, 1,
                    );
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
                        &uplo, &TRANS[ta], &TRANS[tb], &n, &k, &alpha, pa, &lda, pb, &ldb, &beta,
                        pc, &ldc, 1, 1, 1,
                    );
                }
                Convention::Cblas => {
                    let order = order(c.by_rows);
                    let (ta, tb) = (NUMBER_TRANS[ta], NUMBER_TRANS[tb]);
                    if part == Part::All {
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
