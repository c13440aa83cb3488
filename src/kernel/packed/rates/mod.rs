//! Rates of the kernels on this machine: built-in, measured, or read from a file.

mod cache;
mod cpu;
mod measure;
mod text;

use super::isa::FloatIsa;

/// Rates of one core with one instruction set, for the planner. A wrong rate costs time, never
/// correctness.
///
/// There is no global state: saved rates are read on request only ([`Rates::cached`]).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rates {
    /// Flops per second (a multiply-add counts two) of f64 tiles whose operands are in the caches;
    /// f32 is assumed to run twice as fast.
    pub flops: f64,
    /// Bytes per second that packing reads from matrices that fit no cache.
    pub read_bytes: f64,
    /// Bytes per second that packing writes into panels.
    pub pack_bytes: f64,
    /// Bytes per second (reads plus writes) of adding finished tiles to a matrix that fits no
    /// cache.
    pub update_bytes: f64,
}

impl Rates {
    /// Returns the built-in rates, for machines without measured rates.
    ///
    /// ```
    /// use catamaran::kernel::packed::{FloatIsa, Rates};
    ///
    /// assert!(Rates::of(FloatIsa::Avx2).flops > Rates::of(FloatIsa::Portable).flops);
    /// ```
    pub fn of(isa: FloatIsa) -> Self {
        let flops = match isa {
            FloatIsa::Avx512 => 85e9,
            FloatIsa::Avx2 => 50e9,
            // Two FMA pipelines at 3 GHz; not measured.
            FloatIsa::Neon => 24e9,
            FloatIsa::Portable => 14e9,
        };
        Self { flops, read_bytes: 15e9, pack_bytes: 20e9, update_bytes: 20e9 }
    }
}
