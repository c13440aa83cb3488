use super::glued::Glued;
use crate::mesh::slots::next;
use crate::mesh::{Site, SurfacePoint, nearest_vertex};
use catamaran::base::{Error, Result};

/// Barycentric coordinates below this count as 0: the point is on an edge, or at a vertex.
const NOTHING: f64 = 1e-12;

/// A point inside a face, or on an edge but not at its ends.
#[derive(Debug, Clone)]
pub(super) struct Place {
    /// The point in the face that the caller named.
    pub point: SurfacePoint,
    /// The point in every face that has it: in one, or in all faces of its edge.
    pub faces: Vec<SurfacePoint>,
}

impl Place {
    /// Returns the point in this face; `None` unless the face has it.
    pub fn within(&self, face: u32) -> Option<SurfacePoint> {
        self.faces.iter().copied().find(|point| point.face == face)
    }
}

/// Where a path starts or ends.
#[derive(Debug, Clone)]
pub(super) enum Spot {
    Vertex(u32),
    Place(Place),
}

impl Spot {
    /// Finds the vertex, edge or face of a position.
    ///
    /// # Errors
    /// [`Error::Argument`] of `what` for a position that the mesh does not have.
    pub fn new(glued: &Glued<'_>, what: &'static str, site: Site) -> Result<Self> {
        let mesh = glued.mesh();
        if let Some(why) = site.fault(mesh) {
            return Err(Error::Argument { what, why });
        }
        let point = match site {
            Site::Vertex(v) => return Ok(Self::Vertex(v)),
            Site::Near(point) => {
                let found = nearest_vertex(mesh, &mesh.referenced(), point);
                let none = || Error::Argument { what, why: "no vertex has a face".into() };
                return found.map(Self::Vertex).ok_or_else(none);
            }
            Site::Face(point) => cleaned(point),
        };
        Ok(match support(point) {
            Support::Vertex(corner) => Self::Vertex(glued.tail(corner)),
            Support::Edge(slot) => {
                let share = point.weights[next(slot) as usize % 3];
                let start = glued.tail(slot);
                let beyond = glued.across(slot).map(|other| {
                    let is_same_way = glued.tail(other) == start;
                    SurfacePoint::on_edge(other, if is_same_way { share } else { 1.0 - share })
                });
                Self::Place(Place { point, faces: [point].into_iter().chain(beyond).collect() })
            }
            Support::Face => Self::Place(Place { point, faces: vec![point] }),
        })
    }
}

/// What a point of a face is on, with slots of the face.
pub(super) enum Support {
    /// The vertex where the slot starts.
    Vertex(u32),
    /// The edge of the slot.
    Edge(u32),
    Face,
}

/// Returns what a point is on whose coordinates are [`cleaned`].
pub(super) fn support(point: SurfacePoint) -> Support {
    let slots = [0, 1, 2].map(|corner| 3 * point.face + corner);
    let is_on = |slot: &&u32| point.weights[**slot as usize % 3] > 0.0;
    let is_off = |slot: &&u32| !is_on(slot);
    match slots.iter().filter(is_off).count() {
        0 => Support::Face,
        // The edge of an end is the one after it; the other corner is off the edge.
        1 => slots.iter().find(is_off).map_or(Support::Face, |&slot| Support::Edge(next(slot))),
        _ => slots.iter().find(is_on).map_or(Support::Face, |&slot| Support::Vertex(slot)),
    }
}

/// Returns the point with coordinates that are 0 where they nearly are, and whose sum is 1.
pub(super) fn cleaned(point: SurfacePoint) -> SurfacePoint {
    let weights = point.weights.map(|w| if w < NOTHING { 0.0 } else { w });
    let sum: f64 = weights.iter().sum();
    SurfacePoint { weights: weights.map(|w| w / sum), ..point }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    #[test]
    fn a_point_of_an_edge_is_in_all_faces_of_the_edge() {
        // Two triangles, 0 1 3 and 0 3 2: their common edge is the diagonal.
        let mesh = shapes::grid(1, 1);
        let glued = Glued::new(&mesh).unwrap();
        for face in 0..2 {
            for corner in 0..3 {
                let mut weights = [0.25, 0.75, 0.0];
                weights.rotate_right(corner);
                let point = SurfacePoint { face, weights };
                let Spot::Place(place) = Spot::new(&glued, "sources", point.into()).unwrap() else {
                    panic!("{point:?} is a vertex");
                };
                let position = point.position(&mesh);
                let is_inside = position[..2].iter().all(|&x| x > 0.0 && x < 1.0);
                assert_eq!(place.faces.len(), if is_inside { 2 } else { 1 });
                assert!(place.faces.iter().all(|other| other.position(&mesh) == position));
            }
        }
        let vertex = SurfacePoint { face: 1, weights: [0.0, 1e-14, 1.0] };
        let found = Spot::new(&glued, "sources", vertex.into()).unwrap();
        assert!(matches!(found, Spot::Vertex(v) if v == mesh.faces()[1][2]));
    }
}
