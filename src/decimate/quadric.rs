//! The point nearest to the planes of the surface around a vertex: on creases, at corners and tips.

use std::collections::HashSet;
use std::f64::consts::PI;
use std::hash::BuildHasherDefault;

use super::batches::Multiply;
use super::patch::Patch;
use super::surface::Surface;
use crate::mesh::vector::{Vector, cross, distance, dot, norm, scale, sub};

/// The least weight of where a vertex would go otherwise, beside that of the planes.
const HOLD: f64 = 0.01;

/// How much more that weighs where the planes have no point in common, as round surfaces do. Larger:
/// more regular triangles; smaller: creases and tips met more closely.
const ROUND: f64 = 240.0;

/// The same weight where it is measured whether the planes have a point in common.
const FREE: f64 = 1e-3;

/// The point of least square distance from `target` and from the planes of the surface that is
/// nearer to v than to its neighbours (Garland and Heckbert, Surface Simplification Using Quadric
/// Error Metrics, 1997), no farther than `length` from `target`.
///
/// Planes weigh the more, the better they meet in a line or a point, and the more they differ: where
/// the surface is sharp or thin, vertices go to its creases, corners and tips; elsewhere they go to
/// `target`.
pub(super) fn sharpest(
    surface: &Surface<'_>,
    patch: &Patch,
    v: u32,
    target: Vector,
    length: f64,
) -> Vector {
    let mut planes = Planes::default();
    for w in own_vertices(surface, patch, v, length) {
        for &f in surface.faces_of.row(w as usize) {
            let corners = surface.mesh.faces()[f as usize].map(|u| surface.position(u));
            planes.add(corners, target);
        }
    }
    if planes.area <= 0.0 {
        return target;
    }
    // Every face was counted at each of its corners.
    let square = planes.area / (3.0 * PI);
    let rest = planes.error(planes.step(FREE)) / square;
    let alike = dot(planes.normal, planes.normal) / planes.area.powi(2);
    let step = planes.step(HOLD + ROUND * rest * alike * alike);
    let size = norm(step);
    if !size.is_finite() {
        return target;
    }
    let part = (length / size).min(1.0);
    std::array::from_fn(|k| target[k] + part * step[k])
}

/// Sums over planes, weighted by the areas of their faces, as seen from a point.
#[derive(Default)]
struct Planes {
    area: f64,
    /// Of the normals.
    normal: Vector,
    /// Of the products of each normal with itself: symmetric.
    products: [Vector; 3],
    /// Of the normals times the heights of the planes above the point.
    heights: Vector,
    /// Of the squares of these heights.
    squares: f64,
}

impl Planes {
    fn add(&mut self, [a, b, c]: [Vector; 3], from: Vector) {
        let doubled = cross(sub(b, a), sub(c, a));
        let area = norm(doubled);
        if area <= 0.0 {
            return;
        }
        let normal = scale(doubled, 1.0 / area);
        let height = dot(normal, sub(a, from));
        for (i, row) in self.products.iter_mut().enumerate() {
            (0..3).for_each(|j| row[j] += area * normal[i] * normal[j]);
            self.heights[i] += area * height * normal[i];
            self.normal[i] += doubled[i];
        }
        self.squares += area * height * height;
        self.area += area;
    }

    /// From the point to that of least sum of squares, its own distance weighted by `hold`.
    fn step(&self, hold: f64) -> Vector {
        let mut rows = self.products;
        rows.iter_mut().enumerate().for_each(|(i, row)| row[i] += hold * self.area);
        let [x, y, z] = rows;
        let right = self.heights;
        let parts = [dot(right, cross(y, z)), dot(x, cross(right, z)), dot(x, cross(y, right))];
        scale(parts, 1.0 / dot(x, cross(y, z)))
    }

    /// The mean square of the distances of the planes from the end of a step.
    fn error(&self, step: Vector) -> f64 {
        let along: f64 = (0..3).map(|i| step[i] * dot(self.products[i], step)).sum();
        (self.squares - 2.0 * dot(step, self.heights) + along).max(0.0) / self.area
    }
}

/// The vertices of the surface that are connected to the anchor of v, nearer to v than to its
/// neighbours, and not farther than `radius`; the anchor at any rate.
fn own_vertices(surface: &Surface<'_>, patch: &Patch, v: u32, radius: f64) -> Vec<u32> {
    let here = patch.position(v);
    let neighbours: Vec<Vector> =
        patch.neighbours(v).into_iter().map(|w| patch.position(w)).collect();
    let anchor = patch.anchors[v as usize];
    let mut seen: HashSet<u32, BuildHasherDefault<Multiply>> = HashSet::from_iter([anchor]);
    let mut open = vec![anchor];
    let mut own = Vec::new();
    while let Some(w) = open.pop() {
        let q = surface.position(w);
        let away = distance(q, here);
        let is_own = away <= radius && neighbours.iter().all(|&p| distance(p, q) >= away);
        // On a coarse surface the vertex nearest to v may be nearer to a neighbour.
        if !is_own && w != anchor {
            continue;
        }
        own.push(w);
        open.extend(surface.links(w).iter().map(|link| link.to).filter(|&to| seen.insert(to)));
    }
    own
}
