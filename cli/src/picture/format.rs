//! The formats of pictures, which the names of their files select.

use std::path::Path;

use anyhow::{Result, bail};
use catamaran::io::Output;

use crate::common::Force;

/// A format of pictures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Pixels.
    Png,
    /// Lines and letters of charts; other pictures are pixels in it.
    Svg,
}

impl Format {
    /// Returns the format that the name of a file selects, if there is one.
    pub fn of(path: &Path) -> Option<Self> {
        let extension = path.extension()?;
        let is = |ending: &str| extension.eq_ignore_ascii_case(ending);
        match () {
            () if is("png") => Some(Self::Png),
            () if is("svg") => Some(Self::Svg),
            () => None,
        }
    }
}

/// Starts the file of a picture.
///
/// # Errors
/// Its name selects no format; those of [`Force::create`].
pub fn create(path: &Path, force: Force) -> Result<Output> {
    if Format::of(path).is_none() {
        bail!("{}: the name of a picture must end in .png or .svg", path.display());
    }
    force.create(path)
}
