use std::collections::BTreeMap;

use catamaran::faer::linalg::solvers::Solve;
use catamaran::faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use catamaran::faer::{self, Mat, Scale, Side};
use catamaran::{Error, Result};

use crate::dataset::{EIGENVALUES, Spectrum};

/// Logarithms of the eigenvalues 2 to 20. The first eigenvalue of a closed shape is 0, so it is
/// left out.
pub type Logs = [f64; LOGS];

const LOGS: usize = EIGENVALUES - 1;

/// Computes the logarithms of a spectrum.
pub fn logarithms(spectrum: &Spectrum) -> Logs {
    std::array::from_fn(|i| spectrum[i + 1].ln())
}

/// Computes `a - b`.
pub(super) fn difference(a: &Logs, b: &Logs) -> Logs {
    std::array::from_fn(|i| a[i] - b[i])
}

/// Options of fitting a [`RetrievalMetric`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MetricOptions {
    /// Whether shapes that differ only in size count as the same. Default false.
    pub scale_free: bool,
    /// Share, from 0 to 1, of the covariance of errors that is replaced by their mean variance,
    /// equal for all eigenvalues and independent: predictions for new shapes have errors that do
    /// not occur in the training. Default 0.5.
    pub shrinkage: f64,
}

impl Default for MetricOptions {
    fn default() -> Self {
        Self { scale_free: false, shrinkage: 0.5 }
    }
}

/// Added to the variance of each logarithm within an identity: differences of 0.1 % are caused by
/// the mesh.
const NOISE: f64 = 1e-6;

/// A distance between the predicted spectrum of a complete shape and the true spectrum of another
/// one. It measures how unlikely it is that both are of the same identity in different poses.
///
/// The logarithms of eigenvalues are the sum of those of the identity, a contribution of the pose,
/// and errors of the prediction, each normally distributed. Let W be the covariance of poses, T
/// that of all shapes, m their mean, and C and e the covariance and the mean of errors. Given a
/// shape g, a query q of the same identity is then normally distributed about
/// `m + e + (1 - W T^-1) (g - m)` with covariance `S = 2 W - W T^-1 W + C`. The distance is the
/// Mahalanobis distance of this distribution. If identities differ much more than poses (T is
/// large), it is that of q - e - g for the covariance `2 W + C`.
///
/// T has to be estimated from several times as many identities as there are logarithms: estimated
/// from six, it makes new identities seem impossible, and Euclidean distances give better results.
///
/// Source: Ioffe, Probabilistic Linear Discriminant Analysis (2006).
#[derive(Debug, Clone, PartialEq)]
pub struct RetrievalMetric {
    /// m + e, which is subtracted from queries.
    query_mean: Logs,
    /// The inverse Cholesky factor of S.
    of_query: Mat<f64>,
    /// m.
    shape_mean: Logs,
    /// The same factor, multiplied by `1 - W T^-1`.
    of_shape: Mat<f64>,
    scale_free: bool,
}

impl RetrievalMetric {
    /// Fits a metric to true spectra of shapes with their identities, some of which have several
    /// poses, and to errors of logarithms of predictions for such shapes. For queries with true
    /// spectra, there are no errors.
    ///
    /// # Errors
    /// [`Error::Argument`] for a shrinkage outside [0, 1], if no identity has several poses, for
    /// spectra and errors that are not finite, and for shapes that differ less than their poses.
    pub fn fit(
        shapes: &[(usize, Spectrum)],
        errors: &[Logs],
        options: &MetricOptions,
    ) -> Result<Self> {
        let refuse = |what, why: &str| Error::Argument { what, why: why.into() };
        if !(0.0..=1.0).contains(&options.shrinkage) {
            return Err(refuse("shrinkage", "must be in [0, 1]"));
        }
        let logs_of = |spectrum| sized(logarithms(spectrum), options.scale_free);
        let shapes: Vec<(usize, Logs)> =
            shapes.iter().map(|(identity, spectrum)| (*identity, logs_of(spectrum))).collect();
        let deviations = pose_deviations(&shapes);
        if deviations.is_empty() {
            return Err(refuse("shapes", "must have an identity with several poses"));
        }
        let logs: Vec<Logs> = shapes.iter().map(|(_, logs)| *logs).collect();
        let errors: Vec<Logs> =
            errors.iter().map(|&error| sized(error, options.scale_free)).collect();
        let (shape_mean, error_mean) = (mean(&logs), mean(&errors));
        let within = second_moment(deviations.into_iter()) + diagonal(NOISE);
        let total = covariance(&logs, &shape_mean) + diagonal(NOISE);
        let spread = covariance(&errors, &error_mean);
        let variance = (0..LOGS).map(|i| spread[(i, i)]).sum::<f64>() / LOGS as f64;
        let spread =
            spread * Scale(1.0 - options.shrinkage) + diagonal(options.shrinkage * variance);
        let factor = total.llt(Side::Lower).map_err(|_| refuse("shapes", "not finite"))?;
        // T^-1 W, the transpose of W T^-1.
        let shrunk = factor.solve(&within);
        let scatter = &within * Scale(2.0) - &within * &shrunk + spread;
        let Some(factor) = cholesky(&scatter) else {
            return Err(refuse("shapes", "must differ more than their poses, and be finite"));
        };
        let mut of_query = Mat::identity(LOGS, LOGS);
        solve_lower_triangular_in_place(factor.as_ref(), of_query.as_mut(), faer::Par::Seq);
        let of_shape = &of_query - &of_query * shrunk.transpose();
        let query_mean = std::array::from_fn(|i| shape_mean[i] + error_mean[i]);
        let scale_free = options.scale_free;
        Ok(Self { query_mean, of_query, shape_mean, of_shape, scale_free })
    }

    /// Computes the signature of a query. Its distance from a shape is the Euclidean distance of
    /// their signatures.
    pub fn of_query(&self, spectrum: &Spectrum) -> Logs {
        let logs = sized(logarithms(spectrum), self.scale_free);
        product(&self.of_query, &difference(&logs, &self.query_mean))
    }

    /// Computes the signature of a shape of the gallery.
    pub fn of_shape(&self, spectrum: &Spectrum) -> Logs {
        let logs = sized(logarithms(spectrum), self.scale_free);
        product(&self.of_shape, &difference(&logs, &self.shape_mean))
    }

    /// Computes the distance of a query from a shape; a pure number, about the square root of 19 if
    /// both have the same identity.
    pub fn distance(&self, query: &Spectrum, shape: &Spectrum) -> f64 {
        let apart = difference(&self.of_query(query), &self.of_shape(shape));
        apart.iter().map(|x| x * x).sum::<f64>().sqrt()
    }
}

/// Returns the logarithms, minus their mean if `scale_free`.
fn sized(logs: Logs, scale_free: bool) -> Logs {
    let mean = if scale_free { logs.iter().sum::<f64>() / LOGS as f64 } else { 0.0 };
    logs.map(|x| x - mean)
}

/// Returns the deviations from the mean of each identity with several poses, scaled so that their
/// second moment is an unbiased estimate of the covariance.
fn pose_deviations(shapes: &[(usize, Logs)]) -> Vec<Logs> {
    let mut identities: BTreeMap<usize, Vec<Logs>> = BTreeMap::new();
    for (identity, logs) in shapes {
        identities.entry(*identity).or_default().push(*logs);
    }
    let several = identities.into_values().filter(|poses| poses.len() > 1);
    several
        .flat_map(|poses| {
            let count = poses.len() as f64;
            let (mean, scale) = (mean(&poses), (count / (count - 1.0)).sqrt());
            poses.into_iter().map(move |pose| difference(&pose, &mean).map(|x| scale * x))
        })
        .collect()
}

/// Computes the mean; 0 for no samples.
pub(super) fn mean(samples: &[Logs]) -> Logs {
    let count = samples.len().max(1) as f64;
    std::array::from_fn(|i| samples.iter().map(|sample| sample[i]).sum::<f64>() / count)
}

/// Computes the covariance of samples with this mean; 0 for no samples.
pub(super) fn covariance(samples: &[Logs], mean: &Logs) -> Mat<f64> {
    second_moment(samples.iter().map(|sample| difference(sample, mean)))
}

fn second_moment(samples: impl Iterator<Item = Logs>) -> Mat<f64> {
    let mut sum = [[0.0; LOGS]; LOGS];
    let mut count = 0.0;
    for sample in samples {
        count += 1.0;
        for (row, x) in sum.iter_mut().zip(sample) {
            row.iter_mut().zip(sample).for_each(|(entry, y)| *entry += x * y);
        }
    }
    Mat::from_fn(LOGS, LOGS, |i, j| sum[i][j] / f64::max(count, 1.0))
}

/// Returns the identity matrix times a number.
pub(super) fn diagonal(value: f64) -> Mat<f64> {
    Mat::from_fn(LOGS, LOGS, |i, j| if i == j { value } else { 0.0 })
}

/// Computes the lower Cholesky factor; `None` unless the matrix is positive definite.
pub(super) fn cholesky(matrix: &Mat<f64>) -> Option<Mat<f64>> {
    Some(matrix.llt(Side::Lower).ok()?.L().to_owned())
}

pub(super) fn product(matrix: &Mat<f64>, x: &Logs) -> Logs {
    std::array::from_fn(|i| (0..LOGS).map(|j| matrix[(i, j)] * x[j]).sum())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn base() -> Logs {
        std::array::from_fn(|i| i as f64)
    }

    fn plus(logs: Logs, at: usize, length: f64) -> Logs {
        let mut logs = logs;
        logs[at] += length;
        logs
    }

    /// Returns the spectrum with these logarithms, of a closed shape.
    fn spectrum(logs: Logs) -> Spectrum {
        std::array::from_fn(|i| if i == 0 { 0.0 } else { logs[i - 1].exp() })
    }

    /// Returns two identities for each logarithm, which differ from the mean by plus or minus
    /// `apart` in this logarithm, each in two poses that add plus or minus `turned`.
    fn shapes(apart: f64, turned: f64) -> Vec<(usize, Spectrum)> {
        let mut shapes = Vec::new();
        for at in 0..LOGS {
            for (number, own) in [apart, -apart].into_iter().enumerate() {
                for pose in [turned, -turned] {
                    shapes.push((2 * at + number, spectrum(plus(base(), at, own + pose))));
                }
            }
        }
        shapes
    }

    /// Returns errors with the mean `mean` and the independent deviations `0.01 (i + 1)`.
    fn errors(mean: f64) -> Vec<Logs> {
        let length = |i: usize| 0.01 * (i + 1) as f64 * (LOGS as f64).sqrt();
        let of = |i: usize| [length(i), -length(i)].map(|x| plus([mean; LOGS], i, x));
        (0..LOGS).flat_map(of).collect()
    }

    #[test]
    fn distances_are_those_of_the_conditional_distribution() {
        let (apart, turned) = (0.5, 0.1);
        let options = MetricOptions { shrinkage: 0.25, ..MetricOptions::default() };
        let metric = RetrievalMetric::fit(&shapes(apart, turned), &errors(0.02), &options).unwrap();
        let n = LOGS as f64;
        // 4 of 4 n shapes differ from the mean in each logarithm; the variance of two poses is
        // twice the square.
        let within = 2.0 * turned * turned / n + NOISE;
        let total = (apart * apart + turned * turned) / n + NOISE;
        let mean_variance = (1..=LOGS).map(|i| 1e-4 * (i * i) as f64).sum::<f64>() / n;
        for i in [0, 7, 18] {
            let error = 0.75 * 1e-4 * ((i + 1) * (i + 1)) as f64 + 0.25 * mean_variance;
            let scatter = 2.0 * within - within * within / total + error;
            for (query, shape) in [(0.3, 0.3), (0.1, -0.2)] {
                let found = metric.distance(
                    &spectrum(plus(base().map(|x| x + 0.02), i, query)),
                    &spectrum(plus(base(), i, shape)),
                );
                let apart = query - (1.0 - within / total) * shape;
                let expected = apart.abs() / scatter.sqrt();
                assert!((found - expected).abs() < 1e-9, "{found} {expected}");
            }
        }
    }

    #[test]
    fn poses_in_common_cost_little_and_other_differences_much() {
        // Poses change all logarithms together.
        let by = |x: f64| base().map(|logarithm| logarithm + x);
        let mut poses = shapes(0.5, 0.0);
        poses.extend([0.3, -0.3].map(|x| (1000, spectrum(by(x)))));
        let metric = RetrievalMetric::fit(&poses, &[], &MetricOptions::default()).unwrap();
        let here = spectrum(base());
        let together = metric.distance(&spectrum(by(0.1)), &here);
        let alone = metric.distance(&spectrum(plus(base(), 4, 0.1)), &here);
        assert!(20.0 * together < alone, "{together} {alone}");
    }

    #[test]
    fn the_size_may_be_left_out() {
        let fit = |scale_free| {
            let options = MetricOptions { scale_free, ..MetricOptions::default() };
            RetrievalMetric::fit(&shapes(0.5, 0.1), &errors(0.0), &options).unwrap()
        };
        let (one, other) = (spectrum(base()), spectrum(plus(base(), 3, 0.2)));
        let larger = one.map(|x| 3.0 * x);
        let metric = fit(true);
        let apart = metric.distance(&one, &other);
        assert!(metric.distance(&one, &one) < 1e-9 && apart > 0.1);
        assert!((metric.distance(&larger, &other) - apart).abs() < 1e-9);
        let metric = fit(false);
        assert!(metric.distance(&larger, &one) > 10.0);
    }

    #[test]
    fn deviations_estimate_the_covariance_without_bias() {
        let [one, other] = [[1.0; LOGS], [4.0; LOGS]];
        let found = pose_deviations(&[(4, one), (2, one), (4, other)]);
        assert_eq!(found.len(), 2);
        // The variance of 1 and 4 is 4.5.
        let squares: f64 = found.iter().map(|deviation| deviation[3] * deviation[3]).sum();
        assert!((squares / 2.0 - 4.5).abs() < 1e-12);
    }

    #[test]
    fn what_cannot_be_fitted_is_refused() {
        let refused = |shapes: &[(usize, Spectrum)], errors: &[Logs], shrinkage| {
            let options = MetricOptions { shrinkage, ..MetricOptions::default() };
            RetrievalMetric::fit(shapes, errors, &options).unwrap_err().to_string()
        };
        let shapes = shapes(0.5, 0.1);
        assert!(refused(&shapes, &[], 1.5).starts_with("shrinkage"));
        assert!(refused(&shapes[..1], &[], 0.5).contains("several poses"));
        assert!(refused(&shapes, &[[f64::NAN; LOGS]], 0.5).contains("not finite"));
    }
}
