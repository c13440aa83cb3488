//! What launchers, such as `mpirun` and `srun`, tell a process before MPI starts.

use crate::base::{Error, Result};

/// The variables in which a launcher passes the rank of a process and the number of processes.
struct Launcher {
    name: &'static str,
    rank: &'static str,
    /// `None` where the launcher passes no number.
    size: Option<&'static str>,
}

/// The innermost launcher comes first: `mpirun` passes on the variables of the job of Slurm that it
/// runs in. Slurm comes before PMIx, which passes no number of processes.
const LAUNCHERS: [Launcher; 6] = [
    Launcher {
        name: "Open MPI's mpirun",
        rank: "OMPI_COMM_WORLD_RANK",
        size: Some("OMPI_COMM_WORLD_SIZE"),
    },
    Launcher { name: "a launcher with PMI", rank: "PMI_RANK", size: Some("PMI_SIZE") },
    Launcher { name: "PALS", rank: "PALS_RANKID", size: None },
    Launcher { name: "Flux", rank: "FLUX_TASK_RANK", size: Some("FLUX_JOB_SIZE") },
    SLURM,
    Launcher { name: "a launcher with PMIx", rank: PMIX_RANK, size: None },
];

/// The script of a batch job of Slurm has a rank too, but no number of processes.
const SLURM: Launcher =
    Launcher { name: "Slurm's srun", rank: "SLURM_PROCID", size: Some("SLURM_STEP_NUM_TASKS") };
const PMIX_RANK: &str = "PMIX_RANK";

/// What the launcher of this process says about it before MPI starts.
///
/// Open MPI, MPICH and its relatives (PMI), Slurm, Flux, PALS and PMIx are known, by the variables
/// that they set.
///
/// ```
/// use catamaran::ranks::Launch;
///
/// // This program was not started by `mpirun`.
/// assert!(Launch::of_process().is_none_or(|launch| launch.least_processes() == 1));
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Launch {
    launcher: &'static str,
    rank: usize,
    size: Option<usize>,
    /// The variables of ranks that are set: without them, there is no launcher.
    variables: Vec<&'static str>,
}

impl Launch {
    /// Returns what the variables of this process say; `None` without those of a launcher.
    pub fn of_process() -> Option<Self> {
        Self::of(|name| std::env::var(name).ok())
    }

    fn of(variable: impl Fn(&str) -> Option<String>) -> Option<Self> {
        let number = |name: &str| variable(name)?.trim().parse::<usize>().ok();
        LAUNCHERS.iter().find_map(|&Launcher { name, rank: rank_name, size }| {
            let (rank, size) = (number(rank_name)?, size.and_then(number));
            if rank_name == SLURM.rank {
                // Below a daemon that Slurm started, PMIx counts the processes of the daemons.
                let same = number(PMIX_RANK).is_none_or(|of_pmix| of_pmix == rank);
                if size.is_none() || !same {
                    return None;
                }
            }
            let names = LAUNCHERS.iter().map(|launcher| launcher.rank);
            let variables = names.filter(|name| variable(name).is_some()).collect();
            Some(Self { launcher: name, rank, size, variables })
        })
    }

    /// Returns the rank of this process, from 0.
    pub fn rank(&self) -> usize {
        self.rank
    }

    /// Returns the name of the launcher, as part of a sentence.
    pub fn launcher(&self) -> &'static str {
        self.launcher
    }

    /// Returns whether there may be other processes: the launcher passes their number, more than
    /// one, or no number.
    pub fn may_be_several(&self) -> bool {
        self.size.is_none() || self.least_processes() > 1
    }

    /// Returns how many processes were started: their number, or where the launcher does not pass
    /// it, the least that there can be.
    pub fn least_processes(&self) -> usize {
        self.size.unwrap_or(1).max(self.rank + 1)
    }

    /// Returns whether this process is the one that reports an error of all processes that the
    /// launcher started: the first one that knows of others.
    pub fn speaks(&self) -> bool {
        self.rank == 0 || self.size.is_none() && self.rank == 1
    }

    /// Checks that MPI, whose library calls itself `mpi`, has several ranks where the launcher
    /// started several processes. Each process is alone when the launcher belongs to another MPI
    /// library than the program.
    ///
    /// ```
    /// use catamaran::ranks::Launch;
    ///
    /// if let Some(launch) = Launch::of_process() {
    ///     launch.check(launch.least_processes(), "Open MPI v4.1.4")?;
    /// }
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Argument`] that names the launcher and the library.
    pub fn check(&self, ranks: usize, mpi: &str) -> Result<()> {
        if ranks > 1 || self.least_processes() == 1 {
            return Ok(());
        }
        let why = format!(
            "{}, but each is alone in {mpi}, for which this program was built: start it by the \
             launcher of that library (mpirun.openmpi, mpirun.mpich, or srun with --mpi=pmix or \
             --mpi=pmi2); {}",
            self.text(),
            self.advice()
        );
        Err(Error::Argument { what: "launcher", why })
    }

    /// Checks that there is one process: for a program without MPI, and for work that ranks do not
    /// share.
    ///
    /// # Errors
    /// [`Error::Argument`] that names the launcher and says `what` stands against its processes.
    pub fn check_alone(&self, what: &str) -> Result<()> {
        if self.least_processes() == 1 {
            return Ok(());
        }
        let why = format!("{}, but {what}; {}", self.text(), self.advice());
        Err(Error::Argument { what: "launcher", why })
    }

    /// Says who started how many processes.
    fn text(&self) -> String {
        let least = if self.size.is_none() { "at least " } else { "" };
        format!("{} started {least}{} processes", self.launcher, self.least_processes())
    }

    /// Says how processes can work for themselves.
    fn advice(&self) -> String {
        let names = self.variables.join(" and ");
        format!("where each process has work of its own, unset {names}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(variables: &[(&str, &str)]) -> Option<Launch> {
        Launch::of(|name| {
            let found = variables.iter().find(|(key, _)| *key == name);
            found.map(|(_, value)| (*value).to_owned())
        })
    }

    #[test]
    fn every_launcher_is_known_by_its_variables() {
        for (variables, launcher, rank, size) in [
            (&[("OMPI_COMM_WORLD_RANK", "1"), ("OMPI_COMM_WORLD_SIZE", "4")][..], "Open MPI", 1, 4),
            (&[("PMI_RANK", "2"), ("PMI_SIZE", "3")], "PMI", 2, 3),
            (&[("PALS_RANKID", "5")], "PALS", 5, 6),
            (&[("FLUX_TASK_RANK", "0"), ("FLUX_JOB_SIZE", "2")], "Flux", 0, 2),
            (&[("SLURM_PROCID", "3"), ("SLURM_STEP_NUM_TASKS", "4")], "Slurm", 3, 4),
            (&[("PMIX_RANK", "7")], "PMIx", 7, 8),
            // srun --mpi=pmix.
            (
                &[("PMIX_RANK", "3"), ("SLURM_PROCID", "3"), ("SLURM_STEP_NUM_TASKS", "4")],
                "Slurm",
                3,
                4,
            ),
            // A daemon on each of two nodes, with processes of its own.
            (
                &[("PMIX_RANK", "3"), ("SLURM_PROCID", "1"), ("SLURM_STEP_NUM_TASKS", "2")],
                "PMIx",
                3,
                4,
            ),
        ] {
            let found = of(variables).unwrap_or_else(|| panic!("{variables:?}"));
            assert!(found.launcher().contains(launcher), "{variables:?}: {found:?}");
            assert_eq!((found.rank(), found.least_processes()), (rank, size), "{variables:?}");
            assert!(found.may_be_several(), "{variables:?}");
        }
    }

    #[test]
    fn processes_that_are_alone_are_not_taken_for_several() {
        assert_eq!(of(&[]), None);
        // The script of a batch job.
        assert_eq!(of(&[("SLURM_PROCID", "0"), ("SLURM_NTASKS", "4")]), None);
        assert_eq!(of(&[("PMI_RANK", "none")]), None);
        // mpirun -n 1 on two nodes of Slurm: the two tasks of the step are its daemons.
        let inner = of(&[
            ("SLURM_PROCID", "0"),
            ("SLURM_STEP_NUM_TASKS", "2"),
            ("OMPI_COMM_WORLD_RANK", "0"),
            ("OMPI_COMM_WORLD_SIZE", "1"),
        ])
        .unwrap();
        assert!(!inner.may_be_several());
        inner.check(1, "MPI").unwrap();
        inner.check_alone("it works alone").unwrap();
        // No number is passed: MPI says how many there are.
        let first = of(&[("PMIX_RANK", "0")]).unwrap();
        assert!(first.may_be_several());
        first.check(1, "MPI").unwrap();
        // Only the second process knows that there are two.
        let rank = |variable, rank: &str| of(&[(variable, rank)]).unwrap();
        assert_eq!(["0", "1", "2"].map(|r| rank("PMIX_RANK", r).speaks()), [true, true, false]);
        let of_two = of(&[("PMI_RANK", "1"), ("PMI_SIZE", "2")]).unwrap();
        assert!(!of_two.speaks());
    }

    #[test]
    fn a_launcher_of_another_mpi_is_refused_by_its_name_and_that_of_the_library() {
        let launch = of(&[("SLURM_PROCID", "1"), ("SLURM_STEP_NUM_TASKS", "4")]).unwrap();
        launch.check(4, "Open MPI v4.1.4").unwrap();
        let said = launch.check(1, "Open MPI v4.1.4").unwrap_err().to_string();
        assert!(said.contains("Slurm's srun started 4 processes"), "{said}");
        assert!(said.contains("alone in Open MPI v4.1.4"), "{said}");
        assert!(said.ends_with("unset SLURM_PROCID"), "{said}");
        let both = [("PMIX_RANK", "1"), ("SLURM_PROCID", "1"), ("SLURM_STEP_NUM_TASKS", "4")];
        let said = of(&both).unwrap().check(1, "MPICH").unwrap_err().to_string();
        assert!(said.ends_with("unset SLURM_PROCID and PMIX_RANK"), "{said}");
        let said = of(&[("PMIX_RANK", "1")]).unwrap().check(1, "MPICH").unwrap_err().to_string();
        assert!(said.contains("PMIx started at least 2 processes"), "{said}");
        let said = launch.check_alone("`basis` runs in one").unwrap_err().to_string();
        assert!(said.contains("4 processes, but `basis` runs in one"), "{said}");
    }
}
