//! Block-cyclic A and C.

use catamaran::faer::Mat;
use catamaran::ranks::plan::{BlockCyclic, Grid, GridOrder};
use catamaran::ranks::{CyclicMut, CyclicRef, MpiReal, World, aat_cyclic, ata_cyclic};
use catamaran::{AtaOptions, Par, Real, Uplo};

use crate::matrices::{SHAPES, entry, expected, options};
use crate::{Case, Scene};

pub const CASES: &[Case] = &[
    ("cyclic_of_any_shape_f64", shapes::<f64>),
    ("cyclic_of_any_shape_f32", shapes::<f32>),
    ("cyclic_in_short_messages", short_messages),
    ("cyclic_transposed", transposed),
    ("cyclic_words_are_those_of_the_plan", traffic),
    ("cyclic_gives_the_same_bits_for_any_number_of_threads", threads),
];

pub const SCENES: &[Scene] = &[
    Scene {
        name: "a_rank_with_another_block_is_named",
        ranks: 3,
        starved: None,
        play: another_block,
        printed: &[
            "0: rank 1: NB_ of C is 3, where rank 0 has 2, C untouched",
            "1: rank 1: NB_ of C is 3, where rank 0 has 2, C untouched",
            "2: rank 1: NB_ of C is 3, where rank 0 has 2, C untouched",
        ],
        succeeds: true,
    },
    Scene {
        name: "a_grid_larger_than_the_world_is_refused",
        ranks: 2,
        starved: None,
        play: large_grid,
        printed: &["0: grid: 2 x 2 needs more than the 2 ranks there are", "1: grid: 2 x 2"],
        succeeds: true,
    },
    Scene {
        name: "a_part_of_a_transposed_matrix_is_named_in_the_shape_that_was_given",
        ranks: 1,
        starved: None,
        play: another_part,
        printed: &["0: this rank's part of A: expected 7 x 9, got 9 x 7"],
        succeeds: true,
    },
];

/// What C holds at first: symmetric.
fn old(i: usize, j: usize) -> f64 {
    ((i + j) % 5) as f64 - 7.0
}

/// The part of this rank of a matrix.
fn local<T: Real>(
    world: &World,
    matrix: &BlockCyclic,
    entry: impl Fn(usize, usize) -> T,
) -> Mat<T> {
    let (rows, cols) = matrix.local_shape(world.rank());
    let (row, col) = matrix.grid().place(world.rank()).unwrap_or((0, 0));
    Mat::from_fn(rows, cols, |i, j| {
        entry(matrix.rows().global(row, i), matrix.cols().global(col, j))
    })
}

/// The largest grids of about the form of a square, a row and a column, and a smaller one.
fn grids(world: &World) -> Vec<Grid> {
    let ranks = world.size();
    let side = (1..=ranks).rev().find(|d| d * d <= ranks).unwrap_or(1);
    vec![
        Grid::new(side, ranks / side, GridOrder::Rows).unwrap(),
        Grid::new(1, ranks, GridOrder::Columns).unwrap(),
        Grid::new(ranks, 1, GridOrder::Rows).unwrap(),
        Grid::new(ranks.div_ceil(2), 1, GridOrder::Columns).unwrap(),
    ]
}

/// Checks what this rank has of C; what is not wanted holds its old entries still.
fn check<T: Real>(
    world: &World,
    matrix: &BlockCyclic,
    c: &Mat<T>,
    uplo: Uplo,
    value: impl Fn(usize, usize) -> f64,
) {
    let should_be = local(world, matrix, |i, j| {
        let wanted = match uplo {
            Uplo::Lower => i >= j,
            Uplo::Upper => i <= j,
            Uplo::Both => true,
        };
        T::from_f64(if wanted { value(i, j) } else { old(i, j) })
    });
    assert!(*c == should_be, "{matrix:?} {uplo:?}\n{c:?}\n{should_be:?}");
}

fn shapes<T: MpiReal>(world: &World) {
    let uplos = [Uplo::Lower, Uplo::Upper, Uplo::Both];
    let blocks = [(1, 1), (2, 3), (5, 2), (64, 64)];
    for (k, (m, n)) in SHAPES.into_iter().enumerate() {
        for (g, grid) in grids(world).into_iter().enumerate() {
            let block = blocks[(k + g) % blocks.len()];
            let first = (grid.rows() - 1, grid.cols() / 2);
            let a = BlockCyclic::new("A", (m, n), block, first, grid).unwrap();
            // C has other blocks and another first process than A.
            let block = blocks[(k + g + 1) % blocks.len()];
            let c = BlockCyclic::new("C", (n, n), block, (0, grid.cols() - 1), grid).unwrap();
            let (uplo, beta) = (uplos[(k + g) % 3], [0.0, 1.0, -2.0][(k + 2 * g) % 3]);
            let a_entries = local(world, &a, entry::<T>);
            let mut c_entries = local(world, &c, |i, j| T::from_f64(old(i, j)));
            ata_cyclic(
                world,
                T::from_f64(2.0),
                CyclicRef { matrix: a, entries: a_entries.as_ref() },
                T::from_f64(beta),
                CyclicMut { matrix: c, entries: c_entries.as_mut() },
                &options().uplo(uplo),
            )
            .unwrap();
            check(world, &c, &c_entries, uplo, |i, j| {
                expected(2.0, m, i.max(j), i.min(j)) + beta * old(i, j)
            });
        }
    }
}

fn short_messages(world: &World) {
    world.set_longest_message(100);
    shapes::<f64>(world);
}

/// A A^T of the transposed matrix, on a grid of its own, with C row by row and not read.
fn transposed(world: &World) {
    for (m, n) in SHAPES {
        let [grid, c_grid, ..] = grids(world)[..] else { unreachable!("four grids") };
        let a = BlockCyclic::new("A", (n, m), (3, 2), (0, 0), grid).unwrap();
        let c = BlockCyclic::new("C", (n, n), (2, 4), (0, 0), c_grid).unwrap();
        let entries = local(world, &a, |i, j| entry::<f64>(j, i));
        let (rows, cols) = c.local_shape(world.rank());
        let mut by_rows = Mat::from_fn(cols, rows, |_, _| f64::NAN);
        aat_cyclic(
            world,
            1.0,
            CyclicRef { matrix: a, entries: entries.as_ref() },
            0.0,
            CyclicMut { matrix: c, entries: by_rows.as_mut().transpose_mut() },
            &options().uplo(Uplo::Both),
        )
        .unwrap();
        check(world, &c, &by_rows.transpose().to_owned(), Uplo::Both, |i, j| {
            expected(1.0, m, i.max(j), i.min(j))
        });
    }
}

fn traffic(world: &World) {
    let (m, n, ranks) = (1200, 60, world.size() as f64);
    let grid = grids(world)[0];
    let a = BlockCyclic::new("A", (m, n), (8, 8), (0, 0), grid).unwrap();
    let c = BlockCyclic::new("C", (n, n), (8, 8), (0, 0), grid).unwrap();
    let a_entries = local(world, &a, entry::<f64>);
    let mut c_entries = local(world, &c, |_, _| 0.0);
    world.take_traffic();
    ata_cyclic(
        world,
        1.0,
        CyclicRef { matrix: a, entries: a_entries.as_ref() },
        0.0,
        CyclicMut { matrix: c, entries: c_entries.as_mut() },
        &options(),
    )
    .unwrap();
    let seen = world.traffic();
    // A stays in its row of the grid but for a few rows, C is reduced and delivered.
    let held = (a_entries.nrows() * a_entries.ncols()) as f64;
    let (n, columns) = (n as f64, grid.cols() as f64);
    let triangle = n * (n + 1.0) / 2.0;
    let spare = 16.0 * n;
    let a_words = held * (1.0 - 1.0 / columns) + spare;
    let c_words = triangle * (1.0 - 1.0 / ranks) + triangle / ranks + spare;
    if grid.size() == world.size() {
        assert!(seen.words_sent as f64 <= a_words + c_words, "{seen:?}, {a_words} + {c_words}");
    }
    assert!(world.size() > 1 || seen.words_sent == 0);
}

fn threads(world: &World) {
    let (m, n) = (700, 300);
    let grid = grids(world)[0];
    let a = BlockCyclic::new("A", (m, n), (32, 32), (0, 0), grid).unwrap();
    let c = BlockCyclic::new("C", (n, n), (32, 32), (0, 0), grid).unwrap();
    let entries = local(world, &a, |i, j| (i as f64 * 0.37 + j as f64).sin());
    let run = |par| {
        let mut result = local(world, &c, |_, _| 0.0);
        ata_cyclic(
            world,
            0.3,
            CyclicRef { matrix: a, entries: entries.as_ref() },
            0.0,
            CyclicMut { matrix: c, entries: result.as_mut() },
            &AtaOptions::new().par(par),
        )
        .unwrap();
        result
    };
    assert!(run(Par::Seq) == run(Par::Threads(2)));
}

fn tell(world: &World, grid: Grid, block_of_c: usize) {
    let a = BlockCyclic::new("A", (9, 7), (2, 2), (0, 0), grid).unwrap();
    let c = BlockCyclic::new("C", (7, 7), (2, block_of_c), (0, 0), grid).unwrap();
    let a_entries = local(world, &a, entry::<f64>);
    let mut c_entries = local(world, &c, old);
    let error = ata_cyclic(
        world,
        1.0,
        CyclicRef { matrix: a, entries: a_entries.as_ref() },
        0.0,
        CyclicMut { matrix: c, entries: c_entries.as_mut() },
        &options(),
    )
    .unwrap_err();
    assert!(c_entries == local(world, &c, old));
    println!("{}: {error}, C untouched", world.rank());
}

fn another_block(world: &World) {
    let block = if world.rank() == 1 { 3 } else { 2 };
    tell(world, Grid::new(1, 3, GridOrder::Rows).unwrap(), block);
}

/// A is 7 x 9, and its part is 9 x 7.
fn another_part(world: &World) {
    let grid = Grid::new(1, 1, GridOrder::Rows).unwrap();
    let a = BlockCyclic::new("A", (7, 9), (2, 2), (0, 0), grid).unwrap();
    let c = BlockCyclic::new("C", (7, 7), (2, 2), (0, 0), grid).unwrap();
    let (a_entries, mut c_entries) = (Mat::zeros(9, 7), local(world, &c, old));
    let error = aat_cyclic(
        world,
        1.0,
        CyclicRef { matrix: a, entries: a_entries.as_ref() },
        0.0,
        CyclicMut { matrix: c, entries: c_entries.as_mut() },
        &options(),
    )
    .unwrap_err();
    println!("{}: {error}", world.rank());
}

fn large_grid(world: &World) {
    tell(world, Grid::new(2, 2, GridOrder::Rows).unwrap(), 2);
}
