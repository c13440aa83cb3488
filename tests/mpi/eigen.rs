//! Eigenpairs of rows that are spread, beside the same on one process.

use std::ops::ControlFlow;
use std::ops::Range;

use catamaran::faer::Mat;
use catamaran::ranks::{World, eigs, gather_rows};
use catamaran::sparse::{self, CsMat, EigenOptions, Eigenpairs, Mass};
use catamaran::{Error, Par};

use crate::matrices::{tell, uneven};
use crate::{Case, Scene};

pub const CASES: &[Case] = &[
    ("spread_eigenpairs_agree_with_one_process", agreement),
    ("spread_eigenpairs_of_matrices_that_no_rank_holds", large),
    ("spread_eigenpairs_of_small_matrices", small),
    ("spread_eigenpairs_are_the_same_bits_for_any_number_of_threads", threads),
    ("matrices_that_do_not_fit_are_refused_and_named", refusals),
];

pub const SCENES: &[Scene] = &[
    Scene {
        name: "eigenpairs_that_one_rank_cancels_end_on_every_rank",
        ranks: 3,
        starved: None,
        play: cancel,
        printed: &["0: rank 1: cancelled", "1: cancelled", "2: rank 1: cancelled"],
        succeeds: true,
    },
    Scene {
        name: "ranks_that_want_other_eigenpairs_are_named",
        ranks: 2,
        starved: None,
        play: another_k,
        printed: &["0: rank 1: k is 4, where rank 0 has 3", "1: rank 1: k is 4"],
        succeeds: true,
    },
];

pub fn rows(matrix: &CsMat<f64>, span: Range<usize>) -> CsMat<f64> {
    let mut triplets = sprs::TriMat::new((span.len(), matrix.cols()));
    for i in span.clone() {
        for (j, &x) in matrix.outer_view(i).unwrap().iter() {
            triplets.add_triplet(i - span.start, j, x);
        }
    }
    triplets.to_csr()
}

fn mass_rows(mass: &Mass, span: Range<usize>) -> Mass {
    match mass {
        Mass::Lumped(masses) => Mass::Lumped(masses[span].to_vec()),
        Mass::Full(matrix) => Mass::Full(rows(matrix, span)),
    }
}

/// Two grids of a x a and b x b nodes side by side, with weights that differ a little.
pub fn two_grids(a: usize, b: usize) -> CsMat<f64> {
    let n = a * a + b * b;
    let mut triplets = sprs::TriMat::new((n, n));
    let mut edge = |i: usize, j: usize| {
        let weight = 1.0 + 0.01 * ((i * 7 + j * 3) % 5) as f64;
        for (i, j, x) in [(i, j, -weight), (j, i, -weight), (i, i, weight), (j, j, weight)] {
            triplets.add_triplet(i, j, x);
        }
    };
    for (first, side) in [(0, a), (a * a, b)] {
        for i in 0..side {
            for j in 0..side {
                let node = first + i * side + j;
                if j + 1 < side {
                    edge(node, node + 1);
                }
                if i + 1 < side {
                    edge(node, node + side);
                }
            }
        }
    }
    triplets.to_csr()
}

/// A square grid of `side` x `side` nodes whose opposite edges are joined.
fn torus(side: usize) -> CsMat<f64> {
    let n = side * side;
    let mut triplets = sprs::TriMat::new((n, n));
    for i in 0..n {
        let (row, col) = (i / side, i % side);
        for j in [row * side + (col + 1) % side, (row + 1) % side * side + col] {
            for (i, j, x) in [(i, j, -1.0), (j, i, -1.0), (i, i, 1.0), (j, j, 1.0)] {
                triplets.add_triplet(i, j, x);
            }
        }
    }
    triplets.to_csr()
}

/// Masses of 2 for each row.
fn lumped(w: &CsMat<f64>) -> Mass {
    Mass::Lumped(vec![2.0; w.rows()])
}

/// The identity less a tenth of `w`: positive definite for sums of rows below 10.
fn smoothed(w: &CsMat<f64>) -> CsMat<f64> {
    let mut triplets = sprs::TriMat::new(w.shape());
    for (&x, (i, j)) in w {
        triplets.add_triplet(i, j, f64::from(i == j) - 0.1 * x);
    }
    triplets.to_csr()
}

fn spread(world: &World, w: &CsMat<f64>, mass: &Mass, options: &EigenOptions<'_>) -> Eigenpairs {
    let own = uneven(w.rows(), world.size(), world.rank());
    let (own_rows, own_mass) = (rows(w, own.clone()), mass_rows(mass, own));
    eigs(world, own_rows.view(), &own_mass, options).unwrap()
}

/// Compares with one process, and looks at the vectors.
fn check(world: &World, w: &CsMat<f64>, mass: &Mass, options: &EigenOptions<'_>) {
    let expected = sparse::eigs(w.view(), mass, options).unwrap();
    let found = spread(world, w, mass, options);
    let (n, k) = (w.rows(), options.k);
    assert_eq!((found.values.len(), found.residuals.len()), (k, k));
    let largest = w.data().iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    for (i, (x, y)) in found.values.iter().zip(&expected.values).enumerate() {
        // Zero is known up to rounding of the entries.
        assert!((x - y).abs() <= 1e-10 * y.abs() + 1e-13 * largest, "{i}: {x} instead of {y}");
    }
    assert!(found.residuals.iter().all(|residual| *residual <= options.tolerance));
    let Some(v) = gather_rows(world, 0, found.vectors.as_ref()).unwrap() else { return };
    assert_eq!(v.shape(), (n, k));
    let (mut wv, mut mv) = (Mat::zeros(n, k), Mat::zeros(n, k));
    sparse::multiply(w.view(), v.as_ref(), wv.as_mut(), Par::Seq).unwrap();
    mass.multiply(v.as_ref(), mv.as_mut(), Par::Seq).unwrap();
    let gram = v.transpose() * &mv;
    for j in 0..k {
        for i in 0..k {
            assert!((gram[(i, j)] - f64::from(i == j)).abs() < 1e-11);
        }
        let gap = (wv.col(j) - faer::Scale(found.values[j]) * mv.col(j)).norm_l2();
        assert!(gap <= 1e-8 * (largest * mv.col(j).norm_l2()), "pair {j}: {gap:e}");
    }
}

fn options(k: usize) -> EigenOptions<'static> {
    EigenOptions::new().k(k).par(Par::Seq)
}

fn agreement(world: &World) {
    // Pairs of equal eigenvalues, and both kinds of mass.
    let w = torus(14);
    let near = options(9).shift(Some(0.7)).verify_count(true);
    for (mass, wanted) in [(lumped(&w), options(17)), (Mass::Full(smoothed(&w)), near)] {
        check(world, &w, &mass, &wanted);
    }
    // A shift that is an eigenvalue.
    check(world, &w, &lumped(&w), &options(9).shift(Some(0.0)));
    // Two components.
    let w = two_grids(17, 12);
    let counted = options(25).verify_count(true);
    check(world, &w, &Mass::identity(w.rows()), &counted);
}

/// Graphs of more vertices than every rank may hold.
fn large(world: &World) {
    let w = two_grids(50, 42);
    check(world, &w, &Mass::identity(w.rows()), &options(7));
    check(world, &w, &Mass::Full(smoothed(&w)), &options(7).shift(Some(0.05)));
}

fn small(world: &World) {
    let grids = two_grids(2, 1);
    for k in [0, 1, 4, 5] {
        check(world, &grids, &Mass::identity(5), &options(k));
    }
    check(world, &CsMat::zero((0, 0)), &Mass::identity(0), &options(0));
    check(world, &CsMat::zero((1, 1)), &Mass::Lumped(vec![2.0]), &options(1));
}

fn threads(world: &World) {
    let w = two_grids(20, 15);
    let mass = Mass::identity(w.rows());
    let run = |par| spread(world, &w, &mass, &options(12).par(par));
    let (one, two) = (run(Par::Seq), run(Par::Threads(2)));
    assert!(one.values == two.values && one.vectors == two.vectors);
}

fn refusals(world: &World) {
    let w = two_grids(3, 2);
    let n = w.rows();
    let own = uneven(n, world.size(), world.rank());
    let (part, mass) = (rows(&w, own.clone()), mass_rows(&Mass::identity(n), own.clone()));
    let too_many = eigs(world, part.view(), &mass, &options(n + 1)).unwrap_err();
    assert!(matches!(too_many, Error::Argument { what: "k", .. }), "{too_many}");
    // Every rank has all rows.
    if world.size() > 1 {
        let twice = eigs(world, w.view(), &Mass::identity(n), &options(1)).unwrap_err();
        assert!(matches!(twice, Error::Shape { what: "stiffness", .. }), "{twice}");
    }
    let negative = Mass::Lumped(own.clone().map(|i| if i == 4 { -1.0 } else { 1.0 }).collect());
    let refused = eigs(world, part.view(), &negative, &options(1)).unwrap_err();
    assert!(refused.to_string().contains("entry 4 is -1"), "{refused}");
    // The world is as good as before.
    eigs(world, part.view(), &mass, &options(1)).unwrap();
}

fn cancel(world: &World) {
    let second = world.rank() == 1;
    let progress = move |done| {
        if second && done > 0.1 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let w = two_grids(20, 15);
    let own = uneven(w.rows(), world.size(), world.rank());
    let (part, mass) = (rows(&w, own.clone()), mass_rows(&Mass::identity(w.rows()), own));
    let options = options(20).progress(&progress);
    tell(world, eigs(world, part.view(), &mass, &options).unwrap_err());
}

fn another_k(world: &World) {
    let w = two_grids(3, 2);
    let own = uneven(w.rows(), world.size(), world.rank());
    let (part, mass) = (rows(&w, own.clone()), mass_rows(&Mass::identity(w.rows()), own));
    tell(world, eigs(world, part.view(), &mass, &options(3 + world.rank())).unwrap_err());
}
