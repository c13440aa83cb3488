use super::super::TriMesh;
use super::Edges;
use catamaran::base::Result;

impl TriMesh {
    /// Returns the boundary loops: the vertices of each in order, the first not repeated, with the
    /// mesh on the left where it is oriented. Where the boundary meets itself at a vertex, a loop
    /// stays with its fan of faces. Loops are ordered by their lowest boundary edge.
    ///
    /// ```
    /// use catamaran_geometry::mesh::{Edges, families};
    ///
    /// let square = families::grid(1, 1)?;
    /// assert_eq!(square.boundary_loops(&Edges::new(&square))?, [[1, 0, 2, 3]]);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Mesh`](catamaran::Error::Mesh) when there is a boundary and an edge with three
    /// faces or more: such a boundary need not consist of loops.
    pub fn boundary_loops(&self, edges: &Edges) -> Result<Vec<Vec<u32>>> {
        let edges = &*edges.of(self);
        if edges.boundary().next().is_none() {
            return Ok(Vec::new());
        }
        edges.require_manifold()?;
        let mut seen = vec![false; edges.len()];
        let mut loops = Vec::new();
        for first in edges.boundary() {
            if seen[first as usize] {
                continue;
            }
            let mut corner = edges.corners().row(first as usize)[0];
            let [start, mut vertex] = self.ends(corner);
            let mut walk = vec![start];
            seen[first as usize] = true;
            loop {
                let edge;
                (edge, corner) = self.next_on_boundary(edges, corner, vertex);
                if seen[edge as usize] {
                    break;
                }
                seen[edge as usize] = true;
                walk.push(vertex);
                let [a, b] = self.ends(corner);
                vertex = if a == vertex { b } else { a };
            }
            loops.push(walk);
        }
        Ok(loops)
    }

    /// Returns the vertices of the edge that starts at a corner.
    fn ends(&self, corner: u32) -> [u32; 2] {
        let [f, i] = [corner as usize / 3, corner as usize % 3];
        [self.faces()[f][i], self.faces()[f][(i + 1) % 3]]
    }

    /// Returns the boundary edge that follows a boundary edge at one of its vertices, by walking
    /// through the fan of faces there.
    fn next_on_boundary(&self, edges: &Edges, mut corner: u32, vertex: u32) -> (u32, u32) {
        loop {
            // The other edge of this face at the vertex; the orientation of faces may differ.
            let face = corner / 3;
            let others = (3 * face..3 * face + 3).filter(|&c| c != corner);
            let other = others.into_iter().find(|&c| self.ends(c).contains(&vertex));
            // There always is one, because two edges of a face meet at a corner.
            let other = other.unwrap_or(corner);
            let edge = edges.of_corners()[other as usize];
            match edges.corners().row(edge as usize) {
                &[a, b] => corner = if a == other { b } else { a },
                _ => return (edge, other),
            }
        }
    }
}
