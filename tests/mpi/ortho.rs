//! Gram-Schmidt and Cholesky QR of rows that are spread, beside the same on one process.

use std::ops::ControlFlow;
use std::ops::Range;

use catamaran::base::Rng;
use catamaran::faer::{Mat, MatRef};
use catamaran::ortho::{self, GramSchmidtOptions};
use catamaran::ranks::{World, cholesky_qr, gather_rows, gram_schmidt};
use catamaran::sparse::{CsMat, Mass};
use catamaran::{Error, Par};

use crate::matrices::{tell, uneven};
use crate::{Case, Scene};

pub const CASES: &[Case] = &[
    ("spread_columns_become_orthonormal_as_on_one_process", agreement),
    ("spread_panels_give_the_same_bits_for_any_number_of_threads", threads),
    ("spread_cholesky_qr_agrees_with_one_process", cholesky),
    ("rows_come_together_in_the_order_of_the_ranks", gathering),
];

pub const SCENES: &[Scene] = &[
    Scene {
        name: "a_rank_with_a_nan_is_named_on_every_rank",
        ranks: 3,
        starved: None,
        play: nan,
        printed: &["0: rank 2: A: not finite at row 1", "1: rank 2: A: not finite", "2: A: not"],
        succeeds: true,
    },
    Scene {
        name: "a_mass_that_differs_from_its_transpose_on_another_rank_is_refused",
        ranks: 3,
        starved: None,
        play: asymmetric,
        printed: &["0: rank 1: mass: not symmetric: entry", "1: mass: not", "2: mass: not"],
        succeeds: true,
    },
    Scene {
        name: "a_mass_that_is_not_positive_is_named_by_its_row_of_all_ranks",
        ranks: 3,
        starved: None,
        play: negative,
        printed: &[
            "0: rank 1: mass: must be positive, but entry 8 is -1e0",
            "1: mass: must be positive, but entry 8 is -1e0",
            "2: rank 1: mass: must be positive, but entry 8 is -1e0",
        ],
        succeeds: true,
    },
    Scene {
        name: "gram_schmidt_that_one_rank_cancels_ends_on_every_rank",
        ranks: 2,
        starved: None,
        play: cancel,
        printed: &["0: rank 1: cancelled", "1: cancelled"],
        succeeds: true,
    },
    Scene {
        name: "columns_that_depend_are_refused_on_every_rank",
        ranks: 3,
        starved: None,
        play: dependent,
        printed: &["0: A: column 3 depends", "1: A: column 3 depends", "2: A: column 3 depends"],
        succeeds: true,
    },
];

/// Columns of which every fifth depends on those before it.
fn columns(n: usize, c: usize) -> Mat<f64> {
    let mut rng = Rng::new(7);
    let mut a = Mat::from_fn(n, c, |_, _| rng.uniform() - 0.5);
    for j in (4..c).step_by(5) {
        for i in 0..n {
            a[(i, j)] = a[(i, j - 1)] - 2.0 * a[(i, j - 4)];
        }
    }
    a
}

fn lumped(rows: Range<usize>) -> Mass {
    Mass::Lumped(rows.map(|i| 1.0 + 0.9 * (i as f64).sin()).collect())
}

/// Rows of a tridiagonal mass.
pub fn full(n: usize, rows: Range<usize>) -> Mass {
    let mut triplets = sprs::TriMat::new((rows.len(), n));
    for i in rows.clone() {
        triplets.add_triplet(i - rows.start, i, 2.0 + (i as f64).cos());
        (i + 1 < n).then(|| triplets.add_triplet(i - rows.start, i + 1, 0.3));
        (i > 0).then(|| triplets.add_triplet(i - rows.start, i - 1, 0.3));
    }
    let matrix: CsMat<f64> = triplets.to_csr();
    Mass::Full(matrix)
}

fn entries(x: MatRef<'_, f64>) -> impl Iterator<Item = f64> + '_ {
    x.col_iter().flat_map(|column| column.iter().copied())
}

/// The largest difference.
fn gap(x: MatRef<'_, f64>, y: MatRef<'_, f64>) -> f64 {
    assert_eq!(x.shape(), y.shape());
    entries(x).zip(entries(y)).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max)
}

/// The largest entry of `|Q^T M Q - I|`.
fn defect(q: MatRef<'_, f64>, mass: &Mass) -> f64 {
    let mut weighted = Mat::zeros(q.nrows(), q.ncols());
    mass.multiply(q, weighted.as_mut(), Par::Seq).unwrap();
    gap((q.transpose() * &weighted).as_ref(), Mat::identity(q.ncols(), q.ncols()).as_ref())
}

/// Checks that all ranks have the same bits.
fn check_same(world: &World, x: MatRef<'_, f64>) {
    let own = Mat::from_fn(1, x.nrows() * x.ncols(), |_, i| x[(i % x.nrows(), i / x.nrows())]);
    if let Some(all) = gather_rows(world, 0, own.as_ref()).unwrap() {
        assert!((0..all.ncols()).all(|j| all.col(j).iter().all(|x| *x == all[(0, j)])));
    }
}

fn agreement(world: &World) {
    for (n, c) in [(0, 3), (5, 0), (1, 1), (7, 3), (3, 7), (127, 31), (300, 270)] {
        let own = uneven(n, world.size(), world.rank());
        let a = columns(n, c);
        let [once, again] =
            [GramSchmidtOptions::single_pass(), GramSchmidtOptions::reorthogonalized()];
        let lumped = (lumped(0..n), lumped(own.clone()));
        let full = (full(n, 0..n), full(n, own.clone()));
        for (mode, (mass, part)) in [(once, full), (again, lumped)] {
            let options = mode.par(Par::Seq);
            let expected = ortho::gram_schmidt(a.as_ref(), &mass, &options).unwrap();
            let rows = a.as_ref().subrows(own.start, own.len());
            let found = gram_schmidt(world, rows, &part, &options).unwrap();
            assert_eq!(found.kept, expected.kept);
            assert!(gap(found.r.as_ref(), expected.r.as_ref()) < 1e-11);
            check_same(world, found.r.as_ref());
            let Some(q) = gather_rows(world, 0, found.q.as_ref()).unwrap() else { continue };
            assert!(gap(q.as_ref(), expected.q.as_ref()) < 1e-9);
            let allowed = if options.reorthogonalize { 1e-12 } else { 1e-9 };
            assert!(defect(q.as_ref(), &mass) <= allowed);
        }
    }
}

fn threads(world: &World) {
    let (n, c) = (3000, 40);
    let own = uneven(n, world.size(), world.rank());
    let a = columns(n, c);
    let run = |par| {
        let options = GramSchmidtOptions::reorthogonalized().par(par);
        let rows = a.as_ref().subrows(own.start, own.len());
        gram_schmidt(world, rows, &lumped(own.clone()), &options).unwrap()
    };
    let (one, two) = (run(Par::Seq), run(Par::Threads(2)));
    assert!(one.q == two.q && one.r == two.r);
}

fn cholesky(world: &World) {
    for (n, c) in [(0, 0), (1, 1), (127, 31), (300, 130)] {
        let own = uneven(n, world.size(), world.rank());
        let mut rng = Rng::new(3);
        // Columns of very different lengths, 10^-200 to 10^200.
        let scale = |j: usize| 10f64.powi(50 * (j as i32 % 9 - 4));
        let a = Mat::from_fn(n, c, |_, j| (rng.uniform() - 0.5) * scale(j));
        for (mass, part) in
            [(lumped(0..n), lumped(own.clone())), (full(n, 0..n), full(n, own.clone()))]
        {
            let mut whole = a.clone();
            let expected = ortho::cholesky_qr(whole.as_mut(), &mass, Par::Seq).unwrap();
            let mut rows = a.as_ref().subrows(own.start, own.len()).to_owned();
            let r = cholesky_qr(world, rows.as_mut(), &part, Par::Seq).unwrap();
            let size = expected.norm_max().max(1.0);
            assert!(gap(r.as_ref(), expected.as_ref()) < 1e-11 * size);
            check_same(world, r.as_ref());
            let Some(q) = gather_rows(world, 0, rows.as_ref()).unwrap() else { continue };
            assert!(gap(q.as_ref(), whole.as_ref()) < 1e-9);
            assert!(defect(q.as_ref(), &mass) < 1e-12);
        }
    }
}

fn gathering(world: &World) {
    for (n, c) in [(0, 2), (3, 0), (1, 1), (31, 3)] {
        let own = uneven(n, world.size(), world.rank());
        let rows = Mat::from_fn(own.len(), c, |i, j| ((own.start + i) * 10 + j) as f64);
        let root = world.size() / 2;
        let all = gather_rows(world, root, rows.as_ref()).unwrap();
        assert_eq!(all.is_some(), world.rank() == root);
        let expected = Mat::from_fn(n, c, |i, j| (i * 10 + j) as f64);
        assert!(all.is_none_or(|all| all == expected));
    }
    let refused = gather_rows(world, world.size(), Mat::zeros(1, 1).as_ref()).unwrap_err();
    assert!(matches!(refused, Error::Argument { what: "root", .. }));
}

/// Six rows on each rank.
fn own_rows(world: &World) -> Range<usize> {
    6 * world.rank()..6 * world.rank() + 6
}

fn nan(world: &World) {
    let own = own_rows(world);
    let bad = world.rank() == 2;
    let a = Mat::from_fn(6, 2, |i, _| if bad && i == 1 { f64::NAN } else { i as f64 });
    let options = GramSchmidtOptions::reorthogonalized();
    tell(world, gram_schmidt(world, a.as_ref(), &lumped(own.clone()), &options).unwrap_err());
    // The world is as good as before.
    let a = columns(6 * world.size(), 3);
    let rows = a.as_ref().subrows(own.start, 6);
    gram_schmidt(world, rows, &lumped(own), &options).unwrap();
}

fn asymmetric(world: &World) {
    let (own, n) = (own_rows(world), 6 * world.size());
    let Mass::Full(mut matrix) = full(n, own.clone()) else { return };
    if world.rank() == 2 {
        // Its mirror image is the last row of rank 1.
        *matrix.get_mut(0, 11).unwrap() = 0.4;
    }
    let a = Mat::from_fn(6, 2, |i, j| (i + j) as f64);
    let options = GramSchmidtOptions::single_pass();
    let mass = Mass::Full(matrix);
    tell(world, gram_schmidt(world, a.as_ref(), &mass, &options).unwrap_err());
}

/// Entry 2 of the masses of rank 1 is negative.
fn negative(world: &World) {
    let own = own_rows(world);
    let mass = |i: usize| if i == 8 { -1.0 } else { 1.0 };
    let mass = Mass::Lumped(own.map(mass).collect());
    let a = Mat::from_fn(6, 2, |i, j| (i + j) as f64);
    let options = GramSchmidtOptions::single_pass();
    tell(world, gram_schmidt(world, a.as_ref(), &mass, &options).unwrap_err());
}

fn cancel(world: &World) {
    let last = world.rank() == 1;
    let progress = move |_| if last { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
    let own = own_rows(world);
    let a = columns(6 * world.size(), 3);
    let options = GramSchmidtOptions::single_pass().progress(&progress);
    let rows = a.as_ref().subrows(own.start, 6);
    tell(world, gram_schmidt(world, rows, &lumped(own), &options).unwrap_err());
}

fn dependent(world: &World) {
    let own = own_rows(world);
    let mut rows = Mat::from_fn(6, 5, |i, j| {
        let x = (own.start + i) as f64;
        match j {
            3 => x.sin() + 1.0,
            _ => [1.0, x.sin(), x.cos(), 0.0, (2.0 * x).sin()][j],
        }
    });
    tell(world, cholesky_qr(world, rows.as_mut(), &lumped(own), Par::Seq).unwrap_err());
}
