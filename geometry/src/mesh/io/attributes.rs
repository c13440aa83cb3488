use super::super::{Part, TriMesh, has_corner_twice};
use super::labels::{Labels, check_name};
use super::notes::{COLLAPSED, Notes};
use catamaran::base::{Error, Result};

/// The content of a mesh file: a mesh with colours, texture coordinates, normals, materials,
/// names of groups and functions on the vertices.
///
/// ```
/// use catamaran_geometry::mesh::{families, io::MeshFile};
///
/// let mut file = MeshFile::from(families::grid(1, 1)?);
/// file.colors = Some(vec![[0.0, 0.5, 1.0, 1.0]; 4]);
/// assert!(file.uv.is_none());
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct MeshFile {
    /// The mesh.
    pub mesh: TriMesh,
    /// Texture coordinates (u, v).
    pub uv: Option<Attribute<2>>,
    /// Normals of any length, as in the file.
    pub normals: Option<Attribute<3>>,
    /// Colours of the vertices: red, green, blue and opacity, usually from 0 to 1.
    pub colors: Option<Vec<[f64; 4]>>,
    /// The material of each face (`usemtl` of OBJ, a material of glTF).
    pub materials: Option<Labels>,
    /// The group of each face (`g` of OBJ).
    pub groups: Option<Labels>,
    /// The object of each face (`o` of OBJ).
    pub objects: Option<Labels>,
    /// Named values of the vertices, such as a thickness (VTK, GIFTI, Gmsh).
    pub scalars: Vec<Scalars>,
    /// The files that describe the materials, as the file names them (`mtllib` of OBJ).
    pub material_files: Vec<String>,
    /// Number of triangles that are left out because two of their corners are one vertex.
    pub collapsed_faces: usize,
    /// The place of the first of these triangles, such as `line 12` or `face 4`; empty without one.
    pub first_collapsed: String,
    /// What the reader left out or replaced, one line each; empty for a mesh that was not read from
    /// a file.
    pub notes: Vec<String>,
}

impl MeshFile {
    /// Creates a mesh of arrays as other programs have them: triangles that have a vertex twice are
    /// left out, counted and noted, as by the readers of files.
    ///
    /// # Errors
    /// Those of [`TriMesh::new`], with the numbers that faces have without these triangles.
    pub fn from_arrays(vertices: Vec<[f64; 3]>, mut faces: Vec<[u32; 3]>) -> Result<Self> {
        let (all, first) = (faces.len(), faces.iter().position(has_corner_twice));
        faces.retain(|face| !has_corner_twice(face));
        let collapsed_faces = all - faces.len();
        let mut notes = Notes::default();
        let first_collapsed = first.map_or_else(String::new, |face| format!("face {face}"));
        notes.add_many(COLLAPSED, collapsed_faces, || first_collapsed.clone());
        let (mesh, notes) = (TriMesh::new(vertices, faces)?, notes.lines());
        Ok(Self { collapsed_faces, first_collapsed, notes, ..mesh.into() })
    }
}

impl From<TriMesh> for MeshFile {
    fn from(mesh: TriMesh) -> Self {
        Self {
            mesh,
            uv: None,
            normals: None,
            colors: None,
            materials: None,
            groups: None,
            objects: None,
            scalars: Vec::new(),
            material_files: Vec::new(),
            collapsed_faces: 0,
            first_collapsed: String::new(),
            notes: Vec::new(),
        }
    }
}

impl MeshFile {
    /// Returns a part of the mesh of this file, with the attributes of the part's vertices, corners
    /// and faces.
    ///
    /// ```
    /// use catamaran_geometry::mesh::{families, io::MeshFile};
    ///
    /// let mesh = families::grid(1, 2)?;
    /// let mut file = MeshFile::from(mesh.clone());
    /// file.colors = Some(vec![[1.0, 0.0, 0.0, 1.0]; mesh.vertices().len()]);
    /// let half = file.part(mesh.submesh(&[2, 3])?)?;
    /// assert_eq!(half.colors.unwrap().len(), 4);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Shape`] and [`Error::Argument`] when attributes do not fit the mesh,
    /// [`Error::Argument`] when the part is of another mesh.
    pub fn part(&self, part: Part) -> Result<MeshFile> {
        self.check()?;
        let (vertices, faces) = (self.mesh.vertices().len(), self.mesh.faces().len());
        let beyond = |numbers: &[u32], len: usize| numbers.iter().any(|&i| i as usize >= len);
        if beyond(&part.vertices, vertices) || beyond(&part.faces, faces) {
            let why = format!("is not part of this mesh of {vertices} vertices and {faces} faces");
            return Err(Error::Argument { what: "part", why });
        }
        let colors = self.colors.as_ref();
        Ok(MeshFile {
            uv: self.uv.as_ref().map(|uv| uv.part(&part)),
            normals: self.normals.as_ref().map(|normals| normals.part(&part)),
            colors: colors.map(|all| part.vertices.iter().map(|&v| all[v as usize]).collect()),
            materials: self.materials.as_ref().map(|labels| labels.part(&part)),
            groups: self.groups.as_ref().map(|labels| labels.part(&part)),
            objects: self.objects.as_ref().map(|labels| labels.part(&part)),
            scalars: self.scalars.iter().map(|s| s.at(&part.vertices)).collect(),
            material_files: self.material_files.clone(),
            collapsed_faces: self.collapsed_faces,
            first_collapsed: self.first_collapsed.clone(),
            notes: self.notes.clone(),
            mesh: part.mesh,
        })
    }

    /// Returns the file without the vertices that are in no face.
    pub(super) fn without_lone_vertices(&self) -> Result<MeshFile> {
        let faces: Vec<u32> = (0..self.mesh.faces().len() as u32).collect();
        self.part(self.mesh.submesh(&faces)?)
    }

    /// Returns an error unless the attributes fit the mesh.
    pub(crate) fn check(&self) -> Result<()> {
        let vertices = self.mesh.vertices().len();
        if let Some(colors) = &self.colors {
            Error::check_shape("colors", (vertices, 4), (colors.len(), 4))?;
        }
        if let Some(uv) = &self.uv {
            uv.check("uv", &self.mesh)?;
        }
        if let Some(normals) = &self.normals {
            normals.check("normals", &self.mesh)?;
        }
        for (what, labels) in
            [("materials", &self.materials), ("groups", &self.groups), ("objects", &self.objects)]
        {
            if let Some(labels) = labels {
                labels.check(what, self.mesh.faces().len())?;
            }
        }
        for Scalars { values, .. } in &self.scalars {
            Error::check_shape("scalars", (vertices, 1), (values.len(), 1))?;
        }
        self.material_files.iter().try_for_each(|name| check_name("material_files", name))
    }

    /// Returns an error unless every number of the attributes is finite: other programs stop at
    /// the text NaN.
    pub(super) fn check_finite(&self) -> Result<()> {
        fn check<const N: usize>(what: &'static str, values: Option<&[[f64; N]]>) -> Result<()> {
            let numbers = values.unwrap_or_default().as_flattened();
            match numbers.iter().position(|x| !x.is_finite()) {
                Some(i) => Err(Error::NonFinite { what, index: (i / N, i % N) }),
                None => Ok(()),
            }
        }
        check("colors", self.colors.as_deref())?;
        check("uv", self.uv.as_ref().map(|uv| &uv.values[..]))?;
        check("normals", self.normals.as_ref().map(|normals| &normals.values[..]))
    }
}

/// A named function on the vertices of a mesh.
///
/// ```
/// use catamaran_geometry::mesh::families;
/// use catamaran_geometry::mesh::io::{MeshFile, MeshFormat, Scalars, read_bytes, write_bytes};
///
/// let mut file = MeshFile::from(families::grid(1, 1)?);
/// file.scalars = vec![Scalars { name: "height".into(), values: vec![0.5, 1.0, 1.5, 2.0] }];
/// let gifti = MeshFormat::Gifti;
/// assert_eq!(read_bytes(&write_bytes(&file, gifti)?.0, gifti)?.scalars, file.scalars);
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Scalars {
    /// The name, as in the file.
    pub name: String,
    /// The value of each vertex; NaN where there is none.
    pub values: Vec<f64>,
}

impl Scalars {
    /// Returns the columns of a matrix with `width` values for each vertex. Several have their
    /// number, from 0, after the name.
    pub(super) fn columns(name: &str, width: usize, values: &[f64]) -> Vec<Self> {
        let column = |k: usize| Self {
            name: if width == 1 { name.into() } else { format!("{name}.{k}") },
            values: values.iter().skip(k).step_by(width).copied().collect(),
        };
        (0..width).map(column).collect()
    }

    /// Returns the values at these vertices.
    pub(crate) fn at(&self, vertices: &[u32]) -> Self {
        let values = vertices.iter().map(|&v| self.values[v as usize]).collect();
        Self { name: self.name.clone(), values }
    }
}

/// Values of the vertices of a mesh, or of the corners of its faces: at a cut of a texture, a
/// vertex has several values.
#[derive(Debug, Clone, PartialEq)]
pub struct Attribute<const N: usize> {
    /// The values.
    pub values: Vec<[f64; N]>,
    /// For each face, the indices of the values of its corners, all three [`Attribute::ABSENT`] if
    /// the face has none. `None` when the values are those of the vertices.
    pub corners: Option<Vec<[u32; 3]>>,
}

impl<const N: usize> Attribute<N> {
    /// The index of an absent value.
    pub const ABSENT: u32 = u32::MAX;

    /// Returns the values of the corners of face f of `mesh`; `None` when the face has none.
    pub fn of_face(&self, mesh: &TriMesh, f: usize) -> Option<[[f64; N]; 3]> {
        let numbers = self.corners.as_deref().unwrap_or(mesh.faces()).get(f)?;
        let [a, b, c] = numbers.map(|i| self.values.get(i as usize).copied());
        Some([a?, b?, c?])
    }

    /// Returns the values of the vertices; `None` when the values belong to corners.
    pub fn of_vertices(&self) -> Option<&[[f64; N]]> {
        if self.corners.is_none() { Some(&self.values) } else { None }
    }

    /// Returns the attribute of a part of the mesh.
    fn part(&self, part: &Part) -> Self {
        let Some(corners) = &self.corners else {
            let values = part.vertices.iter().map(|&v| self.values[v as usize]).collect();
            return Self { values, corners: None };
        };
        let mut corners: Vec<[u32; 3]> = part.faces.iter().map(|&f| corners[f as usize]).collect();
        let mut number = vec![Self::ABSENT; self.values.len()];
        for &i in corners.as_flattened().iter().filter(|i| **i != Self::ABSENT) {
            number[i as usize] = 0;
        }
        let mut values = Vec::new();
        for (number, value) in number.iter_mut().zip(&self.values).filter(|(n, _)| **n == 0) {
            *number = values.len() as u32;
            values.push(*value);
        }
        for i in corners.as_flattened_mut().iter_mut().filter(|i| **i != Self::ABSENT) {
            *i = number[*i as usize];
        }
        Self::simplified(values, corners, &part.mesh)
    }

    /// Returns values of corners as values of vertices if each vertex has only one.
    pub(in super::super) fn simplified(
        values: Vec<[f64; N]>,
        corners: Vec<[u32; 3]>,
        mesh: &TriMesh,
    ) -> Self {
        let by_vertex = values.len() == mesh.vertices().len() && corners == mesh.faces();
        Self { values, corners: if by_vertex { None } else { Some(corners) } }
    }

    fn check(&self, what: &'static str, mesh: &TriMesh) -> Result<()> {
        let Some(corners) = &self.corners else {
            return Error::check_shape(what, (mesh.vertices().len(), N), (self.values.len(), N));
        };
        Error::check_shape(what, (mesh.faces().len(), 3), (corners.len(), 3))?;
        let absent = [Self::ABSENT; 3];
        let wrong =
            |c: &[u32; 3]| *c != absent && c.iter().any(|&i| i as usize >= self.values.len());
        match corners.iter().position(wrong) {
            None => Ok(()),
            Some(f) => Err(Error::Argument {
                what,
                why: format!("face {f} has {:?} of {} values", corners[f], self.values.len()),
            }),
        }
    }
}
