//! Progress bars, and lines of progress where there is no terminal for a bar.

use std::ops::ControlFlow;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::report;
pub use crate::signals::check;

/// Steps of a bar.
const STEPS: u64 = 1000;

/// Share of the work after which a line is due.
const LINE: f64 = 0.1;

/// Least time between two lines.
const LEAST: Duration = Duration::from_secs(1);

/// Time after which a line is due whatever was done.
const MOST: Duration = Duration::from_secs(60);

/// A progress bar on stderr, when that is a terminal; it goes away when dropped. The first of
/// several processes prints lines instead.
pub struct Bar {
    bar: ProgressBar,
    lines: Option<Lines>,
}

/// Lines of progress.
struct Lines {
    label: &'static str,
    begun: Instant,
    last: Mutex<Last>,
}

/// The last line, or the beginning of the work.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct Last {
    fraction: f64,
    /// Time since the beginning.
    time: Duration,
}

impl Last {
    /// Returns whether another line is due.
    fn is_due(&self, now: &Self) -> bool {
        let time = now.time.saturating_sub(self.time);
        time >= LEAST && now.fraction < 1.0 && (now.fraction - self.fraction) >= LINE
            || time >= MOST
    }
}

impl Lines {
    /// Prints a line if it is due.
    fn update(&self, fraction: f64) {
        // Another thread is just printing one.
        let Ok(mut last) = self.last.try_lock() else { return };
        let now = Last { fraction, time: self.begun.elapsed() };
        if last.is_due(&now) {
            *last = now;
            let (label, percent) = (self.label, 100.0 * fraction);
            let time = report::seconds(now.time);
            report::progress_line(format_args!("{label:<11} {percent:.0} % after {time}"));
        }
    }
}

impl Bar {
    /// Returns a bar with the label `label`.
    pub fn new(label: &'static str) -> Self {
        let style = ProgressStyle::with_template("{msg:>9} [{bar:40}] {percent:>3} %  {eta}")
            .unwrap_or_else(|_| ProgressStyle::default_bar())
            .progress_chars("=> ");
        let has_lines = report::has_lines_of_progress();
        let target = if report::is_quiet() || has_lines {
            ProgressDrawTarget::hidden()
        } else {
            ProgressDrawTarget::stderr()
        };
        let bar = ProgressBar::with_draw_target(Some(STEPS), target);
        let begun = Instant::now();
        let lines = has_lines.then(|| Lines { label, begun, last: Mutex::default() });
        Self { bar: bar.with_style(style).with_message(label), lines }
    }

    /// Shows `fraction` of the work as done, never less than before; asks to stop after a signal.
    pub fn update(&self, fraction: f64) -> ControlFlow<()> {
        self.show(fraction);
        if check().is_err() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    /// Shows `fraction` of the work as done, never less than before.
    pub fn show(&self, fraction: f64) {
        let position = (fraction * STEPS as f64) as u64;
        let before = self.bar.position();
        if position > before {
            self.bar.set_position(position);
            if before == 0 {
                // The part that a resumed run starts with took no time.
                self.bar.reset_eta();
            }
        }
        if let Some(lines) = &self.lines {
            lines.update(fraction);
        }
    }

    /// Updates the bar between two parts of the work.
    ///
    /// # Errors
    /// [`catamaran::Error::Cancelled`] after a signal.
    pub fn step(&self, fraction: f64) -> catamaran::Result<()> {
        self.show(fraction);
        check()
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_come_with_each_tenth_but_neither_too_often_nor_too_seldom() {
        let at = |fraction, seconds| Last { fraction, time: Duration::from_secs_f64(seconds) };
        let begin = Last::default();
        assert!(!begin.is_due(&at(0.5, 0.9)), "short work needs none");
        assert!(!begin.is_due(&at(0.09, 30.0)));
        assert!(begin.is_due(&at(0.1, 2.0)));
        assert!(begin.is_due(&at(0.001, 61.0)));
        assert!(!at(0.3, 10.0).is_due(&at(0.39, 11.5)));
        assert!(at(0.3, 10.0).is_due(&at(0.41, 11.5)));
        assert!(!at(0.3, 10.0).is_due(&at(0.41, 10.5)));
        assert!(!at(0.95, 10.0).is_due(&at(1.0, 12.0)), "the result is about to come");
    }
}
