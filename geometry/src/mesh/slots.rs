//! Triangles that are glued along their edges. Slot 3 f + k is the edge of triangle f from its
//! corner k to corner k + 1 (mod 3).

/// Marks the absence of a slot.
pub(crate) const NONE: u32 = u32::MAX;

/// Returns the next slot of the same triangle.
pub(crate) fn next(slot: u32) -> u32 {
    if slot % 3 == 2 { slot - 2 } else { slot + 1 }
}

/// Returns the previous slot of the same triangle.
pub(crate) fn previous(slot: u32) -> u32 {
    next(next(slot))
}

/// Replaces the edge of a slot by the other diagonal of its two triangles; afterwards it is slot 0
/// of both. `twins` has for each slot the slot on the other side, which runs the other way, or
/// [`NONE`]. Returns the old and the new slots of the other four sides.
pub(crate) fn flip(faces: &mut [[u32; 3]], twins: &mut [u32], slot: u32) -> [(u32, u32); 4] {
    let twin = twins[slot as usize];
    let (f, g) = (slot / 3, twin / 3);
    // Triangles (i, j, k) and (j, i, l), with the edge i j in common.
    let (jk, ki) = (next(slot), previous(slot));
    let (il, lj) = (next(twin), previous(twin));
    let [i, j, k, l] = [slot, twin, ki, lj].map(|s| faces.as_flattened()[s as usize]);
    let moved = [(lj, 3 * f + 1), (jk, 3 * f + 2), (ki, 3 * g + 1), (il, 3 * g + 2)];
    let others = moved.map(|(old, _)| twins[old as usize]);
    faces[f as usize] = [k, l, j];
    faces[g as usize] = [l, k, i];
    twins[3 * f as usize] = 3 * g;
    twins[3 * g as usize] = 3 * f;
    for ((_, new), other) in moved.into_iter().zip(others) {
        // Two sides of the quadrilateral may be glued to each other.
        let other = moved.iter().find(|m| m.0 == other).map_or(other, |m| m.1);
        twins[new as usize] = other;
        if other != NONE {
            twins[other as usize] = new;
        }
    }
    moved
}
