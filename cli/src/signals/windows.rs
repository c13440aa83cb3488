//! The signals of Windows: Ctrl-C, and SIGTERM, which only programs raise.

use std::io;
use std::sync::mpsc::{Receiver, channel};

use signal_hook::consts::{SIGINT, SIGTERM};

/// The signals that the program ends after.
pub struct Signals(Receiver<i32>);

impl Signals {
    /// Watches for signals from now on.
    ///
    /// # Errors
    /// The operating system refuses the handlers.
    pub fn watch() -> io::Result<Self> {
        let (sender, receiver) = channel();
        for signal in [SIGINT, SIGTERM] {
            let sender = sender.clone();
            // Nobody is left to tell when the receiver is gone.
            let handler = move || sender.send(signal).unwrap_or_default();
            // SAFETY: Windows runs the handler for Ctrl-C on a thread of its own, and that for
            // SIGTERM where the program raises it, which this one never does.
            unsafe { signal_hook::low_level::register(signal, handler) }?;
        }
        Ok(Self(receiver))
    }

    /// Waits for the next signal.
    pub fn wait(&mut self) -> Option<i32> {
        self.0.recv().ok()
    }

    /// Returns a signal that has come meanwhile.
    pub fn poll(&mut self) -> Option<i32> {
        self.0.try_recv().ok()
    }
}

/// Handlers, which no library replaces here.
#[cfg(any(feature = "mpi", feature = "opencl", test))]
pub struct Actions;

#[cfg(any(feature = "mpi", feature = "opencl", test))]
impl Actions {
    /// Returns nothing.
    pub fn now() -> Self {
        Self
    }

    /// Does nothing.
    pub fn restore(&self) {}
}
