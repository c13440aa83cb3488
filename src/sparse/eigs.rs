use faer::Mat;
use sprs::CsMatView;

use super::Mass;
use super::certificate::{Certificate, ROUNDINGS, certify, count_is_complete};
use super::check::check_symmetric;
use super::lanczos::{WIDTH, basis_size};
use super::problem::{Problem, ascending, scale};
use super::small::dense_pairs;
use super::space::{Pencil, WholePencil};
use crate::base::{Error, Par, Progress, Result};

/// What [`eigs`] is asked for.
#[derive(Clone)]
pub struct EigenOptions<'a> {
    /// Number of eigenpairs, at most the number of rows. Default 100.
    pub k: usize,
    /// The k eigenvalues nearest to this number; `None` (default): the k smallest.
    pub shift: Option<f64>,
    /// Residual that every pair must reach (as [`Eigenpairs::residuals`] says), between 1e-14 and 1e-2; default 1e-9.
    /// Where a few roundings of the vector alone make it larger (`eps | |W| |phi| |`: huge weights), those are enough.
    pub tolerance: f64,
    /// Counts the eigenvalues that are there by the inertia of another factorisation (Sylvester), and goes on until
    /// none is missing; default false.
    pub verify_count: bool,
    /// Threads; default all cores of the affinity mask. Does not change the result.
    pub par: Par,
    /// Seed of the starting block. Default 0.
    pub seed: u64,
    /// Restarts after which [`Error::NotConverged`] is returned; default 60.
    pub max_restarts: usize,
    /// Told of progress; may cancel.
    pub progress: Progress<'a>,
}

impl Default for EigenOptions<'_> {
    fn default() -> Self {
        Self {
            k: 100,
            shift: None,
            tolerance: 1e-9,
            verify_count: false,
            par: Par::all(),
            seed: 0,
            max_restarts: 60,
            progress: Progress::none(),
        }
    }
}

impl EigenOptions<'_> {
    /// Tells of progress.
    pub(super) fn report(&self, fraction: f64) -> Result<()> {
        self.progress.report(fraction)
    }

    fn check(&self, n: usize) -> Result<()> {
        let refuse = |what, why: String| Err(Error::Argument { what, why });
        if self.k > n {
            return refuse("k", format!("{} eigenpairs of a matrix of {n} rows", self.k));
        }
        if !(1e-14..=1e-2).contains(&self.tolerance) {
            return refuse(
                "tolerance",
                format!("{:e} is not between 1e-14 and 1e-2", self.tolerance),
            );
        }
        match self.shift {
            Some(shift) if !shift.is_finite() => refuse("shift", format!("{shift} is not finite")),
            _ => Ok(()),
        }
    }
}

/// Eigenpairs of `W phi = lambda M phi`.
#[derive(Debug, Clone)]
pub struct Eigenpairs {
    /// k eigenvalues, ascending.
    pub values: Vec<f64>,
    /// n x k: an eigenvector for each value, `V^T M V = I` (to rounding).
    pub vectors: Mat<f64>,
    /// For each pair `|W phi - lambda M phi| / max(|W phi|, s |M phi|)` in the Euclidean norm, as computed from the
    /// result, `W phi` by differences in rows that sum to zero. The scale s of the smallest eigenvalues ([`eigs`])
    /// stands for that of `W phi` where lambda is about 0.
    pub residuals: Vec<f64>,
    /// Vectors that `(W - sigma M)^-1 M` was applied to; 0 if the problem was solved as a dense one.
    pub solves: usize,
}

/// The k smallest eigenvalues, or the k nearest to a shift, of `W phi = lambda M phi`, and their eigenvectors.
///
/// W (n x n) is symmetric, all entries stored, by rows or by columns; positive semi-definite unless a shift is given.
/// Shift-invert block Lanczos with thick restart (Wu and Simon 2000; Grimes, Lewis and Simon 1994) on a sparse
/// Cholesky factorisation of `W - sigma M`. Without a shift, `sigma = -s`, where n s is the median of `W_ii / M_ii`:
/// for a surface of area A of equilateral triangles `s = 2 sqrt(3) / A`, the size of its first eigenvalues. Null
/// vectors that are constant on components of the graph of W are taken as they are, however many there are. Other
/// eigenvalues of more than 8 dimensions are complete only under [`EigenOptions::verify_count`].
///
/// The result is the same, bit for bit, for every `options.par`. Memory: about `2 k + 80` vectors of n, the result,
/// and the factor.
///
/// # Errors
/// [`Error::Shape`], [`Error::NonFinite`] and [`Error::Argument`] name W ("stiffness"), "mass" or the option at fault;
/// [`Error::OutOfMemory`], [`Error::Cancelled`]; [`Error::NotConverged`] with the restarts done and the largest
/// residual.
pub fn eigs(
    stiffness: CsMatView<'_, f64>,
    mass: &Mass,
    options: &EigenOptions<'_>,
) -> Result<Eigenpairs> {
    check(stiffness, mass, options)?;
    eigs_of(&WholePencil { stiffness, mass }, stiffness, mass, options)
}

/// [`eigs`] with vectors of the rows that are here. The matrices, checked, are those of the pencil, with all rows.
pub(crate) fn eigs_of(
    pencil: &dyn Pencil,
    stiffness: CsMatView<'_, f64>,
    mass: &Mass,
    options: &EigenOptions<'_>,
) -> Result<Eigenpairs> {
    if options.k == 0 {
        let vectors = Mat::zeros(pencil.inner().rows().len(), 0);
        return Ok(Eigenpairs { values: vec![], vectors, residuals: vec![], solves: 0 });
    }
    if basis_size(options.k) + 2 * WIDTH > stiffness.rows() {
        return small(pencil, stiffness, mass, options);
    }
    let problem = Problem::new(pencil, stiffness, mass)?;
    options.report(0.01)?;
    one_window(&problem, options)
}

/// Refuses what is not a problem.
pub(crate) fn check(
    stiffness: CsMatView<'_, f64>,
    mass: &Mass,
    options: &EigenOptions<'_>,
) -> Result<()> {
    let n = stiffness.rows();
    check_symmetric("stiffness", stiffness)?;
    mass.check(n)?;
    options.check(n)
}

/// All pairs at once.
pub(super) fn one_window(problem: &Problem<'_>, options: &EigenOptions<'_>) -> Result<Eigenpairs> {
    let (sigma, factor) = match options.shift {
        Some(shift) => (shift, problem.any(shift)?),
        None => (-problem.scale, problem.positive(-problem.scale)?),
    };
    options.report(0.02)?;
    let from_below = factor.is_positive();
    let below = |value| problem.below(value);
    let pairs = problem.nearest(sigma, factor, options, |values| match options.verify_count {
        true => count_is_complete(values, from_below, problem.scale, below),
        false => Ok(true),
    })?;
    options.report(1.0)?;
    Ok(pairs)
}

/// The wanted pairs of all.
pub(super) fn small(
    pencil: &dyn Pencil,
    stiffness: CsMatView<'_, f64>,
    mass: &Mass,
    options: &EigenOptions<'_>,
) -> Result<Eigenpairs> {
    let (values, vectors) = dense_pairs(stiffness, mass, options)?;
    let mut order: Vec<usize> = (0..values.len()).collect();
    if let Some(shift) = options.shift {
        order.sort_by(|&a, &b| (values[a] - shift).abs().total_cmp(&(values[b] - shift).abs()));
    }
    order.truncate(options.k);
    order.sort_unstable();
    let values: Vec<f64> = order.iter().map(|&j| values[j]).collect();
    let rows = pencil.inner().rows();
    let vectors = Mat::from_fn(rows.len(), options.k, |i, j| vectors[(rows.start + i, order[j])]);
    let (scale, vectors) = (scale(stiffness, mass), vectors.as_ref());
    let Certificate { residuals, .. } =
        certify(pencil, stiffness, &values, vectors, scale, ROUNDINGS, options)?;
    options.report(1.0)?;
    Ok(ascending(&values, vectors, &residuals, 0, options.shift.is_none()))
}
