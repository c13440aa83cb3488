//! The operands: seeded random matrices.

use std::str::FromStr;

use catamaran::Real;
use catamaran::base::Rng;
use clap::ValueEnum;

/// The distribution of the entries of A.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Distribution {
    /// Uniform in [-1, 1).
    Uniform,
    /// Standard normal.
    Gaussian,
    /// Uniform in [0, 1): no cancellation, large sums.
    Positive,
    /// Column j of a Gaussian matrix times 2^e_j, the e_j uniform integers: columns of very
    /// different norms. In f64 from -100 to 100, in f32 from -30 to 30.
    Graded,
    /// (u - 1/2) exp(g), u uniform in [0, 1), g standard normal.
    Lognormal1,
    /// (u - 1/2) exp(4 g): entries of very different sizes within each column.
    Lognormal4,
}

impl std::fmt::Display for Distribution {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let value = self.to_possible_value();
        f.pad(value.as_ref().map_or("", |v| v.get_name()))
    }
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

/// Returns A, row-major.
pub fn matrix<T: Real>(shape: Shape, distribution: Distribution, seed: u64) -> Vec<T> {
    let mut rng = Rng::new(seed);
    let powers: Vec<f64> = match distribution {
        Distribution::Graded => graded_powers::<T>(shape.n, &mut rng),
        _ => vec![1.0; shape.n],
    };
    let mut draw = || match distribution {
        Distribution::Uniform => 2.0 * rng.uniform() - 1.0,
        Distribution::Gaussian | Distribution::Graded => rng.normal(),
        Distribution::Positive => rng.uniform(),
        Distribution::Lognormal1 => lognormal(1.0, &mut rng),
        Distribution::Lognormal4 => lognormal(4.0, &mut rng),
    };
    let mut a = Vec::with_capacity(shape.m * shape.n);
    for _ in 0..shape.m {
        a.extend(powers.iter().map(|power| T::from_f64(power * draw())));
    }
    a
}

/// Returns the powers of two that scale the columns of [`Distribution::Graded`].
fn graded_powers<T: Real>(n: usize, rng: &mut Rng) -> Vec<f64> {
    // The products of any two columns must stay within the range of T.
    let most = if size_of::<T>() == 8 { 100 } else { 30 };
    let exponents = 2 * most + 1;
    (0..n).map(|_| 2f64.powi((rng.uniform() * exponents as f64) as i32 - most)).collect()
}

/// Returns a number of the distribution "phi-lognormal" of the papers on Ozaki's scheme.
fn lognormal(phi: f64, rng: &mut Rng) -> f64 {
    (rng.uniform() - 0.5) * (phi * rng.normal()).exp()
}

/// Returns the folder of real inputs: CATAMARAN_DATA, by default ../shared.
pub fn data_folder() -> std::path::PathBuf {
    std::env::var_os("CATAMARAN_DATA").map_or_else(|| "../shared".into(), Into::into)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TALL: Shape = Shape { m: 4000, n: 5 };

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
    fn positive_is_positive() {
        let a = matrix::<f32>(TALL, Distribution::Positive, 7);
        assert!(a.iter().all(|x| (0.0..=1.0).contains(x)));
    }

    #[test]
    fn every_distribution_is_named_seeded_and_finite() {
        for distribution in Distribution::value_variants() {
            let name = distribution.to_string();
            assert_eq!(Distribution::from_str(&name, false).as_ref(), Ok(distribution));
            let a = matrix::<f32>(TALL, *distribution, 7);
            assert_eq!(a.len(), TALL.m * TALL.n);
            assert!(a.iter().all(|x| x.is_finite()), "{name}");
            assert_eq!(a, matrix::<f32>(TALL, *distribution, 7), "{name}");
            assert_ne!(a, matrix::<f32>(TALL, *distribution, 8), "{name}");
        }
    }

    #[test]
    fn graded_columns_are_gaussian_ones_times_powers_of_two() {
        fn exponents<T: Real>() -> Vec<i32> {
            graded_powers::<T>(10_000, &mut Rng::new(3)).iter().map(|p| p.log2() as i32).collect()
        }
        for (exponents, most) in [(exponents::<f64>(), 100), (exponents::<f32>(), 30)] {
            assert_eq!(exponents.iter().min(), Some(&-most));
            assert_eq!(exponents.iter().max(), Some(&most));
        }
        let powers = graded_powers::<f64>(TALL.n, &mut Rng::new(3));
        let a = matrix::<f64>(TALL, Distribution::Graded, 3);
        for (j, power) in powers.iter().enumerate() {
            let squares = a.iter().skip(j).step_by(TALL.n).map(|x| (x / power).powi(2));
            let variance = squares.sum::<f64>() / TALL.m as f64;
            assert!((variance - 1.0).abs() < 0.2, "column {j}: {variance}");
        }
    }

    #[test]
    fn lognormal_entries_spread_as_told() {
        for (distribution, phi) in
            [(Distribution::Lognormal1, 1.0), (Distribution::Lognormal4, 4.0)]
        {
            // The logarithm of |x| has the variance of ln u, which is 1, plus phi^2.
            let logs: Vec<_> =
                matrix::<f64>(TALL, distribution, 5).iter().map(|x| x.abs().ln()).collect();
            let mean = logs.iter().sum::<f64>() / logs.len() as f64;
            let variance = logs.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / logs.len() as f64;
            let expected = 1.0 + phi * phi;
            assert!((variance / expected - 1.0).abs() < 0.1, "{distribution}: {variance}");
        }
    }
}
