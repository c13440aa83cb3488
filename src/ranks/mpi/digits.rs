//! Exact sums as numbers that a reduction in floating point adds without rounding.

use crate::product::exact::Flags;

/// Parts in which a sum is sent: 32 bits each, as floating-point numbers whose sums are exact, and
/// the number of ranks with each kind of terms that are not finite.
pub(super) const PARTS: usize = 5;

/// Returns one part of what is sent for entry (i, j).
pub(super) fn part_of((c, flags): (i128, Flags), part: usize) -> f64 {
    match part {
        0..3 => f64::from((c >> (32 * part)) as u32),
        3 => f64::from((c >> 96) as i32),
        // One digit of base 2^16 for each kind of flag: enough for 2^16 ranks.
        _ => (0..2).map(|bit| f64::from(flags.0 >> bit & 1) * f64::from(16 * bit).exp2()).sum(),
    }
}

/// Returns the sum of the parts of all ranks.
pub(super) fn whole(parts: &[f64; PARTS]) -> (i128, Flags) {
    let c = (0..4).map(|part| (parts[part] as i128) << (32 * part)).sum();
    let counts = parts[4] as u64;
    let flag = |bit: u32| u8::from(counts >> (16 * bit) & 0xffff != 0) << bit;
    (c, Flags((0..2).map(flag).sum()))
}
