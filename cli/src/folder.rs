//! Folders of results.

use std::collections::HashSet;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};

use crate::output;
use crate::report::note;

/// A folder that is there, and can be written, before the work begins. Folders that were made for
/// it go away again unless something is written into them.
pub struct Folder {
    /// The folders that were made, the innermost first.
    made: Vec<PathBuf>,
}

impl Folder {
    /// Makes the folder unless it exists. `name` is a file that will be in it.
    ///
    /// # Errors
    /// A part of the path is not a folder; the folder can't be made, or the file can't be written.
    pub fn create(path: &Path, name: &str) -> Result<Self> {
        // Without a slash at the end, after which a file does not seem to exist.
        let path = path.components().as_path();
        let parts = || path.ancestors().filter(|part| !part.as_os_str().is_empty());
        if let Some(part) = parts().find(|part| part.exists()).filter(|part| !part.is_dir()) {
            bail!("{}: is not a folder", part.display());
        }
        let made = parts().take_while(|part| !part.exists()).map(Path::to_owned).collect();
        let folder = Self { made };
        fs::create_dir_all(path).with_context(|| path.display().to_string())?;
        output::probe(&path.join(name))?;
        Ok(folder)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        for folder in &self.made {
            // Only an empty folder can be removed.
            if fs::remove_dir(folder).is_err() {
                break;
            }
        }
    }
}

/// Notes files of earlier runs that stay beside the numbered ones of this run, and would be in a
/// film of all files: those called `prefix`, a number and an end that `is_end` accepts, without
/// those in `written`. `what` says what they are.
pub fn note_older(
    folder: &Path,
    what: &str,
    prefix: &str,
    is_end: impl Fn(&str) -> bool,
    written: &[String],
) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    let number = |name: &str| -> Option<u64> {
        let rest = name.strip_prefix(prefix)?;
        let end = rest.trim_start_matches(|c: char| c.is_ascii_digit());
        is_end(end).then(|| rest[..rest.len() - end.len()].parse().ok())?
    };
    let written: HashSet<&str> = written.iter().map(String::as_str).collect();
    let mut older: Vec<(u64, String)> = entries
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
        .filter(|name| !written.contains(name.as_str()))
        .filter_map(|name| Some((number(&name)?, name)))
        .collect();
    older.sort_unstable();
    let names = match older.as_slice() {
        [] => return,
        [(_, only)] => only.clone(),
        [(_, first), .., (_, last)] => format!("{first} to {last}"),
    };
    let (folder, count) = (folder.display(), older.len());
    note(format_args!("{folder}: {what} that this run does not write stay: {count}, {names}"));
}
