//! Saves accumulators, from which a run that was killed is resumed.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};
use catamaran::blas::BlasReal;
use catamaran::io::{self as files, Output, Overwrite};
use catamaran::rows::Accumulator;

use crate::claims::{Purpose, claim};
use crate::common::Force;
use crate::parse;
use crate::ranks::Ranks;
use crate::report::{complain, status};

/// The options of checkpoints.
#[derive(clap::Args)]
pub struct CheckpointArgs {
    /// Save the sums to this file from time to time, for --resume; the file is removed at the end.
    #[arg(long, value_name = "FILE")]
    checkpoint: Option<PathBuf>,
    /// Minutes between two checkpoints; 0 writes one after each block.
    #[arg(
        long,
        value_name = "MINUTES",
        default_value = "10",
        value_parser = parse::minutes,
        requires = "checkpoint"
    )]
    checkpoint_every: Duration,
    /// Continue from the checkpoint, if there is one. The result has the same bytes as that of an
    /// uninterrupted run.
    #[arg(long, requires = "checkpoint")]
    resume: bool,
}

impl CheckpointArgs {
    /// Returns whether checkpoints are written.
    pub fn is_given(&self) -> bool {
        self.checkpoint.is_some()
    }

    /// Returns the file of the checkpoints of this rank.
    fn path(&self, ranks: &Ranks) -> Option<PathBuf> {
        let path = self.checkpoint.as_ref()?;
        Some(match ranks.label() {
            Some(label) => {
                let mut name = path.clone().into_os_string();
                name.push(format!(".{label}"));
                name.into()
            }
            None => path.clone(),
        })
    }

    /// Refuses a file that exists, unless --resume or --force is given, one that has another
    /// purpose, and one that can't be written.
    pub fn check(&self, ranks: &Ranks, force: Force) -> Result<()> {
        let Some(path) = self.path(ranks) else { return Ok(()) };
        claim(&path, Purpose::Checkpoint)?;
        force.check_resumable(&path, self.resume)?;
        // The first checkpoint, which may be hours later, would be too late for this error.
        drop(Output::create(&path, Overwrite::Replace)?);
        Ok(())
    }

    /// Returns the sums of all columns in the checkpoint, with --resume and if there is a
    /// checkpoint.
    pub fn resume<T: BlasReal>(
        &self,
        ranks: &Ranks,
        ncols: usize,
        labels: &[(String, String)],
    ) -> Result<Option<Accumulator<T>>> {
        match self.path(ranks) {
            Some(path) if self.resume => resume(&path, ncols, labels),
            _ => Ok(None),
        }
    }

    /// Starts the time to the first checkpoint.
    pub fn begin(&self, ranks: &Ranks) -> Option<Checkpoint> {
        let (path, every) = (self.path(ranks)?, self.checkpoint_every);
        Some(Checkpoint { path, every, last: Instant::now() })
    }

    /// Removes the file, after all ranks have done their work.
    pub fn remove(&self, ranks: &Ranks) -> Result<()> {
        ranks.wait();
        match self.path(ranks) {
            Some(path) if path.symlink_metadata().is_ok() => std::fs::remove_file(&path)
                .with_context(|| format!("{}: can't be removed", path.display())),
            _ => Ok(()),
        }
    }
}

/// A file that is replaced from time to time.
pub struct Checkpoint {
    path: PathBuf,
    every: Duration,
    last: Instant,
}

impl Checkpoint {
    /// Writes the file when it is due. A failure is reported and leaves the last file: the sums are
    /// still right.
    pub fn after_block<T: BlasReal>(&mut self, sum: &Accumulator<T>) {
        if self.last.elapsed() < self.every || sum.rows() == sum.expected_rows() {
            return;
        }
        let written = Output::create(&self.path, Overwrite::Replace)
            .and_then(|output| files::write_accumulator(output, sum));
        if let Err(e) = written {
            complain(format_args!(
                "{e}; the run continues, with the last checkpoint if there is one"
            ));
        }
        self.last = Instant::now();
    }
}

/// Reads the accumulator in the file, and refuses one of other sums; `None` when there is no file.
fn resume<T: BlasReal>(
    path: &Path,
    ncols: usize,
    labels: &[(String, String)],
) -> Result<Option<Accumulator<T>>> {
    if path.symlink_metadata().is_err() {
        let name = path.display().to_string();
        status!("resumed", path = name, row = 0; "no {name}: the run starts from the first row")?;
        return Ok(None);
    }
    let sum = files::read_accumulator::<T>(path)?;
    sum.check_labels(labels).with_context(|| path.display().to_string())?;
    if sum.strip() != (0..ncols) {
        bail!("{}: has the sums of a strip of C, not of all of C", path.display());
    }
    let (rows, all) = (sum.rows(), sum.expected_rows());
    let name = path.display().to_string();
    status!("resumed", path = name, row = rows, rows = all; "{name}: row {rows} of {all}")?;
    Ok(Some(sum))
}
