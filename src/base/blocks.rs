//! The size of a block of rows.

use super::scalar::Real;

/// Bytes of the two blocks that are in memory; of all three where weights need one of their own.
const BLOCKS_BYTES: usize = 128 << 20;

/// Least rows of a block: fewer do not pay for the pass over C that each block takes.
const LEAST_ROWS: usize = 1024;

/// Returns the number of rows of a block of n columns: a multiple of 64, for about 64 MiB, or 1024
/// where these would be fewer. With weights it is two thirds of that: three blocks in the memory of
/// two. The number must not depend on threads or on the number of rows, because the result would
/// then depend on them too.
///
/// ```
/// use catamaran::base::block_rows;
///
/// assert_eq!(block_rows::<f64>(1 << 10, false), 8192);
/// assert_eq!(block_rows::<f32>(1 << 10, false), 16384);
/// ```
pub fn block_rows<T: Real>(n: usize, weighted: bool) -> usize {
    let row = n.max(1).saturating_mul(size_of::<T>());
    let rows = (BLOCKS_BYTES / 2 / row).max(LEAST_ROWS);
    let rows = if weighted { rows * 2 / 3 } else { rows };
    rows / 64 * 64
}
