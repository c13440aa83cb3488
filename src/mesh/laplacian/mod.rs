//! The Laplacian of a mesh: stiffness W and mass M of linear finite elements, so that
//! `W phi = lambda M phi` is the eigenproblem of the Laplace-Beltrami operator (positive sign).
//!
//! Sources: Pinkall and Polthier, Computing Discrete Minimal Surfaces and Their Conjugates (1993);
//! Meyer, Desbrun, Schroeder and Barr, Discrete Differential-Geometry Operators (2003), for the mixed Voronoi areas;
//! Bobenko and Springborn, A Discrete Laplace-Beltrami Operator for Simplicial Surfaces (2007), for the
//! intrinsic Delaunay triangulation; Sharp and Crane, A Laplacian for Nonmanifold Triangle Meshes (2020).

mod assembly;
mod boundary;
mod complex;
mod delaunay;
mod element;
#[cfg(test)]
mod tests;

use std::borrow::Cow;

use faer::{Mat, MatRef};
use sprs::CsMat;

use super::TriMesh;
use crate::base::{Error, Par, Result};
use crate::sparse::Mass;

pub(crate) use assembly::assemble;
pub(crate) use complex::Complex;
pub(crate) use delaunay::ROUNDING;
pub(crate) use element::{Element, of_mesh};

/// Which triangles the functions are linear on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LaplacianKind {
    /// Those of the mesh: the cotangent Laplacian. Any set of triangles, as long as each has an area.
    #[default]
    Cotangent,
    /// Those of the intrinsic Delaunay triangulation of the same surface and vertices: no edge inside has a negative
    /// weight. For surfaces: no edge of three faces, neighbours that agree on the outside. Lengths are mollified first.
    IntrinsicDelaunay,
    /// Those of the intrinsic Delaunay triangulation of the tufted cover, which has each face twice, front and back;
    /// both matrices are halved. No edge has a negative weight. Any mesh whatever; lengths are mollified first.
    Tufted,
}

/// How the mass of a triangle goes to its vertices.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum MassKind {
    /// A third to each, a diagonal.
    #[default]
    Barycentric,
    /// What is nearest to each, a diagonal; of an obtuse triangle half to the obtuse corner and a quarter to the others
    /// (Meyer et al. 2003, section 3.3).
    MixedVoronoi,
    /// The inner product of linear functions, a full matrix: of the area a 6th on the diagonal, a 12th beside it.
    Consistent,
}

/// What holds at the boundary: the edges with one face.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Boundary {
    /// The normal derivative is zero, which takes no doing.
    #[default]
    Neumann,
    /// Functions are zero at the vertices of the boundary; these are left out of the matrices.
    Dirichlet,
    /// Functions are zero at these vertices, on the boundary or not; Neumann elsewhere.
    Mixed(Vec<u32>),
}

/// Options of [`laplacian()`].
#[derive(Debug, Clone, PartialEq)]
pub struct LaplacianOptions {
    /// Triangles; default [`LaplacianKind::Cotangent`].
    pub kind: LaplacianKind,
    /// Mass; default [`MassKind::Barycentric`].
    pub mass: MassKind,
    /// Boundary; default [`Boundary::Neumann`].
    pub boundary: Boundary,
    /// Threads; default all cores of the affinity mask. Does not change the result.
    pub par: Par,
}

impl Default for LaplacianOptions {
    fn default() -> Self {
        Self {
            kind: LaplacianKind::default(),
            mass: MassKind::default(),
            boundary: Boundary::default(),
            par: Par::all(),
        }
    }
}

/// The matrices of the eigenproblem `W phi = lambda M phi`. Rows stand for the vertices in [`Laplacian::kept`].
#[derive(Debug, Clone, PartialEq)]
pub struct Laplacian {
    /// W: symmetric, positive semi-definite, by rows, both triangles, a diagonal entry in every row. Off the diagonal,
    /// minus the weights: halves of the cotangents that face an edge. `W 1 = 0` but for rounding (Neumann).
    pub stiffness: CsMat<f64>,
    /// M: positive definite; its entries sum to the area (Neumann).
    pub mass: Mass,
    /// The vertices that the rows stand for, ascending. Left out are those that the boundary conditions set to zero,
    /// and those in no face, which have no area, whatever the kind.
    pub kept: Vec<usize>,
    /// The number of vertices of the mesh.
    pub vertices: usize,
}

impl Laplacian {
    /// Functions on the mesh (one row a vertex, one column a function) from functions on the rows: zero at vertices
    /// that have none.
    ///
    /// # Errors
    /// [`Error::Shape`] unless it has one row for each vertex kept.
    pub fn extend(&self, functions: MatRef<'_, f64>) -> Result<Mat<f64>> {
        let columns = functions.ncols();
        let expected = (self.kept.len(), columns);
        Error::check_shape("functions", expected, (functions.nrows(), columns))?;
        let mut extended = Mat::zeros(self.vertices, columns);
        for j in 0..columns {
            for (row, &vertex) in self.kept.iter().enumerate() {
                extended[(vertex, j)] = functions[(row, j)];
            }
        }
        Ok(extended)
    }

    /// The Laplacian with Dirichlet conditions at all vertices but those in the mask: only their rows and columns are kept,
    /// as far as they were there.
    ///
    /// # Errors
    /// [`Error::Shape`] unless the mask has an entry for each vertex of the mesh.
    pub fn restricted(&self, mask: &[bool]) -> Result<Self> {
        Error::check_shape("mask", (self.vertices, 1), (mask.len(), 1))?;
        Ok(boundary::part(self, mask))
    }

    /// The rows, of functions on the mesh, of the vertices kept.
    ///
    /// # Errors
    /// [`Error::Shape`] unless it has one row for each vertex of the mesh.
    pub fn restrict(&self, functions: MatRef<'_, f64>) -> Result<Mat<f64>> {
        let columns = functions.ncols();
        let expected = (self.vertices, columns);
        Error::check_shape("functions", expected, (functions.nrows(), columns))?;
        Ok(Mat::from_fn(self.kept.len(), columns, |row, j| functions[(self.kept[row], j)]))
    }
}

/// The Laplacian of a mesh, with nothing but finite numbers.
///
/// With V vertices and F faces this takes O(V + F) time and memory, and for the kinds other than
/// [`LaplacianKind::Cotangent`] also O(1) for each flip of an edge.
///
/// # Errors
/// [`Error::Mesh`] names a face without area (to within rounding: an angle of a few 1e-16), where the kind is
/// [`LaplacianKind::Cotangent`] or all vertices of the face coincide; an edge that an intrinsic Delaunay triangulation
/// can't have; a vertex of [`Boundary::Mixed`] that is not there; whatever has a weight or mass out of the range of
/// `f64`. [`Error::Argument`] for 7e8 faces or more; [`Error::NotConverged`] when flips go on without end.
pub fn laplacian(mesh: &TriMesh, options: &LaplacianOptions) -> Result<Laplacian> {
    if u32::try_from(mesh.faces().len().saturating_mul(6)).is_err() {
        let why = format!("{} of them, where at most 7e8 can be numbered", mesh.faces().len());
        return Err(Error::Argument { what: "faces", why });
    }
    let removed = boundary::removed(mesh, &options.boundary)?;
    let (faces, elements, rounding) = match options.kind {
        LaplacianKind::Cotangent => (Cow::Borrowed(mesh.faces()), of_mesh(mesh, options.par)?, 0.0),
        kind => {
            let complex = Complex::delaunay(mesh, kind)?;
            let elements = complex.elements()?;
            (Cow::Owned(complex.into_faces()), elements, ROUNDING)
        }
    };
    let n = mesh.vertices().len();
    let (stiffness, mass) = assemble(n, &faces, &elements, rounding, options.mass, options.par);
    boundary::restrict(stiffness, mass, &removed)
}
