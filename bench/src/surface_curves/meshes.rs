use catamaran_geometry::curve::dataset::scaled;
use catamaran_geometry::mesh::{Components, TriMesh, families, io};

use crate::Result;

/// A mesh for generated curves, of volume 1.
pub struct Surface {
    /// Its name.
    pub name: &'static str,
    /// The mesh.
    pub mesh: TriMesh,
    /// Whether it is connected and without boundary.
    pub closed: bool,
}

/// The source of a mesh.
enum Source {
    Made(fn() -> catamaran::Result<TriMesh>),
    File(&'static str),
}

use Source::{File, Made};

/// Three generated meshes, and seven of CATAMARAN_DATA: models, slivers, boundary, a million
/// vertices.
const ALL: [(&str, Source); 10] = [
    ("torus", Made(|| families::torus(240, 100, 2.0, 0.8))),
    ("knot", Made(|| families::knot(2, 3, 600, 60, 0.3))),
    ("genus 3", Made(|| families::genus(3, 18))),
    ("cheese", File("cheese_genus133.off.gz")),
    ("bunny", File("ofp_bunny10k.off.gz")),
    ("lion", File("lionstatue32k.obj.gz")),
    ("nefertiti", File("nefertiti35k.obj.gz")),
    ("armadillo", File("armadillo43k.obj.gz")),
    ("elephant", File("refined_elephant44k.off.gz")),
    ("white matter", File("mni152_wm1p24M.ply.xz")),
];

/// Returns the meshes, or those with these names; each is read when its turn comes. Without data,
/// only generated ones.
///
/// # Errors
/// For a name that no mesh has. The iterator returns an error for a file that can't be read.
pub fn surfaces(names: &[String]) -> Result<impl Iterator<Item = Result<Surface>>> {
    if let Some(name) = names.iter().find(|name| ALL.iter().all(|(known, _)| known != name)) {
        let known: Vec<_> = ALL.iter().map(|(known, _)| *known).collect();
        return Err(format!("{name}: no such mesh, must be one of {}", known.join(", ")).into());
    }
    let data = crate::input::data_folder();
    let folder = data.join("meshes");
    let wanted = ALL.into_iter().filter({
        let names = names.to_vec();
        move |(name, _)| names.is_empty() || names.iter().any(|n| n == name)
    });
    Ok(wanted.filter_map(move |(name, source)| {
        let mesh = match source {
            Made(make) => make(),
            File(file) => {
                let path = folder.join(file);
                if !path.is_file() {
                    println!("skipped: {} is not there", path.display());
                    return None;
                }
                io::read(&path).map(|file| file.mesh)
            }
        };
        Some(mesh.and_then(|mesh| surface(name, &mesh)).map_err(Into::into))
    }))
}

/// Returns the largest component, scaled.
fn surface(name: &'static str, mesh: &TriMesh) -> catamaran::Result<Surface> {
    let components = Components::new(mesh);
    let part = match components.largest() {
        Some(largest) if components.len() > 1 => mesh.component(&components, largest)?.mesh,
        _ => mesh.clone(),
    };
    Ok(Surface { name, mesh: scaled(&part)?, closed: part.require_closed().is_ok() })
}
