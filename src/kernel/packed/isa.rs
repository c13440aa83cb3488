//! The instruction sets, and which of them this machine supports.

#[cfg(target_arch = "aarch64")]
use super::neon::Neon;
#[cfg(target_arch = "x86_64")]
use super::x86::{Avx2, Avx512};

/// An instruction set that the kernels are written for.
///
/// ```
/// use catamaran::kernel::packed::FloatIsa;
///
/// let usable: Vec<_> = FloatIsa::ALL.into_iter().filter(|isa| isa.refusal().is_none()).collect();
/// assert_eq!(usable.first(), Some(&FloatIsa::best()));
/// assert_eq!(usable.last(), Some(&FloatIsa::Portable));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum FloatIsa {
    /// AVX-512.
    Avx512,
    /// AVX2 with FMA and BMI2.
    Avx2,
    /// NEON, which every AArch64 CPU has.
    Neon,
    /// Plain Rust.
    Portable,
}

impl FloatIsa {
    /// All instruction sets, the fastest first.
    pub const ALL: [Self; 4] = [Self::Avx512, Self::Avx2, Self::Neon, Self::Portable];

    /// Returns the short name: `avx512`, `avx2`, `neon` or `portable`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Avx512 => "avx512",
            Self::Avx2 => "avx2",
            Self::Neon => "neon",
            Self::Portable => "portable",
        }
    }

    /// Returns the fastest instruction set that this machine supports.
    pub fn best() -> Self {
        let usable = |i: &Self| i.refusal().is_none();
        Self::ALL.into_iter().find(usable).unwrap_or(Self::Portable)
    }

    /// Returns why this machine can't use the instruction set; `None` when it can.
    pub fn refusal(self) -> Option<&'static str> {
        match self {
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => Avx512::new().err(),
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => Avx2::new().err(),
            #[cfg(not(target_arch = "x86_64"))]
            Self::Avx512 | Self::Avx2 => Some("not an x86-64 CPU"),
            #[cfg(target_arch = "aarch64")]
            Self::Neon => Neon::new().err(),
            #[cfg(not(target_arch = "aarch64"))]
            Self::Neon => Some("not an AArch64 CPU"),
            Self::Portable => None,
        }
    }
}
