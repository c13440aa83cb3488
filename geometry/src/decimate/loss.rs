//! Measures how far a change of the new mesh would deviate from the surface.

use super::patch::Patch;
use crate::mesh::nearest_on_triangle;
use crate::mesh::vector::{Vector, cross, dot, norm, square, sub, unit};

/// Returns the vector to q from the nearest point of the faces around v, with v at p.
pub(super) fn gap_of_move(patch: &Patch, v: u32, p: Vector, q: Vector) -> Vector {
    gap(patch, q, patch.around(v).iter(), [v, v], p)
}

/// Returns the distance of the ends of the edge from a to b from the faces around p after a
/// collapse of the edge to p.
pub(super) fn loss_of_collapse(patch: &Patch, a: u32, b: u32, p: Vector) -> f64 {
    let lost = |q: u32| {
        let without = |v: u32| move |f: &&u32| !patch.faces[**f as usize].contains(&v);
        let of_a = patch.around(a).iter().filter(without(b));
        let of_b = patch.around(b).iter().filter(without(a));
        norm(gap(patch, patch.position(q), of_a.chain(of_b), [a, b], p))
    };
    lost(a).max(lost(b))
}

/// Returns the distance of the edge from a to b from the edge from c to d, along the normal of
/// both.
pub(super) fn loss_of_flip(patch: &Patch, [a, b]: [u32; 2], [c, d]: [u32; 2]) -> f64 {
    let [a, b, c, d] = [a, b, c, d].map(|v| patch.position(v));
    dot(sub(c, a), unit(cross(sub(b, a), sub(d, c)))).abs()
}

/// Returns the vector to q from the nearest point of these faces, with the vertices `moved` at p.
fn gap<'a>(
    patch: &Patch,
    q: Vector,
    faces: impl Iterator<Item = &'a u32>,
    moved: [u32; 2],
    p: Vector,
) -> Vector {
    let mut nearest = ([0.0; 3], f64::INFINITY);
    for &f in faces {
        let corners = patch.corners_with(patch.faces[f as usize], moved, p);
        let step = sub(q, nearest_on_triangle(corners, q).0);
        let square = square(step);
        if square < nearest.1 {
            nearest = (step, square);
        }
    }
    nearest.0
}
