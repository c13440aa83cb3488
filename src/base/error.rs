use std::fmt;
use std::path::PathBuf;

/// The result of every fallible function of this crate.
pub type Result<T> = std::result::Result<T, Error>;

/// What a caller can get wrong, or the world can refuse; every variant names the culprit.
///
/// A panic out of this crate is a bug of this crate.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Error {
    /// A matrix, vector or buffer has the wrong shape (rows x columns; vectors are n x 1).
    Shape {
        /// The argument at fault.
        what: &'static str,
        /// Its required rows and columns.
        expected: (usize, usize),
        /// Its actual rows and columns.
        got: (usize, usize),
    },
    /// An argument is outside its range.
    Argument {
        /// The argument at fault.
        what: &'static str,
        /// The range it must lie in, and what it was.
        why: String,
    },
    /// A NaN or an infinity where only finite numbers are allowed.
    NonFinite {
        /// The argument at fault.
        what: &'static str,
        /// Its first offending entry (row, column), from 0.
        index: (usize, usize),
    },
    /// An iteration ended before it reached its tolerance.
    NotConverged {
        /// Iterations done.
        iterations: usize,
        /// Residual reached.
        residual: f64,
    },
    /// A file could not be read or written.
    Io {
        /// The file.
        path: PathBuf,
        /// The line at fault, from 1; 0 when no line is to blame.
        line: usize,
        /// What is wrong with it.
        what: String,
    },
    /// Memory for a result or a workspace could not be had.
    OutOfMemory {
        /// The size of the request.
        bytes: usize,
    },
    /// A triangle mesh or a plant is not one, or not of the kind that is asked for.
    Mesh {
        /// What is wrong.
        what: String,
        /// The vertex, node, edge or face at fault, as in "face 12".
        element: String,
    },
    /// A BLAS back end could not be loaded, or refused.
    Backend {
        /// The library.
        name: String,
        /// What it said.
        why: String,
    },
    /// Another rank of a distributed call failed, or does not fit the others.
    Rank {
        /// The rank at fault, from 0.
        rank: usize,
        /// What it said, or what is wrong with it.
        why: String,
    },
    /// The progress callback asked to stop. Outputs hold unspecified values.
    Cancelled,
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Shape { what, expected, got } => write!(
                f,
                "{what}: expected {} x {}, got {} x {}",
                expected.0, expected.1, got.0, got.1
            ),
            Self::Argument { what, why } => write!(f, "{what}: {why}"),
            Self::NonFinite { what, index } => {
                write!(f, "{what}: not finite at row {}, column {}", index.0, index.1)
            }
            Self::NotConverged { iterations, residual } => {
                write!(f, "not converged after {iterations} iterations, residual {residual:e}")
            }
            Self::Io { path, line: 0, what } => write!(f, "{}: {what}", path.display()),
            Self::Io { path, line, what } => write!(f, "{}:{line}: {what}", path.display()),
            Self::OutOfMemory { bytes } => write!(f, "out of memory: {bytes} bytes requested"),
            Self::Mesh { what, element } => write!(f, "{element}: {what}"),
            Self::Backend { name, why } => write!(f, "back end {name}: {why}"),
            Self::Rank { rank, why } => write!(f, "rank {rank}: {why}"),
            Self::Cancelled => write!(f, "cancelled"),
        }
    }
}

impl std::error::Error for Error {}

impl Error {
    /// `Ok` when `got == expected`, else [`Error::Shape`].
    pub(crate) fn check_shape(
        what: &'static str,
        expected: (usize, usize),
        got: (usize, usize),
    ) -> Result<()> {
        if expected == got { Ok(()) } else { Err(Self::Shape { what, expected, got }) }
    }
}
