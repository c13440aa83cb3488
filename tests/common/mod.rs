//! What the integration tests share: oracles, inputs, back ends.
#![allow(dead_code)] // each test file uses a part

use std::fs::OpenOptions;
use std::io::Write;
use std::path::PathBuf;
use std::sync::Arc;

use catamaran::base::Rng;
use catamaran::blas::{self, Backend, BlasReal, Kernels, Rates};
use catamaran::faer::prelude::ReborrowMut;
use catamaran::faer::{Mat, MatMut, MatRef};

/// Sizes that break things: empty, one, around powers of two, primes.
pub const AWKWARD: [usize; 9] = [0, 1, 2, 3, 7, 16, 31, 65, 127];

/// Small integers: every product and sum of them below is exact in f32 and f64, so that every
/// scheme, order and thread count must give the very same result as the oracle.
pub fn integers<T: BlasReal>(m: usize, n: usize, seed: u64) -> Mat<T> {
    let mut rng = Rng::new(seed);
    Mat::from_fn(m, n, |_, _| T::from_f64((rng.uniform() * 9.0).floor() - 4.0))
}

/// Standard normal entries.
pub fn gaussian<T: BlasReal>(m: usize, n: usize, seed: u64) -> Mat<T> {
    let mut rng = Rng::new(seed);
    Mat::from_fn(m, n, |_, _| T::from_f64(rng.normal()))
}

/// `alpha A^T W B + beta C` by the definition, in f64.
pub fn oracle<T: BlasReal>(
    alpha: f64,
    a: MatRef<'_, T>,
    weights: Option<&[f64]>,
    b: MatRef<'_, T>,
    beta: f64,
    c: MatRef<'_, T>,
) -> Mat<f64> {
    Mat::from_fn(a.ncols(), b.ncols(), |i, j| {
        let term =
            |r: usize| weights.map_or(1.0, |w| w[r]) * a[(r, i)].to_f64() * b[(r, j)].to_f64();
        let sum: f64 = (0..a.nrows()).map(term).sum();
        alpha * sum + if beta == 0.0 { 0.0 } else { beta * c[(i, j)].to_f64() }
    })
}

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

/// What has this name in the shared data folder (`CATAMARAN_DATA`, default `../shared`).
///
/// `None` when it is not there. A test then does without it, and says so in the file that
/// `CATAMARAN_SKIPPED` names, which `scripts/test` reports: what a test that passes prints is not
/// shown.
///
/// # Panics
/// When it is not there and `CATAMARAN_REQUIRE_DATA` is set.
pub fn data(name: &str) -> Option<PathBuf> {
    let folder = std::env::var_os("CATAMARAN_DATA")
        .map_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared"), PathBuf::from);
    let path = folder.join(name);
    if path.exists() {
        return Some(path);
    }
    assert!(
        std::env::var_os("CATAMARAN_REQUIRE_DATA").is_none(),
        "{} is not there, and CATAMARAN_REQUIRE_DATA is set",
        path.display()
    );
    if let Some(log) = std::env::var_os("CATAMARAN_SKIPPED") {
        let mut log = OpenOptions::new().create(true).append(true).open(log).expect("the list");
        writeln!(log, "skipped: {} is not there", path.display()).expect("a line");
    }
    None
}

/// The bits of every entry, for comparisons that know no tolerance.
pub fn bits<T: BlasReal>(c: MatRef<'_, T>) -> Vec<u64> {
    (0..c.ncols()).flat_map(|j| (0..c.nrows()).map(move |i| c[(i, j)].to_f64().to_bits())).collect()
}
