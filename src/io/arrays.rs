use std::path::Path;

use super::npz::{Array, write_npz};
use super::output::Output;
use super::source::error;
use crate::base::Result;

enum Format {
    Npz,
    #[cfg(feature = "hdf5")]
    Hdf5,
}

fn format_of(path: &Path) -> Result<Format> {
    let name = path.file_name().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    if name.ends_with(".npz") {
        return Ok(Format::Npz);
    }
    if ![".h5", ".hdf5", ".he5"].iter().any(|end| name.ends_with(end)) {
        return Err(error(path, 0, "must be called .npz, .h5, .hdf5 or .he5"));
    }
    #[cfg(feature = "hdf5")]
    return Ok(Format::Hdf5);
    #[cfg(not(feature = "hdf5"))]
    Err(error(path, 0, "HDF5 is not part of this program: build it with --features hdf5"))
}

/// Whether [`write_arrays`] can write a file of this name.
///
/// # Errors
/// [`Error::Io`](crate::Error::Io) for any other end of the name, and for HDF5 without feature `hdf5`.
pub fn check_arrays_name(path: &Path) -> Result<()> {
    format_of(path).map(drop)
}

/// Writes named arrays into `output`, as its name says, and lets it appear: `.npz` as [`write_npz`]; `.h5`, `.hdf5` and
/// `.he5` (feature `hdf5`) with a dataset for each, of the same name, shape and type.
///
/// # Errors
/// As [`check_arrays_name`]; [`Error::Io`](crate::Error::Io), and nothing is left behind then.
pub fn write_arrays(output: Output, arrays: &[(&str, Array<'_>)]) -> Result<()> {
    match format_of(output.path())? {
        Format::Npz => write_npz(output, arrays),
        #[cfg(feature = "hdf5")]
        Format::Hdf5 => super::hdf5::write_hdf5(output, arrays),
    }
}
