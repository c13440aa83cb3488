use std::ffi::{CStr, c_char};

use super::boundary::boundary;
use super::pointer::{optional_output, put};
use super::status::cata_status;
use catamaran::base;

/// Bit of cata_capabilities: OpenBLAS is linked in.
pub const CATA_CAP_OPENBLAS: u64 = 1;
/// Bit of cata_capabilities: MPI is linked in.
pub const CATA_CAP_MPI: u64 = 2;
/// Bit of cata_capabilities: kernels for OpenCL devices.
pub const CATA_CAP_OPENCL: u64 = 4;
/// Bit of cata_capabilities: rows from HDF5 files.
pub const CATA_CAP_HDF5: u64 = 8;
/// Bit of cata_capabilities: all chapters, not A^T A alone.
pub const CATA_CAP_CHAPTERS: u64 = 16;

const VERSION: &CStr =
    match CStr::from_bytes_with_nul(concat!(env!("CARGO_PKG_VERSION"), "\0").as_bytes()) {
        Ok(version) => version,
        Err(_) => panic!("a version has no NUL inside"),
    };

/// Gets the version of the library that runs, which may be newer than the header's. NULL where a
/// part is not wanted.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_version(
    major: *mut i32,
    minor: *mut i32,
    patch: *mut i32,
) -> cata_status {
    boundary(|| {
        let version = base::version();
        // SAFETY: clause `memory` (`major`, `minor`, `patch`, one value each).
        let places = unsafe {
            [
                optional_output("major", major)?,
                optional_output("minor", minor)?,
                optional_output("patch", patch)?,
            ]
        };
        let parts = [version.major, version.minor, version.patch];
        places.into_iter().zip(parts).for_each(|(place, part)| put(place, part as i32));
        Ok(())
    })
}

/// Returns the version as "major.minor.patch". Static, never NULL; do not free it.
#[unsafe(no_mangle)]
pub extern "C" fn cata_version_string() -> *const c_char {
    VERSION.as_ptr()
}

/// Returns what this build of the library can do: a sum of CATA_CAP_* bits. The functions of an
/// absent capability exist, and return CATA_ERR_UNSUPPORTED.
#[unsafe(no_mangle)]
pub extern "C" fn cata_capabilities() -> u64 {
    let openblas = if cfg!(feature = "openblas") { CATA_CAP_OPENBLAS } else { 0 };
    let mpi = if cfg!(feature = "mpi") { CATA_CAP_MPI } else { 0 };
    let opencl = if cfg!(feature = "opencl") { CATA_CAP_OPENCL } else { 0 };
    let hdf5 = if cfg!(feature = "hdf5") { CATA_CAP_HDF5 } else { 0 };
    let chapters = if cfg!(feature = "chapters") { CATA_CAP_CHAPTERS } else { 0 };
    openblas | mpi | opencl | hdf5 | chapters
}
