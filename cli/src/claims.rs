//! The files that this process uses: none serves two purposes of which one would destroy the other.

use std::any::TypeId;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use anyhow::{Result, bail};
use clap::{Arg, ArgMatches, Command};

use crate::input::TextFile;
use crate::parse::levels;
use crate::tables::MatrixFile;

/// The arguments whose files are written, in any command. The files of all others are inputs.
const OUTPUTS: [&str; 21] = [
    "accumulator",
    "cells",
    "checkpoint",
    "correlations",
    "coverage",
    "cut",
    "distances",
    "fit_metric",
    "heights",
    "output",
    "paint",
    "path_output",
    "picture",
    "points_output",
    "prolongation",
    "region",
    "render",
    "rest",
    "signatures",
    "state",
    "write_material",
];

/// What a file is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    Input,
    Result,
    /// Written from time to time, and removed at the end.
    Checkpoint,
}

/// A file, and what it is for.
struct Used {
    place: Place,
    purpose: Purpose,
}

static USED: Mutex<Vec<Used>> = Mutex::new(Vec::new());

/// Notes the inputs that the command line names.
pub fn claim_inputs(command: &Command, matches: &ArgMatches) {
    for (command, matches) in levels(command, matches) {
        for arg in command.get_arguments().filter(|arg| is_file(arg) && !is_output(arg)) {
            let values = matches.try_get_raw(arg.get_id().as_str()).ok().flatten();
            values.into_iter().flatten().for_each(|value| claim_input(Path::new(value)));
        }
    }
}

fn is_file(arg: &Arg) -> bool {
    let kind = arg.get_value_parser().type_id();
    kind == TypeId::of::<PathBuf>()
        || kind == TypeId::of::<TextFile>()
        || kind == TypeId::of::<MatrixFile>()
}

fn is_output(arg: &Arg) -> bool {
    OUTPUTS.contains(&arg.get_id().as_str())
}

fn claim_input(path: &Path) {
    if let Some(place) = Place::of(file_of(path)) {
        let mut used = USED.lock().unwrap_or_else(PoisonError::into_inner);
        used.push(Used { place, purpose: Purpose::Input });
    }
}

/// Returns the file of `FILE:/dataset` or `FILE:dataset`, or of another name.
pub fn file_of(name: &Path) -> &Path {
    let Some(text) = name.to_str().filter(|_| !name.exists()) else { return name };
    let mut files = text.match_indices(':').map(|(at, _)| Path::new(&text[..at]));
    files.find(|file| file.is_file()).unwrap_or(name)
}

/// Refuses an output in the place of an input.
///
/// # Errors
/// The path leads to an input.
pub fn refuse_input(path: &Path) -> Result<()> {
    if is_used(path, Purpose::Input) {
        bail!("{}: is an input of this command, and can't also be an output", path.display());
    }
    Ok(())
}

/// Refuses an output in the place of a result that is claimed already.
///
/// # Errors
/// Another result is written there.
pub fn refuse_result(path: &Path) -> Result<()> {
    if is_used(path, Purpose::Result) {
        bail!("{}: two results have this name", path.display());
    }
    Ok(())
}

/// Returns whether a file of this purpose is in the place of the path.
fn is_used(path: &Path, purpose: Purpose) -> bool {
    Place::of(path).is_some_and(|place| {
        let used = USED.lock().unwrap_or_else(PoisonError::into_inner);
        used.iter().any(|other| other.purpose == purpose && other.place.is_same(&place))
    })
}

/// Notes what an output is for.
///
/// # Errors
/// The file is an input, another result is written there, or the file is both a checkpoint and
/// something else.
pub fn claim(path: &Path, purpose: Purpose) -> Result<()> {
    if purpose == Purpose::Result {
        refuse_input(path)?;
        refuse_result(path)?;
    }
    let Some(place) = Place::of(path) else { return Ok(()) };
    let mut used = USED.lock().unwrap_or_else(PoisonError::into_inner);
    if used.iter().any(|other| other.purpose != purpose && other.place.is_same(&place)) {
        let name = path.display();
        bail!("{name}: --checkpoint names a file that is also an input or a result");
    }
    used.push(Used { place, purpose });
    Ok(())
}

/// Where a file is or will be.
struct Place {
    path: PathBuf,
    /// The device and the number of a file that exists, which its hard links share.
    #[cfg(unix)]
    number: Option<(u64, u64)>,
}

impl Place {
    /// Returns where a path leads; `None` for a device or a pipe, which several may use.
    fn of(path: &Path) -> Option<Self> {
        let found = path.metadata().ok();
        if found.as_ref().is_some_and(|found| !found.is_file()) {
            return None;
        }
        Some(Self {
            path: place(path)?,
            #[cfg(unix)]
            number: found.map(|found| {
                use std::os::unix::fs::MetadataExt as _;
                (found.dev(), found.ino())
            }),
        })
    }

    #[cfg(unix)]
    fn is_same(&self, other: &Self) -> bool {
        self.path == other.path || self.number.is_some() && self.number == other.number
    }

    #[cfg(not(unix))]
    fn is_same(&self, other: &Self) -> bool {
        self.path == other.path
    }
}

/// Returns the path without links, of a file that may not exist yet.
fn place(path: &Path) -> Option<PathBuf> {
    if let Ok(found) = fs::canonicalize(path) {
        return Some(found);
    }
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    let folder = fs::canonicalize(folder.unwrap_or(Path::new("."))).ok()?;
    Some(folder.join(path.file_name()?))
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use clap::CommandFactory as _;

    use super::*;
    use crate::Cli;

    /// How the help text of an argument begins whose file or folder is written.
    const WRITTEN: [&str; 6] =
        ["Output file", "Output folder", "Write ", "Save ", "Draw ", "Folder for "];

    /// Adds the names of the file arguments that are outputs, and the faults of all.
    fn check(command: &Command, outputs: &mut BTreeSet<String>, faults: &mut Vec<String>) {
        for arg in command.get_arguments().filter(|arg| is_file(arg)) {
            let help = arg.get_help().map(ToString::to_string).unwrap_or_default();
            if is_output(arg) != WRITTEN.iter().any(|begin| help.starts_with(begin)) {
                faults.push(format!("{} {arg}: {help}", command.get_name()));
            }
            if is_output(arg) {
                outputs.insert(arg.get_id().to_string());
            }
        }
        command.get_subcommands().for_each(|below| check(below, outputs, faults));
    }

    #[test]
    fn arguments_are_outputs_where_their_help_says_that_they_write() {
        let (mut outputs, mut faults) = (BTreeSet::new(), Vec::new());
        check(&Cli::command(), &mut outputs, &mut faults);
        assert!(faults.is_empty(), "{}", faults.join("\n"));
        assert!(outputs.iter().eq(OUTPUTS.iter()), "{outputs:?}");
    }

    #[test]
    fn a_dataset_stands_for_its_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        fs::write(path("a.nc"), "").unwrap();
        fs::write(path("b:c"), "").unwrap();
        for (name, file) in
            [("a.nc:/g/x:y", "a.nc"), ("a.nc:x", "a.nc"), ("b:c", "b:c"), ("none:x", "none:x")]
        {
            assert_eq!(file_of(&path(name)), path(file), "{name}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn a_file_is_the_same_by_every_path_and_link() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        fs::write(path("file"), "").unwrap();
        fs::write(path("other"), "").unwrap();
        fs::create_dir(path("in")).unwrap();
        fs::hard_link(path("file"), path("hard")).unwrap();
        std::os::unix::fs::symlink(path("file"), path("soft")).unwrap();
        let same =
            |a: &str, b: &str| Place::of(&path(a)).unwrap().is_same(&Place::of(&path(b)).unwrap());
        for name in ["file", "hard", "soft", "in/../file"] {
            assert!(same("file", name), "{name}");
        }
        for name in ["other", "new", "in/file"] {
            assert!(!same("file", name), "{name}");
        }
        assert!(same("new", "in/../new") && !same("new", "newer"));
        assert!(Place::of(&path("in")).is_none());
    }
}
