//! Joins the primitives of a file into one mesh.

use super::super::super::has_corner_twice;
use super::super::super::vector::bits;
use super::super::attributes::{Attribute, MeshFile};
use super::super::draft::{Checked, Draft, Numbers};
use super::super::labels::{Labels, clean_name};
use super::document::Document;
use catamaran::base::{Result, push, reserved, room};

/// For each face, the indices of the values of its corners.
type Corners = Vec<[u32; 3]>;

/// A corner without a value.
const ABSENT: u32 = u32::MAX;

/// Values of vertices that have them; empty until a vertex has one, and not longer than up to the
/// last such vertex.
pub(super) struct Values<const N: usize>(Vec<Option<[f64; N]>>);

impl<const N: usize> Default for Values<N> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<const N: usize> Values<N> {
    /// Adds the values of the vertices from number `first` on.
    pub fn add(
        &mut self,
        first: usize,
        values: impl ExactSizeIterator<Item = [f64; N]>,
    ) -> Result<()> {
        if values.len() == 0 {
            return Ok(());
        }
        let more = (first - self.0.len()) + values.len();
        room(&mut self.0, more)?;
        self.0.resize(first, None);
        self.0.extend(values.map(Some));
        Ok(())
    }

    fn of(&self, vertex: usize) -> Option<[f64; N]> {
        self.0.get(vertex).copied().flatten()
    }
}

/// The faces from a number on, which are those of a primitive.
struct Run {
    start: usize,
    material: u32,
    place: String,
}

/// The parts of the mesh that were read so far. Vertices are those of glTF, with one value of each
/// attribute.
#[derive(Default)]
pub(super) struct Assembly {
    pub draft: Draft,
    pub positions: Vec<[f64; 3]>,
    pub normals: Values<3>,
    pub uv: Values<2>,
    pub colors: Values<4>,
    pub faces: Vec<[u32; 3]>,
    runs: Vec<Run>,
    /// The first vertex of each mesh.
    meshes: Vec<usize>,
    /// Number of primitives of points, and the place of the first.
    points: (usize, String),
}

impl Assembly {
    /// Starts another mesh, to which the following vertices belong.
    pub fn begin_mesh(&mut self) {
        self.meshes.push(self.positions.len());
    }

    /// Adds vertices with these positions; their other values are added apart.
    pub fn add_vertices(&mut self, mut positions: Vec<[f64; 3]>) -> Result<()> {
        if self.positions.is_empty() {
            self.positions = positions;
            return Ok(());
        }
        room(&mut self.positions, positions.len())?;
        self.positions.append(&mut positions);
        Ok(())
    }

    /// Records a primitive of points, whose vertices are already there.
    pub fn points(&mut self, place: &dyn Fn() -> String) {
        if self.points.0 == 0 {
            self.points.1 = place();
        }
        self.points.0 += 1;
    }

    /// Adds the faces of a primitive.
    pub fn add_faces(
        &mut self,
        faces: impl ExactSizeIterator<Item = [u32; 3]>,
        material: Option<usize>,
        place: &dyn Fn() -> String,
    ) -> Result<()> {
        if faces.len() == 0 {
            return Ok(());
        }
        let material = material.and_then(|number| u32::try_from(number).ok()).unwrap_or(ABSENT);
        push(&mut self.runs, Run { start: self.faces.len(), material, place: place() })?;
        room(&mut self.faces, faces.len())?;
        self.faces.extend(faces);
        Ok(())
    }

    /// Returns the mesh. Vertices of a mesh that have the same position and colour become one: glTF
    /// has copies of a vertex where a texture is cut or a normal is not continuous.
    pub fn finish(mut self, document: &Document) -> Checked<MeshFile> {
        let colored = !self.colors.0.is_empty();
        // White, the default of renderers.
        let color = |i: usize| self.colors.of(i).unwrap_or([1.0; 4]);
        let mut colors = Vec::new();
        let mut numbers = reserved(self.positions.len())?;
        let vertices = &mut self.positions;
        let total = vertices.len();
        // Vertices that are known take the places of copies before them.
        let mut count = 0;
        let ends = self.meshes.iter().copied().skip(1).chain([total]);
        for (start, end) in self.meshes.iter().copied().zip(ends) {
            let base = count;
            let mut known = Numbers::default();
            for i in start..end {
                let position = vertices[i];
                let is_same = |k: usize| vertices[base + k] == position;
                let (number, is_new) = if colored {
                    let own = color(i);
                    let words = bits(position).into_iter().chain(bits(own));
                    known.of(words, |k| is_same(k) && colors[base + k] == own)?
                } else {
                    known.of(bits(position), is_same)?
                };
                numbers.push(base as u32 + number);
                if is_new {
                    vertices[count] = position;
                    count += 1;
                    if colored {
                        push(&mut colors, color(i))?;
                    }
                }
            }
        }
        vertices.truncate(count);
        let joined = total - count;
        let what = "joined vertices with others at the same position (copies along seams)";
        let copy = numbers.iter().enumerate().position(|(i, &number)| i != number as usize);
        self.draft.notes.add_many(what, joined, || format!("vertex {}", copy.unwrap_or_default()));

        let (uv, mut uv_corners) = values(&self.faces, &numbers, joined > 0, &self.uv)?;
        let (normals, mut normal_corners) =
            values(&self.faces, &numbers, joined > 0, &self.normals)?;
        if joined > 0 {
            self.faces.iter_mut().for_each(|face| *face = face.map(|v| numbers[v as usize]));
        }
        drop(numbers);
        if let Some(first) = self.faces.iter().position(has_corner_twice) {
            let run = self.runs.partition_point(|run| run.start <= first) - 1;
            self.draft.collapse(|| self.runs[run].place.clone());
        }
        let mut materials = Vec::new();
        if self.runs.iter().any(|run| run.material != ABSENT) {
            materials = reserved(self.faces.len())?;
            let ends = self.runs.iter().map(|run| run.start).skip(1).chain([self.faces.len()]);
            self.runs.iter().zip(ends).for_each(|(run, end)| materials.resize(end, run.material));
        }
        self.draft.vertices = self.positions;
        self.draft.faces = self.faces;
        // Points alone are the vertices of a mesh without faces.
        if !self.draft.faces.is_empty() {
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
        let mut file = self.draft.finish(corners, &mut [&mut materials])?;
        if !uv.is_empty() {
            file.uv = Some(Attribute::simplified(uv, uv_corners, &file.mesh));
        }
        if !normals.is_empty() {
            file.normals = Some(Attribute::simplified(normals, normal_corners, &file.mesh));
        }
        file.colors = colored.then_some(colors);
        file.materials = labels(materials, document)?;
        Ok(file)
    }
}

/// Returns an attribute with each value of a vertex once, and for each face the indices of the
/// values of its corners; [`ABSENT`] where there is no value. Vertices with the same entry of
/// `numbers` are one vertex; if none are, `is_joined` is false.
fn values<const N: usize>(
    faces: &[[u32; 3]],
    numbers: &[u32],
    is_joined: bool,
    given: &Values<N>,
) -> Checked<(Vec<[f64; N]>, Corners)> {
    if given.0.is_empty() {
        return Ok((Vec::new(), Vec::new()));
    }
    let mut known = Numbers::default();
    // The values, and the vertex of each.
    let mut values: Vec<[f64; N]> = Vec::new();
    let mut owners = Vec::new();
    let mut of_vertices = reserved(numbers.len())?;
    for (i, &vertex) in numbers.iter().enumerate() {
        let Some(value) = given.of(i) else {
            of_vertices.push(ABSENT);
            continue;
        };
        // Vertices that are not joined have no value in common.
        let (number, is_new) = if is_joined {
            let own = bits(value);
            let words = own.into_iter().chain([u64::from(vertex)]);
            known.of(words, |k| owners[k] == vertex && bits(values[k]) == own)?
        } else {
            (values.len() as u32, true)
        };
        if is_new {
            push(&mut values, value)?;
            if is_joined {
                push(&mut owners, vertex)?;
            }
        }
        of_vertices.push(number);
    }
    let mut corners = Vec::new();
    if !values.is_empty() {
        corners = reserved(faces.len())?;
        corners.extend(faces.iter().map(|face| {
            let face = face.map(|v| of_vertices[v as usize]);
            if face.contains(&ABSENT) { [ABSENT; 3] } else { face }
        }));
    }
    Ok((values, corners))
}

/// Returns the materials of faces; the list is empty where no face has one.
fn labels(of_faces: Vec<u32>, document: &Document) -> Checked<Option<Labels>> {
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
