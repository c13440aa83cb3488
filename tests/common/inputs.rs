//! Inputs, oracles and bits, for the tests of all crates.
#![allow(dead_code)] // each test file uses a part

use std::fs::OpenOptions;
use std::io::Write;
use std::path::{Path, PathBuf};

use catamaran::base::Rng;
use catamaran::blas::BlasReal;
use catamaran::faer::{Mat, MatRef};

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

/// What has this name in the shared data folder (`CATAMARAN_DATA`, default `../shared`).
///
/// `None` when it is not there. A test then does without it, and says so in the file that
/// `CATAMARAN_SKIPPED` names, which `scripts/test` reports: what a test that passes prints is not
/// shown.
///
/// # Panics
/// When it is not there and `CATAMARAN_REQUIRE_DATA` is set.
pub fn data(name: &str) -> Option<PathBuf> {
    let beside = |folder: &Path| folder.join("../shared");
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = std::env::var_os("CATAMARAN_DATA").map_or_else(
        || package.ancestors().map(beside).find(|f| f.exists()).unwrap_or_else(|| beside(package)),
        PathBuf::from,
    );
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
