//! Sparse Cholesky factorizations: an analytic inverse, a dense oracle, invariants, refusals.

use std::ops::{ControlFlow, Range};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

use catamaran::base::{Progress, Rng};
use catamaran::faer::{Mat, MatRef};
use catamaran::sparse::{Cholesky, CholeskyOptions, CsMat, Triangle, multiply};
use catamaran::{Error, Par};

use crate::sparse::{grid, sparse};

fn options() -> CholeskyOptions<'static> {
    CholeskyOptions::new().par(Par::Seq)
}

/// 2 on the diagonal, -1 beside it.
fn held_path(n: usize) -> CsMat<f64> {
    let beside = (1..n).flat_map(|i| [(i, i - 1, -1.0), (i - 1, i, -1.0)]);
    sparse(n, (0..n).map(|i| (i, i, 2.0)).chain(beside))
}

/// The Laplacian of a grid, plus the identity.
fn shifted_grid(a: usize, b: usize) -> CsMat<f64> {
    let entries: Vec<_> = grid(a, b).iter().map(|(&x, (i, j))| (i, j, x)).collect();
    sparse(a * b, entries.into_iter().chain((0..a * b).map(|i| (i, i, 1.0))))
}

/// A random graph with weights of both signs between nodes of the same of some blocks, and a
/// diagonal that dominates.
fn random(n: usize, blocks: usize, seed: u64) -> CsMat<f64> {
    let mut rng = Rng::new(seed);
    let mut entries = Vec::new();
    for i in 0..n {
        entries.push((i, i, 1.0));
        for _ in 0..3 {
            let (j, x) = (rng.bits() as usize % n, rng.uniform() - 0.5);
            if i != j && i % blocks == j % blocks {
                entries.extend([(i, j, x), (j, i, x), (i, i, x.abs()), (j, j, x.abs())]);
            }
        }
    }
    sparse(n, entries)
}

/// The Laplacian of a random graph whose blocks are paths with further edges.
fn laplacian(n: usize, blocks: usize, seed: u64) -> CsMat<f64> {
    let mut rng = Rng::new(seed);
    let mut entries = Vec::new();
    let mut join = |i: usize, j: usize, x: f64| {
        entries.extend([(i, j, -x), (j, i, -x), (i, i, x), (j, j, x)]);
    };
    for i in blocks..n {
        join(i, i - blocks, 0.5 + rng.uniform());
        let other = rng.bits() as usize % n / blocks * blocks + i % blocks;
        if other < n && other != i {
            join(i, other, 0.5 + rng.uniform());
        }
    }
    sparse(n, entries)
}

/// A triangle of a matrix, with numbers in the other one that must not be read.
fn part(a: &CsMat<f64>, triangle: Triangle) -> CsMat<f64> {
    let entry = |i: usize, j: usize, x: f64| match triangle {
        Triangle::Lower if j > i => 1e3,
        Triangle::Upper if i > j => 1e3,
        _ => x,
    };
    let entries = a.iter().map(|(&x, (i, j))| (i, j, entry(i, j, x)));
    sparse(a.rows(), entries.collect::<Vec<_>>())
}

fn product(a: &CsMat<f64>, x: MatRef<'_, f64>) -> Mat<f64> {
    let mut b = Mat::zeros(a.rows(), x.ncols());
    multiply(a.view(), x, b.as_mut(), Par::Seq).unwrap();
    b
}

fn random_columns(n: usize, columns: usize, seed: u64) -> Mat<f64> {
    let mut rng = Rng::new(seed);
    Mat::from_fn(n, columns, |_, _| rng.uniform() - 0.5)
}

/// The solution by a dense factorization, entry by entry.
fn dense_solution(a: &CsMat<f64>, b: MatRef<'_, f64>) -> Mat<f64> {
    let n = a.rows();
    let mut l = Mat::<f64>::zeros(n, n);
    a.iter().for_each(|(&x, (i, j))| l[(i, j)] = x);
    for j in 0..n {
        for i in j..n {
            let sum = (0..j).map(|k| l[(i, k)] * l[(j, k)]).sum::<f64>();
            let x = l[(i, j)] - sum;
            l[(i, j)] = if i == j { x.sqrt() } else { x / l[(j, j)] };
        }
    }
    let mut x = b.to_owned();
    for c in 0..b.ncols() {
        for i in 0..n {
            let sum = (0..i).map(|k| l[(i, k)] * x[(k, c)]).sum::<f64>();
            x[(i, c)] = (x[(i, c)] - sum) / l[(i, i)];
        }
        for i in (0..n).rev() {
            let sum = (i + 1..n).map(|k| l[(k, i)] * x[(k, c)]).sum::<f64>();
            x[(i, c)] = (x[(i, c)] - sum) / l[(i, i)];
        }
    }
    x
}

fn assert_close(found: &Mat<f64>, expected: &Mat<f64>, tolerance: f64, what: &str) {
    assert_eq!(found.shape(), expected.shape(), "{what}");
    let gap = (found - expected).norm_max();
    assert!(gap <= tolerance * expected.norm_max().max(1.0), "{what}: {gap:e}");
}

#[test]
fn the_inverse_of_a_path_is_the_analytic_one_from_any_triangle_and_storage() {
    for n in [1, 2, 3, 7, 31, 101, 997] {
        let a = held_path(n);
        let columns: Vec<usize> = (0..n).step_by(1 + n / 5).collect();
        let unit = Mat::from_fn(n, columns.len(), |i, c| f64::from(i == columns[c]));
        let inverse = Mat::from_fn(n, columns.len(), |i, c| {
            let (low, high) = (i.min(columns[c]), i.max(columns[c]));
            (low + 1) as f64 * (n - high) as f64 / (n + 1) as f64
        });
        for triangle in [Triangle::Lower, Triangle::Upper, Triangle::Both] {
            let stored = part(&a, triangle);
            for stored in [stored.to_csc(), stored] {
                let options = options().triangle(triangle);
                let cholesky = Cholesky::new(stored.view(), &options).unwrap();
                assert!(cholesky.held().is_empty() && cholesky.n() == n);
                let found = cholesky.solve(unit.as_ref()).unwrap();
                let what = format!("n = {n}, {triangle:?}, by columns: {}", stored.is_csc());
                assert_close(&found, &inverse, 1e-11, &what);
            }
        }
    }
}

#[test]
fn solutions_are_those_of_a_dense_factorization_the_same_for_any_threads_and_strides() {
    for (n, blocks) in [(1, 1), (2, 1), (13, 1), (53, 5), (211, 1), (211, 7), (307, 100)] {
        let a = random(n, blocks, 3);
        let by = |par| Cholesky::new(a.view(), &options().par(par)).unwrap();
        let (one, three) = (by(Par::Seq), by(Par::Threads(3)));
        for columns in [0, 1, 3, 8, 9, 17] {
            let what = format!("n = {n}, {blocks} blocks, {columns} columns");
            let b = random_columns(n, columns, 5);
            let found = one.solve(b.as_ref()).unwrap();
            assert_close(&found, &dense_solution(&a, b.as_ref()), 1e-12, &what);
            assert_close(&product(&a, found.as_ref()), &b, 1e-12, &what);
            assert_eq!(three.solve(b.as_ref()).unwrap(), found, "{what}");
            let mut by_rows = b.transpose().to_owned();
            one.solve_in_place(by_rows.as_mut().transpose_mut()).unwrap();
            assert_eq!(found, by_rows.transpose(), "{what}");
        }
    }
}

#[test]
fn threads_that_share_large_supernodes_do_not_change_the_factor() {
    // 1000 columns: supernodes of 256, with updates of 10^8 operations.
    for (n, rank) in [(1000, 1000), (1000, 991)] {
        let entry = |i: usize, j: usize| match (i.max(j) < rank, i == j) {
            (true, true) => n as f64,
            (true, false) => ((i * j) % 7) as f64 / 7.0 - 0.5,
            // Rows that are zero.
            _ => 0.0,
        };
        let a = sparse(n, (0..n * n).map(|k| (k / n, k % n, entry(k / n, k % n))));
        let x = Mat::from_fn(n, 2, |i, j| if i < rank { (i % 5 + j) as f64 } else { 0.0 });
        let b = product(&a, x.as_ref());
        let solve = |par| {
            let options = options().par(par).semidefinite(rank < n);
            let cholesky = Cholesky::new(a.view(), &options).unwrap();
            assert_eq!(cholesky.held(), (rank..n).collect::<Vec<_>>());
            cholesky.solve(b.as_ref()).unwrap()
        };
        let found = solve(Par::Seq);
        assert_close(&found, &x, 1e-11, "large supernodes");
        assert_eq!(solve(Par::Threads(3)), found);
        assert_eq!(solve(Par::Threads(2)), found);
    }
}

#[test]
fn a_grid_is_solved_and_its_factor_is_sparse() {
    let (shifted, n) = (shifted_grid(61, 67), 61 * 67);
    let x = random_columns(n, 2, 1);
    let cholesky = Cholesky::new(shifted.view(), &options()).unwrap();
    let found = cholesky.solve(product(&shifted, x.as_ref()).as_ref()).unwrap();
    assert_close(&found, &x, 1e-12, "grid");
    // A band has 61 n.
    assert!(cholesky.entries() < 40 * n, "{} entries", cholesky.entries());
    assert!(cholesky.bytes() > 8 * cholesky.entries());
}

#[test]
fn permuted_matrices_have_permuted_solutions() {
    for n in [5, 47, 199] {
        let a = random(n, 1, 8);
        // A step that is prime to n visits every row.
        let place = |i: usize| (3 * i + 2) % n;
        let entries = a.iter().map(|(&x, (i, j))| (place(i), place(j), x));
        let permuted = sparse(n, entries.collect::<Vec<_>>());
        let b = random_columns(n, 3, 2);
        let mut moved = b.clone();
        (0..n).for_each(|i| (0..3).for_each(|j| moved[(place(i), j)] = b[(i, j)]));
        let solve = |a: &CsMat<f64>, b: &Mat<f64>| {
            Cholesky::new(a.view(), &options()).unwrap().solve(b.as_ref()).unwrap()
        };
        let (found, moved) = (solve(&a, &b), solve(&permuted, &moved));
        let back = Mat::from_fn(n, 3, |i, j| moved[(place(i), j)]);
        assert_close(&back, &found, 1e-12, "permuted");
    }
}

/// The rows of a part of a grid of b columns, with a middle line of the longer sides last.
fn dissected(rows: Range<usize>, columns: Range<usize>, b: usize) -> Vec<usize> {
    let nodes = |rows: Range<usize>, columns: Range<usize>| -> Vec<usize> {
        rows.flat_map(|i| columns.clone().map(move |j| i * b + j)).collect()
    };
    if rows.len() <= 2 || columns.len() <= 2 {
        return nodes(rows, columns);
    }
    let (row, column) = (rows.start + rows.len() / 2, columns.start + columns.len() / 2);
    let parts = match rows.len() >= columns.len() {
        true => [
            dissected(rows.start..row, columns.clone(), b),
            dissected(row + 1..rows.end, columns.clone(), b),
            nodes(row..row + 1, columns),
        ],
        false => [
            dissected(rows.clone(), columns.start..column, b),
            dissected(rows.clone(), column + 1..columns.end, b),
            nodes(rows, column..column + 1),
        ],
    };
    parts.concat()
}

#[test]
fn any_order_of_elimination_has_the_same_solution_and_dissection_a_sparse_factor() {
    let (side, n) = (40, 1600);
    let a = shifted_grid(side, side);
    let x = random_columns(n, 2, 3);
    let b = product(&a, x.as_ref());
    let by_rows: Vec<usize> = (0..n).collect();
    // A step that is prime to n.
    let mixed: Vec<usize> = (0..n).map(|i| (611 * i + 5) % n).collect();
    let dissected = dissected(0..side, 0..side, side);
    let mut entries = Vec::new();
    for order in [&by_rows, &mixed, &dissected] {
        let options = options().order(&order[..]);
        let mut cholesky = Cholesky::new(a.view(), &options).unwrap();
        assert_close(&cholesky.solve(b.as_ref()).unwrap(), &x, 1e-12, "any order");
        let found = cholesky.solve(b.as_ref()).unwrap();
        cholesky.factor(a.view(), Progress::none()).unwrap();
        assert_eq!(cholesky.solve(b.as_ref()).unwrap(), found);
        entries.push(cholesky.entries());
    }
    // The entries of a band of 40 rows, with zeros of wider supernodes.
    assert!(entries[0] < 60 * n && entries[1] > entries[0], "{entries:?}");
    assert!(3 * entries[2] < 2 * entries[0], "{entries:?}");
    let refused = |order: &[usize]| {
        Cholesky::new(a.view(), &options().order(order)).map(|_| ()).unwrap_err().to_string()
    };
    assert_eq!(refused(&by_rows[1..]), "order: expected 1600 x 1, got 1599 x 1");
    let twice: Vec<usize> = (0..n).map(|i| i.max(1)).collect();
    assert_eq!(refused(&twice), "order: must have every row once, but entry 1 is 1");
    let beyond: Vec<usize> = (1..=n).collect();
    assert_eq!(refused(&beyond), "order: must have every row once, but entry 1599 is 1600");
}

#[test]
fn a_matrix_without_rows_has_solutions_without_rows() {
    let none = CsMat::<f64>::zero((0, 0));
    for semidefinite in [false, true] {
        let options = options().semidefinite(semidefinite);
        let cholesky = Cholesky::new(none.view(), &options).unwrap();
        let x = cholesky.solve(Mat::<f64>::zeros(0, 3).as_ref()).unwrap();
        assert_eq!(x.shape(), (0, 3));
        let rows = cholesky.solve_rows(Mat::<f64>::zeros(0, 3).as_ref(), &[]).unwrap();
        assert_eq!(rows.shape(), (0, 3));
        assert_eq!((cholesky.n(), cholesky.entries(), cholesky.weakest()), (0, 0, None));
    }
}

#[test]
fn later_factors_do_not_depend_on_what_earlier_ones_left() {
    let n = 149;
    let (first, mut second) = (random(n, 1, 1), random(n, 1, 1));
    second.data_mut().iter_mut().for_each(|x| *x *= 1.5);
    let mut negative = first.clone();
    negative.data_mut().iter_mut().for_each(|x| *x *= -1.0);
    let b = random_columns(n, 9, 4);
    let fresh =
        |a: &CsMat<f64>| Cholesky::new(a.view(), &options()).unwrap().solve(b.as_ref()).unwrap();
    let expected = [fresh(&first), fresh(&second)];
    assert_ne!(expected[0], expected[1]);
    let mut cholesky = Cholesky::analyse(first.view(), &options()).unwrap();
    assert!(!cholesky.is_factored());
    for (a, expected) in [(&first, &expected[0]), (&second, &expected[1]), (&first, &expected[0])] {
        cholesky.factor(a.view(), Progress::none()).unwrap();
        assert!(cholesky.is_factored());
        assert_eq!(&cholesky.solve(b.as_ref()).unwrap(), expected);
        // Fails in between.
        assert!(cholesky.factor(negative.view(), Progress::none()).is_err());
        assert!(!cholesky.is_factored() && cholesky.weakest().is_none());
        let refused = cholesky.solve(b.as_ref()).unwrap_err().to_string();
        assert!(refused.starts_with("A: not factorized"), "{refused}");
    }
}

#[test]
fn the_row_of_a_pivot_that_is_not_positive_is_named() {
    let n = 23;
    for wrong in [0, 7, 22] {
        for pivot in [-1.0, 0.0] {
            let a = sparse(n, (0..n).map(|i| (i, i, if i == wrong { pivot } else { 2.0 })));
            let refused = Cholesky::new(a.view(), &options()).unwrap_err();
            let expected = format!("(elimination fails at row {wrong})");
            assert!(matches!(refused, Error::Argument { what: "A", .. }));
            assert!(refused.to_string().contains(&expected), "{refused}");
            assert!(refused.to_string().contains("semidefinite"), "{refused}");
            let held = Cholesky::new(a.view(), &options().semidefinite(true));
            match pivot {
                0.0 => assert_eq!(held.unwrap().held(), [wrong]),
                _ => assert!(held.unwrap_err().to_string().contains(&expected)),
            }
        }
    }
    // Dense, so that all rows are in one supernode: the last pivot of each is that of the others.
    for n in [9, 40, 300] {
        let a = sparse(n, (0..n * n).map(|k| (k / n, k % n, f64::from(k / n == k % n) - 0.5)));
        let refused = Cholesky::new(a.view(), &options()).unwrap_err().to_string();
        assert!(refused.contains("not positive definite (elimination fails at row"), "{refused}");
        let refused = Cholesky::new(a.view(), &options().semidefinite(true)).unwrap_err();
        assert!(refused.to_string().contains("not positive semidefinite"), "{refused}");
    }
}

/// The matrix L D L^T of n rows with ones in the lower triangle L, and in D but for one pivot: all
/// numbers of its elimination are integers.
fn of_ones(n: usize, wrong: usize, pivot: f64) -> CsMat<f64> {
    let sum = |count: usize| count as f64 + if wrong < count { pivot - 1.0 } else { 0.0 };
    sparse(n, (0..n * n).map(|k| (k / n, k % n, sum((k / n).min(k % n) + 1))))
}

#[test]
fn the_first_wrong_pivot_of_a_dense_matrix_is_named_in_a_given_order() {
    // Up to 8 columns are factorized one by one, 256 in one supernode.
    for n in [3, 8, 9, 61, 300, 521] {
        let order: Vec<usize> = (0..n).collect();
        let options = options().order(&order[..]);
        for wrong in [0, n / 2, n - 1] {
            let named = |a: &CsMat<f64>, options: &CholeskyOptions<'_>| {
                let refused = Cholesky::new(a.view(), options).unwrap_err().to_string();
                let at = format!("(elimination fails at row {wrong})");
                assert!(refused.contains(&at), "n = {n}, row {wrong}: {refused}");
            };
            for pivot in [-3.0, -0.25, 0.0] {
                named(&of_ones(n, wrong, pivot), &options);
            }
            let semidefinite = options.clone().semidefinite(true);
            named(&of_ones(n, wrong, -0.25), &semidefinite);
            // Positive, and zero by the tolerance of the caller.
            if wrong > 0 {
                let small = of_ones(n, wrong, 1.0 / 4096.0);
                let cholesky = Cholesky::new(small.view(), &options).unwrap();
                assert_eq!(cholesky.weakest().unwrap().0, wrong);
                named(&small, &options.clone().tolerance(1e-3));
            }

            let a = of_ones(n, wrong, 0.0);
            let cholesky = Cholesky::new(a.view(), &semidefinite).unwrap();
            assert_eq!(cholesky.held(), [wrong], "n = {n}");
            let x = Mat::from_fn(n, 2, |i, j| if i == wrong { 0.0 } else { (i % 3 + j) as f64 });
            let found = cholesky.solve(product(&a, x.as_ref()).as_ref()).unwrap();
            assert_close(&found, &x, 1e-9, &format!("n = {n}, row {wrong}"));
        }
    }
}

#[test]
fn powers_of_four_scale_factors_of_singular_matrices_bit_for_bit() {
    let full = |n: usize| {
        let entry = |k: usize| if k / n == k % n { n as f64 - 1.0 } else { -1.0 };
        sparse(n, (0..n * n).map(|k| (k / n, k % n, entry(k))))
    };
    for a in [laplacian(401, 3, 2), full(7), full(40)] {
        let n = a.rows();
        let b = product(&a, random_columns(n, 3, 4).as_ref());
        let options = options().semidefinite(true);
        let expected = Cholesky::new(a.view(), &options).unwrap();
        let x = expected.solve(b.as_ref()).unwrap();
        for exponent in [-900, -2, 600, 1000] {
            let scale = 2f64.powi(exponent);
            let mut scaled = a.clone();
            scaled.scale(scale);
            let found = Cholesky::new(scaled.view(), &options).unwrap();
            assert_eq!(found.held(), expected.held(), "2^{exponent}");
            assert_eq!(found.weakest(), expected.weakest(), "2^{exponent}");
            let scaled = Mat::from_fn(n, 3, |i, j| b[(i, j)] * scale);
            assert_eq!(found.solve(scaled.as_ref()).unwrap(), x, "2^{exponent}");
        }
    }
    // An entry beside a zero pivot is not rounding at any scale.
    for scale in [1e-300, 1e-150, 1.0, 1e150, 1e300] {
        let entries = [(0, 2, scale), (2, 0, scale), (1, 1, scale), (2, 2, 2.0 * scale)];
        let a = sparse(3, entries);
        let refused = Cholesky::new(a.view(), &options().semidefinite(true)).unwrap_err();
        assert!(refused.to_string().contains("not positive semidefinite"), "{scale:e}: {refused}");
    }
}

#[test]
fn zero_pivots_beside_other_entries_are_not_semidefinite() {
    let swap = sparse(2, [(0, 1, 1.0), (1, 0, 1.0)]);
    let refused = Cholesky::new(swap.view(), &options().semidefinite(true)).unwrap_err();
    assert!(refused.to_string().contains("not positive semidefinite"), "{refused}");
    // Row 0 is 0 but for one entry, which is in another supernode or not.
    for n in [3, 30, 300] {
        let full = (0..n * n).map(|k| (k / n, k % n, f64::from(k / n == k % n) + 0.5));
        let full = full.filter(|(i, j, _)| *i > 0 && *j > 0);
        let a = sparse(n, full.chain([(0, n - 1, 1.0), (n - 1, 0, 1.0)]));
        let refused = Cholesky::new(a.view(), &options().semidefinite(true)).unwrap_err();
        assert!(refused.to_string().contains("not positive semidefinite"), "n = {n}: {refused}");
    }
}

#[test]
fn a_laplacian_holds_one_row_of_each_component_and_solves_what_can_be_solved() {
    for (n, blocks) in [(2, 1), (3, 3), (31, 1), (101, 2), (400, 7), (2003, 1), (2003, 5)] {
        let (w, what) = (laplacian(n, blocks, 6), format!("n = {n}, {blocks} components"));
        let options = options().semidefinite(true);
        let cholesky = Cholesky::new(w.view(), &options).unwrap();
        let held = cholesky.held();
        let mut components: Vec<usize> = held.iter().map(|row| row % blocks).collect();
        components.sort_unstable();
        assert_eq!(components, (0..blocks).collect::<Vec<_>>(), "{what}");
        assert!(held.is_sorted());
        let b = product(&w, random_columns(n, 3, 9).as_ref());
        let x = cholesky.solve(b.as_ref()).unwrap();
        assert_close(&product(&w, x.as_ref()), &b, 1e-11, &what);
        // No solution: the equations that are not held are solved.
        let ones = Mat::<f64>::ones(n, 1);
        let x = cholesky.solve(ones.as_ref()).unwrap();
        let residual = product(&w, x.as_ref()) - &ones;
        for i in 0..n {
            match held.contains(&i) {
                true => assert_eq!(x[(i, 0)], 0.0, "{what}"),
                false => {
                    let bound = 1e-12 * n as f64 * x.norm_max().max(1.0);
                    assert!(residual[(i, 0)].abs() < bound, "{what}: {}", residual[(i, 0)]);
                }
            }
        }
        let strict = Cholesky::new(w.view(), &options.clone().semidefinite(false).tolerance(1e-10));
        assert!(strict.is_err(), "{what}");
    }
    // Weights of integers, one supernode of many columns: exact zeros and rounding alike.
    for n in [2, 8, 9, 40, 300] {
        let full = sparse(
            n,
            (0..n * n).map(|k| (k / n, k % n, if k / n == k % n { n as f64 - 1.0 } else { -1.0 })),
        );
        let cholesky = Cholesky::new(full.view(), &options().semidefinite(true)).unwrap();
        assert_eq!(cholesky.held().len(), 1, "n = {n}");
        assert!(cholesky.weakest().is_none_or(|(_, ratio)| ratio > 1e-3), "n = {n}");
    }
}

#[test]
fn several_dependent_rows_of_one_supernode_are_held() {
    // The product of an n x rank matrix and its transpose.
    for (n, rank) in [(5, 2), (40, 13), (40, 40), (300, 170)] {
        let g = random_columns(n, rank, 12);
        let gram = &g * g.transpose();
        let place = |k: usize| (k / n, k % n);
        let a = sparse(n, (0..n * n).map(|k| (place(k).0, place(k).1, gram[place(k)])));
        let options = options().semidefinite(true).tolerance(1e-9);
        let cholesky = Cholesky::new(a.view(), &options).unwrap();
        assert_eq!(cholesky.held().len(), n - rank, "n = {n}");
        let b = product(&a, random_columns(n, 2, 13).as_ref());
        let x = cholesky.solve(b.as_ref()).unwrap();
        assert_close(&product(&a, x.as_ref()), &b, 1e-6, "of low rank");
    }
}

#[test]
fn selected_rows_are_those_of_all() {
    let (w, n) = (laplacian(1501, 3, 2), 1501);
    let cholesky = Cholesky::new(w.view(), &options().semidefinite(true)).unwrap();
    let held = cholesky.held()[0];
    for columns in [0, 1, 8, 11] {
        let b = random_columns(n, columns, 7);
        let all = cholesky.solve(b.as_ref()).unwrap();
        for rows in [vec![], vec![0], vec![n - 1, 5, 5, held, 700], (0..n).rev().collect()] {
            let found = cholesky.solve_rows(b.as_ref(), &rows).unwrap();
            let expected = Mat::from_fn(rows.len(), columns, |i, j| all[(rows[i], j)]);
            assert_eq!(found, expected);
        }
    }
    let refused = cholesky.solve_rows(Mat::<f64>::zeros(n, 1).as_ref(), &[3, n]).unwrap_err();
    let expected = "rows: row 1501 is out of range: 1501 rows, numbered from 0";
    assert_eq!(refused.to_string(), expected);
}

#[test]
fn arguments_at_fault_are_named() {
    let a = held_path(5);
    let of = |a: &CsMat<f64>, options: &CholeskyOptions<'_>| {
        Cholesky::new(a.view(), options).map(|_| ()).unwrap_err().to_string()
    };
    let flat = CsMat::<f64>::zero((2, 3));
    assert_eq!(of(&flat, &options()), "A: expected 2 x 2, got 2 x 3");
    for tolerance in [-1e-3, 0.02, f64::NAN] {
        let refused = of(&a, &options().tolerance(tolerance));
        assert!(refused.starts_with("tolerance: must be from 0 to 0.01, is "), "{refused}");
    }
    let mut wrong = a.clone();
    *wrong.get_mut(3, 2).unwrap() = f64::INFINITY;
    assert_eq!(of(&wrong, &options()), "A: not finite at row 3, column 2");
    *wrong.get_mut(3, 2).unwrap() = -2.0;
    assert!(of(&wrong, &options()).contains("not symmetric: entry (2, 3)"), "{wrong:?}");
    Cholesky::new(wrong.view(), &options().triangle(Triangle::Upper)).unwrap();

    let mut cholesky = Cholesky::new(a.view(), &options()).unwrap();
    let refused = cholesky.solve(Mat::<f64>::zeros(4, 2).as_ref()).unwrap_err().to_string();
    assert_eq!(refused, "B: expected 5 x 2, got 4 x 2");
    let mut b = Mat::<f64>::zeros(5, 2);
    b[(4, 1)] = f64::NAN;
    let refused = cholesky.solve(b.as_ref()).unwrap_err().to_string();
    assert_eq!(refused, "B: not finite at row 4, column 1");
    let refused = cholesky.factor(grid(5, 1).view(), Progress::none());
    assert!(refused.unwrap_err().to_string().contains("not positive definite"));
    let other = sparse(5, [(0, 4, 1.0), (4, 0, 1.0)]);
    let refused = cholesky.factor(other.view(), Progress::none()).unwrap_err().to_string();
    assert_eq!(refused, "A: entry (4, 0) is not in the pattern that was analysed");
}

#[test]
fn progress_ascends_to_one_and_a_stop_leaves_a_factorization_that_can_be_repeated() {
    let a = shifted_grid(80, 80);
    let told = Mutex::new(Vec::new());
    let stop = AtomicBool::new(false);
    let callback = |fraction: f64| {
        told.lock().unwrap().push(fraction);
        match stop.load(Ordering::Relaxed) && fraction > 0.5 {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        }
    };
    let options = options().progress(&callback);
    let mut cholesky = Cholesky::new(a.view(), &options).unwrap();
    let expected = cholesky.solve(Mat::<f64>::ones(6400, 1).as_ref()).unwrap();
    {
        let told = told.lock().unwrap();
        assert!(told.is_sorted() && told.len() > 10, "{told:?}");
        assert_eq!((told[0], told[told.len() - 1]), (0.0, 1.0));
    }
    stop.store(true, Ordering::Relaxed);
    let stopped = cholesky.factor(a.view(), Progress::new(&callback));
    assert_eq!(stopped, Err(Error::Cancelled));
    assert!(!cholesky.is_factored());
    assert_eq!(Cholesky::new(a.view(), &options).map(|_| ()), Err(Error::Cancelled));
    cholesky.factor(a.view(), Progress::none()).unwrap();
    assert_eq!(cholesky.solve(Mat::<f64>::ones(6400, 1).as_ref()).unwrap(), expected);
}
