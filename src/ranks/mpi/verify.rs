//! The probabilistic check of a distributed result.

use faer::prelude::IntoConst;
use faer::{MatMut, MatRef};

use super::symmetric::Symmetric;
use super::world::{MpiReal, Operation, World, fact, number_fact};
use crate::base::{Error, Result, zeros};
use crate::blas::{self, Kernels};
use crate::product::{Verification, check_rounds, refuse_non_finite, signs, verdict};

/// A matrix of which every rank holds a part.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub enum Distributed<'a, T> {
    /// Rows, as for [`ata_rows`](super::ata_rows).
    Rows(MatRef<'a, T>),
    /// Columns in the order of the ranks, as for [`ata_columns`](super::ata_columns).
    Columns(MatRef<'a, T>),
}

/// Rows that are multiplied at once.
const HEIGHT: usize = 1024;

/// Checks `C = alpha A^T A` with `rounds` random vectors of signs, as
/// [`product::verify`](crate::product::verify()) does; all ranks get the same verdict.
///
/// Each rank works on its parts of A and C, in O(rounds (m n + n^2) / P), and holds 2 n x rounds
/// numbers. Vectors of n x rounds entries are summed over the ranks, of m x rounds too when A is
/// spread by columns; they do not count as traffic.
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
    let (by_columns, own) = match a {
        Distributed::Rows(rows) => (false, rows),
        Distributed::Columns(columns) => (true, columns),
    };
    let facts = [
        fact("n", n),
        fact("the distribution of A (0 rows, 1 columns)", usize::from(by_columns)),
        fact("the number of rounds", r),
        fact("the seed", seed as usize),
        number_fact("alpha", alpha),
    ];
    let (x, (mut z, mut norms), mut block, mut y) =
        world.begin(Operation::Verify, &facts, prepared)?;
    let (m, first) = placed(world, n, own.shape(), by_columns)?;
    let columns = if by_columns { first..first + own.ncols() } else { 0..n };

    add_part(&mut z, c, x.as_ref());
    // - alpha A^T (A X)
    let x = x.subrows(columns.start, columns.len());
    let backend = blas::native();
    let kernels: &dyn Kernels<f64> = backend.as_ref();
    for start in (0..own.nrows()).step_by(HEIGHT) {
        let rows = own.subrows(start, HEIGHT.min(own.nrows() - start));
        let block = widened(rows, &mut block, &mut norms[columns.clone()]);
        let count = rows.nrows();
        let y = &mut y[..count * r];
        let out = MatMut::from_row_major_slice_mut(y, count, r);
        kernels.gemm(1.0, block.transpose(), x, 0.0, out);
        if by_columns {
            world.sum(y);
        }
        let y = MatRef::from_row_major_slice(y, count, r);
        let z = MatMut::from_row_major_slice_mut(&mut z, n, r);
        let z = z.subrows_mut(columns.start, columns.len());
        kernels.gemm(-alpha, block, y, 1.0, z);
    }

    let corner = if by_columns { (0, first) } else { (first, 0) };
    world.agree(refuse_non_finite(&norms[columns], own, corner))?;
    world.sum(&mut z);
    world.sum(&mut norms);
    Ok(verdict::<T>(alpha, m, MatRef::from_row_major_slice(&z, n, r), &norms))
}

/// Returns the number of rows of A, and the first row of this rank's part, or its first column.
///
/// # Errors
/// [`Error::Shape`] or [`Error::Rank`] on all ranks unless the parts fit together and have n
/// columns.
fn placed(
    world: &World,
    n: usize,
    (rows, cols): (usize, usize),
    by_columns: bool,
) -> Result<(usize, usize)> {
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
    Ok((m, first))
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
