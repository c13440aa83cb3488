//! Marching through the tetrahedra. Points, edges and cells are visited in the order of their
//! numbers; layers are independent of each other, so that the number of threads does not change the
//! result.

use super::lattice::{Lattice, Rim};
use crate::mesh::TriMesh;
use crate::mesh::vector::{square, sub};
use catamaran::base::{Error, Par, Progress, Result, Tracker, reserved};

/// The tetrahedra of a cell by their corners, whose bits are the steps along x (1), y (2) and
/// z (4); each positively oriented.
const TETRAHEDRA: [[usize; 4]; 6] =
    [[0, 1, 3, 7], [0, 2, 6, 7], [0, 4, 5, 7], [0, 3, 2, 7], [0, 5, 1, 7], [0, 6, 4, 7]];
/// For each corner of a tetrahedron, an order of the corners that begins with it and keeps the
/// orientation.
const FROM_ONE: [[usize; 4]; 4] = [[0, 1, 2, 3], [1, 0, 3, 2], [2, 0, 1, 3], [3, 0, 2, 1]];
/// For each pair of corners, an order of the corners that begins with the pair and keeps the
/// orientation.
const FROM_TWO: [[usize; 4]; 6] =
    [[0, 1, 2, 3], [0, 2, 3, 1], [0, 3, 1, 2], [1, 2, 0, 3], [1, 3, 2, 0], [2, 3, 0, 1]];

/// An edge of the lattice with one end inside.
#[derive(Debug, Clone, Copy)]
pub struct Crossing {
    /// The indices of the ends in the lattice; meaningless for an end outside of the lattice.
    pub points: [usize; 2],
    /// Whether one end is outside of the lattice.
    pub capped: bool,
    /// The first end, in steps, and the vector to the other end.
    place: [f64; 3],
    way: [f64; 3],
}

/// A lattice, with a layer of points around it when its rim is closed, and the edges that the
/// surface crosses.
pub struct March<'a> {
    lattice: &'a Lattice,
    par: Par,
    /// Number of layers of points around the lattice on each side: 0 or 1.
    margin: usize,
    /// Number of points along x, y and z, with the margin.
    counts: [usize; 3],
    /// For each point, whether it is inside.
    inside: Vec<bool>,
    /// For each point, bit d is set if the edge towards corner d of its cell crosses the surface.
    edges: Vec<u8>,
    /// For each point, the number of vertices before its own.
    first: Vec<u32>,
    vertices: usize,
}

impl<'a> March<'a> {
    /// Finds the edges of the lattice that the surface crosses.
    pub fn new(
        lattice: &'a Lattice,
        rim: Rim,
        is_inside: &(dyn Fn(usize) -> bool + Sync),
        par: Par,
        progress: Progress<'_>,
    ) -> Result<Self> {
        let margin = usize::from(rim == Rim::Closed);
        let counts = lattice.counts.map(|n| n.saturating_add(2 * margin));
        let refused = |why: String| Err(Error::Argument { what: "lattice", why });
        if lattice.counts.contains(&0) || counts.iter().any(|n| *n < 2) {
            let needed = if margin == 0 { "2 points" } else { "a point" };
            return refused(format!("needs {needed} in each direction, has {:?}", lattice.counts));
        }
        let all = counts.iter().try_fold(1_usize, |n, side| n.checked_mul(*side));
        let Some(all) = all.filter(|n| u32::try_from(*n).is_ok()) else {
            return refused(format!("at most 2^32 - 1 points are possible, got {counts:?}"));
        };
        let mut march = Self {
            lattice,
            par,
            margin,
            counts,
            inside: reserved(all)?,
            edges: reserved(all)?,
            first: reserved(all)?,
            vertices: 0,
        };
        march.inside.resize(all, false);
        march.edges.resize(all, 0);
        march.first.resize(all, 0);
        march.mark(is_inside, &progress)?;
        march.cross(&progress)?;
        march.number()?;
        Ok(march)
    }

    /// Returns the number of points of a layer.
    fn layer(&self) -> usize {
        self.counts[0] * self.counts[1]
    }

    /// Finds the points that are inside.
    fn mark(
        &mut self,
        is_inside: &(dyn Fn(usize) -> bool + Sync),
        progress: &Progress<'_>,
    ) -> Result<()> {
        let ([nx, ny, nz], margin) = (self.lattice.counts, self.margin);
        let (row, layer) = (self.counts[0], self.layer());
        let tracker = Tracker::new(progress.part(0.0..0.5), nz as f64);
        let layers = self.inside.chunks_mut(layer).skip(margin).take(nz);
        self.par.for_each(layers, |k, flags| {
            if tracker.state().is_break() {
                return;
            }
            for j in 0..ny {
                let start = (j + margin) * row + margin;
                for (i, flag) in flags[start..start + nx].iter_mut().enumerate() {
                    *flag = is_inside(i + nx * (j + ny * k));
                }
            }
            // The remaining layers check the state of the tracker.
            let _ = tracker.add(1.0);
        });
        tracker.finish()
    }

    /// Finds the edges that the surface crosses.
    fn cross(&mut self, progress: &Progress<'_>) -> Result<()> {
        let ([nx, ny, nz], layer) = (self.counts, self.layer());
        let tracker = Tracker::new(progress.part(0.5..1.0), nz as f64);
        let inside = &self.inside;
        self.par.for_each(self.edges.chunks_mut(layer), |k, edges| {
            if tracker.state().is_break() {
                return;
            }
            for (p, edges) in edges.iter_mut().enumerate() {
                let (i, j) = (p % nx, p / nx);
                let here = inside[k * layer + p];
                for d in 1..8_usize {
                    let [x, y, z] = [d & 1, d >> 1 & 1, d >> 2];
                    if i + x < nx && j + y < ny && k + z < nz {
                        let there = inside[(k + z) * layer + p + y * nx + x];
                        *edges |= u8::from(here != there) << d;
                    }
                }
            }
            let _ = tracker.add(1.0);
        });
        tracker.finish()
    }

    /// Numbers the vertices.
    fn number(&mut self) -> Result<()> {
        let mut next = 0_u64;
        for (first, edges) in self.first.iter_mut().zip(&self.edges) {
            *first = next as u32;
            next += u64::from(edges.count_ones());
        }
        if u32::try_from(next).is_err() {
            let why = format!("at most 2^32 - 1 vertices are possible, the surface has {next}");
            return Err(Error::Argument { what: "lattice", why });
        }
        self.vertices = next as usize;
        Ok(())
    }

    /// Returns the edges that the surface crosses, each of which is a vertex, in their order.
    pub fn crossings(&self) -> Crossings<'_> {
        Crossings { march: self, point: 0, left: self.edges[0], rest: self.vertices }
    }

    fn crossing(&self, point: usize, d: usize) -> Crossing {
        let [nx, ny, _] = self.counts;
        let place = [point % nx, point / nx % ny, point / nx / ny];
        let way = [d & 1, d >> 1 & 1, d >> 2];
        let mut capped = false;
        let points = [0, 1].map(|end| {
            let mut at = [0; 3];
            for c in 0..3 {
                // Below the margin the subtraction wraps around to a number that is too large.
                at[c] = (place[c] + end * way[c]).wrapping_sub(self.margin);
                capped |= at[c] >= self.lattice.counts[c];
            }
            let [nx, ny, _] = self.lattice.counts;
            at[2].wrapping_mul(ny).wrapping_add(at[1]).wrapping_mul(nx).wrapping_add(at[0])
        });
        let place = place.map(|i| i as f64 - self.margin as f64);
        Crossing { points, capped, place, way: way.map(|x| x as f64) }
    }

    /// Returns the point at this share of the way along a crossed edge.
    pub fn between(&self, crossing: &Crossing, share: f64) -> [f64; 3] {
        let place = std::array::from_fn(|c| crossing.place[c] + share * crossing.way[c]);
        self.lattice.at(place)
    }

    /// Returns the surface whose vertices are at these shares of the crossed edges.
    pub fn mesh(&self, shares: &[f64], progress: Progress<'_>) -> Result<TriMesh> {
        let mut vertices = reserved(self.vertices)?;
        let places = self.crossings().zip(shares);
        vertices.extend(places.map(|(crossing, &share)| self.between(&crossing, share)));
        let layers = self.counts[2] - 1;
        let tracker = Tracker::new(progress, layers as f64);
        let parts = self.par.map_blocks(layers, 1, |range| {
            if tracker.state().is_break() {
                return Vec::new();
            }
            let faces = self.faces(range.start, &vertices);
            let _ = tracker.add(1.0);
            faces
        });
        tracker.finish()?;
        let mut faces = reserved(parts.iter().map(Vec::len).sum())?;
        parts.iter().for_each(|part| faces.extend_from_slice(part));
        TriMesh::new(vertices, faces)
    }

    /// Returns the faces in a layer of cells.
    fn faces(&self, k: usize, vertices: &[[f64; 3]]) -> Vec<[u32; 3]> {
        let ([nx, ny, _], layer) = (self.counts, self.layer());
        let offsets: [usize; 8] =
            std::array::from_fn(|c| (c & 1) + (c >> 1 & 1) * nx + (c >> 2) * layer);
        let mut faces = Vec::new();
        for j in 0..ny - 1 {
            for i in 0..nx - 1 {
                let cell = i + nx * j + layer * k;
                let corners = (0..8)
                    .fold(0, |bits, c| bits | usize::from(self.inside[cell + offsets[c]]) << c);
                if corners == 0 || corners == 255 {
                    continue;
                }
                // For two corners of a tetrahedron, the steps of one include those of the other.
                let vertex = |u: usize, v: usize| {
                    let (point, d) = (cell + offsets[u & v], u ^ v);
                    let before = self.edges[point] & ((1 << d) - 1) as u8;
                    self.first[point] + before.count_ones()
                };
                for tetrahedron in TETRAHEDRA {
                    let bits = (0..4).fold(0, |b, t| b | (corners >> tetrahedron[t] & 1) << t);
                    cut(tetrahedron, bits, vertex, vertices, &mut faces);
                }
            }
        }
        faces
    }
}

/// Adds the faces of the surface in a tetrahedron with these corners inside, counter-clockwise as
/// seen from outside.
fn cut(
    tetrahedron: [usize; 4],
    inside: usize,
    vertex: impl Fn(usize, usize) -> u32,
    vertices: &[[f64; 3]],
    faces: &mut Vec<[u32; 3]>,
) {
    let one = |corner: usize| {
        let [a, b, c, d] = FROM_ONE[corner].map(|t| tetrahedron[t]);
        [vertex(a, b), vertex(a, c), vertex(a, d)]
    };
    match inside.count_ones() {
        1 => faces.push(one(inside.trailing_zeros() as usize)),
        3 => {
            let [a, b, c] = one((!inside).trailing_zeros() as usize);
            faces.push([a, c, b]);
        }
        2 => {
            let pair = FROM_TWO.into_iter().find(|p| 1 << p[0] | 1 << p[1] == inside);
            let [a, b, c, d] = pair.unwrap_or_default().map(|t| tetrahedron[t]);
            let [p, q, r, s] = [vertex(a, c), vertex(a, d), vertex(b, d), vertex(b, c)];
            // The quadrilateral is cut along its shorter diagonal.
            let length = |u: u32, v: u32| square(sub(vertices[u as usize], vertices[v as usize]));
            if length(p, r) <= length(q, s) {
                faces.extend([[p, q, r], [p, r, s]]);
            } else {
                faces.extend([[q, r, s], [q, s, p]]);
            }
        }
        _ => {}
    }
}

/// An iterator over the edges that the surface crosses.
pub struct Crossings<'a> {
    march: &'a March<'a>,
    point: usize,
    /// The edges of the current point that are not yet visited, one bit each.
    left: u8,
    rest: usize,
}

impl Iterator for Crossings<'_> {
    type Item = Crossing;

    fn next(&mut self) -> Option<Crossing> {
        while self.left == 0 {
            self.point += 1;
            self.left = *self.march.edges.get(self.point)?;
        }
        let d = self.left.trailing_zeros() as usize;
        self.left &= self.left - 1;
        self.rest -= 1;
        Some(self.march.crossing(self.point, d))
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        (self.rest, Some(self.rest))
    }
}

impl ExactSizeIterator for Crossings<'_> {}
