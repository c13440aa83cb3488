//! Options that several commands have: one meaning and one help text for each.

use std::num::NonZeroUsize;
use std::path::Path;

use anyhow::{Result, anyhow, bail};
use catamaran::io::{Output, Overwrite};
use catamaran::{Error, Par};

use crate::claims::{Purpose, claim, refuse_input};

/// The heading of these options in help texts.
pub const HEADING: &str = "Common options";

/// How many threads a command uses.
#[derive(Debug, Clone, Copy, clap::Args)]
pub struct Threads {
    /// Number of threads, at most 4 for each core. Does not change the result [default: one for
    /// each core of the affinity mask, at most CATAMARAN_NUM_THREADS and RAYON_NUM_THREADS].
    #[arg(long, value_name = "N", help_heading = HEADING)]
    threads: Option<NonZeroUsize>,
}

impl Threads {
    /// Returns the number that `--threads` asks for.
    pub fn asked(self) -> Option<usize> {
        self.threads.map(NonZeroUsize::get)
    }

    /// Returns the threads of the library that do the work.
    pub fn par(self) -> Par {
        self.asked().map_or_else(Par::all, Par::Threads)
    }
}

/// Whether a command may replace files.
#[derive(Debug, Clone, Copy, clap::Args)]
pub struct Force {
    /// Replace files that exist.
    #[arg(long, help_heading = HEADING)]
    force: bool,
}

impl Force {
    /// Returns what happens when a file appears while a command runs.
    pub fn overwrite(self) -> Overwrite {
        if self.force { Overwrite::Replace } else { Overwrite::Never }
    }

    /// Refuses a file that exists and may not be replaced.
    ///
    /// # Errors
    /// The file is an input, or exists and `--force` is not given; there is a directory in its
    /// place.
    pub fn check(self, path: &Path) -> Result<()> {
        refuse_input(path)?;
        if path.is_dir() {
            bail!("{}: is a directory", path.display());
        }
        if !self.force && path.symlink_metadata().is_ok() {
            bail!("{}: exists already (--force replaces it)", path.display());
        }
        Ok(())
    }

    /// Refuses a file that exists and may neither be replaced nor continued from (`--resume`).
    ///
    /// # Errors
    /// The file is an input, or exists and neither `--force` nor `--resume` is given.
    pub fn check_resumable(self, path: &Path, resume: bool) -> Result<()> {
        refuse_input(path)?;
        if !self.force && !resume && path.symlink_metadata().is_ok() {
            bail!(
                "{}: exists already (--force replaces it, --resume continues from it)",
                path.display()
            );
        }
        Ok(())
    }

    /// Starts a file as [`Force::create`] does; with `resume` it replaces the one continued from.
    ///
    /// # Errors
    /// Those of [`Force::check_resumable`] and [`Force::create`].
    pub fn create_resumable(self, path: &Path, resume: bool) -> Result<Output> {
        self.check_resumable(path, resume)?;
        Self { force: self.force || resume }.create(path)
    }

    /// Starts a file, once it is known that it may be written.
    ///
    /// # Errors
    /// Those of [`Force::check`]; the folder can't be written; another result has this name.
    pub fn create(self, path: &Path) -> Result<Output> {
        self.check(path)?;
        claim(path, Purpose::Result)?;
        Ok(Output::create(path, self.overwrite())?)
    }
}

/// Turns an error of the library that names an argument into one that names the option of the same
/// name.
pub fn as_option(error: Error) -> anyhow::Error {
    match error {
        Error::Argument { what, why } => anyhow!("--{}: {why}", what.replace('_', "-")),
        error => error.into(),
    }
}
