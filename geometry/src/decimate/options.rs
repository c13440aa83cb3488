use catamaran::base::{Par, Progress, options};

/// The method by which faces are found and vertices placed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// Farthest points in batches, the dual triangulation made manifold, Lloyd passes, and
    /// relaxation on the surface. The result has exactly n vertices and the topology of the input.
    Uniform,
    /// The algorithm of the thesis, for comparison: one farthest point after the other (algorithm
    /// 5.2), with every three-cycle of the graph of cells as a face. In general, the result is no
    /// manifold. Passes have no effect.
    Thesis,
}

options! {
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
    pub struct DecimateOptions<'a> {
        /// The method.
        method: Method = Method::Uniform;
        /// Whether edges longer than the edges of the result
        /// ([`edge_length_for`](super::edge_length_for)) are split first. Without the splits, which
        /// is meant for comparison, large faces of the input leave holes in the result, and n is at
        /// most the number of vertices. [`Method::Thesis`] never splits edges.
        resample: bool = true;
        /// Number of Lloyd passes over the input. Each moves the samples to the centroids of their
        /// cells, and grows the cells again. Relaxation achieves more at less cost.
        lloyd: usize = 0;
        /// Number of relaxation passes over the result. A pass makes edges Delaunay, moves vertices
        /// on the surface to the centroids of their faces or to its creases, and exchanges short
        /// edges for long ones. At the end, vertices are raised off the surface, so that it does
        /// not lie on one side of the faces, and the places farthest from it are repaired; 0 omits
        /// all of this.
        relaxation: usize = 12;
        /// Whether the relaxation ends with passes that make the areas of the triangles as equal as
        /// possible, at the cost of their shapes: areas vary half as much. It has no effect without
        /// relaxation passes.
        uniform: bool = false;
        /// Whether handles that are too narrow for the triangles of the result are cut and their
        /// ends closed, as [`Decimation::after`](super::Decimation::after) reports. Otherwise all
        /// handles are kept.
        cut_narrow_handles: bool = false;
        /// The vertex of the first sample, which must have a face; `None`: the lowest vertex with a
        /// face.
        first: Option<u32> = None, setter into;
        /// Vertices of the input that stay, each once: they are the first vertices of the result,
        /// in this order, at exactly the same positions, and an edge of the input between two of
        /// them stays an edge, unless it is longer than the edges of the result and split
        /// (`resample`; [`Decimation::lost_edges`](super::Decimation::lost_edges) counts
        /// those). n must be at least their number. Not with [`Method::Thesis`].
        locked: &'a [u32] = &[];
        /// Vertices of the result per area, relative to elsewhere: one number for each vertex of
        /// the input, all positive, at most 10^12 times the least; only ratios count. Between
        /// vertices, the square root is linear. Empty: the same everywhere. Not with
        /// [`Method::Thesis`].
        density: &'a [f64] = &[];
        /// Largest ratio of the numbers of vertices per area where the surface bends most and where
        /// it is flat; 1: the same everywhere. `density` is multiplied by
        /// [`curvature_density`](super::curvature_density). Not with [`Method::Thesis`].
        curvature: f64 = 1.0, check(from 1.0 to 1e6);
        /// Threads. Their number does not change the result.
        par: Par = Par::all();
        /// Callback for progress, which may cancel.
        progress: Progress<'a> = Progress::none(), setter into;
    }
}
