//! The processes of `mpirun` or `srun`, in a program with MPI.

use std::cell::Cell;
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use catamaran::base::available_memory;
use catamaran::faer::Mat;
use catamaran::ranks::{Launch, Node, World, mpi_version};
use catamaran::rows::{Accumulator, RowBlocks, RowBounds};
use catamaran::sparse::{CsMat, EigenOptions, Eigenpairs, Mass, eigs_sliced};
use mpi::collective::SystemOperation;
use mpi::topology::SimpleCommunicator;
use mpi::traits::{Communicator, CommunicatorCollectives, Root};

use super::notices::{Notice, Notices, POLL, wait_on};
use super::{Crowd, Said, Scalar, said_by_one};
use crate::{report, shortage, signals};

/// How long a process that was told to stop waits for the others, unless sums are being saved, and
/// one that fails for those before it.
const PATIENCE: Duration = Duration::from_millis(300);

/// How long it waits while others save their sums. Each ends on its own, or is killed.
const PATIENCE_TO_SAVE: Duration = Duration::from_secs(600);

/// How long a process waits to be ended by another one that has aborted the job.
const PATIENCE_TO_END: Duration = Duration::from_secs(5);

/// How long `MPI_Abort` may take.
const PATIENCE_TO_ABORT: Duration = Duration::from_millis(500);

/// How much later than the process that has failed the others end: `mpirun` names the first one.
const PATIENCE_TO_NAME: Duration = Duration::from_millis(200);

/// This process and its rank; the only process without a launcher.
pub struct Ranks {
    mpi: Option<Several>,
}

/// A process among others. Dropped in this order: MPI ends last.
struct Several {
    world: World,
    notices: Notices,
    node: Node,
    /// Whether all processes know that the job has failed, and one of them says why.
    agreed: Cell<bool>,
    /// Whether the others were told to stop.
    stopped: Cell<bool>,
    /// Whether this process has saved its sums after a signal.
    saved: Cell<bool>,
    _universe: mpi::environment::Universe,
}

impl Ranks {
    /// Starts MPI under a launcher; all but the first process are quiet from now on.
    ///
    /// # Errors
    /// Each process that the launcher started is alone, because it belongs to another MPI library.
    pub fn join() -> Result<Self> {
        let Some(launch) = Launch::of_process().filter(Launch::may_be_several) else {
            return Ok(Self { mpi: None });
        };
        let start = signals::kept(|| mpi::initialize_with_threading(mpi::Threading::Funneled));
        let (universe, _) = start.context("MPI is initialized already")?;
        let world = World::new(&universe.world())?;
        said_by_one(&launch, launch.check(world.size(), &mpi_version()))?;
        if world.size() == 1 {
            return Ok(Self { mpi: None });
        }
        match world.rank() {
            0 => report::show_lines_of_progress(),
            _ => report::be_silent(),
        }
        let (notices, node) = (Notices::new(world.communicator()), world.node());
        let [agreed, stopped, saved] = [const { Cell::new(false) }; 3];
        let _universe = universe;
        let mpi = Several { world, notices, node, agreed, stopped, saved, _universe };
        Ok(Self { mpi: Some(mpi) })
    }

    /// Returns the number of this process, from 0.
    pub fn rank(&self) -> usize {
        self.mpi.as_ref().map_or(0, |mpi| mpi.world.rank())
    }

    /// Returns the number of processes.
    pub fn size(&self) -> usize {
        self.mpi.as_ref().map_or(1, |mpi| mpi.world.size())
    }

    /// Returns the processes that share cores and have the most threads on them, if these are more
    /// than the cores.
    pub(super) fn crowd(&self, threads: usize) -> Option<Crowd> {
        let mpi = self.mpi.as_ref()?;
        let sharing = mpi.node.sharing();
        // Those that share cores have as many threads each, unless their options differ.
        let own = [sharing, sharing * threads, mpi.node.cores()].map(|number| number as u64);
        let mut all = vec![0_u64; own.len() * mpi.world.size()];
        mpi.comm().all_gather_into(&own[..], &mut all[..]);
        let groups = all.chunks_exact(own.len()).map(|group| Crowd {
            ranks: group[0] as usize,
            threads: group[1] as usize,
            cores: group[2] as usize,
        });
        Crowd::worst(groups)
    }

    /// Returns the bytes of memory that this process can take: its part of what the machine has.
    pub fn available_memory(&self) -> u64 {
        let ranks = self.mpi.as_ref().map_or(1, |mpi| mpi.node.ranks());
        available_memory() / ranks as u64
    }

    /// Divides cores among the processes that share them, for pinned threads; returns how many this
    /// process has. All processes call this function.
    pub fn share_cores(&self) -> Option<usize> {
        self.mpi.as_ref().map(|mpi| mpi.world.share_cores())
    }

    /// Waits for all processes; returns `Ok` on each of them if all have succeeded, and else an
    /// error on each: that of the first one that has failed, which says it, and [`Said`] on the
    /// others.
    pub fn meet<X>(&self, own: Result<X>) -> Result<X> {
        let Some(mpi) = &self.mpi else { return own };
        let rank = mpi.world.rank();
        let at_fault = if own.is_err() { rank as i32 } else { i32::MAX };
        let mut first = 0_i32;
        mpi.comm().all_reduce_into(&at_fault, &mut first, SystemOperation::min());
        if first == i32::MAX {
            return own;
        }
        mpi.agreed.set(true);
        match own {
            Err(error) if first as usize == rank => Err(error),
            _ => Err(Said { status: 1 }.into()),
        }
    }

    /// Returns the least number of all processes.
    pub fn least(&self, own: usize) -> usize {
        self.reduced(own, SystemOperation::min())
    }

    /// Returns the sum of the numbers of all processes.
    pub fn total(&self, own: usize) -> usize {
        self.reduced(own, SystemOperation::sum())
    }

    fn reduced(&self, own: usize, operation: SystemOperation) -> usize {
        let Some(mpi) = &self.mpi else { return own };
        let mut all = 0_u64;
        mpi.comm().all_reduce_into(&(own as u64), &mut all, operation);
        all as usize
    }

    /// Returns the text of the first process.
    pub fn text_of_first(&self, own: String) -> String {
        let Some(mpi) = &self.mpi else { return own };
        let root = mpi.comm().process_at_rank(0);
        let mut bytes = if mpi.world.rank() == 0 { own.into_bytes() } else { Vec::new() };
        let mut len = bytes.len() as u64;
        root.broadcast_into(&mut len);
        bytes.resize(len as usize, 0);
        // The address of no bytes is 1, as MPI_IN_PLACE of Open MPI.
        if len > 0 {
            root.broadcast_into(&mut bytes[..]);
        }
        String::from_utf8_lossy(&bytes).into_owned()
    }

    /// Checks that all processes read the same rows, and have the same numbers in `others`.
    pub fn same_rows(
        &self,
        rows: &mut (dyn RowBlocks<f64> + Send),
        others: &[(&'static str, usize)],
    ) -> catamaran::Result<()> {
        match &self.mpi {
            Some(mpi) => catamaran::ranks::agree_rows(&mpi.world, rows, others),
            None => Ok(()),
        }
    }

    /// Checks that all processes have the same numbers.
    pub fn same_numbers(&self, numbers: &[(&'static str, usize)]) -> Result<()> {
        let Some(mpi) = &self.mpi else { return Ok(()) };
        self.meet(catamaran::ranks::agree_numbers(&mpi.world, numbers).map_err(Into::into))
    }

    /// Returns an error after a signal to any process, and after another process has failed. A
    /// signal to this process is told to all others. Called on the thread that calls MPI.
    pub fn check(&self) -> catamaran::Result<()> {
        let own = signals::check();
        let Some(mpi) = &self.mpi else { return own };
        if own.is_err() && !mpi.stopped.replace(true) {
            mpi.notices.send(Notice::Stop);
        }
        own?;
        if mpi.notices.has(Notice::Stop) || mpi.notices.has(Notice::Failed) {
            return Err(catamaran::Error::Cancelled);
        }
        Ok(())
    }

    /// Waits for all processes, and meanwhile for signals.
    ///
    /// # Errors
    /// As [`Ranks::check`].
    pub fn gather_up(&self) -> catamaran::Result<()> {
        let Some(mpi) = &self.mpi else { return Ok(()) };
        let mut checked = Ok(());
        wait_on(mpi.comm(), || {
            checked = self.check();
            checked.is_ok()
        });
        checked
    }

    /// Notes that this process has saved its sums after a signal, and so may others still do.
    pub fn note_stop(&self) {
        if let Some(mpi) = &self.mpi {
            mpi.saved.set(true);
        }
    }

    /// Merges the sums of all processes, and returns them on the first one.
    pub fn merge<T: Scalar>(&self, sum: Accumulator<T>) -> Result<Option<Accumulator<T>>> {
        let Some(mpi) = &self.mpi else { return Ok(Some(sum)) };
        let merged = catamaran::ranks::merge_accumulators(&mpi.world, sum);
        self.meet(merged.map_err(Into::into))
    }

    /// Returns the bounds of the rows of all processes, on each of them.
    pub fn common_bounds<T: Scalar>(&self, bounds: RowBounds<T>) -> Result<RowBounds<T>> {
        let Some(mpi) = &self.mpi else { return Ok(bounds) };
        let common = catamaran::ranks::agree_bounds(&mpi.world, &bounds);
        self.meet(common.map_err(Into::into))
    }

    /// Computes the eigenpairs from the rows of this process. One process computes them in slices
    /// that fit into `memory` bytes; several processes compute all at once, and the first one gets
    /// all rows of the vectors.
    pub fn eigenpairs(
        &self,
        stiffness: &CsMat<f64>,
        mass: &Mass,
        options: &EigenOptions<'_>,
        memory: usize,
        mut sink: impl FnMut(Eigenpairs) -> catamaran::Result<()>,
    ) -> catamaran::Result<()> {
        let Some(mpi) = &self.mpi else {
            return eigs_sliced(stiffness.view(), mass, options, memory, sink);
        };
        let world = &mpi.world;
        let found = catamaran::ranks::eigs(world, stiffness.view(), mass, options)?;
        let vectors = catamaran::ranks::gather_rows(world, 0, found.vectors.as_ref())?;
        sink(Eigenpairs { vectors: vectors.unwrap_or_else(Mat::new), ..found })
    }

    /// Returns the result of the only process. Among several, the one that has failed says why. If
    /// the others do not know that yet, it ends all of them, because they would wait for ever.
    pub fn end(self, done: Result<()>) -> Result<()> {
        let Some(mpi) = &self.mpi else { return done };
        let Err(error) = done else { return Ok(()) };
        signals::wait_for_end();
        shortage::wait_for_abort();
        let is_cancelled = matches!(error.downcast_ref(), Some(catamaran::Error::Cancelled));
        if is_cancelled && !mpi.agreed.get() {
            mpi.end_all_cancelled();
        }
        if mpi.agreed.get() {
            let status = if signals::check().is_err() { signals::status() } else { 1 };
            let is_other = error.is::<Said>();
            match is_other {
                true => {}
                false if is_cancelled => report::complain(format_args!("cancelled")),
                false => mpi.complain(&error),
            }
            drop(self);
            if is_other {
                thread::sleep(PATIENCE_TO_NAME);
            }
            return Err(Said { status }.into());
        }
        mpi.notices.send(Notice::Failed);
        match mpi.is_first_to_fail() {
            true => mpi.complain(&error),
            false => thread::sleep(PATIENCE_TO_END),
        }
        mpi.abort(1);
    }
}

impl Several {
    fn comm(&self) -> &SimpleCommunicator {
        self.world.communicator()
    }

    /// Says why this process has failed. An error that names a rank comes from several processes,
    /// of which this one speaks.
    fn complain(&self, error: &anyhow::Error) {
        let names_rank = |cause: &(dyn std::error::Error + 'static)| {
            matches!(cause.downcast_ref(), Some(catamaran::Error::Rank { .. }))
        };
        let said = report::message(error);
        if error.chain().any(names_rank) {
            report::complain(format_args!("{said}"));
        } else {
            report::complain(format_args!("rank {}: {said}", self.world.rank()));
        }
    }

    /// Returns whether no process before this one fails at the same time, as all do over a file
    /// that none can read.
    fn is_first_to_fail(&self) -> bool {
        let (start, rank) = (Instant::now(), self.world.rank());
        while rank > 0 && start.elapsed() < PATIENCE {
            if self.notices.has_from_before(rank, Notice::Failed) {
                return false;
            }
            thread::sleep(POLL);
        }
        true
    }

    /// Ends all processes after a signal, when those that save their sums have done so. The first
    /// one says so, unless the signal only follows from the failure of another process.
    fn end_all_cancelled(&self) -> ! {
        if !self.stopped.replace(true) && signals::check().is_err() {
            self.notices.send(Notice::Stop);
        }
        self.notices.meet(if self.saved.get() { PATIENCE_TO_SAVE } else { PATIENCE });
        signals::keep_status();
        if self.world.rank() == 0 {
            if !self.notices.has(Notice::Failed) {
                report::complain(format_args!("cancelled"));
            }
        } else {
            thread::sleep(PATIENCE_TO_END);
        }
        self.abort(signals::status());
    }

    /// Ends all processes. `MPI_Abort` of MPICH 4.0 may wait for ever on processes that call it
    /// too, after a signal: then the launcher ends the others, once this process has gone.
    fn abort(&self, status: u8) -> ! {
        thread::spawn(move || {
            thread::sleep(PATIENCE_TO_ABORT);
            // SAFETY: the process ends at once, and runs nothing that MPI could wait in.
            unsafe { libc::_exit(status.into()) }
        });
        self.comm().abort(status.into())
    }
}
