//! Rates of kernels, for tests that measure.

use std::time::{Duration, Instant};

/// Returns the highest rate of the runs of `work` in a tenth of a second; `work` returns how much
/// it did.
pub fn fastest(mut work: impl FnMut() -> usize) -> f64 {
    const LENGTH: Duration = Duration::from_millis(100);
    let (begin, mut best) = (Instant::now(), 0.0_f64);
    while begin.elapsed() < LENGTH {
        let start = Instant::now();
        let done = work();
        best = best.max(done as f64 / start.elapsed().as_secs_f64());
    }
    best
}
