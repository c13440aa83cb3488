//! A and C on one rank: AtA-D, and rows that are dealt.

use std::ops::ControlFlow;
use std::sync::Mutex;

use catamaran::base::{Progress, block_rows, triangle_len};
use catamaran::faer::{Mat, MatMut, MatRef};
use catamaran::ranks::plan::{Machine, TaskTree, row_shares};
use catamaran::ranks::{MpiReal, Traffic, World, ata_deal, ata_root, ata_tree};
use catamaran::{AtaOptions, Error, Par, Uplo};

use crate::matrices::{SHAPES, check_whole, expected, options, part};
use crate::{Case, Scene};

pub const CASES: &[Case] = &[
    ("root_has_any_shape_and_storage_f64", shapes::<f64>),
    ("root_has_any_shape_and_storage_f32", shapes::<f32>),
    ("root_adds_to_what_is_there", adds),
    ("root_sends_strided_views_in_short_messages", strided),
    ("root_communicates_as_planned_in_a_tree", tree_traffic),
    ("root_sends_every_row_once_at_most_when_it_deals", deal_traffic),
    ("root_deals_more_rows_than_a_block_has", many_blocks),
    ("root_gives_the_same_bits_every_time_for_any_number_of_threads", threads),
    ("root_tells_progress_up_to_the_end", progress),
];

pub const SCENES: &[Scene] = &[
    Scene {
        name: "a_tree_of_three_levels_gives_the_product",
        ranks: 36,
        starved: None,
        play: shapes::<f64>,
        printed: &[],
        succeeds: true,
    },
    Scene {
        name: "a_root_without_a_matrix_is_named_on_every_rank",
        ranks: 3,
        starved: None,
        play: without_matrix,
        printed: &["0: rank 1: A: missing on the root", "1: A: missing", "2: rank 1: A: missing"],
        succeeds: true,
    },
    Scene {
        name: "a_root_that_differs_or_does_not_exist_is_named",
        ranks: 2,
        starved: None,
        play: another_root,
        printed: &["0: rank 1: root is 1, where rank 0 has 0", "0: root: must be less than 2"],
        succeeds: true,
    },
    Scene {
        name: "a_result_of_another_shape_is_named_on_every_rank",
        ranks: 2,
        starved: None,
        play: another_shape,
        printed: &["0: C: expected 5 x 5, got 4 x 4", "1: rank 0: C: expected 5 x 5"],
        succeeds: true,
    },
    Scene {
        name: "a_rank_of_the_tree_that_cancels_ends_the_call_on_every_rank",
        ranks: 8,
        starved: None,
        play: cancel,
        printed: &["0: rank 5: cancelled", "5: cancelled", "7: rank 5: cancelled"],
        succeeds: true,
    },
    Scene {
        name: "a_rank_that_is_dealt_to_and_cancels_ends_the_call_on_every_rank",
        ranks: 8,
        starved: None,
        play: cancel_deal,
        printed: &["0: rank 5: cancelled", "5: cancelled", "7: rank 5: cancelled"],
        succeeds: true,
    },
    Scene {
        name: "a_killed_rank_of_the_tree_ends_the_job",
        ranks: 7,
        starved: None,
        play: killed,
        printed: &[],
        succeeds: false,
    },
    Scene {
        name: "a_rank_of_the_tree_that_panics_ends_the_job",
        ranks: 7,
        starved: None,
        play: panicking,
        printed: &["this rank panics"],
        succeeds: false,
    },
];

type Product<T> = fn(
    &World,
    usize,
    T,
    Option<MatRef<'_, T>>,
    T,
    Option<MatMut<'_, T>>,
    &AtaOptions<'_>,
) -> Result<(), Error>;

/// Every way; the first one is whichever should be faster.
fn products<T: MpiReal>() -> [Product<T>; 3] {
    [ata_root, ata_tree, ata_deal]
}

/// `alpha A^T A + beta C` of the integer matrix, from the last rank but one.
fn shapes<T: MpiReal>(world: &World) {
    let root = world.size().saturating_sub(2);
    let is_root = world.rank() == root;
    for (m, n) in SHAPES {
        let columns = part::<T>(0..m, 0..n);
        let rows = Mat::from_fn(n, m, |j, i| columns[(i, j)]);
        for (a, uplo, by_rows) in [
            (columns.as_ref(), Uplo::Lower, false),
            (rows.transpose(), Uplo::Upper, false),
            (columns.as_ref(), Uplo::Both, true),
            (rows.transpose(), Uplo::Lower, true),
            (columns.as_ref(), Uplo::Upper, true),
        ] {
            for product in products() {
                let mut c = Mat::<T>::from_fn(n, n, |_, _| T::from_f64(-77.0));
                let view = if by_rows { c.as_mut().transpose_mut() } else { c.as_mut() };
                let options = options().uplo(uplo);
                let (a, view) = (is_root.then_some(a), is_root.then_some(view));
                product(world, root, T::from_f64(2.0), a, T::ZERO, view, &options).unwrap();
                if is_root {
                    let c = if by_rows { c.as_ref().transpose() } else { c.as_ref() };
                    check_whole(c, 2.0, m, uplo);
                }
            }
        }
    }
}

fn adds(world: &World) {
    let is_root = world.rank() == 0;
    for (m, n) in SHAPES {
        let a = part::<f64>(0..m, 0..n);
        let old = |i: usize, j: usize| (i * 5 + j) as f64;
        for product in products() {
            let mut c = Mat::from_fn(n, n, old);
            // What others say about beta does not matter.
            let beta = if is_root { -3.0 } else { 0.0 };
            let (a, view) = (is_root.then_some(a.as_ref()), is_root.then_some(c.as_mut()));
            product(world, 0, 1.0, a, beta, view, &options()).unwrap();
            for j in 0..n {
                for i in 0..n {
                    let new = expected(1.0, m, i, j) - 3.0 * old(i, j);
                    let wanted = if is_root && i >= j { new } else { old(i, j) };
                    assert_eq!(c[(i, j)], wanted, "entry ({i}, {j}), m = {m}");
                }
            }
        }
    }
}

/// Every other row and column of larger matrices, from below.
fn strided(world: &World) {
    world.set_longest_message(100);
    let is_root = world.rank() == 0;
    for (m, n) in [(33, 21), (130, 70)] {
        let large = Mat::<f64>::from_fn(2 * m, 2 * n, |i, j| {
            if i % 2 == 1 && j % 2 == 0 {
                part::<f64>(m - 1 - i / 2..m - i / 2, j / 2..j / 2 + 1)[(0, 0)]
            } else {
                f64::NAN
            }
        });
        // SAFETY: every other row and column, from the last row up: all within the matrix.
        let a = unsafe {
            MatRef::from_raw_parts(
                large.as_ref().subrows(2 * m - 1, 1).as_ptr(),
                m,
                n,
                -2 * large.row_stride(),
                2 * large.col_stride(),
            )
        };
        for a in [a, part::<f64>(0..m, 0..n).as_ref()] {
            for product in products() {
                let mut c = Mat::from_fn(n, n, |_, _| -77.0);
                let (a, view) = (is_root.then_some(a), is_root.then_some(c.as_mut()));
                product(world, 0, 1.0, a, 0.0, view, &options()).unwrap();
                if is_root {
                    check_whole(c.as_ref(), 1.0, m, Uplo::Lower);
                }
            }
        }
    }
}

fn tree_traffic(world: &World) {
    for (m, n) in [(128, 96), (1, 50), (40, 3)] {
        let a = part::<f64>(0..m, 0..n);
        let mut c = Mat::zeros(n, n);
        let is_root = world.rank() == 0;
        world.take_traffic();
        let (a, c) = (is_root.then_some(a.as_ref()), is_root.then_some(c.as_mut()));
        ata_tree(world, 0, 1.0, a, 0.0, c, &options()).unwrap();
        let load = TaskTree::new(m, n, world.size()).loads()[world.rank()];
        let planned = Traffic {
            words_sent: load.words_sent as u64,
            words_received: load.words_received as u64,
            messages_sent: load.messages_sent as u64,
            messages_received: load.messages_received as u64,
        };
        assert_eq!(world.traffic(), planned, "{m} x {n}");
    }
}

fn deal_traffic(world: &World) {
    let (m, n) = (5000, 40);
    let a = part::<f64>(0..m, 0..n);
    let mut c = Mat::zeros(n, n);
    let is_root = world.rank() == 0;
    world.take_traffic();
    let (a, c) = (is_root.then_some(a.as_ref()), is_root.then_some(c.as_mut()));
    ata_deal(world, 0, 1.0, a, 0.0, c, &options()).unwrap();
    let parts = row_shares(world.size(), m, n, &Machine::default());
    let Traffic { words_sent, words_received, .. } = world.traffic();
    let sums = 2 * triangle_len(n);
    if is_root {
        let dealt = (m - parts[0].len()) * n;
        assert!((dealt..=dealt + sums).contains(&(words_sent as usize)), "{words_sent}");
        assert!(words_received as usize <= sums, "{words_received}");
    } else {
        let dealt = parts[world.rank()].len() * n;
        assert!((dealt..=dealt + sums).contains(&(words_received as usize)), "{words_received}");
        assert!(words_sent as usize <= sums, "{words_sent}");
    }
}

/// Three blocks for each rank, and one that is not whole.
fn many_blocks(world: &World) {
    // Blocks are large, and there is no more to be seen with many ranks.
    if world.size() > 2 {
        return;
    }
    let n = 4099;
    let m = world.size() * (3 * block_rows::<f64>(n, false) + 11);
    let a = Mat::<f64>::from_fn(m, n, |i, j| if i % n == j { 1.0 } else { 0.0 });
    let is_root = world.rank() == 0;
    let mut c = Mat::<f64>::zeros(n, n);
    let (a, view) = (is_root.then_some(a.as_ref()), is_root.then_some(c.as_mut()));
    ata_deal(world, 0, 1.0, a, 0.0, view, &options()).unwrap();
    if is_root {
        for j in 0..n {
            let times = (m - j).div_ceil(n);
            assert!((j..n).all(|i| c[(i, j)] == if i == j { times as f64 } else { 0.0 }));
        }
    }
}

fn threads(world: &World) {
    let (m, n) = (700, 500);
    let is_root = world.rank() == 0;
    let a = Mat::from_fn(m, n, |i, j| (i as f64 * 0.37 + j as f64).sin());
    for product in products() {
        let run = |par| {
            let options = AtaOptions::new().par(par);
            let mut c = Mat::zeros(n, n);
            let (a, view) = (is_root.then_some(a.as_ref()), is_root.then_some(c.as_mut()));
            product(world, 0, 0.3, a, 0.0, view, &options).unwrap();
            c
        };
        let once = run(Par::Seq);
        assert_eq!(once, run(Par::Threads(2)));
        assert_eq!(once, run(Par::Seq));
        if is_root {
            let mut c = Mat::zeros(n, n);
            catamaran::ata_into(0.3, a.as_ref(), 0.0, c.as_mut(), &options()).unwrap();
            let error = (&once - &c).norm_max();
            assert!(error <= 1e-12 * m as f64, "{error}");
        }
    }
}

fn progress(world: &World) {
    for product in products() {
        let seen = Mutex::new(Vec::new());
        let note = |fraction| {
            seen.lock().unwrap().push(fraction);
            ControlFlow::Continue(())
        };
        let options = options().progress(&note);
        let a = part::<f64>(0..300, 0..300);
        let mut c = Mat::zeros(300, 300);
        let is_root = world.rank() == 0;
        let (a, view) = (is_root.then_some(a.as_ref()), is_root.then_some(c.as_mut()));
        product(world, 0, 1.0, a, 0.0, view, &options).unwrap();
        let seen = seen.into_inner().unwrap();
        assert!(seen.is_sorted() && seen.last() == Some(&1.0), "{seen:?}");
    }
}

fn tell(world: &World, result: Result<(), Error>) {
    println!("{}: {}", world.rank(), result.unwrap_err());
}

fn without_matrix(world: &World) {
    let mut c = Mat::<f64>::zeros(5, 5);
    tell(world, ata_root(world, 1, 1.0, None, 0.0, Some(c.as_mut()), &options()));
}

fn another_root(world: &World) {
    let a = part::<f64>(0..5, 0..5);
    let mut c = Mat::<f64>::zeros(5, 5);
    for root in [world.rank(), 2] {
        tell(
            world,
            ata_root(world, root, 1.0, Some(a.as_ref()), 0.0, Some(c.as_mut()), &options()),
        );
    }
}

fn another_shape(world: &World) {
    let a = part::<f64>(0..5, 0..5);
    let mut c = Mat::<f64>::zeros(4, 4);
    tell(world, ata_root(world, 0, 1.0, Some(a.as_ref()), 0.0, Some(c.as_mut()), &options()));
}

/// The product of a matrix large enough for every rank, with this progress callback, by a tree.
fn product(world: &World, progress: &(dyn Fn(f64) -> ControlFlow<()> + Sync)) -> Result<(), Error> {
    product_by(ata_tree, world, progress)
}

fn product_by(
    product: Product<f64>,
    world: &World,
    progress: &(dyn Fn(f64) -> ControlFlow<()> + Sync),
) -> Result<(), Error> {
    let a = part::<f64>(0..600, 0..400);
    let mut c = Mat::<f64>::zeros(400, 400);
    let options = options().progress(Progress::new(progress));
    product(world, 0, 1.0, Some(a.as_ref()), 0.0, Some(c.as_mut()), &options)
}

fn cancel_deal(world: &World) {
    let flow = if world.rank() == 5 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
    tell(world, product_by(ata_deal, world, &|_| flow));
}

fn cancel(world: &World) {
    let own = world.rank();
    tell(
        world,
        product(world, &|_| {
            if own == 5 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        }),
    );
}

fn killed(world: &World) {
    if world.rank() == 6 {
        // SAFETY: ends this process, at once.
        unsafe { libc::raise(libc::SIGKILL) };
    }
    let _ = product(world, &|_| ControlFlow::Continue(()));
}

fn panicking(world: &World) {
    let own = world.rank();
    let _ = product(world, &|_| {
        if own == 1 { panic!("this rank panics") } else { ControlFlow::Continue(()) }
    });
}
