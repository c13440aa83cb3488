//! The exported functions: each routine in every spelling that programs use.
//!
//! | spelling | integers | used by |
//! |---|---|---|
//! | `dsyrk_`, `cblas_dsyrk` | 32 bits | most programs |
//! | `dsyrk_64_`, `cblas_dsyrk64_` | 64 bits | OpenBLAS with a suffix, as in Julia |
//! | `dsyrk_64`, `cblas_dsyrk_64` | 64 bits | MKL, reference CBLAS 3.12 |
//! | `scipy_dsyrk_`, `scipy_cblas_dsyrk` | 32 bits | wheels of scipy |
//! | `scipy_dsyrk_64_`, `scipy_cblas_dsyrk64_` | 64 bits | wheels of numpy |
//!
//! Functions of Fortran take the lengths of their letters after all other arguments. Callers
//! written in C leave these out; whatever is in their place is passed on, as by a jump.

use std::ffi::CStr;
use std::mem::transmute;

use catamaran::faer::{c32, c64};

use crate::arguments::{Gemm, Syrk};
use crate::dispatch;
use crate::entry::Entry;
use crate::host::Code;
use crate::policy::is_small;

/// Returns the C string of a literal that ends with NUL.
const fn c_str(text: &'static str) -> &'static CStr {
    match CStr::from_bytes_with_nul(text.as_bytes()) {
        Ok(text) => text,
        Err(_) => panic!("no NUL at the end"),
    }
}

/// Defines an exported function. It calls the next library at once when the sides are small, else
/// `dispatch::call` with the request.
macro_rules! export {
    (
        $name:expr, $scalar:ty,
        ($($argument:ident: $type:ty),* $(,)?),
        sides: $sides:expr,
        request: $request:expr $(,)?
    ) => {
        const _: () = {
            type Symbol = unsafe extern "C" fn($($type),*);
            static ENTRY: Entry = Entry::new(c_str(concat!($name, "\0")));

            #[unsafe(export_name = $name)]
            unsafe extern "C" fn symbol($($argument: $type),*) {
                // SAFETY: arguments of BLAS; the next library has the same symbol, of this type.
                unsafe {
                    let [m, n, k]: [i64; 3] = $sides;
                    let quick = if is_small(m, n, k) { ENTRY.quick() } else { None };
                    let f = quick.map_or(look as Symbol, |next| transmute::<Code, Symbol>(next));
                    f($($argument),*)
                }
            }

            // A function of its own, so that the one above is some comparisons and a jump.
            #[inline(never)]
            unsafe extern "C" fn look($($argument: $type),*) {
                // SAFETY: the arguments are those that the caller of BLAS passed to the symbol, of
                // which the request says how many elements they point to; `next` is the same
                // symbol, of this type.
                unsafe {
                    dispatch::call::<$scalar>(&ENTRY, $request, &|next| {
                        transmute::<Code, Symbol>(next)($($argument),*)
                    });
                }
            }
        };
    };
}

macro_rules! fortran_syrk {
    ($t:ty, $int:ty, $name:expr) => {
        fortran_syrk! { $t, $t, $int, $name }
    };
    ($s:ty, $t:ty, $int:ty, $name:expr) => {
        export! {
            $name, $t,
            (
                uplo: *const u8, trans: *const u8, n: *const $int, k: *const $int,
                alpha: *const $s, a: *const $t, lda: *const $int,
                beta: *const $s, c: *mut $t, ldc: *const $int,
                uplo_len: usize, trans_len: usize,
            ),
            sides: [(*n).into(), (*n).into(), (*k).into()],
            request: Syrk {
                n: *n, k: *k, alpha: *alpha, a, lda: *lda, beta: *beta, c, ldc: *ldc,
            }.fortran(*uplo, *trans),
        }
    };
}

macro_rules! cblas_syrk {
    ($t:ty, $int:ty, $name:expr) => {
        cblas_syrk! { $t, $t, $int, $name }
    };
    ($s:ty, $t:ty, $int:ty, $name:expr) => {
        export! {
            $name, $t,
            (
                order: i32, uplo: i32, trans: i32, n: $int, k: $int,
                alpha: $s, a: *const $t, lda: $int, beta: $s, c: *mut $t, ldc: $int,
            ),
            sides: [n.into(), n.into(), k.into()],
            request: Syrk { n, k, alpha, a, lda, beta, c, ldc }.cblas(order, uplo, trans),
        }
    };
}

macro_rules! fortran_gemm {
    ($t:ty, $int:ty, $name:expr) => {
        export! {
            $name, $t,
            (
                trans_a: *const u8, trans_b: *const u8,
                m: *const $int, n: *const $int, k: *const $int,
                alpha: *const $t, a: *const $t, lda: *const $int, b: *const $t, ldb: *const $int,
                beta: *const $t, c: *mut $t, ldc: *const $int,
                trans_a_len: usize, trans_b_len: usize,
            ),
            sides: [(*m).into(), (*n).into(), (*k).into()],
            request: Gemm {
                m: *m, n: *n, k: *k, alpha: *alpha, a, lda: *lda, b, ldb: *ldb,
                beta: *beta, c, ldc: *ldc,
            }.fortran(*trans_a, *trans_b),
        }
    };
}

macro_rules! cblas_gemm {
    ($t:ty, $int:ty, $name:expr) => {
        export! {
            $name, $t,
            (
                order: i32, trans_a: i32, trans_b: i32, m: $int, n: $int, k: $int,
                alpha: $t, a: *const $t, lda: $int, b: *const $t, ldb: $int,
                beta: $t, c: *mut $t, ldc: $int,
            ),
            sides: [m.into(), n.into(), k.into()],
            request: Gemm { m, n, k, alpha, a, lda, b, ldb, beta, c, ldc }
                .cblas(order, trans_a, trans_b),
        }
    };
}

// Complex scalars are passed by address.
macro_rules! cblas_complex_gemm {
    ($t:ty, $int:ty, $name:expr) => {
        export! {
            $name, $t,
            (
                order: i32, trans_a: i32, trans_b: i32, m: $int, n: $int, k: $int,
                alpha: *const $t, a: *const $t, lda: $int, b: *const $t, ldb: $int,
                beta: *const $t, c: *mut $t, ldc: $int,
            ),
            sides: [m.into(), n.into(), k.into()],
            request: Gemm { m, n, k, alpha: *alpha, a, lda, b, ldb, beta: *beta, c, ldc }
                .cblas(order, trans_a, trans_b),
        }
    };
}

macro_rules! fortran_herk {
    (c32, $int:ty, $name:expr) => {
        fortran_syrk! { f32, c32, $int, $name }
    };
    (c64, $int:ty, $name:expr) => {
        fortran_syrk! { f64, c64, $int, $name }
    };
}

macro_rules! cblas_herk {
    (c32, $int:ty, $name:expr) => {
        cblas_syrk! { f32, c32, $int, $name }
    };
    (c64, $int:ty, $name:expr) => {
        cblas_syrk! { f64, c64, $int, $name }
    };
}

macro_rules! fortran_gemmt {
    ($t:ty, $int:ty, $name:expr) => {
        export! {
            $name, $t,
            (
                uplo: *const u8, trans_a: *const u8, trans_b: *const u8,
                n: *const $int, k: *const $int,
                alpha: *const $t, a: *const $t, lda: *const $int, b: *const $t, ldb: *const $int,
                beta: *const $t, c: *mut $t, ldc: *const $int,
                uplo_len: usize, trans_a_len: usize, trans_b_len: usize,
            ),
            sides: [(*n).into(), (*n).into(), (*k).into()],
            request: Gemm {
                m: *n, n: *n, k: *k, alpha: *alpha, a, lda: *lda, b, ldb: *ldb,
                beta: *beta, c, ldc: *ldc,
            }.fortran_triangle(*uplo, *trans_a, *trans_b),
        }
    };
}

macro_rules! cblas_gemmt {
    ($t:ty, $int:ty, $name:expr) => {
        export! {
            $name, $t,
            (
                order: i32, uplo: i32, trans_a: i32, trans_b: i32, n: $int, k: $int,
                alpha: $t, a: *const $t, lda: $int, b: *const $t, ldb: $int,
                beta: $t, c: *mut $t, ldc: $int,
            ),
            sides: [n.into(), n.into(), k.into()],
            request: Gemm { m: n, n, k, alpha, a, lda, b, ldb, beta, c, ldc }
                .cblas_triangle(order, uplo, trans_a, trans_b),
        }
    };
}

/// Defines a routine in every spelling.
macro_rules! routine {
    ($fortran:ident, $cblas:ident, $t:tt, $name:literal) => {
        $fortran!($t, i32, concat!($name, "_"));
        $fortran!($t, i32, concat!("scipy_", $name, "_"));
        $fortran!($t, i64, concat!($name, "_64_"));
        $fortran!($t, i64, concat!($name, "_64"));
        $fortran!($t, i64, concat!("scipy_", $name, "_64_"));
        $cblas!($t, i32, concat!("cblas_", $name));
        $cblas!($t, i32, concat!("scipy_cblas_", $name));
        $cblas!($t, i64, concat!("cblas_", $name, "64_"));
        $cblas!($t, i64, concat!("cblas_", $name, "_64"));
        $cblas!($t, i64, concat!("scipy_cblas_", $name, "64_"));
    };
}

routine!(fortran_syrk, cblas_syrk, f32, "ssyrk");
routine!(fortran_syrk, cblas_syrk, f64, "dsyrk");
routine!(fortran_gemm, cblas_gemm, f32, "sgemm");
routine!(fortran_gemm, cblas_gemm, f64, "dgemm");
routine!(fortran_gemm, cblas_complex_gemm, c32, "cgemm");
routine!(fortran_gemm, cblas_complex_gemm, c64, "zgemm");
routine!(fortran_herk, cblas_herk, c32, "cherk");
routine!(fortran_herk, cblas_herk, c64, "zherk");
routine!(fortran_gemmt, cblas_gemmt, f32, "sgemmt");
routine!(fortran_gemmt, cblas_gemmt, f64, "dgemmt");
// The same by the name of the reference implementation, from LAPACK 3.12.1 on.
routine!(fortran_gemmt, cblas_gemmt, f32, "sgemmtr");
routine!(fortran_gemmt, cblas_gemmt, f64, "dgemmtr");
