use std::fmt;

/// The outcome of a reconstruction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Outcome {
    /// Closed curves through all samples but those [left out](Reconstruction::left_out), which meet
    /// neither each other nor themselves.
    Closed,
    /// Curves from one end to another, as requested.
    Open,
    /// No path leads from one of the samples to another one that is left.
    Blocked {
        /// The number of that sample in the list of samples.
        at: u32,
        /// Samples that the curve has not reached.
        remaining: usize,
    },
    /// All samples are connected, but no path leads back to the first one.
    CloseBlocked,
    /// Samples are on different components of the mesh, and no curve through all of them is there;
    /// or none of the components has three samples.
    Disconnected {
        /// The number of these components.
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
        /// Its ends.
        ends: [u32; 2],
        /// How far from the first end to the second, from 0 to 1.
        share: f64,
    },
}

/// A curve along edges, complete or the part of it that was found.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// Numbers of samples in the list of samples, in the order of the curve.
    pub order: Vec<u32>,
    /// Its vertices, one after the other; the first one is not repeated where it closes. Those from
    /// the mesh's number of vertices on are the [`Reconstruction::steiner`] points, in their order.
    pub path: Vec<u32>,
    /// Positions of the vertices; of a smooth curve also where it crosses edges.
    pub points: Vec<[f64; 3]>,
    /// Where the points are, on the mesh with the [`Reconstruction::steiner`] points. Straight
    /// lines on faces, or edges, join one to the next.
    pub waypoints: Vec<Waypoint>,
    /// Whether an edge leads from the last vertex to the first.
    pub closed: bool,
    /// Sum of the lengths of the edges.
    pub length: f64,
}

/// A vertex that was put into the middle of an edge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Steiner {
    /// Ends of the edge: vertices of the mesh, or earlier Steiner points, numbered from the mesh's
    /// number of vertices on.
    pub ends: [u32; 2],
    /// Where it is.
    pub position: [f64; 3],
}

/// The result of [`CurveSolver::reconstruct`](super::CurveSolver::reconstruct).
#[derive(Debug, Clone, PartialEq)]
pub struct Reconstruction {
    /// How it ended.
    pub outcome: Outcome,
    /// The curves, or what there is of them; in the order of their lowest samples.
    pub curves: Vec<Curve>,
    /// Points in the middle of edges that were needed, in the order of their numbers; not all of
    /// them need be on a curve.
    pub steiner: Vec<Steiner>,
    /// Numbers of samples, ascending, that no curve is through, because their components of the
    /// mesh have fewer than three samples each. Only where there may be several curves; all other
    /// samples are on curves, or the outcome says why not.
    pub left_out: Vec<u32>,
}

impl Reconstruction {
    /// Returns the sum of the curves' lengths.
    pub fn length(&self) -> f64 {
        total(self.curves.iter().map(|curve| curve.length))
    }
}

/// Returns the sum of lengths; for no lengths 0, where the sum of the standard library is -0.
pub(super) fn total(lengths: impl Iterator<Item = f64>) -> f64 {
    lengths.fold(0.0, |sum, length| sum + length)
}
