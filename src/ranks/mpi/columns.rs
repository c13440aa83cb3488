//! Columns of A on every rank: blocks of columns travel so that each pair of blocks meets once.

use faer::MatRef;

use super::pairs::{ExactPairs, FloatPairs, bounds_of_seen, summed};
use super::symmetric::Symmetric;
use super::world::{MpiReal, Operation, World, fact, flag, number_fact, scalar_fact};
use crate::base::{Result, reserved};
use crate::product::AtaOptions;
use crate::ranks::plan::{Blocks, TriangleLayout};

/// Computes `C = alpha A^T A` where every rank has some `columns` of A, possibly none, in the order
/// of the ranks.
///
/// This is the two-dimensional distribution, for matrices that are not much longer than wide. With
/// about equal numbers of columns, each rank receives `m n / sqrt(P)` words (at most 1.5 times
/// that, see [`difference_cover`](crate::ranks::plan::difference_cover)), piece by piece of
/// rows, while it multiplies the previous piece. The columns of a rank are m x n_r with any
/// strides. Beside these columns and its part of C, a rank holds two pieces of the columns that it
/// multiplies, not more than its share of A and C together. `options.uplo` does not matter. The
/// result depends, by rounding, on the number of ranks and the widths; on the exact path, which is
/// used if the options request it, C has the same bytes for any of them, and those of
/// [`ata_rows`](super::ata_rows).
///
/// ```no_run
/// use catamaran::ranks::{World, ata_columns};
/// use catamaran::{AtaOptions, faer::Mat};
///
/// # let start = mpi::initialize_with_threading(mpi::Threading::Funneled);
/// # let (universe, _) = start.expect("MPI is started once");
/// # let world = World::new(&universe.world())?;
/// // Every rank has 8 columns.
/// let own = Mat::<f64>::from_fn(100, 8, |i, j| (world.rank() + i * j % 7) as f64);
/// let result = ata_columns(&world, 1.0, own.as_ref(), &AtaOptions::new())?;
/// assert_eq!(result.n(), 8 * world.size());
/// result.for_each_segment(|i, j, entries| println!("C[{i}, {j}..] = {entries:?}"));
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Rank`](crate::Error::Rank) when m, alpha or the precision differ, or another rank
/// failed; else as [`ata_into`](crate::ata_into).
pub fn ata_columns<T: MpiReal>(
    world: &World,
    alpha: T,
    columns: MatRef<'_, T>,
    options: &AtaOptions<'_>,
) -> Result<Symmetric<T>> {
    let _guard = world.abort_on_panic();
    let (m, own) = (columns.nrows(), world.rank());
    let exact = flag("the exact path", options.asks_for_exact());
    let facts = [fact("m", m), scalar_fact::<T>(), number_fact("alpha", alpha), exact];
    world.begin(Operation::Columns, &facts, Ok(()))?;
    let blocks = Blocks::new(&world.gather_numbers(columns.ncols()));
    let place = Some((0, &blocks));
    let entries = if options.asks_for_exact() {
        let (size, held) = ((m, blocks.n()), blocks.columns(own));
        let bounds = bounds_of_seen(world, Some((&blocks, own)), columns, held, size, options)?;
        let sums = || ExactPairs::new(&blocks, own, &bounds);
        let pairs = summed(world, place, columns, sums, options)?.expect("a block on every rank");
        let mut entries = world.agree(reserved(pairs.len()))?;
        entries.extend((0..pairs.len()).map(|k| pairs.value(k, alpha, pairs.sum(k))));
        entries
    } else {
        let sums = || FloatPairs::new(&blocks, own, alpha);
        let pairs = summed(world, place, columns, sums, options)?.expect("a block on every rank");
        pairs.into_entries()
    };
    Ok(Symmetric::new(TriangleLayout::Blocks(blocks), own, entries))
}
