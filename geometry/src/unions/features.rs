use super::network::{FEATURES, K};
use super::spectrum;
use catamaran::base::{Error, Result};

/// The features of the parts of a union, without units, in the form that the network reads.
#[derive(Debug, Clone, PartialEq)]
pub struct PartFeatures {
    /// The divisor of the eigenvalues: the last one of the bound.
    pub scale: f64,
    /// An upper bound of the eigenvalues of the union, by Dirichlet domain monotonicity: for each
    /// index, the smallest eigenvalue of all parts.
    pub bound: [f64; K],
    /// For each part and eigenvalue, its logarithm, and K times the difference from the previous
    /// eigenvalue.
    pub features: Vec<[[f64; FEATURES]; K]>,
}

impl PartFeatures {
    /// Computes the features of two parts with these spectra.
    ///
    /// ```
    /// use catamaran_geometry::unions::{K, PartFeatures};
    ///
    /// let part: Vec<f64> = (1..=K).map(|k| k as f64).collect();
    /// let features = PartFeatures::of_pair(&part, &part)?;
    /// assert_eq!((features.scale, features.bound[0]), (K as f64, 1.0));
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Shape`], [`Error::NonFinite`] and [`Error::Argument`] name the spectrum, `first` or
    /// `second`.
    pub fn of_pair(first: &[f64], second: &[f64]) -> Result<Self> {
        Ok(Self::of(&[spectrum::check("first", first)?, spectrum::check("second", second)?]))
    }

    /// Computes the features of parts with these spectra.
    ///
    /// # Errors
    /// [`Error::NonFinite`] and [`Error::Argument`] for an invalid spectrum, and for no parts.
    pub fn new(parts: &[[f64; K]]) -> Result<Self> {
        parts.iter().try_for_each(|part| spectrum::check("parts", part).map(drop))?;
        match parts.is_empty() {
            true => Err(Error::Argument { what: "parts", why: "must not be empty".into() }),
            false => Ok(Self::of(parts)),
        }
    }

    fn of(parts: &[[f64; K]]) -> Self {
        let least = |i: usize| parts.iter().map(|part| part[i]).fold(f64::INFINITY, f64::min);
        let bound: [f64; K] = std::array::from_fn(least);
        let scale = bound[K - 1];
        let of_part = |values: &[f64; K]| {
            std::array::from_fn(|i| {
                let before = if i == 0 { 0.0 } else { values[i - 1] };
                [(values[i] / scale).ln(), K as f64 * ((values[i] - before) / scale)]
            })
        };
        Self { scale, bound, features: parts.iter().map(of_part).collect() }
    }

    /// Returns features that do not depend on the order of the parts: the mean of each logarithm
    /// over the parts, and the difference between its largest and smallest value.
    pub fn symmetric(&self) -> [f64; 2 * K] {
        let count = self.features.len() as f64;
        std::array::from_fn(|j| {
            let logarithms = || self.features.iter().map(|part| part[j % K][0]);
            if j < K {
                return logarithms().sum::<f64>() / count;
            }
            let largest = logarithms().fold(f64::NEG_INFINITY, f64::max);
            largest - logarithms().fold(f64::INFINITY, f64::min)
        })
    }
}
