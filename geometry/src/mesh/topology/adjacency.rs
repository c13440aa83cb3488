use super::super::TriMesh;

/// Lists of numbers in compressed rows: row i is `items[starts[i]..starts[i + 1]]`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Adjacency {
    starts: Vec<u32>,
    items: Vec<u32>,
}

impl Adjacency {
    /// Creates the rows from the pairs `(row, item)` of `pairs`, which is iterated twice, and whose
    /// order the items keep. The number of pairs must be less than 2^32.
    ///
    /// Public for the trees of plants of `catamaran-simulation`.
    #[doc(hidden)]
    pub fn from_pairs<I: Iterator<Item = (u32, u32)>>(rows: usize, pairs: impl Fn() -> I) -> Self {
        let mut starts = vec![0u32; rows + 1];
        for (row, _) in pairs() {
            starts[row as usize + 1] += 1;
        }
        for i in 0..rows {
            starts[i + 1] += starts[i];
        }
        let mut ends = starts.clone();
        let mut items = vec![0; starts[rows] as usize];
        for (row, item) in pairs() {
            let end = &mut ends[row as usize];
            items[*end as usize] = item;
            *end += 1;
        }
        Self { starts, items }
    }

    /// Creates the lists from rows in compressed form.
    pub(super) fn from_parts(starts: Vec<u32>, items: Vec<u32>) -> Self {
        Self { starts, items }
    }

    /// Returns the number of rows.
    pub fn len(&self) -> usize {
        self.starts.len() - 1
    }

    /// Returns whether there are no rows.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns row i; empty if the row does not exist.
    pub fn row(&self, i: usize) -> &[u32] {
        match self.starts.get(i..i + 2) {
            Some(&[start, end]) => &self.items[start as usize..end as usize],
            _ => &[],
        }
    }

    /// Returns all rows, in order.
    pub fn rows(&self) -> impl Iterator<Item = &[u32]> {
        self.starts.windows(2).map(|w| &self.items[w[0] as usize..w[1] as usize])
    }

    /// Returns the start of each row, and the end of the last one: one more than there are rows.
    pub fn starts(&self) -> &[u32] {
        &self.starts
    }

    /// Returns the items of all rows, one row after the other.
    pub fn items(&self) -> &[u32] {
        &self.items
    }

    /// Returns the rows with their items in ascending order, each once.
    fn sorted(mut self) -> Self {
        let mut kept = 0;
        let mut start = 0;
        for i in 0..self.len() {
            let end = self.starts[i + 1] as usize;
            self.items[start..end].sort_unstable();
            let first = kept;
            for at in start..end {
                if kept == first || self.items[kept - 1] != self.items[at] {
                    self.items[kept] = self.items[at];
                    kept += 1;
                }
            }
            start = end;
            self.starts[i + 1] = kept as u32;
        }
        self.items.truncate(kept);
        self
    }
}

/// Returns the corners of a mesh, each with its vertex.
pub(in super::super) fn corners(faces: &[[u32; 3]]) -> impl Iterator<Item = (u32, u32)> {
    faces.as_flattened().iter().zip(0..).map(|(&vertex, corner)| (vertex, corner))
}

impl TriMesh {
    /// Returns for each vertex the vertices that an edge joins to it, ascending.
    ///
    /// ```
    /// use catamaran_geometry::mesh::families;
    ///
    /// let neighbors = families::icosphere(0)?.vertex_neighbors();
    /// assert!(neighbors.rows().all(|row| row.len() == 5));
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    pub fn vertex_neighbors(&self) -> Adjacency {
        let pairs = || {
            let faces = self.faces().iter();
            faces.flat_map(|&[a, b, c]| [(a, b), (b, a), (b, c), (c, b), (c, a), (a, c)])
        };
        Adjacency::from_pairs(self.vertices().len(), pairs).sorted()
    }

    /// Returns for each vertex its faces, ascending.
    ///
    /// ```
    /// use catamaran_geometry::mesh::families;
    ///
    /// assert_eq!(families::grid(1, 1)?.vertex_faces().row(0), [0, 1]);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    pub fn vertex_faces(&self) -> Adjacency {
        Adjacency::from_pairs(self.vertices().len(), || {
            corners(self.faces()).map(|(vertex, corner)| (vertex, corner / 3))
        })
    }

    /// Returns the vertices that no face has, ascending.
    ///
    /// ```
    /// use catamaran_geometry::mesh::TriMesh;
    ///
    /// let mesh = TriMesh::new(vec![[0.0; 3]; 4], vec![[0, 1, 3]])?;
    /// assert_eq!(mesh.unreferenced_vertices(), [2]);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    pub fn unreferenced_vertices(&self) -> Vec<u32> {
        let used = self.referenced();
        (0..self.vertices().len() as u32).filter(|&v| !used[v as usize]).collect()
    }

    /// Returns for each vertex whether a face has it.
    pub(crate) fn referenced(&self) -> Vec<bool> {
        let mut used = vec![false; self.vertices().len()];
        for &v in self.faces().as_flattened() {
            used[v as usize] = true;
        }
        used
    }
}
