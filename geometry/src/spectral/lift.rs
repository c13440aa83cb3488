//! Functions and maps between a mesh and its decimation.

use faer::{Mat, MatRef};
use sprs::CsMat;

use crate::decimate::Decimation;
use crate::mesh::TriMesh;
use catamaran::base::{Error, Par, Result};
use catamaran::dense::zeros;

/// Takes functions on a mesh of n vertices to its decimation of m vertices, and back. The point of
/// a vertex v of one mesh on another, from the points between their decimations, is
/// `source.corners()[points[target.nearest()[v]]]`.
///
/// ```
/// use catamaran::Par;
/// use catamaran_geometry::{decimate::{DecimateOptions, decimate}, mesh::families};
/// use catamaran_geometry::spectral::{Lift, coordinates};
///
/// let sphere = families::icosphere(3)?;
/// let found = decimate(&sphere, 200, &DecimateOptions::new())?;
/// let lift = Lift::new(&sphere, &found, Par::Seq)?;
/// let coarse = lift.restrict(coordinates(&sphere).as_ref())?;
/// let fine = lift.prolong(coarse.as_ref())?;
/// assert_eq!((coarse.nrows(), fine.nrows()), (200, 642));
/// assert!((fine - coordinates(&sphere)).norm_max() < 0.1);
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Lift {
    /// n x m.
    weights: CsMat<f64>,
    /// For each vertex of the decimation, the corners of the face of the mesh on which it lies, and
    /// its barycentric coordinates there.
    places: Vec<([u32; 3], [f64; 3])>,
    /// For each vertex of the mesh, the nearest vertex of the decimation.
    nearest: Vec<u32>,
}

impl Lift {
    /// Creates the lift from the decimation `of` of `mesh`.
    ///
    /// # Errors
    /// [`Error::Shape`] when `of` is the decimation of another mesh, [`Error::Argument`] names the
    /// first vertex of `mesh` without a face, [`Error::OutOfMemory`].
    pub fn new(mesh: &TriMesh, of: &Decimation, par: Par) -> Result<Self> {
        let weights = of.weights(mesh, par)?;
        let nearest = of.cells.of_vertices().to_vec();
        let coarse = of.mesh.vertices().len();
        if let Some(v) = nearest.iter().position(|&cell| cell as usize >= coarse) {
            return Err(Error::Argument { what: "mesh", why: format!("vertex {v} has no face") });
        }
        let corners =
            |place: &crate::mesh::SurfacePoint| (mesh.faces()[place.face as usize], place.weights);
        Ok(Self { weights, places: of.places.iter().map(corners).collect(), nearest })
    }

    /// Returns functions (n x c) at the vertices of the decimation (m x c), linear on each face of
    /// the mesh.
    ///
    /// # Errors
    /// [`Error::Shape`] unless `f` has a row for each vertex of the mesh, [`Error::OutOfMemory`].
    pub fn restrict(&self, f: MatRef<'_, f64>) -> Result<Mat<f64>> {
        Error::check_shape("functions", (self.nearest.len(), f.ncols()), f.shape())?;
        let mut coarse = zeros(self.places.len(), f.ncols())?;
        for j in 0..f.ncols() {
            for (i, (corners, weights)) in self.places.iter().enumerate() {
                coarse[(i, j)] = (0..3).map(|k| weights[k] * f[(corners[k] as usize, j)]).sum();
            }
        }
        Ok(coarse)
    }

    /// Returns functions on the decimation (m x c) at the vertices of the mesh (n x c), linear on
    /// each face of the decimation.
    ///
    /// # Errors
    /// [`Error::Shape`] unless `g` has a row for each vertex of the decimation,
    /// [`Error::OutOfMemory`].
    pub fn prolong(&self, g: MatRef<'_, f64>) -> Result<Mat<f64>> {
        Error::check_shape("functions", (self.places.len(), g.ncols()), g.shape())?;
        let mut fine = zeros(self.nearest.len(), g.ncols())?;
        for j in 0..g.ncols() {
            for (i, row) in self.weights.outer_iterator().enumerate() {
                fine[(i, j)] = row.iter().map(|(k, weight)| weight * g[(k, j)]).sum();
            }
        }
        Ok(fine)
    }

    /// Returns, for each vertex of the mesh, the nearest vertex of the decimation.
    pub fn nearest(&self) -> &[u32] {
        &self.nearest
    }

    /// Returns, for each vertex of the decimation, the vertex of the mesh nearest to it among the
    /// corners of its face, by barycentric coordinates.
    pub fn corners(&self) -> Vec<u32> {
        let corner = |(corners, weights): &([u32; 3], [f64; 3])| {
            let heaviest = (0..3).max_by(|&i, &j| weights[i].total_cmp(&weights[j]));
            corners[heaviest.unwrap_or(0)]
        };
        self.places.iter().map(corner).collect()
    }
}
