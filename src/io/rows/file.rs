//! Files that are read in pieces, in any order. They must not change meanwhile.

use std::fmt;
use std::fs::{self, Metadata};
use std::io;
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use crate::base::{Error, Result};
use crate::io::source::{error, error_at};

/// Bytes of a file that are converted at a time.
pub(super) const BUFFER: usize = 1 << 18;

/// The message for a file that was changed.
pub(in crate::io) const CHANGED: &str = "changed since it was opened";

/// Size and time of modification of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::io) struct Stamp {
    pub len: u64,
    /// `None` where the system does not tell.
    modified: Option<SystemTime>,
}

impl Stamp {
    /// Returns the size and time of modification in `metadata`.
    pub fn of(metadata: &Metadata) -> Self {
        Self { len: metadata.len(), modified: metadata.modified().ok() }
    }

    /// Returns an error for a file that has changed since.
    pub fn check(self, path: &Path, now: io::Result<Metadata>) -> Result<()> {
        let now = Self::of(&now.map_err(|e| error_at(path, None, e))?);
        match now {
            _ if now == self => Ok(()),
            _ if now.len < self.len => Err(shrank(path)),
            _ => Err(error(path, None, CHANGED)),
        }
    }
}

impl fmt::Display for Stamp {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} bytes", self.len)?;
        let Some(modified) = self.modified else { return Ok(()) };
        let (sign, since) = match modified.duration_since(UNIX_EPOCH) {
            Ok(since) => ("", since),
            Err(before) => ("-", before.duration()),
        };
        write!(f, ", modified {sign}{}.{:09}", since.as_secs(), since.subsec_nanos())
    }
}

pub(super) fn shrank(path: &Path) -> Error {
    error(path, None, "truncated: it shrank since it was opened")
}

/// Returns the size and time of a file that can be read from its middle.
pub(in crate::io) fn seekable(path: &Path) -> Result<Stamp> {
    let metadata = fs::metadata(path).map_err(|e| error_at(path, None, e))?;
    if metadata.is_dir() {
        return Err(error(path, None, "is a directory"));
    }
    if !metadata.is_file() {
        return Err(error(path, None, "not a plain file, so rows can't be read from its middle"));
    }
    Ok(Stamp::of(&metadata))
}

/// Checks that `count` rows from `first` on are among the `nrows` rows of a file.
pub(in crate::io) fn check_rows(first: usize, count: usize, nrows: usize) -> Result<()> {
    if first.checked_add(count).is_some_and(|end| end <= nrows) {
        return Ok(());
    }
    let why = format!("{count} from row {first} on, but the file has {nrows}");
    Err(Error::Argument { what: "rows", why })
}

/// Returns `path` without links and relative parts, where the system can tell.
pub(in crate::io) fn canonical(path: &Path) -> PathBuf {
    fs::canonicalize(path).unwrap_or_else(|_| path.into())
}
