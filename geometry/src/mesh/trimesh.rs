use catamaran::base::{Error, Result};

/// A triangle mesh: positions of vertices, and faces of three vertices each.
///
/// Any set of triangles is allowed: several components, boundary, edges of three faces,
/// unreferenced vertices and faces without area. Functions that can't handle one of these return an
/// error that names it.
///
/// ```
/// use catamaran_geometry::mesh::{Edges, TriMesh};
///
/// let vertices = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
/// let faces = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
/// let mesh = TriMesh::new(vertices, faces)?;
/// let edges = Edges::new(&mesh);
/// mesh.require_closed()?;
/// assert_eq!(mesh.euler_characteristic(&edges), 2);
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct TriMesh {
    vertices: Vec<[f64; 3]>,
    faces: Vec<[u32; 3]>,
}

impl TriMesh {
    /// Creates a mesh of these positions and faces (three indices of vertices, from 0,
    /// counter-clockwise as seen from outside).
    ///
    /// # Errors
    /// [`Error::Mesh`] names a coordinate that is not finite, a face with an index out of range or
    /// with the same index twice; [`Error::Argument`] if there are 2^32 vertices or corners of
    /// faces, or more.
    pub fn new(vertices: Vec<[f64; 3]>, faces: Vec<[u32; 3]>) -> Result<Self> {
        if u32::try_from(vertices.len()).is_err() {
            return Err(Error::Argument {
                what: "vertices",
                why: format!("at most 2^32 - 1 are possible, got {}", vertices.len()),
            });
        }
        if u32::try_from(faces.len().saturating_mul(3)).is_err() {
            return Err(Error::Argument {
                what: "faces",
                why: format!("at most (2^32 - 1) / 3 are possible, got {}", faces.len()),
            });
        }
        let refused = |what: String, element: String| Err(Error::Mesh { what, element });
        if let Some(v) = vertices.iter().position(|p| p.iter().any(|x| !x.is_finite())) {
            return refused(
                format!("position {:?} is not finite", vertices[v]),
                format!("vertex {v}"),
            );
        }
        for (f, face) in faces.iter().enumerate() {
            if let Some(&v) = face.iter().find(|&&v| v as usize >= vertices.len()) {
                let n = vertices.len();
                return refused(
                    format!("vertex {v} is out of range: {n} vertices, numbered from 0"),
                    format!("face {f}"),
                );
            }
            if has_corner_twice(face) {
                return refused(
                    format!("has the same vertex twice: {face:?}"),
                    format!("face {f}"),
                );
            }
        }
        Ok(Self { vertices, faces })
    }

    /// Creates a mesh that [`TriMesh::new`] would accept, without its checks.
    pub(super) fn of_valid(vertices: Vec<[f64; 3]>, faces: Vec<[u32; 3]>) -> Self {
        Self { vertices, faces }
    }

    /// Returns the positions of the vertices.
    pub fn vertices(&self) -> &[[f64; 3]] {
        &self.vertices
    }

    /// Returns the vertices of the faces.
    pub fn faces(&self) -> &[[u32; 3]] {
        &self.faces
    }

    /// Returns the positions and the faces.
    pub fn into_parts(self) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
        (self.vertices, self.faces)
    }
}

/// Returns whether two corners of a triangle, vertices or positions, are the same.
pub(crate) fn has_corner_twice<T: PartialEq>([a, b, c]: &[T; 3]) -> bool {
    a == b || b == c || c == a
}
