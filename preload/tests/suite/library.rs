//! Where the shared library is.

use std::path::PathBuf;

/// The file that cargo built beside this program.
pub fn path() -> PathBuf {
    let program = std::env::current_exe().unwrap();
    let path = program.with_file_name("libcatamaran_blas.so");
    assert!(path.exists(), "{} is not built", path.display());
    path
}
