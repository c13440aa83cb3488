//! How fast the kernels are on this machine: built-in numbers, measured ones, and a file of them.

mod cache;
mod cpu;
mod measure;
mod text;

use super::isa::Isa;

/// Speed of one core with one instruction set, for the planner. Estimates: a wrong one costs time,
/// never correctness.
///
/// There is no global state: rates that were measured and saved are read on request only
/// ([`Rates::cached`]).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rates {
    /// Flops per second (a multiply-add counts two) of tiles whose operands are in the caches, f64;
    /// f32 runs at twice that.
    pub flops: f64,
    /// Bytes per second that packing reads from matrices which fit no cache.
    pub read_bytes: f64,
    /// Bytes per second that packing writes into panels.
    pub pack_bytes: f64,
    /// Bytes per second (reads plus writes) of adding finished tiles to a matrix that fits no
    /// cache.
    pub update_bytes: f64,
}

impl Rates {
    /// Returns the built-in rates, which apply where nothing was measured.
    ///
    /// ```
    /// use catamaran::kernel::packed::{Isa, Rates};
    ///
    /// assert!(Rates::of(Isa::Avx2).flops > Rates::of(Isa::Portable).flops);
    /// ```
    pub fn of(isa: Isa) -> Self {
        let flops = match isa {
            Isa::Avx512 => 85e9,
            Isa::Avx2 => 50e9,
            Isa::Portable => 14e9,
        };
        Self { flops, read_bytes: 15e9, pack_bytes: 20e9, update_bytes: 20e9 }
    }
}
