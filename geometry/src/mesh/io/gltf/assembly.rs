//! Joins the primitives of a file into one mesh.

use super::super::super::has_corner_twice;
use super::super::attributes::{Attribute, MeshFile};
use super::super::draft::{Checked, Draft, Numbers, bits};
use super::super::labels::{Labels, clean_name};
use super::document::Document;
use catamaran::base::{Result, push};

/// For each face, the indices of the values of its corners.
type Corners = Vec<[u32; 3]>;

/// A corner without a value.
const ABSENT: u32 = u32::MAX;

/// A vertex of glTF, with one value of each attribute.
pub(super) struct Vertex {
    pub position: [f64; 3],
    pub normal: Option<[f64; 3]>,
    pub uv: Option<[f64; 2]>,
    pub color: Option<[f64; 4]>,
}

/// The parts of the mesh that were read so far.
#[derive(Default)]
pub(super) struct Assembly {
    pub draft: Draft,
    pub vertices: Vec<Vertex>,
    pub faces: Vec<[u32; 3]>,
    materials: Vec<u32>,
    /// The first vertex of each mesh.
    meshes: Vec<usize>,
    /// Number of primitives of points, and the place of the first.
    points: (usize, String),
}

impl Assembly {
    /// Starts another mesh, to which the following vertices belong.
    pub fn begin_mesh(&mut self) {
        self.meshes.push(self.vertices.len());
    }

    /// Adds a vertex.
    pub fn push_vertex(&mut self, vertex: Vertex) -> Result<()> {
        push(&mut self.vertices, vertex)
    }

    /// Records a primitive of points, whose vertices are already there.
    pub fn points(&mut self, place: &dyn Fn() -> String) {
        if self.points.0 == 0 {
            self.points.1 = place();
        }
        self.points.0 += 1;
    }

    /// Adds a face.
    pub fn push_face(
        &mut self,
        face: [u32; 3],
        material: Option<usize>,
        place: &dyn Fn() -> String,
    ) -> Result<()> {
        push(&mut self.faces, face)?;
        let material = material.and_then(|number| u32::try_from(number).ok());
        push(&mut self.materials, material.unwrap_or(ABSENT))?;
        // The vertices are renumbered when all are known.
        if has_corner_twice(&face.map(|v| self.vertices[v as usize].position)) {
            self.draft.collapse(place);
        }
        Ok(())
    }

    /// Returns the mesh. Vertices of a mesh that have the same position and colour become one: glTF
    /// has copies of a vertex where a texture is cut or a normal is not continuous.
    pub fn finish(mut self, document: &Document) -> Checked<MeshFile> {
        let colored = self.vertices.iter().any(|vertex| vertex.color.is_some());
        let mut colors = Vec::new();
        let mut known = Numbers::default();
        let mut numbers = Vec::new();
        let mut meshes = self.meshes.iter().enumerate().peekable();
        let mut mesh = 0;
        for (i, vertex) in self.vertices.iter().enumerate() {
            while let Some((number, _)) = meshes.next_if(|(_, start)| **start <= i) {
                mesh = number;
            }
            // White, the default of renderers.
            let color = vertex.color.unwrap_or([1.0; 4]);
            let (number, is_new) = known.of((mesh, bits(vertex.position), bits(color)))?;
            push(&mut numbers, number)?;
            if is_new {
                self.draft.push_vertex(vertex.position)?;
                if colored {
                    push(&mut colors, color)?;
                }
            }
        }
        let joined = self.vertices.len() - self.draft.vertices.len();
        let what = "joined vertices with others at the same position (copies along seams)";
        let copy = numbers.iter().enumerate().position(|(i, &number)| i != number as usize);
        self.draft.notes.add_many(what, joined, || format!("vertex {}", copy.unwrap_or_default()));

        let faces = &self.faces;
        let (uv, mut uv_corners) = values(faces, &numbers, self.vertices.iter().map(|v| v.uv))?;
        let (normals, mut normal_corners) =
            values(faces, &numbers, self.vertices.iter().map(|v| v.normal))?;
        for face in faces {
            push(&mut self.draft.faces, face.map(|v| numbers[v as usize]))?;
        }
        // Points alone are the vertices of a mesh without faces.
        if !faces.is_empty() {
            let what = "read points as vertices without a face: primitives";
            self.draft.notes.add_many(what, self.points.0, || self.points.1.clone());
        }
        for (what, name, count) in [
            ("left out textures", "texture 0", document.textures.len()),
            ("left out animations", "animation 0", document.animations.len()),
        ] {
            self.draft.notes.add_many(what, count, || name.into());
        }
        let mut rich = document.materials.iter().enumerate().filter(|(_, m)| !m.others.is_empty());
        if let Some((first, _)) = rich.next() {
            let what = "left out properties of materials, of which the names are kept";
            self.draft.notes.add_many(what, 1 + rich.count(), || format!("material {first}"));
        }
        let corners = &mut [&mut uv_corners, &mut normal_corners];
        let mut file = self.draft.finish(corners, &mut [&mut self.materials])?;
        if !uv.is_empty() {
            file.uv = Some(Attribute::simplified(uv, uv_corners, &file.mesh));
        }
        if !normals.is_empty() {
            file.normals = Some(Attribute::simplified(normals, normal_corners, &file.mesh));
        }
        file.colors = colored.then_some(colors);
        file.materials = materials(self.materials, document)?;
        Ok(file)
    }
}

/// Returns an attribute with each value of a vertex once, and for each face the indices of the
/// values of its corners; [`ABSENT`] where there is no value. Vertices with the same entry of
/// `numbers` are one vertex.
fn values<const N: usize>(
    faces: &[[u32; 3]],
    numbers: &[u32],
    given: impl Iterator<Item = Option<[f64; N]>>,
) -> Checked<(Vec<[f64; N]>, Corners)> {
    let mut known = Numbers::default();
    let mut values = Vec::new();
    let mut of_vertices = Vec::new();
    for (value, &vertex) in given.zip(numbers) {
        let number = match value {
            None => ABSENT,
            Some(value) => {
                let (number, is_new) = known.of((vertex, bits(value)))?;
                if is_new {
                    push(&mut values, value)?;
                }
                number
            }
        };
        push(&mut of_vertices, number)?;
    }
    let mut corners = Vec::new();
    if !values.is_empty() {
        for face in faces {
            let face = face.map(|v| of_vertices[v as usize]);
            push(&mut corners, if face.contains(&ABSENT) { [ABSENT; 3] } else { face })?;
        }
    }
    Ok((values, corners))
}

fn materials(of_faces: Vec<u32>, document: &Document) -> Checked<Option<Labels>> {
    let count = document.materials.len();
    if let Some(&wrong) = of_faces.iter().find(|&&m| m != ABSENT && m as usize >= count) {
        return Err(format!("material {wrong} is out of range: {count} materials").into());
    }
    if of_faces.iter().all(|&material| material == ABSENT) {
        return Ok(None);
    }
    let name = |(i, given): (usize, &str)| match clean_name(given) {
        name if name.is_empty() => format!("material {i}"),
        name => name,
    };
    let names = document.materials.iter().map(|material| &material.name[..]);
    Ok(Some(Labels { names: names.enumerate().map(name).collect(), of_faces }))
}
