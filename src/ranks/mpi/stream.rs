//! Accumulators of streams, one on each rank.

use std::io::{self, Read, Write};

use ::mpi::datatype::Equivalence;
use ::mpi::point_to_point::{Destination, Source};
use ::mpi::topology::Communicator;

use super::tags::STREAM;
use super::world::{MpiReal, Operation, Traffic, World, fact, flag, scalar_fact};
use crate::base::{Error, Result};
use crate::rows::{Accumulator, RowBounds};

/// Bytes of a message.
const MESSAGE: usize = 1 << 20;

/// Joins the bounds of the rows of all ranks. The result is the same on every rank:
/// [`Accumulator::exact`] sums with these bounds merge to the same bytes for any distribution of
/// rows.
///
/// ```no_run
/// use catamaran::ranks::{World, agree_bounds, merge_accumulators};
/// use catamaran::{AtaOptions, rows::{Accumulator, RowBounds}, faer::mat};
///
/// # let start = mpi::initialize_with_threading(mpi::Threading::Funneled);
/// # let (universe, _) = start.expect("MPI is started once");
/// # let world = World::new(&universe.world())?;
/// let own = world.rank() as f64;
/// let bounds = RowBounds::new(vec![own], vec![own], 1)?;
/// let bounds = agree_bounds(&world, &bounds)?;
/// assert_eq!(bounds.upper(), [(world.size() - 1) as f64]);
///
/// let mut sum = Accumulator::exact(&bounds, false)?;
/// sum.add_block(mat![[own]], None, &AtaOptions::new())?;
/// if let Some(sum) = merge_accumulators(&world, sum)? {
///     assert_eq!(sum.rows(), world.size() as u64);
/// }
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Rank`] when the columns or the precision differ, only some ranks have weights, or
/// another rank failed.
pub fn agree_bounds<T: MpiReal>(world: &World, bounds: &RowBounds<T>) -> Result<RowBounds<T>> {
    let _guard = world.abort_on_panic();
    let facts = [
        fact("the number of columns", bounds.ncols()),
        flag("the presence of weights", bounds.weight().is_some()),
        scalar_fact::<T>(),
    ];
    world.begin(Operation::Bounds, &facts, Ok(()))?;
    joined_bounds(world, bounds)
}

/// Computes [`agree_bounds`] inside a call.
pub(super) fn joined_bounds<T: MpiReal>(
    world: &World,
    bounds: &RowBounds<T>,
) -> Result<RowBounds<T>> {
    let n = bounds.ncols();
    let rows = world.gather_numbers(bounds.rows() as usize).iter().sum::<usize>() as u64;
    // The largest value is the negative of the least negative.
    let weight = bounds.weight().map(|w| -w.to_f64());
    let lower = bounds.lower().iter().map(|x| x.to_f64());
    let upper = bounds.upper().iter().map(|x| -x.to_f64());
    let units = bounds.units().iter().copied();
    let mut values: Vec<f64> = lower.chain(upper).chain(units).chain(weight).collect();
    world.least(&mut values);
    let part = |range: std::ops::Range<usize>, sign: f64| {
        values[range].iter().map(|x| T::from_f64(sign * x)).collect()
    };
    let (bounds, units) = ([part(0..n, 1.0), part(n..2 * n, -1.0)], values[2 * n..3 * n].to_vec());
    let weight = weight.map(|_| T::from_f64(-values[3 * n]));
    Ok(RowBounds::from_parts(bounds, units, weight, rows))
}

/// Joins the bounds of the parts of all ranks, each of some `columns` of all rows or of a part of
/// them; A is m x n. Returns those of the `wanted` columns.
pub(super) fn joined_bounds_of_columns<T: MpiReal>(
    world: &World,
    bounds: &RowBounds<T>,
    columns: std::ops::Range<usize>,
    (m, n): (usize, usize),
    wanted: &[usize],
) -> RowBounds<T> {
    // Lower bounds, negative upper bounds, and units; those of other columns change nothing.
    let mut values = vec![f64::INFINITY; 3 * n];
    for (k, column) in columns.enumerate() {
        values[column] = bounds.lower()[k].to_f64();
        values[n + column] = -bounds.upper()[k].to_f64();
        values[2 * n + column] = bounds.units()[k];
    }
    world.least(&mut values);
    let lower = wanted.iter().map(|&column| T::from_f64(values[column])).collect();
    let upper = wanted.iter().map(|&column| T::from_f64(-values[n + column])).collect();
    let units = wanted.iter().map(|&column| values[2 * n + column]).collect();
    RowBounds::from_parts([lower, upper], units, None, m as u64)
}

/// Merges the accumulators of all ranks, in a tree of `log2 P` levels that depends on P only.
/// Returns the sum on rank 0, and `None` on the others. Exact sums on the same bounds
/// ([`agree_bounds`]) are the same bytes for any P. Beside its own accumulator a rank holds one
/// more.
///
/// ```no_run
/// use catamaran::ranks::{World, merge_accumulators};
/// use catamaran::{AtaOptions, Uplo, rows::Accumulator, faer::mat};
///
/// # let start = mpi::initialize_with_threading(mpi::Threading::Funneled);
/// # let (universe, _) = start.expect("MPI is started once");
/// # let world = World::new(&universe.world())?;
/// let mut sum = Accumulator::<f64>::new(2, false)?;
/// sum.add_block(mat![[1.0, 2.0]], None, &AtaOptions::new())?;
/// if let Some(sum) = merge_accumulators(&world, sum)? {
///     let c = sum.finish(1.0, Uplo::Lower)?;
///     assert_eq!(c.as_ref()[(1, 0)], 2.0 * world.size() as f64);
/// }
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Rank`] when the columns or the centring differ, or another rank failed;
/// [`Error::Argument`] for labels that are too long for [`Accumulator::write`]; else as
/// [`Accumulator::merge`].
pub fn merge_accumulators<T: MpiReal>(
    world: &World,
    mut sum: Accumulator<T>,
) -> Result<Option<Accumulator<T>>> {
    let _guard = world.abort_on_panic();
    let facts = [
        fact("the number of columns", sum.ncols()),
        flag("centring", sum.is_centered()),
        fact("the kind of sums", usize::from(sum.is_exact()) + usize::from(sum.is_extended())),
        scalar_fact::<T>(),
    ];
    let head = sum.head().map_err(|e| {
        let why = e.to_string();
        Error::Argument { what: "accumulator", why }
    });
    world.begin(Operation::Merge, &facts, head.map(drop))?;
    let (rank, size) = (world.rank(), world.size());
    let mut done = Ok(());
    let mut step = 1;
    // A rank that fails continues with what it has, so that no rank waits for it.
    while step < size && rank.is_multiple_of(2 * step) {
        if rank + step < size {
            let mut stream = Incoming::new(world, rank + step);
            let other = Accumulator::read(&mut stream)
                .map_err(|e| Error::Rank { rank: rank + step, why: e.to_string() });
            let end = io::copy(&mut stream, &mut io::sink());
            stream.count::<T>();
            let merged = other.and_then(|other| sum.merge(other));
            debug_assert!(end.is_ok());
            done = done.and(merged);
        }
        step *= 2;
    }
    if rank > 0 {
        let mut stream = Outgoing::new(world, rank - step);
        let written = sum.write(&mut stream);
        // The other rank waits for the end, whatever was written.
        let sent = written.and(stream.end::<T>());
        done = done.and(sent.map_err(|e| Error::Rank { rank, why: e.to_string() }));
    }
    world.agree(done)?;
    Ok((rank == 0).then_some(sum))
}

/// Writes bytes to another rank, in messages of one length except the last, which is shorter.
struct Outgoing<'w> {
    world: &'w World,
    to: usize,
    buffer: Vec<u8>,
    bytes: usize,
}

impl<'w> Outgoing<'w> {
    fn new(world: &'w World, to: usize) -> Self {
        Self { world, to, buffer: Vec::with_capacity(MESSAGE), bytes: 0 }
    }

    fn send(&mut self) {
        self.world
            .communicator()
            .process_at_rank(self.to as i32)
            .send_with_tag(&self.buffer[..], STREAM.number());
        self.bytes += self.buffer.len();
        self.buffer.clear();
    }

    /// Sends the last message, which may be empty.
    fn end<T>(mut self) -> io::Result<()> {
        self.send();
        let messages_sent = (self.bytes / MESSAGE + 1) as u64;
        let words_sent = self.bytes.div_ceil(size_of::<T>()) as u64;
        self.world.count(Traffic { words_sent, messages_sent, ..Traffic::default() });
        Ok(())
    }
}

impl Write for Outgoing<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let taken = bytes.len().min(MESSAGE - self.buffer.len());
        self.buffer.extend_from_slice(&bytes[..taken]);
        if self.buffer.len() == MESSAGE {
            self.send();
        }
        Ok(taken)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Reads the bytes of an [`Outgoing`].
struct Incoming<'w> {
    world: &'w World,
    from: usize,
    buffer: Vec<u8>,
    taken: usize,
    bytes: usize,
    ended: bool,
}

impl<'w> Incoming<'w> {
    fn new(world: &'w World, from: usize) -> Self {
        Self { world, from, buffer: Vec::new(), taken: 0, bytes: 0, ended: false }
    }

    /// Adds the received messages to the traffic, after the end.
    fn count<T>(&self) {
        let messages_received = (self.bytes / MESSAGE + 1) as u64;
        let words_received = self.bytes.div_ceil(size_of::<T>()) as u64;
        self.world.count(Traffic { words_received, messages_received, ..Traffic::default() });
    }
}

impl Read for Incoming<'_> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        if self.taken == self.buffer.len() && !self.ended {
            let from = self.world.communicator().process_at_rank(self.from as i32);
            self.buffer.resize(MESSAGE, 0);
            let status = from.receive_into_with_tag(&mut self.buffer[..], STREAM.number());
            self.buffer.truncate(status.count(u8::equivalent_datatype()) as usize);
            self.taken = 0;
            self.bytes += self.buffer.len();
            self.ended = self.buffer.len() < MESSAGE;
        }
        let count = out.len().min(self.buffer.len() - self.taken);
        out[..count].copy_from_slice(&self.buffer[self.taken..][..count]);
        self.taken += count;
        Ok(count)
    }
}
