//! What the names of files say about their content.

use std::path::{Path, PathBuf};

use super::source::error;
use crate::base::{Error, Result};

/// The format of a file of one matrix.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum MatrixFormat {
    Npy,
    Mtx,
    /// A text table, and what a writer puts between its fields.
    Table(char),
}

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
