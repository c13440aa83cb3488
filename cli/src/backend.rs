//! The option `--backend`.

use std::path::Path;
use std::sync::Arc;

use anyhow::Result;
use catamaran::blas::{self, Backend};

/// Returns the back end called `name`: `native`, `openblas`, or the path of a CBLAS library.
pub fn find(name: &str) -> Result<Arc<dyn Backend>> {
    match name {
        // `gemm` is the former name.
        "native" | "gemm" => Ok(blas::tuned()),
        #[cfg(feature = "openblas")]
        "openblas" => Ok(blas::openblas()),
        #[cfg(not(feature = "openblas"))]
        "openblas" => anyhow::bail!(
            "--backend openblas: this program was built without OpenBLAS; give the path of its \
             library (libopenblas.so), or build with --features openblas"
        ),
        path => Ok(blas::load(Path::new(path))?),
    }
}
