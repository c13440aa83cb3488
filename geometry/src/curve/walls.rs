//! Edges across which faces are not connected.

use crate::mesh::{Edges, TriMesh};
use catamaran::base::{Error, Result, Sets};

/// The edges of a mesh, some of which are walls.
pub(super) struct Walls {
    pub edges: Edges,
    pub is_wall: Vec<bool>,
}

impl Walls {
    /// Creates the walls along the edges between these vertices.
    pub fn new(mesh: &TriMesh, along: &[[u32; 2]]) -> Result<Self> {
        let edges = Edges::new(mesh);
        let mut is_wall = vec![false; edges.len()];
        for &[a, b] in along {
            match edges.ends().binary_search(&[a.min(b), a.max(b)]) {
                Ok(e) => is_wall[e] = true,
                Err(_) => {
                    let why = format!("no edge joins vertices {a} and {b}");
                    return Err(Error::Argument { what: "along", why });
                }
            }
        }
        Ok(Self { edges, is_wall })
    }

    /// Returns for each face the lowest face of its piece: faces with a common edge that is no wall
    /// are in the same piece.
    pub fn pieces(&self, faces: usize) -> Vec<u32> {
        let mut pieces = Sets::new(faces);
        for e in (0..self.edges.len()).filter(|&e| !self.is_wall[e]) {
            let row: Vec<u32> = self.edges.faces(e).collect();
            for pair in row.windows(2) {
                pieces.join(pair[0], pair[1]);
            }
        }
        (0..faces as u32).map(|f| pieces.find(f)).collect()
    }

    /// Returns the faces on both sides of each wall that is not on the boundary, with the index of
    /// the wall.
    pub fn sides(&self) -> impl Iterator<Item = (usize, u32, u32)> + '_ {
        let walls = (0..self.edges.len()).filter(|&e| self.is_wall[e]);
        walls.flat_map(|e| {
            let row: Vec<u32> = self.edges.faces(e).collect();
            row.windows(2).map(|pair| (e, pair[0], pair[1])).collect::<Vec<_>>()
        })
    }
}
