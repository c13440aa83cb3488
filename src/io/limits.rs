//! How much memory a file may make its reader take. A header of a few bytes can announce terabytes,
//! and a small packed file can hold them.

use std::fmt::Display;

use crate::base::{Progress, builder};

/// Memory that a file may take, at least: more than this, and than [`RATIO`] times its size, is
/// asked for by a damaged file or by one that is made to.
const LEAST: u64 = 1 << 30;

/// What people pack has ratios of up to about 20; a bomb has a thousand.
const RATIO: u64 = 100;

/// Of the memory of a file a line takes at most this part.
const LINES: u64 = 64;

/// How a file is read that is not a matrix: a mesh, a plant. The default suits what people have.
#[derive(Debug, Clone, Copy, Default)]
#[non_exhaustive]
pub struct SourceOptions<'a> {
    /// Bytes of memory that the file may take, for what it unpacks to and for what its header
    /// announces; default a hundred times its size, or 1 GiB if that is more. A line of text may
    /// take a 64th.
    pub max_memory: Option<u64>,
    /// Told the fraction of the file read; may cancel.
    pub progress: Progress<'a>,
}

builder! { SourceOptions<'a> {
    #[into] max_memory: Option<u64>,
    #[into] progress: Progress<'a>,
}}

/// The bytes of memory that a file of `size` bytes may take, where the caller may have set a limit.
pub(super) fn memory_limit(size: u64, max_memory: Option<u64>) -> u64 {
    max_memory.unwrap_or_else(|| size.saturating_mul(RATIO).max(LEAST))
}

/// The longest line of a file that may take so much.
pub(super) fn longest_line(memory: u64) -> usize {
    usize::try_from(memory / LINES).unwrap_or(usize::MAX)
}

/// What is wrong when `what` takes so many bytes, and a file may take `limit`, if anything is.
pub(super) fn check_memory(limit: u64, what: impl Display, bytes: u64) -> Result<(), String> {
    if bytes <= limit {
        return Ok(());
    }
    let gib = |bytes: u64| bytes as f64 / f64::from(1 << 30);
    Err(format!(
        "{what} would take {:.2} GiB of memory, and this file may take {:.2} GiB: a larger \
         max_memory (--max-memory) allows it",
        gib(bytes),
        gib(limit)
    ))
}
