//! The probabilistic check of a product of rows.

use faer::{MatMut, MatRef};

use super::ata::{AdjustedRows, RowOptions};
use super::source::RowBlocks;
use crate::base::{Real, Result};
use crate::product::{Uplo, Verification, check_blocks};

/// Checks `C = alpha X^T W X` of [`ata_rows`](super::ata_rows) as
/// [`verify`](crate::product::verify()) does.
///
/// ```
/// use catamaran::rows::{Center, DenseRows, RowOptions, ata_rows, verify_rows};
/// use catamaran::{AtaOptions, Uplo, faer::Mat};
///
/// let a = Mat::<f64>::from_fn(50, 8, |i, j| ((3 * i + j) % 7) as f64);
/// let (mut rows, about_mean) = (DenseRows(a.as_ref()), RowOptions::new().center(Center::Mean));
/// let mut c = Mat::zeros(8, 8);
/// ata_rows(1.0, &mut rows, &about_mean, 0.0, c.as_mut(), &AtaOptions::new())?;
/// assert!(verify_rows(1.0, &mut rows, &about_mean, c.as_ref(), Uplo::Lower, 20, 0)?.passed);
/// // It is not the product without the mean.
/// let plain = RowOptions::new();
/// assert!(!verify_rows(1.0, &mut rows, &plain, c.as_ref(), Uplo::Lower, 20, 0)?.passed);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// As [`verify`](crate::product::verify()), where A is X, and [`ata_rows`](super::ata_rows).
pub fn verify_rows<T: Real>(
    alpha: f64,
    rows: &mut dyn RowBlocks<f64>,
    row_options: &RowOptions<'_, f64>,
    c: MatRef<'_, T>,
    uplo: Uplo,
    rounds: u32,
    seed: u64,
) -> Result<Verification> {
    let (shape, weights) = ((rows.nrows(), rows.ncols()), row_options.weights);
    let mut adjusted = AdjustedRows::new(rows, row_options)?;
    let read = |first, block: MatMut<'_, f64>| adjusted.read(first, block);
    check_blocks(alpha, shape, read, weights, c, uplo, rounds, seed)
}
