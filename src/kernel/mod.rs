//! Kernels: the innermost arithmetic of every product, for each instruction set.

pub mod int8;
pub mod packed;

/// Orders the non-temporal stores (past the caches) of this thread before its later stores, for
/// other threads. Does nothing unless `past_caches`.
#[inline]
fn finish_stores(past_caches: bool) {
    if past_caches {
        #[cfg(target_arch = "x86_64")]
        // SAFETY: every x86-64 CPU has the instruction.
        unsafe {
            std::arch::x86_64::_mm_sfence();
        }
    }
}
