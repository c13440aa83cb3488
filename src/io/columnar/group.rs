//! Decodes the rows of a group, some at a time, a column on a thread.

use std::path::Path;
use std::sync::Arc;

use faer::MatMut;
use faer::prelude::ReborrowMut;

use super::fault::Fault;
use super::store::{Cells, ColumnReader, Store};
use super::words::Words;
use crate::base::{Error, Par, Real, Result};
use crate::io::source::error;
use crate::io::table::{Missing, TableColumn, option};

/// Rows that are decoded at a time: the entries of a column stay in the second cache.
pub const BATCH: usize = 1 << 15;

/// Rows that a thread copies at a time.
const COPIED: usize = 1 << 12;

/// A column that is read.
#[derive(Debug, Clone)]
pub struct Used {
    pub column: TableColumn,
    /// The numbers of its words, if it is a factor.
    pub words: Option<Arc<Words>>,
}

/// What the rows of all groups have in common.
#[derive(Clone, Copy)]
pub struct Context<'a> {
    pub path: &'a Path,
    pub store: &'a dyn Store,
    pub missing: Missing,
    pub par: Par,
}

impl Context<'_> {
    /// Returns the error for what is wrong with a column in a group.
    fn fail(&self, group: usize, name: &str, what: &str) -> Error {
        let of = self.store.contents().group_name;
        error(self.path, None, format!("column {name}, {of} {group} (counted from 0): {what}"))
    }
}

/// A group whose rows are decoded in order.
pub struct Group {
    pub number: usize,
    columns: Vec<Column>,
    /// Rows that are not decoded yet.
    pub left: usize,
    /// Rows that are decoded.
    rows: usize,
    /// Those of the decoded rows that are kept, if not all are.
    kept: Option<Vec<u32>>,
}

struct Column {
    name: String,
    reader: Box<dyn ColumnReader>,
    cells: Cells,
    fault: Option<Fault>,
}

impl Group {
    /// Opens some columns of a group.
    pub fn open<'a>(
        context: Context<'_>,
        number: usize,
        used: impl Iterator<Item = &'a Used>,
    ) -> Result<Self> {
        let open = |Used { column, words }: &Used| -> Result<Column> {
            let reader = context.store.column(number, column.number, words.as_ref());
            let reader = reader.map_err(|what| context.fail(number, &column.name, &what))?;
            let name = column.name.clone();
            Ok(Column { name, reader, cells: Cells::default(), fault: None })
        };
        let columns = used.map(open).collect::<Result<_>>()?;
        let left = context.store.contents().groups[number];
        Ok(Self { number, columns, left, rows: 0, kept: None })
    }

    /// Decodes the next rows, at most [`BATCH`].
    ///
    /// # Errors
    /// A column is damaged; a cell is missing where that is an error.
    pub fn next(&mut self, context: Context<'_>) -> Result<()> {
        let before = context.store.contents().groups[self.number];
        let rows = self.left.min(BATCH);
        context.par.for_each(self.columns.iter_mut(), |_, column: &mut Column| {
            column.cells.clear();
            let done = column.reader.read(rows, &mut column.cells);
            column.fault = match done {
                Ok(()) if column.cells.values.len() == rows => None,
                Ok(()) => Some("fewer entries than rows".into()),
                Err(what) => Some(what),
            };
        });
        for Column { name, fault, .. } in &self.columns {
            if let Some(what) = fault {
                return Err(context.fail(self.number, name, what));
            }
        }
        let first = before - self.left;
        self.left -= rows;
        self.rows = rows;
        self.kept = None;
        match context.missing {
            Missing::Nan => {}
            Missing::Drop => self.drop_missing(),
            Missing::Error => {
                for Column { name, cells, .. } in &self.columns {
                    if let Some(at) = cells.values.iter().position(|x| x.is_nan()) {
                        let (row, option) = (first + at, option("missing"));
                        let what = format!(
                            "a missing value in row {row} of it; {option} says what becomes of \
                             such rows"
                        );
                        return Err(context.fail(self.number, name, &what));
                    }
                }
            }
        }
        Ok(())
    }

    /// Leaves out the rows with missing cells.
    fn drop_missing(&mut self) {
        let mut is_kept = vec![true; self.rows];
        for column in &self.columns {
            is_kept.iter_mut().zip(&column.cells.values).for_each(|(kept, x)| *kept &= !x.is_nan());
        }
        if is_kept.contains(&false) {
            let kept = (0..self.rows as u32).filter(|&at| is_kept[at as usize]);
            self.kept = Some(kept.collect());
        }
    }

    /// Returns how many of the decoded rows are kept.
    pub fn kept(&self) -> usize {
        self.kept.as_ref().map_or(self.rows, Vec::len)
    }

    /// Marks the words in kept rows of a column.
    pub fn mark(&self, column: usize, seen: &mut Vec<bool>) {
        let values = &self.columns[column].cells.values;
        let mut mark = |value: f64| {
            // A missing word is NaN, which no place has.
            if value >= 0.0 {
                let number = value as usize;
                if number >= seen.len() {
                    seen.resize(number + 1, false);
                }
                seen[number] = true;
            }
        };
        match &self.kept {
            None => values.iter().for_each(|&value| mark(value)),
            Some(kept) => kept.iter().for_each(|&at| mark(values[at as usize])),
        }
    }

    /// Returns the rows among those that are decoded and kept in which an integer of a column was
    /// rounded.
    pub fn rounded(&self, column: usize) -> impl Iterator<Item = usize> {
        let rows = self.columns[column].cells.rounded.iter().copied();
        let is_kept =
            |row: u32| self.kept.as_ref().is_none_or(|kept| kept.binary_search(&row).is_ok());
        rows.filter(move |&row| is_kept(row as u32))
    }

    /// Copies kept rows, from `first` of them on, into the rows of `out`.
    pub fn copy<T: Real>(&self, first: usize, out: MatMut<'_, T>, par: Par) {
        let columns: Vec<&[f64]> = self.columns.iter().map(|c| &c.cells.values[..]).collect();
        let mut parts = Vec::with_capacity(out.nrows() / COPIED + 1);
        let (mut rest, mut start) = (out, first);
        while rest.nrows() > 0 {
            let count = rest.nrows().min(COPIED);
            let (part, below) = rest.split_at_row_mut(count);
            parts.push((start, part));
            (rest, start) = (below, start + count);
        }
        // Readers of columns, which a group has, too, must not be shared by threads.
        let kept = self.kept.as_deref();
        par.for_each(parts.into_iter(), |_, (start, part)| match kept {
            None => copy(&columns, |i| start + i, part),
            Some(kept) => copy(&columns, |i| kept[start + i] as usize, part),
        });
    }
}

/// Copies row `of(i)` of the columns into row i of `out`.
fn copy<T: Real>(columns: &[&[f64]], of: impl Fn(usize) -> usize, mut out: MatMut<'_, T>) {
    for i in 0..out.nrows() {
        let from = of(i);
        let row = out.rb_mut().row_mut(i);
        for (to, column) in row.iter_mut().zip(columns) {
            *to = T::from_f64(column[from]);
        }
    }
}
