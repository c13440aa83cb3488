//! How much memory a file may make its reader take. A header of a few bytes can announce terabytes,
//! and a small packed file can hold them.

use std::fmt::Display;

use crate::base::{Progress, byte_size, options};

/// Memory that a file may always take. A file that asks for more than this, and for more than
/// [`RATIO`] times its size, is damaged or malicious.
const LEAST: u64 = 1 << 30;

/// Ratio of unpacked to packed size: usual files reach about 20, a decompression bomb a thousand.
const RATIO: u64 = 100;

/// A line takes at most this part of the memory of a file.
const LINES: u64 = 64;

/// The end of a message about a file that takes more memory than it may. The command line puts the
/// name of its option in the place of this one.
#[doc(hidden)]
pub const LARGER_MAX_MEMORY: &str = "a larger max_memory allows it";

options! {
    /// How a file that is not a matrix is read: a mesh, a plant. The default suits usual files.
    #[derive(Debug, Clone, Copy)]
    pub struct SourceOptions<'a> {
        /// Bytes of memory that the file may take, for what it unpacks to and for what its header
        /// announces; `None`: a hundred times its size, or 1 GiB if that is more. A line of text
        /// may take a 64th.
        max_memory: Option<u64> = None, setter into;
        /// Receives the fraction of the file that has been read; may cancel.
        progress: Progress<'a> = Progress::none(), setter into;
    }
}

/// Returns the bytes of memory that a file of `size` bytes may take; the caller may set a limit.
pub(super) fn memory_limit(size: u64, max_memory: Option<u64>) -> u64 {
    max_memory.unwrap_or_else(|| size.saturating_mul(RATIO).max(LEAST))
}

/// Returns the length of the longest line of a file that may take so much memory.
pub(super) fn longest_line(memory: u64) -> usize {
    usize::try_from(memory / LINES).unwrap_or(usize::MAX)
}

/// Returns a message when `what` takes more bytes than the `limit` of the file.
pub(super) fn check_memory(limit: u64, what: impl Display, bytes: u64) -> Result<(), String> {
    if bytes <= limit {
        return Ok(());
    }
    let (needed, limit) = (byte_size(bytes as f64), byte_size(limit as f64));
    Err(format!(
        "{what} would take {needed} of memory, and this file may take {limit}: {LARGER_MAX_MEMORY}"
    ))
}
