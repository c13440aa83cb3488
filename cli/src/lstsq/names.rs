//! Columns of A by names or numbers.

use std::collections::BTreeSet;
use std::path::Path;

use anyhow::{Error, Result, anyhow, bail};

use crate::rows::Source;

/// Most columns that an error lists.
const LISTED: usize = 10;

/// How `predict` finds a column of A in another table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// By its name.
    Name,
    /// It is the only one with an empty name in the header.
    Unnamed,
    /// By this number in a table without names; in others by the name that is this number.
    Number(usize),
}

/// Returns how each column of A is found.
pub fn places(a: &Source) -> Vec<Place> {
    let (names, numbers) = (a.column_names(), a.numbers());
    let reading = a.reading().filter(|reading| reading.header);
    let is_unnamed = |j: usize| {
        let column = reading.and_then(|reading| reading.columns.get(j));
        column.is_some_and(|column| column.name.is_empty())
    };
    let place = |j: usize| match is_unnamed(j) {
        true => Place::Unnamed,
        false if names[j] == numbers[j].to_string() => Place::Number(numbers[j]),
        false => Place::Name,
    };
    (0..names.len()).map(place).collect()
}

/// Returns a name that two columns have, empty for two without names.
pub fn shared(names: &[String], places: &[Place]) -> Option<String> {
    let mut known = BTreeSet::new();
    let own = |(name, place): (&String, &Place)| match place {
        Place::Unnamed => String::new(),
        Place::Name | Place::Number(_) => name.clone(),
    };
    names.iter().zip(places).map(own).find(|name| !known.insert(name.clone()))
}

/// The columns of A.
pub struct Names<'a> {
    /// The file.
    pub path: &'a Path,
    /// Their names.
    pub names: &'a [String],
    /// Their numbers in the file.
    pub numbers: &'a [usize],
    /// Whether `--columns` selects them.
    pub are_selected: bool,
}

impl Names<'_> {
    /// Returns the columns with these names, or these numbers in their file.
    ///
    /// # Errors
    /// No column or more than one has a name, or a column is named twice.
    pub fn find(&self, wanted: &[String]) -> Result<Vec<usize>> {
        let mut found = Vec::with_capacity(wanted.len());
        for name in wanted {
            let Some(column) = self.position(name)? else {
                return Err(self.missing(name, "by-column"));
            };
            if found.contains(&column) {
                bail!("{}: column {name} is named twice by --by-column", self.path.display());
            }
            found.push(column);
        }
        Ok(found)
    }

    /// Returns the column with this name, or this number in the file, if there is one.
    ///
    /// # Errors
    /// More than one has this name.
    pub fn position(&self, wanted: &str) -> Result<Option<usize>> {
        let mut called = (0..self.names.len()).filter(|&column| self.names[column] == wanted);
        match (called.next(), called.next()) {
            (Some(column), None) => return Ok(Some(column)),
            (Some(_), Some(_)) => {
                let path = self.path.display();
                bail!("{path}: two columns are called {wanted}; give a number instead")
            }
            (None, _) => {}
        }
        let number = wanted.parse::<usize>().ok();
        Ok(number.and_then(|number| self.numbers.iter().position(|&other| other == number)))
    }

    /// Returns an error about a column that an option names and A does not have.
    pub fn missing(&self, wanted: &str, option: &str) -> Error {
        let known = list(self.names.iter().map(String::as_str));
        let others = if self.are_selected { "; --columns leaves out the others" } else { "" };
        anyhow!("{}: no column {wanted} for --{option}; A has {known}{others}", self.path.display())
    }
}

/// Joins names in a line, at most [`LISTED`] of them.
pub fn list<'a>(names: impl ExactSizeIterator<Item = &'a str>) -> String {
    let count = names.len();
    let mut text = names.take(LISTED).collect::<Vec<_>>().join(", ");
    if count > LISTED {
        text += &format!(" and {} more", count - LISTED);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(wanted: &[&str]) -> Result<Vec<usize>, String> {
        let names = ["x", "y", "x", "7"].map(str::to_owned);
        let wanted: Vec<String> = wanted.iter().map(|&name| name.to_owned()).collect();
        let path = Path::new("a.csv");
        let names = Names { path, names: &names, numbers: &[5, 6, 7, 9], are_selected: true };
        names.find(&wanted).map_err(|e| e.to_string())
    }

    #[test]
    fn names_come_before_numbers_which_count_the_columns_of_the_file() {
        assert_eq!(found(&["y"]), Ok(vec![1]));
        assert_eq!(found(&["7", "5"]), Ok(vec![3, 0]));
        assert_eq!(found(&["9", "y"]), Ok(vec![3, 1]));
    }

    #[test]
    fn a_name_is_shared_by_columns_that_another_table_can_not_tell_apart() {
        let shared = |names: &[&str], places: &[Place]| {
            let names: Vec<String> = names.iter().map(|&name| name.to_owned()).collect();
            shared(&names, places)
        };
        let (name, number) = (Place::Name, Place::Number);
        assert_eq!(shared(&["x", "y", "x"], &[name, name, name]), Some("x".into()));
        assert_eq!(shared(&["0", "1", "0"], &[number(0), number(1), name]), Some("0".into()));
        // The second one has an empty name, and is shown by its number.
        assert_eq!(shared(&["2", "2", "y"], &[name, Place::Unnamed, name]), None);
        assert_eq!(shared(&["1", "2"], &[Place::Unnamed, Place::Unnamed]), Some(String::new()));
    }

    #[test]
    fn errors_name_the_file_and_the_column() {
        let no =
            "a.csv: no column z for --by-column; A has x, y, x, 7; --columns leaves out the others";
        assert_eq!(found(&["z"]), Err(no.into()));
        assert_eq!(found(&["8"]), Err(no.replace("column z", "column 8")));
        assert_eq!(found(&["4"]), Err(no.replace("column z", "column 4")));
        let two = "a.csv: two columns are called x; give a number instead";
        assert_eq!(found(&["x"]), Err(two.into()));
        let twice = "a.csv: column 6 is named twice by --by-column";
        assert_eq!(found(&["y", "6"]), Err(twice.into()));
    }
}
