//! The input meshes of decimation.

use std::path::{Path, PathBuf};

use catamaran::io::{Output, Overwrite};
use catamaran_geometry::mesh::io::MeshFile;
use catamaran_geometry::mesh::{Edges, Normalization, RepairOptions, TriMesh, repair};

use crate::Result;

/// A repaired mesh of longest side 1, so that distances are comparable, and its file for the
/// contenders.
pub struct Input {
    /// Its name.
    pub name: String,
    /// The mesh.
    pub mesh: TriMesh,
    /// Its PLY file.
    pub path: PathBuf,
}

impl Input {
    /// Returns the number of faces of a closed mesh of `n` vertices with the same Euler
    /// characteristic.
    pub fn faces_for(&self, n: usize) -> usize {
        let vertices = n as i64 - self.mesh.euler_characteristic(&Edges::new(&self.mesh));
        2 * vertices.max(0) as usize
    }
}

/// Input meshes as PLY files, in a temporary folder.
pub struct Inputs {
    data: Option<PathBuf>,
    scratch: tempfile::TempDir,
}

impl Inputs {
    /// Creates the temporary folder. Real meshes are those of CATAMARAN_DATA (default ../shared).
    ///
    /// # Errors
    /// When the temporary folder can't be created.
    pub fn new() -> Result<Self> {
        let data = crate::input::data_folder();
        let folder = data.join("meshes");
        Ok(Self { data: folder.is_dir().then_some(folder), scratch: tempfile::tempdir()? })
    }

    /// Returns the folder in which contenders may write.
    pub fn scratch(&self) -> &Path {
        self.scratch.path()
    }

    /// Returns the file names of all real meshes, sorted.
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

    /// Returns a real mesh; `None` without data.
    ///
    /// # Errors
    /// When the mesh can't be read.
    pub fn real(&self, file: &str) -> Result<Option<Input>> {
        let Some(folder) = &self.data else { return Ok(None) };
        let path = folder.join(file);
        if !path.exists() {
            return Ok(None);
        }
        let name = file.split('.').next().unwrap_or(file);
        self.of(name, catamaran_geometry::mesh::io::read(&path)?).map(Some)
    }

    /// Returns this mesh with longest side 1, and with the repairs that `catamaran decimate` makes
    /// by default, so that every contender starts from the same surface. Vertices without a face
    /// are left out, because some contenders would keep them.
    ///
    /// # Errors
    /// When the mesh can't be repaired, or its file can't be written.
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
/// When the file can't be written.
pub fn write(path: &Path, mesh: &TriMesh, overwrite: Overwrite) -> Result<()> {
    let output = Output::create(path, overwrite)?;
    catamaran_geometry::mesh::io::write(output, &MeshFile::from(mesh.clone()))?;
    Ok(())
}
