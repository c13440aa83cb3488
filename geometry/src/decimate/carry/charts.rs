//! The texture of the input as a surface of its own, which ends at seams.

use std::collections::VecDeque;

use super::frame::{Frame, Uv, area};
use crate::mesh::io::Attribute;
use crate::mesh::vector::{Vector, dot, sub};
use crate::mesh::{Edges, SurfacePoint, TriMesh};

/// Marks the absence of a face.
const NONE: u32 = u32::MAX;

/// Distance below which texture coordinates are equal, relative to their extent: a few roundings to
/// single precision.
const SAME: f64 = 1e-6;

/// Ratio of the area of a face in the texture to the square of its longest side at or below which
/// it has no orientation.
const NO_AREA: f64 = 1e-9;

/// Number of faces that are searched around a face without area for a frame.
const NEARBY: usize = 64;

/// A mesh and its texture.
pub(super) struct Charts<'a> {
    mesh: &'a TriMesh,
    uv: &'a Attribute<2>,
    /// For each corner the face across the edge that starts there, if the texture continues there.
    across: Vec<u32>,
    /// For each face the last search that met it, and its side.
    met: Vec<(u32, u32)>,
    search: u32,
    queue: VecDeque<u32>,
}

/// The faces near a point that are connected in the texture.
pub(super) struct Side {
    /// Their point nearest to the given point.
    pub place: SurfacePoint,
    pub point: Vector,
    /// Whether they include the face of the given point.
    pub own: bool,
}

impl<'a> Charts<'a> {
    /// Finds the charts of a texture.
    pub fn of(mesh: &'a TriMesh, uv: &'a Attribute<2>) -> Self {
        let faces = mesh.faces().len();
        let across = across(mesh, uv);
        Self { mesh, uv, across, met: vec![(0, 0); faces], search: 0, queue: VecDeque::new() }
    }

    /// Returns the texture at a place.
    pub fn at(&self, place: &SurfacePoint) -> Option<Uv> {
        Some(place.interpolate(self.uv.of_face(self.mesh, place.face as usize)?))
    }

    /// Returns the frame of a face.
    pub fn frame(&self, face: u32) -> Option<Frame> {
        let corners = self.mesh.faces()[face as usize].map(|v| self.mesh.vertices()[v as usize]);
        Frame::of(corners, self.uv.of_face(self.mesh, face as usize)?)
    }

    /// Returns the frame of a face, or, if the face has none, that of a face nearby in the texture.
    pub fn frame_near(&mut self, face: u32) -> Option<Frame> {
        if let Some(frame) = self.frame(face) {
            return Some(frame);
        }
        self.begin();
        self.meet(face, 0);
        for _ in 0..NEARBY {
            let face = self.queue.pop_front()?;
            if let Some(frame) = self.frame(face) {
                return Some(frame);
            }
            self.meet_around(face, 0);
        }
        None
    }

    /// Returns the sides of seams on which these faces lie within `radius` around p, a point of the
    /// face `own`: the sides, and for each face the number of its side.
    pub fn sides(
        &mut self,
        p: Vector,
        own: &SurfacePoint,
        radius: f64,
        faces: impl Iterator<Item = u32>,
    ) -> (Vec<Side>, Vec<usize>) {
        self.begin();
        let mut sides = Vec::new();
        let of_faces = faces
            .map(|face| match self.met[face as usize] {
                (search, side) if search == self.search => side as usize,
                _ => {
                    sides.push(self.side(p, own, radius, face, sides.len() as u32));
                    sides.len() - 1
                }
            })
            .collect();
        (sides, of_faces)
    }

    fn side(
        &mut self,
        p: Vector,
        own: &SurfacePoint,
        radius: f64,
        first: u32,
        number: u32,
    ) -> Side {
        let (mut best, mut nearest) = (None, f64::INFINITY);
        let mut has_own = false;
        self.meet(first, number);
        while let Some(face) = self.queue.pop_front() {
            let (place, point) = SurfacePoint::nearest(self.mesh, face, p);
            let away = sub(point, p);
            let square = dot(away, away);
            if square > radius * radius && face != first {
                continue;
            }
            if square < nearest || best.is_none() {
                nearest = square;
                best = Some((place, point));
            }
            has_own |= face == own.face;
            self.meet_around(face, number);
        }
        let (place, point) = match best {
            Some(found) if !has_own => found,
            _ => (*own, p),
        };
        Side { place, point, own: has_own }
    }

    fn begin(&mut self) {
        self.search += 1;
        self.queue.clear();
    }

    fn meet(&mut self, face: u32, side: u32) {
        self.met[face as usize] = (self.search, side);
        self.queue.push_back(face);
    }

    fn meet_around(&mut self, face: u32, side: u32) {
        for corner in 3 * face as usize..3 * face as usize + 3 {
            let next = self.across[corner];
            if next != NONE && self.met[next as usize].0 != self.search {
                self.meet(next, side);
            }
        }
    }
}

fn across(mesh: &TriMesh, uv: &Attribute<2>) -> Vec<u32> {
    let same = extent(uv) * SAME;
    let turns: Vec<f64> =
        (0..mesh.faces().len()).map(|f| uv.of_face(mesh, f).map_or(0.0, turn)).collect();
    // The vertices of an edge in the order of its face, and their values.
    let edge = |corner: u32| {
        let (f, i) = (corner as usize / 3, corner as usize % 3);
        let values = uv.of_face(mesh, f)?;
        let ends = [i, (i + 1) % 3];
        Some((ends.map(|i| mesh.faces()[f][i]), ends.map(|i| values[i])))
    };
    let goes_on = |one: u32, other: u32| {
        let Some(((ends, values), (others, [p, q]))) = edge(one).zip(edge(other)) else {
            return false;
        };
        let along = ends == others;
        let there = if along { [p, q] } else { [q, p] };
        let close = |(a, b): (&f64, &f64)| (a - b).abs() <= same;
        // Where a texture is folded, as for mirrored halves of a face, the edge is a seam, too.
        let turns = turns[one as usize / 3] * turns[other as usize / 3];
        let folded = if along { turns > 0.0 } else { turns < 0.0 };
        !folded && values.as_flattened().iter().zip(there.as_flattened()).all(close)
    };
    let edges = Edges::new(mesh);
    let mut across = vec![NONE; 3 * mesh.faces().len()];
    for corners in edges.corners().rows() {
        for (i, &corner) in corners.iter().enumerate() {
            // In cyclic order, so that all faces at an edge of many faces are reached.
            let others = corners[i + 1..].iter().chain(&corners[..i]);
            let next = others.copied().find(|&other| goes_on(corner, other));
            across[corner as usize] = next.map_or(NONE, |other| other / 3);
        }
    }
    across
}

/// Returns 1 for a face whose corners are counter-clockwise in the texture, -1 for clockwise, 0 for
/// a face without area there.
fn turn(corners: [Uv; 3]) -> f64 {
    let [a, b, c] = corners;
    let square = |p: Uv, q: Uv| (p[0] - q[0]).powi(2) + (p[1] - q[1]).powi(2);
    let longest = square(a, b).max(square(b, c)).max(square(c, a));
    let area = area(corners);
    if area.abs() > NO_AREA * longest { area.signum() } else { 0.0 }
}

/// Returns the longer side of the bounding box of all values.
fn extent(uv: &Attribute<2>) -> f64 {
    let side = |k: usize| {
        let values = uv.values.iter().map(|value| value[k]);
        let (low, high) = values
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
        high - low
    };
    side(0).max(side(1)).max(0.0)
}
