//! Meshes for tests, in addition to those of [`super::families`].

use super::{TriMesh, families};
use catamaran::base::Rng;

/// Generates a grid of x by y squares of side 1, each cut along the diagonal from its lower left
/// corner; vertices are numbered along x first.
pub(crate) fn grid(x: u32, y: u32) -> TriMesh {
    let at = |i, j| j * (x + 1) + i;
    let vertices = (0..=y).flat_map(|j| (0..=x).map(move |i| [f64::from(i), f64::from(j), 0.0]));
    let faces = (0..y).flat_map(|j| {
        (0..x).flat_map(move |i| {
            let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
            [[a, b, c], [a, c, d]]
        })
    });
    TriMesh::new(vertices.collect(), faces.collect()).unwrap()
}

/// Generates the unit sphere by subdivision of an icosahedron.
pub(crate) fn sphere(subdivisions: u32) -> TriMesh {
    families::icosphere(subdivisions).unwrap()
}

/// Returns the mesh with every coordinate moved by a random amount of at most `by`.
pub(crate) fn shaken(mesh: &TriMesh, by: f64, seed: u64) -> TriMesh {
    let mut rng = Rng::new(seed);
    let mut vertices = mesh.vertices().to_vec();
    for x in vertices.as_flattened_mut() {
        *x += by * (2.0 * rng.uniform() - 1.0);
    }
    TriMesh::new(vertices, mesh.faces().to_vec()).unwrap()
}

/// Generates random triangles among n vertices, some of which have equal positions.
pub(crate) fn soup(n: u32, faces: usize, seed: u64) -> TriMesh {
    let mut rng = Rng::new(seed);
    let mut below = |n: u32| (rng.bits() % u64::from(n)) as u32;
    let faces = (0..faces)
        .map(|_| {
            let a = below(n);
            let b = (a + 1 + below(n - 1)) % n;
            let c = std::iter::repeat_with(|| below(n)).find(|&c| c != a && c != b);
            [a, b, c.unwrap_or_default()]
        })
        .collect();
    let vertices = (0..n).map(|_| std::array::from_fn(|_| f64::from(below(5)))).collect();
    TriMesh::new(vertices, faces).unwrap()
}

/// Returns two meshes as one mesh, the second moved along x.
pub(crate) fn both(first: &TriMesh, second: &TriMesh, along: f64) -> TriMesh {
    let n = first.vertices().len() as u32;
    let mut vertices = first.vertices().to_vec();
    vertices.extend(second.vertices().iter().map(|p| [p[0] + along, p[1], p[2]]));
    let mut faces = first.faces().to_vec();
    faces.extend(second.faces().iter().map(|f| f.map(|v| v + n)));
    TriMesh::new(vertices, faces).unwrap()
}
