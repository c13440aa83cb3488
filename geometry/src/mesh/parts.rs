//! Parts of meshes, as meshes of their own.

use super::{Components, TriMesh};
use catamaran::base::{Error, Result};

/// A part of a mesh, with vertices and faces in the order of the mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    /// The part.
    pub mesh: TriMesh,
    /// For each vertex of the part, its number in the mesh.
    pub vertices: Vec<u32>,
    /// For each face of the part, its number in the mesh.
    pub faces: Vec<u32>,
}

impl TriMesh {
    /// Returns the part of these faces, in the order of the mesh, with the vertices that they use.
    ///
    /// ```
    /// use catamaran_geometry::mesh::families;
    ///
    /// let part = families::grid(1, 2)?.submesh(&[2, 3])?;
    /// assert_eq!(part.mesh.faces().len(), 2);
    /// assert_eq!(part.vertices.len(), 4);
    /// assert_eq!(part.faces, [2, 3]);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Argument`] for a face that does not exist or that is given twice.
    pub fn submesh(&self, faces: &[u32]) -> Result<Part> {
        let n = self.faces().len();
        let mut wanted = vec![false; n];
        for &f in faces {
            let refused = |why| Err(Error::Argument { what: "faces", why });
            match wanted.get_mut(f as usize) {
                None => {
                    return refused(format!(
                        "face {f} is out of range: {n} faces, numbered from 0"
                    ));
                }
                Some(true) => return refused(format!("face {f} is given twice")),
                Some(wanted) => *wanted = true,
            }
        }
        Ok(self.part(|f| wanted[f as usize]))
    }

    /// Returns component number `component` of `components`, which must be those of this mesh.
    ///
    /// ```
    /// use catamaran_geometry::mesh::{Components, families};
    ///
    /// let two = families::spheres(2, 0)?;
    /// let second = two.component(&Components::new(&two), 1)?;
    /// assert_eq!((second.mesh.vertices().len(), second.vertices[0]), (12, 12));
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Argument`] when the component does not exist, or `components` are those of another
    /// mesh.
    pub fn component(&self, components: &Components, component: usize) -> Result<Part> {
        let own = components.of_faces();
        if component >= components.len() || own.len() != self.faces().len() {
            return Err(Error::Argument {
                what: "component",
                why: format!(
                    "{component} is not one of the {} components of this mesh (numbered from 0)",
                    components.len()
                ),
            });
        }
        Ok(self.part(|f| own[f as usize] as usize == component))
    }

    /// Returns the mesh without the vertices that no face has.
    ///
    /// ```
    /// use catamaran_geometry::mesh::TriMesh;
    ///
    /// let vertices = vec![[9.0; 3], [0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    /// let part = TriMesh::new(vertices, vec![[1, 2, 3]])?.without_unreferenced();
    /// assert_eq!((part.mesh.faces(), part.vertices), (&[[0, 1, 2]][..], vec![1, 2, 3]));
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    pub fn without_unreferenced(&self) -> Part {
        self.part(|_| true)
    }

    /// Returns the part of the wanted faces.
    fn part(&self, wanted: impl Fn(u32) -> bool) -> Part {
        let faces: Vec<u32> = (0..self.faces().len() as u32).filter(|&f| wanted(f)).collect();
        let mut number = vec![u32::MAX; self.vertices().len()];
        for &f in &faces {
            for v in self.faces()[f as usize] {
                number[v as usize] = 0;
            }
        }
        let mut vertices = Vec::new();
        for (v, number) in (0..).zip(&mut number) {
            if *number == 0 {
                *number = vertices.len() as u32;
                vertices.push(v);
            }
        }
        let positions = vertices.iter().map(|&v: &u32| self.vertices()[v as usize]).collect();
        let numbered =
            faces.iter().map(|&f| self.faces()[f as usize].map(|v| number[v as usize])).collect();
        Part { mesh: TriMesh::of_valid(positions, numbered), vertices, faces }
    }
}
