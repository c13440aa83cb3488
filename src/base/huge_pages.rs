//! Large pages of the memory of Linux.

/// Bytes of a huge page.
pub(super) const HUGE_PAGE: usize = 2 << 20;

/// Asks the system for huge pages where `block` has room for two of them: when they are touched,
/// the system clears them many times faster than small ones.
#[cfg(target_os = "linux")]
pub(super) fn ask_for_huge_pages<T>(block: &mut [T]) {
    if size_of_val(block) < 2 * HUGE_PAGE {
        return;
    }
    let start = block.as_mut_ptr().cast::<u8>();
    let skipped = start.align_offset(HUGE_PAGE);
    let bytes = (size_of_val(block) - skipped) / HUGE_PAGE * HUGE_PAGE;
    // SAFETY: whole pages inside the block, which is longer than what is skipped; the advice
    // changes no contents, and may be refused.
    unsafe { libc::madvise(start.add(skipped).cast(), bytes, libc::MADV_HUGEPAGE) };
}

#[cfg(not(target_os = "linux"))]
pub(super) fn ask_for_huge_pages<T>(_block: &mut [T]) {}
