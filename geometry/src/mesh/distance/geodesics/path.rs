use super::glued::Glued;
use super::windows::{Arrival, Windows, crossing};
use crate::mesh::slots::{next, previous};
use crate::mesh::{SurfacePoint, TriMesh};

/// Crossings of edges that are nearer to a vertex than this are at the vertex, relative to the edge
/// and the distance from where the path starts.
const NEAR: f64 = 1e-11;

/// A shortest path over the faces of a mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct GeodesicPath {
    /// The points where the path starts, crosses edges, passes vertices and ends, with straight
    /// lines in between; empty if there is no path.
    pub points: Vec<SurfacePoint>,
    /// The length, infinite if there is no path.
    pub length: f64,
}

impl GeodesicPath {
    /// Returns the positions of the points. Panics when the mesh does not have the faces.
    pub fn positions(&self, mesh: &TriMesh) -> Vec<[f64; 3]> {
        self.points.iter().map(|point| point.position(mesh)).collect()
    }
}

/// Returns the shortest path to a node that the windows, all of which are kept, have reached.
pub(super) fn path(glued: &Glued<'_>, windows: &Windows<'_, '_>, target: u32) -> GeodesicPath {
    let length = windows.distance(target);
    let mut points = Vec::new();
    let mut node = target;
    loop {
        let own = windows.place(node);
        let at = |otherwise: SurfacePoint| own.map_or(otherwise, |place| place.point);
        match windows.arrival(node) {
            Arrival::Unreached => return GeodesicPath { points, length },
            Arrival::Source => {
                match own {
                    Some(place) => points.push(place.point),
                    None => {
                        let corner = glued.slots_at(node).first();
                        points.extend(corner.map(|&corner| SurfacePoint::on_edge(corner, 0.0)));
                    }
                }
                break;
            }
            Arrival::Edge { slot, from } => {
                let share = if glued.tail(slot) == node { 0.0 } else { 1.0 };
                points.push(SurfacePoint::on_edge(slot, share));
                node = from;
            }
            Arrival::Direct { slot, from, .. } => {
                points.push(at(SurfacePoint::on_edge(slot, 0.0)));
                node = from;
            }
            Arrival::Face { slot, number, .. } => {
                points.push(at(SurfacePoint::on_edge(previous(slot), 0.0)));
                let inside = own.and_then(|place| place.within(slot / 3));
                let end = match inside {
                    Some(point) => glued.local(slot, point.weights),
                    None => glued.unfolded(slot).apex,
                };
                node = back(glued, windows, number, end, &mut points);
            }
        }
    }
    // Around a vertex that the path passes, every edge is crossed at this vertex.
    let mesh = glued.mesh();
    points.dedup_by(|later, kept| later.position(mesh) == kept.position(mesh));
    points.reverse();
    GeodesicPath { points, length }
}

/// Adds the crossings of edges of the straight path from `end`, in the face of a window unfolded
/// along its edge, back to the node where the window starts, and returns that node.
fn back(
    glued: &Glued<'_>,
    windows: &Windows<'_, '_>,
    number: usize,
    mut end: [f64; 2],
    points: &mut Vec<SurfacePoint>,
) -> u32 {
    let mut window = windows.window(number);
    loop {
        let ([p, q], [x, y]) = (window.ends, window.source);
        let crossing = crossing([x, y], end).clamp(p, q);
        let length = glued.length(window.slot);
        let near = NEAR * (length + x.abs() + y);
        let share = match crossing {
            crossing if crossing <= near => 0.0,
            crossing if crossing >= length - near => 1.0,
            crossing => crossing / length,
        };
        points.push(SurfacePoint::on_edge(window.slot, share));
        let Some(before) = window.before else {
            return window.origin;
        };
        // The crossing in the face before, unfolded along the edge of the window before.
        let ends = [window.slot, next(window.slot)].map(|slot| glued.tail(slot));
        window = windows.window(before);
        let [a, b] = ends.map(|vertex| glued.place(window.slot, vertex));
        end = [0, 1].map(|k| (1.0 - share) * a[k] + share * b[k]);
    }
}
