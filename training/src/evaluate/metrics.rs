use catamaran::Result;
use catamaran_geometry::unions::SpectralUnion;

use crate::dataset::{Dataset, Spectrum};
use crate::train::{LEAST_SHARE, Pair};

/// A method that predicts the spectrum of a union from those of two parts.
pub trait Predictor {
    /// Returns the name of the method in tables.
    fn name(&self) -> &str;

    /// Returns the predicted spectrum.
    ///
    /// # Errors
    /// When a spectrum is invalid.
    fn predict(&self, first: &Spectrum, second: &Spectrum) -> Result<Spectrum>;
}

impl Predictor for SpectralUnion {
    fn name(&self) -> &str {
        "network"
    }

    fn predict(&self, first: &Spectrum, second: &Spectrum) -> Result<Spectrum> {
        Self::predict(self, first, second)
    }
}

/// Mean errors over pairs and their eigenvalues.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Errors {
    /// Number of pairs.
    pub pairs: usize,
    /// Mean squared error, in 1 / length^4.
    pub mse: f64,
    /// Mean absolute error, in 1 / length^2.
    pub mae: f64,
    /// Mean relative error; the zero eigenvalues of closed surfaces are left out.
    pub relative: f64,
}

/// Computes the errors of a predictor.
///
/// # Errors
/// When a spectrum is invalid.
pub fn errors(predictor: &dyn Predictor, pairs: &[Pair]) -> Result<Errors> {
    let (mut squares, mut absolute) = (0.0, 0.0);
    let (mut relative, mut positive) = (0.0, 0.0);
    for pair in pairs {
        let found = predictor.predict(&pair.first, &pair.second)?;
        let last = pair.union[pair.union.len() - 1];
        for (found, truth) in found.into_iter().zip(pair.union) {
            squares += (found - truth) * (found - truth);
            absolute += (found - truth).abs();
            if truth > LEAST_SHARE * last {
                relative += (found / truth - 1.0).abs();
                positive += 1.0;
            }
        }
    }
    let count = (pairs.len() * size_of::<Spectrum>() / size_of::<f64>()).max(1) as f64;
    let relative = relative / f64::max(positive, 1.0);
    Ok(Errors { pairs: pairs.len(), mse: squares / count, mae: absolute / count, relative })
}

/// Returns the pairs of a data set with these values in the columns `split`, `knowledge` and
/// `remeshed`.
pub fn select(dataset: &Dataset, split: usize, knowledge: usize, remeshed: bool) -> Vec<Pair> {
    let samples = &dataset.samples;
    (0..samples.part1.len())
        .filter(|&i| {
            samples.split[i] == split
                && samples.knowledge[i] == knowledge
                && samples.remeshed[i] == usize::from(remeshed)
        })
        .map(|i| Pair {
            first: samples.part1[i],
            second: samples.part2[i],
            union: samples.union[i],
            regions: None,
        })
        .collect()
}

/// How far unions are from being associative.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Associativity {
    /// Number of triples tested; none of them is in the training.
    pub triples: usize,
    /// Share of the triples for which (1 2) 3 and 1 (2 3) differ by at most 5 % in the mean over
    /// the eigenvalues.
    pub within: f64,
    /// Mean relative difference of (1 2) 3 and 1 (2 3).
    pub difference: f64,
    /// Mean relative error of (1 2) 3.
    pub error: f64,
    /// Mean relative error of the union of all three at once.
    pub error_at_once: f64,
}

/// Largest mean relative difference of the two orders that counts as equal.
const CLOSE: f64 = 0.05;

/// Measures associativity on the triples with this `knowledge`: of unions of two parts one after
/// the other, as in the thesis (equation 2.5), and of all three at once.
///
/// # Errors
/// When a spectrum is invalid.
pub fn associativity(
    model: &SpectralUnion,
    dataset: &Dataset,
    knowledge: usize,
) -> Result<Associativity> {
    let triples = &dataset.triples;
    let of_kind = (0..triples.part1.len()).filter(|&i| triples.knowledge[i] == knowledge);
    let (mut count, mut within, mut difference) = (0, 0, 0.0);
    let (mut error, mut error_at_once) = (0.0, 0.0);
    for i in of_kind {
        let [a, b, c] = [&triples.part1[i], &triples.part2[i], &triples.part3[i]];
        let left = model.predict(&model.predict(a, b)?, c)?;
        let right = model.predict(a, &model.predict(b, c)?)?;
        let at_once = model.predict_all(&[a, b, c])?;
        let mean = |x: &Spectrum, y: &Spectrum| {
            x.iter().zip(y).map(|(x, y)| (x - y).abs() / x.max(*y)).sum::<f64>() / x.len() as f64
        };
        let apart = mean(&left, &right);
        count += 1;
        within += usize::from(apart <= CLOSE);
        difference += apart;
        error += mean(&left, &triples.whole[i]);
        error_at_once += mean(&at_once, &triples.whole[i]);
    }
    let all = f64::from(u32::try_from(count).unwrap_or(u32::MAX)).max(1.0);
    Ok(Associativity {
        triples: count,
        within: within as f64 / all,
        difference: difference / all,
        error: error / all,
        error_at_once: error_at_once / all,
    })
}
