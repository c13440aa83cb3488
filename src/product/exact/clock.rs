//! Times of the stages.

use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// Seconds of each stage, added up over the threads.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Stages {
    /// Norms of the columns.
    pub norms: f64,
    /// Conversion to residues.
    pub conversion: f64,
    /// Products of residues, with their reductions.
    pub products: f64,
    /// Recombination of residues to C.
    pub recombination: f64,
}

/// Collects the times from all threads.
#[derive(Default)]
pub(super) struct Clock(Mutex<Stages>);

impl Clock {
    /// Adds the time of `work` on each of `threads` threads to a stage.
    pub fn time<R>(
        &self,
        stage: fn(&mut Stages) -> &mut f64,
        threads: usize,
        work: impl FnOnce() -> R,
    ) -> R {
        let start = Instant::now();
        let result = work();
        let seconds = start.elapsed().as_secs_f64() * threads as f64;
        *stage(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner)) += seconds;
        result
    }

    /// Returns the seconds of each stage so far.
    pub fn stages(&self) -> Stages {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
