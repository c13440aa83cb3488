use catamaran::base::options;

/// The vertices that [`repair`](super::repair()) joins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Weld {
    /// None.
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

options! {
    /// Options of [`repair`](super::repair()): the steps to take. By default there are none.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct RepairOptions {
        /// The vertices to join; faces that lose a corner thereby are left out.
        weld: Weld = Weld::Never;
        /// Whether faces with the vertices of an earlier face, in any order, are left out.
        drop_duplicates: bool = false;
        /// Whether faces without area
        /// ([`faces_without_area`](crate::mesh::TriMesh::faces_without_area)) are removed: by
        /// joining two corners in one place, by flipping the longest edge, or, where the result of
        /// both would not be a manifold, by leaving them out.
        drop_degenerate: bool = false;
        /// Whether vertices without a face are left out.
        compact: bool = false;
        /// Whether the mesh is cut along edges of more than two faces, and at vertices where the
        /// surface meets itself.
        cut: bool = false;
        /// Number of components to keep: those with the most faces. `None`: all of them.
        keep_largest: Option<usize> = None, range "at least 1", setter into;
        /// Components with less than this share of the area of the mesh are left out. `None`: no
        /// component is.
        drop_specks: Option<f64> = None, range "from 0 to 1", setter into;
        /// Holes of at most this many edges are filled. `None`: no hole is.
        fill_holes: Option<usize> = None, setter into;
        /// Whether faces are flipped to agree with their neighbours, and in closed components so
        /// that they are counter-clockwise as seen from outside. A closed component inside of an
        /// odd number of others bounds a cavity, and its outside is the side of the cavity.
        orient: bool = false;
    }
}

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
