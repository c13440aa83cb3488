//! Packed products of floating-point matrices: the arithmetic of the native path.
//!
//! Both sides of a product are packed into panels of the same width, so that one packing of A
//! serves both sides of A^T A. Packing reads a signed sum of blocks, and a finished tile is added
//! to several blocks of C: levels of a fast scheme cost no scratch matrices
//! (docs/algorithms/ata.md). Narrow matrices stored by rows are not packed but read in place.
//!
//! The algorithm (`pack`, `tile`, `in_place`, `write`) is written once in terms of `vectors`, and
//! instantiated for each instruction set (`kernel`, `portable`, `neon`, `x86`). `schedule` runs it
//! on many threads, `small` on one without preparations.

mod blocking;
mod geometry;
mod in_place;
mod isa;
mod kernel;
#[cfg(target_arch = "aarch64")]
mod neon;
mod operand;
mod operands;
mod pack;
mod phase;
mod portable;
mod rates;
mod schedule;
mod small;
mod target;
#[cfg(test)]
mod tests;
mod tile;
mod tuning;
mod vectors;
mod write;
#[cfg(target_arch = "x86_64")]
mod x86;

pub(crate) use blocking::Blocking;
pub(crate) use geometry::Geometry;
pub use isa::FloatIsa;
pub(crate) use kernel::Kernel;
pub use operand::FloatOperand;
pub(crate) use operands::{KernelProduct, Shape, Source};
pub use rates::Rates;
pub(crate) use schedule::{Job, run, scratch_len};
pub(crate) use small::{is_small, run_small};
pub(crate) use target::{Destination, Part};
