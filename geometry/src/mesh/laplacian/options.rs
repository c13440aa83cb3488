//! The options of a Laplacian.

use catamaran::base::{Par, options};

/// The triangulation on which the functions are linear.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LaplacianKind {
    /// The triangles of the mesh: the cotangent Laplacian. Allows any set of triangles that have an
    /// area.
    Cotangent,
    /// The intrinsic Delaunay triangulation of the same surface and vertices, in which no interior
    /// edge has a negative weight. Allows surfaces whose edges have at most two faces, which agree
    /// about which side is outside. Lengths are mollified first.
    IntrinsicDelaunay,
    /// The intrinsic Delaunay triangulation of the tufted cover, which has each face twice, front
    /// and back; both matrices are halved. No edge has a negative weight. Allows any mesh; lengths
    /// are mollified first.
    Tufted,
}

/// How the mass of a triangle is distributed to its vertices.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MassKind {
    /// A third of the area for each corner; diagonal.
    Barycentric,
    /// The area nearest to each corner; diagonal. In an obtuse triangle, half the area for the
    /// obtuse corner and a quarter for the others (Meyer et al. 2003, section 3.3).
    MixedVoronoi,
    /// The inner product of linear functions, a full matrix: a sixth of the area on the diagonal, a
    /// twelfth for each pair of corners.
    Consistent,
}

/// The condition at the boundary: the edges with one face.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Boundary {
    /// The normal derivative is zero, the natural condition.
    Neumann,
    /// Functions are zero at the vertices of the boundary; these are left out of the matrices.
    Dirichlet,
    /// Functions are zero at these vertices, on the boundary or not; Neumann elsewhere.
    Mixed(Vec<u32>),
}

options! {
    /// Options of [`laplacian()`](super::laplacian()).
    ///
    /// ```
    /// use catamaran_geometry::mesh::{LaplacianKind, LaplacianOptions, families, laplacian};
    ///
    /// let options = LaplacianOptions::new().kind(LaplacianKind::Tufted);
    /// let matrices = laplacian(&families::icosphere(1)?, &options)?;
    /// assert_eq!(matrices.kept.len(), 42);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    #[derive(Debug, Clone, PartialEq)]
    pub struct LaplacianOptions {
        /// The triangulation.
        kind: LaplacianKind = LaplacianKind::Cotangent;
        /// How masses are distributed.
        mass: MassKind = MassKind::Barycentric;
        /// The condition at the boundary.
        boundary: Boundary = Boundary::Neumann;
        /// Threads. Their number does not change the result.
        par: Par = Par::all();
    }
}
