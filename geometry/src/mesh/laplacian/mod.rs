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
use std::ops::Range;

use super::TriMesh;
use catamaran::base::{Error, Result};

pub(crate) use assembly::assemble;
use boundary::Places;
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
    laplacian_rows(mesh, options, |rows| 0..rows)
}

/// Computes some rows of the Laplacian of a mesh, for processes that hold some rows each: `share`
/// returns those of this process, given the number of all rows. Only these rows of W and M are
/// held. They are the same, bit for bit, as those of [`laplacian`].
///
/// ```
/// use catamaran_geometry::mesh::{LaplacianOptions, families, laplacian, laplacian_rows};
///
/// let (mesh, options) = (families::icosphere(2)?, LaplacianOptions::new());
/// let first = laplacian_rows(&mesh, &options, |rows| 0..rows / 2)?;
/// assert_eq!((first.stiffness.rows(), first.stiffness.cols()), (81, 162));
/// assert_eq!(first.kept.len(), 162);
/// let whole = laplacian(&mesh, &options)?;
/// assert_eq!(first.stiffness.outer_view(80), whole.stiffness.outer_view(80));
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// Those of [`laplacian`], for entries of these rows only; [`Error::Argument`] for rows that the
/// matrices do not have.
pub fn laplacian_rows(
    mesh: &TriMesh,
    options: &LaplacianOptions,
    share: impl FnOnce(usize) -> Range<usize>,
) -> Result<Laplacian> {
    if u32::try_from(mesh.faces().len().saturating_mul(6)).is_err() {
        let why = format!("at most 7e8 are possible, got {}", mesh.faces().len());
        return Err(Error::Argument { what: "faces", why });
    }
    let places = Places::new(mesh, &options.boundary)?;
    let count = places.kept.len();
    let rows = share(count);
    if rows.start > rows.end || rows.end > count {
        let why = format!("must be among {count}, are {rows:?}");
        return Err(Error::Argument { what: "rows", why });
    }
    let (faces, elements, rounding) = match options.kind {
        LaplacianKind::Cotangent => (Cow::Borrowed(mesh.faces()), of_mesh(mesh, options.par)?, 0.0),
        kind => {
            let complex = Complex::delaunay(mesh, kind)?;
            let elements = complex.elements()?;
            (Cow::Owned(complex.into_faces()), elements, ROUNDING)
        }
    };
    let n = mesh.vertices().len();
    let own = places.vertices(rows.clone());
    let (stiffness, mass) =
        assemble(n, own.clone(), &faces, &elements, rounding, options.mass, options.par)?;
    places.restrict(stiffness, mass, own.start, rows)
}
