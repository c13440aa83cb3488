//! Meshes and simulations that several tests use.

use catamaran_geometry::mesh::{TriMesh, families};
use catamaran_simulation::texture::slime::{Mask, Options, Simulation, Surface, atlas};

/// A surface with an atlas of triangles for a texture of that size.
pub fn with_atlas(mesh: &TriMesh, size: usize) -> Surface {
    Surface::of_faces(mesh, atlas(mesh, size).unwrap()).unwrap()
}

/// The unit square, whose texture coordinates are its own.
pub fn square(cells: usize) -> Surface {
    let mesh = families::grid(cells, cells).unwrap();
    let at = |v: u32| {
        let [x, y, _] = mesh.vertices()[v as usize];
        [x, y]
    };
    Surface::of_faces(&mesh, mesh.faces().iter().map(|face| face.map(at)).collect()).unwrap()
}

/// Small, so that tests are fast.
pub fn options(agents: usize, size: usize) -> Options {
    Options::new().agents(agents).size(size).seed(7)
}

pub fn simulation(surface: Surface, options: &Options) -> Simulation {
    Simulation::new(surface, options, &Mask::default()).unwrap()
}
