use super::super::TriMesh;
use super::Edges;
use catamaran::base::{Error, Result};

impl TriMesh {
    /// Returns the edges whose two faces disagree about which side is outside: both run along the
    /// edge in the same direction. Edges with one face, or with more than two, are not included.
    ///
    /// ```
    /// use catamaran_geometry::mesh::{Edges, TriMesh};
    ///
    /// let corners = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
    /// let mesh = TriMesh::new(corners, vec![[0, 1, 2], [1, 2, 3]])?;
    /// let edges = Edges::new(&mesh);
    /// let found = mesh.inconsistent_edges(&edges);
    /// assert_eq!(edges.ends()[found[0] as usize], [1, 2]);
    /// assert!(mesh.oriented()?.inconsistent_edges(&edges).is_empty());
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    pub fn inconsistent_edges(&self, edges: &Edges) -> Vec<u32> {
        let edges = &*edges.of(self);
        let both = |row: &[u32]| matches!(row, &[a, b] if self.same_direction(a, b));
        (0..).zip(edges.corners().rows()).filter(|(_, row)| both(row)).map(|(e, _)| e).collect()
    }

    /// Returns whether two faces run along their common edge in the same direction; the edge starts
    /// at these corners.
    fn same_direction(&self, a: u32, b: u32) -> bool {
        self.faces()[a as usize / 3][a as usize % 3] == self.faces()[b as usize / 3][b as usize % 3]
    }

    /// Returns which faces must be flipped so that all agree over every edge of two faces; the
    /// lowest face of each group of faces that are connected over such edges stays.
    ///
    /// ```
    /// use catamaran_geometry::mesh::{Edges, TriMesh};
    ///
    /// let corners = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
    /// let mesh = TriMesh::new(corners, vec![[0, 1, 2], [1, 2, 3]])?;
    /// assert_eq!(mesh.flips(&Edges::new(&mesh))?, [false, true]);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Mesh`] names an edge whose faces can't be flipped to agree: the mesh is not
    /// orientable.
    pub fn flips(&self, edges: &Edges) -> Result<Vec<bool>> {
        let edges = &*edges.of(self);
        let sides = self.sides(edges);
        match sides.conflicts.iter().flatten().next() {
            None => Ok(sides.flip),
            Some(&e) => {
                let faces: Vec<u32> = edges.faces(e as usize).collect();
                Err(Error::Mesh {
                    what: format!("{} can't be flipped to agree: not orientable", pair(&faces)),
                    element: edges.name(e as usize),
                })
            }
        }
    }

    /// Returns the groups of faces that are connected over edges of two faces, and which faces must
    /// be flipped so that the faces of each group agree with its lowest one.
    pub(in super::super) fn sides(&self, edges: &Edges) -> Sides {
        let mut group = vec![u32::MAX; self.faces().len()];
        let mut flip = vec![false; self.faces().len()];
        let mut conflicts = Vec::new();
        let mut open = Vec::new();
        for seed in 0..group.len() {
            if group[seed] != u32::MAX {
                continue;
            }
            let number = conflicts.len() as u32;
            let mut conflict = None;
            group[seed] = number;
            open.push(seed as u32);
            while let Some(face) = open.pop() {
                let own = flip[face as usize];
                for corner in 3 * face..3 * face + 3 {
                    let e = edges.of_corners()[corner as usize];
                    let &[a, b] = edges.corners().row(e as usize) else { continue };
                    let neighbor = (if a == corner { b } else { a }) as usize / 3;
                    let wanted = own ^ self.same_direction(a, b);
                    if group[neighbor] == u32::MAX {
                        group[neighbor] = number;
                        flip[neighbor] = wanted;
                        open.push(neighbor as u32);
                    } else if flip[neighbor] != wanted {
                        conflict = conflict.or(Some(e));
                    }
                }
            }
            conflicts.push(conflict);
        }
        Sides { group, flip, conflicts }
    }

    /// Returns the mesh with faces flipped so that all agree; the lowest face of each group of
    /// faces that are connected over edges of two faces stays as it is.
    ///
    /// ```
    /// use catamaran_geometry::mesh::TriMesh;
    ///
    /// let corners = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
    /// let mesh = TriMesh::new(corners, vec![[0, 1, 2], [1, 2, 3]])?.oriented()?;
    /// assert_eq!(mesh.face_normals(), [[0.0, 0.0, 1.0]; 2]);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Mesh`] names an edge with more than two faces, or one over which the mesh is not
    /// orientable.
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

/// Which faces of a mesh must be flipped so that connected faces agree.
pub(in super::super) struct Sides {
    /// For each face its group; groups are numbered by their lowest face.
    pub group: Vec<u32>,
    /// Whether each face must be flipped.
    pub flip: Vec<bool>,
    /// For each group that is not orientable, an edge whose faces disagree; `None` for the other
    /// groups.
    pub conflicts: Vec<Option<u32>>,
}

fn pair(faces: &[u32]) -> String {
    match faces {
        [a, b] => format!("faces {a} and {b}"),
        _ => "its faces".into(),
    }
}
