use std::io::{self, Write};

use super::super::attributes::{Attribute, MeshFile};
use super::super::colors::byte;
use super::encoding::PlyEncoding;

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
    let (vertices, faces) = (file.mesh.vertices(), file.mesh.faces());
    let normals = file.normals.as_ref().and_then(Attribute::of_vertices);
    let uv = file.uv.as_ref().and_then(Attribute::of_vertices);
    let corner_uv = file.uv.as_ref().filter(|uv| uv.corners.is_some());
    let colors = file.colors.as_deref();
    let channels = colors.map(|colors| {
        let opaque = colors.iter().all(|color| color[3] == 1.0);
        if opaque { 3 } else { 4 }
    });

    let name = match encoding {
        PlyEncoding::Ascii => "ascii",
        PlyEncoding::LittleEndian => "binary_little_endian",
        PlyEncoding::BigEndian => "binary_big_endian",
    };
    let position_kind = kind_of(vertices.as_flattened().iter());
    let normal_kind = kind_of(normals.unwrap_or_default().as_flattened().iter());
    let uv_kind = uv_kind(file.uv.iter().flat_map(|uv| uv.values.as_flattened()));
    let bytes_do = colors.unwrap_or_default().as_flattened().iter().all(|&x| byte(x).is_some());
    let color_kind = if bytes_do { "uchar" } else { "double" };
    let index_kind = if i32::try_from(vertices.len()).is_ok() { "int" } else { "uint" };

    writeln!(sink, "ply\nformat {name} 1.0\nelement vertex {}", vertices.len())?;
    let mut properties = |kind: &str, names: &[&str]| {
        names.iter().try_for_each(|name| writeln!(sink, "property {kind} {name}"))
    };
    properties(position_kind, &["x", "y", "z"])?;
    if normals.is_some() {
        properties(normal_kind, &["nx", "ny", "nz"])?;
    }
    if uv.is_some() {
        properties(uv_kind, &["s", "t"])?;
    }
    if let Some(channels) = channels {
        properties(color_kind, &["red", "green", "blue", "alpha"][..channels])?;
    }
    writeln!(sink, "element face {}", faces.len())?;
    writeln!(sink, "property list uchar {index_kind} vertex_indices")?;
    if corner_uv.is_some() {
        writeln!(sink, "property list uchar {uv_kind} texcoord")?;
    }
    writeln!(sink, "end_header")?;

    let mut sink = Sink { sink, encoding, started: false };
    for v in 0..vertices.len() {
        vertices[v].iter().try_for_each(|&x| sink.real(x, position_kind))?;
        if let Some(normals) = normals {
            normals[v].iter().try_for_each(|&x| sink.real(x, normal_kind))?;
        }
        if let Some(uv) = uv {
            uv[v].iter().try_for_each(|&x| sink.real(x, uv_kind))?;
        }
        if let (Some(colors), Some(channels)) = (colors, channels) {
            for &x in &colors[v][..channels] {
                match byte(x) {
                    Some(x) if bytes_do => sink.byte(x)?,
                    _ => sink.real(x, color_kind)?,
                }
            }
        }
        sink.end_row()?;
    }
    for (f, face) in faces.iter().enumerate() {
        sink.byte(3)?;
        face.iter().try_for_each(|&v| sink.bytes(v.to_le_bytes(), v))?;
        if let Some(uv) = corner_uv {
            let values = uv.of_face(&file.mesh, f);
            sink.byte(if values.is_some() { 6 } else { 0 })?;
            let values = values.as_ref().map_or(&[][..], |values| values.as_flattened());
            values.iter().try_for_each(|&x| sink.real(x, uv_kind))?;
        }
        sink.end_row()?;
    }
    Ok(())
}
