use super::super::vector::distance;
use super::super::{Edges, TriMesh};
use catamaran::base::{Error, Result};

/// An undirected graph whose edges have lengths, in compressed rows.
///
/// ```
/// use catamaran_geometry::mesh::Graph;
///
/// let graph = Graph::new(3, &[(0, 1, 1.5), (1, 2, 2.0)])?;
/// assert_eq!(graph.neighbours(1).collect::<Vec<_>>(), [(0, 1.5), (2, 2.0)]);
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Graph {
    /// The neighbours of v are the entries `starts[v]..starts[v + 1]`.
    starts: Vec<usize>,
    neighbours: Vec<u32>,
    lengths: Vec<f64>,
}

impl Graph {
    /// Creates the graph of the edges of a mesh with their Euclidean lengths, in O(V + F).
    ///
    /// ```
    /// use catamaran_geometry::mesh::{Graph, families};
    ///
    /// let graph = Graph::of_mesh(&families::grid(2, 2)?);
    /// assert_eq!(graph.len(), 9);
    /// assert!(graph.neighbours(0).any(|(vertex, length)| vertex == 1 && length == 0.5));
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    pub fn of_mesh(mesh: &TriMesh) -> Self {
        let p = mesh.vertices();
        let edges = Edges::new(mesh);
        Self::build(p.len(), || {
            edges.ends().iter().map(|&[a, b]| (a, b, distance(p[a as usize], p[b as usize])))
        })
    }

    /// Creates a graph of n vertices, at most 2^32 - 1, from edges: two vertices and a length each.
    ///
    /// # Errors
    /// [`Error::Argument`] names an edge whose end is out of range, or whose length is negative or
    /// not finite.
    pub fn new(n: usize, edges: &[(u32, u32, f64)]) -> Result<Self> {
        let refused = |why| Err(Error::Argument { what: "edges", why });
        if u32::try_from(n).is_err() {
            return refused(format!("at most 2^32 - 1 vertices are possible, got {n}"));
        }
        for (e, &(a, b, length)) in edges.iter().enumerate() {
            if a as usize >= n || b as usize >= n {
                return refused(format!(
                    "edge {e}, from {a} to {b}, is out of range: {n} vertices"
                ));
            }
            if !(length >= 0.0 && length.is_finite()) {
                return refused(format!(
                    "edge {e} has length {length}, must be finite and at least 0"
                ));
            }
        }
        Ok(Self::build(n, || edges.iter().copied()))
    }

    fn build<I: Iterator<Item = (u32, u32, f64)>>(n: usize, edges: impl Fn() -> I) -> Self {
        let mut starts = vec![0; n + 1];
        for (a, b, _) in edges() {
            starts[a as usize + 1] += 1;
            starts[b as usize + 1] += 1;
        }
        for v in 0..n {
            starts[v + 1] += starts[v];
        }
        let mut next = starts.clone();
        let mut neighbours = vec![0; starts[n]];
        let mut lengths = vec![0.0; starts[n]];
        for (a, b, length) in edges() {
            for (from, to) in [(a, b), (b, a)] {
                let place = &mut next[from as usize];
                neighbours[*place] = to;
                lengths[*place] = length;
                *place += 1;
            }
        }
        Self { starts, neighbours, lengths }
    }

    /// Returns the number of vertices.
    pub fn len(&self) -> usize {
        self.starts.len() - 1
    }

    /// Returns whether the graph has no vertices.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the neighbours of a vertex and the lengths of the edges that lead there. Panics when
    /// the graph does not have the vertex.
    pub fn neighbours(&self, vertex: u32) -> impl Iterator<Item = (u32, f64)> {
        let range = self.starts[vertex as usize]..self.starts[vertex as usize + 1];
        range.map(|e| (self.neighbours[e], self.lengths[e]))
    }
}
