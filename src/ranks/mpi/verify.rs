//! The probabilistic check of a distributed result.

use std::ops::Range;

use faer::prelude::IntoConst;
use faer::{MatMut, MatRef};

use super::symmetric::Symmetric;
use super::world::{MpiReal, Operation, World, fact, number_fact};
use crate::base::{Error, Result, zeros};
use crate::blas::{self, Kernels};
use crate::product::{Verification, check_rounds, refuse_non_finite, signs, verdict};
use crate::ranks::plan::Bricks;

/// A matrix of which every rank holds a part.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub enum Distributed<'a, T> {
    /// Rows, as for [`ata_rows`](super::ata_rows).
    Rows(MatRef<'a, T>),
    /// Columns in the order of the ranks, as for [`ata_columns`](super::ata_columns).
    Columns(MatRef<'a, T>),
    /// Some rows of some columns, as for [`ata_bricks`](super::ata_bricks).
    Bricks(MatRef<'a, T>, &'a Bricks),
}

/// Rows that are multiplied at once.
const HEIGHT: usize = 1024;

/// Checks `C = alpha A^T A` with `rounds` random vectors of signs, as
/// [`product::verify`](crate::product::verify()) does; all ranks get the same verdict.
///
/// Each rank works on its parts of A and C, in O(rounds (m n + n^2) / P), and holds 2 n x rounds
/// numbers. Vectors of n x rounds entries are summed over the ranks, of m x rounds too when A is
/// spread by columns or bricks; they do not count as traffic.
///
/// ```no_run
/// use catamaran::ranks::{Distributed, World, ata_rows, verify};
/// use catamaran::{AtaOptions, faer::Mat};
///
/// # let start = mpi::initialize_with_threading(mpi::Threading::Funneled);
/// # let (universe, _) = start.expect("MPI is started once");
/// # let world = World::new(&universe.world())?;
/// let own = Mat::<f64>::from_fn(100, 8, |i, j| (world.rank() + i * j % 7) as f64);
/// let c = ata_rows(&world, 1.0, own.as_ref(), &AtaOptions::new())?;
/// assert!(verify(&world, 1.0, Distributed::Rows(own.as_ref()), &c, 20, 0)?.passed);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Rank`] when arguments differ, or another rank failed; [`Error::Argument`] unless
/// `rounds` is in 1..=1000, [`Error::Shape`] when A has not n columns, [`Error::NonFinite`] for the
/// first NaN or infinity of this rank's part, with its place in A, [`Error::OutOfMemory`].
pub fn verify<T: MpiReal>(
    world: &World,
    alpha: f64,
    a: Distributed<'_, T>,
    c: &Symmetric<T>,
    rounds: u32,
    seed: u64,
) -> Result<Verification> {
    let _guard = world.abort_on_panic();
    let (n, r) = (c.n(), rounds as usize);
    let prepared = check_rounds(rounds).and_then(|()| {
        let of_c = (zeros(n * r)?, zeros(n)?);
        Ok((signs(n, rounds, seed), of_c, zeros(HEIGHT * n)?, zeros(HEIGHT * r)?))
    });
    let (spread, own) = match a {
        Distributed::Rows(rows) => (0, rows),
        Distributed::Columns(columns) => (1, columns),
        Distributed::Bricks(brick, _) => (2, brick),
    };
    let facts = [
        fact("n", n),
        fact("the distribution of A (0 rows, 1 columns, 2 bricks)", spread),
        fact("the number of rounds", r),
        fact("the seed", seed as usize),
        number_fact("alpha", alpha),
    ];
    let (x, (mut z, mut norms), mut block, mut y) =
        world.begin(Operation::Verify, &facts, prepared)?;
    let Placed { m, rows, columns } = placed(world, n, a)?;

    add_part(&mut z, c, x.as_ref());
    // - alpha A^T (A X)
    let x = x.subrows(columns.start, columns.len());
    let backend = blas::native();
    let kernels: &dyn Kernels<f64> = backend.as_ref();
    // Several ranks have parts of a row, unless A is spread by rows.
    let all = if spread == 0 { rows.clone() } else { 0..m };
    for start in all.clone().step_by(HEIGHT) {
        let chunk = start..all.end.min(start + HEIGHT);
        let clamped = |row: usize| row.clamp(chunk.start, chunk.end);
        let held = clamped(rows.start)..clamped(rows.end);
        let of_held = (held.start - chunk.start) * r..(held.end - chunk.start) * r;
        let y = &mut y[..chunk.len() * r];
        y.fill(0.0);
        let first = held.start.saturating_sub(rows.start).min(rows.len());
        let block =
            widened(own.subrows(first, held.len()), &mut block, &mut norms[columns.clone()]);
        if !held.is_empty() {
            let out = MatMut::from_row_major_slice_mut(&mut y[of_held.clone()], held.len(), r);
            kernels.gemm(1.0, block.transpose(), x, 0.0, out);
        }
        if spread != 0 {
            world.sum(y);
        }
        if !held.is_empty() {
            let y = MatRef::from_row_major_slice(&y[of_held], held.len(), r);
            let z = MatMut::from_row_major_slice_mut(&mut z, n, r);
            let z = z.subrows_mut(columns.start, columns.len());
            kernels.gemm(-alpha, block, y, 1.0, z);
        }
    }

    let corner = (rows.start, columns.start);
    world.agree(refuse_non_finite(&norms[columns], own, corner))?;
    world.sum(&mut z);
    world.sum(&mut norms);
    Ok(verdict::<T>(alpha, m, MatRef::from_row_major_slice(&z, n, r), &norms))
}

/// Where the part of a rank is in A, which has m rows.
struct Placed {
    m: usize,
    rows: Range<usize>,
    columns: Range<usize>,
}

/// Returns where the part of this rank is.
///
/// # Errors
/// [`Error::Shape`] or [`Error::Rank`] on all ranks unless the parts fit together and have n
/// columns.
fn placed<T>(world: &World, n: usize, a: Distributed<'_, T>) -> Result<Placed> {
    let (own, by_columns) = match a {
        Distributed::Rows(rows) => (rows.shape(), false),
        Distributed::Columns(columns) => (columns.shape(), true),
        Distributed::Bricks(brick, bricks) => {
            let (rows, columns) = (bricks.rows(world.rank()), bricks.columns(world.rank()));
            let m = bricks.m();
            let fits = Error::check_shape("A", (m, n), (m, bricks.n())).and_then(|()| {
                let shape = (rows.len(), columns.len());
                Error::check_shape("this rank's part of A", shape, brick.shape())
            });
            // The sums over the ranks are of the same rows.
            let heights = world.gather_numbers(m);
            let differs = heights.iter().position(|&other| other != heights[0]);
            let same = differs.map_or(Ok(()), |rank| {
                let (m, of_first) = (heights[rank], heights[0]);
                let why = format!("m is {m}, where rank 0 has {of_first}");
                Err(Error::Rank { rank, why })
            });
            world.agree(fits.and(same))?;
            return Ok(Placed { m, rows, columns });
        }
    };
    let (rows, cols) = own;
    let parts = world.gather_numbers(if by_columns { cols } else { rows });
    let heights = world.gather_numbers(rows);
    let first: usize = parts[..world.rank()].iter().sum();
    let (width, m) = match by_columns {
        true => (parts.iter().sum(), heights[0]),
        false => (cols, heights.iter().sum()),
    };
    let fits = Error::check_shape("A", (m, n), (m, width)).and_then(|()| {
        // All parts need the same height, or the sums over the ranks would be of different rows.
        let rows = heights.iter().find(|&&rows| by_columns && rows != m).map_or(m, |&rows| rows);
        Error::check_shape("A", (m, n), (rows, n))
    });
    world.agree(fits)?;
    Ok(match by_columns {
        true => Placed { m, rows: 0..rows, columns: first..first + cols },
        false => Placed { m, rows: first..first + rows, columns: 0..n },
    })
}

/// Adds `C X` for this rank's part of C to Z, by rows.
fn add_part<T: MpiReal>(z: &mut [f64], c: &Symmetric<T>, x: MatRef<'_, f64>) {
    let r = x.ncols();
    c.for_each_segment(|i, start, entries| {
        for (j, entry) in (start..).zip(entries) {
            let entry = entry.to_f64();
            for k in 0..r {
                z[i * r + k] += entry * x[(j, k)];
                if i != j {
                    z[j * r + k] += entry * x[(i, k)];
                }
            }
        }
    });
}

/// Returns the rows as f64 in `memory`, and adds the squares of their columns to `norms`.
fn widened<'m, T: MpiReal>(
    rows: MatRef<'_, T>,
    memory: &'m mut [f64],
    norms: &mut [f64],
) -> MatRef<'m, f64> {
    let (count, width) = rows.shape();
    let mut block = MatMut::from_row_major_slice_mut(&mut memory[..count * width], count, width);
    for i in 0..count {
        for j in 0..width {
            let entry = rows[(i, j)].to_f64();
            block[(i, j)] = entry;
            norms[j] += entry * entry;
        }
    }
    block.into_const()
}
