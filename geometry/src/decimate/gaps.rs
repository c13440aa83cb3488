//! Measures the local distances between the new mesh and the surface.

use super::closest::{Found, downhill, on_surface};
use super::patch::Patch;
use super::surface::Surface;
use crate::mesh::intersections::Bounds;
use crate::mesh::vector::{Vector, distance, square, sub};
use crate::mesh::{interpolate, nearest_on_triangle};

/// A point where the new mesh and the surface differ.
#[derive(Debug, Clone, Copy)]
pub(super) struct Gap {
    pub size: f64,
    pub on_patch: Vector,
    pub on_surface: Vector,
    /// The vertex of the surface nearest to this point.
    pub near: u32,
    pub site: Site,
}

/// The element at which a gap is measured.
#[derive(Debug, Clone, Copy)]
pub(super) enum Site {
    /// The part of the surface in the cell of a vertex.
    Cell(u32),
    /// A face of the new mesh.
    Face(u32),
}

/// The surface, with its part in the cell of each vertex of the new mesh.
pub(super) struct Gaps<'a, 's> {
    pub surface: &'a Surface<'s>,
    /// For each vertex of the new mesh, the vertices of the surface in its cell.
    cells: Vec<Vec<u32>>,
}

/// Barycentric coordinates of the points of a face whose distances are measured.
const SAMPLES: [Vector; 4] = [[1.0 / 3.0; 3], [0.5, 0.5, 0.0], [0.0, 0.5, 0.5], [0.5, 0.0, 0.5]];

impl<'a, 's> Gaps<'a, 's> {
    /// Creates the gaps of a surface from the cell of each of its vertices, of `count` cells.
    pub fn new(
        surface: &'a Surface<'s>,
        cell_of: impl IntoIterator<Item = u32>,
        count: usize,
    ) -> Self {
        let mut cells = vec![Vec::new(); count];
        for (cell, v) in cell_of.into_iter().zip(0..) {
            if let Some(cell) = cells.get_mut(cell as usize) {
                cell.push(v);
            }
        }
        Self { surface, cells }
    }

    /// Returns the cell of v; empty for vertices that were added later.
    fn cell(&self, v: u32) -> &[u32] {
        self.cells.get(v as usize).map_or(&[], Vec::as_slice)
    }

    /// Returns the gap from the vertex in the cell of v that is farthest from the new mesh; `None`
    /// when none is farther than `least`.
    pub fn of_cell(&self, patch: &Patch, v: u32, least: f64) -> Option<Gap> {
        let mut widest: Option<Gap> = None;
        for &near in self.cell(v) {
            let limit = widest.map_or(least, |gap| gap.size);
            let q = self.surface.position(near);
            let mut nearest = (q, f64::INFINITY);
            // Most vertices are near enough to v, or to one of its faces.
            let is_near = distance(patch.position(v), q) <= limit
                || patch.around(v).iter().any(|&f| {
                    approach(patch, f, q, &mut nearest);
                    nearest.1 <= limit * limit
                });
            if is_near {
                continue;
            }
            let reach = nearest.1.sqrt().min(self.surface.scale);
            let bounds = Bounds::of(&[-reach, reach].map(|r| q.map(|x| x + r)));
            patch.visit(&bounds, |f| approach(patch, f, q, &mut nearest));
            let (on_patch, size) = (nearest.0, nearest.1.sqrt());
            if size > limit {
                widest = Some(Gap { size, on_patch, on_surface: q, near, site: Site::Cell(v) });
            }
        }
        widest
    }

    /// Returns the gap from the middle of a face or of its edges, whichever is farthest from the
    /// surface; `None` when none is farther than `least`.
    pub fn of_face(&self, patch: &Patch, f: u32, least: f64) -> Option<Gap> {
        let face = patch.face(f as usize)?;
        let corners = patch.corners_at(face);
        let mut widest: Option<Gap> = None;
        for weights in SAMPLES {
            let limit = widest.map_or(least, |gap| gap.size);
            let p = interpolate(weights, corners);
            let Some(found) = self.nearest(patch, face, p, limit) else { continue };
            let size = found.square.sqrt();
            if size > limit {
                let (on_surface, near) = (found.point, found.vertex);
                widest = Some(Gap { size, on_patch: p, on_surface, near, site: Site::Face(f) });
            }
        }
        widest
    }

    /// Returns the point of the surface nearest to p, which is on this face; `None` when a walk
    /// finds one that is no farther than `enough`.
    fn nearest(&self, patch: &Patch, face: [u32; 3], p: Vector, enough: f64) -> Option<Found> {
        let mut best: Option<Found> = None;
        let mut walk = |from: u32| {
            let found = on_surface(self.surface, from, p);
            best = best.into_iter().chain(found).min_by(|a, b| a.square.total_cmp(&b.square));
            best
        };
        for v in face {
            // On a fine surface, a vertex is near enough, and no face has to be measured.
            let (end, square) =
                downhill(self.surface, patch.anchors[v as usize], p, enough * enough);
            let is_near = square <= enough * enough
                || walk(end).is_some_and(|found| found.square <= enough * enough);
            if is_near {
                return None;
            }
        }
        // All these walks may have missed the nearest point.
        let away = |w: u32| square(sub(self.surface.position(w), p));
        let all = face.iter().flat_map(|&v| self.cell(v)).copied();
        match all.min_by(|&a, &b| away(a).total_cmp(&away(b))) {
            Some(w) => walk(w),
            None => best,
        }
    }
}

/// Replaces `nearest` by the point of a face nearest to p, with its squared distance, if that is
/// nearer.
fn approach(patch: &Patch, f: u32, p: Vector, nearest: &mut (Vector, f64)) {
    let (q, _) = nearest_on_triangle(patch.corners_of(f), p);
    let square = square(sub(p, q));
    if square < nearest.1 {
        *nearest = (q, square);
    }
}
