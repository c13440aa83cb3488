use catamaran::base::Rng;
use catamaran::faer::{Mat, Side};
use catamaran::{Error, Result};

use super::retrieval::Query;
use crate::dataset::{EIGENVALUES, Spectrum};

const LOGS: usize = EIGENVALUES - 1;

/// Logarithms of the eigenvalues 2 to 20, or their errors. The first eigenvalue of a closed shape
/// is 0, so it is left out.
pub type Logs = [f64; LOGS];

/// The errors of the logarithms of eigenvalues 2 to 20, as a normal distribution.
#[derive(Debug, Clone, PartialEq)]
pub struct ErrorModel {
    mean: Logs,
    /// The lower Cholesky factor of the covariance.
    factor: Mat<f64>,
}

/// Added to variances, so that a few samples suffice.
const LEAST_VARIANCE: f64 = 1e-12;

impl ErrorModel {
    /// Fits the mean and the covariance.
    ///
    /// # Errors
    /// [`Error::Argument`] for no samples and samples that are not finite.
    pub fn fit(samples: &[Logs]) -> Result<Self> {
        let refuse = |why: &str| Error::Argument { what: "samples", why: why.into() };
        if samples.is_empty() {
            return Err(refuse("must not be empty"));
        }
        let count = samples.len() as f64;
        let mean: Logs = std::array::from_fn(|i| samples.iter().map(|x| x[i]).sum::<f64>() / count);
        let covariance = Mat::from_fn(LOGS, LOGS, |i, j| {
            let sum: f64 = samples.iter().map(|x| (x[i] - mean[i]) * (x[j] - mean[j])).sum();
            sum / count + if i == j { LEAST_VARIANCE } else { 0.0 }
        });
        let factor = covariance.llt(Side::Lower).map_err(|_| refuse("not finite"))?;
        Ok(Self { mean, factor: factor.L().to_owned() })
    }

    fn draw(&self, rng: &mut Rng) -> Logs {
        let normal: Logs = std::array::from_fn(|_| rng.normal());
        let deviation = |i: usize| (0..LOGS).map(|j| self.factor[(i, j)] * normal[j]).sum::<f64>();
        std::array::from_fn(|i| self.mean[i] + deviation(i))
    }
}

/// A disturbance of a spectrum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Disturbance<'a> {
    /// An independent relative error of each eigenvalue, with this standard deviation.
    Independent(f64),
    /// One relative error that grows with the eigenvalue, as between meshes; this is its standard
    /// deviation at the last eigenvalue.
    Drift(f64),
    /// Errors of a model, times a factor.
    Modelled(&'a ErrorModel, f64),
}

impl Disturbance<'_> {
    /// Disturbs a spectrum; the result ascends. The first eigenvalue is disturbed as well, except
    /// by an error model, which does not contain it.
    pub fn apply(&self, spectrum: &Spectrum, rng: &mut Rng) -> Spectrum {
        let mut changed = match *self {
            Self::Independent(size) => spectrum.map(|x| x * (size * rng.normal()).exp()),
            Self::Drift(size) => {
                let drift = size * rng.normal() / spectrum[EIGENVALUES - 1];
                spectrum.map(|x| x * (drift * x).exp())
            }
            Self::Modelled(model, factor) => with_errors(spectrum, &model.draw(rng), factor),
        };
        changed.sort_unstable_by(f64::total_cmp);
        changed
    }

    /// Disturbs the spectrum of each query `repeats` times; the same seed gives the same spectra.
    pub fn queries(&self, queries: &[Query], repeats: usize, seed: u64) -> Vec<Query> {
        let mut rng = Rng::new(seed);
        let repeated = (0..repeats).flat_map(|_| queries);
        repeated
            .map(|query| Query { spectrum: self.apply(&query.spectrum, &mut rng), ..*query })
            .collect()
    }
}

/// Returns the spectrum with these errors of its logarithms, times a factor.
pub(super) fn with_errors(spectrum: &Spectrum, errors: &Logs, factor: f64) -> Spectrum {
    std::array::from_fn(|i| match i {
        0 => spectrum[0],
        _ => spectrum[i] * (factor * errors[i - 1]).exp(),
    })
}

/// Computes the errors of the logarithms of a spectrum.
pub(super) fn log_errors(found: &Spectrum, truth: &Spectrum) -> Logs {
    std::array::from_fn(|i| found[i + 1].ln() - truth[i + 1].ln())
}

/// Computes the mean relative error of each of the eigenvalues 2 to 20.
pub fn errors_by_index(found: &[Spectrum], truth: &[Spectrum]) -> Logs {
    let mut sum = [0.0; LOGS];
    for (found, truth) in found.iter().zip(truth) {
        for (i, sum) in sum.iter_mut().enumerate() {
            *sum += (found[i + 1] / truth[i + 1] - 1.0).abs();
        }
    }
    sum.map(|sum| sum / f64::max(1.0, found.len() as f64))
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRUTH: Spectrum = [
        0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0, 90.0, 100.0, 110.0, 120.0, 130.0,
        140.0, 150.0, 160.0, 170.0, 180.0, 190.0,
    ];

    /// Returns the errors of the logarithms of many disturbed spectra.
    fn errors(disturbance: &Disturbance<'_>) -> Vec<Logs> {
        let query = Query { identity: 1, pose: 0, spectrum: TRUTH };
        let found = disturbance.queries(&[query], 4000, 3);
        assert_eq!(found, disturbance.queries(&[query], 4000, 3));
        assert!(found.iter().all(|query| query.spectrum.is_sorted()));
        found.iter().map(|query| log_errors(&query.spectrum, &TRUTH)).collect()
    }

    fn moment(errors: &[Logs], i: usize, j: usize) -> f64 {
        errors.iter().map(|e| e[i] * e[j]).sum::<f64>() / errors.len() as f64
    }

    #[test]
    fn independent_errors_have_their_size_and_nothing_in_common() {
        let found = errors(&Disturbance::Independent(0.01));
        for i in [0, 5, 12] {
            assert!((moment(&found, i, i).sqrt() / 0.01 - 1.0).abs() < 0.05);
            assert!(moment(&found, i, i + 1).abs() < 0.1 * 1e-4);
        }
    }

    #[test]
    fn a_drift_grows_with_the_eigenvalue() {
        let found = errors(&Disturbance::Drift(0.02));
        for error in &found {
            for i in 0..LOGS {
                let expected = error[EIGENVALUES - 2] * TRUTH[i + 1] / TRUTH[EIGENVALUES - 1];
                assert!((error[i] - expected).abs() < 1e-12);
            }
        }
        let last = EIGENVALUES - 2;
        assert!((moment(&found, last, last).sqrt() / 0.02 - 1.0).abs() < 0.05);
    }

    #[test]
    fn modelled_errors_are_like_those_fitted() {
        // The mean is 1 %, and there are two independent directions.
        let one: Logs = std::array::from_fn(|i| 1e-3 * (i % 4) as f64);
        let other: Logs = std::array::from_fn(|i| if i % 2 == 0 { 2e-3 } else { -1e-3 });
        let mut samples = Vec::new();
        for signs in [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]] {
            samples.push(std::array::from_fn(|i| 0.01 + signs[0] * one[i] + signs[1] * other[i]));
        }
        let model = ErrorModel::fit(&samples).unwrap();
        for factor in [1.0, 0.5] {
            let found = errors(&Disturbance::Modelled(&model, factor));
            for (i, j) in [(0, 0), (3, 6), (7, 8)] {
                let mean = found.iter().map(|e| e[i]).sum::<f64>() / found.len() as f64;
                assert!((mean - factor * 0.01).abs() < 2e-4 * factor, "{mean}");
                let expected = factor * factor * moment(&samples, i, j);
                assert!((moment(&found, i, j) / expected - 1.0).abs() < 0.05);
            }
        }
        assert!(ErrorModel::fit(&[]).is_err());
    }

    #[test]
    fn errors_are_those_of_each_eigenvalue() {
        let found = std::array::from_fn(|i| TRUTH[i] * if i == 2 { 1.1 } else { 1.0 });
        let mean = errors_by_index(&[found, TRUTH], &[TRUTH, TRUTH]);
        assert!((mean[1] - 0.05).abs() < 1e-12);
        assert!(mean.iter().enumerate().all(|(i, &error)| i == 1 || error == 0.0));
        let all = with_errors(&TRUTH, &log_errors(&found, &TRUTH), 1.0);
        assert!((all[2] - found[2]).abs() < 1e-12);
        let half = with_errors(&TRUTH, &log_errors(&found, &TRUTH), 0.5);
        assert!((half[2] - 20.0 * 1.1f64.sqrt()).abs() < 1e-12);
    }
}
