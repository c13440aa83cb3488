use sprs::CsMatView;

use super::certificate::{ROUNDINGS, certify, magnitudes};
use super::cholesky::Symbolic;
use super::eigenpairs::{Eigenpairs, ascending};
use super::lanczos::{Krylov, WIDTH};
use super::options::EigenOptions;
use super::shifted::Shifted;
use super::space::{Inverse, Pencil, Shifts, WholePencil};
use super::{Mass, components};
use crate::base::{Error, Result};

/// What runs need to know about W and M beside their products.
pub(crate) struct Outline {
    /// The s of [`Eigenpairs`].
    scale: f64,
    /// The largest `W_ii / M_ii`, at least 0.
    largest: f64,
    /// The mean of the diagonal of M.
    mean_mass: f64,
    /// Null vectors of W, as lists of rows; of each, this process may have a part.
    null: Vec<Vec<usize>>,
}

impl Outline {
    /// Creates the outline for `W_ii / M_ii` of all rows, the mean of the diagonal of M, and the
    /// null vectors of W.
    pub fn new(ratios: Vec<f64>, mean_mass: f64, null: Vec<Vec<usize>>) -> Self {
        let largest = ratios.iter().copied().fold(0.0, f64::max);
        Self { scale: scale_of(ratios), largest, mean_mass, null }
    }

    /// Finds what is known about whole matrices.
    fn of(stiffness: CsMatView<'_, f64>, mass: &Mass) -> Self {
        let n = stiffness.rows();
        let mean_mass = (0..n).map(|i| mass.diagonal(i)).sum::<f64>() / n as f64;
        let null = components::null_components(stiffness, mass);
        Self::new(ratios(stiffness, mass), mean_mass, null)
    }
}

/// The matrices W and M, with the data that all runs share.
pub(crate) struct Problem<'a> {
    pub pencil: &'a dyn Pencil,
    /// The s of [`Eigenpairs`].
    pub scale: f64,
    shifts: Box<dyn Shifts + 'a>,
    /// The largest `W_ii / M_ii`.
    largest: f64,
    mean_mass: f64,
    /// Null vectors of W, as lists of rows.
    null: Vec<Vec<usize>>,
}

impl<'a> Problem<'a> {
    /// Creates the problem of matrices that are known to be symmetric, on this process.
    pub fn whole(pencil: &'a WholePencil<'a>) -> Result<Self> {
        let WholePencil { stiffness, mass } = *pencil;
        let shifted = Shifted::new(stiffness, mass);
        let symbolic = Symbolic::new(shifted.symbolic())?;
        let shifts = Box::new(WholeShifts { shifted, symbolic });
        Ok(Self::new(pencil, Outline::of(stiffness, mass), shifts))
    }

    /// Creates the problem of a pencil and its shifts.
    pub fn new(pencil: &'a dyn Pencil, outline: Outline, shifts: Box<dyn Shifts + 'a>) -> Self {
        let Outline { scale, largest, mean_mass, null } = outline;
        Self { pencil, scale, shifts, largest, mean_mass, null }
    }

    /// Returns the bytes that a factorization takes, and those that are allocated anyway.
    pub fn bytes(&self) -> usize {
        self.shifts.bytes()
    }

    /// Returns the number of eigenvalues below `value`.
    pub fn below(&self, value: f64) -> Result<usize> {
        Ok(self.shifts.indefinite(value)?.below_zero())
    }

    /// Returns [`Problem::below`], or `None` where `value` is an eigenvalue up to rounding.
    pub fn count_below(&self, value: f64) -> Result<Option<usize>> {
        let factor = self.shifts.indefinite(value)?;
        Ok(factor.is_finite().then(|| factor.below_zero()))
    }

    /// Factorizes `W - sigma M` for a semi-definite W.
    pub fn positive(&self, sigma: f64) -> Result<Box<dyn Inverse + '_>> {
        self.shifts.positive(sigma)?.ok_or_else(not_semi_definite)
    }

    /// Returns whether all eigenvalues exceed sigma.
    pub fn all_exceed(&self, sigma: f64) -> Result<bool> {
        Ok(self.shifts.positive(sigma)?.is_some())
    }

    /// Factorizes `W - sigma M`; `None` where sigma is an eigenvalue up to rounding.
    pub fn regular(&self, sigma: f64) -> Result<Option<Box<dyn Inverse + '_>>> {
        if sigma < 0.0
            && let Some(factor) = self.shifts.positive(sigma)?
        {
            return Ok(Some(factor));
        }
        let factor = self.shifts.indefinite(sigma)?;
        Ok(factor.is_finite().then_some(factor))
    }

    /// Returns [`Problem::regular`], or an error of "shift" where there is no factor.
    pub fn any(&self, sigma: f64) -> Result<Box<dyn Inverse + '_>> {
        self.regular(sigma)?.ok_or_else(|| {
            let why = format!("{sigma:e} is an eigenvalue up to rounding");
            Error::Argument { what: "shift", why }
        })
    }

    /// Returns the null vectors from which a run with this sigma starts.
    fn null_near(&self, sigma: f64) -> &[Vec<usize>] {
        if sigma < 0.0 { &self.null[..] } else { &[] }
    }

    /// Creates the first space of a run, given the factor for sigma.
    pub fn start<'b>(
        &'b self,
        sigma: f64,
        factor: &dyn Inverse,
        options: &'b EigenOptions<'_>,
    ) -> Result<Krylov<'b>> {
        let mass_norm = self.mean_mass.sqrt();
        let mut krylov = Krylov::new(self.pencil, sigma, self.scale, mass_norm, options)?;
        krylov.lock(factor, self.null_near(sigma))?;
        Ok(krylov)
    }

    /// Computes the `options.k` pairs nearest to sigma, given the factor for it, or to
    /// `options.shift`, which sigma is at or beside. Continues until `complete` returns that no
    /// eigenvalue is missing; the factor is freed before each such call.
    pub fn nearest(
        &self,
        sigma: f64,
        factor: Box<dyn Inverse + '_>,
        options: &EigenOptions<'_>,
        complete: impl FnMut(&[f64]) -> Result<bool>,
    ) -> Result<Eigenpairs> {
        let krylov = self.start(sigma, &*factor, options)?;
        self.finish(krylov, sigma, factor, options, complete)
    }

    /// Computes [`Problem::nearest`], given what [`Problem::start`] returned.
    pub fn finish(
        &self,
        mut krylov: Krylov<'_>,
        sigma: f64,
        factor: Box<dyn Inverse + '_>,
        options: &EigenOptions<'_>,
        mut complete: impl FnMut(&[f64]) -> Result<bool>,
    ) -> Result<Eigenpairs> {
        let certify = |krylov: &Krylov<'_>| {
            let (values, vectors) = (krylov.values(), krylov.vectors());
            certify(self.pencil, values, vectors, self.scale, ROUNDINGS, options)
        };
        // Each round tightens the estimate, or adds a block of directions in which the earlier ones
        // have no component.
        let rounds = 8 + options.k / WIDTH;
        let mut kept = Some(factor);
        let mut least = f64::INFINITY;
        for _ in 0..rounds {
            let factor = match kept.take() {
                Some(factor) => factor,
                None => {
                    let factor = self.any(sigma)?;
                    krylov.add_directions(&*factor)?;
                    factor
                }
            };
            krylov.converge(&*factor).map_err(|error| not_above(error, least))?;
            let mut certificate = certify(&krylov)?;
            if certificate.excess > 1.0 {
                krylov.purify(&*factor)?;
                certificate = certify(&krylov)?;
            }
            if certificate.excess > 1.0 {
                least = least.min(certificate.largest);
                krylov.tighten(0.1 / certificate.excess);
                kept = Some(factor);
                continue;
            }
            drop(factor);
            if complete(krylov.values())? {
                // Later slices start inside the spectrum, and hand out nothing near zero.
                let are_smallest = options.shift.is_none() && sigma < 0.0;
                if are_smallest && options.k <= self.null.len() {
                    self.check_semi_definite(options)?;
                }
                let (values, vectors) = (krylov.values(), krylov.vectors());
                let (residuals, solves) = (&certificate.residuals, krylov.solves());
                let mut pairs = ascending(values, vectors, residuals, solves, options.par)?;
                if are_smallest {
                    without_negative(self.pencil, &mut pairs, self.scale, options)?;
                    // The values of constants on components are zero, not rounding errors.
                    let null = self.null_near(sigma);
                    pairs.values.iter_mut().take(null.len()).for_each(|value| *value = 0.0);
                }
                return Ok(pairs);
            }
        }
        Err(Error::NotConverged { iterations: krylov.restarts(), residual: least })
    }

    /// Checks, by a factorization, that no eigenvalue is farther below zero than the tolerance or
    /// rounding explains: where null vectors are all that is wanted, no other eigenvalue is
    /// computed.
    fn check_semi_definite(&self, options: &EigenOptions<'_>) -> Result<()> {
        let negligible = options.tolerance.max(NEGLIGIBLE) * self.scale;
        let least = -negligible.max(NULL_ROUNDING * self.largest);
        // The first factorization was that of `W + s M`.
        match least <= -self.scale || self.all_exceed(least)? {
            true => Ok(()),
            false => Err(not_semi_definite()),
        }
    }
}

/// The shifts of a pencil whose rows are all on this process.
struct WholeShifts<'a> {
    shifted: Shifted<'a>,
    symbolic: Symbolic,
}

impl Shifts for WholeShifts<'_> {
    fn bytes(&self) -> usize {
        self.symbolic.bytes() + self.shifted.bytes()
    }

    fn positive(&self, sigma: f64) -> Result<Option<Box<dyn Inverse + '_>>> {
        let factor = self.symbolic.positive(self.shifted.matrix(&self.shifted.values(sigma)))?;
        Ok(factor.map(|factor| Box::new(factor) as Box<dyn Inverse + '_>))
    }

    fn indefinite(&self, sigma: f64) -> Result<Box<dyn Inverse + '_>> {
        Ok(Box::new(self.symbolic.indefinite(self.shifted.matrix(&self.shifted.values(sigma)))?))
    }
}

/// Replaces the residual of an [`Error::NotConverged`] by that of an earlier round that did not
/// converge either, if it is less.
fn not_above(error: Error, least: f64) -> Error {
    match error {
        Error::NotConverged { iterations, residual } => {
            Error::NotConverged { iterations, residual: residual.min(least) }
        }
        other => other,
    }
}

/// Size of the negative values that count as zero, in units of s, whatever the tolerance is: solves
/// are rounded.
const NEGLIGIBLE: f64 = 1e-12;

/// Roundings of the entries of a semi-definite W, in units of epsilon, by which eigenvalues may be
/// negative: those of W itself and of its factor, with a wide margin.
const ENTRY_ROUNDINGS: f64 = 1e3;

/// Size of the eigenvalues of null vectors, and of the rounding of a factor, in units of the
/// largest `W_ii / M_ii`, with a margin: rows whose sums are below 1e-12 of their entries count as
/// zero.
const NULL_ROUNDING: f64 = 1e-11;

/// Replaces the negative values of ascending pairs of a semi-definite W by zeros, if the tolerance
/// or rounding explains them, and their residuals by those of the result.
///
/// # Errors
/// [`not_semi_definite`] where a value is farther below zero; else those of the pencil.
pub(crate) fn without_negative(
    pencil: &dyn Pencil,
    pairs: &mut Eigenpairs,
    scale: f64,
    options: &EigenOptions<'_>,
) -> Result<()> {
    let count = pairs.values.partition_point(|value| *value < 0.0);
    if count == 0 {
        return Ok(());
    }
    for j in 0..count {
        let tolerance = options.tolerance.max(pairs.residuals[j]).max(NEGLIGIBLE);
        let negligible = tolerance * scale;
        if pairs.values[j] >= -negligible {
            continue;
        }
        // A change of each entry of W by `e |W_ij|` changes the value by `e |phi|^T |W| |phi|`.
        let size = magnitudes(pencil, pairs.vectors.as_ref().subcols(j, 1))?.dot;
        if pairs.values[j] < -negligible.max(ENTRY_ROUNDINGS * f64::EPSILON * size) {
            return Err(not_semi_definite());
        }
    }
    pairs.values[..count].fill(0.0);
    let (zeros, vectors) = (&pairs.values[..count], pairs.vectors.as_ref().subcols(0, count));
    let found = certify(pencil, zeros, vectors, scale, ROUNDINGS, options)?;
    pairs.residuals[..count].copy_from_slice(&found.residuals);
    Ok(())
}

/// Returns the error about a W with negative eigenvalues without a request for a shift.
pub(crate) fn not_semi_definite() -> Error {
    let why = "not positive semi-definite, which needs a shift".into();
    Error::Argument { what: "stiffness", why }
}

/// Returns the scale s of [`super::eigs()`].
pub(crate) fn scale(stiffness: CsMatView<'_, f64>, mass: &Mass) -> f64 {
    scale_of(ratios(stiffness, mass))
}

/// Returns `W_ii / M_ii` of all rows.
fn ratios(stiffness: CsMatView<'_, f64>, mass: &Mass) -> Vec<f64> {
    let ratio = |i: usize| stiffness.get(i, i).copied().unwrap_or(0.0) / mass.diagonal(i);
    (0..stiffness.rows()).map(ratio).collect()
}

/// Returns the scale of matrices whose diagonals have these ratios, `W_ii / M_ii`.
fn scale_of(mut ratios: Vec<f64>) -> f64 {
    let n = ratios.len();
    ratios.retain(|x| *x > 0.0);
    if ratios.is_empty() {
        return 1.0;
    }
    let middle = ratios.len() / 2;
    *ratios.select_nth_unstable_by(middle, f64::total_cmp).1 / n as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Par;
    use crate::sparse::path::path;

    #[test]
    fn eigenvalues_that_are_missing_have_no_residual() {
        let (w, mass) = (path(300), Mass::identity(300));
        let pencil = WholePencil { stiffness: w.view(), mass: &mass };
        let problem = Problem::whole(&pencil).unwrap();
        let options = EigenOptions::new().k(5).shift(0.5).par(Par::Seq);
        let factor = problem.any(0.5).unwrap();
        let error = problem.nearest(0.5, factor, &options, |_| Ok(false)).unwrap_err();
        let said = error.to_string();
        assert!(
            said.starts_with("not converged after ") && said.ends_with(" iterations"),
            "{said}"
        );
    }
}
