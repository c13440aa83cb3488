//! Several arrays in one file, as `numpy.load` reads them: NumPy `.npz`, a zip archive of `.npy` files, not packed.

use std::io::{self, Write};

use faer::MatRef;
use npyz::WriterBuilder;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

use super::{Output, npy};
use crate::base::Result;

/// An array of a file of several.
#[derive(Debug, Clone, Copy)]
pub enum Array<'a> {
    /// One dimension, f8.
    Vector(&'a [f64]),
    /// One dimension, u8: unsigned integers of 64 bits.
    Indices(&'a [usize]),
    /// Two dimensions in C order, f8.
    Matrix(MatRef<'a, f64>),
}

/// Writes named arrays into `output` and lets it appear.
///
/// # Errors
/// [`Error::Io`](crate::Error::Io); nothing is left behind then.
pub fn write_npz(mut output: Output, arrays: &[(&str, Array<'_>)]) -> Result<()> {
    let written = write_archive(&mut output, arrays);
    written.map_err(|e| output.error(&e))?;
    output.commit()
}

fn write_archive(output: &mut Output, arrays: &[(&str, Array<'_>)]) -> io::Result<()> {
    let mut archive = ZipWriter::new(output);
    // Sizes are known only when all is written.
    let options =
        SimpleFileOptions::default().compression_method(CompressionMethod::Stored).large_file(true);
    for (name, array) in arrays {
        archive.start_file(format!("{name}.npy"), options)?;
        match array {
            Array::Vector(values) => {
                vector_header::<f64>(&mut archive, values.len())?;
                for value in *values {
                    archive.write_all(&value.to_ne_bytes())?;
                }
            }
            Array::Indices(values) => {
                vector_header::<u64>(&mut archive, values.len())?;
                for &value in *values {
                    archive.write_all(&(value as u64).to_ne_bytes())?;
                }
            }
            Array::Matrix(matrix) => npy::write(&mut archive, *matrix)?,
        }
    }
    archive.finish()?;
    Ok(())
}

/// The header of a vector; default_dtype is in the order of the machine.
fn vector_header<T: npyz::AutoSerialize>(sink: &mut dyn Write, len: usize) -> io::Result<()> {
    npyz::WriteOptions::new_header_only()
        .dtype(T::default_dtype())
        .shape(&[len as u64])
        .writer(sink)
        .write_header_only()
        .map(drop)
}

#[cfg(test)]
mod tests {
    use std::io::Read;

    use faer::mat;

    use super::*;
    use crate::io::Overwrite;

    #[test]
    fn arrays_come_back_under_their_names() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.npz");
        let matrix = mat![[1.0, 2.5], [3.0, -4.0], [0.0, 1e300]];
        let arrays = [
            ("values", Array::Vector(&[0.5, f64::INFINITY])),
            ("kept", Array::Indices(&[0, 7, usize::MAX])),
            ("none", Array::Vector(&[])),
            ("matrix", Array::Matrix(matrix.as_ref())),
        ];
        write_npz(Output::create(&path, Overwrite::Never).unwrap(), &arrays).unwrap();
        let mut archive = zip::ZipArchive::new(std::fs::File::open(&path).unwrap()).unwrap();
        let mut read = |name: &str| {
            let mut bytes = Vec::new();
            archive.by_name(name).unwrap().read_to_end(&mut bytes).unwrap();
            bytes
        };
        let (values, none, all) = (read("values.npy"), read("none.npy"), read("matrix.npy"));
        let kept = read("kept.npy");
        let open = |bytes| npyz::NpyFile::new(io::Cursor::new(bytes)).unwrap();
        assert_eq!(open(values).into_vec::<f64>().unwrap(), [0.5, f64::INFINITY]);
        assert_eq!(open(kept).into_vec::<u64>().unwrap(), [0, 7, u64::MAX]);
        assert_eq!(open(none).shape(), [0]);
        let file = open(all);
        assert_eq!(file.shape(), [3, 2]);
        assert_eq!(file.into_vec::<f64>().unwrap(), [1.0, 2.5, 3.0, -4.0, 0.0, 1e300]);
    }
}
