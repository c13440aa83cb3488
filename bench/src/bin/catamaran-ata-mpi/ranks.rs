//! What the ranks tell each other around the measurements.

use std::time::Instant;

use catamaran_bench::Result;
use mpi::collective::SystemOperation;
use mpi::topology::SimpleCommunicator;
use mpi::traits::{Communicator, CommunicatorCollectives, Root};

/// All ranks.
pub struct Ranks<'c>(pub &'c SimpleCommunicator);

impl Ranks<'_> {
    /// This rank, from 0.
    pub fn own(&self) -> usize {
        self.0.rank() as usize
    }

    /// Their number.
    pub fn count(&self) -> usize {
        self.0.size() as usize
    }

    /// The number of machines they are on.
    pub fn machines(&self) -> usize {
        let is_first = self.0.split_shared(self.0.rank()).rank() == 0;
        self.sum(f64::from(u8::from(is_first))) as usize
    }

    /// The number of ranks on this machine.
    pub fn on_this_machine(&self) -> usize {
        self.0.split_shared(self.0.rank()).size() as usize
    }

    /// The largest of all ranks' values.
    pub fn largest(&self, own: f64) -> f64 {
        self.reduce(own, SystemOperation::max())
    }

    /// The sum of all ranks' values.
    pub fn sum(&self, own: f64) -> f64 {
        self.reduce(own, SystemOperation::sum())
    }

    fn reduce(&self, own: f64, operation: SystemOperation) -> f64 {
        let mut all = 0.0;
        self.0.all_reduce_into(&own, &mut all, operation);
        all
    }

    /// Seconds that `work` takes on this rank, once all are there.
    pub fn time<R>(&self, work: impl FnOnce() -> R) -> (f64, R) {
        self.0.barrier();
        let start = Instant::now();
        let result = work();
        (start.elapsed().as_secs_f64(), result)
    }

    /// What a rank did by itself: an error on one is an error on all.
    ///
    /// # Errors
    /// That of the first rank that has one.
    pub fn agree<R>(&self, own: Result<R>) -> Result<R> {
        let failed = if own.is_err() { self.0.rank() } else { i32::MAX };
        let mut first = 0;
        self.0.all_reduce_into(&failed, &mut first, SystemOperation::min());
        if first == i32::MAX {
            return own;
        }
        let mut text = own.err().map(|e| e.to_string().into_bytes()).unwrap_or_default();
        let root = self.0.process_at_rank(first);
        let mut len = text.len() as u64;
        root.broadcast_into(&mut len);
        text.resize(len as usize, 0);
        root.broadcast_into(&mut text[..]);
        Err(format!("rank {first}: {}", String::from_utf8_lossy(&text)).into())
    }
}
