//! The scalars that have kernels.

use super::isa::FloatIsa;
use super::kernel::Kernel;
#[cfg(target_arch = "aarch64")]
use super::neon::Neon;
use super::portable::Portable;
#[cfg(target_arch = "x86_64")]
use super::x86::{Avx2, Avx512};
use crate::base::Real;

/// A scalar that the kernels are written for.
pub trait FloatOperand: Real + sealed::Kernels {}

impl FloatOperand for f32 {}
impl FloatOperand for f64 {}

pub(crate) mod sealed {
    use super::*;

    pub trait Kernels: Sized {
        /// Returns the kernel of an isa, or that of [`FloatIsa::Portable`] if this machine can't
        /// use it.
        #[allow(private_interfaces)]
        fn kernel(isa: FloatIsa) -> &'static dyn Kernel<Self>;
    }

    macro_rules! kernels {
        ($t:ident) => {
            impl Kernels for $t {
                #[allow(private_interfaces)]
                fn kernel(isa: FloatIsa) -> &'static dyn Kernel<Self> {
                    let portable: &'static dyn Kernel<Self> = &Portable;
                    match isa {
                        #[cfg(target_arch = "x86_64")]
                        FloatIsa::Avx512 => Avx512::new().map_or(portable, |kernel| kernel),
                        #[cfg(target_arch = "x86_64")]
                        FloatIsa::Avx2 => Avx2::new().map_or(portable, |kernel| kernel),
                        #[cfg(target_arch = "aarch64")]
                        FloatIsa::Neon => Neon::new().map_or(portable, |kernel| kernel),
                        #[cfg(not(target_arch = "x86_64"))]
                        FloatIsa::Avx512 | FloatIsa::Avx2 => portable,
                        #[cfg(not(target_arch = "aarch64"))]
                        FloatIsa::Neon => portable,
                        FloatIsa::Portable => portable,
                    }
                }
            }
        };
    }
    kernels!(f32);
    kernels!(f64);
}
