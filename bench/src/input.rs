//! What is multiplied: seeded random matrices.

use std::str::FromStr;

use catamaran::Real;
use catamaran::base::Rng;

/// The distribution of the entries of A.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Distribution {
    /// Uniform in [-1, 1).
    Uniform,
    /// Standard normal.
    Gaussian,
    /// Uniform in [0, 1): no cancellation, large sums.
    Positive,
}

/// Rows and columns of A; written `2048` for a square one, or `30000x2500`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shape {
    /// Rows.
    pub m: usize,
    /// Columns.
    pub n: usize,
}

impl FromStr for Shape {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (m, n) = text.split_once('x').unwrap_or((text, text));
        let side = |s: &str| match s.parse() {
            Ok(0) | Err(_) => Err(format!("{text}: not a size such as 2048 or 30000x2500")),
            Ok(side) => Ok(side),
        };
        Ok(Self { m: side(m)?, n: side(n)? })
    }
}

impl std::fmt::Display for Shape {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.m == self.n { write!(f, "{}", self.n) } else { write!(f, "{}x{}", self.m, self.n) }
    }
}

/// A, row-major.
pub fn matrix<T: Real>(shape: Shape, distribution: Distribution, seed: u64) -> Vec<T> {
    let mut rng = Rng::new(seed);
    let mut draw = || match distribution {
        Distribution::Uniform => 2.0 * rng.uniform() - 1.0,
        Distribution::Gaussian => rng.normal(),
        Distribution::Positive => rng.uniform(),
    };
    (0..shape.m * shape.n).map(|_| T::from_f64(draw())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shapes_are_read_and_written() {
        for text in ["2048", "30000x2500"] {
            assert_eq!(text.parse::<Shape>().unwrap().to_string(), text);
        }
        for text in ["", "0", "3x", "x3", "3x0", "-1"] {
            assert!(text.parse::<Shape>().is_err(), "{text}");
        }
    }

    #[test]
    fn positive_is_positive_and_seeded() {
        let shape = Shape { m: 3, n: 5 };
        let a = matrix::<f32>(shape, Distribution::Positive, 7);
        assert!(a.iter().all(|x| (0.0..=1.0).contains(x)));
        assert_eq!(a, matrix::<f32>(shape, Distribution::Positive, 7));
    }
}
