//! A and C on one rank: AtA-D, or rows distributed to all ranks.

use faer::prelude::ReborrowMut;
use faer::{MatMut, MatRef};

use super::form::Form;
use super::world::{MpiReal, Operation, World, fact, number_fact, scalar_fact};
use super::{deal, tree};
use crate::base::{Error, Result};
use crate::product::combine::mirror_lower;
use crate::product::{AtaOptions, Uplo};
use crate::ranks::plan::{Machine, Mode, Place, choose};

/// Computes `C := alpha A^T A + beta C` where rank `root` has A, m x n, and C, n x n, the triangles
/// of `options.uplo`. The values of A, beta and C on other ranks are not read.
///
/// It calls [`ata_tree`] or [`ata_deal`], whichever [`choose`] expects to be faster for this shape
/// and number of ranks on the default [`Machine`]. The result depends on the shape and the number
/// of ranks only.
///
/// ```no_run
/// use catamaran::ranks::{World, ata_root};
/// use catamaran::{AtaOptions, faer::Mat};
///
/// let start = mpi::initialize_with_threading(mpi::Threading::Funneled);
/// let (universe, _) = start.expect("MPI is started once");
/// let world = World::new(&universe.world())?;
/// let is_root = world.rank() == 0;
/// let a = is_root.then(|| Mat::<f64>::ones(100, 8));
/// let mut c = is_root.then(|| Mat::zeros(8, 8));
/// let (from, to) = (a.as_ref().map(|a| a.as_ref()), c.as_mut().map(|c| c.as_mut()));
/// ata_root(&world, 0, 1.0, from, 0.0, to, &AtaOptions::new())?;
/// assert!(c.is_none_or(|c| c[(7, 0)] == 100.0));
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Argument`] for a root out of range, or A or C missing on it; [`Error::Rank`] when the
/// roots, alpha or the precision differ, or another rank failed; else as
/// [`ata_into`](crate::ata_into). Then C holds unspecified values.
pub fn ata_root<T: MpiReal>(
    world: &World,
    root: usize,
    alpha: T,
    a: Option<MatRef<'_, T>>,
    beta: T,
    c: Option<MatMut<'_, T>>,
    options: &AtaOptions<'_>,
) -> Result<()> {
    let best =
        |form: Form| choose(world.size(), form.m, form.n, &Machine::default(), Place::OneRank);
    from_root(world, root, alpha, a, beta, c, options, best)
}

/// Computes [`ata_root`] by the algorithm AtA-D (thesis, algorithm 8.4).
///
/// Parts of A go down a [`TaskTree`](crate::ranks::plan::TaskTree); parts of C come up and are
/// added in the order of the tree. The root sends its matrices without a copy. Beside them it holds
/// two results of other ranks, of at most `n^2 / 4` entries each. Another rank holds the part of A
/// that it and the ranks below it read, at most `m n / 2` entries from six ranks on (with less, up
/// to all of A), its block of C, at most `n^2 / 4`, and two results of other ranks, at most half of
/// that each.
///
/// ```no_run
/// use catamaran::ranks::{World, ata_tree};
/// use catamaran::{AtaOptions, faer::Mat};
///
/// # let start = mpi::initialize_with_threading(mpi::Threading::Funneled);
/// # let (universe, _) = start.expect("MPI is started once");
/// # let world = World::new(&universe.world())?;
/// let is_root = world.rank() == 0;
/// let a = is_root.then(|| Mat::<f64>::ones(100, 8));
/// let mut c = is_root.then(|| Mat::zeros(8, 8));
/// let (from, to) = (a.as_ref().map(|a| a.as_ref()), c.as_mut().map(|c| c.as_mut()));
/// ata_tree(&world, 0, 1.0, from, 0.0, to, &AtaOptions::new())?;
/// assert!(c.is_none_or(|c| c[(7, 0)] == 100.0));
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// As [`ata_root`].
pub fn ata_tree<T: MpiReal>(
    world: &World,
    root: usize,
    alpha: T,
    a: Option<MatRef<'_, T>>,
    beta: T,
    c: Option<MatMut<'_, T>>,
    options: &AtaOptions<'_>,
) -> Result<()> {
    from_root(world, root, alpha, a, beta, c, options, |_| Mode::Tree)
}

/// Computes [`ata_root`] by rows: the root distributes blocks of rows to the ranks, every rank sums
/// the products of its blocks, and the sums are added, chunk by chunk as by
/// [`sum_symmetric`](super::sum_symmetric), and gathered.
///
/// It suits tall A: every entry of A is sent at most once, and `n^2` entries of C in all. The root
/// sends A without a copy and multiplies its own rows meanwhile. Another rank holds an n x n sum
/// and two blocks of rows, each of at most 64 MiB (or 1024 rows), not more than its rows.
///
/// ```no_run
/// use catamaran::ranks::{World, ata_deal};
/// use catamaran::{AtaOptions, faer::Mat};
///
/// # let start = mpi::initialize_with_threading(mpi::Threading::Funneled);
/// # let (universe, _) = start.expect("MPI is started once");
/// # let world = World::new(&universe.world())?;
/// let is_root = world.rank() == 0;
/// let a = is_root.then(|| Mat::<f64>::ones(100, 8));
/// let mut c = is_root.then(|| Mat::zeros(8, 8));
/// let (from, to) = (a.as_ref().map(|a| a.as_ref()), c.as_mut().map(|c| c.as_mut()));
/// ata_deal(&world, 0, 1.0, from, 0.0, to, &AtaOptions::new())?;
/// assert!(c.is_none_or(|c| c[(7, 0)] == 100.0));
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// As [`ata_root`].
pub fn ata_deal<T: MpiReal>(
    world: &World,
    root: usize,
    alpha: T,
    a: Option<MatRef<'_, T>>,
    beta: T,
    c: Option<MatMut<'_, T>>,
    options: &AtaOptions<'_>,
) -> Result<()> {
    from_root(world, root, alpha, a, beta, c, options, |_| Mode::Deal)
}

fn from_root<T: MpiReal>(
    world: &World,
    root: usize,
    alpha: T,
    a: Option<MatRef<'_, T>>,
    beta: T,
    c: Option<MatMut<'_, T>>,
    options: &AtaOptions<'_>,
    mode: impl FnOnce(Form) -> Mode,
) -> Result<()> {
    let _guard = world.abort_on_panic();
    let facts = [fact("root", root), scalar_fact::<T>(), number_fact("alpha", alpha)];
    let mut matrices = world.begin(Operation::Root, &facts, on_root(world, root, a, c))?;
    let form = Form::broadcast(world, root, matrices.as_ref(), options.uplo);
    let own = matrices.as_mut().map(|(a, c)| {
        let c = c.rb_mut();
        (*a, if options.uplo == Uplo::Upper { c.transpose_mut() } else { c })
    });
    match mode(form) {
        Mode::Deal => deal::run(world, form, alpha, beta, own, options)?,
        _ => tree::run(world, form, alpha, beta, own, options)?,
    }
    if let (Some((_, c)), Uplo::Both) = (matrices, options.uplo) {
        mirror_lower(c);
    }
    Ok(())
}

/// Returns A and C, on the root alone.
fn on_root<'a, 'c, T>(
    world: &World,
    root: usize,
    a: Option<MatRef<'a, T>>,
    c: Option<MatMut<'c, T>>,
) -> Result<Option<(MatRef<'a, T>, MatMut<'c, T>)>> {
    world.check_root(root)?;
    if root != world.rank() {
        return Ok(None);
    }
    let missing = |what| Error::Argument { what, why: "missing on the root".into() };
    let (a, c) = (a.ok_or(missing("A"))?, c.ok_or(missing("C"))?);
    Error::check_shape("C", (a.ncols(), a.ncols()), c.shape())?;
    Ok(Some((a, c)))
}
