//! `--backend`.

use std::path::Path;
use std::sync::Arc;

use anyhow::Result;
use catamaran::blas::{self, Backend};

/// The back end called `name`: `native`, `openblas`, or the path of a CBLAS library.
pub fn find(name: &str) -> Result<Arc<dyn Backend>> {
    match name {
        // `gemm` is what it was called once.
        "native" | "gemm" => Ok(blas::tuned()),
        #[cfg(feature = "openblas")]
        "openblas" => Ok(blas::openblas()),
        #[cfg(not(feature = "openblas"))]
        "openblas" => anyhow::bail!(
            "this program was built without OpenBLAS: give the path of its library \
             (libopenblas.so), or build with --features openblas"
        ),
        path => Ok(blas::load(Path::new(path))?),
    }
}
