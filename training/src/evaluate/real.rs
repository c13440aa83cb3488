use std::path::Path;

use catamaran::{Par, Result};
use catamaran_geometry::decimate::{DecimateOptions, decimate};
use catamaran_geometry::mesh::{RepairOptions, TriMesh, io, repair};

use super::{BodyCut, Frame, body_pairs};
use crate::families::{Family, Model};
use crate::train::Pair;

/// A real shape, which is in no data set.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RealShape {
    /// Its name in tables.
    pub name: &'static str,
    /// Whether it is a human.
    pub human: bool,
    source: Source,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Source {
    /// The largest component of the mesh in this file, with y up.
    File(&'static str),
    /// A generated shape of this family.
    Family(Family),
}

const fn file(name: &'static str, human: bool, path: &'static str) -> RealShape {
    RealShape { name, human, source: Source::File(path) }
}

const fn family(name: &'static str, family: Family) -> RealShape {
    RealShape { name, human: false, source: Source::Family(family) }
}

/// Real people, and other shapes: animals, statues, objects, and the families that are not in the
/// training.
pub const REAL_SHAPES: [RealShape; 16] = [
    file("man", true, "human_man.obj.gz"),
    file("woman", true, "human_woman.obj.gz"),
    file("cow", false, "spot.obj.gz"),
    file("armadillo", false, "armadillo43k.obj.gz"),
    file("bunny", false, "ofp_bunny10k.off.gz"),
    file("elephant", false, "refined_elephant44k.off.gz"),
    file("lion statue", false, "lionstatue32k.obj.gz"),
    file("bust", false, "nefertiti35k.obj.gz"),
    file("monkey's head", false, "suzanne_499components.ply.gz"),
    file("brain", false, "fsaverage5_L_pial.ply.gz"),
    file("vase", false, "vase.stl.gz"),
    file("sword", false, "sword_quads.obj.gz"),
    file("terrain", false, "mountain26k.obj.gz"),
    family("quadruped", Family::Quadruped),
    family("headphones", Family::Headphones),
    family("sheet", Family::Sheet),
];

/// Meshes with more vertices are decimated to this number, to save time.
const DECIMATED_ABOVE: usize = 20_000;
const DECIMATED_TO: usize = 7_000;

/// Number of vertices of generated shapes; also their seed, which no data set has.
const GENERATED: usize = 2_500;
const SEED: u64 = 4242;

impl RealShape {
    /// Returns the shape and its axes; files are read from `folder`.
    ///
    /// # Errors
    /// [`catamaran::Error::Mesh`] when the largest component is not a manifold; those of
    /// [`io::read`], [`repair`] of seams and repeated faces, and [`decimate`].
    pub fn mesh(&self, folder: &Path, par: Par) -> Result<(TriMesh, Frame)> {
        Ok(match self.source {
            Source::File(name) => (read(&folder.join(name), par)?, Frame { up: 1, side: 0 }),
            Source::Family(family) => {
                let mesh = Model::new(family, GENERATED)?.shape(SEED, 0, 0, 0)?;
                (mesh, Frame { up: 2, side: 0 })
            }
        })
    }

    /// Cuts the shape in each way of [`BODY_CUTS`](super::BODY_CUTS).
    ///
    /// # Errors
    /// Those of [`mesh`](Self::mesh) and [`body_pairs`].
    pub fn pairs(&self, folder: &Path, par: Par) -> Result<Vec<(&'static BodyCut, Result<Pair>)>> {
        let (mesh, frame) = self.mesh(folder, par)?;
        body_pairs(&mesh, frame, par)
    }
}

/// Reads the largest component of a mesh, and decimates it if it is too large.
fn read(path: &Path, par: Par) -> Result<TriMesh> {
    let options = RepairOptions::unambiguous().compact(true).keep_largest(1);
    let mesh = repair(io::read(path)?, &options)?.file.mesh;
    mesh.require_manifold()?;
    if mesh.vertices().len() <= DECIMATED_ABOVE {
        return Ok(mesh);
    }
    Ok(decimate(&mesh, DECIMATED_TO, &DecimateOptions::new().par(par))?.mesh)
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn the_largest_component_is_read_if_it_is_a_manifold() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.obj");
        // A tetrahedron, and a triangle.
        let points = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 5 0 0\nv 6 0 1\nv 5 1 0\n";
        let closed = "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
        fs::write(&path, format!("{points}{closed}f 5 6 7\n")).unwrap();
        let mesh = read(&path, Par::Seq).unwrap();
        assert_eq!((mesh.vertices().len(), mesh.faces().len()), (4, 4));
        // A strip whose ends meet in vertex 1.
        let strip = "f 1 2 3\nf 2 4 3\nf 3 4 5\nf 4 6 5\nf 5 6 1\n";
        fs::write(&path, format!("{points}{strip}")).unwrap();
        let refused = read(&path, Par::Seq).unwrap_err().to_string();
        assert!(refused.contains("vertex 0"), "{refused}");
        assert!(REAL_SHAPES[0].pairs(folder.path(), Par::Seq).is_err());
    }
}
