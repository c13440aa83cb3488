use std::collections::HashMap;
use std::io::{self, Write};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};

use super::super::attributes::MeshFile;
use super::super::colors::byte;
use super::super::labels::Labels;
use super::super::rounding::Rounding;
use super::document::code;
use super::encoding::GltfEncoding;
use super::material::Material;
use super::picture::Picture;

/// A corner without a value.
const ABSENT: u32 = u32::MAX;

/// A vertex of glTF: the indices of its position, texture coordinates and normal.
type Copy = [u32; 3];

pub(in super::super) fn write(
    sink: &mut dyn Write,
    file: &MeshFile,
    encoding: GltfEncoding,
    rounding: &Rounding,
) -> io::Result<()> {
    write_all(sink, file, encoding, rounding, None)
}

/// Writes as [`write()`] does, with this material on all faces.
pub(in super::super) fn write_with_material(
    sink: &mut dyn Write,
    file: &MeshFile,
    encoding: GltfEncoding,
    rounding: &Rounding,
    material: &Material,
) -> io::Result<()> {
    let labels =
        Labels { names: vec![material.name.clone()], of_faces: vec![0; file.mesh.faces().len()] };
    let file = MeshFile { materials: Some(labels), ..file.clone() };
    write_all(sink, &file, encoding, rounding, Some(material))
}

fn write_all(
    sink: &mut dyn Write,
    file: &MeshFile,
    encoding: GltfEncoding,
    rounding: &Rounding,
    material: Option<&Material>,
) -> io::Result<()> {
    let (mut document, bytes) = document(file, rounding, material)?;
    let mut buffer = json!({ "byteLength": bytes.len() });
    if !bytes.is_empty() {
        if encoding == GltfEncoding::Text {
            let data = STANDARD.encode(&bytes);
            buffer["uri"] = format!("data:application/octet-stream;base64,{data}").into();
        }
        document["buffers"] = json!([buffer]);
    }
    match encoding {
        GltfEncoding::Text => {
            serde_json::to_writer(&mut *sink, &document)?;
            writeln!(sink)
        }
        GltfEncoding::Binary => write_glb(sink, serde_json::to_vec(&document)?, bytes),
    }
}

/// Returns the document without its buffer, and the bytes of the buffer.
fn document(
    file: &MeshFile,
    rounding: &Rounding,
    material: Option<&Material>,
) -> io::Result<(Value, Vec<u8>)> {
    let (copies, primitives) = split(file)?;
    let mut numbers = Numbers::default();
    let mut document = json!({
        "asset": { "version": "2.0", "generator": "catamaran" },
        "scene": 0,
        "scenes": [{}],
    });
    if copies.is_empty() {
        return Ok((document, numbers.bytes));
    }
    let primitives = primitives_of(file, rounding, &copies, &primitives, &mut numbers)?;
    document["scenes"] = json!([{ "nodes": [0] }]);
    document["nodes"] = json!([{ "mesh": 0 }]);
    if rounding.origin != [0.0; 3] {
        document["nodes"][0]["translation"] = rounding.origin[..].into();
    }
    document["meshes"] = json!([{ "primitives": primitives }]);
    if let Some(material) = material {
        describe(material, &mut document, &mut numbers)?;
    } else if let Some(materials) = &file.materials {
        let material = |name: &String| json!({ "name": name });
        document["materials"] = materials.names.iter().map(material).collect();
    }
    document["accessors"] = Value::Array(numbers.accessors);
    document["bufferViews"] = Value::Array(numbers.views);
    Ok((document, numbers.bytes))
}

/// Adds a material and its pictures to a document.
fn describe(material: &Material, document: &mut Value, numbers: &mut Numbers) -> io::Result<()> {
    let mut images = Vec::new();
    let described = material.json(&mut |name: &str, picture: &Picture| {
        let view = numbers.picture(picture)?;
        images.push(json!({ "name": name, "mimeType": "image/png", "bufferView": view }));
        Ok(images.len() - 1)
    })?;
    document["materials"] = json!([described]);
    if !images.is_empty() {
        let texture = |source: usize| json!({ "sampler": 0, "source": source });
        document["textures"] = (0..images.len()).map(texture).collect();
        document["samplers"] = json!([{
            "magFilter": code::LINEAR, "minFilter": code::LINEAR_MIPMAP_LINEAR,
            "wrapS": code::REPEAT, "wrapT": code::REPEAT,
        }]);
        document["images"] = Value::Array(images);
    }
    Ok(())
}

/// Writes a document of glTF 2.0, as JSON, and its buffer as the two chunks of a .glb file.
///
/// Public for the animations of the command line, which are documents of another kind.
///
/// # Errors
/// Those of `sink`, and an error when the file would have more than 4 GiB.
#[doc(hidden)]
pub fn write_glb(sink: &mut dyn Write, mut text: Vec<u8>, mut bytes: Vec<u8>) -> io::Result<()> {
    text.resize(text.len().next_multiple_of(4), b' ');
    bytes.resize(bytes.len().next_multiple_of(4), 0);
    let binary = if bytes.is_empty() { 0 } else { 8 + bytes.len() };
    let length = |bytes: usize| {
        let too_large = |_| io::Error::other("more than 4 GiB, which .glb can't hold");
        u32::try_from(bytes).map_err(too_large)
    };
    sink.write_all(b"glTF")?;
    sink.write_all(&2u32.to_le_bytes())?;
    sink.write_all(&length(20 + text.len() + binary)?.to_le_bytes())?;
    sink.write_all(&length(text.len())?.to_le_bytes())?;
    sink.write_all(b"JSON")?;
    sink.write_all(&text)?;
    if !bytes.is_empty() {
        sink.write_all(&length(bytes.len())?.to_le_bytes())?;
        sink.write_all(b"BIN\0")?;
        sink.write_all(&bytes)?;
    }
    Ok(())
}

/// The material and the attributes that the faces of a primitive share.
#[derive(PartialEq, Eq, Hash, Clone)]
struct Kind {
    material: u32,
    has_uv: bool,
    has_normals: bool,
}

/// The faces of a primitive, as indices of copies of vertices, three for each face.
type Primitive = (Kind, Vec<u32>);

/// Returns the vertices, copied where the corners at one vertex have several values, and the faces
/// by kind. The first copy of a vertex has the index of the vertex.
fn split(file: &MeshFile) -> io::Result<(Vec<Copy>, Vec<Primitive>)> {
    let faces = file.mesh.faces();
    let corners = |given: Option<Option<&[[u32; 3]]>>, f: usize| match given {
        None => [ABSENT; 3],
        Some(corners) => corners.unwrap_or(faces)[f],
    };
    let uv = file.uv.as_ref().map(|uv| uv.corners.as_deref());
    let normals = file.normals.as_ref().map(|normals| normals.corners.as_deref());
    // In a mesh without faces, a vertex has the value that belongs to it, if any.
    let alone = |given: Option<Option<&[[u32; 3]]>>, v: u32| match given {
        Some(None) => v,
        _ => ABSENT,
    };
    let count = file.mesh.vertices().len();
    let mut copies: Vec<Copy> =
        (0..count as u32).map(|v| [v, alone(uv, v), alone(normals, v)]).collect();
    let mut used = vec![false; count];
    let mut further: HashMap<Copy, u32> = HashMap::new();
    let mut kinds: HashMap<Kind, usize> = HashMap::new();
    let mut primitives: Vec<Primitive> = Vec::new();
    for (f, face) in faces.iter().enumerate() {
        let (t, n) = (corners(uv, f), corners(normals, f));
        let material = file.materials.as_ref().map_or(ABSENT, |labels| labels.of_faces[f]);
        let has = |corner: u32| corner != ABSENT;
        let kind = Kind { material, has_uv: has(t[0]), has_normals: has(n[0]) };
        let slot = *kinds.entry(kind.clone()).or_insert_with(|| {
            primitives.push((kind, Vec::new()));
            primitives.len() - 1
        });
        for i in 0..3 {
            let copy = [face[i], t[i], n[i]];
            let first = &mut copies[face[i] as usize];
            let number = if !std::mem::replace(&mut used[face[i] as usize], true) || *first == copy
            {
                *first = copy;
                face[i]
            } else {
                let next = copies.len();
                let number = *further.entry(copy).or_insert(next as u32);
                if number as usize == next {
                    copies.push(copy);
                }
                number
            };
            primitives[slot].1.push(number);
        }
        if u32::try_from(copies.len()).is_err() {
            return Err(io::Error::other("more than 2^32 vertices"));
        }
    }
    Ok((copies, primitives))
}

fn primitives_of(
    file: &MeshFile,
    rounding: &Rounding,
    copies: &[Copy],
    primitives: &[Primitive],
    numbers: &mut Numbers,
) -> io::Result<Vec<Value>> {
    let vertices = file.mesh.vertices();
    let positions = copies.iter().map(|copy| rounding.single(vertices[copy[0] as usize]));
    let positions = positions.map(|p| p.map(f64::from));
    let positions = numbers.floats("VEC3", positions, true)?;
    let uv = file.uv.as_ref().map(|uv| {
        let value = |copy: &Copy| uv.values.get(copy[1] as usize).copied().unwrap_or_default();
        numbers.floats("VEC2", copies.iter().map(value).map(|[u, v]| [u, 1.0 - v]), false)
    });
    let normals = file.normals.as_ref().map(|normals| {
        let value = |copy: &Copy| unit(normals.values.get(copy[2] as usize).copied());
        numbers.floats("VEC3", copies.iter().map(value), false)
    });
    let colors = file.colors.as_ref().map(|colors| {
        let bytes = || copies.iter().map(|copy| colors[copy[0] as usize].map(byte));
        if bytes().flatten().all(|byte| byte.is_some()) {
            let content = bytes().flatten().flatten().collect::<Vec<_>>();
            return Ok(numbers.accessor(&content, code::U8, "VEC4", copies.len(), code::VERTICES));
        }
        numbers.floats("VEC4", copies.iter().map(|copy| colors[copy[0] as usize]), false)
    });
    let (uv, normals, colors) = (uv.transpose()?, normals.transpose()?, colors.transpose()?);
    let primitive = |(kind, corners): &Primitive, numbers: &mut Numbers| {
        let mut attributes = json!({ "POSITION": positions });
        let mut attribute = |name: &str, accessor: Option<usize>| {
            if let Some(accessor) = accessor {
                attributes[name] = accessor.into();
            }
        };
        attribute("TEXCOORD_0", uv.filter(|_| kind.has_uv));
        attribute("NORMAL", normals.filter(|_| kind.has_normals));
        attribute("COLOR_0", colors);
        let mut primitive = json!({ "attributes": attributes });
        if corners.is_empty() {
            primitive["mode"] = code::POINTS.into();
            return primitive;
        }
        let bytes: Vec<u8> = corners.iter().flat_map(|number| number.to_le_bytes()).collect();
        let count = corners.len();
        primitive["indices"] =
            numbers.accessor(&bytes, code::U32, "SCALAR", count, code::INDICES).into();
        if kind.material != ABSENT {
            primitive["material"] = kind.material.into();
        }
        primitive
    };
    if primitives.is_empty() {
        let by_vertex = |corners: Option<bool>| corners.unwrap_or_default();
        let kind = Kind {
            material: ABSENT,
            has_uv: by_vertex(file.uv.as_ref().map(|uv| uv.corners.is_none())),
            has_normals: by_vertex(file.normals.as_ref().map(|normals| normals.corners.is_none())),
        };
        return Ok(vec![primitive(&(kind, Vec::new()), numbers)]);
    }
    Ok(primitives.iter().map(|given| primitive(given, numbers)).collect())
}

/// Returns a normal of length 1, as glTF requires; upwards where there is none.
fn unit(normal: Option<[f64; 3]>) -> [f64; 3] {
    let normal = normal.unwrap_or_default();
    let length = normal.iter().map(|x| x * x).sum::<f64>().sqrt();
    if length > 0.0 && length.is_finite() { normal.map(|x| x / length) } else { [0.0, 0.0, 1.0] }
}

/// The buffer, its views and its accessors.
#[derive(Default)]
struct Numbers {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Numbers {
    /// Adds an accessor of these bytes with its own view. Returns the index of the accessor.
    fn accessor(
        &mut self,
        bytes: &[u8],
        component: u32,
        kind: &str,
        count: usize,
        target: u32,
    ) -> usize {
        self.views.push(json!({
            "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len(), "target": target,
        }));
        self.bytes.extend_from_slice(bytes);
        self.accessors.push(json!({
            "bufferView": self.views.len() - 1, "componentType": component, "type": kind,
            "count": count,
        }));
        if component == code::U8 {
            self.accessors[self.views.len() - 1]["normalized"] = true.into();
        }
        self.accessors.len() - 1
    }

    /// Adds a picture, aligned to four bytes. Returns the index of its view.
    fn picture(&mut self, picture: &Picture) -> io::Result<usize> {
        let start = self.bytes.len();
        picture.write_png(&mut self.bytes)?;
        let length = self.bytes.len() - start;
        self.views.push(json!({ "buffer": 0, "byteOffset": start, "byteLength": length }));
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        Ok(self.views.len() - 1)
    }

    /// Adds an accessor of these values in single precision, with their bounds if `bounds` is set.
    fn floats<const N: usize>(
        &mut self,
        kind: &str,
        values: impl Iterator<Item = [f64; N]>,
        bounds: bool,
    ) -> io::Result<usize> {
        let (mut low, mut high) = ([f32::INFINITY; N], [f32::NEG_INFINITY; N]);
        let mut bytes = Vec::new();
        let mut count = 0;
        for value in values {
            count += 1;
            for k in 0..N {
                let x = value[k] as f32;
                if !x.is_finite() {
                    let what = format!("{:e} is beyond single precision", value[k]);
                    return Err(io::Error::other(what));
                }
                low[k] = low[k].min(x);
                high[k] = high[k].max(x);
                bytes.extend(x.to_le_bytes());
            }
        }
        let number = self.accessor(&bytes, code::F32, kind, count, code::VERTICES);
        if bounds {
            self.accessors[number]["min"] = low[..].into();
            self.accessors[number]["max"] = high[..].into();
        }
        Ok(number)
    }
}
