//! Guards against new intersections of faces of the new mesh.

use super::patch::{Flip, Move, Patch};
use crate::mesh::intersections::{Bounds, Corners, intersect};
use crate::mesh::vector::Vector;
use catamaran::base::Par;

/// Returns whether replacing the faces `old` by `new` creates no additional intersecting pairs.
fn allows(patch: &Patch, old: &[u32], new: &[Corners]) -> bool {
    let after = intersections(patch, old, new);
    after == 0 || after <= intersections_of(patch, old)
}

/// Returns whether replacing the faces `old` by `new` reduces the number of intersecting pairs.
fn untangles(patch: &Patch, old: &[u32], new: &[Corners]) -> bool {
    intersections(patch, old, new) < intersections_of(patch, old)
}

/// Returns the number of intersecting pairs of these faces with each other and with all others.
fn intersections_of(patch: &Patch, faces: &[u32]) -> usize {
    let corners: Vec<_> = faces.iter().map(|&f| patch.corners_of(f)).collect();
    intersections(patch, faces, &corners)
}

/// Returns whether an edge may flip.
pub(super) fn allows_flip(patch: &Patch, flip: &Flip) -> bool {
    allows(patch, &flip.old, &flip.new.map(|face| patch.corners_at(face)))
}

/// Returns whether the edge from a to b may collapse into p.
pub(super) fn allows_collapse(patch: &Patch, a: u32, b: u32, p: Vector) -> bool {
    let of_b = patch.around(b).iter().filter(|f| !patch.faces[**f as usize].contains(&a));
    let old: Vec<u32> = patch.around(a).iter().chain(of_b).copied().collect();
    let left = old.iter().map(|&f| patch.faces[f as usize]);
    let left = left.filter(|face| !(face.contains(&a) && face.contains(&b)));
    let new: Vec<Corners> = left.map(|face| patch.corners_with(face, [a, b], p)).collect();
    allows(patch, &old, &new)
}

/// Returns whether v may move to p.
pub(super) fn allows_move(patch: &Patch, v: u32, p: Vector) -> bool {
    allows(patch, patch.around(v), &faces_with(patch, v, p))
}

/// Returns whether moving v to p reduces the number of intersecting pairs.
pub(super) fn untangles_move(patch: &Patch, v: u32, p: Vector) -> bool {
    untangles(patch, patch.around(v), &faces_with(patch, v, p))
}

/// Returns whether flipping an edge reduces the number of intersecting pairs.
pub(super) fn untangles_flip(patch: &Patch, flip: &Flip) -> bool {
    untangles(patch, &flip.old, &flip.new.map(|face| patch.corners_at(face)))
}

/// Returns the faces at v after a move of v to p.
fn faces_with(patch: &Patch, v: u32, p: Vector) -> Vec<Corners> {
    let faces = patch.around(v).iter().map(|&f| patch.faces[f as usize]);
    faces.map(|face| patch.corners_with(face, [v, v], p)).collect()
}

/// Returns the number of intersecting pairs of these triangles with each other, and with all faces
/// except `without`.
fn intersections(patch: &Patch, without: &[u32], triangles: &[Corners]) -> usize {
    let mut count = 0;
    for (i, own) in triangles.iter().enumerate() {
        count += triangles[..i].iter().filter(|other| intersect(own, other)).count();
        patch.visit(&Bounds::of(own), |f| {
            let other = patch.corners_of(f);
            count += usize::from(!without.contains(&f) && intersect(own, &other));
        });
    }
    count
}

/// Moves all vertices at once, except those whose move would create new intersections.
pub(super) fn move_all(patch: &mut Patch, moves: &[Option<Move>], par: Par) {
    let mut before: Vec<Option<Move>> = vec![None; moves.len()];
    for (v, found) in (0..).zip(moves) {
        if let Some((p, anchor)) = *found {
            before[v as usize] = Some((patch.position(v), patch.anchors[v as usize]));
            patch.anchors[v as usize] = anchor;
            patch.displace(v, p);
        }
    }
    patch.plant_tree();
    let mut pairs = patch.tree().pairs(par, |f, g| is_new(patch, [f, g], &before));
    // Undoing a move may create another new intersection; then that move is undone, too.
    while !pairs.is_empty() {
        let mut faces = Vec::new();
        for v in pairs.iter().flatten().flat_map(|&f| patch.faces[f as usize]).collect::<Vec<_>>() {
            if let Some(earlier) = before[v as usize].take() {
                patch.move_to(v, earlier);
                faces.extend(patch.around(v));
            }
        }
        faces.sort_unstable();
        faces.dedup();
        pairs.clear();
        for f in faces {
            patch.visit(&Bounds::of(&patch.corners_of(f)), |g| {
                if g != f && is_new(patch, [f, g], &before) {
                    pairs.push([f, g]);
                }
            });
        }
    }
}

/// Returns whether two faces intersect now, and did not with vertices at their positions `before`.
fn is_new(patch: &Patch, pair: [u32; 2], before: &[Option<Move>]) -> bool {
    let [f, g] = pair.map(|f| patch.faces[f as usize]);
    let earlier = |v: u32| before[v as usize].map_or(patch.position(v), |was| was.0);
    intersect(&patch.corners_at(f), &patch.corners_at(g))
        && !intersect(&f.map(earlier), &g.map(earlier))
}
