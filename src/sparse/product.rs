use faer::prelude::ReborrowMut;
use faer::{MatMut, MatRef};
use sprs::CsMatView;

use crate::base::{Error, Par, Result, count};
use crate::dense::{ROW_BLOCK, for_row_blocks};

/// Computes `Y := A X` for a sparse A (n x m, by rows), X (m x c) and Y (n x c) of any strides.
/// Blocks of rows make the result the same, bit for bit, for every `par`.
///
/// ```
/// use catamaran::{Par, faer::{Mat, mat}, sparse::{CsMat, multiply}};
///
/// let (x, mut y) = (mat![[1.0], [2.0], [3.0]], Mat::zeros(3, 1));
/// multiply(CsMat::eye(3).view(), x.as_ref(), y.as_mut(), Par::Seq)?;
/// assert_eq!(x, y);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Argument`] when A is stored by columns, [`Error::Shape`].
pub fn multiply(
    a: CsMatView<'_, f64>,
    x: MatRef<'_, f64>,
    y: MatMut<'_, f64>,
    par: Par,
) -> Result<()> {
    if !a.is_csr() {
        return Err(Error::Argument { what: "A", why: "must be stored by rows".into() });
    }
    Error::check_shape("X", (a.cols(), x.ncols()), x.shape())?;
    Error::check_shape("Y", (a.rows(), x.ncols()), y.shape())?;
    multiply_symmetric_or_rows(a, x, y, par);
    Ok(())
}

/// Computes [`multiply`] by the rows that A is stored in, or by the columns of a symmetric A.
pub(crate) fn multiply_symmetric_or_rows(
    a: CsMatView<'_, f64>,
    x: MatRef<'_, f64>,
    y: MatMut<'_, f64>,
    par: Par,
) {
    count(2.0 * a.nnz() as f64 * x.ncols() as f64);
    for_row_blocks(y, ROW_BLOCK, par, |first, mut y| {
        // The rows of a block stay in the cache from one column to the next.
        for j in 0..x.ncols() {
            let (x, mut y) = (x.col(j), y.rb_mut().col_mut(j));
            let contiguous = x.try_as_col_major().map(|x| x.as_slice());
            for i in 0..y.nrows() {
                let row = a.outer_view(first + i).expect("as many rows as Y has");
                let entries = row.indices().iter().zip(row.data());
                y[i] = match contiguous {
                    Some(x) => entries.map(|(&j, a)| a * x[j]).sum(),
                    None => entries.map(|(&j, a)| a * x[j]).sum(),
                };
            }
        }
    });
}

/// Returns the sum of these entries of a row, or zero where the sum is only rounding.
pub(crate) fn row_sum(entries: &[f64]) -> f64 {
    /// Relative to the sum of magnitudes.
    const ROUNDING: f64 = 1e-12;
    let (sum, magnitude) =
        entries.iter().fold((0.0, 0.0), |(sum, magnitude), x| (sum + x, magnitude + x.abs()));
    if f64::abs(sum) > ROUNDING * magnitude { sum } else { 0.0 }
}

/// Computes `Y := A X` for a symmetric A, as `sum of a_ij (x_j - x_i) + (sum of a_ij) x_i`: exact
/// for the constants that a Laplacian with huge weights maps to zero. A may also be some rows of
/// such a matrix, with the columns of these rows first.
pub(crate) fn multiply_by_differences(
    a: CsMatView<'_, f64>,
    x: MatRef<'_, f64>,
    y: MatMut<'_, f64>,
    par: Par,
) {
    count(3.0 * a.nnz() as f64 * x.ncols() as f64);
    for_row_blocks(y, ROW_BLOCK, par, |first, mut y| {
        for i in 0..y.nrows() {
            let row = a.outer_view(first + i).expect("as many rows as Y has");
            let sum = row_sum(row.data());
            for j in 0..x.ncols() {
                let own = x[(first + i, j)];
                let differences = row.iter().map(|(l, a)| a * (x[(l, j)] - own)).sum::<f64>();
                y[(i, j)] = differences + sum * own;
            }
        }
    });
}

/// Computes `Y := |A| |X|` for a symmetric A, or for rows.
pub(crate) fn multiply_magnitudes(
    a: CsMatView<'_, f64>,
    x: MatRef<'_, f64>,
    mut y: MatMut<'_, f64>,
) {
    count(2.0 * a.nnz() as f64 * x.ncols() as f64);
    for (i, row) in a.outer_iterator().enumerate() {
        for j in 0..x.ncols() {
            y[(i, j)] = row.iter().map(|(l, a)| (a * x[(l, j)]).abs()).sum();
        }
    }
}
