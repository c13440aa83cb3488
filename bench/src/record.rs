//! What a command leaves behind: numbers, the host they are from, and pictures.

use std::fmt::Display;
use std::fs;
use std::path::PathBuf;

use crate::{Result, host};

/// Writes the files, each a name and its text, into `bench/record/<host kind>-<date>/`; that folder.
///
/// # Errors
/// When a file can't be written.
pub fn write(files: &[(&str, String)]) -> Result<PathBuf> {
    let folder = folder();
    fs::create_dir_all(&folder)?;
    for (name, text) in files {
        fs::write(folder.join(name), text)?;
    }
    Ok(folder)
}

/// Puts a line into the table `NAME.csv`, in the place of the line that has the same first `keys` fields if there is
/// one, and `host` into host.txt, in that folder, which comes back.
///
/// # Errors
/// When a file can't be written, or the table has other columns.
pub fn put(name: &str, header: &str, keys: usize, line: &str, host: String) -> Result<PathBuf> {
    let name = format!("{name}.csv");
    let old = fs::read_to_string(folder().join(&name)).unwrap_or_default();
    let table =
        with_line(&old, header, keys, line).ok_or_else(|| format!("{name}: other columns"))?;
    write(&[(&name, table), ("host.txt", host)])
}

/// The table `old`, empty at first, with one more line, or another one with the same first fields; `None` if it has
/// another header.
fn with_line(old: &str, header: &str, keys: usize, line: &str) -> Option<String> {
    let (first, lines) = old.split_once('\n').unwrap_or((header, ""));
    let key = |line: &str| line.split(',').take(keys).map(str::to_owned).collect::<Vec<_>>();
    let mut lines: Vec<_> = lines.lines().collect();
    match lines.iter_mut().find(|old| key(old) == key(line)) {
        Some(old) => *old = line,
        None => lines.push(line),
    }
    (first == header).then(|| csv(header, lines))
}

fn folder() -> PathBuf {
    let name = format!("{}-{}", host::kind(), host::date());
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("record").join(name)
}

/// A file of comma-separated values.
pub fn csv(header: &str, lines: impl IntoIterator<Item = impl Display>) -> String {
    lines.into_iter().fold(format!("{header}\n"), |text, line| format!("{text}{line}\n"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_the_same_kind_are_replaced() {
        let mut table = String::new();
        for line in ["a,1,2", "b,1,3", "a,1,4", "a,2,5"] {
            table = with_line(&table, "x,y,z", 2, line).unwrap();
        }
        assert_eq!(table, "x,y,z\na,1,4\nb,1,3\na,2,5\n");
        assert_eq!(with_line(&table, "x,y", 2, "a,1"), None);
    }

    #[test]
    fn lines_follow_the_header() {
        assert_eq!(csv("a,b", ["1,2", "3,4"]), "a,b\n1,2\n3,4\n");
    }
}
