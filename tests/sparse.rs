//! Eigenpairs of sparse symmetric pencils: analytic spectra, dense oracles, invariants, refusals.

use std::f64::consts::PI;
use std::sync::atomic::{AtomicUsize, Ordering};

use catamaran::base::{Flow, Rng};
use catamaran::faer::Mat;
use catamaran::sparse::{CsMat, EigenOptions, Eigenpairs, Mass, eigs, multiply};
use catamaran::{Error, Par};

/// A sparse matrix of these entries; those of the same place are summed.
fn sparse(n: usize, entries: impl IntoIterator<Item = (usize, usize, f64)>) -> CsMat<f64> {
    let mut triplets = sprs::TriMat::new((n, n));
    entries.into_iter().for_each(|(i, j, x)| triplets.add_triplet(i, j, x));
    triplets.to_csr()
}

/// The Laplacian of a graph with these edges, all of weight 1.
fn graph(n: usize, edges: impl IntoIterator<Item = (usize, usize)>) -> CsMat<f64> {
    let entries = edges.into_iter().flat_map(|(a, b)| {
        [(a, b, -1.0), (b, a, -1.0), (a, a, 1.0), (b, b, 1.0)]
    });
    sparse(n, entries.chain((0..n).map(|i| (i, i, 0.0))))
}

/// A grid graph, of a x b nodes.
fn grid(a: usize, b: usize) -> CsMat<f64> {
    let node = move |i: usize, j: usize| i * b + j;
    let along = (0..a).flat_map(move |i| (1..b).map(move |j| (node(i, j - 1), node(i, j))));
    let across = (1..a).flat_map(move |i| (0..b).map(move |j| (node(i - 1, j), node(i, j))));
    graph(a * b, along.chain(across))
}

/// Its eigenvalues, ascending.
fn grid_spectrum(a: usize, b: usize) -> Vec<f64> {
    let path = |n: usize, i: usize| 2.0 - 2.0 * (PI * i as f64 / n as f64).cos();
    let mut values: Vec<f64> =
        (0..a).flat_map(|i| (0..b).map(move |j| path(a, i) + path(b, j))).collect();
    values.sort_by(f64::total_cmp);
    values
}

fn options(k: usize) -> EigenOptions<'static> {
    EigenOptions { k, par: Par::Seq, ..EigenOptions::default() }
}

/// Checks the residuals, which it computes anew, and `V^T M V = I`.
fn check(w: &CsMat<f64>, mass: &Mass, pairs: &Eigenpairs, tolerance: f64) {
    let (n, k) = (pairs.vectors.nrows(), pairs.values.len());
    assert_eq!((pairs.vectors.ncols(), pairs.residuals.len()), (k, k));
    assert!(pairs.values.is_sorted());
    let (mut wv, mut mv) = (Mat::zeros(n, k), Mat::zeros(n, k));
    multiply(w.view(), pairs.vectors.as_ref(), wv.as_mut(), Par::Seq).unwrap();
    mass.multiply(pairs.vectors.as_ref(), mv.as_mut(), Par::Seq).unwrap();
    for j in 0..k {
        let gap = wv.col(j) - catamaran::faer::Scale(pairs.values[j]) * mv.col(j);
        let size = wv.col(j).norm_l2();
        assert!(pairs.residuals[j] <= tolerance, "pair {j}: {:e}", pairs.residuals[j]);
        if pairs.values[j] > 1e-6 {
            assert!(gap.norm_l2() <= 4.0 * tolerance * size, "pair {j}: {:e}", gap.norm_l2() / size);
        }
    }
    let identity = pairs.vectors.transpose() * &mv;
    for j in 0..k {
        for i in 0..k {
            let expected = f64::from(i == j);
            assert!((identity[(i, j)] - expected).abs() < 1e-11, "{i} {j}: {}", identity[(i, j)]);
        }
    }
}

fn assert_close(found: &[f64], expected: &[f64], tolerance: f64) {
    assert_eq!(found.len(), expected.len());
    for (i, (a, b)) in found.iter().zip(expected).enumerate() {
        assert!((a - b).abs() <= tolerance * b.abs().max(1e-3), "{i}: {a} instead of {b}");
    }
}

#[test]
fn a_grid_has_its_analytic_spectrum_multiplicities_included() {
    for (a, b, k) in [(41, 41, 30), (97, 31, 50), (23, 60, 1), (2000, 1, 12)] {
        let (w, mass) = (grid(a, b), Mass::identity(a * b));
        let pairs = eigs(w.view(), &mass, &options(k)).unwrap();
        assert!(pairs.solves > 0, "{a} x {b} was solved as a dense one");
        check(&w, &mass, &pairs, 1e-9);
        assert_close(&pairs.values, &grid_spectrum(a, b)[..k], 1e-9);
    }
}
