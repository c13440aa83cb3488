//! # Back ends
//!
//! A BLAS library may compute the small products that schemes end in.
//!
//! ```c
//! double a[] = {1, 2, 3, 4, 5, 6}, c[4];
//! cata_backend *backend;
//! if (cata_backend_load("libopenblas.so.0", &backend) == CATA_OK) {
//!     cata_ata_params params = {.struct_size = sizeof params, .backend = backend};
//!     cata_ata_f64(CATA_ROW_MAJOR, CATA_BOTH, 3, 2, 1, a, 2, 0, c, 2, &params);
//!     cata_backend_free(backend);
//! }
//! ```

use std::ffi::{CString, c_char};
use std::sync::Arc;

use super::boundary::{boundary, path};
use super::pointer::{free, hand_over, output};
#[cfg(not(feature = "openblas"))]
use super::status::Failure;
use super::status::cata_status;
use catamaran::blas::{self, Backend};

/// A BLAS library that computes the small products, for several calls and threads at a time.
pub struct cata_backend {
    backend: Arc<dyn Backend>,
    name: CString,
}

impl cata_backend {
    fn new(backend: Arc<dyn Backend>) -> Self {
        let name = CString::new(backend.name()).unwrap_or_default();
        Self { backend, name }
    }

    pub(super) fn get(&self) -> Arc<dyn Backend> {
        Arc::clone(&self.backend)
    }
}

/// Loads the shared library at `path` (MKL's libmkl_rt.so, libopenblas.so, libblis.so, ...),
/// which must have the CBLAS interface with 32-bit integers; without a slash the system's search
/// path is used. Its initializers run: load only what you trust. CATA_ERR_BACKEND when there is
/// no such file or it is not such a library.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_backend_load(
    path: *const c_char,
    backend: *mut *mut cata_backend,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`backend`, one value), clause `texts` (`path`).
        let (path, backend) = unsafe { (self::path("path", path)?, output("backend", backend)?) };
        hand_over(backend, cata_backend::new(blas::load(&path)?));
        Ok(())
    })
}

/// Gets the OpenBLAS that the library was linked with; needs CATA_CAP_OPENBLAS.
///
/// # Safety
/// The pointer is as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_backend_openblas(backend: *mut *mut cata_backend) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`backend`, one value).
        let backend = unsafe { output("backend", backend) }?;
        #[cfg(feature = "openblas")]
        {
            hand_over(backend, cata_backend::new(blas::openblas()));
            Ok(())
        }
        #[cfg(not(feature = "openblas"))]
        {
            let _ = backend;
            Err(Failure::absent("openblas"))
        }
    })
}

/// Returns the short name of a back end, such as "openblas" or the file name of a loaded library,
/// in UTF-8; valid until cata_backend_free; empty for NULL. Never NULL; do not free it.
///
/// # Safety
/// The pointer is as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_backend_name(backend: *const cata_backend) -> *const c_char {
    // SAFETY: clause `handles` (`backend`); NULL gives the default.
    unsafe { backend.as_ref() }.map_or(c"".as_ptr(), |b| b.name.as_ptr())
}

/// Frees a back end.
///
/// # Safety
/// The pointer is as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_backend_free(backend: *mut cata_backend) {
    // SAFETY: clause `handles` (`backend`).
    unsafe { free(backend) };
}
