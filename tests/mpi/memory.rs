//! No rank holds much more than its share: bytes counted by the allocator.

use catamaran::base::release_memory;
use catamaran::faer::{Mat, MatRef};
use catamaran::ranks::plan::TaskTree;
use catamaran::ranks::{Symmetric, World, ata_columns, ata_rows, ata_tree, eigs};
use catamaran::sparse::{self, EigenOptions, Mass};
use catamaran::{AtaOptions, Par, Result, SchemeChoice};

use crate::Case;
use crate::counting::peak_of;
use crate::eigen::{rows, two_grids};
use crate::matrices::{options, part, uneven};

pub const CASES: &[Case] = &[
    ("no_rank_holds_more_than_twice_its_share", shares),
    ("ranks_of_the_tree_hold_what_is_planned", tree),
    ("ranks_share_the_factor_of_eigenpairs", factor),
];

type Mode = fn(&World, f64, MatRef<'_, f64>, &AtaOptions<'_>) -> Result<Symmetric<f64>>;

/// Bytes of packed operands that a local product may have beside.
const SCRATCH: usize = 12 << 20;

/// Bytes that buffers may have before their first huge page, which are not touched.
const UNTOUCHED: usize = 16 << 20;

fn shares(world: &World) {
    let (ranks, rank) = (world.size(), world.rank());
    let n = 2048 / ranks * ranks;
    let own = rank * (n / ranks)..(rank + 1) * (n / ranks);
    // The exact path has residues of the operands beside them.
    let options = options().scheme(SchemeChoice::Float);
    let check = |name: &str, a: Mat<f64>, product: Mode| {
        release_memory();
        let (peak, c) = peak_of(|| product(world, 1.0, a.as_ref(), &options));
        let matrix = 8 * a.nrows() * a.ncols();
        let share = matrix + 8 * c.unwrap().entries().len();
        let held = peak + matrix;
        assert!(
            held <= 2 * share + SCRATCH + UNTOUCHED,
            "{name}: {held} bytes held, share {share}"
        );
    };
    check("rows", part(own.clone(), 0..n), ata_rows);
    check("columns", part(0..n, own), ata_columns);
}

fn tree(world: &World) {
    let (m, n) = (1600, 1200);
    let is_root = world.rank() == 0;
    let options = options().scheme(SchemeChoice::Float);
    let matrices = is_root.then(|| (part::<f64>(0..m, 0..n), Mat::zeros(n, n)));
    let (a, mut c) = matrices.unzip();
    release_memory();
    let (peak, done) = peak_of(|| {
        let a = a.as_ref().map(Mat::as_ref);
        ata_tree(world, 0, 1.0, a, 0.0, c.as_mut().map(Mat::as_mut), &options)
    });
    done.unwrap();
    let own = if is_root { m * n + n * n } else { 0 };
    let held = peak + 8 * own;
    let planned = 8 * TaskTree::new(m, n, world.size()).loads()[world.rank()].memory;
    assert!(held <= planned + SCRATCH, "{held} bytes held, planned {planned}");
}

/// Few pairs of many rows: the factor takes more than the basis.
fn factor(world: &World) {
    let (side, ranks) = (150, world.size());
    let n = side * side;
    let w = two_grids(side, 0);
    let options = EigenOptions::new().k(2).par(Par::Seq);
    let whole = || peak_of(|| sparse::eigs(w.view(), &Mass::identity(n), &options).unwrap()).0;
    whole();
    let whole = whole();
    let own = uneven(n, ranks, world.rank());
    let (part, mass) = (rows(&w, own.clone()), Mass::identity(own.len()));
    let (peak, pairs) = peak_of(|| eigs(world, part.view(), &mass, &options));
    pairs.unwrap();
    // Rows move to the ranks of their domains, however many each rank has before. Beside its share
    // a rank has the graph while it is divided, its rows on their way, and the interface.
    let share = 1.0 / ranks as f64 + 0.25;
    assert!(peak as f64 <= share * whole as f64, "{peak} of {whole} bytes on one of {ranks} ranks");
}
