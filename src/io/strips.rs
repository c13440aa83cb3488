use std::io::{self, Seek, SeekFrom, Write};
use std::path::Path;

use super::names::MatrixFormat;
use super::npy::{encode, write_header};
use super::output::Output;
use crate::base::{Error, Real, Result};
use crate::product::Uplo;
use crate::rows::Strip;

/// Writes a symmetric n x n matrix into a `.npy` file, strip by strip, because it is too large for
/// memory.
///
/// ```
/// use catamaran::rows::{Accumulator, DenseRows, stream};
/// use catamaran::io::{Matrix, Output, Overwrite, ReadOptions, StripOutput, read};
/// use catamaran::{AtaOptions, Uplo, faer::Mat};
///
/// # let folder = tempfile::tempdir().unwrap();
/// # let path = &folder.path().join("c.npy");
/// let a = Mat::<f64>::from_fn(10, 4, |i, j| (i * j % 3) as f64);
/// let output = Output::create(path, Overwrite::Never)?;
/// let mut output = StripOutput::new::<f64>(output, 4, Uplo::Both)?;
/// for rows in [0..3, 3..4] {
///     let mut sum = Accumulator::<f64>::of_strip(4, rows, false)?;
///     let (rows, options) = (&mut DenseRows(a.as_ref()), AtaOptions::new());
///     stream(rows, None, 64, &mut sum, &options, &mut |_| Ok(()))?;
///     output.write(&sum.finish(1.0, Uplo::Lower)?)?;
/// }
/// output.commit()?;
/// let Matrix::F64(c) = read(path, &ReadOptions::new())? else { panic!() };
/// assert_eq!(c.as_ref(), a.transpose() * &a);
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug)]
pub struct StripOutput {
    output: Output,
    n: usize,
    uplo: Uplo,
    /// Bytes before the first entry.
    offset: u64,
}

impl StripOutput {
    /// Starts the file of a matrix of entries T, of which the triangle or triangles of `uplo` are
    /// written, and the rest is zero.
    ///
    /// # Errors
    /// [`Error::Io`] for a name that does not end in `.npy`, and when it can't be written.
    pub fn new<T: Real>(mut output: Output, n: usize, uplo: Uplo) -> Result<Self> {
        check_strip_name(output.path())?;
        let start = write_header::<T>(&mut output, n, n).and_then(|()| {
            let offset = output.stream_position()?;
            let entries = (n as u64).checked_mul(n as u64);
            let bytes = entries.and_then(|e| e.checked_mul(size_of::<T>() as u64));
            let end = bytes.and_then(|bytes| bytes.checked_add(offset));
            output.set_len(end.ok_or_else(|| io::Error::other("too large for a file"))?)?;
            Ok(offset)
        });
        let offset = start.map_err(|e| output.error(e))?;
        Ok(Self { output, n, uplo, offset })
    }

    /// Writes a strip of the lower triangle and, if `uplo` wants it, the mirror image above the
    /// diagonal. T must be the type that the file was started for.
    ///
    /// # Errors
    /// [`Error::Shape`] when the strip is not of an n x n matrix, [`Error::Io`].
    pub fn write<T: Real>(&mut self, strip: &Strip<T>) -> Result<()> {
        let (rows, c) = (strip.rows(), strip.as_ref());
        if rows.end > self.n {
            return Err(Error::Shape { what: "strip", expected: (self.n, self.n), got: c.shape() });
        }
        let mut bytes = Vec::new();
        if self.uplo != Uplo::Upper {
            for i in rows.clone() {
                bytes.clear();
                encode((0..=i).map(|j| c[(i - rows.start, j)]), &mut bytes);
                self.put::<T>(i, 0, &bytes)?;
            }
        }
        if self.uplo != Uplo::Lower {
            for j in 0..rows.end {
                let first = rows.start.max(j);
                bytes.clear();
                encode((first..rows.end).map(|i| c[(i - rows.start, j)]), &mut bytes);
                self.put::<T>(j, first, &bytes)?;
            }
        }
        Ok(())
    }

    /// Writes the bytes of entries into row `i` of the file, from column `j` on.
    fn put<T: Real>(&mut self, i: usize, j: usize, bytes: &[u8]) -> Result<()> {
        let at = self.offset + (i as u64 * self.n as u64 + j as u64) * size_of::<T>() as u64;
        let done = self.output.seek(SeekFrom::Start(at)).and_then(|_| self.output.write_all(bytes));
        done.map_err(|e| self.output.error(e))
    }

    /// Lets the file appear, as [`Output::commit`] does.
    ///
    /// # Errors
    /// [`Error::Io`]; no file is left behind then.
    pub fn commit(self) -> Result<()> {
        self.output.commit()
    }
}

fn check_strip_name(path: &Path) -> Result<()> {
    if MatrixFormat::of(path)? == (MatrixFormat::Npy, false) {
        return Ok(());
    }
    let what = "a matrix larger than memory can only be written to a .npy file";
    Err(super::source::error(path, None, what))
}
