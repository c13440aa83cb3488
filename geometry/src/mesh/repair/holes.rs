//! Fills holes with triangles of least area.

use std::collections::HashSet;

use super::super::TriMesh;
use super::super::measure::is_flat;
use super::super::slots;
use super::super::topology::Edges;
use super::super::vector::{Vector, distance, doubled_normal, norm};
use super::rebuild::{Rebuild, corners_of};
use super::report::RepairStep;
use catamaran::base::Result;

/// A longer loop is first cut in two by a short diagonal, because time grows with the cube of the
/// length.
const BATCH: usize = 256;

/// Weight of the square of a diagonal, which is added to the areas. Of the many triangulations of a
/// flat hole with least area, those with short diagonals have better faces.
const DIAGONAL: f64 = 1e-3;

/// Cost of a face without area, relative to the square of its longest edge: more than the cost of
/// diagonals, and less than the area that would span a slit.
const FLAT: f64 = 1e-2;

/// Returns the mesh with its boundary loops of at most `most` edges filled; `None` when there are
/// no such loops. New faces have the orientation of their neighbours, and the values of the
/// neighbouring corners.
///
/// # Errors
/// [`Error::Mesh`](catamaran::Error::Mesh) that names an edge of more than two faces.
pub(super) fn filled(mesh: &TriMesh, most: usize) -> Result<(Option<Rebuild>, RepairStep)> {
    let edges = Edges::new(mesh);
    let loops = mesh.boundary_loops(&edges)?;
    let mut known: HashSet<[u32; 2]> = edges.ends().iter().copied().collect();
    let (mut new, mut corners) = (Vec::new(), Vec::new());
    let (mut holes, mut left) = (0, 0);
    for walk in &loops {
        if walk.len() > most {
            left += 1;
            continue;
        }
        let before = new.len();
        let done = simple_loops(mesh, &edges, walk).iter().all(|ring| {
            let mut filling = Filling { mesh, known: &mut known, faces: Vec::new() };
            let done = filling.fill(ring);
            let faces = filling.faces;
            new.extend(faces.iter().map(|face| face.map(|i| ring[i].vertex)));
            corners.extend(faces.iter().map(|face| face.map(|i| ring[i].corner)));
            done
        });
        if done {
            holes += 1;
        } else {
            left += 1;
            for [a, b, c] in new.drain(before..) {
                for edge in [key(a, b), key(b, c), key(c, a)] {
                    if edges.ends().binary_search(&edge).is_err() {
                        known.remove(&edge);
                    }
                }
            }
            corners.truncate(before);
        }
    }
    let step = RepairStep::FilledHoles { holes, faces: new.len(), left };
    if holes == 0 {
        return Ok((None, step));
    }
    let mut faces = mesh.faces().to_vec();
    let mut all: Vec<[u32; 3]> = (0..faces.len() as u32).map(corners_of).collect();
    faces.extend(new);
    all.extend(corners);
    let vertices = (0..mesh.vertices().len() as u32).collect();
    let rebuild = Rebuild { vertices, faces, corners: all, insertions: Vec::new(), joined: None };
    Ok((Some(rebuild), step))
}

/// A vertex of a hole, and its corner in a face beside the hole.
#[derive(Clone, Copy)]
struct Rim {
    vertex: u32,
    corner: u32,
}

/// Returns the rings, with each vertex once, of which a boundary loop consists, with the hole on
/// the left.
fn simple_loops(mesh: &TriMesh, edges: &Edges, walk: &[u32]) -> Vec<Vec<Rim>> {
    let corner_at = |u: u32, v: u32| -> Option<(u32, bool)> {
        let e = edges.ends().binary_search(&key(u, v)).ok()?;
        let &start = edges.corners().row(e).first()?;
        let runs = mesh.faces().as_flattened()[start as usize] == u;
        Some((if runs { start } else { slots::next(start) }, runs))
    };
    let mut rings = Vec::new();
    let mut open: Vec<Rim> = Vec::new();
    let mut agrees = 0i64;
    for (i, &vertex) in walk.iter().enumerate() {
        let Some((corner, runs)) = corner_at(vertex, walk[(i + 1) % walk.len()]) else { continue };
        agrees += if runs { 1 } else { -1 };
        if let Some(at) = open.iter().position(|rim| rim.vertex == vertex) {
            rings.push(open.split_off(at));
        }
        open.push(Rim { vertex, corner });
    }
    rings.push(open);
    // New faces must run along the boundary edges in the direction opposite to that of the old
    // faces.
    if agrees >= 0 {
        rings.iter_mut().for_each(|ring| ring.reverse());
    }
    rings
}

fn key(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

struct Filling<'a> {
    mesh: &'a TriMesh,
    /// The existing edges: a new edge may not be one of these.
    known: &'a mut HashSet<[u32; 2]>,
    /// The new faces, as indices in the ring.
    faces: Vec<[usize; 3]>,
}

impl Filling<'_> {
    /// Fills the hole; returns whether that was possible.
    fn fill(&mut self, ring: &[Rim]) -> bool {
        // The boundary of a single face is not a hole.
        let alone = |first: &Rim| ring.iter().all(|rim| rim.corner / 3 == first.corner / 3);
        if ring.first().is_none_or(alone) {
            return false;
        }
        let all: Vec<usize> = (0..ring.len()).collect();
        let mut open = vec![all];
        while let Some(part) = open.pop() {
            if part.len() > BATCH {
                let Some([i, j]) = self.shortest_diagonal(ring, &part) else { return false };
                self.known.insert(key(ring[part[i]].vertex, ring[part[j]].vertex));
                let outer = part[..=i].iter().chain(&part[j..]).copied().collect();
                open.extend([outer, part[i..=j].to_vec()]);
            } else if !self.least_area(ring, &part) {
                return false;
            }
        }
        true
    }

    fn point(&self, rim: Rim) -> Vector {
        self.mesh.vertices()[rim.vertex as usize]
    }

    /// Returns the shortest diagonal with at least a quarter of the ring on each side.
    fn shortest_diagonal(&self, ring: &[Rim], part: &[usize]) -> Option<[usize; 2]> {
        let n = part.len();
        let mut best: Option<(f64, [usize; 2])> = None;
        for i in 0..n {
            for j in i + n / 4..n.min(i + n - n / 4) {
                let [p, q] = [ring[part[i]], ring[part[j]]];
                let length = distance(self.point(p), self.point(q));
                let better = best.is_none_or(|best| length < best.0);
                if better && !self.known.contains(&key(p.vertex, q.vertex)) {
                    best = Some((length, [i, j]));
                }
            }
        }
        best.map(|(_, ends)| ends)
    }

    /// Finds the triangulation of least area by dynamic programming over the sub-polygons i..=j
    /// (Barequet and Sharir 1995); returns whether there is one.
    fn least_area(&mut self, ring: &[Rim], part: &[usize]) -> bool {
        let n = part.len();
        if n < 3 {
            return false;
        }
        let rims: Vec<Rim> = part.iter().map(|&i| ring[i]).collect();
        let points: Vec<Vector> = rims.iter().map(|&rim| self.point(rim)).collect();
        let mut cost = vec![0.0; n * n];
        let mut apex = vec![0; n * n];
        for span in 2..n {
            for i in 0..n - span {
                let j = i + span;
                let square = distance(points[i], points[j]).powi(2);
                let closing = span == n - 1;
                let there = self.known.contains(&key(rims[i].vertex, rims[j].vertex));
                let mut best = (f64::INFINITY, 0);
                if closing || !there {
                    for k in i + 1..j {
                        let corners = [points[i], points[k], points[j]];
                        let area = match is_flat(corners) {
                            // A face without area is used only where there is no alternative.
                            true => FLAT * square,
                            false => norm(doubled_normal(corners)) / 2.0,
                        };
                        let all = cost[i * n + k] + cost[k * n + j] + area;
                        if all < best.0 {
                            best = (all, k);
                        }
                    }
                    best.0 += if closing { 0.0 } else { DIAGONAL * square };
                }
                cost[i * n + j] = best.0;
                apex[i * n + j] = best.1;
            }
        }
        if !cost[n - 1].is_finite() {
            return false;
        }
        let mut open = vec![(0, n - 1)];
        while let Some((i, j)) = open.pop() {
            if j - i < 2 {
                continue;
            }
            let k = apex[i * n + j];
            self.faces.push([part[i], part[k], part[j]]);
            self.known.insert(key(rims[i].vertex, rims[j].vertex));
            open.extend([(k, j), (i, k)]);
        }
        true
    }
}
