//! Kernels: the innermost arithmetic of every product, for each instruction set.

pub mod int8;
pub mod packed;
#[cfg(test)]
mod rate;

/// Prefetches a cache line into the first-level cache, or into the second-level one if `FAR`; any
/// address is allowed.
#[cfg(target_arch = "aarch64")]
#[inline(always)]
fn prefetch<const FAR: bool>(address: *const u8) {
    // SAFETY: a hint, which reads nothing.
    unsafe {
        std::arch::asm!("prfm {level}, [{address}]", level = const 2 * FAR as u8,
            address = in(reg) address, options(nomem, nostack, preserves_flags));
    }
}

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
