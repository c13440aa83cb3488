//! Our side: runs a task once, in a separate process.

use std::path::Path;
use std::time::Instant;

use catamaran::faer::{Mat, MatRef};
use catamaran::io::{Dense, Matrix, ReadOptions, RowFile, read};
use catamaran::rows::{Center, DenseRows, ExtendedGram, RowOptions, ata_extended};
use catamaran::solve::{
    GramQr, LeastSquaresOptions, PrincipalComponents, PrincipalComponentsOptions, lstsq,
    singular_values,
};
use catamaran::{AtaOptions, Par, SchemeChoice, ata_into};
use clap::ValueEnum;

use crate::Result;
use crate::child::{self, Report};
use crate::exchange::{get, get_vector, put, put_vector};

/// A task in a folder, the same as that of bench/rivals/gram.py with this name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Task {
    /// Solves each NAME-a, NAME-b.
    Digits,
    /// Solves a, b.
    Lstsq,
    /// Singular values of a.
    Sigma,
    /// Explained variances of the file a.npy.
    Pca,
    /// An orthonormal basis of the columns of a.
    Qr,
}

impl Task {
    /// Returns the name of the task in bench/rivals/gram.py.
    pub fn name(self) -> &'static str {
        match self {
            Self::Digits => "digits",
            Self::Lstsq => "lstsq",
            Self::Sigma => "sigma",
            Self::Pca => "pca",
            Self::Qr => "qr",
        }
    }
}

/// Runs a task, writes its result into the folder, and returns the line that [`child::run`] reads.
///
/// # Errors
/// The errors of the files, and of the library.
pub fn run(task: Task, folder: &Path, threads: usize) -> Result<String> {
    let par = Par::Threads(threads);
    match task {
        Task::Digits => digits(folder, par),
        Task::Lstsq => {
            let (a, b) = (by_rows(folder, "a")?, get_vector(folder, "b")?);
            let (x, line) = measured(|| least_squares(a.as_ref(), &b, par))?;
            put_vector(folder, "x-ours", &x)?;
            Ok(line)
        }
        Task::Sigma => {
            let a = by_rows(folder, "a")?;
            let (values, line) = measured(|| Ok(singular_values(a.as_ref(), par)?.values))?;
            put_vector(folder, "sigma-ours", &values)?;
            Ok(line)
        }
        Task::Pca => {
            let (values, line) = measured(|| explained_variances(&folder.join("a.npy"), par))?;
            put_vector(folder, "variances-ours", &values)?;
            Ok(line)
        }
        Task::Qr => {
            let mut a = get(folder, "a")?;
            let (q, line) = measured(|| orthonormal_basis(&mut a, par))?;
            put(folder, "q-ours", q)?;
            Ok(line)
        }
    }
}

/// Returns the result of a call, and its report.
fn measured<T>(call: impl FnOnce() -> Result<T>) -> Result<(T, String)> {
    child::forget_peak();
    let [before, _] = child::memory();
    let start = Instant::now();
    let result = call()?;
    let seconds = start.elapsed().as_secs_f64();
    let [_, peak] = child::memory();
    Ok((result, Report::line(seconds, peak.saturating_sub(before), &[])))
}

fn digits(folder: &Path, par: Par) -> Result<String> {
    let mut names: Vec<String> = Vec::new();
    for entry in std::fs::read_dir(folder)? {
        let name = entry?.file_name().to_string_lossy().into_owned();
        names.extend(name.strip_suffix("-a.npy").map(str::to_owned));
    }
    let solve = || -> Result<()> {
        for name in &names {
            let a = get(folder, &format!("{name}-a"))?;
            let b = get_vector(folder, &format!("{name}-b"))?;
            put_vector(folder, &format!("{name}-ours"), &least_squares(a.as_ref(), &b, par)?)?;
        }
        Ok(())
    };
    Ok(measured(solve)?.1)
}

/// Reads the matrix NAME of a folder by rows, as numpy does.
fn by_rows(folder: &Path, name: &str) -> Result<Dense<f64>> {
    match read(&folder.join(format!("{name}.npy")), &ReadOptions::default())? {
        Matrix::F64(dense) => Ok(dense),
        _ => Err(format!("{name}: the numbers must be doubles").into()),
    }
}

/// Returns the x that minimizes `|A x - b|`.
fn least_squares(a: MatRef<'_, f64>, b: &[f64], par: Par) -> Result<Vec<f64>> {
    // The rivals compute no standard errors.
    let options = LeastSquaresOptions::new().standard_errors(false).par(par);
    let b = MatRef::from_column_major_slice(b, b.len(), 1);
    let found = lstsq(a, b, None, &options)?;
    Ok(found.coefficients.col(0).iter().copied().collect())
}

/// Returns the Gram matrix of A in extended precision.
fn extended(a: MatRef<'_, f64>, par: Par) -> Result<ExtendedGram> {
    let options = AtaOptions::new().par(par);
    Ok(ata_extended(&mut DenseRows(a), &RowOptions::<f64>::new(), &options)?)
}

/// Returns the eigenvalues of the covariance of the rows of a file, the largest first.
fn explained_variances(file: &Path, par: Par) -> Result<Vec<f64>> {
    let about_mean = RowOptions::<f64>::new().center(Center::Mean);
    let options = AtaOptions::new().par(par);
    let gram = ata_extended(&mut RowFile::open(file)?, &about_mean, &options)?;
    let options = PrincipalComponentsOptions::new().par(par);
    Ok(PrincipalComponents::from_gram(&gram, &options)?.explained_variance)
}

/// Computes an orthonormal basis of the columns of A in the memory of A.
fn orthonormal_basis(a: &mut Mat<f64>, par: Par) -> Result<MatRef<'_, f64>> {
    GramQr::from_gram(&extended(a.as_ref(), par)?, par)?.apply(a.as_mut(), par)?;
    Ok(a.as_ref())
}

/// Computes the lower triangle of A^T A by the exact path with its default accuracy.
pub(super) fn exact_gram(a: MatRef<'_, f64>, threads: usize) -> Result<()> {
    let mut c = Mat::zeros(a.ncols(), a.ncols());
    let options = AtaOptions::new().scheme(SchemeChoice::Exact).threads(threads);
    Ok(ata_into(1.0, a, 0.0, c.as_mut(), &options)?)
}

/// Computes A^T A in extended precision.
pub(super) fn extended_gram(a: MatRef<'_, f64>, threads: usize) -> Result<()> {
    extended(a, Par::Threads(threads)).map(drop)
}
