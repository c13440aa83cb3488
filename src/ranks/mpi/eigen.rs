//! Eigenpairs of a pencil whose rows are distributed over the ranks: the iteration of
//! [`crate::sparse`] with a distributed basis and a distributed factorization
//! (docs/algorithms/eigen.md).

use faer::{Mat, MatMut, MatRef};
use sprs::{CsMat, CsMatView};

use super::call::Call;
use super::components::null_components;
use super::domains::{Domains, SpreadGraph};
use super::exchange::{Rows, gather_lists};
use super::factor::SpreadShifts;
use super::moves::Moves;
use super::spread::{
    SpreadMass, SpreadMatrix, check_mass_shape, check_pencil, check_rows, gather_mass,
    gather_matrix, mass_fact,
};
use super::world::{Operation, World, fact, flag, number_fact};
use crate::base::{Error, Par, Result};
use crate::sparse::{
    self, EigenOptions, Eigenpairs, InnerSpace, Mass, Outline, Pencil, Problem, check_problem,
    is_dense, multiply_by_differences, multiply_magnitudes, one_window, without_iteration,
};

/// Computes [`sparse::eigs`](crate::sparse::eigs()) of matrices of which every rank has some rows,
/// possibly none, in the order of the ranks. `stiffness` is own rows x n, stored by rows; `mass` is
/// the lumped masses of the own rows, or own rows x n of a full mass matrix. Every rank gets all
/// eigenvalues and residuals, and its rows of the eigenvectors.
///
/// The basis, `2 k + 80` vectors, all work with it, the matrices and the factorization of `W -
/// sigma M` are distributed: rows move to the rank of their domain, of about n / P rows that touch
/// no other domain, each rank eliminates its domain, and every rank eliminates the Schur complement
/// of the interface between the domains. No rank holds all rows of a matrix, unless they are so few
/// that the problem is solved as a dense one; every rank holds a number for each row now and then.
/// The starting vectors and the rounding depend on the number of ranks. Small matrices, and the
/// interface, are processed by every rank and must give the same bits everywhere, so all ranks need
/// the same instruction set. On one rank this is [`sparse::eigs`](crate::sparse::eigs()).
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
        if rows.ranks() == 1 {
            return sparse::eigs(stiffness, mass, options);
        }
        if is_dense(options.k, n) {
            return whole(call, &rows, stiffness, mass, options);
        }
        check_pencil(call, &rows, stiffness, mass)?;
        options.check(n)?;
        let (moves, stiffness, mass) = moved(call, &rows, stiffness, mass)?;
        let pencil = SpreadPencil {
            call,
            stiffness: SpreadMatrix::new(call, &moves.rows, stiffness.view())?,
            mass: SpreadMass::new(call, &moves.rows, &mass)?,
        };
        let outline = pencil.outline(&moves.rows, stiffness.view(), &mass)?;
        let shifts = SpreadShifts::new(call, &moves, stiffness.view(), &mass)?;
        drop(stiffness);
        let problem = Problem::new(&pencil, outline, Box::new(shifts));
        options.progress.report(0.01)?;
        let pairs = one_window(&problem, options)?;
        let vectors = moves.back(call, pairs.vectors.as_ref())?;
        Ok(Eigenpairs { vectors, ..pairs })
    })
}

/// Computes pairs of small matrices, which every rank gets whole.
fn whole(
    call: &Call<'_>,
    rows: &Rows,
    stiffness: CsMatView<'_, f64>,
    mass: &Mass,
    options: &EigenOptions<'_>,
) -> Result<Eigenpairs> {
    let pencil = SpreadPencil {
        call,
        stiffness: SpreadMatrix::new(call, rows, stiffness)?,
        mass: SpreadMass::new(call, rows, mass)?,
    };
    let stiffness = gather_matrix(call, rows, stiffness)?;
    let mass = gather_mass(call, rows, mass)?;
    check_problem(stiffness.view(), &mass, options)?;
    let pairs = without_iteration(&pencil, stiffness.view(), &mass, options)?;
    Ok(pairs.expect("small matrices need no iteration"))
}

/// Returns the distribution of the rows by domains, and the rows of this rank in it.
fn moved(
    call: &Call<'_>,
    rows: &Rows,
    stiffness: CsMatView<'_, f64>,
    mass: &Mass,
) -> Result<(Moves, CsMat<f64>, Mass)> {
    let graph = SpreadGraph::of_pencil(call, rows, stiffness, mass)?;
    let domains = Domains::new(call, rows, &graph)?;
    let moves = Moves::new(call, rows, &graph, &domains)?;
    let stiffness = moves.matrix(call, stiffness)?;
    let mass = moves.mass(call, mass)?;
    Ok((moves, stiffness, mass))
}

struct SpreadPencil<'c> {
    call: &'c Call<'c>,
    stiffness: SpreadMatrix,
    mass: SpreadMass<'c>,
}

impl SpreadPencil<'_> {
    /// Finds what runs need to know about matrices with these rows on this rank.
    fn outline(&self, rows: &Rows, stiffness: CsMatView<'_, f64>, mass: &Mass) -> Result<Outline> {
        let own = rows.own();
        let diagonal = |i: usize| match mass {
            Mass::Full(matrix) => matrix.get(i, own.start + i).copied().unwrap_or(0.0),
            Mass::Lumped(masses) => masses[i],
        };
        let ratio =
            |i: usize| stiffness.get(i, own.start + i).copied().unwrap_or(0.0) / diagonal(i);
        let mut sum = Mat::from_fn(1, 1, |_, _| (0..own.len()).map(diagonal).sum());
        self.call.sum(sum.as_mut())?;
        let ratios: Vec<f64> = (0..own.len()).map(ratio).collect();
        let (ratios, _) = gather_lists(self.call, &ratios)?;
        let mut matrices = vec![&self.stiffness];
        matrices.extend(self.mass.matrix());
        let mean_mass = sum[(0, 0)] / rows.count() as f64;
        let null = null_components(self.call, rows, stiffness, &matrices)?;
        Ok(Outline::new(ratios, mean_mass, null))
    }
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
