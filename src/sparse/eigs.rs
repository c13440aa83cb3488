use faer::{Mat, MatRef};
use sprs::CsMatView;

use super::certificate::{count_is_complete, residuals};
use super::check::check_symmetric;
use super::cholesky::{Factor, Symbolic};
use super::lanczos::{Krylov, WIDTH, basis_size};
use super::shifted::Shifted;
use super::small::dense_pairs;
use super::space::{Pencil, WholePencil};
use super::{Mass, components};
use crate::base::{Error, Flow, Par, Progress, Result};

/// What [`eigs`] is asked for.
#[derive(Clone)]
pub struct EigenOptions<'a> {
    /// Number of eigenpairs, at most the number of rows. Default 100.
    pub k: usize,
    /// The k eigenvalues nearest to this number; `None` (default): the k smallest.
    pub shift: Option<f64>,
    /// Residual that every pair must reach (as [`Eigenpairs::residuals`] says), between 1e-14 and 1e-2; default 1e-9.
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
    pub progress: Option<Progress<'a>>,
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
            progress: None,
        }
    }
}

impl EigenOptions<'_> {
    /// Tells of progress.
    pub(super) fn report(&self, fraction: f64) -> Result<()> {
        match self.progress.map(|progress| progress(fraction)) {
            Some(Flow::Cancel) => Err(Error::Cancelled),
            Some(Flow::Continue) | None => Ok(()),
        }
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
    /// result. The scale s of the smallest eigenvalues ([`eigs`]) stands for that of `W phi` where lambda is about 0.
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
    let n = stiffness.rows();
    check_symmetric("stiffness", stiffness)?;
    mass.check(n)?;
    eigs_of(&WholePencil { stiffness, mass }, stiffness, mass, options)
}

/// [`eigs`] with vectors of the rows that are here. The matrices, checked, are those of the pencil, with all rows.
pub(crate) fn eigs_of(
    pencil: &dyn Pencil,
    stiffness: CsMatView<'_, f64>,
    mass: &Mass,
    options: &EigenOptions<'_>,
) -> Result<Eigenpairs> {
    let n = stiffness.rows();
    options.check(n)?;
    if options.k == 0 {
        let vectors = Mat::zeros(pencil.inner().rows().len(), 0);
        return Ok(Eigenpairs { values: vec![], vectors, residuals: vec![], solves: 0 });
    }
    let scale = scale(stiffness, mass);
    if basis_size(options.k) + 2 * WIDTH > n {
        return small(pencil, stiffness, mass, scale, options);
    }
    let shifted = Shifted::new(stiffness, mass);
    let symbolic = Symbolic::new(&shifted)?;
    options.report(0.01)?;
    let sigma = options.shift.unwrap_or(-scale);
    let factor = factor(&symbolic, &shifted, sigma, options)?;
    options.report(0.02)?;
    let null = match sigma < 0.0 {
        true => components::null_components(stiffness, mass),
        false => vec![],
    };
    let mean_mass = (0..n).map(|i| mass.diagonal(i)).sum::<f64>() / n as f64;
    let mut krylov = Krylov::new(pencil, &factor, sigma, scale, mean_mass.sqrt(), options)?;
    krylov.lock(&null)?;
    // Each round tightens the estimate, or adds a block of directions that the earlier ones had nothing of.
    let rounds = 8 + options.k / WIDTH;
    let mut largest = f64::INFINITY;
    for _ in 0..rounds {
        krylov.converge()?;
        let mut residuals;
        (residuals, largest) = certify(&krylov, pencil, scale, options)?;
        if largest > options.tolerance {
            krylov.purify()?;
            (residuals, largest) = certify(&krylov, pencil, scale, options)?;
        }
        let (values, vectors) = (krylov.values(), krylov.vectors());
        if largest > options.tolerance {
            krylov.tighten(0.1 * options.tolerance / largest);
        } else if options.verify_count
            && !count_is_complete(&symbolic, &shifted, values, factor.is_positive(), scale)?
        {
            krylov.add_directions()?;
        } else {
            options.report(1.0)?;
            let positive = options.shift.is_none();
            return Ok(ascending(values, vectors, &residuals, krylov.solves(), positive));
        }
    }
    Err(Error::NotConverged { iterations: krylov.restarts(), residual: largest })
}

/// The residuals of what was found, and the largest of them; infinity where one is NaN.
fn certify(
    krylov: &Krylov<'_>,
    pencil: &dyn Pencil,
    scale: f64,
    options: &EigenOptions<'_>,
) -> Result<(Vec<f64>, f64)> {
    let (values, vectors) = (krylov.values(), krylov.vectors());
    let residuals = residuals(pencil, values, vectors, scale, options.par)?;
    let number = |r: &f64| if r.is_nan() { f64::INFINITY } else { *r };
    let largest = residuals.iter().map(number).fold(0.0, f64::max);
    Ok((residuals, largest))
}

/// s of [`eigs`].
fn scale(stiffness: CsMatView<'_, f64>, mass: &Mass) -> f64 {
    let n = stiffness.rows();
    let ratio = |i: usize| stiffness.get(i, i).copied().unwrap_or(0.0) / mass.diagonal(i);
    let mut ratios: Vec<f64> = (0..n).map(ratio).filter(|x| *x > 0.0).collect();
    if ratios.is_empty() {
        return 1.0;
    }
    let middle = ratios.len() / 2;
    *ratios.select_nth_unstable_by(middle, f64::total_cmp).1 / n as f64
}

/// `W - sigma M`, factorised.
fn factor<'s>(
    symbolic: &'s Symbolic,
    shifted: &Shifted<'_>,
    sigma: f64,
    options: &EigenOptions<'_>,
) -> Result<Factor<'s>> {
    if sigma < 0.0
        && let Some(factor) = Factor::positive(symbolic, shifted, sigma)?
    {
        return Ok(factor);
    }
    if options.shift.is_none() {
        let why = "not positive semi-definite: give a shift".into();
        return Err(Error::Argument { what: "stiffness", why });
    }
    let factor = Factor::indefinite(symbolic, shifted, sigma)?;
    if !factor.is_finite() {
        let why = format!("{sigma:e} is an eigenvalue, as far as elimination can tell");
        return Err(Error::Argument { what: "shift", why });
    }
    Ok(factor)
}

/// The wanted pairs of all.
fn small(
    pencil: &dyn Pencil,
    stiffness: CsMatView<'_, f64>,
    mass: &Mass,
    scale: f64,
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
    let residuals = residuals(pencil, &values, vectors.as_ref(), scale, options.par)?;
    options.report(1.0)?;
    let vectors = vectors.as_ref();
    Ok(ascending(&values, vectors, &residuals, 0, options.shift.is_none()))
}

/// These pairs in ascending order; of a semi-definite matrix, for which rounding below zero is zero.
fn ascending(
    values: &[f64],
    vectors: MatRef<'_, f64>,
    residuals: &[f64],
    solves: usize,
    positive: bool,
) -> Eigenpairs {
    let least = if positive { 0.0 } else { f64::NEG_INFINITY };
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
    Eigenpairs {
        values: order.iter().map(|&j| values[j].max(least)).collect(),
        vectors: Mat::from_fn(vectors.nrows(), order.len(), |i, j| vectors[(i, order[j])]),
        residuals: order.iter().map(|&j| residuals[j]).collect(),
        solves,
    }
}
