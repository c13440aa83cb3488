//! Khronos glTF 2.0: the triangles of a scene, in JSON and binary.
//!
//! In glTF, texture coordinates count from the top; in other formats, from the bottom. They are
//! flipped on reading and writing.

mod accessor;
mod assembly;
mod container;
mod document;
mod encoding;
mod material;
mod picture;
mod transform;
mod write;

use self::accessor::width;
use self::assembly::{Assembly, Vertex};
use self::container::Content;
use self::document::{Primitive, code};
use self::transform::Transform;
use super::attributes::MeshFile;
use super::draft::Checked;
use super::polygon::fan;
use crate::base::Result;
use crate::io::Source;

pub use self::encoding::GltfEncoding;
pub use self::material::Material;
pub use self::picture::Picture;
pub(super) use self::write::{write, write_with_material};

/// Bytes of memory for each vertex while meshes are joined.
type VertexMemory = [u8; 400];

pub(super) fn read(source: &mut Source<'_>) -> Result<MeshFile> {
    let read = |source: &mut Source<'_>| -> Checked<MeshFile> {
        let content = Content::read(source)?;
        let mut reader = Reader { content: &content, source, assembly: Assembly::default() };
        reader.scene()?;
        reader.assembly.finish(&content.document)
    };
    read(source).map_err(|fault| fault.at(source))
}

struct Reader<'c, 's, 'a> {
    content: &'c Content,
    source: &'s Source<'a>,
    assembly: Assembly,
}

impl Reader<'_, '_, '_> {
    /// Reads the meshes of the scene with the transformations of its nodes; reads all meshes where
    /// there is no scene.
    fn scene(&mut self) -> Checked<()> {
        let document = &self.content.document;
        let scene = match document.scene {
            Some(i) => Some(document.scenes.get(i).ok_or_else(|| format!("no scene {i}"))?),
            None => document.scenes.first(),
        };
        let Some(scene) = scene else {
            return (0..document.meshes.len())
                .try_for_each(|mesh| self.mesh(mesh, &Transform::IDENTITY));
        };
        let mut seen = vec![false; document.nodes.len()];
        let mut next: Vec<(usize, Transform)> =
            scene.nodes.iter().rev().map(|&node| (node, Transform::IDENTITY)).collect();
        while let Some((index, parent)) = next.pop() {
            let node = document.nodes.get(index).ok_or_else(|| format!("no node {index}"))?;
            // A node with two parents is an error: without this check, nodes could be visited
            // without end.
            if std::mem::replace(&mut seen[index], true) {
                return Err(format!("node {index} has two parents").into());
            }
            let transform = parent.after(&Transform::of(node));
            if let Some(mesh) = node.mesh {
                self.mesh(mesh, &transform)?;
            }
            next.extend(node.children.iter().rev().map(|&child| (child, transform)));
        }
        Ok(())
    }

    fn mesh(&mut self, index: usize, transform: &Transform) -> Checked<()> {
        let content = self.content;
        let mesh = content.document.meshes.get(index).ok_or_else(|| format!("no mesh {index}"))?;
        self.assembly.begin_mesh();
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            let place = || format!("mesh {index}, primitive {p}");
            let read = self.primitive(primitive, transform, &place);
            read.map_err(|fault| fault.of(place))?;
        }
        Ok(())
    }

    fn primitive(
        &mut self,
        primitive: &Primitive,
        transform: &Transform,
        place: &dyn Fn() -> String,
    ) -> Checked<()> {
        let mode = primitive.mode.unwrap_or(code::TRIANGLES);
        let triangles = [code::TRIANGLES, code::TRIANGLE_STRIP, code::TRIANGLE_FAN].contains(&mode);
        // A primitive of points may hold the vertices of a mesh without faces.
        if !triangles && mode != code::POINTS {
            self.assembly.draft.notes.add("left out primitives of lines", place);
            return Ok(());
        }
        let Some(positions) = primitive.attributes.position else {
            self.assembly.draft.notes.add("left out primitives without positions", place);
            return Ok(());
        };
        let first = self.vertices(primitive, positions, transform, place)?;
        if !triangles {
            return Ok(());
        }
        let vertices = self.assembly.vertices.len() - first as usize;
        let corners: Vec<u32> = match primitive.indices {
            Some(indices) => {
                self.check_room(self.content.accessor(indices)?.count)?;
                let inside = |[number]: [f64; 1]| {
                    let known = number >= 0.0 && number < vertices as f64;
                    if known { Ok(first + number as u32) } else { Err(number) }
                };
                let found = self.content.values::<1>(indices)?.into_iter().map(inside);
                let found: std::result::Result<Vec<u32>, f64> = found.collect();
                found.map_err(|number| {
                    format!("vertex {number} is out of range: {vertices} vertices")
                })?
            }
            None => (first..first + vertices as u32).collect(),
        };
        let corners = match mode {
            code::TRIANGLES => {
                let (triangles, rest) = corners.as_chunks::<3>();
                if !rest.is_empty() {
                    return Err(format!("{} corners are no triangles", corners.len()).into());
                }
                triangles.to_vec()
            }
            code::TRIANGLE_STRIP => {
                let turned = |(i, t): (usize, &[u32])| {
                    if i % 2 == 0 { [t[0], t[1], t[2]] } else { [t[1], t[0], t[2]] }
                };
                corners.windows(3).enumerate().map(turned).collect()
            }
            _ => fan(&corners).collect(),
        };
        for [a, b, c] in corners {
            let face = if transform.is_mirrored() { [a, c, b] } else { [a, b, c] };
            self.assembly.push_face(face, primitive.material, place)?;
        }
        Ok(())
    }

    /// Adds the vertices of a primitive. Returns the number of the first one.
    fn vertices(
        &mut self,
        primitive: &Primitive,
        positions: usize,
        transform: &Transform,
        place: &dyn Fn() -> String,
    ) -> Checked<u32> {
        let content = self.content;
        let count = content.accessor(positions)?.count;
        self.check_room(count)?;
        let attributes = &primitive.attributes;
        for attribute in [attributes.normal, attributes.uv, attributes.color].into_iter().flatten()
        {
            let given = content.accessor(attribute)?.count;
            if given != count {
                return Err(format!("an attribute has {given} values, not {count}").into());
            }
        }
        let positions = content.values::<3>(positions)?;
        let normals = attributes.normal.map(|i| content.values::<3>(i)).transpose()?;
        let uv = attributes.uv.map(|i| content.values::<2>(i)).transpose()?;
        let colors = attributes.color.map(|i| self.colors(i)).transpose()?;
        let assembly = &mut self.assembly;
        let first = u32::try_from(assembly.vertices.len()).ok();
        let first = first.filter(|first| first.checked_add(count as u32).is_some());
        let first = first.ok_or("more than 2^32 vertices")?;
        for (i, position) in positions.into_iter().enumerate() {
            let position = transform.point(position);
            if position.iter().any(|x| !x.is_finite()) {
                return Err(format!("vertex {i}: position {position:?} is not finite").into());
            }
            let normal = normals.as_ref().and_then(|normals| normals.get(i)).copied();
            let normal = normal.map(|n| assembly.draft.finite(n, place));
            let uv = uv.as_ref().and_then(|uv| uv.get(i)).copied();
            let uv = uv.map(|uv| assembly.draft.finite(uv, place));
            let color = colors.as_ref().and_then(|colors| colors.get(i)).copied();
            let color = color.map(|color| assembly.draft.finite(color, place));
            assembly.push_vertex(Vertex {
                position,
                normal: normal.map(|n| transform.normal(n)),
                uv: uv.map(|[u, v]| [u, 1.0 - v]),
                color,
            })?;
        }
        Ok(first)
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
        let so_far = self.assembly.vertices.len() + self.assembly.faces.len();
        self.source.check_memory::<VertexMemory>("the meshes", so_far.saturating_add(more))
    }
}
