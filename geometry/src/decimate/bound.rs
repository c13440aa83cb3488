//! An upper bound of the distance of all points of a surface from another one.
//!
//! The distance from a face is a convex function of the point. Therefore no point of a convex part
//! of a surface is farther from a face of the other one than the farthest corner of the part. Parts
//! for which that is too little are cut along the sides of their nearest face.

use crate::mesh::vector::{Vector, cross, distance, dot, doubled_normal, norm, square, sub};
use crate::mesh::{TriMesh, Triangles, nearest_on_triangle};
use catamaran::base::{Par, Result};

/// Distance between the upper bound and the largest distance, relative to the latter.
const TOLERANCE: f64 = 0.01;

/// The same, relative to the diagonal of the meshes, where the largest distance is smaller than
/// that: rounding errors are smaller still.
const FLOOR: f64 = 1e-9;

/// Number of parts that one thread takes at a time.
const BLOCK: usize = 256;

/// Operations that a part is equal to: the search for its nearest face and the cuts.
const PART: f64 = 5000.0;

/// Largest number of cuts of a part of a part, and of parts at a time, a multiple of the faces and
/// a constant. What is left then is bounded as it is.
const ROUNDS: usize = 64;
const PARTS: (usize, usize) = (4, 1 << 20);

/// Height over a plane, relative to the size of a part, at which a corner counts as on the plane.
const ON_PLANE: f64 = 1e-9;

/// A convex part of a face, by its corners.
type Part = Vec<Vector>;

/// Returns an upper bound of the distance of the points of `mesh` from the faces of `other`, and
/// the largest distance that a point is known to have. `corners` are the squared distances of the
/// vertices of `mesh`, and `known` is a distance that some point of either surface has from the
/// other one: the bound is at least `known`, and at most 1 % above the larger of `known` and the
/// largest distance of a point, unless that takes too many parts.
pub(super) fn bound(
    mesh: &TriMesh,
    other: &Triangles,
    corners: &[f64],
    known: f64,
    par: Par,
) -> Result<[f64; 2]> {
    let diagonal = mesh.bounding_box().map_or(0.0, |[low, high]| distance(low, high));
    let enough = |known: f64| known + (TOLERANCE * known).max(FLOOR * diagonal);
    let mut state = Found { highest: known, known, open: Vec::new() };
    let limit = enough(known);
    let blocks =
        par.map_blocks_asking(mesh.faces().len(), BLOCK, PART * BLOCK as f64, |range| {
            let mut found = Found::new(known);
            for face in &mesh.faces()[range] {
                let part = face.map(|v| mesh.vertices()[v as usize]);
                let reach = |k: usize| {
                    let away = part.iter().map(|&p| square(sub(p, part[k]))).fold(0.0, f64::max);
                    corners[face[k] as usize].sqrt() + away.sqrt()
                };
                let most = reach(0).min(reach(1)).min(reach(2));
                found.sort(part, most, limit);
            }
            found
        })?;
    state.collect(blocks);
    let most_parts = PARTS.0 * mesh.faces().len() + PARTS.1;
    for round in 0.. {
        let parts = std::mem::take(&mut state.open);
        if parts.is_empty() {
            break;
        }
        let cuts = round < ROUNDS && parts.len() < most_parts;
        let limit = if cuts { enough(state.known) } else { f64::INFINITY };
        let blocks = par.map_blocks_asking(parts.len(), BLOCK, PART * BLOCK as f64, |range| {
            let mut found = Found::new(state.known);
            parts[range].iter().for_each(|part| found.measure(part, other, limit));
            found
        })?;
        state.collect(blocks);
    }
    Ok([state.highest, state.known])
}

/// What is known after a round.
struct Found {
    /// An upper bound of the distances in all parts that are done.
    highest: f64,
    /// The largest distance that a point has.
    known: f64,
    /// Parts that are not done.
    open: Vec<Part>,
}

impl Found {
    fn new(known: f64) -> Self {
        Self { highest: 0.0, known, open: Vec::new() }
    }

    /// Adds the results of all blocks, in their order.
    fn collect(&mut self, blocks: Vec<Self>) {
        for block in blocks {
            self.highest = self.highest.max(block.highest);
            self.known = self.known.max(block.known);
            self.open.extend(block.open);
        }
        self.highest = self.highest.max(self.known);
    }

    /// Adds a part without a point farther than `most`.
    fn sort(&mut self, part: impl Into<Part>, most: f64, limit: f64) {
        if most <= limit {
            self.highest = self.highest.max(most);
        } else {
            self.open.push(part.into());
        }
    }

    /// Bounds the distances of a part, or cuts it.
    fn measure(&mut self, part: &[Vector], other: &Triangles, limit: f64) {
        let middle = middle_of(part);
        let Some(face) = other.nearest_face(middle) else { return };
        let here = away_from(face, middle);
        self.known = self.known.max(here);
        let reach = part.iter().map(|&p| distance(p, middle)).fold(0.0, f64::max);
        let most = farthest(part, face).min(here + reach);
        if most <= limit {
            self.highest = self.highest.max(most);
            return;
        }
        for piece in cut(part, face) {
            let most = farthest(&piece, face);
            self.sort(piece, most, limit);
        }
    }
}

fn away_from(face: [Vector; 3], p: Vector) -> f64 {
    distance(nearest_on_triangle(face, p).0, p)
}

/// Returns the largest distance of a point of the part from the face, which a corner has.
fn farthest(part: &[Vector], face: [Vector; 3]) -> f64 {
    part.iter().map(|&p| away_from(face, p)).fold(0.0, f64::max)
}

fn middle_of(part: &[Vector]) -> Vector {
    let share = 1.0 / part.len() as f64;
    std::array::from_fn(|k| part.iter().map(|p| share * p[k]).sum())
}

/// Cuts a part along the sides of the prism over a face; one that no side cuts is halved.
fn cut(part: &[Vector], face: [Vector; 3]) -> Vec<Part> {
    let normal = doubled_normal(face);
    let mut pieces = Vec::new();
    let mut inside = part.to_vec();
    for k in 0..3 {
        let [a, b] = [face[k], face[(k + 1) % 3]];
        let [within, beyond] = halves(&inside, a, cross(normal, sub(b, a)));
        pieces.extend(Some(beyond).filter(|piece| piece.len() > 2));
        inside = within;
    }
    pieces.extend(Some(inside).filter(|piece| piece.len() > 2));
    if pieces.len() > 1 {
        return pieces;
    }
    let mut widest = (0.0, [part[0]; 2]);
    for (at, &p) in part.iter().enumerate() {
        for &q in &part[..at] {
            let length = square(sub(p, q));
            if length > widest.0 {
                widest = (length, [p, q]);
            }
        }
    }
    let [p, q] = widest.1;
    let pieces = halves(part, middle_of(&[p, q]), sub(q, p));
    pieces.into_iter().filter(|piece| piece.len() > 2).collect()
}

/// Returns the parts on the side of the plane through `at` to which `normal` points, and on the
/// other side. A part without an area may be left out: the other one contains it.
fn halves(part: &[Vector], at: Vector, normal: Vector) -> [Part; 2] {
    let mut halves = [Part::with_capacity(part.len() + 1), Part::with_capacity(part.len() + 1)];
    let heights: Vec<f64> = part.iter().map(|&p| dot(sub(p, at), normal)).collect();
    // A part that this plane has cut before has corners on it, up to rounding.
    let least =
        ON_PLANE * norm(normal) * part.iter().map(|&p| distance(p, part[0])).fold(0.0, f64::max);
    let heights: Vec<f64> = heights
        .into_iter()
        .map(|height| if height.abs() <= least { 0.0 } else { height })
        .collect();
    if heights.iter().all(|&height| height >= 0.0) {
        return [part.to_vec(), Part::new()];
    }
    if heights.iter().all(|&height| height <= 0.0) {
        return [Part::new(), part.to_vec()];
    }
    for (i, (&p, &height)) in part.iter().zip(&heights).enumerate() {
        let next = (i + 1) % part.len();
        if height >= 0.0 {
            halves[0].push(p);
        }
        if height <= 0.0 {
            halves[1].push(p);
        }
        let other = heights[next];
        if (height > 0.0 && other < 0.0) || (height < 0.0 && other > 0.0) {
            let share = height / (height - other);
            let q = part[next];
            let between = std::array::from_fn(|k| p[k] + share * (q[k] - p[k]));
            halves[0].push(between);
            halves[1].push(between);
        }
    }
    halves
}
