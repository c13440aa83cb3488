use std::fmt;

/// The outcome of a reconstruction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Outcome {
    /// Closed curves through all samples except those [left out](Reconstruction::left_out). The
    /// curves meet neither each other nor themselves.
    Closed,
    /// Curves from one end to another, as requested.
    Open,
    /// No path leads from one of the samples to another one that is left.
    Blocked {
        /// The index of that sample.
        at: u32,
        /// Number of samples that the curve has not reached.
        remaining: usize,
    },
    /// All samples are connected, but no path leads back to the first one.
    CloseBlocked,
    /// The samples are on different components of the mesh, so that no curve can connect them; or
    /// none of the components has three samples.
    Disconnected {
        /// Number of these components.
        components: usize,
    },
}

impl Outcome {
    /// Returns the name of the outcome: one lower-case word.
    pub fn name(self) -> &'static str {
        match self {
            Self::Closed => "closed",
            Self::Open => "open",
            Self::Blocked { .. } => "blocked",
            Self::CloseBlocked => "close-blocked",
            Self::Disconnected { .. } => "disconnected",
        }
    }

    /// Returns whether the curves are complete: closed, or open where that was requested.
    pub fn is_complete(self) -> bool {
        matches!(self, Self::Closed | Self::Open)
    }
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Blocked { at, remaining } => {
                write!(f, "blocked at sample {at}, {remaining} samples not reached")
            }
            Self::Disconnected { components } => {
                write!(f, "samples on {components} components of the mesh")
            }
            Self::Closed | Self::Open | Self::CloseBlocked => f.write_str(self.name()),
        }
    }
}

/// A point of a curve on the mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Waypoint {
    /// At a vertex.
    Vertex(u32),
    /// On an edge.
    Edge {
        /// The ends of the edge.
        ends: [u32; 2],
        /// Position from the first end to the second, from 0 to 1.
        share: f64,
    },
}

/// A curve along edges, either complete or the part that was found.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// Indices of the samples, in the order of the curve.
    pub order: Vec<u32>,
    /// The vertices of the curve; the first one is not repeated in a closed curve. Indices from the
    /// number of vertices of the mesh on are those of the [`Reconstruction::steiner`] points.
    pub path: Vec<u32>,
    /// Positions of the vertices; for a smooth curve, also its crossings of edges.
    pub points: Vec<[f64; 3]>,
    /// The points as waypoints on the mesh with the [`Reconstruction::steiner`] points. Successive
    /// waypoints are joined by straight lines on faces, or edges.
    pub waypoints: Vec<Waypoint>,
    /// Whether an edge leads from the last vertex to the first.
    pub closed: bool,
    /// The length of the curve.
    pub length: f64,
}

/// The result of [`CurveSolver::reconstruct`](super::CurveSolver::reconstruct).
#[derive(Debug, Clone, PartialEq)]
pub struct Reconstruction {
    /// How the reconstruction ended.
    pub outcome: Outcome,
    /// The curves, or the parts that were found, in the order of their lowest samples.
    pub curves: Vec<Curve>,
    /// The edges in whose middle vertices were inserted: their ends are vertices of the mesh or
    /// earlier Steiner points, whose indices follow those of the mesh in this order. Some of the
    /// points may be on no curve.
    pub steiner: Vec<[u32; 2]>,
    /// Indices, ascending, of the samples that are on no curve because their component of the mesh
    /// has fewer than three samples. Empty unless several curves are allowed, or
    /// [outliers are dropped](super::CurveOptions::drop_outliers). All other samples are on curves,
    /// or the outcome says why not.
    pub left_out: Vec<u32>,
    /// Indices, ascending, of the samples that were dropped as outliers.
    pub outliers: Vec<u32>,
}

impl Reconstruction {
    /// Creates the result of a search that found no curve.
    pub(super) fn without_curves(outcome: Outcome) -> Self {
        let (curves, steiner, left_out, outliers) = (vec![], vec![], vec![], vec![]);
        Self { outcome, curves, steiner, left_out, outliers }
    }

    /// Replaces each index of a sample by its entry in `numbers`, which ascend.
    pub(super) fn renumber(&mut self, numbers: &[u32]) {
        let number = |i: &mut u32| *i = numbers[*i as usize];
        if let Outcome::Blocked { at, .. } = &mut self.outcome {
            number(at);
        }
        self.curves.iter_mut().flat_map(|curve| &mut curve.order).for_each(number);
        self.left_out.iter_mut().for_each(number);
    }

    /// Returns the sum of the lengths of the curves.
    pub fn length(&self) -> f64 {
        total(self.curves.iter().map(|curve| curve.length))
    }
}

/// Returns the sum of lengths; 0 for an empty sum, where the standard library returns -0.
pub(super) fn total(lengths: impl Iterator<Item = f64>) -> f64 {
    lengths.fold(0.0, |sum, length| sum + length)
}

/// Returns whether two orders of the same samples are the same cycle: equal up to the start and the
/// direction.
///
/// ```
/// use catamaran_geometry::curve::same_order;
///
/// assert!(same_order(&[2, 1, 0, 3], &[0, 1, 2, 3]));
/// assert!(!same_order(&[0, 2, 1, 3], &[0, 1, 2, 3]));
/// ```
pub fn same_order(order: &[u32], truth: &[u32]) -> bool {
    let n = order.len();
    if n != truth.len() {
        return false;
    }
    let Some(start) = truth.iter().position(|&i| Some(&i) == order.first()) else {
        return n == 0;
    };
    let ahead = (0..n).all(|i| order[i] == truth[(start + i) % n]);
    ahead || (0..n).all(|i| order[i] == truth[(start + n - i) % n])
}
