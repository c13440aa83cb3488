/// Returns what the MPI library calls itself, such as `Open MPI v4.1.4`; empty if it does not say.
/// MPI need not be started.
///
/// ```no_run
/// println!("built for {}", catamaran::ranks::mpi_version());
/// ```
pub fn mpi_version() -> String {
    let all = ::mpi::environment::library_version().unwrap_or_default();
    let first = all.split([',', '\n']).next().unwrap_or_default();
    first.replace('\t', " ").trim_end_matches(['\0', ' ']).to_owned()
}
