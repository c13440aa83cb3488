//! Eigenpairs of a pencil whose rows are spread over the ranks: the iteration of [`crate::sparse`] with a basis that is
//! spread, and a factor that every rank has (docs/algorithms/eigen.md says why).

use faer::{Mat, MatMut, MatRef};
use sprs::CsMatView;

use super::call::Call;
use super::exchange::{Rows, exchange};
use super::memory::{entries, put_entries};
use super::spread::{
    SpreadMass, SpreadMatrix, check_mass_shape, check_rows, gather_mass, gather_matrix, mass_fact,
};
use super::world::{Operation, World, number_fact};
use crate::base::{Error, Par, Result};
use crate::dense::zeros;
use crate::sparse::{EigenOptions, Eigenpairs, InnerSpace, Mass, Pencil, check_problem, eigs_of};

/// [`sparse::eigs`](crate::sparse::eigs()) of matrices of which every rank has some rows, in the order of the ranks, 0
/// included: `stiffness` is own rows x n, stored by rows; `mass` is the lumped masses of the own rows, or own rows x n of
/// a full mass matrix. Every rank gets all eigenvalues and residuals, and its rows of the eigenvectors.
///
/// The basis, `2 k + 80` vectors, is spread, and so is all work with it; every rank holds both matrices and the factor
/// of `W - sigma M`, and solves for its share of the eight right-hand sides of a step. The start does not depend on the
/// number of ranks, the rounding does. Small matrices are treated by every rank, and must come out the same everywhere,
/// so that all need the same instruction set.
///
/// ```no_run
/// use catamaran::mpi::{World, eigs};
/// use catamaran::sparse::{CsMat, EigenOptions, Mass};
///
/// # let start = mpi::initialize_with_threading(mpi::Threading::Funneled);
/// # let (universe, _) = start.expect("MPI is started once");
/// # let world = World::new(&universe.world())?;
/// // The path with one vertex on each rank: its row of the Laplacian.
/// let (own, n) = (world.rank(), world.size());
/// let (first, last) = (own.saturating_sub(1), (own + 1).min(n - 1));
/// let columns: Vec<usize> = (first..=last).collect();
/// let degree = columns.len() as f64 - 1.0;
/// let values = columns.iter().map(|&j| if j == own { degree } else { -1.0 }).collect();
/// let row = CsMat::new((1, n), vec![0, columns.len()], columns, values);
/// let pairs = eigs(&world, row.view(), &Mass::identity(1), &EigenOptions::new().k(1))?;
/// assert!(pairs.values[0].abs() < 1e-9); // the constant
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Rank`] when arguments differ, or another rank failed or cancelled; [`Error::Argument`] of "stiffness" or
/// "mass" that is stored by columns; else as [`sparse::eigs`](crate::sparse::eigs()).
pub fn eigs(
    world: &World,
    stiffness: CsMatView<'_, f64>,
    mass: &Mass,
    options: &EigenOptions<'_>,
) -> Result<Eigenpairs> {
    let (own, n) = stiffness.shape();
    let facts = [
        ("n", n),
        ("k", options.k),
        number_fact("the shift", options.shift.unwrap_or(f64::NAN)),
        number_fact("the tolerance", options.tolerance),
        ("verify_count", usize::from(options.verify_count)),
        ("the seed", options.seed as usize),
        ("the number of restarts", options.max_restarts),
        mass_fact(mass),
    ];
    Call::run(world, Operation::Eigenpairs, &facts, |call| {
        let rows = Rows::new(call, own)?;
        Error::check_shape("stiffness", (n, n), (rows.count(), n))?;
        check_rows("stiffness", stiffness, own, n)?;
        check_mass_shape(mass, &rows)?;
        let whole = gather_matrix(call, &rows, stiffness)?;
        let whole_mass = gather_mass(call, &rows, mass)?;
        check_problem(whole.view(), &whole_mass, options)?;
        let pencil = SpreadPencil {
            call,
            rows: &rows,
            stiffness: SpreadMatrix::new(call, &rows, stiffness)?,
            mass: SpreadMass::new(call, &rows, mass)?,
        };
        eigs_of(&pencil, whole.view(), &whole_mass, options)
    })
}

struct SpreadPencil<'c> {
    call: &'c Call<'c>,
    rows: &'c Rows,
    stiffness: SpreadMatrix,
    mass: SpreadMass<'c>,
}

impl Pencil for SpreadPencil<'_> {
    fn inner(&self) -> &dyn InnerSpace {
        &self.mass
    }

    fn apply_stiffness(&self, x: MatRef<'_, f64>, y: MatMut<'_, f64>, par: Par) -> Result<()> {
        self.stiffness.multiply(self.call, x, y, par)
    }

    fn map_columns(
        &self,
        x: MatMut<'_, f64>,
        map: &dyn Fn(MatMut<'_, f64>) -> Result<()>,
    ) -> Result<()> {
        by_columns(self.call, self.rows, x, map)
    }
}

/// Applies `map` to X: to its share of the columns on each rank, with all rows.
fn by_columns(
    call: &Call<'_>,
    rows: &Rows,
    mut x: MatMut<'_, f64>,
    map: &dyn Fn(MatMut<'_, f64>) -> Result<()>,
) -> Result<()> {
    let (ranks, count) = (rows.ranks(), x.ncols());
    let columns = |rank: usize| rank * count / ranks..(rank + 1) * count / ranks;
    let own = columns(call.world.rank());
    let outgoing = (0..ranks)
        .map(|rank| entries(x.as_ref().subcols(columns(rank).start, columns(rank).len())))
        .collect::<Result<_>>()?;
    let lens: Vec<usize> = (0..ranks).map(|rank| rows.of(rank).len() * own.len()).collect();
    let parts = exchange(call, outgoing, &lens)?;
    let mut whole: Mat<f64> = zeros(rows.count(), own.len())?;
    for (rank, part) in parts.iter().enumerate() {
        let span = rows.of(rank);
        put_entries(whole.as_mut().subrows_mut(span.start, span.len()), part);
    }
    drop(parts);
    map(whole.as_mut())?;
    let outgoing = (0..ranks)
        .map(|rank| entries(whole.as_ref().subrows(rows.of(rank).start, rows.of(rank).len())))
        .collect::<Result<_>>()?;
    let lens: Vec<usize> = (0..ranks).map(|rank| rows.own().len() * columns(rank).len()).collect();
    for (rank, part) in exchange(call, outgoing, &lens)?.iter().enumerate() {
        let span = columns(rank);
        put_entries(x.as_mut().subcols_mut(span.start, span.len()), part);
    }
    Ok(())
}
