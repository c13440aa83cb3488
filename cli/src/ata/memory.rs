//! How much memory a product may take.

use crate::ranks::Ranks;

/// Returns the bytes that a product may take by default: four fifths of the memory that is
/// available to the process, which shares it with the others on its machine.
pub fn allowed(ranks: &Ranks) -> usize {
    usize::try_from(ranks.available_memory() / 5 * 4).unwrap_or(usize::MAX)
}
