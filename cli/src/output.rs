//! Writes the files of commands.

use std::path::Path;

use anyhow::{Result, bail};
use catamaran::Error;
use catamaran::io::{Output, Overwrite, check_arrays_name};
use catamaran_geometry::mesh::io::{self as meshes, Material, MeshFile, MeshFormat};

use crate::common::Force;
use crate::report;

/// Returns the help of an option that names a mesh to be written.
pub fn mesh_help(what: &str) -> String {
    format!("{what}: {}, and .gz after it", MeshFormat::writable())
}

/// Refuses a file that can't be written, before the long work whose result it will be.
pub fn probe(path: &Path) -> catamaran::Result<()> {
    Output::create(path, Overwrite::Replace).map(drop)
}

/// Writes a mesh, and prints notes about what the format can't store or rounds.
pub fn mesh(output: Output, file: &MeshFile) -> catamaran::Result<()> {
    let format = MeshFormat::of(output.path())?;
    mesh_as(output, file, format)
}

/// Writes a mesh as [`mesh`] does, in a format. A mesh without vertices is an error.
pub fn mesh_as(output: Output, file: &MeshFile, format: MeshFormat) -> catamaran::Result<()> {
    let path = output.path().to_owned();
    if file.mesh.vertices().is_empty() {
        return Err(Error::file(path, "not written: the mesh has no vertices"));
    }
    notes(&path, &meshes::write_as(output, file, format)?);
    Ok(())
}

/// Writes a mesh with a material, and prints notes as [`mesh`] does.
pub fn mesh_with_material(
    output: Output,
    file: &MeshFile,
    material: &Material,
) -> catamaran::Result<()> {
    let path = output.path().to_owned();
    notes(&path, &meshes::write_with_material(output, file, material)?);
    Ok(())
}

fn notes(path: &Path, lines: &[String]) {
    for line in lines {
        report::note(format_args!("{}: {line}", path.display()));
    }
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
