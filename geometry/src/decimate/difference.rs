//! Distances between two meshes (thesis, equation 5.8).

use rstar::RTree;

use crate::mesh::{TriMesh, Triangles, squares};
use catamaran::base::{Error, Par, Result};

/// Distances between a mesh and its decimation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Difference {
    /// The largest distance of a vertex of either mesh from the surface of the other, in units of
    /// length.
    pub hausdorff: f64,
    /// The mean square of the distances of the vertices of one mesh from the surface of the other,
    /// plus the same in the other direction, in units of length squared.
    pub chamfer: f64,
    /// H of equation 5.8 as printed: the largest distance of a vertex of the first mesh from the
    /// vertices of the second.
    pub printed_hausdorff: f64,
    /// C of equation 5.8 as printed. Its first sum is over the second mesh only, and therefore 0,
    /// so that C is the mean square of the distances of the vertices of the second mesh from those
    /// of the first.
    pub printed_chamfer: f64,
}

impl Difference {
    /// Measures the distances between `first` and `second` in O(V log F).
    ///
    /// ```
    /// use catamaran::Par;
    /// use catamaran_geometry::{decimate::Difference, mesh::families};
    ///
    /// let mesh = families::icosphere(2)?;
    /// let found = Difference::between(&mesh, &mesh, Par::Seq)?;
    /// assert_eq!((found.hausdorff, found.chamfer), (0.0, 0.0));
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Mesh`] when one of them has no face, and that of [`TriMesh::check_size`].
    pub fn between(first: &TriMesh, second: &TriMesh, par: Par) -> Result<Self> {
        for mesh in [first, second] {
            mesh.check_size()?;
            if mesh.faces().is_empty() {
                return Err(Error::Mesh { what: "has no face".into(), element: "mesh".into() });
            }
        }
        let out = Triangles::of(second).squares(first.vertices(), par);
        let back = Triangles::of(first).squares(second.vertices(), par);
        let points = |mesh: &TriMesh| RTree::bulk_load(mesh.vertices().to_vec());
        Ok(Self {
            hausdorff: largest(&out).max(largest(&back)).sqrt(),
            chamfer: mean(&out) + mean(&back),
            printed_hausdorff: largest(&squares(first.vertices(), &points(second), par)).sqrt(),
            printed_chamfer: mean(&squares(second.vertices(), &points(first), par)),
        })
    }
}

fn largest(squares: &[f64]) -> f64 {
    squares.iter().copied().fold(0.0, f64::max)
}

fn mean(squares: &[f64]) -> f64 {
    squares.iter().sum::<f64>() / squares.len().max(1) as f64
}
