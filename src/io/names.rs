//! What the names of files say about their content.

use std::path::{Path, PathBuf};

use super::limits::SourceOptions;
use super::source::{Packing, Source, error};
use crate::base::{Error, Result};

/// The format of a file of one matrix.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum MatrixFormat {
    Npy,
    Mtx,
    /// A text table, and what a writer puts between its fields.
    Table(char),
}

/// The format of a file of one matrix that is read.
///
/// ```
/// use catamaran::io::{FileFormat, ReadOptions, read};
///
/// # let folder = tempfile::tempdir().unwrap();
/// # let path = &folder.path().join("a.dat");
/// std::fs::write(path, "1 2\n3 4\n").unwrap();
/// let options = ReadOptions::new().format(FileFormat::Table);
/// assert_eq!(read(path, &options)?.ncols(), 2);
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum FileFormat {
    /// An array of NumPy.
    Npy,
    /// MatrixMarket.
    Mtx,
    /// A text table.
    Table,
    /// Parquet (feature `columnar`).
    Parquet,
    /// A file of Arrow's IPC format, which is version 2 of Feather (feature `columnar`).
    Arrow,
}

/// The first bytes of files that are packed by what this library does not read, and its name.
static UNKNOWN_PACKINGS: [(&[u8], &str); 3] =
    [(b"\x28\xb5\x2f\xfd", "zstd"), (b"BZh", "bzip2"), (b"PK\x03\x04", "zip")];

/// Bytes that show what a file is.
const HEAD: usize = 1 << 10;

impl FileFormat {
    /// The names of the formats, for faces.
    pub const NAMES: [(&str, Self); 5] = [
        ("npy", Self::Npy),
        ("mtx", Self::Mtx),
        ("table", Self::Table),
        ("parquet", Self::Parquet),
        ("arrow", Self::Arrow),
    ];

    /// Returns whether columns are stored one after the other, with their names.
    pub(super) fn is_columnar(self) -> bool {
        matches!(self, Self::Parquet | Self::Arrow)
    }

    /// Returns the format and the packing that the name of a file ends in, if it is known.
    pub(super) fn of_name(path: &Path) -> Option<(Self, Packing)> {
        let name = lower_name(path);
        let (stem, packing) = Packing::of(&name);
        let format = match stem.rsplit_once('.').map(|(_, extension)| extension) {
            Some("npy") => Self::Npy,
            Some("mtx") => Self::Mtx,
            Some("csv" | "tsv" | "txt") => Self::Table,
            Some("parquet" | "pq") => Self::Parquet,
            Some("arrow" | "feather" | "ipc") => Self::Arrow,
            _ => return None,
        };
        Some((format, packing))
    }

    /// Opens a file, and returns its format: the one that is given, or else the one that its name
    /// ends in, or else that of its content. A name that ends in no packing leaves that to the
    /// content, too.
    pub(super) fn open<'a>(
        path: &Path,
        given: Option<Self>,
        options: &SourceOptions<'a>,
    ) -> Result<(Source<'a>, Self)> {
        let named = Self::of_name(path);
        let (_, packing) = Packing::of(&lower_name(path));
        let mut other = None;
        let of_content = |head: &[u8]| {
            other = UNKNOWN_PACKINGS.iter().find(|(magic, _)| head.starts_with(magic));
            match packing {
                Packing::None => Packing::of_content(head),
                packing => packing,
            }
        };
        let mut source = Source::open_packed(path, of_content, options)?;
        if let Some((_, name)) = other {
            return Err(source.fail(format!("packed by {name}: unpack it first")));
        }
        let format = match given.or(named.map(|(format, _)| format)) {
            Some(format) => format,
            None => {
                let head = source.peek(HEAD)?;
                let is_mtx = head.get(..MTX.len()).is_some_and(|s| s.eq_ignore_ascii_case(MTX));
                match &head[..] {
                    [0x93, b'N', b'U', b'M', b'P', b'Y', ..] => Self::Npy,
                    [b'P', b'A', b'R', b'1' | b'E', ..] => Self::Parquet,
                    [b'A', b'R', b'R', b'O', b'W', b'1', ..] | [b'F', b'E', b'A', b'1', ..] => {
                        Self::Arrow
                    }
                    _ if is_mtx => Self::Mtx,
                    _ => Self::Table,
                }
            }
        };
        Ok((source, format))
    }
}

/// How a MatrixMarket file begins.
const MTX: &[u8] = b"%%MatrixMarket";

impl MatrixFormat {
    /// Returns the format of a file, and whether it is gzipped.
    pub fn of(path: &Path) -> Result<(Self, bool)> {
        let name = lower_name(path);
        let stem = name.strip_suffix(".gz");
        let format = match stem.unwrap_or(&name).rsplit_once('.').map(|(_, extension)| extension) {
            Some("npy") => Self::Npy,
            Some("mtx") => Self::Mtx,
            Some("csv") => Self::Table(','),
            Some("tsv") => Self::Table('\t'),
            Some("txt") => Self::Table(' '),
            _ => {
                return Err(Error::file(
                    path,
                    "unknown kind of file: the name must end in .npy, .mtx, .csv, .tsv or .txt, \
                     and may have .gz after it",
                ));
            }
        };
        Ok((format, stem.is_some()))
    }
}

/// Returns the file and the name of the array in the name of a matrix, `FILE.npz:NAME`, whose name
/// of an array may be left out.
pub(super) fn npz_array(path: &Path) -> Option<(PathBuf, Option<&str>)> {
    if lower_name(path).ends_with(".npz") {
        return Some((path.into(), None));
    }
    let whole = path.to_str()?;
    let at = whole.to_ascii_lowercase().find(".npz:")? + ".npz".len();
    Some((whole[..at].into(), Some(&whole[at + 1..])))
}

/// The format of a file of several arrays.
pub(super) enum ArraysFormat {
    Npz,
    #[cfg(feature = "hdf5")]
    Hdf5,
}

impl ArraysFormat {
    pub fn of(path: &Path) -> Result<Self> {
        let name = lower_name(path);
        if name.ends_with(".npz") {
            return Ok(Self::Npz);
        }
        if !is_hdf5(&name) {
            return Err(error(path, None, "the name must end in .npz, .h5, .hdf5 or .he5"));
        }
        #[cfg(feature = "hdf5")]
        return Ok(Self::Hdf5);
        #[cfg(not(feature = "hdf5"))]
        Err(without_hdf5(path))
    }
}

/// The format of a file that is read by rows.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum RowsFormat {
    Npy,
    Hdf5 { path: PathBuf, dataset: Option<String> },
}

impl RowsFormat {
    pub fn of(name: &Path) -> Result<Self> {
        let fail = |what: &str| Err(error(name, None, what));
        let text = name.to_string_lossy().to_ascii_lowercase();
        // A name that is not text has no part for a dataset.
        if let Some(whole) = name.to_str() {
            let colon = text.match_indices(':').find(|&(at, _)| is_hdf5(&text[..at]));
            if let Some((at, _)) = colon {
                let dataset = Some(whole[at + 1..].into());
                return Ok(Self::Hdf5 { path: whole[..at].into(), dataset });
            }
        }
        if is_hdf5(&text) {
            return Ok(Self::Hdf5 { path: name.into(), dataset: None });
        }
        if text.ends_with(".npy") {
            return Ok(Self::Npy);
        }
        if text.ends_with(".npy.gz") {
            return fail("gzipped, so rows can't be read from its middle: unpack it first");
        }
        fail(
            "unknown kind of file for reading by rows: the name must end in .npy, .h5, .hdf5 or \
             .he5, and the last three may have :/path/to/dataset after it",
        )
    }
}

/// Returns the error for an HDF5 file in a program without the feature.
#[cfg(not(feature = "hdf5"))]
pub(super) fn without_hdf5(path: &Path) -> Error {
    error(path, None, "HDF5 is not part of this program: build it with --features hdf5")
}

/// Returns the error for a columnar file in a program without the feature.
#[cfg(not(feature = "columnar"))]
pub(super) fn without_columnar(path: &Path) -> Error {
    let what = "Parquet and Arrow files are not part of this program: build it with --features \
                columnar";
    error(path, None, what)
}

/// Returns the name of a file without its folder, in lower case.
fn lower_name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().to_ascii_lowercase()
}

fn is_hdf5(name: &str) -> bool {
    [".h5", ".hdf5", ".he5"].iter().any(|end| name.ends_with(end))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_in_any_case_end_in_the_format_of_a_matrix() {
        let of = |name: &str| MatrixFormat::of(Path::new(name)).ok();
        assert_eq!(of("d.csv/A.NPY"), Some((MatrixFormat::Npy, false)));
        assert_eq!(of("a.mtx.GZ"), Some((MatrixFormat::Mtx, true)));
        let separators = ["a.csv", "a.tsv.gz", "a.b.Txt"].map(|name| of(name).map(|(f, _)| f));
        assert_eq!(separators, [',', '\t', ' '].map(|c| Some(MatrixFormat::Table(c))));
        for name in ["csv", "a.gz", "a.csv.xz", "a.npz", "a.csv/b"] {
            assert_eq!(of(name), None, "{name}");
        }
    }
}
