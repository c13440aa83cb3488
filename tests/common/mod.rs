//! What the integration tests of the products share: back ends, and the inputs of all crates.
#![allow(dead_code)] // each test file uses a part

mod inputs;

use std::sync::Arc;

use catamaran::blas::{self, Backend, BlasReal, Kernels, Rates};
use catamaran::faer::prelude::ReborrowMut;
use catamaran::faer::{MatMut, MatRef};

#[allow(unused_imports)]
pub use inputs::{AWKWARD, bits, data, gaussian, integers, oracle};

/// A back end by the definition: no blocking, no memory of its own.
pub struct Naive;

impl<T: BlasReal> Kernels<T> for Naive {
    fn gemm(&self, alpha: T, a: MatRef<'_, T>, b: MatRef<'_, T>, beta: T, mut c: MatMut<'_, T>) {
        for j in 0..c.ncols() {
            for i in 0..c.nrows() {
                entry(alpha, a, b, beta, c.rb_mut(), i, j);
            }
        }
    }

    fn syrk(&self, alpha: T, a: MatRef<'_, T>, beta: T, c: MatMut<'_, T>) {
        self.gemmt(alpha, a, a, beta, c);
    }

    fn gemmt(&self, alpha: T, a: MatRef<'_, T>, b: MatRef<'_, T>, beta: T, mut c: MatMut<'_, T>) {
        assert_eq!(c.nrows(), c.ncols());
        for j in 0..c.ncols() {
            for i in j..c.nrows() {
                entry(alpha, a, b, beta, c.rb_mut(), i, j);
            }
        }
    }
}

fn entry<T: BlasReal>(
    alpha: T,
    a: MatRef<'_, T>,
    b: MatRef<'_, T>,
    beta: T,
    mut c: MatMut<'_, T>,
    i: usize,
    j: usize,
) {
    assert_eq!((a.nrows(), a.ncols(), b.ncols()), (b.nrows(), c.nrows(), c.ncols()));
    let mut sum = T::ZERO;
    for r in 0..a.nrows() {
        sum += a[(r, i)] * b[(r, j)];
    }
    let old = if beta == T::ZERO { T::ZERO } else { beta * c[(i, j)] };
    c[(i, j)] = alpha * sum + old;
}

impl Backend for Naive {
    fn name(&self) -> &str {
        "naive"
    }

    fn description(&self) -> &str {
        "by the definition"
    }

    fn rates(&self) -> Rates {
        Rates {
            gemm_flops: 1e9,
            gemm_half_side: 1.0,
            syrk_flops: 1e9,
            syrk_half_side: 1.0,
            add_bytes: 1e10,
        }
    }
}

/// The back ends that this build and machine have.
pub fn backends() -> Vec<Arc<dyn Backend>> {
    #[allow(unused_mut)]
    let mut found: Vec<Arc<dyn Backend>> = vec![blas::native(), Arc::new(Naive)];
    #[cfg(feature = "openblas")]
    found.push(blas::openblas());
    found
}
