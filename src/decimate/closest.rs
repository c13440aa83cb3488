//! Points of the surface near points in space, found by walking from where one was.

use super::result::Place;
use super::surface::Surface;
use crate::mesh::TriMesh;
use crate::mesh::vector::{Vector, dot, sub};

/// Where a walk ended.
#[derive(Debug, Clone, Copy)]
pub(super) struct Found {
    pub place: Place,
    pub point: Vector,
    /// A corner of the face.
    pub vertex: u32,
    pub square: f64,
}

/// The nearest point of the surface that a walk from a vertex meets: over the vertices first, then over faces, downhill.
pub(super) fn on_surface(surface: &Surface<'_>, from: u32, p: Vector) -> Option<Found> {
    let mut best: Option<Found> = None;
    let mut around = [Some(downhill(surface, from, p)), None];
    loop {
        let before = best.map(|found| found.square);
        for v in around.into_iter().flatten() {
            for &face in surface.faces_of.row(v as usize) {
                let (point, weights) = on_face(&surface.mesh, face, p);
                let square = square(sub(point, p));
                if best.is_none_or(|best| square < best.square) {
                    best = Some(Found { place: Place { face, weights }, point, vertex: v, square });
                }
            }
        }
        let found = best?;
        let corners = surface.mesh.faces()[found.place.face as usize];
        let weights = found.place.weights;
        // Within a face, no other one is nearer nearby; else those may be that meet at its edge or corner.
        if before == Some(found.square) || weights.iter().all(|&w| w > 0.0) {
            let heaviest = (0..3).max_by(|&i, &j| weights[i].total_cmp(&weights[j])).unwrap_or(0);
            return Some(Found { vertex: corners[heaviest], ..found });
        }
        let mut ends = (0..3).filter(|&k| weights[k] > 0.0).map(|k| corners[k]);
        around = [ends.next(), ends.next()];
    }
}

/// The same along the boundary, from a vertex there.
pub(super) fn on_boundary(surface: &Surface<'_>, from: u32, p: Vector) -> Option<Found> {
    let mut best: Option<(f64, [u32; 2], f64)> = None;
    let mut at = from;
    loop {
        let before = best;
        for next in surface.along_boundary(at)? {
            let (a, b) = (surface.position(at), surface.position(next));
            let t = along(a, b, p);
            let point: Vector = std::array::from_fn(|k| a[k] + t * (b[k] - a[k]));
            let square = square(sub(point, p));
            if best.is_none_or(|best| square < best.0) {
                best = Some((square, [at, next], t));
            }
        }
        let (square, [a, b], t) = best?;
        let nearer = if t > 0.5 { b } else { a };
        if before.is_some_and(|before| square >= before.0) || nearer == at {
            let (p, q) = (surface.position(a), surface.position(b));
            let point = std::array::from_fn(|k| p[k] + t * (q[k] - p[k]));
            let place = on_edge(surface, a, b, t)?;
            return Some(Found { place, point, vertex: nearer, square });
        }
        at = nearer;
    }
}

fn downhill(surface: &Surface<'_>, from: u32, p: Vector) -> u32 {
    let mut at = from;
    let mut least = square(sub(surface.position(at), p));
    loop {
        let here = at;
        for link in surface.links(here) {
            let found = square(sub(surface.position(link.to), p));
            if found < least {
                (least, at) = (found, link.to);
            }
        }
        if at == here {
            return at;
        }
    }
}

/// The point at the part `t` of the edge from a to b as a point of a face.
fn on_edge(surface: &Surface<'_>, a: u32, b: u32, t: f64) -> Option<Place> {
    let faces = surface.mesh.faces();
    let face =
        *surface.faces_of.row(a as usize).iter().find(|&&f| faces[f as usize].contains(&b))?;
    let weight = |v: u32| {
        if v == a {
            1.0 - t
        } else if v == b {
            t
        } else {
            0.0
        }
    };
    Some(Place { face, weights: faces[face as usize].map(weight) })
}

/// Where between a (0) and b (1) the segment is nearest to p.
fn along(a: Vector, b: Vector, p: Vector) -> f64 {
    let edge = sub(b, a);
    let t = dot(sub(p, a), edge) / dot(edge, edge);
    if t.is_nan() { 0.0 } else { t.clamp(0.0, 1.0) }
}

fn square(a: Vector) -> f64 {
    dot(a, a)
}

/// The nearest point of a face of `mesh` and its barycentric coordinates (Ericson, Real-Time Collision Detection, 2005,
/// section 5.1.5).
pub(super) fn on_face(mesh: &TriMesh, face: u32, p: Vector) -> (Vector, [f64; 3]) {
    let [a, b, c] = mesh.faces()[face as usize].map(|v| mesh.vertices()[v as usize]);
    let weights = weights_on_triangle([a, b, c], p);
    let point = std::array::from_fn(|k| weights[0] * a[k] + weights[1] * b[k] + weights[2] * c[k]);
    (point, weights)
}

/// Barycentric coordinates of the point of the triangle nearest to p.
pub(super) fn weights_on_triangle([a, b, c]: [Vector; 3], p: Vector) -> [f64; 3] {
    let (ab, ac, ap) = (sub(b, a), sub(c, a), sub(p, a));
    let (d1, d2) = (dot(ab, ap), dot(ac, ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let bp = sub(p, b);
    let (d3, d4) = (dot(ab, bp), dot(ac, bp));
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let t = if d1 - d3 > 0.0 { d1 / (d1 - d3) } else { 0.0 };
        return [1.0 - t, t, 0.0];
    }
    let cp = sub(p, c);
    let (d5, d6) = (dot(ab, cp), dot(ac, cp));
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 0.0, 1.0];
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let t = if d2 - d6 > 0.0 { d2 / (d2 - d6) } else { 0.0 };
        return [1.0 - t, 0.0, t];
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        let total = (d4 - d3) + (d5 - d6);
        let t = if total > 0.0 { (d4 - d3) / total } else { 0.0 };
        return [0.0, 1.0 - t, t];
    }
    let total = va + vb + vc;
    if total <= 0.0 || !total.is_finite() {
        return [1.0, 0.0, 0.0];
    }
    [va / total, vb / total, vc / total]
}
