//! The product, and A: seeded, with entries that do not depend on the rank that generates them.

use std::fmt;

use catamaran::ranks::plan::Mode;
use catamaran::{AtaOptions, Par, Real, SchemeChoice};
use catamaran_bench::Result;
use catamaran_bench::input::Shape;
use catamaran_bench::product::Operation;

/// The product of a race.
#[derive(Debug, Clone, Copy)]
pub struct Job {
    /// The mode, which determines the placement of A and C.
    pub mode: Mode,
    /// Shape of A.
    pub shape: Shape,
    /// Seed of A.
    pub seed: u64,
    /// Threads of each rank.
    pub threads: usize,
    /// The scheme of the local product of a rank.
    pub scheme: SchemeChoice,
}

impl fmt::Display for Job {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, mode {}", self.shape, self.way())
    }
}

impl Job {
    /// Returns the number of operations of the classical algorithm.
    pub fn flops(&self) -> f64 {
        Operation::Syrk.flops(self.shape)
    }

    /// Returns the mode, with the scheme if one was requested.
    pub fn way(&self) -> String {
        match SchemeChoice::NAMES.iter().find(|(_, scheme)| *scheme == self.scheme) {
            Some((name, scheme)) if *scheme != SchemeChoice::Auto => {
                format!("{}:{name}", self.mode)
            }
            _ => self.mode.to_string(),
        }
    }

    /// Returns the options of the products of a rank. In the faithful mode, a thread has one task,
    /// as in AtA-S.
    pub fn options(&self) -> AtaOptions<'static> {
        let tasks = (self.scheme == SchemeChoice::Ata2).then_some(self.threads);
        AtaOptions::new().par(Par::Threads(self.threads)).scheme(self.scheme).tasks(tasks)
    }

    /// Returns entry (i, j) of A: uniform in [-1, 1). The index goes through the finalizer of
    /// SplitMix64 (Steele, Lea and Flood 2014), so that a rank can generate its entries without
    /// those of others.
    pub fn entry<T: Real>(&self, i: usize, j: usize) -> T {
        let index = (i as u64) << 32 | j as u64;
        let mut z = (index ^ self.seed.rotate_left(48)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^= z >> 31;
        T::from_f64((z >> 11) as f64 * (2.0 / (1_u64 << 53) as f64) - 1.0)
    }
}

/// Returns a matrix of `outer * inner` entries, line by line; empty lines are allowed.
///
/// # Errors
/// When there is not enough memory.
pub fn filled<T>(outer: usize, inner: usize, entry: impl Fn(usize, usize) -> T) -> Result<Vec<T>> {
    let mut entries = Vec::new();
    entries.try_reserve_exact(outer * inner).map_err(|e| format!("{outer} x {inner}: {e}"))?;
    for o in 0..outer {
        entries.extend((0..inner).map(|i| entry(o, i)));
    }
    Ok(entries)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_are_uniform_and_differ() {
        let job = |seed| Job {
            mode: Mode::Rows,
            shape: Shape { m: 99, n: 101 },
            seed,
            threads: 1,
            scheme: SchemeChoice::Auto,
        };
        let all = filled(99, 101, |i, j| job(1).entry::<f64>(i, j)).unwrap();
        let mean = |power| all.iter().map(|x| x.powi(power)).sum::<f64>() / all.len() as f64;
        assert!(mean(1).abs() < 0.03 && (mean(2) - 1.0 / 3.0).abs() < 0.02);
        assert!(all.iter().all(|x| (-1.0..1.0).contains(x)));
        assert_ne!(job(1).entry::<f64>(3, 4), job(1).entry::<f64>(4, 3));
        assert_ne!(job(1).entry::<f64>(3, 4), job(2).entry::<f64>(3, 4));
        // Neighbours are uncorrelated.
        let products = all.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / all.len() as f64;
        assert!(products.abs() < 0.02);
    }
}
