//! Exchanges matrices with contenders in other processes, in files of a folder.

use std::path::Path;

use catamaran::faer::{Mat, MatRef};
use catamaran::io::{Matrix, Output, Overwrite, ReadOptions, read, write};

use crate::Result;

/// Writes the matrix NAME of a folder, as .npy.
///
/// # Errors
/// The errors of the file.
pub fn put(folder: &Path, name: &str, matrix: MatRef<'_, f64>) -> Result<()> {
    let output = Output::create(&folder.join(format!("{name}.npy")), Overwrite::Replace)?;
    Ok(write(output, matrix)?)
}

/// Writes a column as [`put`] writes a matrix.
///
/// # Errors
/// The errors of the file.
pub fn put_vector(folder: &Path, name: &str, values: &[f64]) -> Result<()> {
    put(folder, name, MatRef::from_column_major_slice(values, values.len(), 1))
}

/// Reads the matrix NAME of a folder.
///
/// # Errors
/// The errors of the file, and when its numbers are not doubles.
pub fn get(folder: &Path, name: &str) -> Result<Mat<f64>> {
    match read(&folder.join(format!("{name}.npy")), &ReadOptions::default())? {
        Matrix::F64(dense) => Ok(dense.as_ref().to_owned()),
        _ => Err(format!("{name}: the numbers must be doubles").into()),
    }
}

/// Reads the first column of the matrix NAME of a folder.
///
/// # Errors
/// As [`get`].
pub fn get_vector(folder: &Path, name: &str) -> Result<Vec<f64>> {
    Ok(get(folder, name)?.col(0).iter().copied().collect())
}
