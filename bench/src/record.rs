//! What a command leaves behind: numbers, the host they are from, and pictures.

use std::fmt::Display;
use std::fs;
use std::path::PathBuf;

use crate::{Result, host};

/// Writes the files, each a name and its text, into `bench/record/<host kind>/`; that folder.
///
/// # Errors
/// When a file can't be written.
pub fn write(files: &[(&str, String)]) -> Result<PathBuf> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("record").join(host::kind());
    fs::create_dir_all(&folder)?;
    for (name, text) in files {
        fs::write(folder.join(name), text)?;
    }
    Ok(folder)
}

/// A file of comma-separated values.
pub fn csv(header: &str, lines: impl IntoIterator<Item = impl Display>) -> String {
    lines.into_iter().fold(format!("{header}\n"), |text, line| format!("{text}{line}\n"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_follow_the_header() {
        assert_eq!(csv("a,b", ["1,2", "3,4"]), "a,b\n1,2\n3,4\n");
    }
}
