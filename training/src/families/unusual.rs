//! Humans outside of the range of the training.

use catamaran::base::Rng;

use super::skeleton::{Proportions, Skeleton};

/// A kind of humans that no data set has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unusual {
    /// A large head, short limbs and small hands and feet.
    Child,
    /// A trunk of nearly twice the width, and thick limbs.
    Heavy,
    /// Long and thin limbs.
    Lanky,
    /// Usual proportions in poses whose joints turn nearly twice as far.
    Contorted,
}

impl Unusual {
    /// The factor of the rotations of poses.
    pub(super) fn turned(self) -> f64 {
        if self == Self::Contorted { 1.8 } else { 1.0 }
    }

    /// Draws proportions of this kind for the skeleton of the humanoids.
    pub(super) fn proportions(self, skeleton: &Skeleton, rng: &mut Rng) -> Proportions {
        if self == Self::Contorted {
            return skeleton.proportions(0, rng);
        }
        // Factors of length and thickness: trunk (entries 0 to 1), neck, head, shoulder, limbs
        // (5, 6, 8, 9), hands and feet.
        let of = |entry: usize| match (self, entry) {
            (Self::Child, 0 | 1) => [0.85, 0.95],
            (Self::Child, 2) => [0.6, 0.95],
            (Self::Child, 3) => [1.3, 1.5],
            (Self::Child, 4) => [0.8, 0.9],
            (Self::Child, 5 | 6 | 8 | 9) => [0.65, 1.0],
            (Self::Child, _) => [0.7, 0.9],
            (Self::Heavy, 0 | 1) => [1.0, 1.85],
            (Self::Heavy, 2 | 4) => [1.1, 1.5],
            (Self::Heavy, 5 | 6 | 8 | 9) => [1.0, 1.4],
            (Self::Lanky, 5 | 6 | 8 | 9) => [1.5, 0.75],
            (Self::Lanky, 2) => [1.5, 0.8],
            _ => [1.0, 1.0],
        };
        let mut about_one = |spread: f64| 1.0 + spread * (2.0 * rng.uniform() - 1.0);
        let own: Vec<[f64; 2]> = (0..skeleton.entries())
            .map(|entry| of(entry).map(|factor| factor * about_one(0.08)))
            .collect();
        skeleton.with_entries(&own)
    }
}
