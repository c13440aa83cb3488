//! Accumulators in files.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use super::Output;
use super::source::error_at;
use crate::base::Result;
use crate::blas::BlasReal;
use crate::rows::{Accumulator, labels_of, scalar_of};

const BUFFER: usize = 1 << 20;

/// Writes an accumulator into `output` and lets it appear.
///
/// ```
/// use catamaran::{AtaOptions, Uplo, rows::Accumulator, faer::mat};
/// use catamaran::io::{Output, Overwrite, accumulator_scalar};
/// use catamaran::io::{read_accumulator, write_accumulator};
///
/// # let folder = tempfile::tempdir().unwrap();
/// # let path = &folder.path().join("sum.acc");
/// let (mut sum, options) = (Accumulator::<f64>::new(2, false)?, AtaOptions::new());
/// sum.add_block(mat![[1.0, 2.0]], None, &options)?;
/// write_accumulator(Output::create(path, Overwrite::Never)?, &sum)?;
///
/// assert_eq!(accumulator_scalar(path)?, "f64");
/// let mut sum = read_accumulator::<f64>(path)?;
/// sum.add_block(mat![[3.0, 4.0]], None, &options)?;
/// assert_eq!(sum.finish(1.0, Uplo::Lower)?.as_ref()[(1, 0)], 14.0);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Io`](crate::Error::Io); in that case no file is left behind, and a file that was to be
/// replaced stays.
pub fn write_accumulator<T: BlasReal>(
    mut output: Output,
    accumulator: &Accumulator<T>,
) -> Result<()> {
    accumulator.write(&mut output).map_err(|e| output.error(e))?;
    output.commit()
}

/// Reads the accumulator of scalars T in the file at `path`.
///
/// ```
/// use catamaran::rows::Accumulator;
/// use catamaran::io::{Output, Overwrite, read_accumulator, write_accumulator};
///
/// # let folder = tempfile::tempdir().unwrap();
/// # let path = &folder.path().join("sum.acc");
/// let sum = Accumulator::<f64>::new(3, false)?;
/// write_accumulator(Output::create(path, Overwrite::Never)?, &sum)?;
/// assert_eq!(read_accumulator::<f64>(path)?.ncols(), 3);
/// assert!(read_accumulator::<f32>(path).is_err());
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Io`](crate::Error::Io): no such file, or not a whole and undamaged accumulator of T;
/// [`Error::OutOfMemory`](crate::Error::OutOfMemory).
pub fn read_accumulator<T: BlasReal>(path: &Path) -> Result<Accumulator<T>> {
    let mut source = open(path)?;
    let read = source.get_ref().metadata().and_then(|about| {
        // A pipe has no length.
        let bytes = if about.is_file() { about.len() } else { u64::MAX };
        Accumulator::read_within(&mut source, bytes)
    });
    read.map_err(|e| error_at(path, None, e))
}

/// Returns the scalar of the accumulator in the file at `path`: `"f32"` or `"f64"`.
///
/// ```
/// use catamaran::rows::Accumulator;
/// use catamaran::io::{Output, Overwrite, accumulator_scalar, write_accumulator};
///
/// # let folder = tempfile::tempdir().unwrap();
/// # let path = &folder.path().join("sum.acc");
/// let sum = Accumulator::<f32>::new(3, false)?;
/// write_accumulator(Output::create(path, Overwrite::Never)?, &sum)?;
/// assert_eq!(accumulator_scalar(path)?, "f32");
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Io`](crate::Error::Io): no such file, or not an accumulator.
pub fn accumulator_scalar(path: &Path) -> Result<&'static str> {
    scalar_of(&mut open(path)?).map_err(|e| error_at(path, None, e))
}

/// Returns the number of rows in the accumulator in the file at `path`, and its labels, which are
/// at the start of the file.
///
/// Public for the command line, which looks for the checkpoints of a run.
///
/// # Errors
/// As [`accumulator_scalar`].
#[doc(hidden)]
pub fn accumulator_labels(path: &Path) -> Result<(u64, Vec<(String, String)>)> {
    labels_of(&mut open(path)?).map_err(|e| error_at(path, None, e))
}

fn open(path: &Path) -> Result<BufReader<File>> {
    let file = File::open(path).map_err(|e| error_at(path, None, e))?;
    Ok(BufReader::with_capacity(BUFFER, file))
}
