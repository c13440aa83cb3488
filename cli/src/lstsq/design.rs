//! Factors and missing values: how the columns and rows of a table become those of A and B.

use std::path::Path;

use anyhow::{Context, Error, Result, anyhow, bail};
use catamaran::io::Missing;
use catamaran::rows::{Design, DesignColumn, Factor, Survey};

use super::Rows;
use super::names::{Names, Place};
use crate::gram::GramArgs;
use crate::ranks::Ranks;
use crate::report::status;

/// A column of A as the coefficients see it.
pub struct Term {
    /// The name of the column.
    pub column: String,
    /// How it is found in another table.
    pub place: Place,
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

/// Returns the names that `--factor` may mean: a name may have commas and an equals sign, or be
/// between and before them.
pub(super) fn possible_names(factors: &[String]) -> Vec<String> {
    let texts = factors.iter().flat_map(|text| [&text[..]].into_iter().chain(text.split(',')));
    let names = texts.flat_map(|text| [Some(text), text.split_once('=').map(|(name, _)| name)]);
    names.flatten().map(|name| name.trim().to_owned()).collect()
}

/// Leaves out rows with missing values, and replaces factors by their indicators. All processes
/// call this function.
pub(super) fn apply(
    args: &GramArgs,
    ranks: &Ranks,
    rows: Rows,
    factors: &[String],
) -> Result<Designed> {
    let path = args.input();
    let mut terms = terms(&rows);
    if factors.is_empty() && args.other_tables().missing() != Missing::Drop {
        return Ok(Designed { rows, terms, dropped: 0 });
    }
    let Rows { table, columns, numbers, levels, .. } = rows;
    let are_selected = args.selects_columns();
    let names_of_a = Names { path, names: &columns, numbers: &numbers, are_selected };
    let wanted = ranks.meet(wanted(&names_of_a, factors))?;
    let at: Vec<usize> = wanted.iter().map(|wanted| wanted.column).collect();
    ranks.meet(refuse_words(&names_of_a, &levels, &at))?;
    let survey = args.survey(ranks, &table, &at);
    let survey = survey.map_err(|error| with_name(error, path, &columns))?;
    let Survey { missing, entries, bounds, .. } = survey;
    let dropped = missing.len();
    let of_column = |(wanted, entries): (&Wanted<'_>, Vec<f64>)| {
        let j = wanted.column;
        factor(&columns[j], &levels[j], entries, wanted.base)
    };
    let found = wanted.iter().zip(entries).map(of_column).collect::<catamaran::Result<Vec<_>>>();
    let found = ranks.meet(found.with_context(|| path.display().to_string()))?;
    let mut design: Vec<DesignColumn> = (0..table.ncols()).map(DesignColumn::Numbers).collect();
    for (j, factor) in at.into_iter().zip(found) {
        let (name, base, levels) = (factor.name(), factor.base(), factor.levels().len());
        status!(
            "factor", column = name, base = base, levels = levels;
            "{name}: {levels} levels, compared with {base}"
        )?;
        terms[j].levels = factor.levels().to_vec();
        design[j] = DesignColumn::Indicators(j, factor);
    }
    let columns = terms.iter().flat_map(names).collect();
    let design = Design::new(design).without_rows(missing);
    let table = ranks.meet(table.designed(design, &bounds))?;
    Ok(Designed { rows: Rows { table, columns, numbers, levels, ..rows }, terms, dropped })
}

/// Returns the columns of A, all of them numbers.
fn terms(rows: &Rows) -> Vec<Term> {
    let term = |(column, &place): (&String, &Place)| Term {
        column: column.clone(),
        place,
        levels: Vec::new(),
    };
    rows.columns.iter().zip(&rows.places).map(term).collect()
}

/// Refuses columns of words that are no factors: their entries would be numbers of levels. The
/// reader accepts such a column where its place in the file is the name of a factor.
fn refuse_words(names: &Names<'_>, levels: &[Vec<String>], factors: &[usize]) -> Result<()> {
    match (0..levels.len()).find(|j| !levels[*j].is_empty() && !factors.contains(j)) {
        Some(j) => bail!(
            "{}: column {} has words, and --factor names another column: --columns leaves it out",
            names.path.display(),
            names.names[j]
        ),
        None => Ok(()),
    }
}

/// Returns an error of a survey about a factor with its name in place of its number.
fn with_name(error: Error, path: &Path, columns: &[String]) -> Error {
    let said = match error.downcast_ref() {
        Some(catamaran::Error::Argument { what: "factor", why }) => {
            why.strip_prefix("column ").and_then(|rest| {
                let (number, rest) = rest.split_once(' ')?;
                let name = columns.get(number.parse::<usize>().ok()?)?;
                Some(anyhow!("{}: factor: {name} {rest}", path.display()))
            })
        }
        _ => None,
    };
    said.unwrap_or(error)
}

/// Returns a factor with the levels of a column that are among its entries: numbers, or codes of
/// words.
fn factor(
    name: &str,
    words: &[String],
    entries: Vec<f64>,
    base: Option<&str>,
) -> catamaran::Result<Factor> {
    let factor = match words {
        [] => Factor::of_numbers(name, entries),
        words => {
            Factor::of_codes(name, words.to_vec()).and_then(|factor| factor.with_entries(&entries))
        }
    };
    match base {
        Some(base) => factor?.with_base(base),
        None => factor,
    }
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

/// Finds the columns of `--factor`, each a name or number, or that, an equals sign and the base, or
/// a list of these between commas.
fn wanted<'a>(names: &Names<'_>, factors: &'a [String]) -> Result<Vec<Wanted<'a>>> {
    let mut found: Vec<Wanted> = Vec::with_capacity(factors.len());
    for text in factors {
        for one in listed(names, text)? {
            if found.iter().any(|other| other.column == one.column) {
                let (path, name) = (names.path.display(), &names.names[one.column]);
                bail!("{path}: column {name} is named twice by --factor");
            }
            found.push(one);
        }
    }
    Ok(found)
}

/// Returns the columns that a text names: a column with commas in its name, or a list, or a column
/// with commas in the name of its base.
fn listed<'a>(names: &Names<'_>, text: &'a str) -> Result<Vec<Wanted<'a>>> {
    if let Some(column) = names.position(text)? {
        return Ok(vec![Wanted { column, base: None }]);
    }
    let mut found = Vec::new();
    for part in text.split(',').map(str::trim) {
        match (named(names, part)?, named(names, text)?) {
            (Some(one), _) => found.push(one),
            (None, Some(whole)) => return Ok(vec![whole]),
            (None, None) => return Err(names.missing(part, "factor")),
        }
    }
    Ok(found)
}

/// Returns the column with a name that may have an equals sign, or the one with the name before it.
fn named<'a>(names: &Names<'_>, text: &'a str) -> Result<Option<Wanted<'a>>> {
    Ok(match (names.position(text)?, text.split_once('=')) {
        (None, Some((name, base))) => {
            names.position(name)?.map(|column| Wanted { column, base: Some(base) })
        }
        (column, _) => column.map(|column| Wanted { column, base: None }),
    })
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    #[test]
    fn factors_are_found_by_name_with_or_without_a_base() {
        let (names, path) = (["a", "b=c", "b"].map(str::to_owned), Path::new("t.csv"));
        let names = Names { path, names: &names, numbers: &[1, 2, 4], are_selected: false };
        let found = |factors: &[&str]| {
            let factors: Vec<String> = factors.iter().map(|&text| text.to_owned()).collect();
            wanted(&names, &factors)
                .map(|found| {
                    let pair = |wanted: &Wanted| (wanted.column, wanted.base.map(str::to_owned));
                    found.iter().map(pair).collect::<Vec<_>>()
                })
                .map_err(|error| error.to_string())
        };
        assert_eq!(found(&["b=c", "a=x=y"]), Ok(vec![(1, None), (0, Some("x=y".into()))]));
        assert_eq!(found(&["b=d"]), Ok(vec![(2, Some("d".into()))]));
        assert_eq!(found(&["4=d", "1"]), Ok(vec![(2, Some("d".into())), (0, None)]));
        assert_eq!(found(&["a,b=d, 1"]).unwrap_err(), "t.csv: column a is named twice by --factor");
        assert_eq!(found(&["b=d, a"]), Ok(vec![(2, Some("d".into())), (0, None)]));
        assert_eq!(found(&["b=d, e"]), Ok(vec![(2, Some("d, e".into()))]));
        let no = "t.csv: no column z for --factor; A has a, b=c, b";
        assert_eq!(found(&["z"]), Err(no.into()));
        assert_eq!(found(&["a,z"]), Err(no.into()));
        let twice = "t.csv: column a is named twice by --factor";
        assert_eq!(found(&["a", "a=1"]), Err(twice.into()));
    }
}
