//! The back ends against the definition, and what is refused as one.

use std::path::Path;

use catamaran::Error;
use catamaran::blas::{self, Backend, BlasReal, Kernels};
use catamaran::faer::{Mat, MatRef};

use crate::common::{AWKWARD, backends, integers, oracle};

fn check<T: BlasReal>(backend: &dyn Backend, a: MatRef<'_, T>, b: MatRef<'_, T>) {
    let kernels: &dyn Kernels<T> = T::kernels(backend);
    let (n, k) = (a.ncols(), b.ncols());
    for (alpha, beta) in [(1.0, 0.0), (-2.0, 3.0)] {
        let (al, be) = (T::from_f64(alpha), T::from_f64(beta));
        let start = integers::<T>(n, k, 3);
        // With beta == 0 C may hold anything.
        let start =
            Mat::from_fn(
                n,
                k,
                |i, j| {
                    if beta == 0.0 { T::from_f64(f64::NAN) } else { start[(i, j)] }
                },
            );
        let mut c = start.clone();
        kernels.gemm(al, a, b, be, c.as_mut());
        let expected = oracle(alpha, a, None, b, beta, start.as_ref());
        assert_eq!(Mat::from_fn(n, k, |i, j| c[(i, j)].to_f64()), expected, "{}", backend.name());
        if n != k {
            continue;
        }
        for square in [false, true] {
            let right = if square { a } else { b };
            let upper_poisoned = |i, j| if i < j { T::from_f64(f64::NAN) } else { start[(i, j)] };
            let mut c = Mat::from_fn(n, n, upper_poisoned);
            if square {
                kernels.syrk(al, a, be, c.as_mut());
            } else {
                kernels.gemmt(al, a, b, be, c.as_mut());
            }
            let expected = oracle(alpha, a, None, right, beta, start.as_ref());
            for j in 0..n {
                for i in 0..n {
                    let got = c[(i, j)].to_f64();
                    if i >= j {
                        assert_eq!(got, expected[(i, j)], "{} ({i}, {j})", backend.name());
                    } else {
                        assert!(got.is_nan(), "{}: the upper triangle was written", backend.name());
                    }
                }
            }
        }
    }
}

#[test]
fn every_backend_is_exact_on_integers_of_awkward_sizes() {
    for backend in backends() {
        for m in AWKWARD {
            for n in AWKWARD {
                check(
                    backend.as_ref(),
                    integers::<f64>(m, n, 1).as_ref(),
                    integers(m, n, 2).as_ref(),
                );
            }
        }
        check(
            backend.as_ref(),
            integers::<f32>(50, 201, 1).as_ref(),
            integers(50, 201, 2).as_ref(),
        );
    }
}

#[test]
fn every_backend_takes_any_layout_of_its_operands() {
    let (a, b) = (integers::<f64>(40, 90, 4), integers::<f64>(90, 40, 5));
    for backend in backends() {
        // Row-major against column-major, parts of larger matrices, reversed lines.
        check(backend.as_ref(), a.as_ref(), b.transpose());
        check(backend.as_ref(), b.transpose(), a.as_ref());
        check(
            backend.as_ref(),
            a.as_ref().submatrix(1, 2, 33, 20),
            a.as_ref().submatrix(3, 40, 33, 20),
        );
        check(backend.as_ref(), a.as_ref().reverse_rows(), a.as_ref().reverse_cols());
    }
}

#[test]
fn a_library_that_is_none_is_refused_with_its_name() {
    let refused = |path: &str| match blas::load(Path::new(path)) {
        Err(Error::Backend { name, why, .. }) => (name, why),
        _ => panic!("{path} was taken for a BLAS"),
    };
    let (name, why) = refused("/nowhere/libnone.so");
    assert_eq!(name, "libnone.so");
    assert!(why.contains("/nowhere/libnone.so"), "{why}");
    #[cfg(target_os = "linux")]
    assert!(refused("libm.so.6").1.contains("cblas_dgemm"));
}

#[cfg(feature = "openblas")]
#[test]
fn threads_held_by_overlapping_calls_are_put_back_after_the_last() {
    unsafe extern "C" {
        fn openblas_get_num_threads() -> i32;
        fn openblas_set_num_threads(n: i32);
    }
    let backend = blas::openblas();
    // SAFETY: the documented functions of OpenBLAS.
    let threads = || unsafe { openblas_get_num_threads() };
    // SAFETY: a documented function of OpenBLAS, which takes any count.
    unsafe { openblas_set_num_threads(2) };
    let before = threads();
    let first = backend.single_threaded();
    let second = backend.single_threaded();
    assert_eq!(threads(), 1);
    drop(first);
    assert_eq!(threads(), 1);
    drop(second);
    assert_eq!(threads(), before);
}
