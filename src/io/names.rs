//! What the names of files say about their content.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use super::limits::SourceOptions;
use super::packing::Packing;
use super::source::{Source, error};
use crate::base::{Error, Result};

/// The format of a file of one matrix.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum MatrixFormat {
    Npy,
    Mtx,
    /// A text table, and what a writer puts between its fields.
    Table(char),
    #[cfg(feature = "hdf5")]
    Hdf5,
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
    /// ends in, or else that of its content; also that of a binary file with the name of a text.
    pub(super) fn open<'a>(
        path: &Path,
        given: Option<Self>,
        options: &SourceOptions<'a>,
    ) -> Result<(Source<'a>, Self)> {
        let named = Self::of_name(path);
        let (_, packing) = Packing::of(&lower_name(path));
        let mut source = Source::open(path, packing, options)?;
        let named = named.map(|(format, _)| format);
        let format = match given.or(named.filter(|format| *format != Self::Table)) {
            Some(format) => format,
            None => {
                let head = source.peek(HEAD)?;
                // The first letters of a header may be those of another format.
                let is_text = named.is_some() && head.iter().all(|byte| *byte >= b'\t');
                match &head[..] {
                    head if begins_mtx(head) => Self::Mtx,
                    _ if is_text => Self::Table,
                    [0x93, b'N', b'U', b'M', b'P', b'Y', ..] => Self::Npy,
                    [b'P', b'A', b'R', b'1' | b'E', ..] => Self::Parquet,
                    [b'A', b'R', b'R', b'O', b'W', b'1', ..] | [b'F', b'E', b'A', b'1', ..] => {
                        Self::Arrow
                    }
                    [0x89, b'H', b'D', b'F', ..] => {
                        let what = "HDF5, of which blocks of rows are read: \
                                    RowFile in Rust, `catamaran ata FILE:/dataset`";
                        return Err(source.fail(what));
                    }
                    _ => Self::Table,
                }
            }
        };
        Ok((source, format))
    }
}

/// Returns whether a file that begins with these bytes is a matrix of MatrixMarket.
pub(super) fn begins_mtx(head: &[u8]) -> bool {
    const START: &[u8] = b"%%MatrixMarket";
    head.get(..START.len()).is_some_and(|start| start.eq_ignore_ascii_case(START))
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
            #[cfg(feature = "hdf5")]
            Some("h5" | "hdf5" | "he5") if stem.is_none() => Self::Hdf5,
            #[cfg(not(feature = "hdf5"))]
            Some("h5" | "hdf5" | "he5") => return Err(without_hdf5(path)),
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
        if FileFormat::of_name(name).is_none()
            && let Some(found) = Self::by_content(name)
        {
            return Ok(found);
        }
        if text.ends_with(".npy.gz") {
            return fail("gzipped, so rows can't be read from its middle: unpack it first");
        }
        if let Some(what) = foreign(name) {
            return fail(what);
        }
        fail(
            "unknown kind of file for reading by rows: the name must end in .npy, .h5, .hdf5 or \
             .he5, or the content must be HDF5, and all but .npy may have :/path/to/dataset after \
             it",
        )
    }

    /// Finds a file whose content is HDF5: of this name, or of its part before a colon.
    fn by_content(name: &Path) -> Option<Self> {
        if has_hdf5(name) {
            return Some(Self::Hdf5 { path: name.into(), dataset: None });
        }
        let whole = name.to_str()?;
        let (at, _) =
            whole.match_indices(':').find(|&(at, _)| has_hdf5(Path::new(&whole[..at])))?;
        let dataset = Some(whole[at + 1..].into());
        Some(Self::Hdf5 { path: whole[..at].into(), dataset })
    }
}

/// Returns whether a file contains HDF5: its signature is at the start, or after a block of 512,
/// 1024, ... bytes for users.
fn has_hdf5(path: &Path) -> bool {
    let mut found = [0; SIGNATURE.len()];
    let Some(mut file) = plain(path) else { return false };
    let mut places = [0].into_iter().chain((0..USER_BLOCKS).map(|power| 512 << power));
    places.any(|place| {
        let read = file.seek(SeekFrom::Start(place)).and_then(|_| file.read_exact(&mut found));
        read.is_ok() && found == SIGNATURE
    })
}

const SIGNATURE: [u8; 8] = *b"\x89HDF\r\n\x1a\n";

/// Sizes of the block for users that are tried: up to 1 MiB.
const USER_BLOCKS: u32 = 12;

/// Says what a file is that is not read, though it looks like one that is, and what converts it.
pub(super) fn foreign(path: &Path) -> Option<&'static str> {
    let mut start = Vec::new();
    plain(path)?.take(16).read_to_end(&mut start).ok()?;
    match &start[..] {
        [0x0e, 0x03, 0x13, 0x01, ..] => Some("HDF4, which is not HDF5: h4toh5 converts it"),
        [b'C', b'D', b'F', 1 | 2 | 5, ..] => {
            Some("netCDF in its classic format: `nccopy -k nc4 FILE OTHER` converts it to HDF5")
        }
        [b'M', b'A', b'T', b'L', b'A', b'B', b' ', b'5', ..] => {
            Some("a file of MATLAB before version 7.3: `save FILE -v7.3` writes HDF5")
        }
        _ => None,
    }
}

/// Opens a plain file; reading a pipe would take something from it.
fn plain(path: &Path) -> Option<File> {
    if path.is_file() { File::open(path).ok() } else { None }
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
pub(super) fn lower_name(path: &Path) -> String {
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
        for name in ["csv", "a.gz", "a.csv.xz", "a.npz", "a.csv/b", "a.h5.gz"] {
            assert_eq!(of(name), None, "{name}");
        }
    }

    #[test]
    fn content_of_hdf5_is_found_under_any_name_and_behind_a_block_for_users() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        let matlab = [b"MATLAB 7.3 MAT-file".to_vec(), vec![0; 493], SIGNATURE.to_vec()].concat();
        std::fs::write(path("a.nc"), SIGNATURE).unwrap();
        std::fs::write(path("a.mat"), matlab).unwrap();
        std::fs::write(path("a.txt"), SIGNATURE).unwrap();
        for name in ["a.nc", "a.mat"] {
            let file = RowsFormat::Hdf5 { path: path(name), dataset: None };
            assert_eq!(RowsFormat::of(&path(name)).unwrap(), file);
            let dataset = Some("/g/x:y".into());
            let part = RowsFormat::Hdf5 { path: path(name), dataset };
            assert_eq!(RowsFormat::of(&path(&format!("{name}:/g/x:y"))).unwrap(), part);
        }
        // The names of other formats are kept.
        assert!(RowsFormat::of(&path("a.txt")).is_err());
    }

    #[test]
    fn hdf5_that_is_read_as_a_whole_is_no_table() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.nc");
        std::fs::write(&path, SIGNATURE).unwrap();
        let refused = FileFormat::open(&path, None, &SourceOptions::new()).err().unwrap();
        assert!(refused.to_string().contains("a.nc: HDF5, of which blocks of rows"), "{refused}");
    }

    #[test]
    fn files_of_other_kinds_say_what_converts_them() {
        let folder = tempfile::tempdir().unwrap();
        for (name, content, tool) in [
            ("a.hdf", &b"\x0e\x03\x13\x01\0\0"[..], "h4toh5"),
            ("a.nc", b"CDF\x02\0\0\0\0", "nccopy"),
            ("a.mat", b"MATLAB 5.0 MAT-file, Platform", "-v7.3"),
        ] {
            let path = folder.path().join(name);
            std::fs::write(&path, content).unwrap();
            let said = RowsFormat::of(&path).unwrap_err().to_string();
            assert!(said.contains(name) && said.contains(tool), "{said}");
        }
    }
}
