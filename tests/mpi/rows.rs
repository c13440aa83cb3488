//! Mode (a): rows of A on every rank.

use catamaran::ata::distributed::packed_len;
use catamaran::faer::Mat;
use catamaran::mpi::{MpiReal, World, ata_rows, sum_symmetric};
use catamaran::{AtaOptions, Par};

use crate::Case;
use crate::matrices::{SHAPES, check, expected, options, part, uneven};

pub const CASES: &[Case] = &[
    ("rows_of_any_shape_f64", shapes::<f64>),
    ("rows_of_any_shape_f32", shapes::<f32>),
    ("rows_in_many_chunks_and_short_messages", many_chunks),
    ("rows_send_no_more_than_they_must", traffic),
    ("rows_give_the_same_bits_for_any_number_of_threads", threads),
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
        catamaran::ata::distributed::Layout::Chunks(chunks) => chunks.count(),
        other => panic!("not chunks: {other:?}"),
    };
    let all = packed_len(n) as u64;
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

fn sums(world: &World) {
    let (m, n) = (world.size() * 5, 75);
    let own = world.rank() * 5..world.rank() * 5 + 5;
    let a = part::<f64>(own, 0..n);
    let mut c = Mat::zeros(n, n);
    catamaran::ata(1.0, a.as_ref(), 0.0, c.as_mut(), &options()).unwrap();
    check(world, &sum_symmetric(world, c.as_ref()).unwrap(), 1.0, m);
}
