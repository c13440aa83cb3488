//! Opens HDF5 files for reading.

use std::ffi::CString;
use std::path::Path;

use ::hdf5::{File, MinorErrorCode};
use ::hdf5_sys::h5f::{H5F_ACC_RDONLY, H5Fopen};
use ::hdf5_sys::h5p::{H5Pexist, H5Pset};

use crate::base::{Error, Result};
use crate::io::source::error;

/// The note of a file that is read without a lock.
const UNLOCKED: &str = "read without a lock: another program writes the file, or the file system \
                        has no locks";

/// The name of the property of HDF5, from version 1.10.7 on, that switches locks on or off.
const LOCKS: &std::ffi::CStr = c"use_file_locking";

/// Opens a file for reading, without a lock (and with a note) where it can't be locked.
pub(in crate::io) fn open(path: &Path) -> Result<(File, Option<String>)> {
    let e = match File::open(path) {
        Ok(file) => return Ok((file, None)),
        Err(e) => e,
    };
    if e.contains_minor(MinorErrorCode::NotHdf5) {
        return Err(error(path, None, "not an HDF5 file"));
    }
    let says = |what: &str| {
        e.stack().is_some_and(|stack| stack.iter().any(|frame| frame.desc().contains(what)))
    };
    if says("already open for write") {
        let what = "marked as open for writing, by a program that writes it or that was killed \
                    (then `h5clear -s FILE` removes the mark)";
        return Err(error(path, None, what));
    }
    // The second one while this process has the file open without a lock.
    if !says("unable to lock") && !says("file locking flag values don't match") {
        return Err(fail(path, &e));
    }
    match unlocked(path) {
        Ok(file) => Ok((file, Some(UNLOCKED.into()))),
        Err(_) => {
            let what = "can't be locked (HDF5_USE_FILE_LOCKING=FALSE reads it without a lock)";
            Err(error(path, None, what))
        }
    }
}

/// Returns the error for what the library says about a file.
pub(super) fn fail(path: &Path, e: &::hdf5::Error) -> Error {
    error(path, None, format!("HDF5 says: {e}"))
}

/// Opens a file without a lock.
fn unlocked(path: &Path) -> ::hdf5::Result<File> {
    let access = ::hdf5::plist::FileAccess::try_new()?;
    let name = CString::new(path.to_string_lossy().as_bytes());
    let name = name.map_err(|e| ::hdf5::Error::Internal(e.to_string()))?;
    ::hdf5::sync::sync(|| {
        let mut off = false;
        // SAFETY: the list and the names are alive; the property is of the type of C that `bool`
        // is, and HDF5 copies its value.
        let id = unsafe {
            if H5Pexist(access.id(), LOCKS.as_ptr()) <= 0
                || H5Pset(access.id(), LOCKS.as_ptr(), (&raw mut off).cast()) < 0
            {
                return Err(::hdf5::Error::Internal("locks can't be switched off".into()));
            }
            H5Fopen(name.as_ptr(), H5F_ACC_RDONLY, access.id())
        };
        if id < 0 {
            return Err(::hdf5::Error::query().unwrap_or_else(|e| e));
        }
        // SAFETY: a new identifier, which the handle then owns.
        unsafe { ::hdf5::from_id(id) }
    })
}
