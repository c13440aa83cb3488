use catamaran::Result;
use catamaran_geometry::unions::SpectralUnion;

use super::errors;
use crate::train::Pair;

/// Mean relative error above which a prediction counts as wrong.
pub const WRONG: f64 = 0.15;

/// The threshold that the documentation of [`SpectralUnion::ood_score`] recommends.
pub const DOCUMENTED_THRESHOLD: f64 = 1.0;

/// The thresholds of the tables.
pub const THRESHOLDS: [f64; 11] = [0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.3, 1.4, 1.5];

/// The results of the prediction for a pair.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Judgement {
    /// The out-of-distribution score of the pair.
    pub score: f64,
    /// Mean relative error of the prediction.
    pub error: f64,
    /// Whether the parts are those of a human.
    pub human: bool,
}

impl Judgement {
    /// Judges the prediction for a pair.
    ///
    /// # Errors
    /// As [`SpectralUnion::predict`].
    pub fn of(model: &SpectralUnion, pair: &Pair, human: bool) -> Result<Self> {
        let score = model.ood_score(&[&pair.first, &pair.second])?;
        let error = errors(model, std::slice::from_ref(pair))?.relative;
        Ok(Self { score, error, human })
    }

    /// Returns the score, and whether the prediction is wrong, as for [`Detection::at`].
    pub fn wrong(&self) -> (f64, bool) {
        (self.score, self.error > WRONG)
    }

    /// Returns the score, and whether the parts are not those of a human.
    pub fn not_human(&self) -> (f64, bool) {
        (self.score, !self.human)
    }
}

/// The pairs that a threshold detects.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Detection {
    /// Number of pairs that score above the threshold.
    pub flagged: usize,
    /// Number of pairs with the label.
    pub wanted: usize,
    /// Number of pairs that score above the threshold and have the label.
    pub found: usize,
}

impl Detection {
    /// Counts the scores above a threshold, and the labels.
    pub fn at(threshold: f64, scored: &[(f64, bool)]) -> Self {
        let count = |of: fn(bool, bool) -> bool| {
            scored.iter().filter(|&&(score, label)| of(score > threshold, label)).count()
        };
        Self {
            flagged: count(|flagged, _| flagged),
            wanted: count(|_, label| label),
            found: count(|flagged, label| flagged && label),
        }
    }

    /// Returns the share of the flagged pairs that have the label; `None` if nothing is flagged.
    pub fn precision(&self) -> Option<f64> {
        (self.flagged > 0).then(|| self.found as f64 / self.flagged as f64)
    }

    /// Returns the share of the pairs with the label that are flagged; `None` if no pair has it.
    pub fn recall(&self) -> Option<f64> {
        (self.wanted > 0).then(|| self.found as f64 / self.wanted as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SCORED: [(f64, bool); 6] =
        [(0.2, false), (0.4, true), (0.9, false), (1.0, true), (1.1, true), (3.0, true)];

    #[test]
    fn precision_and_recall_are_those_counted_by_hand() {
        let at = |threshold| Detection::at(threshold, &SCORED);
        assert_eq!(at(0.5), Detection { flagged: 4, wanted: 4, found: 3 });
        assert_eq!((at(0.5).precision(), at(0.5).recall()), (Some(0.75), Some(0.75)));
        // A score equal to the threshold is not flagged.
        assert_eq!(at(1.0), Detection { flagged: 2, wanted: 4, found: 2 });
        assert_eq!((at(1.0).precision(), at(1.0).recall()), (Some(1.0), Some(0.5)));
        assert_eq!((at(0.0).precision(), at(0.0).recall()), (Some(4.0 / 6.0), Some(1.0)));
    }

    #[test]
    fn shares_of_nothing_are_none() {
        let found = Detection::at(5.0, &SCORED);
        assert_eq!((found.precision(), found.recall()), (None, Some(0.0)));
        let found = Detection::at(0.0, &[(1.0, false)]);
        assert_eq!((found.precision(), found.recall()), (Some(0.0), None));
        let found = Detection::at(0.0, &[]);
        assert_eq!((found.precision(), found.recall()), (None, None));
    }

    #[test]
    fn labels_follow_from_error_and_kind() {
        let judgement = Judgement { score: 0.7, error: 0.2, human: true };
        assert_eq!((judgement.wrong(), judgement.not_human()), ((0.7, true), (0.7, false)));
        let judgement = Judgement { score: 0.7, error: WRONG, human: false };
        assert_eq!((judgement.wrong(), judgement.not_human()), ((0.7, false), (0.7, true)));
    }
}
