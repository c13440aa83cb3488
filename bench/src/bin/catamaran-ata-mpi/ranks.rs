//! Communication between the ranks around the measurements.

use std::time::Instant;

use catamaran_bench::Result;
use mpi::collective::SystemOperation;
use mpi::topology::SimpleCommunicator;
use mpi::traits::{Communicator, CommunicatorCollectives, Root};

/// All ranks.
pub struct Ranks<'c>(pub &'c SimpleCommunicator);

impl Ranks<'_> {
    /// Returns the number of this rank, from 0.
    pub fn own(&self) -> usize {
        self.0.rank() as usize
    }

    /// Returns the number of ranks.
    pub fn count(&self) -> usize {
        self.0.size() as usize
    }

    /// Returns the number of machines.
    pub fn machines(&self) -> usize {
        let is_first = self.0.split_shared(self.0.rank()).rank() == 0;
        self.sum(f64::from(u8::from(is_first))) as usize
    }

    /// Returns the number of ranks on this machine.
    pub fn on_this_machine(&self) -> usize {
        self.0.split_shared(self.0.rank()).size() as usize
    }

    /// Returns the largest of all ranks' values.
    pub fn largest(&self, own: f64) -> f64 {
        self.reduce(own, SystemOperation::max())
    }

    /// Returns the sum of all ranks' values.
    pub fn sum(&self, own: f64) -> f64 {
        self.reduce(own, SystemOperation::sum())
    }

    fn reduce(&self, own: f64, operation: SystemOperation) -> f64 {
        let mut all = 0.0;
        self.0.all_reduce_into(&own, &mut all, operation);
        all
    }

    /// Returns the seconds that `work` takes on this rank, from the moment when all ranks are
    /// ready.
    pub fn time<R>(&self, work: impl FnOnce() -> R) -> (f64, R) {
        self.0.barrier();
        let start = Instant::now();
        let result = work();
        (start.elapsed().as_secs_f64(), result)
    }

    /// Returns this rank's result; if one rank fails, every rank returns the error.
    ///
    /// # Errors
    /// The error of the first rank that fails.
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
