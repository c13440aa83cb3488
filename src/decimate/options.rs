use crate::base::{Par, Progress, builder};

/// How the faces of the result are found and its vertices placed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Method {
    /// Farthest points in batches, the dual triangulation made manifold, Lloyd passes, vertices
    /// moved over the surface: exactly n vertices, the topology of the input.
    #[default]
    Uniform,
    /// The thesis literally: one farthest point after the other (algorithm 5.2), every three-cycle
    /// of the graph of cells a face. Not a manifold in general; for comparison. Passes count for
    /// nothing.
    Thesis,
}

/// Options of [`decimate`](super::decimate()).
///
/// ```
/// use catamaran::{decimate::{DecimateOptions, decimate}, mesh::families};
///
/// let options = DecimateOptions::new().lloyd(2).relaxation(0).first(5);
/// let found = decimate(&families::icosphere(2)?, 50, &options)?;
/// assert_eq!(found.mesh.faces().len(), 96);
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct DecimateOptions<'a> {
    /// Default [`Method::Uniform`].
    pub method: Method,
    /// Whether edges longer than those of the result will be
    /// ([`edge_length_for`](super::edge_length_for)) are split first; default yes. Without it,
    /// large faces of the input tear the result, and n is at most the number of vertices: for
    /// comparison. [`Method::Thesis`] never does.
    pub resample: bool,
    /// Lloyd passes over the input: each moves the sites to the centroids of their cells, and grows
    /// cells anew; default 0, as relaxation does more at less cost.
    pub lloyd: usize,
    /// Passes over the result: edges made Delaunay, vertices moved on the surface to the centroids
    /// of their faces or to its creases, short edges exchanged for long ones; then vertices are
    /// raised beside the surface, so that it is not all above the faces, and the places farthest
    /// from it are mended. Default 12; with 0, none of this.
    pub relaxation: usize,
    /// Whether handles that are too narrow for the triangles of the result are cut and their ends
    /// closed, as [`Decimation::after`](super::Decimation::after) tells; default no: all are kept.
    pub cut_narrow_handles: bool,
    /// The vertex that the first sample is; default the lowest that a face has. Must be one that a
    /// face has.
    pub first: Option<u32>,
    /// Threads; default all cores of the affinity mask. Does not change the result.
    pub par: Par,
    /// Told of progress; may cancel.
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
