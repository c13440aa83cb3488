//! Short messages between processes that are at work: one that gets a signal or fails tells the
//! others, which look for such messages between two blocks of rows.

use std::mem;
use std::thread;
use std::time::{Duration, Instant};

use mpi::request::StaticScope;
use mpi::topology::SimpleCommunicator;
use mpi::traits::{Communicator, CommunicatorCollectives, Destination, Source};

/// The time between two looks at messages while this process waits.
pub const POLL: Duration = Duration::from_millis(1);

/// What a message says, by its tag.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Notice {
    /// All processes are to save their sums and to end.
    Stop = 1,
    /// A process has failed, and says why; the job is about to be aborted.
    Failed = 2,
}

/// The messages of all processes, on a communicator that has no others.
pub struct Notices(SimpleCommunicator);

/// The content of every message, which is alive as long as any of them.
static NOTHING: u8 = 0;

impl Notices {
    /// Returns the messages on a duplicate of a communicator. All processes call this function.
    pub fn new(comm: &SimpleCommunicator) -> Self {
        Self(comm.duplicate())
    }

    /// Sends a message to all others, without waiting for them.
    pub fn send(&self, notice: Notice) {
        let others = (0..self.0.size()).filter(|&rank| rank != self.0.rank());
        for rank in others {
            let other = self.0.process_at_rank(rank);
            let request = other.immediate_send_with_tag(StaticScope, &NOTHING, notice as i32);
            // The job ends before anything waits for it.
            mem::forget(request);
        }
    }

    /// Returns whether there is such a message from any process.
    pub fn has(&self, notice: Notice) -> bool {
        self.0.any_process().immediate_probe_with_tag(notice as i32).is_some()
    }

    /// Returns whether there is such a message from a process of a lower rank.
    pub fn has_from_before(&self, rank: usize, notice: Notice) -> bool {
        (0..rank as i32).any(|rank| {
            self.0.process_at_rank(rank).immediate_probe_with_tag(notice as i32).is_some()
        })
    }

    /// Waits until all processes have called this function, but no longer than `patience`.
    pub fn meet(&self, patience: Duration) {
        let start = Instant::now();
        wait_on(&self.0, || start.elapsed() < patience);
    }
}

/// Waits until all processes of a communicator wait on it, or `go_on` returns false; then the
/// communicator is of no more use. Returns whether all wait.
pub fn wait_on(comm: &SimpleCommunicator, mut go_on: impl FnMut() -> bool) -> bool {
    let mut barrier = comm.immediate_barrier();
    loop {
        match barrier.test() {
            Ok(_) => return true,
            Err(pending) => barrier = pending,
        }
        if !go_on() {
            // The job ends before anything waits for it.
            mem::forget(barrier);
            return false;
        }
        thread::sleep(POLL);
    }
}
