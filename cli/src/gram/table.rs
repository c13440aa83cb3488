//! The rows that are added: those of a file, of two files side by side, or of a file with its
//! columns in another order.

use std::ops::Range;
use std::path::Path;

use anyhow::{Result, bail};
use catamaran::faer::MatMut;
use catamaran::faer::prelude::ReborrowMut;
use catamaran::rows::RowBlocks;
use catamaran::solve::JoinedRows;

use crate::rows::{Part, Source};

/// Rows of f64.
pub struct Table {
    a: Source,
    with: With,
}

/// What is done with the rows of A.
enum With {
    Nothing,
    /// The columns of this matrix follow.
    Columns(Box<Source>),
    /// The columns of A come in this order.
    Order(Vec<usize>),
}

impl Table {
    /// Returns the rows of A.
    pub fn of(a: Source) -> Self {
        Self { a, with: With::Nothing }
    }

    /// Returns the rows of `[A B]`.
    pub fn joined(a: Source, b: Source) -> Result<Self> {
        a.refuse_dropped(b.path())?;
        b.refuse_dropped(a.path())?;
        let ((m, _), (rows, columns)) = (a.shape(), b.shape());
        if rows != m {
            bail!(
                "{}: {rows} x {columns} where the {m} rows of {} need {m} rows",
                b.path().display(),
                a.path().display()
            );
        }
        Ok(Self { a, with: With::Columns(Box::new(b)) })
    }

    /// Returns the rows of A with its columns in this order, a permutation.
    pub fn ordered(a: Source, order: Vec<usize>) -> Self {
        Self { a, with: With::Order(order) }
    }

    /// Returns A.
    pub fn a(&self) -> &Source {
        &self.a
    }

    /// Returns the number of rows.
    pub fn nrows(&self) -> usize {
        self.a.shape().0
    }

    /// Returns the number of columns.
    pub fn ncols(&self) -> usize {
        let more = match &self.with {
            With::Columns(b) => b.shape().1,
            With::Nothing | With::Order(_) => 0,
        };
        self.a.shape().1 + more
    }

    /// Returns the file of a column, and its name there.
    pub fn column(&self, j: usize) -> (&Path, String) {
        let n = self.a.shape().1;
        let (source, j) = match &self.with {
            With::Columns(b) if j >= n => (&**b, j - n),
            With::Order(order) => (&self.a, order[j]),
            With::Columns(_) | With::Nothing => (&self.a, j),
        };
        (source.path(), source.column_names().swap_remove(j))
    }

    /// Returns texts that identify A and what is done with its rows.
    pub fn identity(&self) -> [String; 2] {
        let with = match &self.with {
            With::Nothing => "none".into(),
            With::Columns(b) => b.identity(),
            With::Order(order) => format!("columns in the order {order:?}"),
        };
        [self.a.identity(), with]
    }

    /// Calls `work` with some of the rows; `require_finite` refuses NaN and infinities.
    pub fn read<R>(
        &self,
        range: Range<usize>,
        require_finite: bool,
        work: impl FnOnce(&mut (dyn RowBlocks<f64> + Send)) -> catamaran::Result<R>,
    ) -> Result<R> {
        let part = |source| -> Result<_> {
            Ok(Part { rows: Source::rows::<f64>(source, require_finite)?, range: range.clone() })
        };
        let mut a = part(&self.a)?;
        Ok(match &self.with {
            With::Nothing => work(&mut a)?,
            With::Columns(b) => work(&mut JoinedRows::new(&mut a, &mut part(b)?)?)?,
            With::Order(order) => {
                work(&mut Reordered { rows: a, order, row: vec![0.0; order.len()] })?
            }
        })
    }
}

/// Rows with their columns in another order.
struct Reordered<'a> {
    rows: Part<'a, f64>,
    order: &'a [usize],
    /// A row in the order of the file.
    row: Vec<f64>,
}

impl RowBlocks<f64> for Reordered<'_> {
    fn nrows(&self) -> usize {
        self.rows.nrows()
    }

    fn ncols(&self) -> usize {
        self.order.len()
    }

    fn read(&mut self, first: usize, mut out: MatMut<'_, f64>) -> catamaran::Result<()> {
        self.rows.read(first, out.rb_mut())?;
        for i in 0..out.nrows() {
            let mut out = out.rb_mut().row_mut(i);
            self.row.iter_mut().zip(out.rb_mut().iter_mut()).for_each(|(to, from)| *to = *from);
            out.iter_mut().zip(self.order).for_each(|(to, &from)| *to = self.row[from]);
        }
        Ok(())
    }
}
