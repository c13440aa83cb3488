//! A library that has some routines of BLAS, of which each writes a number of its own to the first
//! element of C.

#![allow(missing_docs, clippy::missing_safety_doc)]

use std::ffi::c_void;

type P = *const c_void;

#[no_mangle]
pub unsafe extern "C" fn dsyrk_(_: P, _: P, _: P, _: P, _: P, _: P, _: P, _: P, c: *mut f64, _: P) {
    *c = 1.0;
}

#[no_mangle]
pub unsafe extern "C" fn cblas_dsyrk64_(
    _: i32, _: i32, _: i32, _: i64, _: i64, _: f64, _: P, _: i64, _: f64, c: *mut f64, _: i64,
) {
    *c = 2.0;
}

#[no_mangle]
pub unsafe extern "C" fn cblas_dgemm(
    _: i32, _: i32, _: i32, _: i32, _: i32, _: i32, _: f64, _: P, _: i32, _: P, _: i32, _: f64,
    c: *mut f64, ldc: i32,
) {
    *c = 3000.0 + f64::from(ldc);
}

#[no_mangle]
pub unsafe extern "C" fn dgemmt_(
    _: P, _: P, _: P, _: P, _: P, _: P, _: P, _: P, _: P, _: P, _: P, c: *mut f64, _: P,
    uplo: usize, _: usize, last: usize,
) {
    *c = 40.0 + (uplo + last) as f64;
}
