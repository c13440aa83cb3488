//! Block-cyclic A and C, as ScaLAPACK has them.

use faer::{MatMut, MatRef};

use super::bricks::ata_bricks;
use super::columns::ata_columns;
use super::memory::{Buffer, append_rows};
use super::rows::ata_rows;
use super::symmetric::Symmetric;
use super::tags::CYCLIC;
use super::transfer::Transfer;
use super::world::{MpiReal, Operation, World, fact, flag, number_fact, scalar_fact};
use crate::base::{Error, Real, Result};
use crate::product::{AtaOptions, Uplo};
use crate::ranks::plan::{BlockCyclic, CutInto, Delivery, GridOrder, Parts, Piece};

/// The part of a block-cyclic matrix that a rank holds.
#[derive(Debug, Clone, Copy)]
pub struct CyclicRef<'a, T> {
    /// How the whole matrix is distributed.
    pub matrix: BlockCyclic,
    /// The entries of this rank: [`BlockCyclic::local_shape`], any strides.
    pub entries: MatRef<'a, T>,
}

impl<T> CyclicRef<'_, T> {
    /// Returns the transposed matrix, on the transposed grid.
    pub fn transpose(self) -> Self {
        Self { matrix: self.matrix.transpose(), entries: self.entries.transpose() }
    }
}

/// The part of a block-cyclic matrix that a rank holds, to be written.
#[derive(Debug)]
pub struct CyclicMut<'a, T> {
    /// How the whole matrix is distributed.
    pub matrix: BlockCyclic,
    /// The entries of this rank: [`BlockCyclic::local_shape`], any strides.
    pub entries: MatMut<'a, T>,
}

/// Computes `C := alpha A^T A + beta C` for block-cyclic A, m x n, and C, n x n, the triangle or
/// triangles of `options.uplo`. This is PDSYRK with TRANS = 'T', of whole matrices.
///
/// The blocks, the first processes and even the grids of A and C may differ. Ranks outside of a
/// grid hold nothing, but take part in the product. A is redistributed by rows, by columns or by
/// bricks, whichever costs the fewest words (see [`Parts::new`]), [`ata_rows`], [`ata_columns`] or
/// [`ata_bricks`] multiplies the parts, and the result is sent to C. Each rank sends about
/// `m n / P` and `n^2 / (2 P)` words more than these functions do, in at most P - 1 messages each
/// (`n^2 / P` for both triangles). Beside A and C a rank holds its part of A, as much again as one
/// message each way, and what the function of the product holds.
///
/// With `beta == 0` C is not read. Otherwise each requested triangle is added to its own old
/// values, so for [`Uplo::Both`] the old C must be symmetric. C is untouched after any error. The
/// result depends, by rounding, on the number of ranks and on the distribution of A.
///
/// ```no_run
/// use catamaran::ranks::plan::{BlockCyclic, Grid, GridOrder};
/// use catamaran::ranks::{CyclicMut, CyclicRef, World, ata_cyclic};
/// use catamaran::{AtaOptions, faer::Mat};
///
/// # let start = mpi::initialize_with_threading(mpi::Threading::Funneled);
/// # let (universe, _) = start.expect("MPI is started once");
/// # let world = World::new(&universe.world())?;
/// // Blocks of 2 x 2 on a column of ranks, as ScaLAPACK has them.
/// let grid = Grid::new(world.size(), 1, GridOrder::Rows)?;
/// let a = BlockCyclic::new("A", (100, 8), (2, 2), (0, 0), grid)?;
/// let c = BlockCyclic::new("C", (8, 8), (2, 2), (0, 0), grid)?;
/// let [(m, n), (k, l)] = [a, c].map(|matrix| matrix.local_shape(world.rank()));
/// let (own_a, mut own_c) = (Mat::<f64>::ones(m, n), Mat::<f64>::zeros(k, l));
/// let a = CyclicRef { matrix: a, entries: own_a.as_ref() };
/// let result = CyclicMut { matrix: c, entries: own_c.as_mut() };
/// ata_cyclic(&world, 1.0, a, 0.0, result, &AtaOptions::new())?;
/// if world.rank() == 0 {
///     assert_eq!(own_c[(0, 0)], 100.0);
/// }
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Shape`] when C is not n x n or entries are not those of the rank, [`Error::Argument`]
/// when a grid has more ranks than there are, [`Error::Rank`] when a descriptor, alpha, beta, a
/// triangle or the precision differs, or another rank failed; else as
/// [`ata_into`](crate::ata_into).
pub fn ata_cyclic<T: MpiReal>(
    world: &World,
    alpha: T,
    a: CyclicRef<'_, T>,
    beta: T,
    c: CyclicMut<'_, T>,
    options: &AtaOptions<'_>,
) -> Result<()> {
    product(world, alpha, a, false, beta, c, options)
}

/// Computes `C := alpha A A^T + beta C` for block-cyclic A, n x m, and C, n x n. This is PDSYRK
/// with TRANS = 'N', of whole matrices, and equals [`ata_cyclic`] of the transposed A.
///
/// ```no_run
/// use catamaran::ranks::plan::{BlockCyclic, Grid, GridOrder};
/// use catamaran::ranks::{CyclicMut, CyclicRef, World, aat_cyclic};
/// use catamaran::{AtaOptions, faer::Mat};
///
/// # let start = mpi::initialize_with_threading(mpi::Threading::Funneled);
/// # let (universe, _) = start.expect("MPI is started once");
/// # let world = World::new(&universe.world())?;
/// // Blocks of 2 x 2 on a column of ranks, as ScaLAPACK has them.
/// let grid = Grid::new(world.size(), 1, GridOrder::Rows)?;
/// let a = BlockCyclic::new("A", (100, 8), (2, 2), (0, 0), grid)?;
/// let c = BlockCyclic::new("C", (100, 100), (2, 2), (0, 0), grid)?;
/// let [(m, n), (k, l)] = [a, c].map(|matrix| matrix.local_shape(world.rank()));
/// let (own_a, mut own_c) = (Mat::<f64>::ones(m, n), Mat::<f64>::zeros(k, l));
/// let a = CyclicRef { matrix: a, entries: own_a.as_ref() };
/// let result = CyclicMut { matrix: c, entries: own_c.as_mut() };
/// aat_cyclic(&world, 1.0, a, 0.0, result, &AtaOptions::new())?;
/// if world.rank() == 0 {
///     assert_eq!(own_c[(0, 0)], 8.0);
/// }
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// As [`ata_cyclic`].
pub fn aat_cyclic<T: MpiReal>(
    world: &World,
    alpha: T,
    a: CyclicRef<'_, T>,
    beta: T,
    c: CyclicMut<'_, T>,
    options: &AtaOptions<'_>,
) -> Result<()> {
    product(world, alpha, a, true, beta, c, options)
}

fn product<T: MpiReal>(
    world: &World,
    alpha: T,
    a: CyclicRef<'_, T>,
    transposed: bool,
    beta: T,
    c: CyclicMut<'_, T>,
    options: &AtaOptions<'_>,
) -> Result<()> {
    let _guard = world.abort_on_panic();
    let given = a.matrix;
    // Errors name A as it was given.
    let n = if transposed { given.shape().0 } else { given.shape().1 };
    let checked = check(world, a, n, &c);
    let a = if transposed { a.transpose() } else { a };
    let prepared =
        checked.and_then(|()| Collection::new(Parts::new(a.matrix, world.size()), world));
    let collection = begin(world, given, transposed, alpha, beta, &c, options.uplo, prepared)?;
    let (cut, bricks) = (collection.parts.cut(), collection.parts.bricks().clone());
    let (entries, (height, width)) = collection.collect(world, a.entries);
    let part = MatRef::from_column_major_slice(&entries, height, width);
    let result = match cut {
        CutInto::Rows => ata_rows(world, alpha, part, options)?,
        CutInto::Columns => ata_columns(world, alpha, part, options)?,
        CutInto::Bricks => ata_bricks(world, alpha, &bricks, part, options)?,
    };
    drop(entries);
    deliver(world, &result, beta, c, options.uplo)
}

/// Checks what this rank can check alone; C must be n x n.
fn check<T>(world: &World, a: CyclicRef<'_, T>, n: usize, c: &CyclicMut<'_, T>) -> Result<()> {
    Error::check_shape("C", (n, n), c.matrix.shape())?;
    for grid in [a.matrix.grid(), c.matrix.grid()] {
        if grid.size() > world.size() {
            let (rows, cols, ranks) = (grid.rows(), grid.cols(), world.size());
            let why = format!("{rows} x {cols} needs more than the {ranks} ranks there are");
            return Err(Error::Argument { what: "grid", why });
        }
    }
    let rank = world.rank();
    Error::check_shape("this rank's part of A", a.matrix.local_shape(rank), a.entries.shape())?;
    Error::check_shape("this rank's part of C", c.matrix.local_shape(rank), c.entries.shape())
}

/// Agrees on everything that must be the same on all ranks, a few numbers at a time.
fn begin<T: MpiReal, X>(
    world: &World,
    a: BlockCyclic,
    transposed: bool,
    alpha: T,
    beta: T,
    c: &CyclicMut<'_, T>,
    uplo: Uplo,
    prepared: Result<X>,
) -> Result<X> {
    let scalars = [
        scalar_fact::<T>(),
        flag("the transposition", transposed),
        number_fact("alpha", alpha),
        number_fact("beta", beta),
        fact("the triangle", uplo as usize),
    ];
    let prepared = world.begin(Operation::Cyclic, &scalars, prepared)?;
    let names = [
        ["M_ of A", "N_ of A", "MB_ of A", "NB_ of A", "RSRC_ of A", "CSRC_ of A"],
        ["M_ of C", "N_ of C", "MB_ of C", "NB_ of C", "RSRC_ of C", "CSRC_ of C"],
    ];
    for (names, matrix) in names.into_iter().zip([a, c.matrix]) {
        let (rows, cols) = (matrix.rows(), matrix.cols());
        let numbers =
            [rows.len(), cols.len(), rows.block(), cols.block(), rows.first(), cols.first()];
        let facts: Vec<_> = names.into_iter().zip(numbers).map(|(what, n)| fact(what, n)).collect();
        world.begin(Operation::Cyclic, &facts, Ok(()))?;
    }
    let (a, c) = (a.grid(), c.matrix.grid());
    let grids = [
        fact("the rows of A's grid", a.rows()),
        fact("the columns of A's grid", a.cols()),
        fact("the order of A's grid", usize::from(a.order() == GridOrder::Columns)),
        fact("the rows of C's grid", c.rows()),
        fact("the columns of C's grid", c.cols()),
        fact("the order of C's grid", usize::from(c.order() == GridOrder::Columns)),
    ];
    world.begin(Operation::Cyclic, &grids, Ok(()))?;
    Ok(prepared)
}

/// The redistribution of A from a grid to parts of rows or columns.
struct Collection<T> {
    parts: Parts,
    buffers: Buffers<T>,
    /// The part of this rank, column by column.
    part: Buffer<T>,
}

impl<T: MpiReal> Collection<T> {
    fn new(parts: Parts, world: &World) -> Result<Self> {
        let (height, width) = parts.shape(world.rank());
        let len = |from, to| match parts.piece(from, to) {
            Some(piece) if from != to => piece.len(),
            _ => 0,
        };
        let buffers = Buffers::new(world, len)?;
        Ok(Self { buffers, part: Buffer::of_len(height.saturating_mul(width))?, parts })
    }

    /// Returns the part of this rank, column by column, and its shape.
    fn collect(self, world: &World, entries: MatRef<'_, T>) -> (Buffer<T>, (usize, usize)) {
        let Self { parts, buffers, mut part } = self;
        let own = world.rank();
        let shape = parts.shape(own);
        let mut place = |from: usize, piece: Piece, held: MatRef<'_, T>| {
            for (j, col) in piece.cols.enumerate() {
                let at = parts.place_of_col(from, own, col) * shape.0 + piece.first_row;
                let column = &mut part[at..at + held.nrows()];
                match held.col(j).try_as_col_major() {
                    Some(entries) => column.copy_from_slice(entries.as_slice()),
                    None => column.iter_mut().zip(held.col(j).iter()).for_each(|(to, &x)| *to = x),
                }
            }
        };
        if let Some(piece) = parts.piece(own, own) {
            let held = entries.get(piece.rows.clone(), piece.cols.clone());
            place(own, piece, held);
        }
        let pack = |to: usize, buffer: &mut Buffer<T>| {
            let Some(piece) = parts.piece(own, to) else { return };
            // Column by column.
            append_rows(buffer, entries.get(piece.rows, piece.cols).transpose());
        };
        let unpack = |from: usize, buffer: &[T]| {
            let Some(piece) = parts.piece(from, own) else { return };
            let (rows, cols) = (piece.rows.len(), piece.cols.len());
            place(from, piece, MatRef::from_column_major_slice(buffer, rows, cols));
        };
        exchange(world, buffers, pack, unpack);
        (part, shape)
    }
}

/// Adds the result to C.
fn deliver<T: MpiReal>(
    world: &World,
    result: &Symmetric<T>,
    beta: T,
    c: CyclicMut<'_, T>,
    uplo: Uplo,
) -> Result<()> {
    let own = world.rank();
    let delivery = Delivery { result: result.layout(), target: c.matrix, uplo };
    let buffers = Buffers::new(world, |from, to| delivery.len(from, to));
    let mut buffers = world.agree(buffers)?;
    let held = result.entries();
    let mut entries = c.entries;
    let pack = |to: usize, buffer: &mut Buffer<T>| {
        delivery.runs(own, to, |run| buffer.extend_from_slice(&held[run.at..run.at + run.len]));
    };
    let mut unpack = |from: usize, buffer: &[T]| {
        let mut values = buffer.iter();
        delivery.runs(from, own, |run| {
            for (k, &value) in values.by_ref().take(run.len).enumerate() {
                let (down, along) = if run.down { (k, 0) } else { (0, k) };
                let entry = &mut entries[(run.row + down, run.col + along)];
                *entry = if beta == T::ZERO { value } else { beta * *entry + value };
            }
        });
    };
    pack(own, &mut buffers.outgoing);
    unpack(own, &buffers.outgoing);
    exchange(world, buffers, pack, unpack);
    Ok(())
}

/// Memory for one message each way, and the lengths of the messages.
struct Buffers<T> {
    outgoing: Buffer<T>,
    incoming: Buffer<T>,
    /// Number of entries to be received from each rank.
    received: Vec<usize>,
}

impl<T: Real> Buffers<T> {
    /// Creates the buffers; rank `from` sends `len(from, to)` entries to rank `to`.
    fn new(world: &World, len: impl Fn(usize, usize) -> usize) -> Result<Self> {
        let (own, ranks) = (world.rank(), world.size());
        let received: Vec<usize> = (0..ranks).map(|from| len(from, own)).collect();
        let others = received.iter().enumerate().filter(|&(from, _)| from != own);
        let incoming = Buffer::with_room(others.map(|(_, len)| *len).max().unwrap_or(0))?;
        let outgoing = Buffer::with_room((0..ranks).map(|to| len(own, to)).max().unwrap_or(0))?;
        Ok(Self { outgoing, incoming, received })
    }
}

/// Sends to every other rank what `pack` appends for it, and passes to `unpack` what comes from
/// each.
///
/// In round k a rank sends to the k-th rank after it and receives from the k-th before it: no rank
/// receives from two at once, and memory for one message each way is enough. An empty message is
/// not sent.
fn exchange<T: MpiReal>(
    world: &World,
    buffers: Buffers<T>,
    mut pack: impl FnMut(usize, &mut Buffer<T>),
    mut unpack: impl FnMut(usize, &[T]),
) {
    let Buffers { mut outgoing, mut incoming, received } = buffers;
    let (own, ranks) = (world.rank(), world.size());
    for round in 1..ranks {
        let (to, from) = ((own + round) % ranks, (own + ranks - round) % ranks);
        incoming.set_len(received[from]);
        let arriving = Transfer::receive(world, incoming, from, CYCLIC);
        outgoing.set_len(0);
        pack(to, &mut outgoing);
        let leaving = Transfer::send(world, outgoing, [to], CYCLIC);
        incoming = arriving.wait();
        unpack(from, &incoming);
        outgoing = leaving.wait();
    }
}
