//! Accumulators on the disk, for a run that was killed to go on.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};
use catamaran::ata::Accumulator;
use catamaran::blas::BlasReal;
use catamaran::io::{self as files, Output, Overwrite};

use crate::report::{complain, report};

/// A file that is replaced from time to time.
pub struct Checkpoint {
    path: PathBuf,
    every: Duration,
    last: Instant,
}

impl Checkpoint {
    /// Begins to count the time.
    pub fn new(path: &Path, every: Duration) -> Self {
        Self { path: path.into(), every, last: Instant::now() }
    }

    /// Writes the file when it is time. A failure is told, and leaves the last file: the sums are still right.
    pub fn after_block<T: BlasReal>(&mut self, sum: &Accumulator<T>) {
        if self.last.elapsed() < self.every || sum.rows() == sum.expected_rows() {
            return;
        }
        let written = Output::create(&self.path, Overwrite::Replace)
            .and_then(|output| files::write_accumulator(output, sum));
        if let Err(e) = written {
            complain(format_args!("{e}; going on with the last checkpoint, if there is one"));
        }
        self.last = Instant::now();
    }
}

/// The accumulator in the file, when it is one of the same sums; `None` when there is no file.
pub fn resume<T: BlasReal>(
    path: &Path,
    ncols: usize,
    labels: &[(String, String)],
) -> Result<Option<Accumulator<T>>> {
    if path.symlink_metadata().is_err() {
        report(format_args!("resumed   no {}: from the first row", path.display()))?;
        return Ok(None);
    }
    let sum = files::read_accumulator::<T>(path)?;
    sum.check_labels(labels).with_context(|| path.display().to_string())?;
    if sum.strip() != (0..ncols) {
        bail!("{}: not of all of C", path.display());
    }
    let (rows, all) = (sum.rows(), sum.expected_rows());
    report(format_args!("resumed   {}: row {rows} of {all}", path.display()))?;
    Ok(Some(sum))
}
