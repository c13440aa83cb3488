//! The path of the shared library.

use std::path::PathBuf;

/// Returns the file that cargo built beside this program.
pub fn path() -> PathBuf {
    let program = std::env::current_exe().unwrap();
    let path = program.with_file_name("libcatamaran_blas.so");
    assert!(path.exists(), "{} is not built", path.display());
    path
}
