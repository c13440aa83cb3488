use std::fmt;

/// The result of one step of [`repair`](super::repair()).
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum RepairStep {
    /// Vertices were joined.
    Welded {
        /// The distance, in units of length; 0 for equal positions.
        tolerance: f64,
        /// Number of vertices that joined another one.
        vertices: usize,
        /// Number of faces that lost a corner thereby, and are left out.
        faces: usize,
        /// Number of vertices that joined a vertex of another colour.
        colors: usize,
    },
    /// Seams were closed ([`Weld::Seams`](super::Weld)).
    ClosedSeams {
        /// Number of vertices that joined another one.
        vertices: usize,
        /// Number of vertices that joined a vertex of another colour.
        colors: usize,
        /// Number of boundary edges that stay, because more than two coincide.
        ambiguous: usize,
    },
    /// Repeated faces were left out.
    DroppedDuplicates {
        /// Number of faces.
        faces: usize,
        /// The first repeated face, and the face whose vertices it has.
        first: Option<[u32; 2]>,
    },
    /// Faces without area were removed.
    DroppedDegenerate {
        /// Number of vertices that joined another one in the same place.
        joined: usize,
        /// Number of edges that were flipped.
        flipped: usize,
        /// Number of faces that were left out.
        faces: usize,
        /// The first face without area.
        first: Option<u32>,
    },
    /// Vertices without a face were left out.
    Compacted {
        /// Number of vertices.
        vertices: usize,
    },
    /// The mesh was cut where it was not a manifold.
    Cut {
        /// Number of edges of more than two faces.
        edges: usize,
        /// Number of vertices that were split.
        vertices: usize,
    },
    /// Components were left out; those with the most faces stay.
    KeptLargest {
        /// Number of components left out.
        components: usize,
        /// Number of their faces.
        faces: usize,
    },
    /// Small components were left out.
    DroppedSpecks {
        /// The share of the area of the mesh below which a component is left out.
        share: f64,
        /// Number of components left out.
        components: usize,
        /// Number of their faces.
        faces: usize,
    },
    /// Holes were filled.
    FilledHoles {
        /// Number of holes.
        holes: usize,
        /// Number of new faces.
        faces: usize,
        /// Number of boundary loops that stay, because they are longer or can't be filled.
        left: usize,
    },
    /// Faces were flipped.
    Oriented {
        /// Number of faces.
        faces: usize,
        /// Number of parts of the surface that are not orientable, and stay as they were.
        not_orientable: usize,
        /// The lowest edge, by its ends, whose faces disagree in the first of these parts.
        edge: Option<[u32; 2]>,
    },
}

impl RepairStep {
    /// Returns the name of the option of [`RepairOptions`](super::RepairOptions) that selects the
    /// step.
    pub fn option(&self) -> &'static str {
        match self {
            Self::Welded { .. } | Self::ClosedSeams { .. } => "weld",
            Self::DroppedDuplicates { .. } => "drop_duplicates",
            Self::DroppedDegenerate { .. } => "drop_degenerate",
            Self::Compacted { .. } => "compact",
            Self::Cut { .. } => "cut",
            Self::KeptLargest { .. } => "keep_largest",
            Self::DroppedSpecks { .. } => "drop_specks",
            Self::FilledHoles { .. } => "fill_holes",
            Self::Oriented { .. } => "orient",
        }
    }

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
    /// Writes a line without a newline: the name of the step, padded to 12 characters, and its
    /// counts.
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

/// The results of the steps of [`repair`](super::repair()).
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub struct RepairReport {
    /// The steps, in the order of their execution.
    pub steps: Vec<RepairStep>,
}

impl RepairReport {
    /// Returns whether any step changed the mesh.
    pub fn changed(&self) -> bool {
        self.steps.iter().any(RepairStep::changed)
    }
}

impl fmt::Display for RepairReport {
    /// Writes a line for each step, without a newline at the end.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, step) in self.steps.iter().enumerate() {
            let end = if i == 0 { "" } else { "\n" };
            write!(f, "{end}{step}")?;
        }
        Ok(())
    }
}
