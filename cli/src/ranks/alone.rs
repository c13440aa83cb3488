//! The only process, in a program without MPI.

use anyhow::Result;
use catamaran::base::available_memory;
use catamaran::ranks::Launch;
use catamaran::rows::{Accumulator, RowBlocks, RowBounds};
use catamaran::sparse::{CsMat, EigenOptions, Eigenpairs, Mass, eigs_sliced};

use super::{Crowd, Scalar, said_by_one};
use crate::signals;

/// The only process.
pub struct Ranks {}

impl Ranks {
    /// Refuses launchers, under which every process would do all of the work.
    pub fn join() -> Result<Self> {
        if let Some(launch) = Launch::of_process() {
            let what = "this program was built without MPI (--features mpi)";
            said_by_one(&launch, launch.check_alone(what))?;
        }
        Ok(Self {})
    }

    /// Returns the number of this process, from 0.
    pub fn rank(&self) -> usize {
        0
    }

    /// Returns the number of processes.
    pub fn size(&self) -> usize {
        1
    }

    pub(super) fn crowd(&self, _: usize) -> Option<Crowd> {
        None
    }

    /// Returns the bytes of memory that this process can take.
    pub fn available_memory(&self) -> u64 {
        available_memory()
    }

    /// Returns how many cores a process has for pinned threads, `None` for all in its mask.
    pub fn share_cores(&self) -> Option<usize> {
        None
    }

    /// Returns the error of the first process that has one.
    pub fn meet<X>(&self, own: Result<X>) -> Result<X> {
        own
    }

    /// Returns the least number of all processes.
    pub fn least(&self, own: usize) -> usize {
        own
    }

    /// Returns the sum of the numbers of all processes.
    pub fn total(&self, own: usize) -> usize {
        own
    }

    /// Returns the text of the first process.
    pub fn text_of_first(&self, own: String) -> String {
        own
    }

    /// Checks that all processes read the same rows.
    pub fn same_rows(
        &self,
        _: &mut (dyn RowBlocks<f64> + Send),
        _: &[(&'static str, usize)],
    ) -> catamaran::Result<()> {
        Ok(())
    }

    /// Checks that all processes have the same numbers.
    pub fn same_numbers(&self, _: &[(&'static str, usize)]) -> Result<()> {
        Ok(())
    }

    /// Returns an error after a signal.
    pub fn check(&self) -> catamaran::Result<()> {
        signals::check()
    }

    /// Waits for all processes.
    pub fn gather_up(&self) -> catamaran::Result<()> {
        Ok(())
    }

    /// Notes that this process has saved its sums after a signal.
    pub fn note_stop(&self) {}

    /// Merges the sums of all processes, and returns them on the first one.
    pub fn merge<T: Scalar>(&self, sum: Accumulator<T>) -> Result<Option<Accumulator<T>>> {
        Ok(Some(sum))
    }

    /// Returns the bounds of the rows of all processes.
    pub fn common_bounds<T: Scalar>(&self, bounds: RowBounds<T>) -> Result<RowBounds<T>> {
        Ok(bounds)
    }

    /// Computes the eigenpairs in slices that fit into `memory` bytes.
    pub fn eigenpairs(
        &self,
        stiffness: &CsMat<f64>,
        mass: &Mass,
        options: &EigenOptions<'_>,
        memory: usize,
        sink: impl FnMut(Eigenpairs) -> catamaran::Result<()>,
    ) -> catamaran::Result<()> {
        eigs_sliced(stiffness.view(), mass, options, memory, sink)
    }

    /// Returns the result.
    pub fn end(self, done: Result<()>) -> Result<()> {
        done
    }
}
