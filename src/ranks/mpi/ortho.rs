//! Orthonormal bases of columns with distributed rows: the algorithms of [`crate::ortho`], with
//! Gram matrices and overlaps summed over the ranks.

use faer::{Mat, MatMut, MatRef};

use super::call::Call;
use super::exchange::Rows;
use super::spread::{SpreadMass, check_mass, mass_fact};
use super::world::{Operation, World, fact, flag, number_fact};
use crate::base::{Par, Progress, Result};
use crate::dense::zeros;
use crate::ortho::{
    GramSchmidtOptions, Orthonormal, TriangularFactor, cholesky_qr_of, gram_schmidt_of,
};
use crate::sparse::Mass;

/// Computes [`ortho::gram_schmidt`](crate::ortho::gram_schmidt()) of a matrix A (n x c) and an
/// inner product of which every rank has some rows, possibly none, in the order of the ranks: `a`
/// has the own rows of A, `mass` is the lumped masses of these rows or own rows x n of a full mass
/// matrix, stored by rows. Every rank gets its rows of Q, and all of R and the kept columns.
///
/// The result depends, by rounding, on the number of ranks and on the distribution of the rows, but
/// not on threads. R and the small matrices are computed by every rank and must be the same
/// everywhere, so all ranks need the same instruction set. Every product with a full mass costs
/// messages: rows that are adjacent to those of the rank.
///
/// ```no_run
/// use catamaran::ranks::{World, gram_schmidt};
/// use catamaran::{faer::Mat, ortho::GramSchmidtOptions, sparse::Mass};
///
/// # let start = mpi::initialize_with_threading(mpi::Threading::Funneled);
/// # let (universe, _) = start.expect("MPI is started once");
/// # let world = World::new(&universe.world())?;
/// // Every rank has 5 rows; the second column is twice the first.
/// let own = Mat::<f64>::from_fn(5, 3, |i, j| [1.0, 2.0, i as f64][j]);
/// let options = GramSchmidtOptions::new();
/// let found = gram_schmidt(&world, own.as_ref(), &Mass::identity(5), &options)?;
/// assert_eq!((found.q.shape(), found.kept), ((5, 2), vec![0, 2]));
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Rank`](crate::Error::Rank) when arguments differ, or another rank failed or cancelled;
/// else as [`ortho::gram_schmidt`](crate::ortho::gram_schmidt()), rows of A counted from the first
/// own one.
pub fn gram_schmidt(
    world: &World,
    a: MatRef<'_, f64>,
    mass: &Mass,
    options: &GramSchmidtOptions<'_>,
) -> Result<Orthonormal> {
    let mut q = zeros(a.nrows(), a.ncols())?;
    q.copy_from(a);
    let TriangularFactor { r, kept } = gram_schmidt_in_place(world, q.as_mut(), mass, options)?;
    q.truncate(a.nrows(), kept.len());
    Ok(Orthonormal { q, r, kept })
}

/// Computes [`gram_schmidt`] in the memory of the own rows of A. Afterwards the first `kept.len()`
/// columns are those of Q, and the other columns are unspecified.
///
/// ```no_run
/// use catamaran::ranks::{World, gram_schmidt_in_place};
/// use catamaran::{faer::Mat, ortho::GramSchmidtOptions, sparse::Mass};
///
/// # let start = mpi::initialize_with_threading(mpi::Threading::Funneled);
/// # let (universe, _) = start.expect("MPI is started once");
/// # let world = World::new(&universe.world())?;
/// // Every rank has 5 rows; the second column is twice the first.
/// let mut own = Mat::<f64>::from_fn(5, 3, |i, j| [1.0, 2.0, i as f64][j]);
/// let options = GramSchmidtOptions::new();
/// let found = gram_schmidt_in_place(&world, own.as_mut(), &Mass::identity(5), &options)?;
/// assert_eq!(found.kept, [0, 2]);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// As [`gram_schmidt`]; A is unspecified after an error.
pub fn gram_schmidt_in_place(
    world: &World,
    a: MatMut<'_, f64>,
    mass: &Mass,
    options: &GramSchmidtOptions<'_>,
) -> Result<TriangularFactor> {
    let (own, c) = a.shape();
    let facts = [
        fact("the number of columns", c),
        mass_fact(mass),
        number_fact("the threshold", options.threshold),
        flag("re-orthogonalization", options.reorthogonalize),
    ];
    Call::run(world, Operation::GramSchmidt, &facts, |call| {
        let rows = Rows::new(call, own)?;
        check_mass(call, &rows, mass)?;
        let mass = SpreadMass::new(call, &rows, mass)?;
        gram_schmidt_of(a, &mass, options)
    })
}

/// Computes [`ortho::cholesky_qr`](crate::ortho::cholesky_qr()) of a matrix and an inner product
/// that are distributed as for [`gram_schmidt`]: the rows of A of a rank become those of Q, and
/// every rank gets R. For each of the two to six passes, a rank sends and receives the packed
/// triangle of a c x c matrix at most twice; and once nine numbers for each column, the order of
/// magnitude of its largest entry.
///
/// ```no_run
/// use catamaran::ranks::{World, cholesky_qr};
/// use catamaran::{Par, faer::Mat, sparse::Mass};
///
/// # let start = mpi::initialize_with_threading(mpi::Threading::Funneled);
/// # let (universe, _) = start.expect("MPI is started once");
/// # let world = World::new(&universe.world())?;
/// // Every rank has 5 rows.
/// let a = Mat::<f64>::from_fn(5, 2, |i, j| (i as f64).powi(j as i32));
/// let mut q = a.clone();
/// let r = cholesky_qr(&world, q.as_mut(), &Mass::identity(5), Par::Seq)?;
/// assert!((q * r - a).norm_max() < 1e-12);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Rank`](crate::Error::Rank) when arguments differ, or another rank failed; else as
/// [`ortho::cholesky_qr`](crate::ortho::cholesky_qr()), rows of A counted from the first own one.
pub fn cholesky_qr(world: &World, a: MatMut<'_, f64>, mass: &Mass, par: Par) -> Result<Mat<f64>> {
    watched_cholesky_qr(world, a, mass, par, Progress::none())
}

/// Computes [`cholesky_qr`], and reports progress.
///
/// # Errors
/// Those of [`cholesky_qr`], and [`Error::Cancelled`](crate::Error::Cancelled).
pub fn watched_cholesky_qr(
    world: &World,
    a: MatMut<'_, f64>,
    mass: &Mass,
    par: Par,
    progress: Progress<'_>,
) -> Result<Mat<f64>> {
    let facts = [fact("the number of columns", a.ncols()), mass_fact(mass)];
    Call::run(world, Operation::CholeskyQr, &facts, |call| {
        let rows = Rows::new(call, a.nrows())?;
        check_mass(call, &rows, mass)?;
        cholesky_qr_of(a, &SpreadMass::new(call, &rows, mass)?, par, progress)
    })
}
