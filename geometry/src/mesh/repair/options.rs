use catamaran::base::builder;

/// The vertices that [`repair`](super::repair()) joins.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Weld {
    /// None.
    #[default]
    Never,
    /// Those with equal positions (-0 equals 0).
    Exact,
    /// Vertices at most this far, in units of length, from a vertex of lower index that stays; each
    /// joins the lowest such vertex. A joined vertex moves by at most this distance.
    Within(f64),
    /// Vertices at the ends of boundary edges that coincide, where exactly two edges do. Seams are
    /// closed, and surfaces that merely touch stay apart.
    Seams,
}

/// Options of [`repair`](super::repair()): the steps to take. By default there are none.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub struct RepairOptions {
    /// The vertices to join; faces that lose a corner thereby are left out.
    pub weld: Weld,
    /// Whether faces with the vertices of an earlier face, in any order, are left out.
    pub drop_duplicates: bool,
    /// Whether faces without area
    /// ([`faces_without_area`](crate::mesh::TriMesh::faces_without_area)) are removed: by joining
    /// two corners in one place, by flipping the longest edge, or, where the result of both would
    /// not be a manifold, by leaving them out.
    pub drop_degenerate: bool,
    /// Whether vertices without a face are left out.
    pub compact: bool,
    /// Whether the mesh is cut along edges of more than two faces, and at vertices where the
    /// surface meets itself.
    pub cut: bool,
    /// Number of components to keep: those with the most faces. All by default.
    pub keep_largest: Option<usize>,
    /// Components with less than this share of the area of the mesh, from 0 to 1, are left out.
    /// None by default.
    pub drop_specks: Option<f64>,
    /// Holes of at most this many edges are filled. None by default.
    pub fill_holes: Option<usize>,
    /// Whether faces are flipped to agree with their neighbours, and in closed components so that
    /// they are counter-clockwise as seen from outside. A closed component inside of an odd number
    /// of others bounds a cavity, and its outside is the side of the cavity.
    pub orient: bool,
}

builder! { RepairOptions {
    weld: Weld,
    drop_duplicates: bool,
    drop_degenerate: bool,
    compact: bool,
    cut: bool,
    #[into] keep_largest: Option<usize>,
    #[into] drop_specks: Option<f64>,
    #[into] fill_holes: Option<usize>,
    orient: bool,
}}

impl RepairOptions {
    /// Returns options with all steps that need no number: [`Weld::Seams`], no components left out
    /// and no holes filled.
    pub fn everything() -> Self {
        Self::new()
            .weld(Weld::Seams)
            .drop_duplicates(true)
            .drop_degenerate(true)
            .compact(true)
            .cut(true)
            .orient(true)
    }

    /// Returns options with the steps that have a single sensible result: [`Weld::Seams`], repeated
    /// faces and faces without area.
    pub fn unambiguous() -> Self {
        Self::new().weld(Weld::Seams).drop_duplicates(true).drop_degenerate(true)
    }
}
