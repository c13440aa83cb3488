//! Some rows of some columns of A on every rank: columns travel within a slice of the rows, and the
//! sums of the slices are reduced.

use faer::MatRef;

use super::digits::{PARTS, part_of, whole};
use super::pairs::{ExactPairs, FloatPairs, Pairs, bounds_of_seen, summed};
use super::scatter::Scatter;
use super::symmetric::Symmetric;
use super::world::{MpiReal, Operation, World, fact, flag, number_fact, scalar_fact};
use crate::base::{Error, Result, reserved, zeros};
use crate::product::AtaOptions;
use crate::ranks::plan::{Bricks, TriangleLayout};

/// Computes `C = alpha A^T A` where every rank has a `brick` of A: the rows and columns that
/// `bricks` gives it, which may be none.
///
/// This is the three-dimensional distribution, for matrices of about as many rows as columns on
/// many ranks. On squares and 16 to 4096 ranks a rank of [`Bricks::new`] receives at most 1.45
/// times the words of the lower bound, and less than 1.25 times as many on most of them. Columns
/// travel in pieces of rows, while the previous piece is multiplied; then the sums are reduced. A
/// brick has any strides. Beside it and what [`ata_columns`](super::ata_columns) holds a rank has
/// its sums before the reduction, for p blocks of columns `n (n + 1) / (2 p)` words, and as many
/// for messages. `options.uplo` does not matter. The result depends, by rounding, on the bricks; on
/// the exact path, which is used if the options request it, C has the same bytes for any bricks,
/// and those of [`ata_rows`](super::ata_rows), at five times the words of sums of f64.
///
/// ```no_run
/// use catamaran::ranks::plan::Bricks;
/// use catamaran::ranks::{World, ata_bricks};
/// use catamaran::{AtaOptions, faer::Mat};
///
/// # let start = mpi::initialize_with_threading(mpi::Threading::Funneled);
/// # let (universe, _) = start.expect("MPI is started once");
/// # let world = World::new(&universe.world())?;
/// let bricks = Bricks::new(world.size(), 1000, 1000);
/// let [rows, columns] = [bricks.rows(world.rank()), bricks.columns(world.rank())];
/// let own = Mat::<f64>::from_fn(rows.len(), columns.len(), |i, j| {
///     ((rows.start + i) * (columns.start + j) % 7) as f64
/// });
/// let result = ata_bricks(&world, 1.0, &bricks, own.as_ref(), &AtaOptions::new())?;
/// result.for_each_segment(|i, j, entries| println!("C[{i}, {j}..] = {entries:?}"));
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Shape`] when this rank has another brick, [`Error::Argument`] when the bricks are for
/// another number of ranks, [`Error::Rank`] when bricks, alpha or the precision differ, or another
/// rank failed; else as [`ata_into`](crate::ata_into).
pub fn ata_bricks<T: MpiReal>(
    world: &World,
    alpha: T,
    bricks: &Bricks,
    brick: MatRef<'_, T>,
    options: &AtaOptions<'_>,
) -> Result<Symmetric<T>> {
    let _guard = world.abort_on_panic();
    let facts = [
        fact("m", bricks.m()),
        fact("n", bricks.n()),
        fact("the number of blocks of columns", bricks.blocks().ranks()),
        fact("the number of slices of rows", bricks.slices()),
        scalar_fact::<T>(),
        number_fact("alpha", alpha),
        flag("the exact path", options.asks_for_exact()),
    ];
    world.begin(Operation::Bricks, &facts, check(world, bricks, brick))?;
    let entries = match options.asks_for_exact() {
        true => in_integers(world, alpha, bricks, brick, options)?,
        false => in_floats(world, alpha, bricks, brick, options)?,
    };
    Ok(Symmetric::new(TriangleLayout::Bricks(bricks.clone()), world.rank(), entries))
}

/// Checks what this rank can check alone.
fn check<T>(world: &World, bricks: &Bricks, brick: MatRef<'_, T>) -> Result<()> {
    if bricks.ranks() != world.size() {
        let why = format!("are for {} ranks, of which there are {}", bricks.ranks(), world.size());
        return Err(Error::Argument { what: "bricks", why });
    }
    let rank = world.rank();
    let shape = (bricks.rows(rank).len(), bricks.columns(rank).len());
    Error::check_shape("this rank's part of A", shape, brick.shape())
}

/// Sums the products of this rank's slice, given its sums of no rows of a block; `None` for a rank
/// without a brick.
fn summed_in_slice<T: MpiReal, P: Pairs<T>>(
    world: &World,
    bricks: &Bricks,
    brick: MatRef<'_, T>,
    sums: impl FnOnce(usize) -> Result<P>,
    options: &AtaOptions<'_>,
) -> Result<Option<P>> {
    let (slice, block) = bricks.place(world.rank()).unzip();
    let place = slice.map(|slice| (bricks.rank(slice, 0), bricks.blocks()));
    summed(world, place, brick, || sums(block.unwrap_or_default()), options)
}

/// Returns the reduction over the slices of the sums of this rank's block; `None` for a rank
/// without a brick.
fn scatter<T: MpiReal>(world: &World, bricks: &Bricks) -> Option<Result<Scatter<T>>> {
    let (slice, block) = bricks.place(world.rank())?;
    let ranks = [block, bricks.blocks().ranks(), bricks.slices()];
    Some(Scatter::new(ranks, slice, bricks.blocks().len(block)))
}

fn in_floats<T: MpiReal>(
    world: &World,
    alpha: T,
    bricks: &Bricks,
    brick: MatRef<'_, T>,
    options: &AtaOptions<'_>,
) -> Result<Vec<T>> {
    let sums = |block| FloatPairs::new(bricks.blocks(), block, alpha);
    let pairs = summed_in_slice(world, bricks, brick, sums, options)?;
    let mut sums = pairs.map(FloatPairs::into_entries).unwrap_or_default();
    let prepared = scatter::<T>(world, bricks).map(|scatter| {
        let scatter = scatter?;
        let entries = reserved(bricks.len(world.rank()))?;
        Ok((scatter, entries))
    });
    let Some((mut scatter, mut entries)) = world.agree(prepared.transpose())? else {
        return Ok(Vec::new());
    };
    entries.extend_from_slice(scatter.sum(world, &mut sums));
    Ok(entries)
}

fn in_integers<T: MpiReal>(
    world: &World,
    alpha: T,
    bricks: &Bricks,
    brick: MatRef<'_, T>,
    options: &AtaOptions<'_>,
) -> Result<Vec<T>> {
    let rank = world.rank();
    let (place, size) = (bricks.place(rank), (bricks.m(), bricks.n()));
    let in_slice = place.map(|(_, block)| (bricks.blocks(), block));
    let bounds = bounds_of_seen(world, in_slice, brick, bricks.columns(rank), size, options)?;
    let sums = |block| ExactPairs::new(bricks.blocks(), block, &bounds);
    let pairs = summed_in_slice(world, bricks, brick, sums, options)?;
    let prepared = scatter::<f64>(world, bricks).zip(pairs).map(|(scatter, pairs)| {
        let (scatter, terms) = (scatter?, zeros::<f64>(pairs.len())?);
        let (len, entries) = (bricks.len(rank), reserved(bricks.len(rank))?);
        Ok((scatter, pairs, terms, zeros::<[f64; PARTS]>(len)?, entries))
    });
    let (Some((mut scatter, pairs, mut terms, mut sums, mut entries)), Some((slice, block))) =
        (world.agree(prepared.transpose())?, place)
    else {
        return Ok(Vec::new());
    };
    for part in 0..PARTS {
        for (k, term) in terms.iter_mut().enumerate() {
            *term = part_of(pairs.sum(k), part);
        }
        let of_own = scatter.sum(world, &mut terms);
        sums.iter_mut().zip(of_own).for_each(|(parts, &sum)| parts[part] = sum);
    }
    let own = bricks.part(slice, block);
    entries.extend(own.zip(&sums).map(|(k, parts)| pairs.value(k, alpha, whole(parts))));
    Ok(entries)
}
