//! Signals that end the program: SIGINT (Ctrl-C), SIGTERM, SIGHUP, and SIGUSR1, which batch systems
//! send some time before they kill a job (`sbatch --signal`).
//!
//! The first one asks the command to stop ([`check`], which every progress bar calls). A command
//! that is still there after [`GRACE`] is ended from outside: outputs that are not committed are
//! removed, and the process exits with the status of the signal. A second signal does that at once.
//!
//! SIGXFSZ is ignored: a file that grows beyond the limit of `ulimit -f` is an error of the write,
//! as on a full disk.

#[cfg(unix)]
#[path = "signals/posix.rs"]
mod system;
#[cfg(windows)]
#[path = "signals/windows.rs"]
mod system;

use std::io;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, AtomicI32, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError, TryLockError};
use std::thread;
use std::time::{Duration, Instant};

use catamaran::{Error, io::discard_unfinished};
use signal_hook::consts::SIGTERM;
use system::Signals;

/// The time that a command has to stop by itself: with what the exit takes, less than a second.
const GRACE: Duration = Duration::from_millis(600);

/// The time between two checks for a second signal.
const POLL: Duration = Duration::from_millis(10);

/// The first signal that was received; 0 before.
static RECEIVED: AtomicI32 = AtomicI32::new(0);

/// Set before the process is ended from outside.
static ENDING: AtomicBool = AtomicBool::new(false);

/// Whether a second signal ends the process with the status of the first one.
static KEEPS_STATUS: AtomicBool = AtomicBool::new(false);

/// Locked while a command writes the state that a later run resumes from.
static SAVING: Mutex<()> = Mutex::new(());

/// Watches for signals from now on.
///
/// SIGHUP stays ignored where the parent process ignores it, as under `nohup`.
///
/// # Errors
/// The operating system refuses the handlers or the thread.
pub fn watch() -> io::Result<()> {
    let signals = Signals::watch()?;
    thread::Builder::new().name("signals".into()).spawn(move || serve(signals))?;
    Ok(())
}

/// Runs a function that may load libraries, after which the signals are those of this program
/// again: LLVM, which drivers of OpenCL contain, takes SIGUSR1 and keeps it. hwloc loads such
/// drivers, as MPI starts.
#[cfg(any(feature = "mpi", feature = "opencl", test))]
pub fn kept<X>(load: impl FnOnce() -> X) -> X {
    let actions = system::Actions::now();
    let loaded = load();
    actions.restore();
    loaded
}

/// Returns an error after a signal; every command calls this function regularly.
///
/// # Errors
/// [`Error::Cancelled`] after a signal.
pub fn check() -> catamaran::Result<()> {
    if RECEIVED.load(Ordering::Relaxed) == 0 { Ok(()) } else { Err(Error::Cancelled) }
}

/// Returns the status of a cancelled command, as a shell reports it: 128 plus the number of the
/// signal.
pub fn status() -> u8 {
    match RECEIVED.load(Ordering::Relaxed) {
        // Another process of `mpirun` has received it.
        0 => status_of(SIGTERM),
        signal => status_of(signal),
    }
}

/// Returns [`status`] as an exit code.
pub fn exit_code() -> ExitCode {
    ExitCode::from(status())
}

/// Makes the first signal decide about the status from now on: other ones follow from the end of
/// the other processes of a job.
#[cfg(feature = "mpi")]
pub fn keep_status() {
    KEEPS_STATUS.store(true, Ordering::Relaxed);
}

/// Delays the end after the first signal while the guard lives: the command finishes its step and
/// writes the state that a later run resumes from.
pub fn finish_first() -> MutexGuard<'static, ()> {
    SAVING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Returns unless the process is being ended from outside. Then an error is the consequence, such
/// as that of an output after all were discarded, and must not be reported.
pub fn wait_for_end() {
    while ENDING.load(Ordering::Acquire) {
        thread::sleep(POLL);
    }
}

fn serve(mut signals: Signals) {
    let Some(first) = signals.wait() else { return };
    RECEIVED.store(first, Ordering::Relaxed);
    let received = Instant::now();
    let is_saving = || matches!(SAVING.try_lock(), Err(TryLockError::WouldBlock));
    let after = |second: i32| if KEEPS_STATUS.load(Ordering::Relaxed) { first } else { second };
    while received.elapsed() < GRACE || is_saving() {
        if let Some(second) = signals.poll() {
            end(after(second));
        }
        thread::sleep(POLL);
    }
    // On a busy machine, much time may have passed since the last look.
    end(signals.poll().map_or(first, after))
}

/// Ends the process without destructors and exit handlers: other threads are at work.
fn end(signal: i32) -> ! {
    ENDING.store(true, Ordering::Release);
    discard_unfinished();
    signal_hook::low_level::exit(i32::from(status_of(signal)))
}

fn status_of(signal: i32) -> u8 {
    128 + signal as u8
}

#[cfg(all(test, unix))]
mod tests {
    use signal_hook::consts::SIGUSR1;

    use super::*;

    /// Sets what the process does after SIGUSR1, and returns what it did before.
    fn exchange(action: libc::sighandler_t) -> libc::sighandler_t {
        // SAFETY: no handler runs: the signal is ignored, or does what it does by default.
        unsafe { libc::signal(SIGUSR1, action) }
    }

    #[test]
    fn a_library_that_takes_a_signal_as_it_is_loaded_does_not_keep_it() {
        let of_others = exchange(libc::SIG_IGN);
        kept(|| exchange(libc::SIG_DFL));
        assert_eq!(exchange(of_others), libc::SIG_IGN);
    }
}
