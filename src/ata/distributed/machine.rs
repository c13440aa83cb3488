/// A message of w words takes `latency + w * seconds_per_word`; a rank sends one at a time, and
/// receives one at a time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Machine {
    /// Seconds.
    pub latency: f64,
    /// Seconds; a word is an entry.
    pub seconds_per_word: f64,
    /// Floating-point operations of a rank per second, two for a product of scalars that is added.
    pub flops: f64,
}

impl Default for Machine {
    /// A rank per core of a cluster: 2 microseconds, 10 GB/s in f64, 50 GFLOP/s.
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
