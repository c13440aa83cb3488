//! Reads the variables that the launcher (mpirun, srun) sets for a process before MPI starts.

/// Variables of this process' rank: Open MPI, MPICH and its relatives, PMIx, Slurm. Slurm comes
/// last, because mpirun passes on the variables of its own job.
const RANKS: [&str; 4] = ["OMPI_COMM_WORLD_RANK", "PMI_RANK", "PMIX_RANK", "SLURM_PROCID"];
/// Variables of the number of processes.
const SIZES: [&str; 3] = ["OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "SLURM_STEP_NUM_TASKS"];

/// Returns whether this process has rank 0, or there is no launcher.
pub fn is_first() -> bool {
    number(&RANKS, environment).unwrap_or(0) == 0
}

/// Returns an error unless MPI, whose library identifies itself as `mpi`, counts as many processes
/// as the launcher.
///
/// # Errors
/// When the launcher started several processes and each of them is alone.
pub fn check(ranks: usize, mpi: &str) -> catamaran_bench::Result<()> {
    check_in(ranks, mpi, environment)
}

fn check_in(
    ranks: usize,
    mpi: &str,
    variable: impl Fn(&str) -> Option<String>,
) -> catamaran_bench::Result<()> {
    match number(&SIZES, variable) {
        Some(started) if ranks == 1 && started > 1 => Err(format!(
            "{started} processes were started, but each is alone: the launcher is not that of \
             {mpi}, for which this program was built (mpirun.openmpi, mpirun.mpich; srun \
             --mpi=list)"
        )
        .into()),
        _ => Ok(()),
    }
}

fn environment(name: &str) -> Option<String> {
    std::env::var(name).ok()
}

/// Returns the value of the first variable that is set to a number.
fn number(names: &[&str], variable: impl Fn(&str) -> Option<String>) -> Option<usize> {
    names.iter().find_map(|name| variable(name)?.parse().ok())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check_with(ranks: usize, variables: &[(&str, &str)]) -> bool {
        let value = |name: &str| {
            let found = variables.iter().find(|(key, _)| *key == name);
            found.map(|(_, value)| (*value).to_owned())
        };
        check_in(ranks, "MPI", value).is_ok()
    }

    #[test]
    fn a_launcher_of_another_mpi_is_refused() {
        assert!(!check_with(1, &[("PMI_SIZE", "4")]));
        assert!(!check_with(1, &[("SLURM_STEP_NUM_TASKS", "4")]));
        assert!(check_with(4, &[("OMPI_COMM_WORLD_SIZE", "4")]));
        assert!(check_with(1, &[]));
        // mpirun -n 1 on two nodes of Slurm: the two tasks of the step are its daemons.
        assert!(check_with(1, &[("SLURM_STEP_NUM_TASKS", "2"), ("OMPI_COMM_WORLD_SIZE", "1")]));
    }
}
