//! Collective exchanges of numbers and rows between the ranks.

use std::ops::Range;

use ::mpi::collective::{CommunicatorCollectives, Root};
use ::mpi::topology::Communicator;
use faer::{Mat, MatRef};

use super::call::Call;
use super::memory::{Buffer, entries, put_entries};
use super::tags::{EXCHANGE, GATHER_ROWS};
use super::transfer::{Transfer, receive, send};
use super::world::{MpiReal, Operation, World, fact};
use crate::base::{Result, zeros};
use crate::dense;

/// Sends one number to each rank, and returns the numbers for this rank.
pub(super) fn exchange_numbers(call: &Call<'_>, outgoing: &[usize]) -> Result<Vec<usize>> {
    call.meet(Ok(()))?;
    let outgoing: Vec<u64> = outgoing.iter().map(|&number| number as u64).collect();
    let mut incoming = vec![0_u64; outgoing.len()];
    call.world.communicator().all_to_all_into(&outgoing[..], &mut incoming[..]);
    Ok(incoming.into_iter().map(|number| number as usize).collect())
}

/// Sends `outgoing[r]` to rank r, and returns `lens[r]` numbers from each rank r.
pub(super) fn exchange(
    call: &Call<'_>,
    mut outgoing: Vec<Vec<f64>>,
    lens: &[usize],
) -> Result<Vec<Buffer<f64>>> {
    let (world, own) = (call.world, call.world.rank());
    let room = |(from, &len): (usize, &usize)| Buffer::of_len(if from == own { 0 } else { len });
    let incoming: Vec<_> = call.meet(lens.iter().enumerate().map(room).collect::<Result<_>>())?;
    let kept = std::mem::take(&mut outgoing[own]);
    let receiving = |(from, buffer)| Transfer::receive(world, buffer, from, EXCHANGE);
    let received: Vec<_> = incoming.into_iter().enumerate().map(receiving).collect();
    let sending = |(to, entries)| Transfer::send(world, Buffer::from(entries), [to], EXCHANGE);
    let sent: Vec<_> = outgoing.into_iter().enumerate().map(sending).collect();
    let mut incoming: Vec<_> = received.into_iter().map(Transfer::wait).collect();
    incoming[own] = kept.into();
    drop(sent);
    Ok(incoming)
}

/// Returns the entries of all ranks, `lens[r]` of rank r, one after another, on every rank. It uses
/// the collective operation of the MPI library, which is not counted as traffic.
pub(super) fn all_gather<T: MpiReal>(call: &Call<'_>, own: &[T], lens: &[usize]) -> Result<Vec<T>> {
    let world = call.world;
    let mut all = call.meet(zeros::<T>(lens.iter().sum()))?;
    let mut rest = &mut all[..];
    for (rank, &len) in lens.iter().enumerate() {
        let (part, others) = rest.split_at_mut(len);
        if rank == world.rank() {
            part.copy_from_slice(own);
        }
        let root = world.communicator().process_at_rank(rank as i32);
        for piece in part.chunks_mut(world.longest_message()) {
            root.broadcast_into(piece);
        }
        rest = others;
    }
    Ok(all)
}

/// Returns the numbers of all ranks, one after another, on every rank, and where those of each rank
/// are.
pub(super) fn gather_lists(call: &Call<'_>, own: &[f64]) -> Result<(Vec<f64>, Vec<Range<usize>>)> {
    let spread = Rows::new(call, own.len())?;
    let spans: Vec<_> = (0..spread.ranks()).map(|rank| spread.of(rank)).collect();
    let lens: Vec<usize> = spans.iter().map(Range::len).collect();
    Ok((all_gather(call, own, &lens)?, spans))
}

/// The distribution of the rows of a matrix over the ranks, in their order.
pub(super) struct Rows {
    rank: usize,
    /// The first row of each rank, and the number of all rows.
    starts: Vec<usize>,
}

impl Rows {
    /// Gathers the numbers of rows; this rank has `own` of them.
    pub fn new(call: &Call<'_>, own: usize) -> Result<Self> {
        call.meet(Ok(()))?;
        let mut starts = vec![0];
        for rows in call.world.gather_numbers(own) {
            starts.push(starts[starts.len() - 1] + rows);
        }
        Ok(Self { rank: call.world.rank(), starts })
    }

    /// Returns the number of rows of the matrix.
    pub fn count(&self) -> usize {
        self.starts[self.ranks()]
    }

    /// Returns the number of ranks.
    pub fn ranks(&self) -> usize {
        self.starts.len() - 1
    }

    /// Returns the rows of a rank.
    pub fn of(&self, rank: usize) -> Range<usize> {
        self.starts[rank]..self.starts[rank + 1]
    }

    /// Returns the rows of this rank.
    pub fn own(&self) -> Range<usize> {
        self.of(self.rank)
    }

    /// Returns the rank that has row i.
    pub fn holder(&self, i: usize) -> usize {
        self.starts.partition_point(|&start| start <= i) - 1
    }
}

/// Gathers a matrix whose `rows` are spread over the ranks, in their order, on rank `root`; returns
/// `None` on the other ranks.
///
/// ```no_run
/// use catamaran::{faer::Mat, ranks::{World, gather_rows}};
///
/// # let start = mpi::initialize_with_threading(mpi::Threading::Funneled);
/// # let (universe, _) = start.expect("MPI is started once");
/// # let world = World::new(&universe.world())?;
/// let own = Mat::<f64>::full(2, 3, world.rank() as f64);
/// if let Some(all) = gather_rows(&world, 0, own.as_ref())? {
///     assert_eq!(all.shape(), (2 * world.size(), 3));
///     assert_eq!(all[(all.nrows() - 1, 0)], (world.size() - 1) as f64);
/// }
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Argument`](crate::Error::Argument) when there is no such root,
/// [`Error::OutOfMemory`](crate::Error::OutOfMemory); [`Error::Rank`](crate::Error::Rank) when
/// arguments differ, or another rank failed.
pub fn gather_rows(world: &World, root: usize, rows: MatRef<'_, f64>) -> Result<Option<Mat<f64>>> {
    let columns = rows.ncols();
    let facts = [fact("the number of columns", columns), fact("root", root)];
    Call::run(world, Operation::GatherRows, &facts, |call| {
        world.check_root(root)?;
        let own = entries(rows);
        let spread = Rows::new(call, rows.nrows())?;
        if world.rank() != root {
            send(world, &call.meet(own)?, root, GATHER_ROWS);
            return Ok(None);
        }
        let longest = (0..world.size()).map(|rank| spread.of(rank).len()).max().unwrap_or(0);
        let room = own.and_then(|own| {
            Ok((own, zeros(longest * columns)?, dense::zeros(spread.count(), columns)?))
        });
        let (own, mut buffer, mut all) = call.meet(room)?;
        for rank in 0..world.size() {
            let span = spread.of(rank);
            let part = all.as_mut().subrows_mut(span.start, span.len());
            if rank == root {
                put_entries(part, &own);
            } else {
                // One rank at a time, so that no more memory than a share is needed.
                let entries = &mut buffer[..span.len() * columns];
                receive(world, entries, rank, GATHER_ROWS);
                put_entries(part, entries);
            }
        }
        Ok(Some(all))
    })
}
