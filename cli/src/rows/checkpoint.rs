//! Saves accumulators, from which a run that was killed is resumed.

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};
use catamaran::blas::BlasReal;
use catamaran::io::{self as files, Output, Overwrite};
use catamaran::rows::Accumulator;

use super::list::RowList;
use super::parts::{CheckpointFile, ROWS, Saved, differing_options};
use crate::claims::{Purpose, claim};
use crate::common::Force;
use crate::parse;
use crate::ranks::Ranks;
use crate::report::{complain, status};

/// The options of checkpoints.
#[derive(clap::Args)]
pub struct CheckpointArgs {
    /// Save the sums to this file from time to time, and after SIGTERM, SIGINT (Ctrl-C) and
    /// SIGUSR1, for --resume; the file is removed at the end. Under mpirun, each process writes a
    /// file, whose name ends with its number.
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
    /// uninterrupted run. Exact sums are continued by any number of processes, others by as many as
    /// before.
    #[arg(long, requires = "checkpoint")]
    resume: bool,
}

impl CheckpointArgs {
    /// Returns whether checkpoints are written.
    pub fn is_given(&self) -> bool {
        self.checkpoint.is_some()
    }

    /// Returns the file of the checkpoints of this process.
    fn path(&self, ranks: &Ranks) -> Option<PathBuf> {
        Some(CheckpointFile::name(self.checkpoint.as_ref()?, ranks.label().as_deref()))
    }

    /// Refuses a file that exists, of this process or of any of another run, unless --resume or
    /// --force is given, one that has another purpose, and one that can't be written.
    pub fn check(&self, ranks: &Ranks, force: Force) -> Result<()> {
        let (Some(base), Some(path)) = (&self.checkpoint, self.path(ranks)) else { return Ok(()) };
        claim(&path, Purpose::Checkpoint)?;
        if ranks.is_first() {
            for part in CheckpointFile::find(base)? {
                force.check_resumable(&part.path, self.resume)?;
            }
        }
        force.check_resumable(&path, self.resume)?;
        // The first checkpoint, which may be hours later, would be too late for this error.
        drop(Output::create(&path, Overwrite::Replace)?);
        Ok(())
    }

    /// Returns what this process begins with: sums of all n columns of some of the m rows, with
    /// --resume and if there is a checkpoint, and its rows, of which `together` are read at once.
    /// All processes call this function.
    pub fn resume<T: BlasReal>(
        &self,
        ranks: &Ranks,
        (m, n): (usize, usize),
        together: usize,
        labels: &[(String, String)],
        exact: bool,
    ) -> Result<Begun<T>> {
        let Some(base) = self.checkpoint.as_deref().filter(|_| self.resume) else {
            return Ok(Begun { sum: None, rows: ranks.share(m, together).into(), done: 0 });
        };
        let begun = match exact {
            true => of_any_run(base, ranks, (m, n), together, labels)?,
            false => of_this_process(base, ranks, (m, n), together, labels)?,
        };
        let (name, done) = (base.display().to_string(), begun.done);
        match (done, ranks.size()) {
            (0, _) => status!(
                "resumed",
                path = name,
                row = 0;
                "no {name}: the run starts from the first row"
            )?,
            (_, 1) => {
                status!("resumed", path = name, row = done, rows = m; "{name}: row {done} of {m}")?;
            }
            _ => status!(
                "resumed",
                path = name,
                row = done,
                rows = m;
                "{name}: {done} of {m} rows, of all processes"
            )?,
        }
        Ok(begun)
    }

    /// Starts the time to the first checkpoint.
    pub fn begin(&self, ranks: &Ranks) -> Option<Checkpoint> {
        let (path, every) = (self.path(ranks)?, self.checkpoint_every);
        Some(Checkpoint { path, every, last: Instant::now() })
    }

    /// Waits for all processes to do their work, and removes the files, those of other numbers of
    /// processes too. Called by each process that has succeeded, with a checkpoint or without.
    pub fn remove(&self, ranks: &Ranks) -> Result<()> {
        ranks.gather_up()?;
        let Some(base) = &self.checkpoint else { return Ok(()) };
        let mut files: Vec<_> = self.path(ranks).into_iter().collect();
        if ranks.is_first() {
            files.extend(CheckpointFile::find(base)?.into_iter().map(|part| part.path));
        }
        files.iter().try_for_each(|path| remove(path))
    }
}

/// Removes a file, which another process may have removed.
fn remove(path: &Path) -> Result<()> {
    match fs::remove_file(path) {
        Err(e) if e.kind() != ErrorKind::NotFound => {
            Err(e).with_context(|| format!("{}: can't be removed", path.display()))
        }
        _ => Ok(()),
    }
}

/// What a process begins with.
pub struct Begun<T> {
    /// The sums of the first rows of `rows`, if any are summed.
    pub sum: Option<Accumulator<T>>,
    /// The rows of this process: those that are summed, and those that are not.
    pub rows: RowList,
    /// The number of rows that are summed, of all processes.
    pub done: usize,
}

/// Continues what this process has saved: sums that are rounded depend on the rows of each process.
fn of_this_process<T: BlasReal>(
    base: &Path,
    ranks: &Ranks,
    (m, n): (usize, usize),
    together: usize,
    labels: &[(String, String)],
) -> Result<Begun<T>> {
    let rows = RowList::from(ranks.share(m, together));
    let path = CheckpointFile::name(base, ranks.label().as_deref());
    let saved = || -> Result<Option<Accumulator<T>>> {
        if path.symlink_metadata().is_ok() {
            return read(&path, n, labels, Some(&rows)).map(Some);
        }
        let parts = CheckpointFile::find(base)?;
        match parts.first() {
            Some(other) if parts.iter().all(|part| part.ranks != ranks.size()) => bail!(
                "{}: a checkpoint of {} processes, which only as many can continue, and these are \
                 {}: rounding depends on their number, except in exact sums (--reproducible)",
                other.path.display(),
                other.ranks,
                ranks.size()
            ),
            _ => Ok(None),
        }
    };
    let sum = ranks.meet(saved())?;
    let done = ranks.total(sum.as_ref().map_or(0, |sum| sum.rows() as usize));
    Ok(Begun { sum, rows, done })
}

/// Continues what any number of processes have saved, as exact sums can: each of the new ones takes
/// some of the files, and a part of the rows that no file has.
fn of_any_run<T: BlasReal>(
    base: &Path,
    ranks: &Ranks,
    (m, n): (usize, usize),
    together: usize,
    labels: &[(String, String)],
) -> Result<Begun<T>> {
    let found = match ranks.is_first() {
        true => Saved::find(base, labels).map(|saved| saved.to_text()),
        false => Ok(String::new()),
    };
    let text = ranks.text_of_first(ranks.meet(found)?);
    let saved = Saved::from_text(&text).with_context(|| format!("{}: its path", base.display()));
    let saved = ranks.meet(saved)?;
    let begun = ranks.meet(of_files(&saved, base, ranks, (m, n), together, labels))?;
    // What is refused stays on the disk, so nothing is removed earlier.
    let removed = match ranks.is_first() {
        true => remove_rest(base, ranks.size(), &saved),
        false => Ok(()),
    };
    ranks.meet(removed)?;
    Ok(begun)
}

/// Returns what this process begins with, of the files that all processes continue.
fn of_files<T: BlasReal>(
    saved: &Saved,
    base: &Path,
    ranks: &Ranks,
    (m, n): (usize, usize),
    together: usize,
    labels: &[(String, String)],
) -> Result<Begun<T>> {
    let all = saved.rows();
    let Some(rest) = all.rest(m) else {
        let name = base.display();
        bail!("{name}: its files have the sums of some rows twice, or of rows that A lacks")
    };
    let own = rest.part(ranks.share(rest.len(), together));
    let (mut sum, mut before) = (None::<Accumulator<T>>, RowList::default());
    let of_own = |rank: usize| rank % ranks.size() == ranks.rank();
    for part in saved.parts.iter().filter(|part| of_own(part.rank)) {
        let next = read(&part.path, n, labels, None)?;
        before = before.join(&part.rows);
        match &mut sum {
            None => sum = Some(next),
            Some(sum) => {
                sum.merge(next).with_context(|| part.path.display().to_string())?;
            }
        }
    }
    let rows = before.join(&own);
    if let Some(sum) = &mut sum {
        sum.set_expected_rows(rows.len() as u64);
    }
    Ok(Begun { sum, rows, done: all.len() })
}

/// Removes the files that have the names of this run and are not those that it continues: later
/// they would be taken for files of this run.
fn remove_rest(base: &Path, ranks: usize, continued: &Saved) -> Result<()> {
    if continued.ranks == ranks {
        return Ok(());
    }
    let parts = CheckpointFile::find(base)?;
    parts.iter().filter(|part| part.ranks == ranks).try_for_each(|part| remove(&part.path))
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
        if let Err(e) = self.write(sum) {
            complain(format_args!(
                "{e}; the run continues, with the last checkpoint if there is one"
            ));
        }
        self.last = Instant::now();
    }

    /// Writes the file after a signal, and says so, or why it is not written.
    pub fn save<T: BlasReal>(&self, sum: &Accumulator<T>) {
        if let Err(e) = self.write(sum) {
            return complain(format_args!("{e}; the last checkpoint stays, if there is one"));
        }
        let (path, rows, all) = (self.path.display(), sum.rows(), sum.expected_rows());
        // A closed stdout does not matter now.
        let _ = status!(
            "saved",
            path = path.to_string(),
            row = rows,
            rows = all;
            "{path}: row {rows} of {all}; --resume continues"
        );
    }

    /// Adds the file to the error of sums that were made in other blocks.
    pub fn of_blocks(&self, error: catamaran::Error) -> catamaran::Error {
        match error {
            catamaran::Error::Argument { what: "accumulator", why }
                if why.contains(" of a block") =>
            {
                catamaran::Error::file(&self.path, format!("--block-rows: {why}"))
            }
            error => error,
        }
    }

    fn write<T: BlasReal>(&self, sum: &Accumulator<T>) -> catamaran::Result<()> {
        let output = Output::create(&self.path, Overwrite::Replace)?;
        files::write_accumulator(output, sum)
    }
}

/// Returns the labels of sums of some rows.
pub fn labels_with_rows(
    mut labels: Vec<(String, String)>,
    rows: &RowList,
) -> Vec<(String, String)> {
    labels.push((ROWS.to_owned(), rows.to_string()));
    labels
}

/// Reads the sums in a file, and refuses others than these; `rows` are its rows, where only these
/// can be continued.
fn read<T: BlasReal>(
    path: &Path,
    n: usize,
    labels: &[(String, String)],
    rows: Option<&RowList>,
) -> Result<Accumulator<T>> {
    let name = || path.display().to_string();
    let sum = files::read_accumulator::<T>(path)?;
    let own = || sum.labels().iter().find(|(name, _)| name == ROWS).map(|(_, rows)| rows.clone());
    let rows = rows.map(ToString::to_string).or_else(own).unwrap_or_default();
    if let Some(what) = differing_options(sum.labels(), labels) {
        bail!("{}: made with other options: {what}", name());
    }
    let mut wanted = labels.to_vec();
    wanted.push((ROWS.to_owned(), rows));
    sum.check_labels(&wanted).with_context(name)?;
    if sum.strip() != (0..n) {
        bail!("{}: has the sums of a strip of C, not of all of C", path.display());
    }
    Ok(sum)
}
