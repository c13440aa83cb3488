//! An error of which another process speaks, or has spoken.

use std::fmt;

/// The error of a process that ends without a word: another process says why, or this one has said
/// it already.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Said {
    /// The exit status of this process.
    pub status: u8,
}

impl fmt::Display for Said {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("another process has failed")
    }
}

impl std::error::Error for Said {}
