//! Packed products of floating-point matrices: the arithmetic of the native path.
//!
//! Both sides of a product are packed into panels of the same width, so that one packing of A serves
//! both sides of A^T A. Packing reads a signed sum of blocks, and a finished tile is added to several
//! blocks of C: levels of a fast scheme cost no scratch matrices (docs/algorithms/ata.md).
//!
//! The algorithm (`generic.rs`) is written once and instantiated for each instruction set.

mod blocking;
mod generic;
mod operands;
mod portable;
mod rates;
mod schedule;
mod small;
#[cfg(test)]
mod tests;
#[cfg(target_arch = "x86_64")]
mod x86;

pub(crate) use blocking::Blocking;
pub(crate) use operands::{Destination, Part, Product, Shape, Source, Target};
pub(crate) use schedule::{Job, run, scratch_len};
pub(crate) use small::{is_small, run_small};

pub use rates::Rates;

use std::ops::Range;

pub(crate) use generic::Row;

use crate::base::Real;

/// An instruction set that the kernels are written for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Isa {
    /// AVX-512.
    Avx512,
    /// AVX2 with FMA.
    Avx2,
    /// Plain Rust.
    Portable,
}

impl Isa {
    /// All of them, the fastest first.
    pub const ALL: [Self; 3] = [Self::Avx512, Self::Avx2, Self::Portable];

    /// Short name: `avx512`, `avx2`, `portable`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Avx512 => "avx512",
            Self::Avx2 => "avx2",
            Self::Portable => "portable",
        }
    }

    /// The fastest one that this machine has.
    pub fn best() -> Self {
        let usable = |i: &Self| i.refusal().is_none();
        Self::ALL.into_iter().find(usable).unwrap_or(Self::Portable)
    }

    /// Why this machine can't use it; `None` when it can.
    pub fn refusal(self) -> Option<&'static str> {
        match self {
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => x86::Avx512::new().err(),
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => x86::Avx2::new().err(),
            #[cfg(not(target_arch = "x86_64"))]
            Self::Avx512 | Self::Avx2 => Some("not an x86-64 CPU"),
            Self::Portable => None,
        }
    }
}

/// A scalar that the kernels are written for.
pub trait Operand: Real + sealed::Kernels {}

impl Operand for f32 {}
impl Operand for f64 {}

pub(crate) mod sealed {
    use super::*;

    pub trait Kernels: Sized {
        /// The kernel; that of [`Isa::Portable`] when this machine refuses the isa.
        #[allow(private_interfaces)]
        fn kernel(isa: Isa) -> &'static dyn Kernel<Self>;
    }

    macro_rules! kernels {
        ($t:ident) => {
            impl Kernels for $t {
                #[allow(private_interfaces)]
                fn kernel(isa: Isa) -> &'static dyn Kernel<Self> {
                    let portable: &'static dyn Kernel<Self> = &portable::Portable;
                    match isa {
                        #[cfg(target_arch = "x86_64")]
                        Isa::Avx512 => x86::Avx512::new().map_or(portable, |kernel| kernel),
                        #[cfg(target_arch = "x86_64")]
                        Isa::Avx2 => x86::Avx2::new().map_or(portable, |kernel| kernel),
                        _ => portable,
                    }
                }
            }
        };
    }
    kernels!(f32);
    kernels!(f64);
}

/// Rows and columns.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Area {
    pub rows: Range<usize>,
    pub cols: Range<usize>,
}

/// The i-th piece of `range`, cut into pieces of `length`.
fn piece(range: &Range<usize>, i: usize, length: usize) -> Range<usize> {
    let start = range.start + i * length;
    start..range.end.min(start + length)
}

/// The extents of a kernel's tiles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Geometry {
    /// Scalars of a vector.
    pub lanes: usize,
    /// Rows of a tile; they divide the width.
    pub rows: usize,
    /// Columns of a tile, and of a panel.
    pub width: usize,
}

/// The steps of a packed product, for one instruction set and scalar.
pub(crate) trait Kernel<T>: Sync {
    fn geometry(&self) -> Geometry;

    /// See `generic::multiply_row`.
    ///
    /// # Safety
    /// As there.
    unsafe fn multiply_row(&self, row: &Row<'_, T>);

    /// See `generic::pack`.
    ///
    /// # Safety
    /// As there.
    unsafe fn pack(&self, sources: &[Source<'_, T>], area: &Area, out: *mut T, panel_stride: usize);
}

/// Instantiates the algorithm: `instantiate!(Kernel, scalar, Vectors, attributes)`. The kernel exists
/// only where the CPU has the instructions.
macro_rules! instantiate {
    ($kernel:ident, $t:ident, $vectors:ty, $($enable:tt)*) => {
        impl super::Kernel<$t> for $kernel {
            fn geometry(&self) -> super::Geometry {
                use super::generic::Vectors as V;
                const { assert!(<$vectors>::WIDTH.is_multiple_of(<$vectors>::ROWS)) };
                super::Geometry {
                    lanes: <$vectors as V>::LANES,
                    rows: <$vectors as V>::ROWS,
                    width: <$vectors as V>::WIDTH,
                }
            }

            unsafe fn multiply_row(&self, row: &super::Row<'_, $t>) {
                $($enable)*
                unsafe fn multiply_row(row: &super::Row<'_, $t>) {
                    use super::generic::{Vectors as V, multiply_row};
                    // SAFETY: the caller's promise.
                    unsafe { multiply_row::<$vectors, { <$vectors as V>::ROWS }, { <$vectors as V>::COUNT }>(row) }
                }
                // SAFETY: the caller's promise; `self` exists, so the CPU has the instructions.
                unsafe { multiply_row(row) }
            }

            unsafe fn pack(
                &self,
                sources: &[super::Source<'_, $t>],
                area: &super::Area,
                out: *mut $t,
                panel_stride: usize,
            ) {
                $($enable)*
                unsafe fn pack(
                    sources: &[super::Source<'_, $t>],
                    area: &super::Area,
                    out: *mut $t,
                    panel_stride: usize,
                ) {
                    // SAFETY: the caller's promise.
                    unsafe { super::generic::pack::<$vectors>(sources, area, out, panel_stride) }
                }
                // SAFETY: the caller's promise; `self` exists, so the CPU has the instructions.
                unsafe { pack(sources, area, out, panel_stride) }
            }
        }
    };
}
use instantiate;
