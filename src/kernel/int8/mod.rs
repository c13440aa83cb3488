//! Exact products of integer matrices through their residues: the arithmetic of the exact path.
//!
//! Integers up to 2^80 in magnitude are reduced modulo up to 28 moduli of at most 256, the residues
//! are multiplied by byte instructions with 32-bit sums, and the Chinese remainder theorem
//! reconstructs the products (Ozaki, Uchino and Imamura 2025, "Ozaki scheme II"). This arithmetic
//! is exact, so every [`IntegerIsa`] and every order of work gives the same bytes.

// The instructions of x86 need more constants.
#![cfg_attr(not(target_arch = "x86_64"), allow(dead_code))]

#[cfg(target_arch = "x86_64")]
mod amx;
#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
mod direct;
#[cfg(target_arch = "x86_64")]
mod dots;
mod integer;
mod kernel;
mod lane_set;
mod lanes;
#[cfg(target_arch = "x86_64")]
mod lanes_avx2;
#[cfg(target_arch = "x86_64")]
mod lanes_avx512;
mod moduli;
#[cfg(target_arch = "aarch64")]
mod neon;
mod portable;
mod recombine;
mod rounding;
#[cfg(test)]
pub(crate) mod tests;
mod tile;

pub(crate) use direct::{Direct, Right, products, to_integers};
pub(crate) use integer::{I256, Integer, U256};
pub(crate) use kernel::{Conversion, Kernel, Next, Operands, Recombination};
pub(crate) use lanes::{LANES, Lanes, OnLanes, Row};
pub(crate) use moduli::{IntegerModuli, MOST_MODULI, Moduli, Modulus, WIDE_BITS};
pub(crate) use recombine::integers;
pub(crate) use tile::{
    DEPTH, EMPTY, NON_FINITE, NORM_BITS, PANEL, PanelBlock, Powers, Residues, STEP, Slice, Square,
    Tile, TileNorms, WIDTH, norms, power_of_two, scaled, transpose,
};

use crate::base::Real;

/// An instruction set that the kernels are written for.
///
/// ```
/// use catamaran::kernel::int8::IntegerIsa;
///
/// let all = IntegerIsa::ALL.into_iter();
/// let usable: Vec<_> = all.filter(|isa| isa.refusal().is_none()).collect();
/// assert_eq!(usable.first(), Some(&IntegerIsa::best()));
/// assert_eq!(usable.last(), Some(&IntegerIsa::Portable));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum IntegerIsa {
    /// Intel's matrix tiles (AMX-INT8) for the products, AVX-512 for the rest.
    Amx,
    /// AVX-512 with dot products of bytes (VNNI).
    Vnni,
    /// AVX2 with dot products of bytes (AVX-VNNI).
    AvxVnni,
    /// AVX2 with products of 16-bit numbers.
    Avx2,
    /// NEON with products of 2 x 8 matrices of bytes.
    I8mm,
    /// NEON with dot products of bytes.
    Dotprod,
    /// Plain Rust.
    Portable,
}

impl IntegerIsa {
    /// All instruction sets, the fastest first.
    pub const ALL: [Self; 7] = [
        Self::Amx,
        Self::Vnni,
        Self::AvxVnni,
        Self::Avx2,
        Self::I8mm,
        Self::Dotprod,
        Self::Portable,
    ];

    /// Returns the short name: `amx`, `vnni`, `avxvnni`, `avx2`, `i8mm`, `dotprod` or `portable`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Amx => "amx",
            Self::Vnni => "vnni",
            Self::AvxVnni => "avxvnni",
            Self::Avx2 => "avx2",
            Self::I8mm => "i8mm",
            Self::Dotprod => "dotprod",
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
            Self::Amx => amx::Amx::new().err(),
            #[cfg(target_arch = "x86_64")]
            Self::Vnni => avx512::Vnni::new().err(),
            #[cfg(target_arch = "x86_64")]
            Self::AvxVnni => dots::kernel().err(),
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => avx2::Avx2::new().err(),
            #[cfg(not(target_arch = "x86_64"))]
            Self::Amx | Self::Vnni | Self::AvxVnni | Self::Avx2 => Some("not an x86-64 CPU"),
            #[cfg(target_arch = "aarch64")]
            Self::I8mm => neon::Neon::with_i8mm().err(),
            #[cfg(target_arch = "aarch64")]
            Self::Dotprod => neon::Neon::with_dotprod().err(),
            #[cfg(not(target_arch = "aarch64"))]
            Self::I8mm | Self::Dotprod => Some("not an AArch64 CPU"),
            Self::Portable => None,
        }
    }

    /// Returns the rates that the planner assumes. They are estimates; their ratio to the rates of
    /// the back ends is a measured one.
    pub(crate) fn rates(self) -> Rates {
        match self {
            Self::Amx => {
                Rates { products: 2.6e12, conversions: 4.2e9, recombinations: 5e9, integers: 2e10 }
            }
            Self::Vnni => {
                Rates { products: 2.0e11, conversions: 4e9, recombinations: 4e9, integers: 2e10 }
            }
            // Half of the bytes of VNNI an instruction; not measured.
            Self::AvxVnni => {
                Rates { products: 1e11, conversions: 3e9, recombinations: 2e9, integers: 1.5e10 }
            }
            Self::Avx2 => {
                Rates { products: 4.5e10, conversions: 3e9, recombinations: 2e9, integers: 1.5e10 }
            }
            // Two pipelines at 3 GHz, half of them filled; not measured.
            Self::I8mm => {
                Rates { products: 9.6e10, conversions: 2e9, recombinations: 1e9, integers: 6e9 }
            }
            Self::Dotprod => {
                Rates { products: 4.8e10, conversions: 2e9, recombinations: 1e9, integers: 6e9 }
            }
            Self::Portable => {
                Rates { products: 1e10, conversions: 2e8, recombinations: 1e9, integers: 3e9 }
            }
        }
    }

    /// Returns the kernel, or that of [`IntegerIsa::Portable`] if the machine can't use this one.
    pub(crate) fn kernel(self) -> &'static dyn Kernel {
        let portable: &'static dyn Kernel = &portable::Portable;
        match self {
            #[cfg(target_arch = "x86_64")]
            Self::Amx => amx::Amx::new().map_or(portable, |kernel| kernel),
            #[cfg(target_arch = "x86_64")]
            Self::Vnni => avx512::Vnni::new().map_or(portable, |kernel| kernel),
            #[cfg(target_arch = "x86_64")]
            Self::AvxVnni => dots::kernel().map_or(portable, |kernel| kernel),
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => avx2::Avx2::new().map_or(portable, |kernel| kernel),
            #[cfg(target_arch = "aarch64")]
            Self::I8mm => neon::Neon::with_i8mm().map_or(portable, |kernel| kernel),
            #[cfg(target_arch = "aarch64")]
            Self::Dotprod => neon::Neon::with_dotprod().map_or(portable, |kernel| kernel),
            _ => portable,
        }
    }
}

/// Rates of one core, per second: multiplications of residues, conversions of an entry to one
/// residue, with the norm of its column and the loads of its panel, residues recombined, and
/// products of parts of integers.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Rates {
    pub products: f64,
    pub conversions: f64,
    pub recombinations: f64,
    pub integers: f64,
}

/// A scalar of the exact path; it selects the variant of each step.
pub trait IntegerOperand: Real + sealed::Steps {}

impl IntegerOperand for f32 {}
impl IntegerOperand for f64 {}

pub(crate) mod sealed {
    use std::borrow::Cow;

    use super::*;

    pub trait Steps: Direct {
        /// log2 of the bound on the integers that entries are converted to.
        const INTEGER_BITS: i32;
        #[allow(private_interfaces)]
        fn norms(kernel: &dyn Kernel, tile: &Tile<Self>) -> TileNorms;
        #[allow(private_interfaces)]
        fn convert(kernel: &dyn Kernel, it: Conversion<'_, '_, Self>);
        #[allow(private_interfaces)]
        fn convert_wide(kernel: &dyn Kernel, it: Conversion<'_, '_, Self, f64>);
    }

    macro_rules! steps {
        ($t:ident, $bits:expr, $norms:ident, $convert:ident, $widened:expr) => {
            impl Steps for $t {
                const INTEGER_BITS: i32 = $bits;

                #[allow(private_interfaces)]
                fn norms(kernel: &dyn Kernel, tile: &Tile<Self>) -> TileNorms {
                    kernel.$norms(tile)
                }

                #[allow(private_interfaces)]
                fn convert(kernel: &dyn Kernel, it: Conversion<'_, '_, Self>) {
                    kernel.$convert(it);
                }

                #[allow(private_interfaces)]
                fn convert_wide(kernel: &dyn Kernel, it: Conversion<'_, '_, Self, f64>) {
                    let Conversion { tile, powers, moduli, out, far } = it;
                    let widened: fn(&Tile<Self>) -> Cow<'_, Tile<f64>> = $widened;
                    let tile = &widened(tile);
                    kernel.convert_wide(Conversion { tile, powers, moduli, out, far });
                }
            }
        };
    }
    steps!(f32, 31, norms_f32, convert_f32, |tile| {
        Cow::Owned(Tile(tile.0.map(|row| row.map(f64::from))))
    });
    steps!(f64, 62, norms_f64, convert_f64, |tile| Cow::Borrowed(tile));
}
