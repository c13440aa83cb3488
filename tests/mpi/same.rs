//! What every rank reads for itself, and the ranks of one machine.

use catamaran::faer::Mat;
use catamaran::ranks::{World, agree_rows};
use catamaran::rows::DenseRows;

use crate::matrices::{part, tell};
use crate::{Case, Scene};

pub const CASES: &[Case] = &[
    ("rows_that_are_the_same_on_all_ranks_pass", same),
    ("ranks_of_a_machine_divide_its_cores", node),
];

pub const SCENES: &[Scene] = &[
    Scene {
        name: "a_rank_with_an_incomplete_copy_is_named_with_both_numbers",
        ranks: 3,
        starved: None,
        play: incomplete,
        printed: &[
            "0: rank 2: the number of rows is 15, where rank 0 has 20",
            "2: rank 2: the number of rows is 15, where rank 0 has 20",
        ],
        succeeds: true,
    },
    Scene {
        name: "a_rank_with_other_entries_is_named_with_both_fingerprints",
        ranks: 3,
        starved: None,
        play: other_entries,
        printed: &[
            "0: rank 1: the fingerprint of sampled rows is ",
            "1: rank 1: the fingerprint of sampled rows is ",
            "2: rank 1: the fingerprint of sampled rows is ",
            ", where rank 0 has ",
        ],
        succeeds: true,
    },
    Scene {
        name: "a_rank_with_a_file_of_another_size_is_named",
        ranks: 2,
        starved: None,
        play: other_size,
        printed: &["0: rank 1: the size of the file is 101, where rank 0 has 100"],
        succeeds: true,
    },
];

fn same(world: &World) {
    for (m, n) in [(20, 3), (0, 3), (5, 0)] {
        let a = part::<f64>(0..m, 0..n);
        agree_rows(world, &mut DenseRows(a.as_ref()), &[("the size of the file", 7)]).unwrap();
    }
}

fn node(world: &World) {
    let node = world.node();
    assert!(node.sharing() >= 1 && node.sharing() <= node.ranks(), "{node:?}");
    assert_eq!(node.ranks(), world.size(), "tests run on one machine");
    let own = world.share_cores();
    let most = node.cores().div_ceil(node.sharing()).max(1);
    assert!(own >= 1 && own <= most, "{own} cores of {node:?}");
}

fn refused(world: &World, a: &Mat<f64>, bytes: usize) {
    let size = [("the size of the file", bytes)];
    tell(world, agree_rows(world, &mut DenseRows(a.as_ref()), &size).unwrap_err());
    // The world is as good as before.
    let a = part::<f64>(0..5, 0..3);
    agree_rows(world, &mut DenseRows(a.as_ref()), &[]).unwrap();
}

fn incomplete(world: &World) {
    let m = if world.rank() == 2 { 15 } else { 20 };
    refused(world, &part(0..m, 0..3), 100);
}

fn other_entries(world: &World) {
    let mut a = part::<f64>(0..20, 0..3);
    if world.rank() == 1 {
        a[(19, 2)] += 1.0;
    }
    refused(world, &a, 100);
}

fn other_size(world: &World) {
    refused(world, &part(0..20, 0..3), 100 + world.rank());
}
