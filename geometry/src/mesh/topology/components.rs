use super::super::{TriMesh, slots};
use catamaran::base::Sets;

/// The connected components of a mesh: two faces with a common vertex are in the same component.
/// Components are numbered by their lowest vertex; vertices without a face are in no component.
///
/// ```
/// use catamaran_geometry::mesh::{Components, families};
///
/// let components = Components::new(&families::spheres(3, 1)?);
/// assert_eq!(components.len(), 3);
/// assert_eq!(components.vertex_counts(), [42; 3]);
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Components {
    of_vertex: Vec<u32>,
    of_face: Vec<u32>,
    faces: Vec<usize>,
    vertices: Vec<usize>,
}

impl Components {
    /// Marks a vertex without a face, which is in no component.
    pub const NONE: u32 = u32::MAX;

    /// Finds the components of `mesh`.
    pub fn new(mesh: &TriMesh) -> Self {
        let mut sets = Sets::new(mesh.vertices().len());
        for &[a, b, c] in mesh.faces() {
            sets.join(a, b);
            sets.join(b, c);
        }
        let used = mesh.referenced();
        let mut vertices = Vec::new();
        let mut of_vertex = vec![Self::NONE; used.len()];
        for v in 0..used.len() {
            if !used[v] {
                continue;
            }
            // The root is the lowest vertex, so its component is numbered before that of all
            // others.
            let root = sets.find(v as u32) as usize;
            if root == v {
                of_vertex[v] = vertices.len() as u32;
                vertices.push(0);
            }
            of_vertex[v] = of_vertex[root];
            vertices[of_vertex[v] as usize] += 1;
        }
        let mut faces = vec![0; vertices.len()];
        let of_face: Vec<u32> = mesh.faces().iter().map(|f| of_vertex[f[0] as usize]).collect();
        for &component in &of_face {
            faces[component as usize] += 1;
        }
        Self { of_vertex, of_face, faces, vertices }
    }

    /// Returns the number of components.
    pub fn len(&self) -> usize {
        self.faces.len()
    }

    /// Returns whether there are no components.
    pub fn is_empty(&self) -> bool {
        self.faces.is_empty()
    }

    /// Returns the component of each vertex, or [`Components::NONE`].
    pub fn of_vertices(&self) -> &[u32] {
        &self.of_vertex
    }

    /// Returns the component of each face.
    pub fn of_faces(&self) -> &[u32] {
        &self.of_face
    }

    /// Returns the number of faces of each component.
    pub fn face_counts(&self) -> &[usize] {
        &self.faces
    }

    /// Returns the number of vertices of each component.
    pub fn vertex_counts(&self) -> &[usize] {
        &self.vertices
    }

    /// Returns the component with the most faces, the first of several with the same number; `None`
    /// when there are no components.
    pub fn largest(&self) -> Option<usize> {
        (0..self.len()).rev().max_by_key(|&c| self.faces[c])
    }
}

impl TriMesh {
    /// Returns the number of fans of each vertex: groups of its faces that are connected over edges
    /// at this vertex. A vertex of more than one fan is non-manifold (a bow tie); a vertex of no
    /// fan is in no face.
    ///
    /// ```
    /// use catamaran_geometry::mesh::{Edges, families};
    ///
    /// let tie = families::bow_tie()?;
    /// assert_eq!(tie.fans(&Edges::new(&tie)), [2, 1, 1, 1, 1, 1, 1]);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    pub fn fans(&self, edges: &super::Edges) -> Vec<u32> {
        let edges = &*edges.of(self);
        let faces = self.faces();
        let mut corners = Sets::new(3 * faces.len());
        // The corners of a face at the start and the end of the edge that starts at this corner.
        let both = |corner: u32| {
            let next = slots::next(corner);
            let [i, j] = [corner, next].map(|c| faces[c as usize / 3][c as usize % 3]);
            if i < j { [corner, next] } else { [next, corner] }
        };
        for row in edges.corners().rows() {
            for pair in row.windows(2) {
                let ([a, b], [c, d]) = (both(pair[0]), both(pair[1]));
                corners.join(a, c);
                corners.join(b, d);
            }
        }
        let mut fans = vec![0; self.vertices().len()];
        for (&vertex, corner) in faces.as_flattened().iter().zip(0..) {
            if corners.find(corner) == corner {
                fans[vertex as usize] += 1;
            }
        }
        fans
    }
}
