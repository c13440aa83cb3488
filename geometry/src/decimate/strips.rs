//! Cuts slender faces into strips of triangles.

use super::splits::Splits;
use crate::mesh::vector::{doubled_normal, norm};
use catamaran::base::{Result, room};

/// Length over height above which a face is cut into a strip. Split in their middle, its edges
/// would leave three or four faces of the same shape in each round: r^1.6 or r^2 faces, where the
/// length is r times the longest edge that may stay, instead of some 2 r.
const SLENDER: f64 = 4.0;

/// Returns the corners of a slender face, beginning with the ends of its longest side, which has to
/// be split; `None` for all other faces.
pub(super) fn slender([a, b, c]: [u32; 3], splits: &Splits) -> Option<[u32; 3]> {
    let turns = [[a, b, c], [b, c, a], [c, a, b]];
    let sides = turns.map(|face| (splits.length(face[0], face[1]), face));
    let (length, face) = sides.into_iter().reduce(|x, y| if y.0 > x.0 { y } else { x })?;
    let height = norm(doubled_normal(face.map(|v| splits.position(v)))) / length;
    let is_slender =
        height * splits.stretch_of(&face) <= splits.longest && SLENDER * height < length;
    (is_slender && splits.is_long(face[0], face[1])).then_some(face)
}

/// Adds the triangles between the longest side of a face, from its first corner to its second, and
/// the other two sides, all of which are split to the end.
pub(super) fn cut_strip(
    [a, b, c]: [u32; 3],
    splits: &mut Splits,
    faces: &mut Vec<[u32; 3]>,
) -> Result<()> {
    let lower = splits.chain(a, b)?;
    let mut upper = splits.chain(a, c)?;
    let rest = splits.chain(c, b)?;
    room(&mut upper, rest.len())?;
    upper.extend(&rest[1..]);
    let last = [lower.len() - 2, upper.len() - 2];
    room(faces, last[0] + last[1])?;
    // Both rails start at a and end at b; between them, each triangle takes the shorter way across.
    let (mut i, mut k) = (1, 1);
    faces.push([a, lower[1], upper[1]]);
    while i < last[0] || k < last[1] {
        let across = |i: usize, k: usize| splits.length(lower[i], upper[k]);
        if k == last[1] || (i < last[0] && across(i + 1, k) <= across(i, k + 1)) {
            faces.push([lower[i], lower[i + 1], upper[k]]);
            i += 1;
        } else {
            faces.push([lower[i], upper[k + 1], upper[k]]);
            k += 1;
        }
    }
    faces.push([lower[i], b, upper[k]]);
    Ok(())
}
