//! The rows that are added: those of a file, of two files side by side, or of a file with its
//! columns in another order; as they are, or those of a design.

use std::path::Path;

use anyhow::{Context, Result, bail};
use catamaran::faer::MatMut;
use catamaran::faer::prelude::ReborrowMut;
use catamaran::io::ReadOptions;
use catamaran::rows::{Design, DesignColumn, RowBlocks, RowBounds};
use catamaran::solve::JoinedRows;

use crate::ranks::Ranks;
use crate::rows::{Part, RowList, Source, check_options, fingerprint, fingerprint_of_text};

/// Rows of f64.
pub struct Table {
    a: Source,
    with: With,
    /// None if the rows are those of the files; with the bounds of its rows.
    design: Option<(Design, RowBounds<f64>)>,
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
        Self { a, with: With::Nothing, design: None }
    }

    /// Returns the rows of `[A B]`.
    pub fn joined(a: Source, b: Source) -> Result<Self> {
        let ((m, _), (rows, columns)) = (a.shape(), b.shape());
        if rows != m {
            bail!(
                "{}: {rows} x {columns} where the {m} rows of {} need {m} rows",
                b.path().display(),
                a.path().display()
            );
        }
        Ok(Self { a, with: With::Columns(Box::new(b)), design: None })
    }

    /// Returns the rows of A with its columns in this order, a permutation.
    pub fn ordered(a: Source, order: Vec<usize>) -> Self {
        Self { a, with: With::Order(order), design: None }
    }

    /// Replaces the rows by those of a design, for the bounds of the rows that it does not leave
    /// out.
    pub fn designed(self, design: Design, bounds: &RowBounds<f64>) -> Result<Self> {
        let bounds = design.bounds(bounds)?;
        Ok(Self { design: Some((design, bounds)), ..self })
    }

    /// Returns the bounds of all rows, if they are known.
    pub fn bounds(&self) -> Option<&RowBounds<f64>> {
        self.design.as_ref().map(|(_, bounds)| bounds)
    }

    fn design(&self) -> Option<&Design> {
        self.design.as_ref().map(|(design, _)| design)
    }

    /// Returns A.
    pub fn a(&self) -> &Source {
        &self.a
    }

    /// Returns how many rows of A are packed together.
    pub fn chunk_rows(&self) -> usize {
        self.a.chunk_rows()
    }

    /// Returns the number of rows.
    pub fn nrows(&self) -> usize {
        let left_out = self.design().map_or(0, |design| design.left_out().len());
        self.all_rows() - left_out
    }

    /// Returns the number of rows of the files.
    pub fn all_rows(&self) -> usize {
        self.a.shape().0
    }

    /// Returns those of the numbers of all rows that belong to rows of the design.
    pub fn kept(&self, numbers: Vec<f64>) -> Result<Vec<f64>> {
        Ok(match self.design() {
            Some(design) => design.kept(&numbers)?,
            None => numbers,
        })
    }

    /// Returns the number of columns.
    pub fn ncols(&self) -> usize {
        self.design().map_or_else(|| self.all_columns(), Design::ncols)
    }

    /// Returns the number of entries of a row as it is added.
    pub fn width(&self) -> usize {
        let coding = self.design().and_then(Design::coding);
        coding.map_or_else(|| self.ncols(), |coding| coding.width())
    }

    /// Returns the number of columns of the files.
    fn all_columns(&self) -> usize {
        let more = match &self.with {
            With::Columns(b) => b.shape().1,
            With::Nothing | With::Order(_) => 0,
        };
        self.a.shape().1 + more
    }

    /// Returns the file of a column, and its name there.
    pub fn column(&self, j: usize) -> (&Path, String) {
        let n = self.a.shape().1;
        let j = self.design().map_or(j, |design| column_of(design, j));
        let (source, j) = match &self.with {
            With::Columns(b) if j >= n => (&**b, j - n),
            With::Order(order) => (&self.a, order[j]),
            With::Columns(_) | With::Nothing => (&self.a, j),
        };
        (source.path(), source.column_names().swap_remove(j))
    }

    /// Returns the names of the files, between commas.
    pub fn files(&self) -> String {
        let a = self.a.path().display();
        match &self.with {
            With::Columns(b) => format!("{a}, {}", b.path().display()),
            With::Nothing | With::Order(_) => a.to_string(),
        }
    }

    /// Refuses options of tables that apply neither to its files nor to weights.
    pub fn check_options(&self, weights: Option<&Path>, options: &ReadOptions<'_>) -> Result<()> {
        let b = match &self.with {
            With::Columns(b) => Some(&**b),
            With::Nothing | With::Order(_) => None,
        };
        check_options(&self.a, b, weights, options)
    }

    /// Returns texts that identify A and what is done with its rows.
    pub fn identity(&self) -> [String; 2] {
        let with = match &self.with {
            With::Nothing => "none".into(),
            With::Columns(b) => b.identity(),
            With::Order(order) => format!("columns in the order {order:?}"),
        };
        let with = match self.design() {
            None => with,
            Some(design) => format!("{with}, {}", about(design)),
        };
        [self.a.identity(), with]
    }

    /// Checks that all processes have opened or read the same files, and have the same design.
    ///
    /// # Errors
    /// A process has another one; the error names it, and what differs.
    pub fn check_same(&self, ranks: &Ranks) -> Result<()> {
        if ranks.size() == 1 {
            return Ok(());
        }
        let mut numbers: Vec<_> = self.a.facts().into();
        if let With::Columns(b) = &self.with {
            let names = ["the size of an entry of B", "the size of the file of B"];
            numbers.extend(names.into_iter().zip(b.facts().map(|(_, number)| number)));
        }
        if let Some(design) = self.design() {
            let hash = fingerprint_of_text(&about(design)) as usize;
            numbers.push(("the fingerprint of factors and of rows that are left out", hash));
        }
        let (all, mut same) = (RowList::from(0..self.nrows()), Ok(()));
        self.read(&all, false, |rows| {
            same = ranks.same_rows(rows, &numbers);
            Ok(())
        })?;
        ranks.meet(same.with_context(|| self.files()))
    }

    /// Calls `work` with some of the rows; `require_finite` refuses NaN and infinities, of which
    /// the rows of a design have none.
    pub fn read<R>(
        &self,
        list: &RowList,
        require_finite: bool,
        work: impl FnOnce(&mut (dyn RowBlocks<f64> + Send)) -> catamaran::Result<R>,
    ) -> Result<R> {
        let Some(design) = self.design() else { return self.read_all(list, require_finite, work) };
        self.read_all(&RowList::from(0..self.all_rows()), false, |table| {
            work(&mut Part { rows: Box::new(design.rows(table)?), list })
        })
    }

    /// Calls `work` as [`Table::read`] does, with the rows of the files.
    pub fn read_all<R>(
        &self,
        list: &RowList,
        require_finite: bool,
        work: impl FnOnce(&mut (dyn RowBlocks<f64> + Send)) -> catamaran::Result<R>,
    ) -> Result<R> {
        let part = |source| -> Result<_> {
            Ok(Part { rows: Source::rows::<f64>(source, require_finite)?, list })
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

/// Returns a short text that identifies a design, of which some have thousands of levels.
fn about(design: &Design) -> String {
    let left_out: Vec<f64> = design.left_out().iter().map(|&row| row as f64).collect();
    let (count, rows) = (left_out.len(), fingerprint(&left_out));
    let columns = fingerprint_of_text(&format!("{:?}", design.columns()));
    format!("without {count} rows ({rows:016x}), columns {columns:016x}")
}

/// Returns the column of the table that column j of the matrix comes from.
fn column_of(design: &Design, j: usize) -> usize {
    let sources = design.columns().iter().flat_map(|column| match column {
        DesignColumn::Indicators(from, factor) => vec![*from; factor.columns().len()],
        DesignColumn::Numbers(from) => vec![*from],
        _ => Vec::new(),
    });
    sources.into_iter().nth(j).unwrap_or(j)
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
