//! Eigenpairs of a pencil whose rows are distributed over the ranks: the iteration of
//! [`crate::sparse`] with a distributed basis and a distributed factorization
//! (docs/algorithms/eigen.md).

use faer::{MatMut, MatRef};
use sprs::CsMatView;

use super::call::Call;
use super::exchange::Rows;
use super::factor::SpreadShifts;
use super::spread::{
    SpreadMass, SpreadMatrix, check_mass_shape, check_rows, gather_mass, gather_matrix, mass_fact,
};
use super::world::{Operation, World, fact, flag, number_fact};
use crate::base::{Error, Par, Result};
use crate::sparse::{
    EigenOptions, Eigenpairs, InnerSpace, Mass, Pencil, Problem, check_problem,
    multiply_by_differences, multiply_magnitudes, one_window, without_iteration,
};

/// Computes [`sparse::eigs`](crate::sparse::eigs()) of matrices of which every rank has some rows,
/// possibly none, in the order of the ranks. `stiffness` is own rows x n, stored by rows; `mass` is
/// the lumped masses of the own rows, or own rows x n of a full mass matrix. Every rank gets all
/// eigenvalues and residuals, and its rows of the eigenvectors.
///
/// The basis, `2 k + 80` vectors, all work with it, and the factorization of `W - sigma M` are
/// distributed: each rank eliminates a domain of about n / P rows, and every rank eliminates the
/// Schur complement of the interface between the domains. At the beginning every rank reads both
/// matrices to choose the domains. The starting vectors do not depend on the number of ranks, but
/// the rounding does. Small matrices, and the interface, are processed by every rank and must give
/// the same bits everywhere, so all ranks need the same instruction set.
///
/// ```no_run
/// use catamaran::ranks::{World, eigs};
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
/// [`Error::Rank`] when arguments differ, or another rank failed or cancelled; [`Error::Argument`]
/// of "stiffness" or "mass" that is stored by columns; else as
/// [`sparse::eigs`](crate::sparse::eigs()).
pub fn eigs(
    world: &World,
    stiffness: CsMatView<'_, f64>,
    mass: &Mass,
    options: &EigenOptions<'_>,
) -> Result<Eigenpairs> {
    let (own, n) = stiffness.shape();
    let facts = [
        fact("n", n),
        fact("k", options.k),
        number_fact("the shift", options.shift.unwrap_or(f64::NAN)),
        number_fact("the tolerance", options.tolerance),
        flag("verify_count", options.verify_count),
        fact("the seed", options.seed as usize),
        fact("the number of restarts", options.max_restarts),
        mass_fact(mass),
    ];
    Call::run(world, Operation::Eigenpairs, &facts, |call| {
        let rows = Rows::new(call, own)?;
        Error::check_shape("stiffness", (n, n), (rows.count(), n))?;
        check_rows("stiffness", stiffness, own, n)?;
        check_mass_shape(mass, &rows)?;
        let pencil = SpreadPencil {
            call,
            stiffness: SpreadMatrix::new(call, &rows, stiffness)?,
            mass: SpreadMass::new(call, &rows, mass)?,
        };
        let problem = {
            let whole = gather_matrix(call, &rows, stiffness)?;
            let whole_mass = gather_mass(call, &rows, mass)?;
            check_problem(whole.view(), &whole_mass, options)?;
            if let Some(pairs) = without_iteration(&pencil, whole.view(), &whole_mass, options)? {
                return Ok(pairs);
            }
            let shifts = SpreadShifts::new(call, &rows, whole.view(), &whole_mass, options.par)?;
            Problem::new(&pencil, whole.view(), &whole_mass, Box::new(shifts))
        };
        options.progress.report(0.01)?;
        one_window(&problem, options)
    })
}

struct SpreadPencil<'c> {
    call: &'c Call<'c>,
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

    fn apply_differences(&self, x: MatRef<'_, f64>, y: MatMut<'_, f64>, par: Par) -> Result<()> {
        let rows = self.stiffness.rows();
        let extended = self.stiffness.extended(self.call, x)?;
        multiply_by_differences(rows, extended.as_ref(), y, par);
        Ok(())
    }

    fn apply_magnitudes(&self, x: MatRef<'_, f64>, y: MatMut<'_, f64>) -> Result<()> {
        let extended = self.stiffness.extended(self.call, x)?;
        multiply_magnitudes(self.stiffness.rows(), extended.as_ref(), y);
        Ok(())
    }
}
