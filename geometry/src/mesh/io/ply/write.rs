use std::io::{self, Write};

use super::super::attributes::{Attribute, MeshFile};
use super::super::colors::nearest_byte;
use super::encoding::PlyEncoding;
use crate::mesh::TriMesh;

/// Writes numbers in one of the encodings.
struct Sink<'a> {
    sink: &'a mut dyn Write,
    encoding: PlyEncoding,
    /// Whether the current line has content.
    started: bool,
}

impl Sink<'_> {
    fn bytes<const N: usize>(
        &mut self,
        mut little: [u8; N],
        text: impl std::fmt::Display,
    ) -> io::Result<()> {
        match self.encoding {
            PlyEncoding::Ascii => {
                let blank = if std::mem::replace(&mut self.started, true) { " " } else { "" };
                write!(self.sink, "{blank}{text}")
            }
            PlyEncoding::LittleEndian => self.sink.write_all(&little),
            PlyEncoding::BigEndian => {
                little.reverse();
                self.sink.write_all(&little)
            }
        }
    }

    /// Writes a float or a double, as `kind` says.
    fn real(&mut self, x: f64, kind: &str) -> io::Result<()> {
        if kind == "float" {
            // Text has every digit of the double, which readers recover.
            self.bytes((x as f32).to_le_bytes(), format_args!("{x:?}"))
        } else {
            self.bytes(x.to_le_bytes(), format_args!("{x:?}"))
        }
    }

    fn byte(&mut self, x: u8) -> io::Result<()> {
        self.bytes([x], x)
    }

    fn end_row(&mut self) -> io::Result<()> {
        match self.encoding {
            PlyEncoding::Ascii => {
                self.started = false;
                writeln!(self.sink)
            }
            _ => Ok(()),
        }
    }
}

/// Returns the type that stores these numbers without loss: float if possible.
fn kind_of<'a>(mut values: impl Iterator<Item = &'a f64>) -> &'static str {
    if values.all(|&x| f64::from(x as f32) == x) { "float" } else { "double" }
}

/// Returns the type of texture coordinates: float, because other programs skip doubles, unless a
/// value is too large.
fn uv_kind<'a>(mut values: impl Iterator<Item = &'a f64>) -> &'static str {
    if values.all(|&x| (x as f32).is_finite()) { "float" } else { "double" }
}

pub(in super::super) fn write(
    sink: &mut dyn Write,
    file: &MeshFile,
    encoding: PlyEncoding,
) -> io::Result<()> {
    let properties = Properties::of(file);
    properties.write_header(sink, encoding)?;
    let mut sink = Sink { sink, encoding, started: false };
    properties.write_vertices(&mut sink)?;
    properties.write_faces(&mut sink)
}

/// Returns the values of an attribute of vertices, or the attribute if it belongs to corners.
///
/// Not inlined: the compiler would look for corners before it knows whether there is an attribute,
/// which Valgrind reports.
#[inline(never)]
fn divided<const N: usize>(
    attribute: Option<&Attribute<N>>,
) -> (Option<&[[f64; N]]>, Option<&Attribute<N>>) {
    let Some(attribute) = attribute else { return (None, None) };
    match attribute.of_vertices() {
        Some(values) => (Some(values), None),
        None => (None, Some(attribute)),
    }
}

/// The properties of vertices and faces, and the types of their numbers.
struct Properties<'a> {
    mesh: &'a TriMesh,
    position_kind: &'static str,
    normals: Option<&'a [[f64; 3]]>,
    normal_kind: &'static str,
    uv: Option<&'a [[f64; 2]]>,
    corner_uv: Option<&'a Attribute<2>>,
    uv_kind: &'static str,
    colors: Option<&'a [[f64; 4]]>,
    /// 3 where all colours are opaque, else 4.
    channels: usize,
    color_kind: &'static str,
}

impl<'a> Properties<'a> {
    fn of(file: &'a MeshFile) -> Self {
        let (normals, _) = divided(file.normals.as_ref());
        let (uv, corner_uv) = divided(file.uv.as_ref());
        let colors = file.colors.as_deref();
        let given = colors.unwrap_or_default();
        // Other programs read colours of other types as black, or not at all.
        let bytes_do = given.as_flattened().iter().all(|&x| nearest_byte(x).is_some());
        Self {
            mesh: &file.mesh,
            position_kind: kind_of(file.mesh.vertices().as_flattened().iter()),
            normals,
            normal_kind: kind_of(normals.unwrap_or_default().as_flattened().iter()),
            uv,
            corner_uv,
            uv_kind: uv_kind(file.uv.iter().flat_map(|uv| uv.values.as_flattened())),
            colors,
            channels: if given.iter().all(|color| color[3] == 1.0) { 3 } else { 4 },
            color_kind: if bytes_do { "uchar" } else { "double" },
        }
    }

    fn write_header(&self, sink: &mut dyn Write, encoding: PlyEncoding) -> io::Result<()> {
        let name = match encoding {
            PlyEncoding::Ascii => "ascii",
            PlyEncoding::LittleEndian => "binary_little_endian",
            PlyEncoding::BigEndian => "binary_big_endian",
        };
        let (vertices, faces) = (self.mesh.vertices().len(), self.mesh.faces().len());
        writeln!(sink, "ply\nformat {name} 1.0\nelement vertex {vertices}")?;
        let mut scalars = |kind: &str, names: &[&str]| {
            names.iter().try_for_each(|name| writeln!(sink, "property {kind} {name}"))
        };
        scalars(self.position_kind, &["x", "y", "z"])?;
        if self.normals.is_some() {
            scalars(self.normal_kind, &["nx", "ny", "nz"])?;
        }
        if self.uv.is_some() {
            scalars(self.uv_kind, &["s", "t"])?;
        }
        if self.colors.is_some() {
            scalars(self.color_kind, &["red", "green", "blue", "alpha"][..self.channels])?;
        }
        let index_kind = if i32::try_from(vertices).is_ok() { "int" } else { "uint" };
        writeln!(sink, "element face {faces}")?;
        writeln!(sink, "property list uchar {index_kind} vertex_indices")?;
        if self.corner_uv.is_some() {
            writeln!(sink, "property list uchar {} texcoord", self.uv_kind)?;
        }
        writeln!(sink, "end_header")
    }

    fn write_vertices(&self, sink: &mut Sink<'_>) -> io::Result<()> {
        for (v, position) in self.mesh.vertices().iter().enumerate() {
            position.iter().try_for_each(|&x| sink.real(x, self.position_kind))?;
            if let Some(normals) = self.normals {
                normals[v].iter().try_for_each(|&x| sink.real(x, self.normal_kind))?;
            }
            if let Some(uv) = self.uv {
                uv[v].iter().try_for_each(|&x| sink.real(x, self.uv_kind))?;
            }
            if let Some(colors) = self.colors {
                for &x in &colors[v][..self.channels] {
                    match nearest_byte(x) {
                        Some(x) if self.color_kind == "uchar" => sink.byte(x)?,
                        _ => sink.real(x, self.color_kind)?,
                    }
                }
            }
            sink.end_row()?;
        }
        Ok(())
    }

    fn write_faces(&self, sink: &mut Sink<'_>) -> io::Result<()> {
        for (f, face) in self.mesh.faces().iter().enumerate() {
            sink.byte(3)?;
            face.iter().try_for_each(|&v| sink.bytes(v.to_le_bytes(), v))?;
            if let Some(uv) = self.corner_uv {
                // Other programs crash on lists of different lengths.
                let values = uv.of_face(self.mesh, f).unwrap_or_default();
                sink.byte(6)?;
                values.as_flattened().iter().try_for_each(|&x| sink.real(x, self.uv_kind))?;
            }
            sink.end_row()?;
        }
        Ok(())
    }
}
