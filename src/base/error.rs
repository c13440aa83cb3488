use std::error::Error as StdError;
use std::fmt;
use std::io;
use std::path::PathBuf;
use std::sync::Arc;

use super::byte_size::byte_size;

/// The result of every fallible function of this crate.
pub type Result<T> = std::result::Result<T, Error>;

/// Everything that can fail, with the argument, file or rank at fault.
///
/// A message is complete: it includes the message of [`source`](StdError::source). A panic inside
/// this crate is a bug in this crate.
///
/// ```
/// use std::error::Error as _;
/// use catamaran::{Error, ata_into, AtaOptions, faer::Mat};
///
/// let (a, mut c) = (Mat::<f64>::zeros(5, 3), Mat::zeros(4, 4));
/// let error = ata_into(1.0, a.as_ref(), 0.0, c.as_mut(), &AtaOptions::default()).unwrap_err();
/// assert!(matches!(error, Error::Shape { expected: (3, 3), got: (4, 4), .. }));
/// assert!(error.source().is_none());
/// ```
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
        /// Residual reached; not finite where none was, as when eigenvalues are missing between
        /// those that converged.
        residual: f64,
    },
    /// A file could not be read or written.
    Io {
        /// The file.
        path: PathBuf,
        /// The line at fault, from 1.
        line: Option<usize>,
        /// What is wrong with it.
        what: String,
        /// The error of the operating system, if there is one.
        cause: Option<Cause>,
    },
    /// Memory for a result or a workspace could not be allocated.
    OutOfMemory {
        /// The size of the request.
        bytes: usize,
    },
    /// A triangle mesh or a plant is invalid, or not of the required kind.
    Mesh {
        /// What is wrong.
        what: String,
        /// The vertex, node, edge or face at fault, as in "face 12".
        element: String,
    },
    /// A BLAS back end could not be loaded, or it refused the request.
    Backend {
        /// The library.
        name: String,
        /// Why it failed.
        why: String,
        /// The error of the loader, if there is one.
        cause: Option<Cause>,
    },
    /// A rank of a distributed call failed, or its arguments disagree with those of other ranks.
    Rank {
        /// The rank at fault, from 0.
        rank: usize,
        /// Its error message, or what is wrong with its arguments.
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
                write!(f, "not converged after {iterations} iterations")?;
                if residual.is_finite() {
                    write!(f, ", residual {residual:e}")?;
                }
                Ok(())
            }
            Self::Io { path, line: None, what, .. } => write!(f, "{}: {what}", path.display()),
            Self::Io { path, line: Some(line), what, .. } => {
                write!(f, "{}:{line}: {what}", path.display())
            }
            Self::OutOfMemory { bytes } => {
                write!(f, "out of memory: {} requested", byte_size(*bytes as f64))
            }
            Self::Mesh { what, element } => write!(f, "{element}: {what}"),
            Self::Backend { name, why, .. } => write!(f, "back end {name}: {why}"),
            Self::Rank { rank, why } => write!(f, "rank {rank}: {why}"),
            Self::Cancelled => write!(f, "cancelled"),
        }
    }
}

impl StdError for Error {
    fn source(&self) -> Option<&(dyn StdError + 'static)> {
        match self {
            Self::Io { cause: Some(cause), .. } | Self::Backend { cause: Some(cause), .. } => {
                Some(&*cause.0)
            }
            _ => None,
        }
    }
}

/// The error of the operating system or of a library that led to an [`Error`].
///
/// It is shared, so that an [`Error`] can be cloned, and equal to another one when their messages
/// are.
///
/// ```
/// use std::{error::Error as _, io, path::Path};
/// use catamaran::Error;
///
/// let error = Error::io(Path::new("a.npy"), io::ErrorKind::PermissionDenied.into());
/// let cause = error.source().and_then(|e| e.downcast_ref::<io::Error>()).unwrap();
/// assert_eq!(cause.kind(), io::ErrorKind::PermissionDenied);
/// assert_eq!(error.to_string(), format!("a.npy: {cause}"));
/// ```
#[derive(Debug, Clone)]
pub struct Cause(Arc<dyn StdError + Send + Sync>);

impl<E: StdError + Send + Sync + 'static> From<E> for Cause {
    fn from(error: E) -> Self {
        Self(Arc::new(error))
    }
}

impl PartialEq for Cause {
    fn eq(&self, other: &Self) -> bool {
        self.0.to_string() == other.0.to_string()
    }
}

impl Error {
    /// Creates an [`Error::Io`] that concerns a file as a whole.
    ///
    /// ```
    /// use catamaran::Error;
    ///
    /// assert_eq!(Error::file("a.npy", "is empty").to_string(), "a.npy: is empty");
    /// ```
    pub fn file(path: impl Into<PathBuf>, what: impl Into<String>) -> Self {
        Self::Io { path: path.into(), line: None, what: what.into(), cause: None }
    }

    /// Creates an [`Error::Io`] from an error of the operating system, which becomes its source. A
    /// file that is missing is named as in the errors of readers: "no such file".
    pub fn io(path: impl Into<PathBuf>, e: io::Error) -> Self {
        let what = match e.kind() {
            io::ErrorKind::NotFound => "no such file".into(),
            _ => e.to_string(),
        };
        Self::Io { path: path.into(), line: None, what, cause: Some(e.into()) }
    }

    /// Returns [`Error::Shape`] unless `got == expected`.
    #[doc(hidden)]
    pub fn check_shape(
        what: &'static str,
        expected: (usize, usize),
        got: (usize, usize),
    ) -> Result<()> {
        if expected == got { Ok(()) } else { Err(Self::Shape { what, expected, got }) }
    }
}
