//! Mode (b): columns of A on every rank.

use catamaran::faer::Mat;
use catamaran::ranks::{MpiReal, World, ata_columns};
use catamaran::{AtaOptions, Par};

use crate::Case;
use crate::matrices::{SHAPES, check, options, part, uneven};

pub const CASES: &[Case] = &[
    ("columns_of_any_shape_f64", shapes::<f64>),
    ("columns_of_any_shape_f32", shapes::<f32>),
    ("columns_in_many_pieces_and_short_messages", many_pieces),
    ("columns_send_little_more_than_they_must", traffic),
    ("columns_give_the_same_bits_for_any_number_of_threads", threads),
];

fn shapes<T: MpiReal>(world: &World) {
    for (m, n) in SHAPES {
        let own = uneven(n, world.size(), world.rank());
        let columns = part::<T>(0..m, own.clone());
        let c = ata_columns(world, T::from_f64(2.0), columns.as_ref(), &options()).unwrap();
        check(world, &c, 2.0, m);
        // Row-major views.
        let transposed = Mat::from_fn(own.len(), m, |j, i| columns[(i, j)]);
        let c = ata_columns(world, T::ONE, transposed.transpose(), &options()).unwrap();
        check(world, &c, 1.0, m);
    }
}

fn many_pieces(world: &World) {
    let (m, n) = (1500, 60);
    world.set_longest_message(1000);
    let own = uneven(n, world.size(), world.rank());
    let c = ata_columns(world, 1.0, part::<f64>(0..m, own).as_ref(), &options()).unwrap();
    check(world, &c, 1.0, m);
}

fn traffic(world: &World) {
    let (m, n, ranks) = (840, 840, world.size());
    let width = n / ranks;
    let own = world.rank() * width..(world.rank() + 1) * width;
    let a = part::<f64>(0..m, own);
    world.take_traffic();
    ata_columns(world, 1.0, a.as_ref(), &options()).unwrap();
    let seen = world.traffic();
    let bound = (n * m) as f64 / (ranks as f64).sqrt();
    assert_eq!(seen.words_sent, seen.words_received);
    assert!(ranks == 1 || seen.words_sent as f64 <= 1.5 * bound, "{seen:?}, at least {bound}");
}

fn threads(world: &World) {
    let (m, n) = (700, 300);
    let own = uneven(n, world.size(), world.rank());
    let a = Mat::from_fn(m, own.len(), |i, j| (i as f64 * 0.37 + (own.start + j) as f64).sin());
    let run = |par| {
        let options = AtaOptions::new().par(par);
        ata_columns(world, 0.3, a.as_ref(), &options).unwrap().entries().to_vec()
    };
    assert_eq!(run(Par::Seq), run(Par::Threads(2)));
}
