//! Mode (c): some rows of some columns of A on every rank.

use catamaran::faer::Mat;
use catamaran::ranks::plan::{Bricks, Machine, Mode, lower_bound, predict};
use catamaran::ranks::{Distributed, MpiReal, World, ata_bricks, ata_columns, verify};
use catamaran::rows::{DenseRows, RowOptions};
use catamaran::{AtaOptions, Par, Real, Uplo};

use crate::matrices::{SHAPES, check, options, part, tell, uneven};
use crate::{Case, Scene};

pub const CASES: &[Case] = &[
    ("bricks_of_any_shape_f64", shapes::<f64>),
    ("bricks_of_any_shape_f32", shapes::<f32>),
    ("bricks_in_many_pieces_and_short_messages", many_pieces),
    ("bricks_send_the_words_of_the_plan", traffic),
    ("bricks_give_the_same_bits_for_any_number_of_threads", threads),
    ("exact_bricks_and_columns_have_the_bits_of_rows", exact),
    ("wrong_sums_of_bricks_are_found", verified),
];

pub const SCENES: &[Scene] = &[
    many("bricks_on_16_ranks", 16),
    many("bricks_on_21_ranks", 21),
    many("bricks_on_36_ranks", 36),
    many("bricks_on_64_ranks", 64),
    Scene {
        name: "another_brick_than_the_planned_one_is_refused",
        ranks: 3,
        starved: None,
        play: another_brick,
        printed: &[
            "0: rank 1: this rank's part of A",
            "1: this rank's part of A",
            "2: rank 1: this rank's part of A",
        ],
        succeeds: true,
    },
];

/// A product on more ranks than there are cores.
const fn many(name: &'static str, ranks: usize) -> Scene {
    let printed = &["words as planned, below grid and rows"];
    Scene { name, ranks, starved: None, play: on_many_ranks, printed, succeeds: true }
}

/// Bricks in every form that the ranks allow, and those that are planned.
fn all_bricks(world: &World, m: usize, n: usize) -> Vec<Bricks> {
    let ranks = world.size();
    let counts = (1..=ranks).flat_map(|columns| (1..=ranks / columns).map(move |s| (columns, s)));
    let named = counts.map(|(c, s)| Bricks::with_counts(ranks, (m, n), c, s).unwrap());
    named.chain([Bricks::new(ranks, m, n)]).collect()
}

/// The brick of this rank.
fn own<T: Real>(world: &World, bricks: &Bricks) -> Mat<T> {
    part(bricks.rows(world.rank()), bricks.columns(world.rank()))
}

fn shapes<T: MpiReal>(world: &World) {
    for (k, (m, n)) in SHAPES.into_iter().enumerate() {
        // Every third form, others for each shape.
        for bricks in all_bricks(world, m, n).into_iter().skip(k % 3).step_by(3) {
            let brick = own::<T>(world, &bricks);
            let alpha = T::from_f64(2.0);
            let c = ata_bricks(world, alpha, &bricks, brick.as_ref(), &options()).unwrap();
            check(world, &c, 2.0, m);
        }
        // Row-major views.
        let bricks = Bricks::new(world.size(), m, n);
        let brick = own::<T>(world, &bricks);
        let transposed = Mat::from_fn(brick.ncols(), brick.nrows(), |j, i| brick[(i, j)]);
        let c = ata_bricks(world, T::ONE, &bricks, transposed.transpose(), &options()).unwrap();
        check(world, &c, 1.0, m);
    }
}

fn many_pieces(world: &World) {
    let (m, n, ranks) = (2100, 40, world.size());
    world.set_longest_message(1000);
    // Slices of several pieces.
    let bricks = Bricks::with_counts(ranks, (m, n), (ranks / 2).max(1), ranks.min(2)).unwrap();
    let brick = own::<f64>(world, &bricks);
    let c = ata_bricks(world, 1.0, &bricks, brick.as_ref(), &options()).unwrap();
    check(world, &c, 1.0, m);
}

/// Computes a product, and checks the words of this rank against the plan.
fn counted(world: &World, bricks: &Bricks) -> u64 {
    let brick = own::<f64>(world, bricks);
    world.take_traffic();
    let c = ata_bricks(world, 1.0, bricks, brick.as_ref(), &options()).unwrap();
    let seen = world.traffic();
    let (sent, received) = bricks.words(world.rank());
    assert_eq!((seen.words_sent, seen.words_received), (sent as u64, received as u64));
    check(world, &c, 1.0, bricks.m());
    seen.words_sent
}

fn traffic(world: &World) {
    for (m, n) in [(66, 66), (100, 42), (20, 101)] {
        all_bricks(world, m, n).iter().for_each(|bricks| _ = counted(world, bricks));
    }
}

fn on_many_ranks(world: &World) {
    let (ranks, n) = (world.size(), 168);
    let bricks = Bricks::new(ranks, n, n);
    let words = counted(world, &bricks) as f64;
    let planned = |mode| predict(mode, ranks, n, n, &Machine::default()).words;
    // Sides that can't be divided evenly, and parts of sums that are a word longer.
    assert!(words <= 1.01 * planned(Mode::Bricks) + 1.0, "{words}");
    assert!(words < 0.8 * planned(Mode::Rows).min(planned(Mode::Columns)), "{words}");
    let least = lower_bound(ranks, n, n).words;
    assert!(words <= 1.35 * least, "{words} words, at least {least}");
    if world.rank() == 0 {
        println!("{words} words as planned, below grid and rows");
    }
}

fn threads(world: &World) {
    let (m, n) = (700, 300);
    let bricks = Bricks::new(world.size(), m, n);
    let [rows, columns] = [bricks.rows(world.rank()), bricks.columns(world.rank())];
    let entry = |i: usize, j: usize| (rows.start + i) as f64 * 0.37 + (columns.start + j) as f64;
    let a = Mat::from_fn(rows.len(), columns.len(), |i, j| entry(i, j).sin());
    let run = |par| {
        let options = AtaOptions::new().par(par);
        ata_bricks(world, 0.3, &bricks, a.as_ref(), &options).unwrap().entries().to_vec()
    };
    assert_eq!(run(Par::Seq), run(Par::Threads(2)));
}

fn exact(world: &World) {
    exact_of::<f64>(world);
    exact_of::<f32>(world);
}

fn exact_of<T: MpiReal>(world: &World) {
    // More rows than a piece has.
    let (m, n) = (600, 23);
    let entry = |i: usize, j: usize| match (i, j) {
        (3, 4) => T::from_f64(f64::NAN),
        (5 | 560, 7) => T::from_f64(f64::INFINITY),
        (_, 9) => T::ZERO,
        _ => T::from_f64((i as f64 * 0.37 + j as f64).sin() * (j as f64).exp2()),
    };
    let options = AtaOptions::new().reproducible(true).uplo(Uplo::Both);
    let mut expected = Mat::from_fn(n, n, |_, _| T::ZERO);
    let (all, alpha) = (Mat::from_fn(m, n, entry), T::from_f64(0.3));
    let (rows, row_options) = (&mut DenseRows(all.as_ref()), RowOptions::new());
    catamaran::rows::ata_rows(alpha, rows, &row_options, T::ZERO, expected.as_mut(), &options)
        .unwrap();
    let compare = |i: usize, first: usize, entries: &[T]| {
        for (j, value) in (first..).zip(entries) {
            let (found, expected): (f64, f64) = (value.to_f64(), expected[(i, j)].to_f64());
            let same = found.to_bits() == expected.to_bits() || found.is_nan() && expected.is_nan();
            assert!(same, "entry ({i}, {j}): {found:e}, not {expected:e}");
        }
    };
    for bricks in all_bricks(world, m, n) {
        let [rows, columns] = [bricks.rows(world.rank()), bricks.columns(world.rank())];
        let brick = Mat::from_fn(rows.len(), columns.len(), |i, j| {
            entry(rows.start + i, columns.start + j)
        });
        let c = ata_bricks(world, alpha, &bricks, brick.as_ref(), &options).unwrap();
        c.for_each_segment(compare);
    }
    let columns = uneven(n, world.size(), world.rank());
    let own = Mat::from_fn(m, columns.len(), |i, j| entry(i, columns.start + j));
    ata_columns(world, alpha, own.as_ref(), &options).unwrap().for_each_segment(compare);
}

fn verified(world: &World) {
    let (m, n) = (2050, 40);
    for bricks in all_bricks(world, m, n).into_iter().step_by(3) {
        let mut brick = own::<f64>(world, &bricks);
        let c = ata_bricks(world, 0.5, &bricks, brick.as_ref(), &options()).unwrap();
        let found = |brick: &Mat<f64>| {
            let a = Distributed::Bricks(brick.as_ref(), &bricks);
            verify(world, 0.5, a, &c, 20, 7).unwrap().passed
        };
        assert!(found(&brick), "{bricks:?}");
        // The last row of the last brick is another one.
        if world.rank() + 1 == bricks.used() {
            let last = (brick.nrows() - 1, brick.ncols() - 1);
            brick[last] += 1.0;
        }
        assert!(!found(&brick), "{bricks:?}");
    }
}

fn another_brick(world: &World) {
    let bricks = Bricks::with_counts(3, (9, 6), 3, 1).unwrap();
    let width = if world.rank() == 1 { 3 } else { 2 };
    let brick = Mat::<f64>::zeros(9, width);
    let error = ata_bricks(world, 1.0, &bricks, brick.as_ref(), &options()).unwrap_err();
    tell(world, error);
}
