use super::TriMesh;
use super::compare::nearest_on_triangle;
use super::vector::Vector;

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
