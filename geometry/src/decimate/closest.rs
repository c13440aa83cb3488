//! Finds points of the surface near points in space, by walking from an earlier result.

use super::surface::Surface;
use crate::mesh::SurfacePoint;
use crate::mesh::vector::{Vector, dot, square, sub};

/// The end of a walk.
#[derive(Debug, Clone, Copy)]
pub(super) struct Found {
    pub place: SurfacePoint,
    pub point: Vector,
    /// A corner of the face.
    pub vertex: u32,
    pub square: f64,
}

/// Returns the nearest point of the surface that a walk from a vertex finds: first over vertices,
/// then downhill over faces.
pub(super) fn on_surface(surface: &Surface<'_>, from: u32, p: Vector) -> Option<Found> {
    let mut best: Option<Found> = None;
    let mut around = [Some(downhill(surface, from, p, 0.0).0), None];
    loop {
        let before = best.map(|found| found.square);
        for v in around.into_iter().flatten() {
            for &face in surface.faces_of.row(v as usize) {
                let (place, point) = SurfacePoint::nearest(&surface.mesh, face, p);
                let square = square(sub(point, p));
                if best.is_none_or(|best| square < best.square) {
                    best = Some(Found { place, point, vertex: v, square });
                }
            }
        }
        let found = best?;
        let corners = surface.mesh.faces()[found.place.face as usize];
        let weights = found.place.weights;
        // Inside of a face, no other face nearby is nearer; at its edge or corner, the adjacent
        // ones may be.
        if before == Some(found.square) || weights.iter().all(|&w| w > 0.0) {
            return Some(Found { vertex: corners[found.place.heaviest()], ..found });
        }
        let mut ends = (0..3).filter(|&k| weights[k] > 0.0).map(|k| corners[k]);
        around = [ends.next(), ends.next()];
    }
}

/// Returns the same for a vertex of the new mesh with this anchor: along the boundary if the anchor
/// is there.
pub(super) fn nearest(
    surface: &Surface<'_>,
    anchor: u32,
    is_on_boundary: bool,
    p: Vector,
) -> Option<Found> {
    if is_on_boundary { on_boundary(surface, anchor, p) } else { on_surface(surface, anchor, p) }
}

/// Returns the nearest point of the boundary, from a vertex on it.
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

/// Returns the vertex at the end of a walk from a vertex over edges, each of which leads nearer to
/// p, with the square of its distance. The walk ends where that is at most `enough`.
pub(super) fn downhill(surface: &Surface<'_>, from: u32, p: Vector, enough: f64) -> (u32, f64) {
    let mut at = from;
    let mut least = square(sub(surface.position(at), p));
    while least > enough {
        let here = at;
        for link in surface.links(here) {
            let found = square(sub(surface.position(link.to), p));
            if found < least {
                (least, at) = (found, link.to);
            }
        }
        if at == here {
            break;
        }
    }
    (at, least)
}

/// Returns the point at the share `t` of the edge from a to b as a point of a face.
fn on_edge(surface: &Surface<'_>, a: u32, b: u32, t: f64) -> Option<SurfacePoint> {
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
    Some(SurfacePoint { face, weights: faces[face as usize].map(weight) })
}

/// Returns the position between a (0) and b (1) of the point of the segment nearest to p.
fn along(a: Vector, b: Vector, p: Vector) -> f64 {
    let edge = sub(b, a);
    let t = dot(sub(p, a), edge) / dot(edge, edge);
    if t.is_nan() { 0.0 } else { t.clamp(0.0, 1.0) }
}
