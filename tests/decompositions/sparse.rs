//! Eigenpairs of sparse symmetric pencils: analytic spectra, dense oracles, invariants, refusals.

use std::f64::consts::PI;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};

use catamaran::base::Rng;
use catamaran::faer::Mat;
use catamaran::sparse::{CsMat, EigenOptions, Eigenpairs, Mass, eigs, eigs_sliced, multiply};
use catamaran::{Error, Par};

/// A sparse matrix of these entries; those of the same place are summed.
pub fn sparse(n: usize, entries: impl IntoIterator<Item = (usize, usize, f64)>) -> CsMat<f64> {
    let mut triplets = sprs::TriMat::new((n, n));
    entries.into_iter().for_each(|(i, j, x)| triplets.add_triplet(i, j, x));
    triplets.to_csr()
}

/// The Laplacian of a graph with these edges, all of weight 1.
fn graph(n: usize, edges: impl IntoIterator<Item = (usize, usize)>) -> CsMat<f64> {
    let entries =
        edges.into_iter().flat_map(|(a, b)| [(a, b, -1.0), (b, a, -1.0), (a, a, 1.0), (b, b, 1.0)]);
    sparse(n, entries.chain((0..n).map(|i| (i, i, 0.0))))
}

/// A grid graph, of a x b nodes.
pub fn grid(a: usize, b: usize) -> CsMat<f64> {
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

/// The Laplacian of a path, and its eigenvalues `4 sin(pi i / 2n)^2`, accurate to their own size.
fn path(n: usize) -> (CsMat<f64>, Vec<f64>) {
    let value = |i: usize| 4.0 * (PI * i as f64 / (2 * n) as f64).sin().powi(2);
    (graph(n, (1..n).map(|i| (i - 1, i))), (0..n).map(value).collect())
}

/// The Laplacian of a ring, and its eigenvalues, ascending.
fn ring(n: usize) -> (CsMat<f64>, Vec<f64>) {
    let value = |i: usize| 2.0 - 2.0 * (2.0 * PI * i.div_ceil(2) as f64 / n as f64).cos();
    (graph(n, (0..n).map(|i| (i, (i + 1) % n))), (0..n).map(value).collect())
}

fn options(k: usize) -> EigenOptions<'static> {
    EigenOptions::new().k(k).par(Par::Seq)
}

/// Checks the residuals, which it computes anew, and `V^T M V = I`.
fn check(w: &CsMat<f64>, mass: &Mass, pairs: &Eigenpairs, tolerance: f64) {
    check_to(w, mass, pairs, tolerance, 1e-11);
}

/// [`check`] with another bound for `V^T M V`.
fn check_to(w: &CsMat<f64>, mass: &Mass, pairs: &Eigenpairs, tolerance: f64, orthogonality: f64) {
    let (n, k) = (pairs.vectors.nrows(), pairs.values.len());
    assert_eq!((pairs.vectors.ncols(), pairs.residuals.len()), (k, k));
    assert!(pairs.values.is_sorted());
    let (mut wv, mut mv) = (Mat::zeros(n, k), Mat::zeros(n, k));
    multiply(w.view(), pairs.vectors.as_ref(), wv.as_mut(), Par::Seq).unwrap();
    mass.multiply(pairs.vectors.as_ref(), mv.as_mut(), Par::Seq).unwrap();
    for j in 0..k {
        let gap = wv.col(j) - faer::Scale(pairs.values[j]) * mv.col(j);
        let size = wv.col(j).norm_l2();
        assert!(pairs.residuals[j] <= tolerance, "pair {j}: {:e}", pairs.residuals[j]);
        if pairs.values[j] > 1e-6 {
            assert!(
                gap.norm_l2() <= 4.0 * tolerance * size,
                "pair {j}: {:e}",
                gap.norm_l2() / size
            );
        }
    }
    let identity = pairs.vectors.transpose() * &mv;
    for j in 0..k {
        for i in 0..k {
            let expected = f64::from(i == j);
            let found = identity[(i, j)];
            assert!((found - expected).abs() < orthogonality, "{i} {j}: {found}");
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

#[test]
fn a_cycle_has_pairs_of_equal_eigenvalues() {
    let (n, k) = (1009, 25);
    let ((w, all), mass) = (ring(n), Mass::identity(n));
    let pairs = eigs(w.view(), &mass, &options(k)).unwrap();
    check(&w, &mass, &pairs, 1e-9);
    assert_close(&pairs.values, &all[..k], 1e-8);
}

#[test]
fn multiplicities_larger_than_a_block_are_complete_when_counted() {
    // 30 equal paths: every eigenvalue 30 times, none of them but 0 to be seen from the graph.
    let (copies, length, k) = (30, 40, 75);
    let edges = (0..copies)
        .flat_map(move |c| (1..length).map(move |i| (c * length + i - 1, c * length + i)));
    let w = graph(copies * length, edges);
    let mass = Mass::identity(copies * length);
    let counted = options(k).verify_count(true);
    let pairs = eigs(w.view(), &mass, &counted).unwrap();
    check(&w, &mass, &pairs, 1e-9);
    let value = |i: usize| 2.0 - 2.0 * (PI * (i / copies) as f64 / length as f64).cos();
    assert_close(&pairs.values, &(0..k).map(value).collect::<Vec<_>>(), 1e-8);
}

#[test]
fn the_null_space_has_a_dimension_for_each_component() {
    // Paths of different lengths, isolated nodes among them.
    let lengths = [1, 700, 3, 1, 500, 11, 2, 1, 1, 1, 400, 5];
    let starts: Vec<usize> =
        lengths.iter().scan(0, |sum, l| Some(std::mem::replace(sum, *sum + l))).collect();
    let n = lengths.iter().sum();
    let edges =
        starts.iter().zip(lengths).flat_map(|(s, l)| (1..l).map(move |i| (s + i - 1, s + i)));
    let w = graph(n, edges.collect::<Vec<_>>());
    let mut rng = Rng::new(5);
    let mass = Mass::Lumped((0..n).map(|_| 0.5 + rng.uniform()).collect());
    for k in [5, lengths.len(), lengths.len() + 6] {
        let pairs = eigs(w.view(), &mass, &options(k)).unwrap();
        check(&w, &mass, &pairs, 1e-9);
        let zero = pairs.values.iter().filter(|v| **v < 1e-10).count();
        assert_eq!(zero, k.min(lengths.len()));
    }
}

/// A seeded pencil: a random graph with random weights, and a mass.
fn random_pencil(n: usize, seed: u64, full: bool) -> (CsMat<f64>, Mass) {
    let mut rng = Rng::new(seed);
    let mut edges: Vec<(usize, usize, f64)> = Vec::new();
    for i in 1..n {
        for _ in 0..2 {
            let j = (rng.uniform() * i as f64) as usize;
            edges.push((i, j.max(i.saturating_sub(9)), 0.1 + rng.uniform()));
        }
    }
    let laplacian = |edges: &[(usize, usize, f64)]| {
        let entries: Vec<_> = edges
            .iter()
            .flat_map(|&(a, b, x)| [(a, b, -x), (b, a, -x), (a, a, x), (b, b, x)])
            .collect();
        sparse(n, entries)
    };
    let w = laplacian(&edges);
    let lumped: Vec<f64> = (0..n).map(|_| 0.2 + rng.uniform()).collect();
    let mass = match full {
        false => Mass::Lumped(lumped),
        // Diagonally dominant.
        true => {
            let off = edges.iter().flat_map(|&(a, b, x)| [(a, b, 0.05 * x), (b, a, 0.05 * x)]);
            let own = lumped.into_iter().enumerate().map(|(i, m)| (i, i, 1.0 + m));
            Mass::Full(sparse(n, off.chain(own).collect::<Vec<_>>()))
        }
    };
    (w, mass)
}

#[test]
fn sparse_and_dense_solvers_agree() {
    for (full, seed) in [(false, 1), (true, 2)] {
        let n = 331;
        let (w, mass) = random_pencil(n, seed, full);
        // For all of them the dense solver is taken.
        let all = eigs(w.view(), &mass, &options(n)).unwrap();
        assert_eq!(all.solves, 0);
        check(&w, &mass, &all, 1e-9);
        let some = eigs(w.view(), &mass, &options(13).verify_count(true)).unwrap();
        assert!(some.solves > 0);
        check(&w, &mass, &some, 1e-9);
        assert_close(&some.values, &all.values[..13], 1e-9);
        let shift = 0.5 * (all.values[100] + all.values[101]) + 1e-4;
        let inside = options(12).shift(Some(shift)).verify_count(true);
        let inside = eigs(w.view(), &mass, &inside).unwrap();
        check(&w, &mass, &inside, 1e-9);
        let mut nearest = all.values.clone();
        nearest.sort_by(|a, b| (a - shift).abs().total_cmp(&(b - shift).abs()));
        nearest.truncate(12);
        nearest.sort_by(f64::total_cmp);
        assert_close(&inside.values, &nearest, 1e-9);
        // The same shift in the dense solver.
        let dense = options(n / 2).shift(Some(shift));
        assert!(eigs(w.view(), &mass, &dense).unwrap().values.is_sorted());
    }
}

/// A diagonal matrix, and its entries: 40 times 1, then 2, 3, ...
fn forty_ones(n: usize) -> (CsMat<f64>, Vec<f64>) {
    let value = |i: usize| if i < 40 { 1.0 } else { (i - 38) as f64 };
    (sparse(n, (0..n).map(|i| (i, i, value(i)))), (0..n).map(value).collect())
}

/// Checks that these are the values of a spectrum that are nearest to a shift; one as far from it
/// as another may stand for it.
fn assert_nearest(found: &Eigenpairs, k: usize, spectrum: &[f64], shift: f64, tolerance: f64) {
    let distances = |values: &[f64]| {
        let mut distances: Vec<f64> = values.iter().map(|value| (value - shift).abs()).collect();
        distances.sort_by(f64::total_cmp);
        distances
    };
    assert_eq!(found.values.len(), k);
    let (own, all) = (distances(&found.values), distances(spectrum));
    for (i, (a, b)) in own.iter().zip(&all).enumerate() {
        assert!((a - b).abs() <= tolerance, "{k} near {shift:e}, {i}: {:?}", found.values);
    }
    for value in &found.values {
        let error = spectrum.iter().map(|other| (value - other).abs()).fold(f64::MAX, f64::min);
        assert!(error <= tolerance, "{k} near {shift:e}: {value:e} is none");
    }
}

#[test]
fn shifts_at_and_near_eigenvalues_find_the_nearest_ones() {
    let (a, b) = (29, 23);
    let n = a * b;
    let mass = Mass::identity(n);
    // Times a factor, plus a multiple of the identity; largest error allowed.
    for (factor, more, tolerance) in [(1.0_f64, 0.0, 1e-9), (1.0, 1e4, 1e-5), (-1e-3, 0.0, 1e-9)] {
        let w = grid(a, b).map(|x| factor * x);
        let w = &w + &sparse(n, (0..n).map(|i| (i, i, more)));
        let mut all: Vec<f64> = grid_spectrum(a, b).iter().map(|x| factor * x + more).collect();
        all.sort_by(f64::total_cmp);
        for at in [all[0], all[1], all[40], all[n - 1]] {
            for beside in [0.0, 1e-14, -1e-12, 1e-9, -1e-6, 1e-4] {
                let shift = at + factor.abs() * beside;
                for k in [1, 5, 60] {
                    let found = eigs(w.view(), &mass, &options(k).shift(shift))
                        .unwrap_or_else(|error| panic!("{k} pairs near {shift:e}: {error}"));
                    assert!(found.solves > 0);
                    check(&w, &mass, &found, 1e-9);
                    assert_nearest(&found, k, &all, shift, tolerance);
                }
            }
        }
    }
}

#[test]
fn shifts_at_eigenvalues_find_the_nearest_ones_where_they_are_much_denser_than_the_scale() {
    let n = 100_000;
    let ((w, all), mass) = (path(n), Mass::identity(n));
    for (shift, k) in [(0.0, 1), (all[3], 1), (all[3], 5), (all[3] + 1e-15, 1)] {
        let found = eigs(w.view(), &mass, &options(k).shift(shift)).unwrap();
        assert_nearest(&found, k, &all, shift, 1e-13);
    }
}

#[test]
fn shifts_among_equal_eigenvalues_find_the_nearest_ones() {
    let ((w, all), mass) = (ring(200), Mass::identity(200));
    for shift in [0.1, all[20], all[21], 0.0, all[199]] {
        for k in [1, 2, 10] {
            let found = eigs(w.view(), &mass, &options(k).shift(shift)).unwrap();
            assert!(found.solves > 0);
            assert_nearest(&found, k, &all, shift, 1e-9);
        }
    }
    // Three components.
    let lengths = [150, 170, 190];
    let edges = [0, 150, 320].into_iter().zip(lengths);
    let edges = edges.flat_map(|(s, l)| (1..l).map(move |i| (s + i - 1, s + i)));
    let w = graph(510, edges);
    let all: Vec<f64> = lengths.iter().flat_map(|l| path(*l).1).collect();
    for k in [1, 3, 10] {
        let found = eigs(w.view(), &Mass::identity(510), &options(k).shift(0.0).verify_count(true))
            .unwrap();
        assert!(found.solves > 0);
        assert_nearest(&found, k, &all, 0.0, 1e-10);
    }
}

#[test]
fn equal_eigenvalues_at_an_end_of_the_result_are_counted() {
    let n = 290;
    let ((w, all), mass) = (forty_ones(n), Mass::identity(n));
    for shift in [0.5, 1.0, 1.0 + 1e-15, 1.5 - 1e-3, 51.0] {
        for k in [10, 50] {
            let options = options(k).shift(shift).verify_count(true);
            let found = eigs(w.view(), &mass, &options)
                .unwrap_or_else(|error| panic!("{k} pairs near {shift:e}: {error}"));
            assert!(found.solves > 0);
            assert_nearest(&found, k, &all, shift, 1e-9);
        }
    }
}

#[test]
fn shifts_of_dense_problems_may_be_eigenvalues() {
    for (w, all) in [path(60), ring(60), forty_ones(60)] {
        for shift in [0.0, all[0], all[3], all[30], 0.1] {
            for k in [1, 7, 45] {
                let options = options(k).shift(shift).verify_count(true);
                let found = eigs(w.view(), &Mass::identity(60), &options).unwrap();
                assert_eq!(found.solves, 0);
                assert_nearest(&found, k, &all, shift, 1e-12);
            }
        }
    }
}

#[test]
fn null_vectors_are_found_near_the_shift_only() {
    let n = 300;
    let value = |i: usize| if i == 0 { -2.0 } else { i as f64 - 1.0 };
    let w = sparse(n, (0..n).map(|i| (i, i, value(i))));
    let pairs = eigs(w.view(), &Mass::identity(n), &options(1).shift(-2.1)).unwrap();
    assert_close(&pairs.values, &[-2.0], 1e-9);
}

#[test]
fn every_small_size_and_count_works() {
    for n in [0, 1, 2, 3, 7, 31] {
        let w = graph(n, (1..n).map(|i| (i - 1, i)));
        let mass = Mass::identity(n);
        for k in 0..=n {
            let pairs = eigs(w.view(), &mass, &options(k)).unwrap();
            check(&w, &mass, &pairs, 1e-9);
            assert_close(&pairs.values, &grid_spectrum(n, 1)[..k], 1e-10);
        }
    }
}

#[test]
fn a_matrix_of_zeros_has_only_null_vectors() {
    let n = 200;
    let (w, mass) = (graph(n, []), Mass::identity(n));
    let pairs = eigs(w.view(), &mass, &options(7)).unwrap();
    check(&w, &mass, &pairs, 1e-9);
    assert_eq!(pairs.values, [0.0; 7]);
}

#[test]
fn the_result_is_the_same_for_any_number_of_threads() {
    let (w, mass) = random_pencil(5000, 3, true);
    let run = |threads| {
        let options = options(20).threads(threads);
        eigs(w.view(), &mass, &options).unwrap()
    };
    let one = run(1);
    for threads in [2, 3] {
        let more = run(threads);
        assert_eq!(one.values, more.values);
        assert_eq!(one.vectors, more.vectors);
        assert_eq!(one.residuals, more.residuals);
    }
    let other = options(20).seed(1);
    let other = eigs(w.view(), &mass, &other).unwrap();
    assert_ne!(one.vectors, other.vectors);
    assert_close(&one.values, &other.values, 1e-10);
}

#[test]
fn progress_grows_to_one_and_cancels() {
    let (w, mass) = (grid(60, 40), Mass::identity(2400));
    let last = std::sync::Mutex::new(0.0);
    let watch = |fraction: f64| {
        let mut last = last.lock().unwrap();
        assert!((*last..=1.0).contains(&fraction), "{fraction} after {}", *last);
        *last = fraction;
        ControlFlow::Continue(())
    };
    eigs(w.view(), &mass, &options(20).progress(&watch)).unwrap();
    assert_eq!(*last.lock().unwrap(), 1.0);
    let calls = AtomicUsize::new(0);
    for limit in [0, 3, 6] {
        calls.store(0, Ordering::Relaxed);
        let stop = |_: f64| match calls.fetch_add(1, Ordering::Relaxed) {
            done if done >= limit => ControlFlow::Break(()),
            _ => ControlFlow::Continue(()),
        };
        let stopped = eigs(w.view(), &mass, &options(20).progress(&stop));
        assert_eq!(stopped.unwrap_err(), Error::Cancelled);
        assert_eq!(calls.load(Ordering::Relaxed), limit + 1);
    }
}

#[test]
fn dirty_inputs_are_refused_by_name() {
    let n = 500;
    let (w, mass) = (grid(50, 10), Mass::identity(n));
    let told = |w: &CsMat<f64>, mass: &Mass, options: &EigenOptions<'_>| {
        eigs(w.view(), mass, options).unwrap_err().to_string()
    };
    let mut bad = w.clone();
    bad.data_mut()[7] = f64::NAN;
    assert!(told(&bad, &mass, &options(3)).starts_with("stiffness: not finite at row 2"));
    let mut bad = w.clone();
    bad.data_mut()[1] = -3.0;
    assert!(
        told(&bad, &mass, &options(3)).contains("stiffness: not symmetric: entry (0, 1) is -3")
    );
    let wide = CsMat::zero((3, 4));
    assert!(matches!(
        eigs(wide.view(), &mass, &options(1)).unwrap_err(),
        Error::Shape { what: "stiffness", .. }
    ));
    let short = Mass::identity(n - 1);
    assert!(matches!(
        eigs(w.view(), &short, &options(1)).unwrap_err(),
        Error::Shape { what: "mass", expected: (500, _), got: (499, _) }
    ));
    let masses = |at: usize, value: f64| {
        Mass::Lumped((0..n).map(|i| if i == at { value } else { 1.0 }).collect())
    };
    assert!(told(&w, &masses(17, -1.0), &options(3)).contains("entry 17 is -1"));
    assert!(told(&w, &masses(0, 0.0), &options(3)).contains("entry 0 is 0"));
    assert_eq!(
        eigs(w.view(), &masses(9, f64::INFINITY), &options(3)).unwrap_err(),
        Error::NonFinite { what: "mass", index: (9, 0) }
    );
    assert!(told(&w, &mass, &options(501)).starts_with("k: 501 eigenpairs"));
    let loose = options(3).tolerance(1.0);
    assert!(told(&w, &mass, &loose).starts_with("tolerance: "));
    let nowhere = options(3).shift(Some(f64::NAN));
    assert!(told(&w, &mass, &nowhere).starts_with("shift: "));
    let negative = w.map(|x| -x);
    assert!(told(&negative, &mass, &options(3)).contains("not positive semi-definite"));
    // A mass that only elimination finds not to be positive.
    let entries = [(0, 0, 1.0), (1, 1, 1.0), (0, 1, 2.0), (1, 0, 2.0)];
    let small = graph(2, [(0, 1)]);
    assert!(told(&small, &Mass::Full(sparse(2, entries)), &options(1)).contains("mass"));
}

#[test]
fn what_does_not_converge_says_how_far_it_came() {
    let (w, mass) = (grid(60, 60), Mass::identity(3600));
    let hasty = options(30).max_restarts(0).tolerance(1e-14);
    match eigs(w.view(), &mass, &hasty) {
        Err(Error::NotConverged { iterations: 0, residual }) => assert!(residual > 1e-14),
        other => panic!("{other:?}"),
    }
    // Beside a shift that is an eigenvalue.
    let said = eigs(w.view(), &mass, &hasty.shift(0.0)).unwrap_err().to_string();
    assert!(said.starts_with("shift: 0e0 is an eigenvalue or near one"), "{said}");
    assert!(said.contains("not converged after 0 iterations"), "{said}");
}

#[test]
fn products_with_blocks_are_those_of_columns() {
    let (w, _) = random_pencil(2500, 4, false);
    let mut rng = Rng::new(9);
    let x = Mat::from_fn(2500, 3, |_, _| rng.uniform());
    for threads in [1, 2, 3] {
        let mut y = Mat::zeros(2500, 3);
        multiply(w.view(), x.as_ref(), y.as_mut(), Par::Threads(threads)).unwrap();
        for i in (0..2500).step_by(97) {
            for j in 0..3 {
                let expected: f64 =
                    w.outer_view(i).unwrap().iter().map(|(l, a)| a * x[(l, j)]).sum();
                assert_eq!(y[(i, j)], expected);
            }
        }
    }
    let by_columns = w.to_csc();
    let refused = multiply(by_columns.view(), x.as_ref(), Mat::zeros(2500, 3).as_mut(), Par::Seq);
    assert!(matches!(refused, Err(Error::Argument { what: "A", .. })));
}

/// The slices of the k smallest pairs within this memory, put together, and where each of them
/// ends.
fn sliced(
    w: &CsMat<f64>,
    mass: &Mass,
    options: &EigenOptions<'_>,
    memory: usize,
) -> (Eigenpairs, Vec<usize>) {
    let (mut slices, mut ends, n): (Vec<Eigenpairs>, _, _) = (vec![], vec![], w.rows());
    eigs_sliced(w.view(), mass, options, memory, |slice| {
        assert_eq!(slice.vectors.shape(), (n, slice.values.len()));
        ends.push(ends.last().unwrap_or(&0) + slice.values.len());
        slices.push(slice);
        Ok(())
    })
    .unwrap();
    let columns: Vec<_> = slices.iter().flat_map(|s| s.vectors.col_iter()).collect();
    let pairs = Eigenpairs {
        values: slices.iter().flat_map(|s| s.values.clone()).collect(),
        vectors: Mat::from_fn(n, columns.len(), |i, j| columns[j][i]),
        residuals: slices.iter().flat_map(|s| s.residuals.clone()).collect(),
        solves: slices.iter().map(|s| s.solves).sum(),
    };
    (pairs, ends)
}

#[test]
fn slices_have_the_pairs_that_a_whole_run_has() {
    let (w, mass) = random_pencil(4001, 6, true);
    let k = 150;
    let whole = eigs(w.view(), &mass, &options(k)).unwrap();
    // For slices of at most about 40 pairs.
    let (pairs, ends) = sliced(&w, &mass, &options(k), 10_500_000);
    assert!(ends.len() >= 4 && ends.last() == Some(&k), "{ends:?}");
    assert!(pairs.values.is_sorted());
    assert_close(&pairs.values, &whole.values, 1e-9);
    check_to(&w, &mass, &pairs, 1e-9, 1e-7);
    // The same for other threads; with more memory there is one slice, that of the whole run.
    let threads = options(k).threads(3);
    let (again, _) = sliced(&w, &mass, &threads, 10_500_000);
    assert_eq!((again.values, again.vectors), (pairs.values, pairs.vectors));
    let (one, ends) = sliced(&w, &mass, &options(k), 1 << 30);
    assert_eq!((one.vectors, ends), (whole.vectors, vec![k]));
}

#[test]
fn slices_do_not_cut_equal_eigenvalues() {
    // 11 equal grids: every eigenvalue 11 times or 22 times.
    let copies = 11;
    let (a, b, k) = (17, 17, 170);
    let node = move |c: usize, i: usize, j: usize| (c * a + i) * b + j;
    let edges = (0..copies).flat_map(|c| (0..a).flat_map(move |i| (0..b).map(move |j| (c, i, j))));
    let edges = edges.flat_map(|(c, i, j)| {
        let right = (j + 1 < b).then(|| (node(c, i, j), node(c, i, j + 1)));
        let down = (i + 1 < a).then(|| (node(c, i, j), node(c, i + 1, j)));
        right.into_iter().chain(down)
    });
    let w = graph(copies * a * b, edges.collect::<Vec<_>>());
    let mass = Mass::identity(w.rows());
    let (pairs, ends) = sliced(&w, &mass, &options(k), 9_500_000);
    let spectrum = grid_spectrum(a, b);
    let expected: Vec<f64> = (0..k).map(|i| spectrum[i / copies]).collect();
    assert_close(&pairs.values, &expected, 1e-8);
    check_to(&w, &mass, &pairs, 1e-9, 1e-7);
    assert!(ends.len() >= 3, "{ends:?}");
    for end in &ends[..ends.len() - 1] {
        assert!(pairs.values[*end] > pairs.values[end - 1] + 1e-6, "cut at {end}");
    }
}

#[test]
fn slices_refuse_too_little_memory_and_stop_when_told() {
    let (w, mass) = (grid(60, 40), Mass::identity(2400));
    let refused = |options: &EigenOptions<'_>, memory| {
        eigs_sliced(w.view(), &mass, options, memory, |_| Ok(())).unwrap_err().to_string()
    };
    let too_little = refused(&options(100), 1000);
    assert!(too_little.starts_with("memory: must be at least "), "{too_little}");
    assert!(too_little.ends_with(" bytes, is 1000"), "{too_little}");
    let around = options(100).shift(Some(1.0));
    assert!(refused(&around, 1000).contains("100 pairs around a shift"));
    // 120 equal paths: no slice has room for all the equal ones.
    let edges: Vec<_> =
        (0..120).flat_map(|c| (1..20).map(move |i| (c * 20 + i - 1, c * 20 + i))).collect();
    let equal = graph(2400, edges);
    let cluster = eigs_sliced(equal.view(), &mass, &options(200), 6_000_000, |_| Ok(()));
    assert!(cluster.unwrap_err().to_string().contains("a cluster of eigenvalues"));
    // Progress grows to one over all slices; what the sink says ends the work.
    let last = std::sync::Mutex::new(0.0);
    let watch = |fraction: f64| {
        let mut last = last.lock().unwrap();
        assert!((*last..=1.0).contains(&fraction), "{fraction} after {}", *last);
        *last = fraction;
        ControlFlow::Continue(())
    };
    let watched = options(100).progress(&watch);
    sliced(&w, &mass, &watched, 6_000_000);
    assert_eq!(*last.lock().unwrap(), 1.0);
    let mut slices = 0;
    let stopped = eigs_sliced(w.view(), &mass, &options(100), 6_000_000, |_| {
        slices += 1;
        Err(Error::Cancelled)
    });
    assert_eq!((stopped, slices), (Err(Error::Cancelled), 1));
}

#[test]
fn what_rounding_leaves_of_huge_weights_is_no_reason_to_go_on() {
    // A path with steps of weight 1e9: W phi has roundings that are larger than the tolerance.
    let n = 900;
    let mut entries = Vec::new();
    for i in 1..n {
        let x = if i % 90 == 0 { 1e9 } else { 1.0 };
        entries.extend([(i - 1, i, -x), (i, i - 1, -x), (i, i, x), (i - 1, i - 1, x)]);
    }
    let (w, mass) = (sparse(n, entries), Mass::identity(n));
    let pairs = eigs(w.view(), &mass, &options(6)).unwrap();
    let (worst, residual) = pairs.worst().unwrap();
    assert!(residual > 1e-9 && residual == pairs.residuals[worst], "{:?}", pairs.residuals);
    assert!(pairs.residuals.iter().all(|r| *r <= residual));
    // Two nodes that such a step joins are one of mass 2.
    let all = eigs(w.view(), &mass, &options(6).k(n)).unwrap();
    let size = all.values[5];
    for (found, expected) in pairs.values.iter().zip(&all.values) {
        // The dense solver is exact to the largest eigenvalue only.
        assert!((found - expected).abs() < 1e-5 + 1e-6 * size, "{found} instead of {expected}");
    }
}
