use crate::base::builder;

/// Which vertices [`repair`](super::repair()) makes one.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Weld {
    /// None.
    #[default]
    Never,
    /// Those with equal positions (-0 equals 0).
    Exact,
    /// Those at most so far, in units of length, from a vertex of lower number that stays: the
    /// lowest one. Joined vertices are never farther than that from where they were.
    Within(f64),
    /// Those at the ends of boundary edges in one place, where these are two: seams are closed, and
    /// what only touches stays apart.
    Seams,
}

/// Options of [`repair`](super::repair()): its steps. By default there are none.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub struct RepairOptions {
    /// Which vertices become one; faces that lose a corner by that are left out.
    pub weld: Weld,
    /// Whether faces with the vertices of an earlier one, in any order, are left out.
    pub drop_duplicates: bool,
    /// Whether faces without area
    /// ([`faces_without_area`](crate::mesh::TriMesh::faces_without_area)) are removed: by joining
    /// two corners in one place, by flipping the longest edge, or, where the result of both would
    /// not be a manifold, by leaving them out.
    pub drop_degenerate: bool,
    /// Whether vertices that no face has are left out.
    pub compact: bool,
    /// Whether the mesh is cut along edges of more than two faces, and at vertices at which the
    /// surface meets itself.
    pub cut: bool,
    /// How many components are kept: those with the most faces. All by default.
    pub keep_largest: Option<usize>,
    /// Components with less than this share of the area of the mesh are left out, from 0 to 1. None
    /// by default.
    pub drop_specks: Option<f64>,
    /// Fills holes of at most this many edges. Default: no holes.
    pub fill_holes: Option<usize>,
    /// Whether faces are flipped to agree with their neighbours, and in closed components so that
    /// they are counter-clockwise as seen from outside. A closed component that is inside an odd
    /// number of others bounds a cavity, and its outside is within.
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
    /// Returns options with all steps that need no number: [`Weld::Seams`], and neither components
    /// left out nor holes filled.
    pub fn everything() -> Self {
        Self::new()
            .weld(Weld::Seams)
            .drop_duplicates(true)
            .drop_degenerate(true)
            .compact(true)
            .cut(true)
            .orient(true)
    }

    /// Returns options with the steps that have one sensible outcome: [`Weld::Seams`], repeated
    /// faces and faces without area.
    pub fn unambiguous() -> Self {
        Self::new().weld(Weld::Seams).drop_duplicates(true).drop_degenerate(true)
    }
}
