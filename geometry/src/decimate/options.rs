use catamaran::base::{Par, Progress, builder};

/// The method by which faces are found and vertices placed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Method {
    /// Farthest points in batches, the dual triangulation made manifold, Lloyd passes, and
    /// relaxation on the surface. The result has exactly n vertices and the topology of the input.
    #[default]
    Uniform,
    /// The algorithm of the thesis, for comparison: one farthest point after the other (algorithm
    /// 5.2), with every three-cycle of the graph of cells as a face. In general, the result is no
    /// manifold. Passes have no effect.
    Thesis,
}

/// Options of [`decimate`](super::decimate()).
///
/// ```
/// use catamaran_geometry::{decimate::{DecimateOptions, decimate}, mesh::families};
///
/// let options = DecimateOptions::new().lloyd(2).relaxation(0).first(5);
/// let found = decimate(&families::icosphere(2)?, 50, &options)?;
/// assert_eq!(found.mesh.faces().len(), 96);
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct DecimateOptions<'a> {
    /// The method; default [`Method::Uniform`].
    pub method: Method,
    /// Whether edges longer than the edges of the result
    /// ([`edge_length_for`](super::edge_length_for)) are split first; default yes. Without the
    /// splits, which is meant for comparison, large faces of the input leave holes in the result,
    /// and n is at most the number of vertices. [`Method::Thesis`] never splits edges.
    pub resample: bool,
    /// Number of Lloyd passes over the input. Each moves the samples to the centroids of their
    /// cells, and grows the cells again. Default 0, because relaxation achieves more at less cost.
    pub lloyd: usize,
    /// Number of relaxation passes over the result. A pass makes edges Delaunay, moves vertices on
    /// the surface to the centroids of their faces or to its creases, and exchanges short edges for
    /// long ones. At the end, vertices are raised off the surface, so that it does not lie on one
    /// side of the faces, and the places farthest from it are repaired. Default 12; 0 omits all of
    /// this.
    pub relaxation: usize,
    /// Whether handles that are too narrow for the triangles of the result are cut and their ends
    /// closed, as [`Decimation::after`](super::Decimation::after) reports; default no: all handles
    /// are kept.
    pub cut_narrow_handles: bool,
    /// The vertex of the first sample, which must have a face; default the lowest vertex with a
    /// face.
    pub first: Option<u32>,
    /// Threads; default [`Par::all`]. Does not change the result.
    pub par: Par,
    /// Callback for progress, which may cancel.
    pub progress: Progress<'a>,
}

impl Default for DecimateOptions<'_> {
    fn default() -> Self {
        Self {
            method: Method::default(),
            resample: true,
            lloyd: 0,
            relaxation: 12,
            cut_narrow_handles: false,
            first: None,
            par: Par::all(),
            progress: Progress::none(),
        }
    }
}

builder! { DecimateOptions<'a> {
    method: Method,
    resample: bool,
    lloyd: usize,
    relaxation: usize,
    cut_narrow_handles: bool,
    #[into] first: Option<u32>,
    par: Par,
    #[into] progress: Progress<'a>,
}}
