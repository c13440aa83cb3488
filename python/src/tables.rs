//! Files of matrices, text tables among them.

use std::path::PathBuf;

use catamaran::faer::Mat;
use catamaran::io::{
    ColumnKind, Columns, FileFormat, Matrix, Missing, ReadOptions, Separator, TableOptions, Words,
    read_file,
};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::array::from_matrix;
use crate::error::refused;
use crate::options::{Threads, arguments, par, word};
use crate::sparse::parts;
use crate::task::{Length, run};

/// The columns that are read.
#[derive(FromPyObject)]
enum Chosen {
    /// As the command line takes them.
    Text(String),
    /// Names, and numbers as text.
    List(Vec<String>),
}

arguments! {
    /// How a file is read, as a dictionary.
    pub struct TableArguments {
        columns: Option<Chosen>,
        separator: Option<char>,
        decimal: Option<char>,
        thousands: Option<char>,
        header: Option<bool>,
        skip: usize,
        comment: Option<char>,
        missing: String,
        missing_words: Option<Vec<String>>,
        index: Option<bool>,
        encoding: Option<String>,
        format: Option<String>,
        /// Whether all columns of words are factors.
        words: bool,
        /// Names, and numbers as text.
        factors: Vec<String>,
        max_memory: Option<u64>,
        /// All cores by default.
        threads: Threads,
    }
}

impl TableArguments {
    fn options(self) -> PyResult<ReadOptions<'static>> {
        let table = TableOptions::new()
            .separator(self.separator.map(Separator::from))
            .decimal(self.decimal)
            .thousands(self.thousands)
            .header(self.header)
            .skip(self.skip)
            .comment(self.comment)
            .missing(word("missing", &self.missing, &Missing::NAMES)?)
            .missing_words(self.missing_words)
            .index(self.index)
            .encoding(self.encoding)
            .words(if self.words { Words::Factor } else { Words::LeaveOut })
            .factors(self.factors)
            .par(par(self.threads)?);
        let columns = match self.columns {
            None => Columns::ALL,
            Some(Chosen::Text(text)) => Columns::parse(&text),
            Some(Chosen::List(items)) => Columns::list(items),
        };
        let format = match &self.format {
            Some(name) => Some(word("format", name, &FileFormat::NAMES)?),
            None => None,
        };
        Ok(ReadOptions::new()
            .columns(columns)
            .format(format)
            .table(table)
            .max_memory(self.max_memory))
    }
}

/// Returns a dictionary of the matrix and what is known about its columns; see `catamaran.read`.
#[pyfunction]
#[pyo3(signature = (path, options, progress))]
pub fn read<'py>(
    py: Python<'py>,
    path: PathBuf,
    options: TableArguments,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let options = options.options()?;
    let content = run(py, Length::Long, progress, move |progress| {
        read_file(&path, &options.progress(progress))
    })?;
    let found = PyDict::new(py);
    let numbers: Vec<usize> = match content.matrix {
        Matrix::Sparse(_) => Vec::new(),
        _ => (0..content.matrix.ncols()).map(|j| content.number(j)).collect(),
    };
    found.set_item("names", &content.names)?;
    found.set_item("numbers", numbers)?;
    let levels = PyDict::new(py);
    if let Some(reading) = &content.reading {
        for (j, column) in reading.columns.iter().enumerate() {
            if let ColumnKind::Factor { levels: words } = &column.kind {
                levels.set_item(j, words)?;
            }
        }
        found.set_item("left_out", &reading.left_out)?;
        found.set_item("dropped_rows", reading.dropped_rows)?;
        found.set_item("reading", reading.to_string())?;
        found.set_item("is_plain", reading.is_plain())?;
    }
    if let Some(rounded) = &content.rounded {
        found.set_item("reading", rounded.to_string())?;
        found.set_item("is_plain", false)?;
    }
    found.set_item("levels", levels)?;
    match content.matrix {
        Matrix::F64(dense) => found.set_item("values", from_matrix(py, dense.as_ref())?)?,
        Matrix::F32(dense) => {
            let a = dense.as_ref();
            let a = Mat::from_fn(a.nrows(), a.ncols(), |i, j| f64::from(a[(i, j)]));
            found.set_item("values", from_matrix(py, a.as_ref())?)?;
        }
        Matrix::Complex(dense) => {
            let (a, (m, n)) = (dense.as_ref(), dense.as_ref().shape());
            let real = Mat::from_fn(m, n, |i, j| a[(i, j)].re);
            let imaginary = Mat::from_fn(m, n, |i, j| a[(i, j)].im);
            found.set_item("values", from_matrix(py, real.as_ref())?)?;
            found.set_item("imaginary", from_matrix(py, imaginary.as_ref())?)?;
        }
        Matrix::Sparse(sparse) => found.set_item("sparse", parts(py, sparse))?,
        _ => return Err(refused("path", "another kind of matrix")),
    }
    Ok(found)
}
