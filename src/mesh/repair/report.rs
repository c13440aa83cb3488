use std::fmt;

/// What one step of [`repair`](super::repair()) did.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum RepairStep {
    /// Vertices became one.
    Welded {
        /// The distance, in units of length; 0: equal positions.
        tolerance: f64,
        /// How many joined another one.
        vertices: usize,
        /// How many faces lost a corner by that, and are left out.
        faces: usize,
        /// How many of the vertices had another colour than the one they joined.
        colors: usize,
    },
    /// Seams are closed ([`Weld::Seams`](super::Weld)).
    ClosedSeams {
        /// How many vertices joined another one.
        vertices: usize,
        /// How many of the vertices had another colour than the one they joined.
        colors: usize,
        /// Boundary edges that stay, as more than two are in one place.
        ambiguous: usize,
    },
    /// Repeated faces are left out.
    DroppedDuplicates {
        /// How many.
        faces: usize,
        /// The first, and the face whose vertices it has.
        first: Option<[u32; 2]>,
    },
    /// Faces without area are gone.
    DroppedDegenerate {
        /// Vertices that joined another one in the same place.
        joined: usize,
        /// Edges that were flipped.
        flipped: usize,
        /// Faces that were left out.
        faces: usize,
        /// The first face without area.
        first: Option<u32>,
    },
    /// Vertices without a face are left out.
    Compacted {
        /// How many.
        vertices: usize,
    },
    /// The mesh was cut where it was not a manifold.
    Cut {
        /// Edges of more than two faces.
        edges: usize,
        /// Vertices that are several now.
        vertices: usize,
    },
    /// Components are left out.
    KeptLargest {
        /// How many.
        components: usize,
        /// Their faces.
        faces: usize,
    },
    /// Small components are left out.
    DroppedSpecks {
        /// The share of the area of the mesh that each of them is below.
        share: f64,
        /// How many.
        components: usize,
        /// Their faces.
        faces: usize,
    },
    /// Holes are filled.
    FilledHoles {
        /// How many.
        holes: usize,
        /// New faces.
        faces: usize,
        /// Boundary loops that stay, because they are longer or can't be filled.
        left: usize,
    },
    /// Faces were flipped.
    Oriented {
        /// How many.
        faces: usize,
        /// Parts of the surface that are not orientable, and stay as they were.
        not_orientable: usize,
        /// The lowest edge, by its ends, over which the first of these does not agree.
        edge: Option<[u32; 2]>,
    },
}

impl RepairStep {
    /// Returns whether the step changed the mesh.
    pub fn changed(&self) -> bool {
        match *self {
            Self::Welded { vertices, .. }
            | Self::ClosedSeams { vertices, .. }
            | Self::Compacted { vertices } => vertices > 0,
            Self::DroppedDuplicates { faces, .. } => faces > 0,
            Self::DroppedDegenerate { joined, flipped, faces, .. } => joined + flipped + faces > 0,
            Self::Cut { edges, vertices } => edges + vertices > 0,
            Self::KeptLargest { components, .. } | Self::DroppedSpecks { components, .. } => {
                components > 0
            }
            Self::FilledHoles { holes, .. } => holes > 0,
            Self::Oriented { faces, .. } => faces > 0,
        }
    }
}

impl fmt::Display for RepairStep {
    /// A line without an end: the name of the step, padded to 12 characters, and its counts.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Welded { tolerance, vertices, faces, colors } => {
                write!(f, "weld        {vertices} vertices joined")?;
                match tolerance > 0.0 {
                    true => write!(f, " (at most {tolerance} apart)")?,
                    false => write!(f, " (equal positions)")?,
                }
                if faces > 0 {
                    write!(f, ", {faces} faces collapsed")?;
                }
                lost(f, colors)
            }
            Self::ClosedSeams { vertices, colors, ambiguous } => {
                write!(f, "weld        {vertices} vertices joined along seams")?;
                if ambiguous > 0 {
                    write!(f, ", {ambiguous} boundary edges stay, three or more in one place")?;
                }
                lost(f, colors)
            }
            Self::DroppedDuplicates { faces, .. } => {
                write!(f, "duplicates  {faces} repeated faces dropped")
            }
            Self::DroppedDegenerate { joined, flipped, faces, .. } => write!(
                f,
                "degenerate  faces without area: {joined} vertices joined with one in the same \
                 place, {flipped} edges flipped, {faces} faces dropped"
            ),
            Self::Compacted { vertices } => {
                write!(f, "compact     {vertices} vertices without a face dropped")
            }
            Self::Cut { edges, vertices } => write!(
                f,
                "cut         {edges} edges of more than two faces, {vertices} vertices split"
            ),
            Self::KeptLargest { components, faces } => {
                write!(f, "largest     {components} components of {faces} faces dropped")
            }
            Self::DroppedSpecks { share, components, faces } => write!(
                f,
                "specks      {components} components of {faces} faces dropped, each below {share} of \
                 the area"
            ),
            Self::FilledHoles { holes, faces, left } => {
                write!(f, "holes       {holes} filled by {faces} faces, {left} loops left")
            }
            Self::Oriented { faces, not_orientable, .. } => {
                write!(f, "orient      {faces} faces flipped")?;
                match not_orientable {
                    0 => Ok(()),
                    _ => write!(f, ", {not_orientable} parts are not orientable"),
                }
            }
        }
    }
}

fn lost(f: &mut fmt::Formatter<'_>, colors: usize) -> fmt::Result {
    match colors {
        0 => Ok(()),
        _ => write!(f, ", {colors} colours lost (the first of each place stays)"),
    }
}

/// What [`repair`](super::repair()) did.
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub struct RepairReport {
    /// The steps, in the order in which they were done.
    pub steps: Vec<RepairStep>,
}

impl RepairReport {
    /// Returns whether any step changed the mesh.
    pub fn changed(&self) -> bool {
        self.steps.iter().any(RepairStep::changed)
    }
}

impl fmt::Display for RepairReport {
    /// A line for each step, the last one without an end.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, step) in self.steps.iter().enumerate() {
            let end = if i == 0 { "" } else { "\n" };
            write!(f, "{end}{step}")?;
        }
        Ok(())
    }
}
