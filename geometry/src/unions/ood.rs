use faer::Mat;

use super::network::K;
use catamaran::base::{Error, Result};
use catamaran::dense;

/// Number of features of a pair that do not depend on the order of its spectra.
pub(super) const SYMMETRIC: usize = 2 * K;

/// Detects pairs that differ from those of the training, by their Mahalanobis distance from the
/// mean, and by the probability that the network predicts.
#[derive(Debug, Clone, PartialEq)]
pub struct OodDetector {
    pub(super) mean: Vec<f32>,
    /// The inverse Cholesky factor of the covariance, lower triangular, by rows.
    pub(super) whitening: Vec<f32>,
    /// Distance that few pairs of the training exceed.
    pub(super) limit: f32,
    /// Probability that few pairs of the training exceed.
    pub(super) probability_limit: f32,
}

/// Probabilities below this are ignored.
const LEAST_PROBABILITY: f32 = 0.05;

/// Added to variances of logarithms of eigenvalues: variations below 0.1 % are noise of the
/// discretization.
const NOISE: f64 = 1e-6;

impl OodDetector {
    /// Fits a detector to the symmetric features
    /// ([`PartFeatures::symmetric`](super::PartFeatures::symmetric)) of all pairs of the training,
    /// of which the share `within` must score at most 1. Probabilities are not used yet.
    ///
    /// ```
    /// use catamaran_geometry::unions::{K, OodDetector};
    ///
    /// assert!(OodDetector::fit(&[[0.0; 2 * K], [1.0; 2 * K]], 0.995).is_ok());
    /// assert!(OodDetector::fit(&[], 0.995).is_err());
    /// ```
    ///
    /// # Errors
    /// [`Error::Argument`] for no pairs, a share outside [0, 1], or features that are not finite.
    pub fn fit(pairs: &[[f64; SYMMETRIC]], within: f64) -> Result<Self> {
        let refuse = |what, why: &str| Error::Argument { what, why: why.into() };
        if pairs.is_empty() {
            return Err(refuse("pairs", "must not be empty"));
        }
        if !(0.0..=1.0).contains(&within) {
            return Err(refuse("within", "must be in [0, 1]"));
        }
        let count = pairs.len() as f64;
        let mean: [f64; SYMMETRIC] =
            std::array::from_fn(|j| pairs.iter().map(|pair| pair[j]).sum::<f64>() / count);
        let mut factor = Mat::from_fn(SYMMETRIC, SYMMETRIC, |i, j| {
            let sum: f64 = pairs.iter().map(|p| (p[i] - mean[i]) * (p[j] - mean[j])).sum();
            sum / count + if i == j { NOISE } else { 0.0 }
        });
        dense::cholesky(factor.as_mut())?
            .map_err(|_| refuse("pairs", "must have a finite covariance"))?;
        let mut whitening = Mat::<f64>::identity(SYMMETRIC, SYMMETRIC);
        dense::lower_solve_in_place(factor.as_ref(), whitening.as_mut());
        let mut found = Self {
            mean: mean.iter().map(|&x| x as f32).collect(),
            whitening: (0..SYMMETRIC * SYMMETRIC)
                .map(|at| whitening[(at / SYMMETRIC, at % SYMMETRIC)] as f32)
                .collect(),
            limit: 1.0,
            probability_limit: 1.0,
        };
        let distances = pairs.iter().map(|pair| found.distance(pair)).collect();
        found.limit = (quantile(distances, within) as f32).max(f32::MIN_POSITIVE);
        Ok(found)
    }

    /// Returns the detector with a limit of probabilities, from those of some pairs of the training
    /// ([`SpectralUnion::ood_probability`](super::SpectralUnion::ood_probability)), of which the
    /// share `within` shall score at most 1; returns it unchanged for no pairs.
    ///
    /// # Panics
    /// For a share outside [0, 1].
    pub fn with_probabilities(self, probabilities: Vec<f64>, within: f64) -> Self {
        if probabilities.is_empty() {
            return self;
        }
        Self {
            probability_limit: (quantile(probabilities, within) as f32).max(LEAST_PROBABILITY),
            ..self
        }
    }

    /// Returns the out-of-distribution score of a pair; above 1 the pair is further out than most
    /// pairs of the training.
    pub(super) fn ood_score(&self, pair: &[f64; SYMMETRIC], probability: f64) -> f64 {
        self.distance(pair).max(probability / f64::from(self.probability_limit))
    }

    /// Returns the distance of a pair, in units of the limit.
    fn distance(&self, pair: &[f64; SYMMETRIC]) -> f64 {
        let centred: [f64; SYMMETRIC] = std::array::from_fn(|j| pair[j] - f64::from(self.mean[j]));
        let squares: f64 = self
            .whitening
            .chunks_exact(SYMMETRIC)
            .map(|row| {
                let sum: f64 = row.iter().zip(centred).map(|(&w, x)| f64::from(w) * x).sum();
                sum * sum
            })
            .sum();
        squares.sqrt() / f64::from(self.limit)
    }
}

/// Returns the value that this share of the values does not exceed.
fn quantile(mut values: Vec<f64>, share: f64) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    values[(share * (values.len() - 1) as f64).round() as usize]
}

#[cfg(test)]
mod tests {
    use super::*;
    use catamaran::base::Rng;

    #[test]
    fn few_pairs_of_the_training_are_out_of_distribution_and_others_are() {
        let mut rng = Rng::new(5);
        let pairs: Vec<[f64; SYMMETRIC]> = (0..500)
            .map(|_| {
                let common = rng.normal();
                std::array::from_fn(|j| common * j as f64 + 0.1 * rng.normal())
            })
            .collect();
        let detector = OodDetector::fit(&pairs, 0.99).unwrap();
        let outside = pairs.iter().filter(|pair| detector.distance(pair) > 1.0 + 1e-6).count();
        assert_eq!(outside, 5);
        // As far from the mean as the others, but orthogonal to their direction.
        let across = std::array::from_fn(|j| if j % 2 == 0 { 3.0 } else { -3.0 });
        assert!(detector.distance(&across) > 5.0);
        // Probabilities are used once usual ones are known.
        assert!(detector.ood_score(&pairs[0], 0.9) < 1.0 + 1e-6);
        let probabilities = (0..=100).map(|i| f64::from(i) / 200.0).collect();
        let detector = detector.with_probabilities(probabilities, 0.8);
        let mean = std::array::from_fn(|j| f64::from(detector.mean[j]));
        assert!((detector.ood_score(&mean, 0.8) - 2.0).abs() < 1e-6);
    }

    #[test]
    fn equal_pairs_and_none() {
        let detector = OodDetector::fit(&[[1.0; SYMMETRIC]; 3], 1.0).unwrap();
        assert!(detector.distance(&[2.0; SYMMETRIC]) > 1.0);
        assert!(
            OodDetector::fit(&[], 0.5).is_err()
                && OodDetector::fit(&[[1.0; SYMMETRIC]], 2.0).is_err()
        );
        assert!(OodDetector::fit(&[[f64::NAN; SYMMETRIC]], 1.0).is_err());
    }
}
