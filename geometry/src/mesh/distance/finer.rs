use super::super::{Edges, TriMesh};
use catamaran::base::Result;

/// Fewest faces on which heat flows: on fewer, distances would be wrong by more than a few per
/// cent. Refinement leaves no path longer than heat can cross (about 650 edges): a strip of 499
/// faces is 250 edges long, and 500 once each edge is halved.
const FEWEST: usize = 500;

/// Returns the mesh with every face cut into four at the middles of its edges, as often as it takes
/// to have [`FEWEST`] faces; `None` for a mesh that has as many already, or none. The first
/// vertices are those of the mesh.
pub(super) fn finer(mesh: &TriMesh) -> Result<Option<TriMesh>> {
    let mut found: Option<TriMesh> = None;
    loop {
        let coarse = found.as_ref().unwrap_or(mesh);
        if coarse.faces().is_empty() || coarse.faces().len() >= FEWEST {
            return Ok(found);
        }
        found = Some(quartered(coarse)?);
    }
}

fn quartered(mesh: &TriMesh) -> Result<TriMesh> {
    let edges = Edges::new(mesh);
    let first = mesh.vertices().len() as u32;
    let mut vertices = mesh.vertices().to_vec();
    vertices.extend(edges.ends().iter().map(|&[a, b]| {
        let [p, q] = [a, b].map(|v| mesh.vertices()[v as usize]);
        // Halves first: the sum of two coordinates may overflow.
        std::array::from_fn(|k| 0.5 * p[k] + 0.5 * q[k])
    }));
    let middles = edges.of_corners().as_chunks::<3>().0;
    let faces = mesh.faces().iter().zip(middles).flat_map(|(&[a, b, c], middles)| {
        let [d, e, f] = middles.map(|edge| first + edge);
        [[a, d, f], [b, e, d], [c, f, e], [d, e, f]]
    });
    TriMesh::new(vertices, faces.collect())
}
