//! How much memory a product may take.

use catamaran::base::available_memory;

/// Returns the bytes that a product may take by default: four fifths of the memory that is
/// available to the process.
pub fn allowed() -> usize {
    usize::try_from(available_memory() / 5 * 4).unwrap_or(usize::MAX)
}
