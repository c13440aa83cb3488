//! Computes the surface of a symmetric field as a mesh that is its own mirror image, by naive
//! surface nets with relaxation.
//!
//! Source: Gibson, Constrained Elastic Surface Nets (1998). The grid has a layer of cells across
//! the plane x = 0; faces are constructed on one side and mirrored.

use std::collections::HashMap;

use catamaran::Result;
use catamaran_geometry::mesh::vector::{Vector, add, distance, scale};
use catamaran_geometry::mesh::{Edges, TriMesh};

use super::field::Field;
use super::rotation::mirrored;

/// Number of rounds that move every vertex to the mean of its neighbours and back to the surface.
const ROUNDS: usize = 12;

/// A mesh, and for each vertex its mirror image.
pub(super) struct Symmetric {
    pub mesh: TriMesh,
    pub mirror: Vec<u32>,
}

/// Cell sizes that are tried, relative to the one for the desired number of vertices: a net is not
/// a manifold where two pieces of the surface pass through one cell.
const SIDES: [f64; 7] = [1.0, 0.985, 1.015, 0.97, 1.03, 0.955, 1.045];

/// Returns the surface of the field, with about `vertices` vertices.
///
/// # Errors
/// [`catamaran::Error::Mesh`] when the surface is too thin for this number of vertices.
pub(super) fn surface(field: &Field<'_>, vertices: usize) -> Result<Symmetric> {
    let [low, high] = field.bounds();
    let size = distance(low, high);
    let rough = size / 60.0;
    let found = Net::new(field, rough).positions.len();
    let side = rough * (found as f64 / vertices.max(1) as f64).sqrt();
    let attempts = SIDES.map(|part| {
        move || {
            let mut net = Net::new(field, part * side);
            net.relax(field);
            let found = net.finish()?;
            Edges::new(&found.mesh).require_manifold()?;
            Ok(found)
        }
    });
    let [first, others @ ..] = attempts;
    others.into_iter().fold(first(), |found, attempt| found.or_else(|_| attempt()))
}

/// The cells on the surface, and the quadrilaterals between them.
struct Net {
    positions: Vec<Vector>,
    mirror: Vec<u32>,
    /// Quadrilaterals with positive x, counter-clockwise as seen from outside.
    quads: Vec<[u32; 4]>,
}

/// Returns the offset of a corner of a cell, numbered from 0 to 7: bit k is the offset along axis
/// k.
fn corner(c: usize) -> [i32; 3] {
    [0, 1, 2].map(|k| (c >> k & 1) as i32)
}

impl Net {
    fn new(field: &Field<'_>, side: f64) -> Self {
        let [low, high] = field.bounds();
        // Points are at (i + 1/2) along x with i >= 0, the others are mirror images; j and k are
        // along y and z.
        let right = (high[0] / side).ceil() as i32 + 1;
        let counts = [1, 2].map(|k| ((high[k] - low[k]) / side).ceil() as i32 + 2);
        let position = |[i, j, k]: [i32; 3]| {
            [
                (f64::from(i) + 0.5) * side,
                low[1] + (f64::from(j) - 0.5) * side,
                low[2] + (f64::from(k) - 0.5) * side,
            ]
        };
        let number = |[i, j, k]: [i32; 3]| {
            // Point -1 is the mirror image of point 0.
            let i = if i < 0 { -1 - i } else { i };
            ((i * counts[0] + j) * counts[1] + k) as usize
        };
        let mut values = Vec::with_capacity((right * counts[0] * counts[1]) as usize);
        for i in 0..right {
            for j in 0..counts[0] {
                values.extend((0..counts[1]).map(|k| field.at(position([i, j, k]))));
            }
        }
        let mut net = Self { positions: vec![], mirror: vec![], quads: vec![] };
        let mut cells: HashMap<[i32; 3], u32> = HashMap::new();
        for i in -1..right - 1 {
            for j in 0..counts[0] - 1 {
                for k in 0..counts[1] - 1 {
                    let cell = [i, j, k];
                    let at = |c: usize| {
                        let offset = corner(c);
                        [0, 1, 2].map(|a| cell[a] + offset[a])
                    };
                    if let Some(p) = crossing(|c| (position(at(c)), values[number(at(c))])) {
                        net.add_cell(cell, p, &mut cells);
                    }
                }
            }
        }
        for i in 0..right - 1 {
            for j in 1..counts[0] - 1 {
                for k in 1..counts[1] - 1 {
                    let start = [i, j, k];
                    for axis in 0..3 {
                        let mut end = start;
                        end[axis] += 1;
                        let inside = [start, end].map(|p| values[number(p)] < 0.0);
                        if inside[0] != inside[1] {
                            net.add_quad(start, axis, inside[0], &cells);
                        }
                    }
                }
            }
        }
        net
    }

    /// Adds a vertex, and its mirror image.
    fn add_cell(&mut self, cell: [i32; 3], p: Vector, cells: &mut HashMap<[i32; 3], u32>) {
        let vertex = self.positions.len() as u32;
        cells.insert(cell, vertex);
        if cell[0] < 0 {
            self.positions.push([0.0, p[1], p[2]]);
            self.mirror.push(vertex);
        } else {
            cells.insert([-2 - cell[0], cell[1], cell[2]], vertex + 1);
            self.positions.extend([p, mirrored(p)]);
            self.mirror.extend([vertex + 1, vertex]);
        }
    }

    /// Adds the quadrilateral of the four cells around an edge of the grid that the surface
    /// crosses.
    fn add_quad(
        &mut self,
        start: [i32; 3],
        axis: usize,
        outwards: bool,
        cells: &HashMap<[i32; 3], u32>,
    ) {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let around = [[1, 1], [0, 1], [0, 0], [1, 0]].map(|[a, b]| {
            let mut cell = start;
            cell[u] -= a;
            cell[v] -= b;
            cells.get(&cell).copied()
        });
        let [Some(a), Some(b), Some(c), Some(d)] = around else { return };
        self.quads.push(if outwards { [a, b, c, d] } else { [d, c, b, a] });
    }

    /// Moves the vertices so that triangles are more equal; the left side mirrors the right side.
    fn relax(&mut self, field: &Field<'_>) {
        let mut neighbours: Vec<Vec<u32>> = vec![vec![]; self.positions.len()];
        for &quad in &self.quads {
            for i in 0..4 {
                let (a, b) = (quad[i], quad[(i + 1) % 4]);
                neighbours[a as usize].push(b);
                neighbours[b as usize].push(a);
            }
        }
        for _ in 0..ROUNDS {
            let before = self.positions.clone();
            for v in 0..before.len() {
                let m = self.mirror[v] as usize;
                if before[v][0] < 0.0 || neighbours[v].is_empty() {
                    continue;
                }
                let sum = neighbours[v].iter().fold([0.0; 3], |s, &w| add(s, before[w as usize]));
                let mut p = scale(sum, 1.0 / neighbours[v].len() as f64);
                if m == v {
                    p[0] = 0.0;
                }
                p = field.onto_surface(p);
                if m == v {
                    p[0] = 0.0;
                }
                self.positions[v] = p;
                self.positions[m] = if m == v { p } else { mirrored(p) };
            }
        }
    }

    fn finish(self) -> Result<Symmetric> {
        let Self { positions, mirror, quads } = self;
        let p = |v: u32| positions[v as usize];
        let mut faces = Vec::with_capacity(4 * quads.len());
        for &[a, b, c, d] in &quads {
            let pair = match distance(p(a), p(c)) <= distance(p(b), p(d)) {
                true => [[a, b, c], [a, c, d]],
                false => [[a, b, d], [b, c, d]],
            };
            for [a, b, c] in pair {
                faces.push([a, b, c]);
                faces.push([a, c, b].map(|v| mirror[v as usize]));
            }
        }
        Ok(Symmetric { mesh: TriMesh::new(positions, faces)?, mirror })
    }
}

/// Returns the mean of the points where the surface crosses the edges of a cell; `None` if it
/// crosses none.
fn crossing(at: impl Fn(usize) -> (Vector, f64)) -> Option<Vector> {
    let (mut sum, mut count) = ([0.0; 3], 0.0);
    for c in 0..8 {
        for axis in [1, 2, 4] {
            if c & axis != 0 {
                continue;
            }
            let ((p, f), (q, g)) = (at(c), at(c | axis));
            if (f < 0.0) != (g < 0.0) {
                let t = f / (f - g);
                sum = add(sum, add(scale(p, 1.0 - t), scale(q, t)));
                count += 1.0;
            }
        }
    }
    (count > 0.0).then(|| scale(sum, 1.0 / count))
}
