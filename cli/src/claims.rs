//! The files that this process uses: none serves two purposes of which one would destroy the other.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use anyhow::{Result, bail};

/// What a file is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    Input,
    Result,
    /// Written from time to time, and removed at the end.
    Checkpoint,
}

static USED: Mutex<Vec<(PathBuf, Purpose)>> = Mutex::new(Vec::new());

/// Notes what a file is for.
///
/// # Errors
/// Another result is written there, or the file is both a checkpoint and something else.
pub fn claim(path: &Path, purpose: Purpose) -> Result<()> {
    let Some(place) = place(path) else { return Ok(()) };
    let mut used = USED.lock().unwrap_or_else(PoisonError::into_inner);
    for (_, other) in used.iter().filter(|(used, _)| *used == place) {
        let name = path.display();
        match (*other, purpose) {
            (Purpose::Result, Purpose::Result) => bail!("{name}: two results have this name"),
            (one, another) if one != another && [one, another].contains(&Purpose::Checkpoint) => {
                bail!("{name}: --checkpoint names a file that is also an input or a result")
            }
            // Inputs may be read twice, and replaced by a result.
            _ => {}
        }
    }
    used.push((place, purpose));
    Ok(())
}

/// Returns where a file is or will be; `None` for a device or a pipe, which several may use.
fn place(path: &Path) -> Option<PathBuf> {
    if path.metadata().is_ok_and(|found| !found.is_file()) {
        return None;
    }
    if let Ok(found) = fs::canonicalize(path) {
        return Some(found);
    }
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    let folder = fs::canonicalize(folder.unwrap_or(Path::new("."))).ok()?;
    Some(folder.join(path.file_name()?))
}
