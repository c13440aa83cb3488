//! The processes that `mpirun` or `srun` started, each of which takes a part of the rows.

#[cfg(not(feature = "mpi"))]
mod alone;
mod fault;
#[cfg(feature = "mpi")]
mod notices;
#[cfg(feature = "mpi")]
mod several;

use std::ops::Range;
use std::thread;
use std::time::Duration;

use anyhow::Result;
#[cfg(not(feature = "mpi"))]
pub use catamaran::blas::BlasReal as Scalar;
use catamaran::ranks::Launch;
#[cfg(feature = "mpi")]
pub use catamaran::ranks::MpiReal as Scalar;

#[cfg(not(feature = "mpi"))]
pub use self::alone::Ranks;
pub use self::fault::Said;
#[cfg(feature = "mpi")]
pub use self::several::Ranks;
use crate::report::{note, status};

/// How long the others wait for the process that speaks of an error of all. They may have started
/// earlier.
const PATIENCE_TO_SPEAK: Duration = Duration::from_secs(1);

/// Refuses to run a command several times beside itself: only some share their work.
///
/// # Errors
/// A launcher started several processes; the error names it and the command.
pub fn refuse(command: &str) -> Result<()> {
    let Some(launch) = Launch::of_process() else { return Ok(()) };
    let what = format!(
        "`{command}` runs in one process (ata, lstsq, pca, svd and spectrum share their work)"
    );
    said_by_one(&launch, launch.check_alone(&what))
}

/// Returns an error that all processes of a launcher have, of which one speaks. The others fail
/// later: `mpirun` ends all when one fails, possibly before that one has spoken.
fn said_by_one(launch: &Launch, checked: catamaran::Result<()>) -> Result<()> {
    match checked {
        Err(_) if !launch.speaks() => {
            thread::sleep(PATIENCE_TO_SPEAK);
            Err(Said { status: 1 }.into())
        }
        checked => Ok(checked?),
    }
}

/// Ends a process that prints help or has a wrong command line, as all processes of a launcher do
/// then: the first one speaks.
pub fn leave(said: &clap::Error) -> ! {
    if Launch::of_process().is_some_and(|launch| launch.rank() > 0) {
        if said.use_stderr() {
            thread::sleep(PATIENCE_TO_SPEAK);
        }
        std::process::exit(said.exit_code());
    }
    said.exit()
}

impl Ranks {
    /// Returns whether this process is the one that writes and reports.
    pub fn is_first(&self) -> bool {
        self.rank() == 0
    }

    /// Reports how many processes there are, and notes when those of a machine have more threads
    /// than cores; `threads` is the number of this process.
    pub fn report(&self, threads: usize) -> Result<()> {
        if self.size() == 1 {
            return Ok(());
        }
        if let Some(Crowd { ranks, threads, cores }) = self.crowd(threads) {
            note(format_args!(
                "{ranks} processes have {threads} threads on {cores} cores: --threads sets the \
                 threads of each; mpirun --bind-to none and srun --cpus-per-task give them more \
                 cores"
            ));
        }
        status!("ranks", count = self.size(); "{}, each with its part of the rows", self.size())
    }

    /// Returns the rows of `m` that this process takes, of which `together` rows are read at once:
    /// those of a packed chunk, which two processes would unpack otherwise.
    pub fn share(&self, m: usize, together: usize) -> Range<usize> {
        share(m, together, self.rank(), self.size())
    }

    /// Returns the rank and the number of processes, for names and labels; `None` for a single
    /// process.
    pub fn label(&self) -> Option<String> {
        (self.size() > 1).then(|| format!("{}-of-{}", self.rank(), self.size()))
    }
}

/// Returns part `rank` of `size` parts of `0..m`, which begin at multiples of `together` if there
/// are enough of these for all parts.
fn share(m: usize, together: usize, rank: usize, size: usize) -> Range<usize> {
    let step = if m / together.max(1) >= size { together.max(1) } else { 1 };
    let steps = m.div_ceil(step);
    let bound = |rank: usize| ((steps / size * rank + (steps % size).min(rank)) * step).min(m);
    bound(rank)..bound(rank + 1)
}

/// Processes with the same cores, on which they have more threads than there are cores.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(not(feature = "mpi"), allow(dead_code, reason = "a process has no others"))]
struct Crowd {
    ranks: usize,
    /// Threads of all of them.
    threads: usize,
    cores: usize,
}

impl Crowd {
    /// Returns the group that has the most threads for each core, if these are more than one.
    #[cfg_attr(not(feature = "mpi"), allow(dead_code, reason = "a process has no others"))]
    fn worst(groups: impl Iterator<Item = Self>) -> Option<Self> {
        let crowds = groups.filter(|group| group.cores > 0 && group.threads > group.cores);
        // Quotients are compared by their cross products.
        crowds.max_by(|a, b| (a.threads * b.cores).cmp(&(b.threads * a.cores)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_follow_each_other_and_are_even() {
        for (m, size) in [(0, 3), (7, 3), (9, 3), (2, 5)] {
            let all: Vec<_> = (0..size).map(|rank| share(m, 1, rank, size)).collect();
            assert_eq!((all[0].start, all[size - 1].end), (0, m));
            for pair in all.windows(2) {
                assert_eq!(pair[0].end, pair[1].start);
                assert!(pair[0].len() - pair[1].len() <= 1);
            }
        }
    }

    #[test]
    fn shares_begin_with_chunks_unless_there_are_fewer_chunks_than_processes() {
        let all = |m, together| [0, 1, 2].map(|rank| share(m, together, rank, 3));
        assert_eq!(all(1000, 100), [0..400, 400..700, 700..1000]);
        assert_eq!(all(350, 100), [0..200, 200..300, 300..350]);
        assert_eq!(all(299, 100), [0..100, 100..200, 200..299]);
        assert_eq!(all(9, 100), [0..3, 3..6, 6..9]);
    }

    #[test]
    fn the_most_crowded_cores_are_noted_and_enough_cores_are_not() {
        let group = |ranks, threads, cores| Crowd { ranks, threads, cores };
        let worst = |groups: &[Crowd]| Crowd::worst(groups.iter().copied());
        assert_eq!(worst(&[group(2, 8, 8), group(1, 4, 8), group(1, 9, 0)]), None);
        let all = [group(2, 16, 8), group(4, 32, 8), group(1, 3, 2)];
        assert_eq!(worst(&all), Some(group(4, 32, 8)));
    }
}
