//! The files of a checkpoint: one of a single process, or one of each of several.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use catamaran::io::{FileFormat, ReadOptions, accumulator_labels};

use super::list::RowList;

/// The label of the rows that the sums in a file are of: those that are summed, and then those that
/// are not yet.
pub const ROWS: &str = "rows";

/// The label of the names of the columns, one in a line.
pub const COLUMNS: &str = "columns";

/// The label of the numbers that the columns have in a file without names, as a [`RowList`].
pub const NUMBERS: &str = "column numbers";

/// The label of what merged sums are made of: a fingerprint of each part, between commas.
pub const PARTS: &str = "parts";

/// How the labels of options begin.
const OPTION: &str = "option ";

/// The label of the weights of the rows, and its value for rows without weights.
pub const WEIGHTS: &str = "weights";
pub const WITHOUT_WEIGHTS: &str = "none";

/// Returns the options that say how A is read, as labels, each with what the command line has.
pub fn option_labels(options: &ReadOptions<'_>) -> Vec<(String, String)> {
    let mut given = options.table.given();
    if !options.columns.is_all() {
        let columns = options.columns.to_string();
        let list = columns.strip_prefix("columns ").unwrap_or(&columns);
        given.insert(0, ("columns", list.to_owned()));
    }
    let format = FileFormat::NAMES.into_iter().find(|(_, format)| Some(*format) == options.format);
    given.extend(format.map(|(name, _)| ("format", name.to_owned())));
    given.into_iter().map(|(name, value)| (format!("{OPTION}{name}"), flag(name, &value))).collect()
}

/// Returns an option as it is on the command line.
fn flag(name: &str, value: &str) -> String {
    match name {
        "header" | "index" => {
            let no = if value == "true" { "" } else { "no-" };
            format!("--{no}{name}")
        }
        _ => format!("--{} {value}", name.replace('_', "-")),
    }
}

/// Returns how the options among labels differ from those of this command, if they do.
pub fn differing_options(
    saved: &[(String, String)],
    wanted: &[(String, String)],
) -> Option<String> {
    let value = |labels: &[(String, String)], name: &str| {
        labels.iter().find(|label| label.0 == name).map(|label| label.1.clone())
    };
    let is_other = |(name, _): &&(String, String)| value(wanted, name).is_none();
    let all = wanted.iter().chain(saved.iter().filter(is_other));
    let options = all.filter(|(name, _)| name.starts_with(OPTION));
    let differing =
        options.filter_map(|(name, _)| match (value(saved, name), value(wanted, name)) {
            (Some(was), Some(is)) if was == is => None,
            (Some(was), Some(is)) => Some(format!("{was} was given, and {is} is now")),
            (Some(was), None) => Some(format!("{was} was given, and is not now")),
            (None, Some(is)) => Some(format!("{is} was not given, and is now")),
            (None, None) => None,
        });
    let differing: Vec<String> = differing.collect();
    (!differing.is_empty()).then(|| differing.join("; "))
}

/// A file of a checkpoint.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CheckpointFile {
    /// The path of the file.
    pub path: PathBuf,
    /// The process that wrote it.
    pub rank: usize,
    /// The number of processes of its run.
    pub ranks: usize,
}

impl CheckpointFile {
    /// Returns the file of a process: `label` is `RANK-of-RANKS`, or `None` for a single process.
    pub fn name(base: &Path, label: Option<&str>) -> PathBuf {
        let mut name = base.to_owned().into_os_string();
        if let Some(label) = label {
            name.push(format!(".{label}"));
        }
        name.into()
    }

    /// Finds all files of the checkpoint `base`, in the order of their processes.
    pub fn find(base: &Path) -> Result<Vec<Self>> {
        let folder = base.parent().filter(|folder| !folder.as_os_str().is_empty());
        let folder = folder.unwrap_or(Path::new("."));
        let name = base.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let mut found = Vec::new();
        // Without a folder there is no file, which the first checkpoint reports.
        let Ok(entries) = fs::read_dir(folder) else { return Ok(found) };
        for entry in entries {
            let entry = entry.with_context(|| folder.display().to_string())?;
            let other = entry.file_name().to_string_lossy().into_owned();
            let Some(end) = other.strip_prefix(&name) else { continue };
            let Some((rank, ranks)) = process_of(end) else { continue };
            found.push(Self { path: base.with_file_name(entry.file_name()), rank, ranks });
        }
        found.sort_by_key(|part| (part.ranks, part.rank));
        Ok(found)
    }
}

/// Returns the process and the number of processes that the end of a name tells: (0, 1) for no end,
/// (R, P) for `.R-of-P`.
fn process_of(end: &str) -> Option<(usize, usize)> {
    if end.is_empty() {
        return Some((0, 1));
    }
    let (rank, ranks) = end.strip_prefix('.')?.split_once("-of-")?;
    let (rank, ranks) = (rank.parse::<usize>().ok()?, ranks.parse::<usize>().ok()?);
    (rank < ranks && end == format!(".{rank}-of-{ranks}")).then_some((rank, ranks))
}

/// A file of a checkpoint, and the rows that it has the sums of.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SavedFile {
    /// The path of the file.
    pub path: PathBuf,
    /// The process that wrote it.
    pub rank: usize,
    /// The rows that are summed.
    pub rows: RowList,
}

/// Files of one run that together have the sums of some rows, and these rows.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Saved {
    /// The files.
    pub parts: Vec<SavedFile>,
    /// The number of processes of the run; 0 where there are no files.
    pub ranks: usize,
}

impl Saved {
    /// Returns the files of the run that has summed the most rows, preferably with these labels.
    ///
    /// # Errors
    /// A file is not that of a checkpoint.
    pub fn find(base: &Path, labels: &[(String, String)]) -> Result<Self> {
        let mut runs: BTreeMap<usize, (bool, Self)> = BTreeMap::new();
        for CheckpointFile { path, rank, ranks } in CheckpointFile::find(base)? {
            let (rows, found) = accumulator_labels(&path)?;
            let name = path.display();
            let list = found.iter().find(|(name, _)| name == ROWS);
            let Some(list) = list.and_then(|(_, list)| list.parse::<RowList>().ok()) else {
                bail!("{name}: no checkpoint of this version: it does not say which rows it has")
            };
            let rows = usize::try_from(rows).ok().filter(|&rows| rows <= list.len());
            let Some(rows) = rows else { bail!("{name}: damaged: it has more rows than it says") };
            let others = found.iter().filter(|(name, _)| name != ROWS);
            let run = runs.entry(ranks).or_insert((true, Self::default()));
            run.0 &= others.eq(labels);
            run.1.ranks = ranks;
            run.1.parts.push(SavedFile { path, rank, rows: list.part(0..rows) });
        }
        let best = runs.into_values().max_by_key(|(same, run)| (*same, run.rows().len()));
        Ok(best.map(|(_, run)| run).unwrap_or_default())
    }

    /// Returns all rows that the files have.
    pub fn rows(&self) -> RowList {
        self.parts.iter().fold(RowList::default(), |list, part| list.join(&part.rows))
    }

    /// Writes the files and their rows as text, for other processes.
    pub fn to_text(&self) -> String {
        let line = |SavedFile { path, rank, rows }: &SavedFile| {
            format!("{rank}\t{rows}\t{}\n", path.display())
        };
        format!("{}\n", self.ranks) + &self.parts.iter().map(line).collect::<String>()
    }

    /// Undoes [`Saved::to_text`]; `None` for another text.
    pub fn from_text(text: &str) -> Option<Self> {
        let mut lines = text.split_terminator('\n');
        let ranks = lines.next()?.parse::<usize>().ok()?;
        let part = |line: &str| {
            let (rank, line) = line.split_once('\t')?;
            let (rows, path) = line.split_once('\t')?;
            let (rank, rows) = (rank.parse().ok()?, rows.parse().ok()?);
            Some(SavedFile { path: path.into(), rank, rows })
        };
        Some(Self { ranks, parts: lines.map(part).collect::<Option<_>>()? })
    }
}

#[cfg(test)]
mod tests {
    use catamaran::io::{Columns, TableOptions};

    use super::*;

    #[test]
    fn names_of_parts_tell_the_number_of_processes() {
        for (end, process) in [
            ("", Some((0, 1))),
            (".0-of-3", Some((0, 3))),
            (".11-of-12", Some((11, 12))),
            (".3-of-3", None),
            (".03-of-4", None),
            (".0-of-3.old", None),
            ("-2", None),
            (".npy", None),
        ] {
            assert_eq!(process_of(end), process, "{end}");
        }
        assert_eq!(
            CheckpointFile::name(Path::new("a/sums"), Some("0-of-2")),
            Path::new("a/sums.0-of-2")
        );
        assert_eq!(CheckpointFile::name(Path::new("sums"), None), Path::new("sums"));
    }

    #[test]
    fn options_that_differ_are_named_as_on_the_command_line() {
        let labels = |table: TableOptions, columns: &str| {
            let columns = if columns.is_empty() { Columns::ALL } else { Columns::parse(columns) };
            option_labels(&ReadOptions::new().table(table).columns(columns))
        };
        let one = labels(TableOptions::new().skip(2).header(false), "0..3");
        let other = labels(TableOptions::new().skip(1).decimal(',').header(false), "");
        assert_eq!(differing_options(&one, &one), None);
        let expected = "--decimal ',' was not given, and is now; --skip 2 was given, and --skip 1 \
                        is now; --columns 0..3 was given, and is not now";
        assert_eq!(differing_options(&one, &other).unwrap(), expected);
        let without = differing_options(&one, &[]).unwrap();
        assert!(without.contains("--no-header was given, and is not now"), "{without}");
        // Other labels are compared elsewhere.
        let weights = [("weights".to_owned(), "none".to_owned())];
        assert_eq!(differing_options(&weights, &[]), None);
    }

    #[test]
    fn files_and_rows_are_passed_on_as_text() {
        let part = |path: &str, rank, rows: &str| SavedFile {
            path: path.into(),
            rank,
            rows: rows.parse().unwrap(),
        };
        let parts = vec![part("a b/sums.0-of-2", 0, "0..3,7..9"), part("s", 1, "")];
        for saved in [Saved { parts, ranks: 2 }, Saved::default()] {
            assert_eq!(Saved::from_text(&saved.to_text()), Some(saved));
        }
        assert_eq!(Saved::from_text("x"), None);
        assert_eq!(Saved::from_text("1\nno tab"), None);
    }
}
