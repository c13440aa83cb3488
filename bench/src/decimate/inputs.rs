//! The meshes that are decimated.

use std::path::{Path, PathBuf};

use catamaran::io::{Output, Overwrite};
use catamaran::mesh::io::MeshFile;
use catamaran::mesh::{Edges, Normalization, RepairOptions, TriMesh, repair};

use crate::Result;

/// A repaired mesh of longest side 1, so that distances compare, and the file of it that contenders
/// read.
pub struct Input {
    /// Its name.
    pub name: String,
    /// The mesh.
    pub mesh: TriMesh,
    /// A PLY file.
    pub path: PathBuf,
}

impl Input {
    /// The faces of a closed mesh of `n` vertices that has the Euler characteristic of this one.
    pub fn faces_for(&self, n: usize) -> usize {
        let vertices = n as i64 - self.mesh.euler_characteristic(&Edges::new(&self.mesh));
        2 * vertices.max(0) as usize
    }
}

/// Meshes as PLY files, in a folder that goes away with this.
pub struct Inputs {
    data: Option<PathBuf>,
    scratch: tempfile::TempDir,
}

impl Inputs {
    /// Real ones are those of CATAMARAN_DATA (default ../shared).
    ///
    /// # Errors
    /// When there can't be a temporary folder.
    pub fn new() -> Result<Self> {
        let data = crate::input::data_folder();
        let folder = data.join("meshes");
        Ok(Self { data: folder.is_dir().then_some(folder), scratch: tempfile::tempdir()? })
    }

    /// Where contenders may write.
    pub fn scratch(&self) -> &Path {
        self.scratch.path()
    }

    /// The file names of all real meshes, sorted.
    pub fn names(&self) -> Vec<String> {
        let entries = self
            .data
            .iter()
            .filter_map(|folder| std::fs::read_dir(folder).ok())
            .flatten()
            .flatten();
        let names = entries.map(|entry| entry.file_name().to_string_lossy().into_owned());
        let mut names: Vec<_> = names.filter(|name| !name.ends_with(".tsv")).collect();
        names.sort();
        names
    }

    /// A real mesh; `None` without data.
    ///
    /// # Errors
    /// When it can't be read.
    pub fn real(&self, file: &str) -> Result<Option<Input>> {
        let Some(folder) = &self.data else { return Ok(None) };
        let path = folder.join(file);
        if !path.exists() {
            return Ok(None);
        }
        let name = file.split('.').next().unwrap_or(file);
        self.of(name, catamaran::mesh::io::read(&path)?).map(Some)
    }

    /// This mesh, its longest side 1, with the repairs that `catamaran decimate` does by itself, so
    /// that every contender starts from the same surface. Vertices that no face has are left out:
    /// some contenders would keep them.
    ///
    /// # Errors
    /// When it can't be repaired, or its file not be written.
    pub fn of(&self, name: &str, mesh: impl Into<MeshFile>) -> Result<Input> {
        let options = RepairOptions::unambiguous().compact(true);
        let mesh = repair(mesh.into(), &options)?.file.mesh.normalized(Normalization::UnitBox)?;
        let path = self.scratch.path().join(format!("{name}.ply"));
        write(&path, &mesh, Overwrite::Replace)?;
        Ok(Input { name: name.into(), mesh, path })
    }
}

/// Writes a PLY file.
///
/// # Errors
/// When it can't be written.
pub fn write(path: &Path, mesh: &TriMesh, overwrite: Overwrite) -> Result<()> {
    let output = Output::create(path, overwrite)?;
    Ok(catamaran::mesh::io::write(output, &MeshFile::from(mesh.clone()))?)
}
