use super::TriMesh;
use super::compare::nearest_on_triangle;
use super::slots::next;
use super::vector::{Vector, distance};

/// The position of a point on a mesh: of a sample, or of an end of a path.
///
/// ```
/// use catamaran_geometry::mesh::{Site, SurfacePoint};
///
/// assert_eq!(Site::from(7_u32), Site::Vertex(7));
/// let point = SurfacePoint { face: 0, weights: [0.2, 0.3, 0.5] };
/// assert_eq!(Site::from(point), Site::Face(point));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Site {
    /// At a vertex.
    Vertex(u32),
    /// On a face; the sum of the barycentric coordinates is 1 to 1e-6.
    Face(SurfacePoint),
    /// At the vertex of a face that is nearest to a point in space.
    Near([f64; 3]),
}

impl From<u32> for Site {
    fn from(vertex: u32) -> Self {
        Self::Vertex(vertex)
    }
}

impl From<SurfacePoint> for Site {
    fn from(point: SurfacePoint) -> Self {
        Self::Face(point)
    }
}

impl Site {
    /// Returns why the mesh has no such position; `None` if it has.
    pub(crate) fn fault(&self, mesh: &TriMesh) -> Option<String> {
        let beyond = |what: &str, number: u32, of: usize, many: &str| {
            let is_there = (number as usize) < of;
            let why = || format!("{what} {number} is out of range: {of} {many}, numbered from 0");
            (!is_there).then(why)
        };
        match *self {
            Self::Vertex(v) => beyond("vertex", v, mesh.vertices().len(), "vertices"),
            Self::Face(SurfacePoint { face, weights }) => {
                let sum: f64 = weights.iter().sum();
                let is_right = weights.iter().all(|&w| w >= 0.0) && (sum - 1.0).abs() <= 1e-6;
                let wrong = || format!("face {face}: wrong barycentric coordinates {weights:?}");
                beyond("face", face, mesh.faces().len(), "faces")
                    .or_else(|| (!is_right).then(wrong))
            }
            Self::Near(point) if !point.iter().all(|x| x.is_finite()) => {
                Some(format!("the point must be finite, is {point:?}"))
            }
            Self::Near(_) if mesh.faces().is_empty() => {
                Some("a point in space needs a mesh with faces".into())
            }
            Self::Near(_) => None,
        }
    }
}

/// Returns the vertex that is nearest to a point in space among those with a face, which `used`
/// marks; the lowest of equally near ones.
pub(crate) fn nearest_vertex(mesh: &TriMesh, used: &[bool], point: Vector) -> Option<u32> {
    let all = (0..).zip(mesh.vertices()).filter(|&(v, _): &(u32, _)| used[v as usize]);
    let near = all.map(|(v, &p)| (distance(p, point), v)).min_by(|x, y| x.0.total_cmp(&y.0));
    near.map(|(_, v)| v)
}

/// A point of a mesh, by a face and barycentric coordinates. Two coordinates are 0 at a vertex, one
/// is 0 on an edge.
///
/// ```
/// use catamaran_geometry::mesh::{SurfacePoint, TriMesh};
///
/// let mesh = TriMesh::new(vec![[0.0; 3], [4.0, 0.0, 0.0], [0.0, 8.0, 0.0]], vec![[0, 1, 2]])?;
/// let point = SurfacePoint { face: 0, weights: [0.25, 0.5, 0.25] };
/// assert_eq!(point.position(&mesh), [2.0, 2.0, 0.0]);
/// assert_eq!((point.interpolate([[1.0], [2.0], [5.0]]), point.heaviest()), ([2.5], 1));
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePoint {
    /// The face of the point.
    pub face: u32,
    /// Its barycentric coordinates in the face, from 0 to 1, with sum 1.
    pub weights: [f64; 3],
}

impl SurfacePoint {
    /// Returns the point of the edge of a slot at this share from its start to its end.
    pub(crate) fn on_edge(slot: u32, share: f64) -> Self {
        let mut weights = [0.0; 3];
        weights[slot as usize % 3] = 1.0 - share;
        weights[next(slot) as usize % 3] = share;
        Self { face: slot / 3, weights }
    }

    /// Returns the point of a face of `mesh` that is nearest to p, and its position.
    pub(crate) fn nearest(mesh: &TriMesh, face: u32, p: Vector) -> (Self, Vector) {
        let corners = mesh.corners_of(mesh.faces()[face as usize]);
        let (position, weights) = nearest_on_triangle(corners, p);
        (Self { face, weights }, position)
    }

    /// Returns the position of the point. Panics when the mesh does not have the face.
    pub fn position(&self, mesh: &TriMesh) -> Vector {
        self.interpolate(mesh.corners_of(mesh.faces()[self.face as usize]))
    }

    /// Returns the value at this point of a function that is linear on the face and has these
    /// values at its corners.
    pub fn interpolate<const N: usize>(&self, values: [[f64; N]; 3]) -> [f64; N] {
        interpolate(self.weights, values)
    }

    /// Returns the corner of the face with the largest barycentric coordinate, 0 to 2.
    pub fn heaviest(&self) -> usize {
        (0..3).max_by(|&i, &j| self.weights[i].total_cmp(&self.weights[j])).unwrap_or(0)
    }
}

/// Returns the sum of three values with these weights.
pub(crate) fn interpolate<const N: usize>(weights: [f64; 3], values: [[f64; N]; 3]) -> [f64; N] {
    std::array::from_fn(|k| (0..3).map(|i| weights[i] * values[i][k]).sum())
}
