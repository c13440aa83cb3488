//! The Laplacian of a mesh: stiffness W and mass M of linear finite elements, so that
//! `W phi = lambda M phi` is the eigenproblem of the Laplace-Beltrami operator (positive sign).
//!
//! Sources: Pinkall and Polthier, Computing Discrete Minimal Surfaces and Their Conjugates (1993);
//! Meyer, Desbrun, Schroeder and Barr, Discrete Differential-Geometry Operators (2003), for the
//! mixed Voronoi areas; Bobenko and Springborn, A Discrete Laplace-Beltrami Operator for Simplicial
//! Surfaces (2007), for the intrinsic Delaunay triangulation; Sharp and Crane, A Laplacian for
//! Nonmanifold Triangle Meshes (2020).

mod assembly;
mod boundary;
mod complex;
mod delaunay;
mod element;
mod matrices;
mod options;
#[cfg(test)]
mod tests;

use std::borrow::Cow;

use super::TriMesh;
use catamaran::base::{Error, Result};

pub(crate) use assembly::assemble;
pub use boundary::free_components;
pub(crate) use complex::Complex;
pub(crate) use delaunay::ROUNDING;
pub(crate) use element::{Element, of_mesh};
pub use matrices::Laplacian;
pub use options::{Boundary, LaplacianKind, LaplacianOptions, MassKind};

/// Computes the Laplacian of a mesh; all entries are finite.
///
/// With V vertices and F faces this takes O(V + F) time and memory, and for the kinds other than
/// [`LaplacianKind::Cotangent`] also O(1) for each flip of an edge.
///
/// ```
/// use catamaran_geometry::mesh::{LaplacianKind, LaplacianOptions, families, laplacian};
///
/// let mesh = families::icosphere(2)?;
/// let found = laplacian(&mesh, &LaplacianOptions::new().kind(LaplacianKind::IntrinsicDelaunay))?;
/// assert_eq!(found.stiffness.rows(), mesh.vertices().len());
/// // The gradient of a constant is zero.
/// let sums = found.stiffness.outer_iterator().map(|row| row.data().iter().sum::<f64>());
/// assert!(sums.into_iter().all(|sum| sum.abs() < 1e-12));
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Mesh`] names a face without area (to within rounding: an angle of a few 1e-16), where
/// the kind is [`LaplacianKind::Cotangent`] or all vertices of the face coincide; an edge that an
/// intrinsic Delaunay triangulation does not allow; a vertex of [`Boundary::Mixed`] that does not
/// exist; an element with a weight or mass out of the range of `f64`; that of
/// [`TriMesh::check_size`]. [`Error::Argument`] for 7e8 faces or more; [`Error::NotConverged`] when
/// flips do not end.
pub fn laplacian(mesh: &TriMesh, options: &LaplacianOptions) -> Result<Laplacian> {
    if u32::try_from(mesh.faces().len().saturating_mul(6)).is_err() {
        let why = format!("at most 7e8 are possible, got {}", mesh.faces().len());
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
    let (stiffness, mass) = assemble(n, &faces, &elements, rounding, options.mass, options.par)?;
    boundary::restrict(stiffness, mass, &removed)
}
