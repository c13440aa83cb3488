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
//!
//! # Safety of this module
//!
//! Functions here do not check what they are passed. `SAFETY` comments name these clauses:
//!
//! - **`instructions`**: the CPU has the instructions of the `Vectors`.
//!   `instantiate!` enables them in the methods of a kernel value, which its `new` returns only
//!   where they were detected (`x86`) or always exist (`neon`, `portable`). All other functions
//!   that are generic in `Vectors` are inlined into these methods.
//! - **`sources`**: a source is a `MatRef`, whose entries inside its shape can be read, and the
//!   scale of a source has an element for each of its columns.
//! - **`sides`**: from `start` on, a side has `steps` rows of the columns that a step names. A
//!   packed side has whole panels of WIDTH columns, which `pack` has written before; a side in
//!   place is a source that has these rows and columns. `phase` and `small` see to it.
//! - **`sums`**: each tile has memory for ROWS x WIDTH scalars, one tile for each that is kept, and
//!   no other thread uses it. WIDTH is a multiple of LANES.
//! - **`targets`**: the entries that a target wants lie inside its block, which comes from a
//!   borrowed `MatMut`, and one thread at a time uses an entry: `schedule` hands out an item once.
//! - **`alignment`**: vectors are loaded and stored at any scalar, except past the caches: `phase`
//!   packs there, from the start of a cache line on, and only where the rows of a panel are whole
//!   cache lines, so that each vector is aligned.

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
