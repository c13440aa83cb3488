//! Writes the files of commands.

use std::path::Path;

use anyhow::{Result, bail};
use catamaran::io::{Output, check_arrays_name};
use catamaran::mesh::io::{self as meshes, MeshFile, MeshFormat};

use crate::common::Force;
use crate::report;

/// Writes a mesh, and prints a note about attributes that the format can't store.
pub fn mesh(output: Output, file: &MeshFile) -> catamaran::Result<()> {
    let path = output.path().to_owned();
    let left_out = MeshFormat::of(&path)?.left_out(file);
    meshes::write(output, file)?;
    if !left_out.is_empty() {
        let what = left_out.join(", ");
        report::note(format_args!("{}: this format can't store {what}", path.display()));
    }
    Ok(())
}

/// Starts a table of comma-separated values with a line of titles.
pub fn csv(path: &Path, force: Force) -> Result<Output> {
    if path.extension().is_none_or(|extension| !extension.eq_ignore_ascii_case("csv")) {
        bail!("{}: the name must end in .csv", path.display());
    }
    force.create(path)
}

/// Starts a file of several arrays, whose name selects the format.
pub fn arrays(path: &Path, force: Force) -> Result<Output> {
    check_arrays_name(path)?;
    force.create(path)
}
