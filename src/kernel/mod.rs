//! Kernels: the arithmetic that everything above is made of, per instruction set.

pub mod int8;
pub mod packed;

/// Shows the stores past the caches that this thread has made, if it has made any, to other threads
/// before every later store.
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
