//! Mode (a): rows of A on every rank.

use catamaran::base::triangle_len;
use catamaran::faer::Mat;
use catamaran::ranks::{MpiReal, World, agree_bounds, ata_rows, merge_accumulators, sum_symmetric};
use catamaran::rows::{Accumulator, DenseRows, RowBounds, RowOptions, stream};
use catamaran::{AtaOptions, Par, Uplo};

use crate::Case;
use crate::matrices::{SHAPES, check, expected, options, part, uneven};

pub const CASES: &[Case] = &[
    ("rows_of_any_shape_f64", shapes::<f64>),
    ("rows_of_any_shape_f32", shapes::<f32>),
    ("rows_in_many_chunks_and_short_messages", many_chunks),
    ("rows_send_no_more_than_they_must", traffic),
    ("rows_give_the_same_bits_for_any_number_of_threads", threads),
    ("exact_rows_are_the_same_bits_for_any_ranks", exact),
    ("exact_sums_of_all_ranks_merge_to_the_same_bits", exact_merge),
    ("sums_of_symmetric_matrices", sums),
];

fn shapes<T: MpiReal>(world: &World) {
    for (m, n) in SHAPES {
        let own = uneven(m, world.size(), world.rank());
        let rows = part::<T>(own.clone(), 0..n);
        let c = ata_rows(world, T::from_f64(2.0), rows.as_ref(), &options()).unwrap();
        check(world, &c, 2.0, m);
        // Row-major views.
        let transposed = Mat::from_fn(n, own.len(), |j, i| rows[(i, j)]);
        let c = ata_rows(world, T::ONE, transposed.transpose(), &options()).unwrap();
        check(world, &c, 1.0, m);
    }
}

fn many_chunks(world: &World) {
    let (m, n) = (20, 1600);
    world.set_longest_message(1000);
    let own = uneven(m, world.size(), world.rank());
    let c = ata_rows(world, 1.0, part::<f64>(own, 0..n).as_ref(), &options()).unwrap();
    c.for_each_segment(|i, first, entries| {
        // All of them would take long.
        if let Some(&value) = entries.last() {
            let j = first + entries.len() - 1;
            assert_eq!(value, expected(1.0, m, i, j), "entry ({i}, {j})");
        }
    });
}

fn traffic(world: &World) {
    let (m, n) = (64, 1100);
    let own = uneven(m, world.size(), world.rank());
    let a = part::<f64>(own, 0..n);
    world.take_traffic();
    let c = ata_rows(world, 1.0, a.as_ref(), &options()).unwrap();
    let seen = world.traffic();
    let chunks = match c.layout() {
        catamaran::ranks::plan::TriangleLayout::Chunks(chunks) => chunks.count(),
        other => panic!("not chunks: {other:?}"),
    };
    let all = triangle_len(n) as u64;
    let kept = c.entries().len() as u64;
    assert_eq!(seen.words_sent, all - kept);
    assert!(seen.words_received.abs_diff(seen.words_sent) <= (chunks * world.size()) as u64);
    let bound = all as f64 * (1.0 - 1.0 / world.size() as f64);
    assert!(seen.words_sent as f64 <= 1.01 * bound, "{seen:?}, at least {bound}");
    let rounds = world.size().next_power_of_two().ilog2() as usize;
    assert_eq!(seen.messages_sent, (rounds * chunks) as u64);
}

fn threads(world: &World) {
    let (m, n) = (300, 700);
    let own = uneven(m, world.size(), world.rank());
    let a = Mat::from_fn(own.len(), n, |i, j| ((own.start + i) as f64 * 0.37 + j as f64).sin());
    let run = |par| {
        let options = AtaOptions::new().par(par);
        ata_rows(world, 0.3, a.as_ref(), &options).unwrap().entries().to_vec()
    };
    assert_eq!(run(Par::Seq), run(Par::Threads(2)));
}

/// All rows of a matrix with a NaN and infinities, and those of this rank.
fn all_and_own<T: MpiReal>(world: &World, m: usize, n: usize) -> (Mat<T>, Mat<T>) {
    let all = Mat::from_fn(m, n, |i, j| match (i, j) {
        (3, 4) => T::from_f64(f64::NAN),
        (5 | 60, 7) => T::from_f64(f64::INFINITY),
        _ => T::from_f64((i as f64 * 0.37 + j as f64).sin() * (j as f64).exp2()),
    });
    let own = uneven(m, world.size(), world.rank());
    let part = Mat::from_fn(own.len(), n, |i, j| all[(own.start + i, j)]);
    (all, part)
}

fn exact(world: &World) {
    exact_of::<f64>(world);
    exact_of::<f32>(world);
}

fn exact_of<T: MpiReal>(world: &World) {
    let (m, n) = (83, 41);
    let (all, own) = all_and_own::<T>(world, m, n);
    let options = AtaOptions::new().reproducible(true).uplo(Uplo::Both);
    let c = ata_rows(world, T::from_f64(0.3), own.as_ref(), &options).unwrap();
    let mut expected = Mat::from_fn(n, n, |_, _| T::ZERO);
    let (rows, alpha) = (&mut DenseRows(all.as_ref()), T::from_f64(0.3));
    let row_options = RowOptions::new();
    catamaran::rows::ata_rows(alpha, rows, &row_options, T::ZERO, expected.as_mut(), &options)
        .unwrap();
    c.for_each_segment(|i, first, entries| {
        for (j, value) in (first..).zip(entries) {
            let (found, expected): (f64, f64) = (value.to_f64(), expected[(i, j)].to_f64());
            let same = found.to_bits() == expected.to_bits() || found.is_nan() && expected.is_nan();
            assert!(same, "entry ({i}, {j}): {found:e}, not {expected:e}");
        }
    });
}

fn exact_merge(world: &World) {
    let (m, n) = (83, 11);
    let (all, own) = all_and_own::<f64>(world, m, n);
    let sums = |a: &Mat<f64>, bounds: &RowBounds<f64>| {
        let mut sum = Accumulator::exact(bounds, true).unwrap();
        let rows = &mut DenseRows(a.as_ref());
        stream(rows, None, 7, &mut sum, &AtaOptions::new(), &mut |_| Ok(())).unwrap();
        sum
    };
    let bounds = |a: &Mat<f64>| {
        RowBounds::of(&mut DenseRows(a.as_ref()), None, 10, &AtaOptions::new()).unwrap()
    };
    let agreed = agree_bounds(world, &bounds(&own)).unwrap();
    assert_eq!(agreed, bounds(&all));
    let merged = merge_accumulators(world, sums(&own, &agreed)).unwrap();
    let bits = |sum: Accumulator<f64>| {
        let c = sum.finish(1.0, Uplo::Both).unwrap();
        let entry = |i: usize, j: usize| c.as_ref()[(i, j)].to_bits();
        (0..n * n).map(|k| entry(k / n, k % n)).collect::<Vec<_>>()
    };
    if let Some(merged) = merged {
        assert_eq!(bits(merged), bits(sums(&all, &agreed)));
    }
}

fn sums(world: &World) {
    let (m, n) = (world.size() * 5, 75);
    let own = world.rank() * 5..world.rank() * 5 + 5;
    let a = part::<f64>(own, 0..n);
    let mut c = Mat::zeros(n, n);
    catamaran::ata_into(1.0, a.as_ref(), 0.0, c.as_mut(), &options()).unwrap();
    check(world, &sum_symmetric(world, c.as_ref()).unwrap(), 1.0, m);
}
