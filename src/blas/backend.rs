//! The trait of BLAS back ends.

use super::kernels::Kernels;
use super::native::Native;
use crate::base::Real;
use crate::kernel::{int8, packed};

/// Sustained speed of a back end on one core, for the planner. Estimates: a wrong one costs time,
/// never correctness.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rates {
    /// Flops per second (a multiply-add counts two) of a large f64 `gemm`; f32 runs at twice that.
    pub gemm_flops: f64,
    /// Side at which `gemm` runs at a third of that, for the model `1 / (1 + half / n + half / k)`.
    pub gemm_half_side: f64,
    /// Useful flops per second of a large f64 `syrk`.
    pub syrk_flops: f64,
    /// Side at which `syrk` runs at half of that.
    pub syrk_half_side: f64,
    /// Bytes per second of a sum of matrices that do not fit the cache, reads and writes counted.
    pub add_bytes: f64,
}

/// A BLAS library, or another implementation of its matrix products.
pub trait Backend: Kernels<f32> + Kernels<f64> {
    /// Returns a short name, such as `native`, `openblas` or the file name of a loaded library.
    fn name(&self) -> &str;

    /// Returns the version or the library's description of itself; may be empty.
    fn description(&self) -> &str;

    /// Returns the rates that the planner assumes.
    fn rates(&self) -> Rates;

    /// Returns the back end itself if it is the kernels of this crate, which
    /// [`product`](crate::product) then uses without this trait.
    fn native(&self) -> Option<&Native> {
        None
    }

    /// Limits the library to one thread until the guard is dropped: on the calling thread (MKL), or
    /// in the process (others), where the last guard restores what the first one found.
    fn single_threaded(&self) -> ThreadGuard {
        ThreadGuard(None)
    }
}

/// Restores a library's thread count when dropped.
pub struct ThreadGuard(pub(super) Option<Box<dyn FnOnce()>>);

impl Drop for ThreadGuard {
    fn drop(&mut self) {
        if let Some(restore) = self.0.take() {
            restore();
        }
    }
}

/// A scalar for which a [`Backend`] has kernels; selects them from the trait object.
///
/// ```
/// use catamaran::{blas::{self, BlasReal}, faer::Mat};
///
/// let backend = blas::native();
/// let (a, mut c) = (Mat::<f64>::ones(5, 3), Mat::zeros(3, 3));
/// f64::kernels(&*backend).gemm(1.0, a.as_ref(), a.as_ref(), 0.0, c.as_mut());
/// assert_eq!(c[(0, 2)], 5.0);
/// ```
pub trait BlasReal: Real + int8::IntegerOperand + packed::FloatOperand {
    /// Returns the kernels of this precision.
    fn kernels(backend: &dyn Backend) -> &dyn Kernels<Self>;
}

impl BlasReal for f32 {
    fn kernels(backend: &dyn Backend) -> &dyn Kernels<Self> {
        backend
    }
}

impl BlasReal for f64 {
    fn kernels(backend: &dyn Backend) -> &dyn Kernels<Self> {
        backend
    }
}

impl Backend for Native {
    fn name(&self) -> &str {
        "native"
    }

    fn description(&self) -> &str {
        self.isa().name()
    }

    fn native(&self) -> Option<&Self> {
        Some(self)
    }

    fn rates(&self) -> Rates {
        let packed::Rates { flops, update_bytes, .. } = Native::rates(self);
        Rates {
            gemm_flops: flops,
            gemm_half_side: 36.0,
            syrk_flops: flops,
            syrk_half_side: 60.0,
            add_bytes: update_bytes,
        }
    }
}
