//! The columns that a reader keeps.

use std::ops::Range;

use crate::base::{Error, Result};

/// Most names that an error lists.
const LISTED: usize = 10;

/// Columns of a file: all, or some by number, range or name.
///
/// ```
/// use catamaran::io::{Columns, ReadOptions, read};
///
/// # let folder = tempfile::tempdir().unwrap();
/// # let path = &folder.path().join("a.csv");
/// std::fs::write(path, "age,height,weight\n3,0.9,15\n7,1.2,24\n").unwrap();
/// let some = |columns: &str| read(path, &ReadOptions::new().columns(Columns::parse(columns)));
/// assert_eq!(some("weight,0")?.ncols(), 2);
/// assert_eq!(some("1..3")?.ncols(), 2);
/// assert!(some("length").is_err());
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Columns(Kept);

#[derive(Debug, Clone, PartialEq, Eq)]
enum Kept {
    All,
    Range(Range<usize>),
    List(Vec<String>),
}

impl From<Range<usize>> for Columns {
    fn from(range: Range<usize>) -> Self {
        Self(Kept::Range(range))
    }
}

impl From<Option<Range<usize>>> for Columns {
    fn from(range: Option<Range<usize>>) -> Self {
        range.map_or(Self::ALL, Self::from)
    }
}

impl Columns {
    /// All columns.
    pub const ALL: Self = Self(Kept::All);

    /// Returns the columns of a list, in its order: names in the header, or else numbers and ranges
    /// `FIRST..END`, counted from 0 over all columns of the file. Commas separate them.
    pub fn parse(list: &str) -> Self {
        Self::list(list.split(',').map(|item| item.trim().to_owned()).collect())
    }

    /// Returns the columns of a list as [`Columns::parse`] does, of names that may have commas.
    pub fn list(items: Vec<String>) -> Self {
        Self(Kept::List(items))
    }

    /// Returns a list of numbers.
    pub(super) fn numbers(numbers: Vec<usize>) -> Self {
        Self::list(numbers.iter().map(usize::to_string).collect())
    }

    /// Returns whether all columns are kept.
    pub fn is_all(&self) -> bool {
        self.0 == Kept::All
    }

    /// Returns the columns, of `ncols`, that a reader keeps: all for a list, of which
    /// [`Matrix::select`](super::Matrix) takes the columns afterwards.
    pub(super) fn range(&self, ncols: usize) -> Result<Range<usize>> {
        match &self.0 {
            Kept::All | Kept::List(_) => Ok(0..ncols),
            Kept::Range(range) => checked_columns(Some(range), ncols),
        }
    }

    /// Returns whether the columns are those of a list.
    pub(super) fn is_list(&self) -> bool {
        matches!(self.0, Kept::List(_))
    }

    /// Returns the first column that a reader keeps.
    pub(super) fn first(&self) -> usize {
        match &self.0 {
            Kept::All | Kept::List(_) => 0,
            Kept::Range(range) => range.start,
        }
    }

    /// Returns the numbers of these columns of a file with `ncols` columns. There are as many
    /// names, or none.
    ///
    /// ```
    /// use catamaran::io::Columns;
    ///
    /// let names = ["x", "7", "y"].map(str::to_owned);
    /// assert_eq!(Columns::parse("y,7,0").of(&names, 3)?, [2, 1, 0]);
    /// assert_eq!(Columns::parse("1..3").of(&[], 3)?, [1, 2]);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Argument`] for a column that does not exist, a name that two columns have, and a
    /// column that is named twice.
    pub fn of(&self, names: &[String], ncols: usize) -> Result<Vec<usize>> {
        let items = match &self.0 {
            Kept::All => return Ok((0..ncols).collect()),
            Kept::Range(range) => return Ok(checked_columns(Some(range), ncols)?.collect()),
            Kept::List(items) => items,
        };
        let mut found = Vec::new();
        for item in items {
            for column in one(item, names, ncols)? {
                if found.contains(&column) {
                    return refuse(format!("column {item} is named twice"));
                }
                found.push(column);
            }
        }
        Ok(found)
    }
}

/// The numbers that the columns of a matrix have in its file.
#[derive(Debug, Clone)]
pub(super) enum ColumnNumbers {
    /// They follow one another, from this one on.
    From(usize),
    List(Vec<usize>),
}

impl ColumnNumbers {
    pub fn of(&self, column: usize) -> usize {
        match self {
            Self::From(first) => first + column,
            Self::List(numbers) => numbers[column],
        }
    }
}

/// Returns the columns of an item of a list.
fn one(item: &str, names: &[String], ncols: usize) -> Result<Range<usize>> {
    let mut called = (0..names.len()).filter(|&column| names[column] == item);
    match (called.next(), called.next()) {
        (Some(column), None) => return Ok(column..column + 1),
        (Some(_), Some(_)) => {
            return refuse(format!("two columns are called {item}; give a number instead"));
        }
        (None, _) => {}
    }
    if let Ok(column) = item.parse::<usize>()
        && column < ncols
    {
        return Ok(column..column + 1);
    }
    let bounds = item.split_once("..").map(|(first, end)| (first.parse(), end.parse()));
    if let Some((Ok(first), Ok(end))) = bounds {
        return checked_columns(Some(&(first..end)), ncols);
    }
    let known = match names {
        [] => format!("the file has {ncols} columns without names, counted from 0"),
        names => format!("the columns are {}", listed(names)),
    };
    refuse(format!("no column {item}; {known}"))
}

/// Joins names, at most [`LISTED`] of them.
pub(super) fn listed<S: AsRef<str>>(names: &[S]) -> String {
    let some: Vec<&str> = names.iter().take(LISTED).map(AsRef::as_ref).collect();
    match names.len().saturating_sub(LISTED) {
        0 => some.join(", "),
        more => format!("{} and {more} more", some.join(", ")),
    }
}

fn refuse<T>(why: String) -> Result<T> {
    Err(Error::Argument { what: "columns", why })
}

/// Returns `columns`, checked against a matrix of `ncols` columns; all of them when `None`.
pub(super) fn checked_columns(
    columns: Option<&Range<usize>>,
    ncols: usize,
) -> Result<Range<usize>> {
    match columns {
        None => Ok(0..ncols),
        Some(r) if r.start <= r.end && r.end <= ncols => Ok(r.clone()),
        Some(r) => refuse(format!(
            "{}..{} is not inside the {ncols} columns of the matrix",
            r.start, r.end
        )),
    }
}
