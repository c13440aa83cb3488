//! Which columns of A are targets, by names or numbers.

use std::path::Path;

use anyhow::{Result, bail};

/// Most columns that an error lists.
const LISTED: usize = 10;

/// Returns the columns with these names, or these numbers in their file.
///
/// # Errors
/// No column or more than one has a name, or a column is named twice.
pub fn find(
    path: &Path,
    names: &[String],
    numbers: &[usize],
    wanted: &[String],
) -> Result<Vec<usize>> {
    let mut found = Vec::with_capacity(wanted.len());
    for name in wanted {
        let column = find_one(path, names, numbers, name)?;
        if found.contains(&column) {
            bail!("{}: column {name} is named twice by --by-column", path.display());
        }
        found.push(column);
    }
    Ok(found)
}

fn find_one(path: &Path, names: &[String], numbers: &[usize], wanted: &str) -> Result<usize> {
    let mut called = (0..names.len()).filter(|&column| names[column] == wanted);
    match (called.next(), called.next()) {
        (Some(column), None) => return Ok(column),
        (Some(_), Some(_)) => {
            bail!("{}: two columns are called {wanted}; give a number instead", path.display())
        }
        (None, _) => {}
    }
    let number = wanted.parse::<usize>().ok();
    match number.and_then(|number| numbers.iter().position(|&other| other == number)) {
        Some(column) => Ok(column),
        None => {
            let known = list(names.iter().map(String::as_str));
            bail!("{}: no column {wanted}; the columns are {known}", path.display())
        }
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
        find(Path::new("a.csv"), &names, &[5, 6, 7, 9], &wanted).map_err(|e| e.to_string())
    }

    #[test]
    fn names_come_before_numbers_which_count_the_columns_of_the_file() {
        assert_eq!(found(&["y"]), Ok(vec![1]));
        assert_eq!(found(&["7", "5"]), Ok(vec![3, 0]));
        assert_eq!(found(&["9", "y"]), Ok(vec![3, 1]));
    }

    #[test]
    fn errors_name_the_file_and_the_column() {
        let no = "a.csv: no column z; the columns are x, y, x, 7";
        assert_eq!(found(&["z"]), Err(no.into()));
        assert_eq!(found(&["8"]), Err(no.replace('z', "8")));
        assert_eq!(found(&["4"]), Err(no.replace('z', "4")));
        let two = "a.csv: two columns are called x; give a number instead";
        assert_eq!(found(&["x"]), Err(two.into()));
        let twice = "a.csv: column 6 is named twice by --by-column";
        assert_eq!(found(&["y", "6"]), Err(twice.into()));
    }
}
