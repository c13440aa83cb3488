use super::super::TriMesh;
use super::Edges;
use crate::base::{Error, Result};

impl TriMesh {
    /// The edges over which two faces do not agree on what is outside: their faces run along them in the same direction.
    /// Edges with one face, or with more than two, are not among them.
    pub fn inconsistent_edges(&self, edges: &Edges) -> Vec<u32> {
        let edges = &*edges.of(self);
        let both = |row: &[u32]| matches!(row, &[a, b] if self.same_direction(a, b));
        (0..).zip(edges.corners().rows()).filter(|(_, row)| both(row)).map(|(e, _)| e).collect()
    }

    /// Whether two faces run along their common edge in the same direction, where it starts at these corners.
    fn same_direction(&self, a: u32, b: u32) -> bool {
        self.faces()[a as usize / 3][a as usize % 3] == self.faces()[b as usize / 3][b as usize % 3]
    }

    /// Which faces must be flipped so that all agree over every edge of two faces; of each group of faces that hang together
    /// over such edges, the lowest stays.
    ///
    /// # Errors
    /// [`Error::Mesh`] that names an edge over which no flipping makes its faces agree: the mesh is not orientable.
    pub fn flips(&self, edges: &Edges) -> Result<Vec<bool>> {
        let edges = &*edges.of(self);
        let mut flip: Vec<Option<bool>> = vec![None; self.faces().len()];
        let mut open = Vec::new();
        for seed in 0..flip.len() {
            if flip[seed].is_none() {
                flip[seed] = Some(false);
                open.push(seed as u32);
            }
            while let Some(face) = open.pop() {
                let own = flip[face as usize].unwrap_or_default();
                for corner in 3 * face..3 * face + 3 {
                    let e = edges.of_corners()[corner as usize];
                    let &[a, b] = edges.corners().row(e as usize) else { continue };
                    let neighbor = if a == corner { b / 3 } else { a / 3 };
                    let wanted = own ^ self.same_direction(a, b);
                    match flip[neighbor as usize] {
                        None => {
                            flip[neighbor as usize] = Some(wanted);
                            open.push(neighbor);
                        }
                        Some(flipped) if flipped == wanted => {}
                        Some(_) => {
                            return Err(Error::Mesh {
                                what: format!(
                                    "faces {} and {} can't be turned to agree: not orientable",
                                    a / 3,
                                    b / 3
                                ),
                                element: edges.name(e as usize),
                            });
                        }
                    }
                }
            }
        }
        Ok(flip.into_iter().map(Option::unwrap_or_default).collect())
    }

    /// The mesh with faces flipped so that all agree; of each group of faces that hang together over edges of two faces, the
    /// lowest stays as it is.
    ///
    /// # Errors
    /// [`Error::Mesh`] that names an edge with more than two faces, or one over which the mesh is not orientable.
    pub fn oriented(&self) -> Result<TriMesh> {
        let edges = Edges::new(self);
        edges.require_manifold()?;
        let flips = self.flips(&edges)?;
        let flipped = |(&[a, b, c], flip): (&[u32; 3], bool)| {
            if flip { [a, c, b] } else { [a, b, c] }
        };
        let faces = self.faces().iter().zip(flips).map(flipped).collect();
        TriMesh::new(self.vertices().to_vec(), faces)
    }
}
