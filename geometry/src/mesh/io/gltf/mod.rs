//! Khronos glTF 2.0: the triangles of a scene, in JSON and binary.
//!
//! In glTF, texture coordinates count from the top; in other formats, from the bottom. They are
//! flipped on reading and writing.

mod accessor;
mod assembly;
mod container;
mod document;
mod draco;
mod encoding;
mod extensions;
mod layout;
mod material;
mod meshopt;
mod picture;
mod scene;
mod transform;
mod write;

use self::assembly::Assembly;
use self::container::Content;
use self::document::{Primitive, code};
use self::layout::width;
use self::scene::Placed;
use super::super::has_corner_twice;
use super::attributes::MeshFile;
use super::draft::Checked;
use super::polygon::fan;
use catamaran::base::Result;
use catamaran::io::Source;

pub use self::encoding::GltfEncoding;
pub use self::material::Material;
pub use self::picture::Picture;
pub(super) use self::transform::Transform;
#[doc(hidden)]
pub use self::write::write_glb;
pub(super) use self::write::{write, write_with_material};

/// Bytes of memory for each vertex while meshes are joined.
type VertexMemory = [u8; 400];

pub(super) fn read(source: &mut Source<'_>) -> Result<MeshFile> {
    let read = |source: &mut Source<'_>| -> Checked<MeshFile> {
        let bytes = source.read_all()?;
        let content = Content::read(&bytes, source)?;
        let mut assembly = Assembly::default();
        extensions::note_left_out(&content.document, &mut assembly.draft.notes);
        let placed = scene::placed(&content, source, &mut assembly.draft.notes)?;
        let mut reader = Reader { content: &content, source, assembly };
        placed.iter().try_for_each(|placed| reader.mesh(placed))?;
        reader.assembly.finish(&content.document)
    };
    read(source).map_err(|fault| fault.at(source))
}

struct Reader<'c, 's, 'a> {
    content: &'c Content<'c>,
    source: &'s Source<'a>,
    assembly: Assembly,
}

impl Reader<'_, '_, '_> {
    /// Reads a mesh with the transformation of its node and the weights of its morph targets.
    fn mesh(&mut self, placed: &Placed<'_>) -> Checked<()> {
        let content = self.content;
        let index = placed.mesh;
        let mesh = content.document.meshes.get(index).ok_or_else(|| format!("no mesh {index}"))?;
        let weights = placed.weights.unwrap_or(&mesh.weights);
        self.assembly.begin_mesh();
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            let place = || format!("mesh {index}, primitive {p}");
            let read = self.primitive(primitive, &placed.transform, weights, &place);
            read.map_err(|fault| fault.of(place))?;
        }
        Ok(())
    }

    fn primitive(
        &mut self,
        primitive: &Primitive,
        transform: &Transform,
        weights: &[f64],
        place: &dyn Fn() -> String,
    ) -> Checked<()> {
        let notes = &mut self.assembly.draft.notes;
        // What Draco packs is triangles, also where they were strips.
        let is_packed = primitive.indices.is_some_and(|i| self.content.decoded.contains_key(&i));
        let mode = if is_packed { None } else { primitive.mode }.unwrap_or(code::TRIANGLES);
        if (code::LINES..=code::LINE_STRIP).contains(&mode) {
            notes.add("left out primitives of lines", place);
            return Ok(());
        }
        if mode > code::TRIANGLE_FAN {
            return Err(format!("unknown mode {mode}").into());
        }
        let Some(positions) = primitive.attributes.position else {
            notes.add("left out primitives without positions", place);
            return Ok(());
        };
        self.note_left_out(primitive, weights, place)?;
        let first = self.vertices(primitive, positions, transform, weights, place)?;
        if mode == code::POINTS {
            self.assembly.points(place);
            return Ok(());
        }
        let vertices = self.assembly.positions.len() - first as usize;
        let content = self.content;
        let numbers = match primitive.indices {
            Some(indices) => {
                self.check_room(content.count(indices)?)?;
                let numbers = content.indices(indices)?;
                if let Some(i) = numbers.iter().position(|&[number]| number as usize >= vertices) {
                    // As the file has it, which may be no index.
                    let [number] = content.values::<1>(indices)?[i];
                    let what = format!("vertex {number} is out of range: {vertices} vertices");
                    return Err(what.into());
                }
                numbers
            }
            None => (0..vertices as u32).map(|number| [number]).collect(),
        };
        let corners = numbers.as_flattened();
        let is_mirrored = transform.is_mirrored();
        let placed = |face: [u32; 3]| {
            let [a, b, c] = face.map(|number| first + number);
            if is_mirrored { [a, c, b] } else { [a, b, c] }
        };
        let faces: Vec<[u32; 3]> = match mode {
            code::TRIANGLES => {
                let (triangles, rest) = corners.as_chunks::<3>();
                let what = "left out corners behind the last triangle of a primitive";
                self.assembly.draft.notes.add_many(what, rest.len(), place);
                let faces = triangles.iter().map(|&face| placed(face));
                return Ok(self.assembly.add_faces(faces, primitive.material, place)?);
            }
            code::TRIANGLE_STRIP => {
                let turned = |(i, t): (usize, &[u32])| {
                    if i % 2 == 0 { [t[0], t[1], t[2]] } else { [t[1], t[0], t[2]] }
                };
                // Strips repeat vertices to change direction; these triangles have no area.
                let all = corners.windows(3).enumerate().map(turned);
                all.filter(|face| !has_corner_twice(face)).collect()
            }
            _ => fan(corners).collect(),
        };
        let faces = faces.into_iter().map(placed);
        Ok(self.assembly.add_faces(faces, primitive.material, place)?)
    }

    /// Adds the vertices of a primitive. Returns the number of the first one.
    fn vertices(
        &mut self,
        primitive: &Primitive,
        positions: usize,
        transform: &Transform,
        weights: &[f64],
        place: &dyn Fn() -> String,
    ) -> Checked<u32> {
        let content = self.content;
        let count = content.count(positions)?;
        self.check_room(count)?;
        let attributes = &primitive.attributes;
        for attribute in [attributes.normal, attributes.uv, attributes.color].into_iter().flatten()
        {
            let given = content.count(attribute)?;
            if given != count {
                return Err(format!("an attribute has {given} values, not {count}").into());
            }
        }
        let mut positions = content.values::<3>(positions)?;
        let mut normals = attributes.normal.map(|i| content.values::<3>(i)).transpose()?;
        let mut uv = attributes.uv.map(|i| content.values::<2>(i)).transpose()?;
        for (target, &weight) in primitive.targets.iter().zip(weights).filter(|(_, w)| **w != 0.0) {
            self.displace(Some(&mut positions), target.position, weight)?;
            self.displace(normals.as_mut(), target.normal, weight)?;
            self.displace(uv.as_mut(), target.uv, weight)?;
        }
        let colors = attributes.color.map(|i| self.colors(i)).transpose()?;
        let assembly = &mut self.assembly;
        let start = assembly.positions.len();
        let first = u32::try_from(start).ok();
        let first = first.filter(|first| first.checked_add(count as u32).is_some());
        let first = first.ok_or("more than 2^32 vertices")?;
        for (i, position) in positions.iter_mut().enumerate() {
            *position = transform.point(*position);
            if position.iter().any(|x| !x.is_finite()) {
                return Err(format!("vertex {i}: position {position:?} is not finite").into());
            }
        }
        assembly.add_vertices(positions)?;
        let draft = &mut assembly.draft;
        if let Some(normals) = normals {
            let moved = |n| transform.normal(draft.finite(n, place));
            assembly.normals.add(start, normals.into_iter().map(moved))?;
        }
        if let Some(uv) = uv {
            let turned = |uv| {
                let [u, v] = draft.finite(uv, place);
                [u, 1.0 - v]
            };
            assembly.uv.add(start, uv.into_iter().map(turned))?;
        }
        if let Some(colors) = colors {
            let finite = |color| draft.finite(color, place);
            assembly.colors.add(start, colors.into_iter().map(finite))?;
        }
        Ok(first)
    }

    /// Adds to values those of a morph target, times its weight.
    fn displace<const N: usize>(
        &self,
        values: Option<&mut Vec<[f64; N]>>,
        target: Option<usize>,
        weight: f64,
    ) -> Checked<()> {
        let (Some(values), Some(target)) = (values, target) else { return Ok(()) };
        let given = self.content.count(target)?;
        if given != values.len() {
            return Err(format!("a morph target has {given} values, not {}", values.len()).into());
        }
        for (value, by) in values.iter_mut().zip(self.content.values::<N>(target)?) {
            (0..N).for_each(|k| value[k] += weight * by[k]);
        }
        Ok(())
    }

    /// Notes what is left out of a primitive; an error if its numbers are in an extension only.
    fn note_left_out(
        &mut self,
        primitive: &Primitive,
        weights: &[f64],
        place: &dyn Fn() -> String,
    ) -> Checked<()> {
        let notes = &mut self.assembly.draft.notes;
        for number in [primitive.attributes.position, primitive.indices].into_iter().flatten() {
            if !self.content.is_stored(number)? {
                let document = &self.content.document;
                let own = &primitive.extensions;
                let packed = own.draco.as_ref().map(|_| draco::NAME);
                if let Some(name) = packed.or_else(|| extensions::source(&own.others, document)) {
                    return Err(extensions::unsupported(name));
                }
                let what = "took 0 for positions and vertex numbers that are not in the file";
                notes.add(what, || format!("accessor {number}"));
            }
        }
        for name in primitive.attributes.others.keys() {
            // Joints and weights belong to a pose, which has a note.
            if !name.starts_with("JOINTS_") && !name.starts_with("WEIGHTS_") {
                notes.add(format!("left out the attribute {name} of primitives"), place);
            }
        }
        let targets = &primitive.targets;
        if weights.len() > targets.len() && !targets.is_empty() {
            let (weights, targets) = (weights.len(), targets.len());
            return Err(format!("{weights} weights of {targets} morph targets").into());
        }
        let weight = |t: usize| weights.get(t).copied().unwrap_or_default();
        let unused = (0..targets.len()).filter(|&t| weight(t) == 0.0).count();
        notes.add_many("left out morph targets, whose weight is 0", unused, place);
        let colors = (0..targets.len()).filter(|&t| weight(t) != 0.0 && targets[t].color.is_some());
        notes.add_many("left out colours of morph targets", colors.count(), place);
        Ok(())
    }

    fn colors(&self, index: usize) -> Checked<Vec<[f64; 4]>> {
        if width(&self.content.accessor(index)?.kind) == Some(4) {
            return self.content.values(index);
        }
        let opaque = |[r, g, b]: [f64; 3]| [r, g, b, 1.0];
        Ok(self.content.values(index)?.into_iter().map(opaque).collect())
    }

    /// Returns an error if `more` vertices or corners would exceed the limit of memory: nodes and
    /// accessors of a small file may repeat the same data many times.
    fn check_room(&self, more: usize) -> Result<()> {
        let so_far = self.assembly.positions.len() + self.assembly.faces.len();
        self.source.check_memory::<VertexMemory>("the meshes", so_far.saturating_add(more))
    }
}
