use std::borrow::Cow;
use std::collections::{HashMap, HashSet};

use super::refinement::Refinement;
use crate::mesh::vector::{Vector, distance};
use crate::mesh::{Components, Graph, TriMesh};
use catamaran::base::Result;

/// The graph on which paths run: the edges of a mesh, and of its refinement for one call.
pub(super) struct Surface<'m> {
    graph: Graph,
    components: Components,
    refinement: Refinement<'m>,
    /// The edges in whose middle the new vertices are.
    ends: Vec<[u32; 2]>,
    /// Neighbours of vertices at which the mesh was refined.
    neighbours: HashMap<u32, Vec<(u32, f64)>>,
}

impl<'m> Surface<'m> {
    /// Creates the surface of a mesh without refinement.
    pub fn new(mesh: Cow<'m, TriMesh>) -> Self {
        Self {
            graph: Graph::of_mesh(&mesh),
            components: Components::new(&mesh),
            refinement: Refinement::new(mesh),
            ends: Vec::new(),
            neighbours: HashMap::new(),
        }
    }

    /// Returns the mesh.
    pub fn mesh(&self) -> &TriMesh {
        self.refinement.mesh()
    }

    /// Returns the number of vertices of the mesh and of its refinement.
    pub fn len(&self) -> usize {
        self.graph.len() + self.ends.len()
    }

    /// Returns the component of a vertex of the mesh.
    pub fn component(&self, vertex: u32) -> u32 {
        self.components.of_vertices()[vertex as usize]
    }

    /// Returns the position of a vertex.
    pub fn position(&self, vertex: u32) -> Vector {
        self.refinement.position(vertex)
    }

    /// Returns the edges in whose middle the vertices of the refinement are.
    pub fn bisected(&self) -> &[[u32; 2]] {
        &self.ends
    }

    /// Returns the neighbours of a vertex, and the lengths of the edges that lead there.
    pub fn neighbours(&self, vertex: u32) -> impl Iterator<Item = (u32, f64)> {
        let new = if self.neighbours.is_empty() { None } else { self.neighbours.get(&vertex) };
        let old = new.is_none().then(|| self.graph.neighbours(vertex));
        old.into_iter().flatten().chain(new.into_iter().flatten().copied())
    }

    /// Inserts a vertex in the middle of every edge at these paths, except the edges of the paths
    /// themselves, so that other paths can go around them.
    ///
    /// # Errors
    /// [`Error::Argument`](catamaran::Error::Argument) when there would be too many vertices for
    /// indices.
    pub fn refine_around(&mut self, paths: &[Vec<u32>]) -> Result<()> {
        let steps = paths.iter().flat_map(|path| path.windows(2));
        // The path that comes next at a sample is refined, too.
        let own: HashSet<[u32; 2]> = steps.map(|step| [step[0], step[1]]).collect();
        let mut seen = HashSet::new();
        for &v in paths.iter().flatten().filter(|v| seen.insert(**v)) {
            let ends: Vec<u32> = self.neighbours(v).map(|(u, _)| u).collect();
            for u in ends {
                if !own.contains(&[v, u]) && !own.contains(&[u, v]) {
                    self.bisect(v, u)?;
                }
            }
        }
        Ok(())
    }

    /// Removes the refinement.
    pub fn forget_refinement(&mut self) {
        self.refinement.forget();
        self.ends.clear();
        self.neighbours.clear();
    }

    fn bisect(&mut self, a: u32, b: u32) -> Result<()> {
        let (_, around) = self.refinement.bisect([a, b])?;
        self.ends.push([a, b]);
        for v in around {
            let p = self.position(v);
            let others = self.refinement.neighbours(v).into_iter();
            let others = others.map(|u| (u, distance(p, self.refinement.position(u)))).collect();
            self.neighbours.insert(v, others);
        }
        Ok(())
    }
}
