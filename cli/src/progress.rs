//! Progress bars.

use std::ops::ControlFlow;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::report;
pub use crate::signals::check;

/// Steps of a bar.
const STEPS: u64 = 1000;

/// A progress bar on stderr, when that is a terminal. It goes away when dropped.
pub struct Bar(ProgressBar);

impl Bar {
    /// Returns a bar with the label `label`.
    pub fn new(label: &'static str) -> Self {
        let style = ProgressStyle::with_template("{msg:>9} [{bar:40}] {percent:>3} %  {eta}")
            .unwrap_or_else(|_| ProgressStyle::default_bar())
            .progress_chars("=> ");
        let target = if report::is_quiet() {
            ProgressDrawTarget::hidden()
        } else {
            ProgressDrawTarget::stderr()
        };
        let bar = ProgressBar::with_draw_target(Some(STEPS), target);
        Self(bar.with_style(style).with_message(label))
    }

    /// Shows `fraction` of the work as done, never less than before; asks to stop after a signal.
    pub fn update(&self, fraction: f64) -> ControlFlow<()> {
        let position = (fraction * STEPS as f64) as u64;
        let before = self.0.position();
        if position > before {
            self.0.set_position(position);
            if before == 0 {
                // The part that a resumed run starts with took no time.
                self.0.reset_eta();
            }
        }
        if check().is_err() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    /// Updates the bar between two parts of the work.
    ///
    /// # Errors
    /// [`catamaran::Error::Cancelled`] after a signal.
    pub fn step(&self, fraction: f64) -> catamaran::Result<()> {
        let _ = self.update(fraction);
        check()
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
