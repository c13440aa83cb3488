//! Which Laplacian is asked for.

use crate::base::{Par, builder};

/// The triangles on which the functions are linear.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LaplacianKind {
    /// Those of the mesh: the cotangent Laplacian. Any set of triangles, as long as each has an
    /// area.
    #[default]
    Cotangent,
    /// Those of the intrinsic Delaunay triangulation of the same surface and vertices: no edge
    /// inside has a negative weight. For surfaces: no edge of three faces, neighbours that agree on
    /// the outside. Lengths are mollified first.
    IntrinsicDelaunay,
    /// Those of the intrinsic Delaunay triangulation of the tufted cover, which has each face
    /// twice, front and back; both matrices are halved. No edge has a negative weight. Any mesh
    /// whatever; lengths are mollified first.
    Tufted,
}

/// How the mass of a triangle is distributed to its vertices.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum MassKind {
    /// A third to each, a diagonal.
    #[default]
    Barycentric,
    /// What is nearest to each, a diagonal; of an obtuse triangle half to the obtuse corner and a
    /// quarter to the others (Meyer et al. 2003, section 3.3).
    MixedVoronoi,
    /// The inner product of linear functions, a full matrix: of the area a 6th on the diagonal, a
    /// 12th beside it.
    Consistent,
}

/// The condition at the boundary: the edges with one face.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Boundary {
    /// The normal derivative is zero, the natural condition.
    #[default]
    Neumann,
    /// Functions are zero at the vertices of the boundary; these are left out of the matrices.
    Dirichlet,
    /// Functions are zero at these vertices, on the boundary or not; Neumann elsewhere.
    Mixed(Vec<u32>),
}

/// Options of [`laplacian()`](super::laplacian()).
///
/// ```
/// use catamaran::mesh::{LaplacianKind, LaplacianOptions, MassKind, families, laplacian};
///
/// let options = LaplacianOptions::new().kind(LaplacianKind::Tufted).mass(MassKind::MixedVoronoi);
/// let matrices = laplacian(&families::icosphere(1)?, &options)?;
/// assert_eq!(matrices.kept.len(), 42);
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
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

builder! { LaplacianOptions {
    kind: LaplacianKind,
    mass: MassKind,
    boundary: Boundary,
    par: Par,
}}
