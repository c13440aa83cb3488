//! The rows of a table without a missing value, also where they have partners in other files.

use anyhow::{Result, anyhow, bail};
use catamaran::faer::Mat;
use catamaran::io::Missing;
use catamaran::rows::{Design, DesignColumn, Survey};
use catamaran::{Error, Par};

use super::{GramArgs, Table};
use crate::ranks::Ranks;
use crate::report::{is_json, note, status};
use crate::rows::RowList;

impl GramArgs {
    /// Leaves out the rows of a table with a missing value, if `--missing` says so. All processes
    /// call this function.
    pub fn complete(&self, ranks: &Ranks, table: Table) -> Result<Table> {
        if self.other_tables().missing() != Missing::Drop {
            return Ok(table);
        }
        let Survey { missing, bounds, .. } = self.survey(ranks, &table, &[])?;
        let columns = (0..table.ncols()).map(DesignColumn::Numbers).collect();
        ranks.meet(table.designed(Design::new(columns).without_rows(missing), &bounds))
    }

    /// Calls [`survey`] with all rows on each process: what it finds decides which rows and columns
    /// there are.
    pub fn survey(&self, ranks: &Ranks, table: &Table, factors: &[usize]) -> Result<Survey> {
        // In copies that differ, each process would find something else.
        table.check_same(ranks)?;
        ranks.meet(survey(table, factors, self.other_tables().missing(), self.par()))
    }
}

/// Finds the rows of the files of a table with a missing value, which are an error unless they are
/// left out, and the entries of factors in the other rows.
pub fn survey(table: &Table, factors: &[usize], missing: Missing, par: Par) -> Result<Survey> {
    let path = table.a().path().display();
    let used: Vec<usize> = (0..table.ncols()).collect();
    let survey = table
        .read_all(&RowList::from(0..table.all_rows()), false, |rows| {
            Survey::of(rows, &used, factors, par)
        })
        .map_err(|error| match error.downcast_ref() {
            Some(&Error::NonFinite { index: (row, j), .. }) => {
                let (path, name) = table.column(j);
                let path = path.display();
                anyhow!("{path}: infinite at row {row} (counted from 0), column {name}")
            }
            // Others name the file.
            Some(Error::Argument { .. }) => error.context(path.to_string()),
            _ => error,
        })?;
    let Some(&first) = survey.missing.first() else { return Ok(survey) };
    if missing != Missing::Drop {
        let column = table.read_all(&RowList::from(first..first + 1), false, |rows| {
            let mut row = Mat::<f64>::zeros(1, rows.ncols());
            rows.read(0, row.as_mut())?;
            Ok((0..row.ncols()).find(|&j| row[(0, j)].is_nan()))
        })?;
        let (path, name) = table.column(column.unwrap_or_default());
        bail!(
            "{}: a value is missing in row {first} (counted from 0), column {name}; --missing \
             drop leaves such rows out",
            path.display()
        );
    }
    let dropped = survey.missing.len();
    let left = table.all_rows() - dropped;
    let rows = if dropped == 1 { "row" } else { "rows" };
    let files = table.files();
    note(format_args!("{files}: {dropped} {rows} with a missing cell left out, {left} used"));
    if is_json() {
        let name = path.to_string();
        status!("left_out", path = name, dropped_rows = dropped, rows = left; "{dropped}")?;
    }
    Ok(survey)
}
