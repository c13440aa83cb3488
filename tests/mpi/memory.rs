//! No rank holds much more than its share: bytes counted by the allocator.

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};

use catamaran::ata::distributed::TaskTree;
use catamaran::base::release_memory;
use catamaran::faer::{Mat, MatRef};
use catamaran::mpi::{Symmetric, World, ata_columns, ata_root, ata_rows};
use catamaran::{AtaOptions, Result, SchemeChoice};

use crate::Case;
use crate::matrices::{options, part};

pub const CASES: &[Case] = &[
    ("no_rank_holds_more_than_twice_its_share", shares),
    ("ranks_of_the_tree_hold_what_is_planned", tree),
];

/// Counts the bytes that are allocated and not freed, and their peak.
struct Counting;

static NOW: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);

// SAFETY: everything is passed on to the system allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let now = NOW.fetch_add(layout.size(), Ordering::SeqCst) + layout.size();
        PEAK.fetch_max(now, Ordering::SeqCst);
        // SAFETY: passed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, ptr: *mut u8, layout: Layout) {
        NOW.fetch_sub(layout.size(), Ordering::SeqCst);
        // SAFETY: passed on.
        unsafe { System.dealloc(ptr, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

type Mode = fn(&World, f64, MatRef<'_, f64>, &AtaOptions<'_>) -> Result<Symmetric<f64>>;

/// Bytes of packed operands that a local product may have beside.
const SCRATCH: usize = 12 << 20;

fn shares(world: &World) {
    let (ranks, rank) = (world.size(), world.rank());
    let n = 2048 / ranks * ranks;
    let own = rank * (n / ranks)..(rank + 1) * (n / ranks);
    // The exact path has residues of the operands beside them.
    let options = AtaOptions { scheme: SchemeChoice::Float, ..options() };
    let check = |name: &str, a: Mat<f64>, product: Mode| {
        release_memory();
        let before = NOW.load(Ordering::SeqCst);
        PEAK.store(before, Ordering::SeqCst);
        let c = product(world, 1.0, a.as_ref(), &options);
        let matrix = 8 * a.nrows() * a.ncols();
        let share = matrix + 8 * c.unwrap().entries().len();
        let held = PEAK.load(Ordering::SeqCst) - before + matrix;
        assert!(held <= 2 * share + SCRATCH, "{name}: {held} bytes held, share {share}");
    };
    check("rows", part(own.clone(), 0..n), ata_rows);
    check("columns", part(0..n, own), ata_columns);
}

fn tree(world: &World) {
    let (m, n) = (1600, 1200);
    let is_root = world.rank() == 0;
    let options = AtaOptions { scheme: SchemeChoice::Float, ..options() };
    let matrices = is_root.then(|| (part::<f64>(0..m, 0..n), Mat::zeros(n, n)));
    let (a, mut c) = matrices.unzip();
    release_memory();
    let before = NOW.load(Ordering::SeqCst);
    PEAK.store(before, Ordering::SeqCst);
    let a = a.as_ref().map(Mat::as_ref);
    ata_root(world, 0, 1.0, a, 0.0, c.as_mut().map(Mat::as_mut), &options).unwrap();
    let own = if is_root { m * n + n * n } else { 0 };
    let held = PEAK.load(Ordering::SeqCst) - before + 8 * own;
    let planned = 8 * TaskTree::new(m, n, world.size()).loads()[world.rank()].memory;
    assert!(held <= planned + SCRATCH, "{held} bytes held, planned {planned}");
}
