use super::network::{FEATURES, K};
use super::spectrum;
use crate::base::Result;

/// A pair of spectra as the network sees it: without units.
#[derive(Debug, Clone, PartialEq)]
pub struct PairFeatures {
    /// By how much eigenvalues are divided: the smaller one of the two largest.
    pub scale: f64,
    /// The union's eigenvalues are at most these (Dirichlet domain monotonicity): the smaller ones
    /// of both.
    pub bound: [f64; K],
    /// K rows of the first spectrum, then K of the second one: the logarithms of its eigenvalue and
    /// of the other's, and K times the difference from the eigenvalue before, of both.
    pub features: [[f64; FEATURES]; 2 * K],
}

impl PairFeatures {
    /// Computes the features of two parts with these spectra.
    ///
    /// # Errors
    /// [`Error::Shape`](crate::Error::Shape), [`Error::NonFinite`](crate::Error::NonFinite) and
    /// [`Error::Argument`](crate::Error::Argument) name the spectrum, `first` or `second`.
    pub fn new(first: &[f64], second: &[f64]) -> Result<Self> {
        let pair = [spectrum::check("first", first)?, spectrum::check("second", second)?];
        let bound: [f64; K] = std::array::from_fn(|i| pair[0][i].min(pair[1][i]));
        let scale = bound[K - 1];
        let logarithms = pair.map(|values| values.map(|x| (x / scale).ln()));
        let offset = |values: &[f64; K], i: usize| {
            let before = if i == 0 { 0.0 } else { values[i - 1] };
            K as f64 * ((values[i] - before) / scale)
        };
        let features = std::array::from_fn(|row| {
            let (own, i) = (row / K, row % K);
            let other = 1 - own;
            [
                logarithms[own][i],
                logarithms[other][i],
                offset(&pair[own], i),
                offset(&pair[other], i),
            ]
        });
        Ok(Self { scale, bound, features })
    }

    /// What does not change when the two spectra are swapped: the mean and the distance of each
    /// pair of logarithms.
    pub fn symmetric(&self) -> [f64; 2 * K] {
        std::array::from_fn(|j| {
            let [a, b, ..] = self.features[j % K];
            if j < K { 0.5 * (a + b) } else { (a - b).abs() }
        })
    }
}
