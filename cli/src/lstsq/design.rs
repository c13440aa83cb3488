//! Factors and missing values: how the columns and rows of a table become those of A and B.

use std::path::Path;

use anyhow::{Context, Result, bail};
use catamaran::rows::{Design, DesignColumn, Factor, Survey};
use catamaran::{Error, Par};
use clap::ValueEnum;

use super::Rows;
use super::names::list;
use crate::report::{note, status};

/// What happens to rows in which a value is missing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Missing {
    /// They are an error.
    Error,
    /// They are left out, and counted.
    Drop,
}

/// A column of A as the coefficients see it.
pub struct Term {
    /// The name of the column.
    pub column: String,
    /// The levels of a factor, the base first; none for numbers.
    pub levels: Vec<String>,
}

/// What `--factor` says.
struct Wanted<'a> {
    column: usize,
    base: Option<&'a str>,
}

/// Rows without missing values, with factors as their indicators.
pub(super) struct Designed {
    pub rows: Rows,
    /// The columns of A.
    pub terms: Vec<Term>,
    /// Rows that are left out.
    pub dropped: usize,
}

/// Leaves out rows with missing values, and replaces factors by their indicators.
pub(super) fn apply(
    path: &Path,
    rows: Rows,
    factors: &[String],
    missing: Missing,
    par: Par,
) -> Result<Designed> {
    let numbers = |column: &String| Term { column: column.clone(), levels: Vec::new() };
    let mut terms: Vec<Term> = rows.columns.iter().map(numbers).collect();
    if factors.is_empty() && missing == Missing::Error {
        return Ok(Designed { rows, terms, dropped: 0 });
    }
    let Rows { table, columns, targets } = rows;
    let wanted = wanted(path, &columns, factors)?;
    let used: Vec<usize> = (0..columns.len() + targets.len()).collect();
    let at: Vec<usize> = wanted.iter().map(|wanted| wanted.column).collect();
    let name = |j: usize| columns.get(j).unwrap_or_else(|| &targets[j - columns.len()]);
    let survey = table
        .read_all(0..table.all_rows(), false, |table| {
            Survey::of(table, &used, &at, par).map_err(|error| match error {
                Error::NonFinite { what: "table", index: (row, j) } => {
                    let why = format!("infinite at row {row} (counted from 0), column {}", name(j));
                    Error::Argument { what: "table", why }
                }
                error => error,
            })
        })
        .map_err(|error| match error.downcast_ref() {
            // Others name the file.
            Some(Error::Argument { .. }) => error.context(path.display().to_string()),
            _ => error,
        })?;
    if let (Missing::Error, Some(row)) = (missing, survey.missing.first()) {
        bail!(
            "{}: a value is missing in row {row} (counted from 0); --missing drop leaves such rows \
             out",
            path.display()
        );
    }
    let dropped = survey.missing.len();
    if dropped > 0 {
        let left = table.all_rows() - dropped;
        note(format_args!(
            "{}: {dropped} rows with a missing value are left out, {left} rows are used",
            path.display()
        ));
    }
    let mut design: Vec<DesignColumn> = used.into_iter().map(DesignColumn::Numbers).collect();
    for (wanted, entries) in wanted.iter().zip(survey.entries) {
        let j = wanted.column;
        let factor = Factor::of_numbers(&columns[j], entries)
            .and_then(|factor| match wanted.base {
                Some(base) => factor.with_base(base),
                None => Ok(factor),
            })
            .with_context(|| path.display().to_string())?;
        let (name, base, levels) = (factor.name(), factor.base(), factor.levels().len());
        status!(
            "factor", column = name, base = base, levels = levels;
            "{name}: {levels} levels, compared with {base}"
        )?;
        terms[j].levels = factor.levels().to_vec();
        design[j] = DesignColumn::Indicators(j, factor);
    }
    let columns = terms.iter().flat_map(names).collect();
    let table = table.designed(Design::new(design).without_rows(survey.missing));
    Ok(Designed { rows: Rows { table, columns, targets }, terms, dropped })
}

/// Returns the names of the columns of a term.
fn names(term: &Term) -> Vec<String> {
    match &term.levels[..] {
        [] => vec![term.column.clone()],
        [_, others @ ..] => {
            others.iter().map(|level| format!("{}[{level}]", term.column)).collect()
        }
    }
}

/// Finds the columns of `--factor`, each a name, or a name, an equals sign and the base.
fn wanted<'a>(path: &Path, columns: &[String], factors: &'a [String]) -> Result<Vec<Wanted<'a>>> {
    let mut found: Vec<Wanted> = Vec::with_capacity(factors.len());
    for text in factors {
        let position = |name: &str| columns.iter().position(|column| column == name);
        // A name may have an equals sign.
        let whole = position(text).map(|column| Wanted { column, base: None });
        let split = || {
            let (name, base) = text.split_once('=')?;
            Some(Wanted { column: position(name)?, base: Some(base) })
        };
        let Some(factor) = whole.or_else(split) else {
            let known = list(columns.iter().map(String::as_str));
            bail!("{}: no column {text} for --factor; A has {known}", path.display());
        };
        if found.iter().any(|other| other.column == factor.column) {
            let name = &columns[factor.column];
            bail!("{}: column {name} is named twice by --factor", path.display());
        }
        found.push(factor);
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn factors_are_found_by_name_with_or_without_a_base() {
        let columns = ["a", "b=c", "b"].map(str::to_owned);
        let found = |factors: &[&str]| {
            let factors: Vec<String> = factors.iter().map(|&text| text.to_owned()).collect();
            wanted(Path::new("t.csv"), &columns, &factors)
                .map(|found| {
                    let pair = |wanted: &Wanted| (wanted.column, wanted.base.map(str::to_owned));
                    found.iter().map(pair).collect::<Vec<_>>()
                })
                .map_err(|error| error.to_string())
        };
        assert_eq!(found(&["b=c", "a=x=y"]), Ok(vec![(1, None), (0, Some("x=y".into()))]));
        assert_eq!(found(&["b=d"]), Ok(vec![(2, Some("d".into()))]));
        let no = "t.csv: no column z for --factor; A has a, b=c, b";
        assert_eq!(found(&["z"]), Err(no.into()));
        let twice = "t.csv: column a is named twice by --factor";
        assert_eq!(found(&["a", "a=1"]), Err(twice.into()));
    }
}
