//! Files that commands write.

use catamaran::io::Output;
use catamaran::mesh::io::{self as meshes, MeshFile, MeshFormat};

use crate::report;

/// Writes a mesh, and names on stderr what the format of its name has no place for.
pub fn mesh(output: Output, file: &MeshFile) -> catamaran::Result<()> {
    let path = output.path().to_owned();
    let left_out = MeshFormat::of(&path)?.left_out(file);
    meshes::write(output, file)?;
    if !left_out.is_empty() {
        let what = left_out.join(", ");
        report::note(format_args!("{}: no place in this format for {what}", path.display()));
    }
    Ok(())
}
