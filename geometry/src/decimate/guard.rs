//! Guards against new intersections of faces of the new mesh.

use super::patch::{Flip, Move, Patch};
use crate::mesh::intersections::{Bounds, Corners, intersect};
use crate::mesh::vector::{Vector, add, cross, dot, sub};
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
    let plain = plain_stars(patch, par);
    let meet = |f, g| !in_plain_star(patch, [f, g], &plain) && is_new(patch, [f, g], &before);
    let mut pairs = patch.tree().pairs(par, meet);
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

/// Number of vertices whose stars one thread tests at a time.
const BLOCK: usize = 1024;

/// Returns for each vertex whether its faces certainly do not intersect each other, as nearly all
/// do not: six triangles are cheaper to test together than in fifteen pairs.
fn plain_stars(patch: &Patch, par: Par) -> Vec<bool> {
    let vertices = patch.positions().len();
    let test = |v: usize| !patch.on_boundary[v] && is_plain(patch, v as u32);
    par.map_blocks(vertices, BLOCK, |range| range.map(test).collect::<Vec<_>>()).concat()
}

/// An upper bound of the rounding error of a determinant of three differences, relative to the
/// product of their longest components.
const ERROR: f64 = 1e-13;

/// Returns whether the faces around a vertex inside certainly, beyond rounding, are the graph of a
/// function over a plane: seen along one direction, all turn the same way, and no other face is
/// behind the middle of the first, so that they go around the vertex once.
fn is_plain(patch: &Patch, v: u32) -> bool {
    let here = patch.position(v);
    let longest = |p: Vector| p.iter().fold(0.0f64, |most, x| most.max(x.abs()));
    let sides = |f: u32| {
        let [x, y, z] = patch.faces[f as usize];
        let [a, b] = if x == v {
            [y, z]
        } else if y == v {
            [z, x]
        } else {
            [x, y]
        };
        [a, b].map(|w| sub(patch.position(w), here))
    };
    let faces = patch.around(v);
    let Some(&first) = faces.first() else { return true };
    let mut normal = [0.0; 3];
    for &f in faces {
        let [a, b] = sides(f);
        normal = add(normal, cross(a, b));
    }
    let [a, b] = sides(first);
    let towards = add(a, b);
    let across = cross(towards, normal);
    let (size, width) = (longest(normal), longest(towards));
    faces.iter().all(|&f| {
        let [a, b] = sides(f);
        let [to_a, to_b] = [longest(a), longest(b)];
        // The determinants of the normal, a and b, of the normal, a and the direction towards the
        // first face, and of the normal, that direction and b.
        dot(normal, cross(a, b)) > ERROR * size * to_a * to_b
            && (f == first
                || dot(a, across) < -ERROR * size * width * to_a
                || dot(b, across) > ERROR * size * width * to_b)
    })
}

/// Returns whether two faces have a corner whose faces do not intersect each other.
fn in_plain_star(patch: &Patch, [f, g]: [u32; 2], plain: &[bool]) -> bool {
    let [f, g] = [f, g].map(|f| patch.faces[f as usize]);
    f.iter().any(|v| g.contains(v) && plain[*v as usize])
}

/// Returns whether two faces intersect now, and did not with vertices at their positions `before`.
fn is_new(patch: &Patch, pair: [u32; 2], before: &[Option<Move>]) -> bool {
    let [f, g] = pair.map(|f| patch.faces[f as usize]);
    let earlier = |v: u32| before[v as usize].map_or(patch.position(v), |was| was.0);
    intersect(&patch.corners_at(f), &patch.corners_at(g))
        && !intersect(&f.map(earlier), &g.map(earlier))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::families;
    use catamaran::base::Rng;

    /// Faces around vertex 0 through these points.
    fn fan(ring: &[Vector]) -> Patch {
        let around = ring.len() as u32;
        let positions: Vec<Vector> = [[0.0; 3]].into_iter().chain(ring.iter().copied()).collect();
        let faces = (0..around).map(|i| [0, 1 + i, 1 + (i + 1) % around]).collect();
        Patch::new(positions, vec![0; ring.len() + 1], faces)
    }

    fn intersect_at(patch: &Patch, v: u32) -> bool {
        let faces = patch.around(v);
        let pairs = faces.iter().flat_map(|f| faces.iter().map(move |g| (f, g)));
        let mut pairs = pairs.filter(|(f, g)| f < g);
        pairs.any(|(&f, &g)| intersect(&patch.corners_of(f), &patch.corners_of(g)))
    }

    #[test]
    fn faces_around_a_vertex_that_is_plain_do_not_intersect() {
        let mut rng = Rng::new(17);
        let (mut plain, mut crossed) = (0, 0);
        for round in 0..4000 {
            let around = 3 + round % 6;
            let turn = std::f64::consts::TAU / around as f64;
            let ring: Vec<Vector> = (0..around)
                .map(|i| {
                    let angle = turn * (i as f64 + 1.6 * rng.uniform());
                    [angle.cos(), angle.sin(), 0.8 * rng.normal()]
                })
                .collect();
            let patch = fan(&ring);
            let is_crossed = intersect_at(&patch, 0);
            assert!(!(is_plain(&patch, 0) && is_crossed), "{ring:?}");
            plain += usize::from(is_plain(&patch, 0));
            crossed += usize::from(is_crossed);
        }
        assert!(plain > 200 && crossed > 20, "{plain} plain, {crossed} crossed");
    }

    #[test]
    fn a_fan_that_goes_around_twice_is_not_plain_and_those_of_a_sphere_are() {
        let twice: Vec<Vector> = (0..6)
            .map(|i| {
                let angle = std::f64::consts::TAU / 3.0 * f64::from(i);
                [angle.cos(), angle.sin(), 0.1 * f64::from(i)]
            })
            .collect();
        assert!(intersect_at(&fan(&twice), 0) && !is_plain(&fan(&twice), 0));
        let (vertices, faces) = families::icosphere(3).unwrap().into_parts();
        let sphere = Patch::new(vertices.clone(), vec![0; vertices.len()], faces);
        assert!(plain_stars(&sphere, Par::Seq).into_iter().all(|is_plain| is_plain));
    }
}
