//! BLAS back ends behind one trait. A back end computes the leaves of every recursion.
//!
//! | constructor | needs | note |
//! |---|---|---|
//! | [`native()`] | nothing | our own kernels, pure Rust; the default |
//! | [`tuned()`] | nothing | the same, with rates measured on this machine |
//! | `openblas` (feature `openblas`) | `libopenblas-dev` | linked at build time |
//! | [`load`] | any shared library with the CBLAS interface | MKL, OpenBLAS, BLIS, by path |
//!
//! A back end computes with one thread: threads belong to the layers above.

mod backend;
mod cblas;
mod kernels;
mod native;
mod triangle;

use std::path::Path;
use std::sync::{Arc, LazyLock};

use crate::base::Result;
use crate::kernel::packed::{self, FloatIsa};

pub use backend::{Backend, BlasReal, Rates, ThreadGuard};
pub use kernels::Kernels;
pub use native::Native;

/// Returns the default back end: the kernels of this crate for the best instruction set of this
/// machine.
///
/// ```
/// use catamaran::{AtaOptions, Uplo, ata_into, blas, faer::Mat};
///
/// let options = AtaOptions::new().backend(blas::native()).uplo(Uplo::Both);
/// let (a, mut c) = (Mat::<f64>::identity(6, 3), Mat::zeros(3, 3));
/// ata_into(2.0, a.as_ref(), 0.0, c.as_mut(), &options)?;
/// assert_eq!(c[(2, 2)], 2.0);
/// # Ok::<(), catamaran::Error>(())
/// ```
pub fn native() -> Arc<dyn Backend> {
    // Every call of `ata` with default options uses this back end: one allocation for all calls.
    static NATIVE: LazyLock<Arc<dyn Backend>> = LazyLock::new(|| native_on(FloatIsa::best()));
    NATIVE.clone()
}

/// Returns the kernels of this crate for one instruction set; the portable kernels if this machine
/// does not support it.
///
/// ```
/// use catamaran::{AtaOptions, ata_into, blas, faer::Mat, kernel::packed::FloatIsa};
///
/// let options = AtaOptions::new().backend(blas::native_on(FloatIsa::Portable));
/// let (a, mut c) = (Mat::<f64>::ones(5, 3), Mat::zeros(3, 3));
/// ata_into(1.0, a.as_ref(), 0.0, c.as_mut(), &options)?;
/// assert_eq!(c[(2, 1)], 5.0);
/// # Ok::<(), catamaran::Error>(())
/// ```
pub fn native_on(isa: FloatIsa) -> Arc<dyn Backend> {
    native_with(isa, packed::Rates::of(isa))
}

/// Returns the kernels of this crate for one instruction set, as [`native_on`] does, with the given
/// rates for the planner.
///
/// ```
/// use catamaran::{blas, kernel::packed::{FloatIsa, Rates}};
///
/// let isa = FloatIsa::best();
/// let backend = blas::native_with(isa, Rates { flops: 1e11, ..Rates::of(isa) });
/// assert_eq!(backend.rates().gemm_flops, 1e11);
/// ```
pub fn native_with(isa: FloatIsa, rates: packed::Rates) -> Arc<dyn Backend> {
    Arc::new(Native::new(isa, rates))
}

/// Returns the kernels of this crate with the rates that were measured on this machine
/// (`catamaran tune`), or the built-in rates if there are none.
///
/// This function reads a file in the user's cache directory. Plans, and therefore the rounding of
/// results, depend on that file. [`native()`] reads no file.
///
/// ```
/// use catamaran::{AtaOptions, ata_into, blas, faer::Mat};
///
/// let options = AtaOptions::new().backend(blas::tuned());
/// let (a, mut c) = (Mat::<f64>::ones(5, 3), Mat::zeros(3, 3));
/// ata_into(1.0, a.as_ref(), 0.0, c.as_mut(), &options)?;
/// assert_eq!(c[(2, 1)], 5.0);
/// # Ok::<(), catamaran::Error>(())
/// ```
pub fn tuned() -> Arc<dyn Backend> {
    let isa = FloatIsa::best();
    let rates = packed::Rates::cached(isa).unwrap_or_else(|| packed::Rates::of(isa));
    native_with(isa, rates)
}

/// Returns OpenBLAS, as linked at build time.
///
/// ```
/// use catamaran::{AtaOptions, ata_into, blas, faer::Mat};
///
/// let options = AtaOptions::new().backend(blas::openblas());
/// let (a, mut c) = (Mat::<f64>::ones(5, 3), Mat::zeros(3, 3));
/// ata_into(1.0, a.as_ref(), 0.0, c.as_mut(), &options)?;
/// assert_eq!(c[(2, 1)], 5.0);
/// # Ok::<(), catamaran::Error>(())
/// ```
#[cfg(feature = "openblas")]
pub fn openblas() -> Arc<dyn Backend> {
    Arc::new(cblas::Cblas::linked_openblas())
}

/// Loads the CBLAS library at `path` (`libmkl_rt.so`, `libopenblas.so`, `libblis.so`, ...), with
/// 32-bit integers (LP64). The symbol names of the PyPI package `scipy-openblas32` are known too.
///
/// Operands that CBLAS can't express (no unit stride, or an extent over 2^31 - 1) are computed by
/// [`native()`] instead.
///
/// ```no_run
/// use catamaran::{AtaOptions, blas};
///
/// let backend = blas::load("/usr/lib/x86_64-linux-gnu/libblis.so.4".as_ref())?;
/// let options = AtaOptions::new().backend(backend);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Backend`](crate::Error::Backend) when the file can't be loaded or lacks a symbol.
pub fn load(path: &Path) -> Result<Arc<dyn Backend>> {
    Ok(Arc::new(cblas::Cblas::load(path)?))
}
