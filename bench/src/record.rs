//! Writes the results of a command: numbers and the host into a record, pictures beside it.

use std::ffi::OsStr;
use std::fmt::Display;
use std::fs::{self, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::{Result, host};

/// Bytes of a table of a record at most.
const TABLE_BYTES: usize = 100_000;

/// Writes the files, each a name and its text, into `bench/record/<host kind>-<date>/`; returns
/// that folder. Pictures and large tables go into `target/record` instead, as the command can make
/// them again.
///
/// # Errors
/// When a file can't be written.
pub fn write(files: &[(&str, String)]) -> Result<PathBuf> {
    let folder = folder();
    let aside = root().join("target/record");
    for (name, text) in files {
        let kept = is_kept(name, text);
        let place = if kept { &folder } else { &aside };
        fs::create_dir_all(place)?;
        fs::write(place.join(name), text)?;
        if !kept {
            println!("not in the record: {}", place.join(name).display());
        }
    }
    Ok(folder)
}

/// Returns whether a record holds a file.
fn is_kept(name: &str, text: &str) -> bool {
    match Path::new(name).extension().and_then(OsStr::to_str) {
        Some("svg") => false,
        Some("csv") => text.len() <= TABLE_BYTES,
        _ => true,
    }
}

/// Puts a line into the table `NAME.csv`, which replaces a line with the same first `keys` fields,
/// the `picture` of the table into `NAME.svg`, and `host` into host.txt; returns the folder of the
/// record.
///
/// # Errors
/// When a file can't be written, or the table has other columns.
pub fn put(
    name: &str,
    header: &str,
    keys: usize,
    line: &str,
    host: String,
    picture: impl Fn(&str) -> String,
) -> Result<PathBuf> {
    let path = table(name);
    let old = fs::read_to_string(&path).unwrap_or_default();
    let table = with_line(&old, header, keys, line)
        .ok_or_else(|| format!("{}: has another header", path.display()))?;
    let picture = picture(&table);
    let names = [format!("{name}.csv"), format!("{name}.svg")];
    write(&[(&names[0], table), (&names[1], picture), ("host.txt", host)])
}

/// Returns where [`put`] keeps the table `NAME.csv`.
pub fn table(name: &str) -> PathBuf {
    folder().join(format!("{name}.csv"))
}

/// Returns an error unless lines under `header` can be appended to the table `path`: the table is
/// missing or empty, or begins with this header.
///
/// # Errors
/// When the file has another header, or can't be read.
pub fn check_header(path: &Path, header: &str) -> Result<()> {
    let place = |error: io::Error| format!("{}: {error}", path.display());
    match fs::read_to_string(path) {
        Ok(text) if text.is_empty() || text.lines().next() == Some(header) => Ok(()),
        Ok(_) => Err(format!("{}: has another header; nothing is written", path.display()).into()),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(()),
        Err(error) => Err(place(error).into()),
    }
}

/// Returns an error unless lines under `header` can be appended to the table `path` later: as
/// [`check_header`], and the file, or one in its folder, can be written. Writes nothing.
///
/// # Errors
/// As [`check_header`], or when the file can't be written.
pub fn check_writable(path: &Path, header: &str) -> Result<()> {
    check_header(path, header)?;
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    let opened = match path.exists() {
        true => OpenOptions::new().append(true).open(path),
        false => tempfile::tempfile_in(folder.unwrap_or(Path::new("."))),
    };
    let place = |error: io::Error| format!("{}: can't be written: {error}", path.display());
    Ok(opened.map(drop).map_err(place)?)
}

/// Appends `line` to the table `path`, after `header` when it is new or empty, by a single write,
/// so that lines of jobs that end at the same time do not mix.
///
/// # Errors
/// As [`check_header`], or when the file can't be written.
pub fn append(path: &Path, header: &str, line: &str) -> Result<()> {
    check_header(path, header)?;
    let place = |error: io::Error| format!("{}: {error}", path.display());
    let mut file = OpenOptions::new().create(true).append(true).open(path).map_err(place)?;
    let is_new = file.metadata().map_err(place)?.len() == 0;
    let text = if is_new { csv(header, [line]) } else { format!("{line}\n") };
    Ok(file.write_all(text.as_bytes()).map_err(place)?)
}

/// Returns the table `old`, which may be empty, with one more line, which replaces a line with the
/// same first fields; `None` if the table has another header.
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
    root().join("bench/record").join(format!("{}-{}", host::kind(), host::date()))
}

/// Returns the root of the repository, or the current folder for a program that was carried to a
/// machine without the sources.
fn root() -> &'static Path {
    let sources = Path::new(env!("CARGO_MANIFEST_DIR"));
    sources.parent().filter(|_| sources.is_dir()).unwrap_or(Path::new(""))
}

/// Returns a file of comma-separated values.
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
    fn lines_are_appended_and_tables_with_other_columns_stay_as_they_are() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("runs.csv");
        append(&path, "x,y", "1,2").unwrap();
        append(&path, "x,y", "1,2").unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "x,y\n1,2\n1,2\n");
        let error = append(&path, "x,y,z", "1,2,3").unwrap_err().to_string();
        assert!(error.contains("runs.csv: has another header"), "{error}");
        assert_eq!(fs::read_to_string(&path).unwrap(), "x,y\n1,2\n1,2\n");
        fs::write(&path, "").unwrap();
        append(&path, "x,y,z", "1,2,3").unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "x,y,z\n1,2,3\n");
        assert!(append(&folder.path().join("none/runs.csv"), "x", "1").is_err());
    }

    #[test]
    fn a_table_that_can_not_be_written_is_found_before_there_is_a_line() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("runs.csv");
        check_writable(&path, "x,y").unwrap();
        assert!(!path.exists());
        append(&path, "x,y", "1,2").unwrap();
        check_writable(&path, "x,y").unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "x,y\n1,2\n");
        assert!(check_writable(&path, "x").is_err());
        let error = check_writable(&folder.path().join("none/runs.csv"), "x").unwrap_err();
        assert!(error.to_string().contains("none/runs.csv: can't be written: "), "{error}");
    }

    #[test]
    fn records_hold_no_pictures_and_no_large_tables() {
        let large = "1,2\n".repeat(TABLE_BYTES / 4 + 1);
        assert!(is_kept("ata.csv", "1,2\n"));
        assert!(is_kept("decimate.md", &large));
        assert!(is_kept("host.txt", ""));
        assert!(!is_kept("decimate.csv", &large));
        assert!(!is_kept("ata.svg", "<svg/>"));
    }

    #[test]
    fn lines_follow_the_header() {
        assert_eq!(csv("a,b", ["1,2", "3,4"]), "a,b\n1,2\n3,4\n");
    }
}
