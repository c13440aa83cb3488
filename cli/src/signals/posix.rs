//! The signals of POSIX.

use std::io;

#[cfg(any(feature = "mpi", feature = "opencl", test))]
use signal_hook::consts::SIGABRT;
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGUSR1};

/// The signals that the program ends after.
pub struct Signals(signal_hook::iterator::Signals);

impl Signals {
    /// Watches for signals from now on, and ignores SIGXFSZ.
    ///
    /// # Errors
    /// The operating system refuses the handlers.
    pub fn watch() -> io::Result<Self> {
        let mut wanted = vec![SIGINT, SIGTERM, SIGUSR1];
        if !is_ignored(SIGHUP)? {
            wanted.push(SIGHUP);
        }
        // SAFETY: no handler of ours runs.
        if unsafe { libc::signal(libc::SIGXFSZ, libc::SIG_IGN) } == libc::SIG_ERR {
            return Err(io::Error::last_os_error());
        }
        Ok(Self(signal_hook::iterator::Signals::new(wanted)?))
    }

    /// Waits for the next signal.
    pub fn wait(&mut self) -> Option<i32> {
        self.0.forever().next()
    }

    /// Returns a signal that has come meanwhile.
    pub fn poll(&mut self) -> Option<i32> {
        self.0.pending().next()
    }
}

fn is_ignored(signal: i32) -> io::Result<bool> {
    action(signal).map(|action| action.sa_sigaction == libc::SIG_IGN)
}

/// Returns what the process does after a signal.
fn action(signal: i32) -> io::Result<libc::sigaction> {
    let mut action = std::mem::MaybeUninit::<libc::sigaction>::uninit();
    // SAFETY: the call only queries; `action` is as large as the result, and is read only after it
    // was written.
    unsafe {
        if libc::sigaction(signal, std::ptr::null(), action.as_mut_ptr()) != 0 {
            return Err(io::Error::last_os_error());
        }
        Ok(action.assume_init())
    }
}

/// What the process does after the signals of this program, and after an abort.
#[cfg(any(feature = "mpi", feature = "opencl", test))]
pub struct Actions(Vec<(i32, libc::sigaction)>);

#[cfg(any(feature = "mpi", feature = "opencl", test))]
impl Actions {
    /// Returns the actions of now.
    pub fn now() -> Self {
        let all = [SIGHUP, SIGINT, SIGTERM, SIGUSR1, SIGABRT];
        Self(all.into_iter().filter_map(|signal| Some((signal, action(signal).ok()?))).collect())
    }

    /// Makes these the actions again.
    pub fn restore(&self) {
        for (signal, action) in &self.0 {
            // SAFETY: the action was one of this process, and its handler is still there. There is
            // nothing to do about an error, of which there is none for these signals.
            unsafe { libc::sigaction(*signal, action, std::ptr::null_mut()) };
        }
    }
}
