//! What the plan says that a rank must send: the lower bound, and the formula of the thesis.

use crate::job::Job;
use crate::report::Cost;

/// The least words that some rank must receive beyond its even share of A and C, whatever the algorithm.
///
/// Al Daas, Ballard, Grigori, Kumar and Rouse, "Parallel Memory-Independent Communication Bounds for SYRK" (2023),
/// theorem 1, for an A of which each rank has an even share.
pub fn lower_bound(job: &Job, ranks: usize) -> f64 {
    let (m, n, p) = (job.shape.m as f64, job.shape.n as f64, ranks as f64);
    let (half, full) = (n * (n - 1.0) / 2.0, n * (n - 1.0));
    let share = (half + m * n) / p;
    let accessed = if n <= m && p <= m / full.sqrt() {
        m * n / p + half
    } else if m < n && p <= full / (m * m) {
        half / p + (full / p).sqrt() * m
    } else {
        1.5 * (full * m / p).powf(2.0 / 3.0)
    };
    (accessed - share).max(0.0)
}

/// Words and messages of a rank beside the least.
pub fn table(job: &Job, ranks: usize, counted: &Cost) -> String {
    let least = lower_bound(job, ranks);
    format!("words {} of {least}, {}", counted.words, counted.messages)
}
