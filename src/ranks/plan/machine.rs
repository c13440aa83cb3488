/// A model of ranks and their network: a message of w words takes `latency + w * seconds_per_word`;
/// a rank sends one message at a time, and receives one at a time.
///
/// ```
/// use catamaran::ranks::plan::{Machine, Mode, predict};
///
/// // Products alone: 2 m n (n + 1) / 2 operations at 1 GFLOP/s.
/// let machine = Machine { latency: 0.0, seconds_per_word: 0.0, flops: 1e9 };
/// let cost = predict(Mode::Rows, 1, 1000, 100, &machine);
/// assert!((cost.seconds - 0.0101).abs() < 1e-12);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Machine {
    /// Seconds that each message takes.
    pub latency: f64,
    /// Seconds that each word takes; a word is an entry.
    pub seconds_per_word: f64,
    /// Floating-point operations of a rank per second, two for a product of scalars that is added.
    pub flops: f64,
}

impl Default for Machine {
    /// Returns a rank per core of a cluster: 2 microseconds, 10 GB/s in f64, 50 GFLOP/s.
    fn default() -> Self {
        Self { latency: 2e-6, seconds_per_word: 8e-10, flops: 5e10 }
    }
}

impl Machine {
    pub(super) fn communication(&self, messages: f64, words: f64) -> f64 {
        messages * self.latency + words * self.seconds_per_word
    }

    pub(super) fn computation(&self, products: f64) -> f64 {
        2.0 * products / self.flops
    }
}
