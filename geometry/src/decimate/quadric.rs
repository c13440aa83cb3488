//! Finds the point nearest to the planes of the surface around a vertex: on creases, at corners and
//! tips.

use std::collections::HashSet;
use std::f64::consts::PI;
use std::hash::BuildHasherDefault;
use std::sync::OnceLock;

use super::batches::Multiply;
use super::patch::Patch;
use super::surface::Surface;
use crate::mesh::vector::{Vector, cross, dot, norm, scale, square, sub};

/// Number of vertices whose planes are computed together.
const BLOCK: usize = 256;

/// Least weight of the target of a vertex, relative to the weight of the planes.
const HOLD: f64 = 0.01;

/// Factor of this weight where the planes have no point in common, as on round surfaces. A larger
/// factor gives more regular triangles, a smaller one creases and tips that are met more closely.
const ROUND: f64 = 240.0;

/// The same weight for the measurement whether the planes have a point in common.
const FREE: f64 = 1e-3;

/// The planes of the faces at each vertex of a surface, which are computed where they are needed
/// first: most of a scan has no crease.
pub(super) struct Quadrics<'a, 's> {
    surface: &'a Surface<'s>,
    blocks: Vec<OnceLock<Vec<Planes>>>,
}

impl<'a, 's> Quadrics<'a, 's> {
    /// Creates the quadrics of a surface.
    pub fn new(surface: &'a Surface<'s>) -> Self {
        let blocks = (0..surface.len().div_ceil(BLOCK)).map(|_| OnceLock::new());
        Self { surface, blocks: blocks.collect() }
    }

    fn at(&self, v: u32) -> &Planes {
        let v = v as usize;
        let first = v - v % BLOCK;
        let block = self.blocks[v / BLOCK].get_or_init(|| {
            let end = self.surface.len().min(first + BLOCK);
            (first..end).map(|v| Planes::at(self.surface, v)).collect()
        });
        &block[v - first]
    }

    /// Returns the point of least square distance from `target` and from the planes of the part of
    /// the surface that is nearer to v than to its neighbours (Garland and Heckbert, Surface
    /// Simplification Using Quadric Error Metrics, 1997), at most `length` from `target`.
    ///
    /// The weight of the planes increases with the precision with which they meet in a line or a
    /// point, and with their differences: where the surface is sharp or thin, vertices move to its
    /// creases, corners and tips; elsewhere they move to `target`.
    pub fn sharpest(&self, patch: &Patch, v: u32, target: Vector, length: f64) -> Vector {
        let mut sum = Sum::default();
        for w in own_vertices(self.surface, patch, v, length) {
            sum.add(self.at(w), sub(self.surface.position(w), target));
        }
        if sum.area <= 0.0 {
            return target;
        }
        // Each face was counted at each of its corners.
        let per_vertex = sum.area * self.surface.scale.powi(2) / (3.0 * PI);
        let rest = sum.error(sum.step(FREE)) / per_vertex;
        let alike = square(sum.normal) / sum.area.powi(2);
        let step = sum.step(HOLD + ROUND * rest * alike * alike);
        let size = norm(step);
        if !size.is_finite() {
            return target;
        }
        let part = (length / size).min(1.0);
        std::array::from_fn(|k| target[k] + part * step[k])
    }
}

/// Sums over the planes of the faces at a vertex, all of which contain the vertex, weighted by
/// their areas relative to the square of [`Surface::scale`]. Single precision saves memory.
#[derive(Clone, Copy, Default)]
struct Planes {
    area: f32,
    /// Sum of the normals.
    normal: [f32; 3],
    /// Sum of the products of the components of each normal: xx, xy, xz, yy, yz, zz.
    products: [f32; 6],
}

impl Planes {
    fn at(surface: &Surface<'_>, v: usize) -> Self {
        let mut planes = Self::default();
        for &f in surface.faces_of.row(v) {
            let [a, b, c] = surface.mesh.faces()[f as usize].map(|u| surface.position(u));
            let scaled = |p: Vector| scale(p, 1.0 / surface.scale);
            let doubled = cross(scaled(sub(b, a)), scaled(sub(c, a)));
            let area = norm(doubled);
            if area <= 0.0 {
                continue;
            }
            let [x, y, z] = scale(doubled, 1.0 / area);
            planes.area += area as f32;
            let products = [x * x, x * y, x * z, y * y, y * z, z * z];
            (0..3).for_each(|k| planes.normal[k] += doubled[k] as f32);
            (0..6).for_each(|k| planes.products[k] += (area * products[k]) as f32);
        }
        planes
    }
}

/// Sums over planes relative to a point.
#[derive(Default)]
struct Sum {
    area: f64,
    normal: Vector,
    /// Sum of the products of each normal with itself: symmetric.
    products: [Vector; 3],
    /// Sum of the normals times the heights of the planes above the point.
    heights: Vector,
    /// Sum of the squares of these heights.
    squares: f64,
}

impl Sum {
    /// Adds planes that contain the point at `offset`.
    fn add(&mut self, planes: &Planes, offset: Vector) {
        let [xx, xy, xz, yy, yz, zz] = planes.products.map(f64::from);
        let rows = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
        for (i, row) in rows.into_iter().enumerate() {
            let height = dot(row, offset);
            self.heights[i] += height;
            self.squares += offset[i] * height;
            self.normal[i] += f64::from(planes.normal[i]);
            (0..3).for_each(|j| self.products[i][j] += row[j]);
        }
        self.area += f64::from(planes.area);
    }

    /// Returns the vector to the point of least sum of squares, where its own distance has the
    /// weight `hold`.
    fn step(&self, hold: f64) -> Vector {
        let mut rows = self.products;
        rows.iter_mut().enumerate().for_each(|(i, row)| row[i] += hold * self.area);
        let [x, y, z] = rows;
        let right = self.heights;
        let parts = [dot(right, cross(y, z)), dot(x, cross(right, z)), dot(x, cross(y, right))];
        scale(parts, 1.0 / dot(x, cross(y, z)))
    }

    /// Returns the mean square of the distances of the planes from the end of a step.
    fn error(&self, step: Vector) -> f64 {
        let along: f64 = (0..3).map(|i| step[i] * dot(self.products[i], step)).sum();
        (self.squares - 2.0 * dot(step, self.heights) + along).max(0.0) / self.area
    }
}

/// Returns the vertices of the surface that are connected to the anchor of v, nearer to v than to
/// its neighbours, and at most `radius` away; always includes the anchor.
fn own_vertices(surface: &Surface<'_>, patch: &Patch, v: u32, radius: f64) -> Vec<u32> {
    let here = patch.position(v);
    let neighbours: Vec<Vector> =
        patch.neighbours(v).into_iter().map(|w| patch.position(w)).collect();
    let anchor = patch.anchors[v as usize];
    let is_own = |w: u32| {
        let q = surface.position(w);
        let away = square(sub(q, here));
        away <= radius * radius && neighbours.iter().all(|&p| square(sub(p, q)) >= away)
    };
    let mut seen: HashSet<u32, BuildHasherDefault<Multiply>> = HashSet::default();
    seen.reserve(64);
    seen.insert(anchor);
    // On a coarse surface, the vertex nearest to v may be nearer to a neighbour.
    let mut open = vec![anchor];
    let mut own = Vec::new();
    while let Some(w) = open.pop() {
        own.push(w);
        // All positions are requested in one loop, so that the processor loads them from memory at
        // the same time.
        let new = surface.links(w).iter().map(|link| link.to).filter(|&to| seen.insert(to));
        open.extend(new.filter(|&to| is_own(to)));
    }
    own
}
