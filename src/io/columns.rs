//! The columns that a reader keeps.

use std::fmt;
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
    /// A list between commas, or a name that has commas.
    Text(String),
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

/// Writes the columns as a message calls them: `all columns`, or `columns` and the list.
impl fmt::Display for Columns {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.0 {
            Kept::All => f.write_str("all columns"),
            Kept::Range(Range { start, end }) => write!(f, "columns {start}..{end}"),
            Kept::List(items) => write!(f, "columns {}", items.join(", ")),
            Kept::Text(text) => write!(f, "columns {text}"),
        }
    }
}

impl Columns {
    /// All columns.
    pub const ALL: Self = Self(Kept::All);

    /// Returns the columns of a list, in its order: names in the header, or else numbers and ranges
    /// `FIRST..END` without END, counted from 0 over all columns of the file. Commas separate them;
    /// the list may also be one name that has commas.
    ///
    /// The ends of a range are no names: where columns are called so and have other numbers, the
    /// range is an error.
    pub fn parse(list: &str) -> Self {
        Self(Kept::Text(list.to_owned()))
    }

    /// Returns the columns of a list as [`Columns::parse`] does, each of which may have commas.
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
        checked_columns(self.as_range().as_ref(), ncols)
    }

    /// Returns whether the columns are those of a list.
    pub(super) fn is_list(&self) -> bool {
        !self.is_all() && self.as_range().is_none()
    }

    /// Returns the first column that a reader keeps.
    pub(super) fn first(&self) -> usize {
        self.as_range().map_or(0, |range| range.start)
    }

    /// Returns a test of whether a column, of `ncols`, is kept.
    pub(super) fn kept(&self, ncols: usize) -> Result<impl Fn(usize) -> bool + use<>> {
        let mut list = if self.is_list() { self.of(&[], ncols)? } else { Vec::new() };
        list.sort_unstable();
        let range = if self.is_list() { 0..0 } else { self.range(ncols)? };
        Ok(move |column| range.contains(&column) || list.binary_search(&column).is_ok())
    }

    fn as_range(&self) -> Option<Range<usize>> {
        match &self.0 {
            Kept::All | Kept::List(_) => None,
            Kept::Range(range) => Some(range.clone()),
            Kept::Text(text) => bounds(text),
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
    /// [`Error::Argument`] for a column that does not exist, a name that two columns have, a column
    /// that is named twice, a range between names, and a text that is a name and a list.
    pub fn of(&self, names: &[String], ncols: usize) -> Result<Vec<usize>> {
        match &self.0 {
            Kept::All => Ok((0..ncols).collect()),
            Kept::Range(range) => Ok(checked_columns(Some(range), ncols)?.collect()),
            Kept::List(items) => each(items.iter().map(String::as_str), names, ncols),
            Kept::Text(text) => {
                let listed = each(text.split(',').map(str::trim), names, ncols);
                match (listed, one(text, names, ncols)) {
                    (Err(_), Ok(whole)) => Ok(whole.collect()),
                    (Ok(_), Ok(_)) if text.contains(',') => {
                        refuse(format!("{text} is a column and a list of columns: give numbers"))
                    }
                    (listed, _) => listed,
                }
            }
        }
    }
}

/// Returns the columns of the items of a list.
fn each<'a>(
    items: impl Iterator<Item = &'a str>,
    names: &[String],
    ncols: usize,
) -> Result<Vec<usize>> {
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
    let place = |name: &str| names.iter().position(|other| other == name);
    let between = item.split_once("..").and_then(|(a, b)| Some((place(a)?, b, place(b)?)));
    let range = bounds(item);
    match (between, &range) {
        (Some((first, _, last)), Some(range)) if (range.start, range.end) == (first, last) => {}
        (Some((first, name, last)), _) => return between_names(item, first, name, last),
        (None, _) => {}
    }
    if range.is_some() {
        return checked_columns(range.as_ref(), ncols);
    }
    if let Some(whole) = with_both_ends(item, ncols) {
        return refuse(format!("{item}: a range has two ends, FIRST..END without END: {whole}"));
    }
    let known = match names {
        [] => format!("the file has {ncols} columns without names, counted from 0"),
        names => format!("the columns are {}", listed(names)),
    };
    refuse(format!("no column {item}; {known}"))
}

/// Returns the error of a range between two names, those of the columns `first` and `last`.
fn between_names<T>(item: &str, first: usize, name: &str, last: usize) -> Result<T> {
    let known = format!("{item}: a range has numbers of columns, counted from 0, and no names");
    let end = last + 1;
    refuse(match first < last {
        true => format!("{known}: {first}..{end} ends with {name}, {first}..{last} before it"),
        false => format!("{known}: its names are those of the columns {first} and {last}"),
    })
}

/// Returns the range, of `ncols` columns, that a text with one end of it may mean.
fn with_both_ends(item: &str, ncols: usize) -> Option<String> {
    let (first, end) = item.split_once("..")?;
    let column = |text: &str| text.parse::<usize>().ok();
    match (first, end) {
        ("", end) => Some(format!("0..{}", column(end).filter(|end| (1..=ncols).contains(end))?)),
        (first, "") => Some(format!("{}..{ncols}", column(first).filter(|&first| first < ncols)?)),
        _ => None,
    }
}

/// Returns the range FIRST..END that a text is.
fn bounds(text: &str) -> Option<Range<usize>> {
    let (first, end) = text.split_once("..")?;
    Some(first.parse().ok()?..end.parse().ok()?)
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

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str, names: &[&str]) -> std::result::Result<Vec<usize>, String> {
        let names: Vec<String> = names.iter().map(|&name| name.to_owned()).collect();
        Columns::parse(text).of(&names, names.len()).map_err(|e| e.to_string())
    }

    #[test]
    fn a_range_between_names_is_refused_unless_they_are_the_numbers() {
        let years = ["country", "1990", "1991", "1992"];
        let refused = of("1990..1992", &years).unwrap_err();
        assert!(refused.contains("1..4 ends with 1992, 1..3 before it"), "{refused}");
        assert!(of("country..1991", &years).unwrap_err().contains("0..3 ends with 1991"));
        assert!(of("0,2..3,1990..1992", &years).is_err());
        assert_eq!(of("1..3", &years), Ok(vec![1, 2]));
        assert_eq!(of("1..3", &["0", "1", "2", "3"]), Ok(vec![1, 2]));
        let shifted = ["x", "0", "1", "2", "3"];
        assert!(of("1..3", &shifted).unwrap_err().contains("2..5 ends with 3"));
        assert_eq!(Columns::from(1..3).of(&shifted.map(str::to_owned), 5).unwrap(), [1, 2]);
    }

    #[test]
    fn a_range_between_names_in_reverse_names_their_columns() {
        let refused = of("0..2", &["2", "0", "1"]).unwrap_err();
        assert!(refused.ends_with("its names are those of the columns 1 and 0"), "{refused}");
        let refused = of("b..b", &["a", "b"]).unwrap_err();
        assert!(refused.ends_with("those of the columns 1 and 1"), "{refused}");
    }

    #[test]
    fn a_range_of_one_end_says_what_both_may_be() {
        let names = ["a", "b", "c", "d", "e"];
        for (text, whole) in [("3..", "3..5"), ("..2", "0..2"), ("a,1..", "1..5")] {
            let refused = of(text, &names).unwrap_err();
            assert!(refused.ends_with(&format!("FIRST..END without END: {whole}")), "{refused}");
        }
        for text in ["5..", "..6", "..0", "..", "a.."] {
            assert!(of(text, &names).unwrap_err().contains(&format!("no column {text};")));
        }
    }

    #[test]
    fn a_text_is_a_list_or_a_name_with_commas() {
        assert_eq!(of("a, 0", &["b", "a"]), Ok(vec![1, 0]));
        assert_eq!(of("Height, cm", &["Height, cm", "x"]), Ok(vec![0]));
        let both = of("a,b", &["a", "b", "a,b"]).unwrap_err();
        assert!(both.contains("a,b is a column and a list of columns"), "{both}");
        assert!(of("a,c", &["a", "b"]).unwrap_err().contains("no column c"));
    }

    #[test]
    fn a_range_in_a_text_bounds_what_is_read() {
        assert_eq!(Columns::parse("1..3").range(5).unwrap(), 1..3);
        assert!(!Columns::parse("1..3").is_list() && Columns::parse("1,2").is_list());
    }
}
