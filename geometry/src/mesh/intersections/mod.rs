//! Faces of a mesh that intersect each other.

mod boxes;
mod triangles;

pub(crate) use boxes::{Bounds, BoxTree, Curve};
pub(crate) use triangles::{Corners, intersect};

use super::TriMesh;
use catamaran::base::Par;

impl TriMesh {
    /// Returns the faces that intersect another face, ascending. Two faces intersect when they
    /// share a point that is not a common corner or on a common edge, or when they have the same
    /// corners. Corners are the same when their positions are equal, whatever their numbers. The
    /// decision is exact (Shewchuk, Adaptive Precision Floating-Point Arithmetic and Fast Robust
    /// Geometric Predicates, 1997). A face without area counts where it meets a face that has one.
    ///
    /// O(F log F) where faces are spread evenly.
    ///
    /// ```
    /// use catamaran::Par;
    /// use catamaran_geometry::mesh::{TriMesh, families};
    ///
    /// assert!(families::icosphere(2)?.intersecting_faces(Par::Seq).is_empty());
    ///
    /// let vertices = vec![
    ///     [0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0],
    ///     [0.5, 0.5, -1.0], [0.5, 0.5, 1.0], [3.0, 3.0, 0.5],
    /// ];
    /// let crossed = TriMesh::new(vertices, vec![[0, 1, 2], [3, 4, 5]])?;
    /// assert_eq!(crossed.intersecting_faces(Par::Seq), [0, 1]);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    pub fn intersecting_faces(&self, par: Par) -> Vec<u32> {
        let corners = |f: u32| self.corners_of(self.faces()[f as usize]);
        let tree = BoxTree::new(self.faces().len(), |f| Some(Bounds::of(&corners(f as u32))));
        let pairs = tree.pairs(par, |f, g| intersect(&corners(f), &corners(g)));
        let mut faces = pairs.into_flattened();
        faces.sort_unstable();
        faces.dedup();
        faces
    }
}
