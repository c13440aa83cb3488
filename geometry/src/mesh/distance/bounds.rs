use std::collections::HashMap;

use rstar::RTree;

use super::super::TriMesh;
use super::super::vector::{Vector, distance};
use super::{Dijkstra, Graph, SearchLimits};
use catamaran::base::{Result, spend};

/// Operations that finding the nearest source is equal to.
const SEARCHED: f64 = 300.0;

/// Bounds of the distances along a surface: paths that lie on it from above, straight lines through
/// space from below.
#[derive(Debug)]
pub(super) struct Bounds {
    positions: Vec<[f64; 3]>,
    /// The edges of the mesh and those of another triangulation of its surface.
    paths: Graph,
}

impl Bounds {
    /// Creates the bounds for a mesh; `faces` with the `lengths` of their edges triangulate the
    /// same surface.
    pub fn new(mesh: &TriMesh, faces: &[[u32; 3]], lengths: &[[f64; 3]]) -> Result<Self> {
        let positions = mesh.vertices().to_vec();
        let at = |v: u32| positions[v as usize];
        let sides = |face: [u32; 3]| [0, 1, 2].map(|k| (face[k], face[(k + 1) % 3]));
        let straight = mesh.faces().iter().flat_map(|&face| sides(face));
        let mut edges: Vec<(u32, u32, f64)> =
            straight.map(|(a, b)| (a.min(b), a.max(b), distance(at(a), at(b)))).collect();
        for (&face, lengths) in faces.iter().zip(lengths) {
            let other = sides(face).into_iter().zip(lengths).filter(|((a, b), _)| a != b);
            edges.extend(other.map(|((a, b), &length)| (a.min(b), a.max(b), length)));
        }
        edges.sort_unstable_by(|x, y| (x.0, x.1).cmp(&(y.0, y.1)).then(x.2.total_cmp(&y.2)));
        edges.dedup_by_key(|edge| (edge.0, edge.1));
        let paths = Graph::new(positions.len(), &edges)?;
        Ok(Self { positions, paths })
    }

    /// Replaces each distance that violates a bound by this bound. The distances are those from the
    /// nearest source in the component of the vertex; `components` has the number of the component
    /// of each vertex.
    pub fn impose(&self, sources: &[u32], components: &[u32], distances: &mut [f64]) -> Result<()> {
        let mut search = Dijkstra::new(&self.paths);
        let starts: Vec<(u32, f64)> = sources.iter().map(|&source| (source, 0.0)).collect();
        search.search(&starts, &SearchLimits::default())?;
        // One tree for each component: a search in a common one would pass all nearer sources of
        // other components.
        let mut placed: HashMap<u32, Vec<Vector>> = HashMap::new();
        for &source in sources {
            let v = source as usize;
            placed.entry(components[v]).or_default().push(self.positions[v]);
        }
        let trees: HashMap<u32, RTree<Vector>> =
            placed.into_iter().map(|(part, points)| (part, RTree::bulk_load(points))).collect();
        for (v, found) in distances.iter_mut().enumerate().filter(|(_, found)| found.is_finite()) {
            spend(SEARCHED)?;
            let position = self.positions[v];
            let tree = trees.get(&components[v]);
            let source = tree.and_then(|tree| tree.nearest_neighbor(position));
            let below = source.map_or(0.0, |&source| distance(position, source));
            *found = found.max(below).min(search.distance(v as u32));
        }
        Ok(())
    }
}
