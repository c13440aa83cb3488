use std::ops::Range;

use faer::{MatMut, MatRef, c64};
use sprs::{CsMat, TriMat};

use super::columns::{ColumnNumbers, Columns};
use crate::base::{Real, Result, reserved};
use crate::rows::RowBlocks;

/// A matrix read from a file.
///
/// ```
/// use catamaran::io::{Matrix, ReadOptions, read};
///
/// # let folder = tempfile::tempdir().unwrap();
/// # let path = &folder.path().join("a.mtx");
/// let text = "%%MatrixMarket matrix coordinate real general\n2 2 1\n2 1 5.0\n";
/// std::fs::write(path, text).unwrap();
/// let Matrix::Sparse(a) = read(path, &ReadOptions::new())? else { panic!("dense") };
/// assert_eq!(a.get(1, 0), Some(&5.0));
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone)]
#[non_exhaustive]
pub enum Matrix {
    /// Dense, single precision.
    F32(Dense<f32>),
    /// Dense, double precision.
    F64(Dense<f64>),
    /// Dense, complex, double precision; also of a complex file of coordinates.
    Complex(Dense<c64>),
    /// Sparse by rows (CSR), double precision.
    Sparse(CsMat<f64>),
}

impl Matrix {
    /// Returns the number of rows.
    pub fn nrows(&self) -> usize {
        match self {
            Self::F32(dense) => dense.nrows,
            Self::F64(dense) => dense.nrows,
            Self::Complex(dense) => dense.nrows,
            Self::Sparse(sparse) => sparse.rows(),
        }
    }

    /// Returns the number of columns.
    pub fn ncols(&self) -> usize {
        match self {
            Self::F32(dense) => dense.columns.len(),
            Self::F64(dense) => dense.columns.len(),
            Self::Complex(dense) => dense.columns.len(),
            Self::Sparse(sparse) => sparse.cols(),
        }
    }
}

impl Matrix {
    /// Takes the columns from a matrix with all columns of its file, and returns their numbers.
    pub(super) fn choose(self, columns: &Columns) -> Result<(Self, ColumnNumbers)> {
        let chosen = Columns::numbers(columns.of(&[], self.ncols())?);
        self.select(&chosen)
    }

    /// Takes the columns of a list from a matrix with all columns of its file, and returns the
    /// numbers of the columns in the file.
    pub(super) fn select(self, columns: &Columns) -> Result<(Self, ColumnNumbers)> {
        if !columns.is_list() {
            return Ok((self, ColumnNumbers::From(columns.first())));
        }
        let chosen = columns.of(&[], self.ncols())?;
        let matrix = match self {
            Self::F32(dense) => Self::F32(dense.select(&chosen)?),
            Self::F64(dense) => Self::F64(dense.select(&chosen)?),
            Self::Complex(dense) => Self::Complex(dense.select(&chosen)?),
            Self::Sparse(sparse) => Self::Sparse(select_sparse(&sparse, &chosen)),
        };
        Ok((matrix, ColumnNumbers::List(chosen)))
    }
}

fn select_sparse(sparse: &CsMat<f64>, chosen: &[usize]) -> CsMat<f64> {
    let place = |column: usize| chosen.iter().position(|&other| other == column);
    let mut picked = TriMat::new((sparse.rows(), chosen.len()));
    for (&value, (i, j)) in sparse.iter() {
        if let Some(j) = place(j) {
            picked.add_triplet(i, j, value);
        }
    }
    picked.to_csr()
}

/// An owned dense matrix in the order its file had.
#[derive(Debug, Clone)]
pub struct Dense<T> {
    values: Vec<T>,
    nrows: usize,
    ncols: usize,
    row_major: bool,
    /// The columns that are part of the matrix.
    columns: Range<usize>,
}

impl<T> Dense<T> {
    /// Creates a matrix of `nrows * ncols` `values`, of which `columns` (in `0..ncols`) are kept.
    pub(super) fn new(
        values: Vec<T>,
        (nrows, ncols): (usize, usize),
        row_major: bool,
        columns: Range<usize>,
    ) -> Self {
        Self { values, nrows, ncols, row_major, columns }
    }

    /// Returns a matrix of some of the columns.
    fn select(&self, columns: &[usize]) -> Result<Self>
    where
        T: Copy,
    {
        let (all, nrows) = (self.as_ref(), self.nrows);
        let mut values = reserved(nrows.saturating_mul(columns.len()))?;
        for i in 0..nrows {
            values.extend(columns.iter().map(|&j| all[(i, j)]));
        }
        Ok(Self::new(values, (nrows, columns.len()), true, 0..columns.len()))
    }

    /// Returns a view of the matrix, without a copy.
    pub fn as_ref(&self) -> MatRef<'_, T> {
        let all = if self.row_major {
            MatRef::from_row_major_slice(&self.values, self.nrows, self.ncols)
        } else {
            MatRef::from_column_major_slice(&self.values, self.nrows, self.ncols)
        };
        all.subcols(self.columns.start, self.columns.len())
    }
}

/// The rows of a sparse matrix (CSR), filled up with zeros block by block.
///
/// ```
/// use catamaran::{rows::RowBlocks, faer::{Mat, mat}, io::{CsMat, SparseRows}};
///
/// let mut block = Mat::<f64>::zeros(2, 3);
/// SparseRows(&CsMat::eye(3)).read(1, block.as_mut())?;
/// assert_eq!(block, mat![[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct SparseRows<'a>(pub &'a CsMat<f64>);

impl<T: Real> RowBlocks<T> for SparseRows<'_> {
    fn nrows(&self) -> usize {
        self.0.rows()
    }

    fn ncols(&self) -> usize {
        self.0.cols()
    }

    fn read(&mut self, first: usize, mut out: MatMut<'_, T>) -> Result<()> {
        if out.ncols() == 0 {
            return Ok(());
        }
        for i in 0..out.nrows() {
            for j in 0..out.ncols() {
                out[(i, j)] = T::ZERO;
            }
            if let Some(row) = self.0.outer_view(first + i) {
                for (j, &value) in row.iter() {
                    out[(i, j)] = T::from_f64(value);
                }
            }
        }
        Ok(())
    }
}
