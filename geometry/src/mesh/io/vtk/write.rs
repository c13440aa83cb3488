use std::fmt::{self, Display, Write as _};
use std::io::{self, Write};

use super::super::attributes::{Attribute, MeshFile};
use super::encoding::VtkEncoding;

/// Writes numbers in one of the encodings.
struct Sink<'a> {
    sink: &'a mut dyn Write,
    is_text: bool,
}

impl Sink<'_> {
    /// Writes rows of numbers, which `bytes` encodes.
    fn rows<'v, T: Display + Copy + 'v, const N: usize>(
        &mut self,
        rows: impl Iterator<Item = &'v [T]>,
        bytes: impl Fn(T) -> [u8; N],
    ) -> io::Result<()> {
        for row in rows {
            let mut blank = "";
            for &x in row {
                if self.is_text {
                    write!(self.sink, "{blank}{x}")?;
                } else {
                    self.sink.write_all(&bytes(x))?;
                }
                blank = " ";
            }
            if self.is_text {
                writeln!(self.sink)?;
            }
        }
        // After binary numbers, too.
        writeln!(self.sink)
    }

    fn reals<const N: usize>(&mut self, rows: &[[f64; N]]) -> io::Result<()> {
        // Text has every digit; VTK reads NaN as nan only.
        let rows: Vec<[Real; N]> = rows.iter().map(|row| row.map(Real)).collect();
        self.rows(rows.iter().map(|row| &row[..]), |Real(x)| x.to_be_bytes())
    }
}

/// A number that is written with every digit.
#[derive(Clone, Copy)]
struct Real(f64);

impl Display for Real {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0.is_nan() { f.write_str("nan") } else { write!(f, "{:?}", self.0) }
    }
}

pub(in super::super) fn write(
    sink: &mut dyn Write,
    file: &MeshFile,
    encoding: VtkEncoding,
) -> io::Result<()> {
    let is_text = encoding == VtkEncoding::Ascii;
    let (points, faces) = (file.mesh.vertices(), file.mesh.faces());
    let too_many = |_| io::Error::other("more than 2^31 vertices");
    i32::try_from(points.len()).map_err(too_many)?;
    let name = if is_text { "ASCII" } else { "BINARY" };
    writeln!(sink, "# vtk DataFile Version 3.0\ncatamaran\n{name}\nDATASET POLYDATA")?;
    let mut sink = Sink { sink, is_text };
    writeln!(sink.sink, "POINTS {} double", points.len())?;
    sink.reals(points)?;
    writeln!(sink.sink, "POLYGONS {} {}", faces.len(), 4 * faces.len())?;
    let rows: Vec<[u32; 4]> = faces.iter().map(|&[a, b, c]| [3, a, b, c]).collect();
    sink.rows(rows.iter().map(|row| &row[..]), u32::to_be_bytes)?;
    let normals = file.normals.as_ref().and_then(Attribute::of_vertices);
    let uv = file.uv.as_ref().and_then(Attribute::of_vertices);
    let count = file.scalars.len();
    if normals.is_none() && uv.is_none() && file.colors.is_none() && count == 0 {
        return Ok(());
    }
    writeln!(sink.sink, "POINT_DATA {}", points.len())?;
    if let Some(colors) = &file.colors {
        writeln!(sink.sink, "COLOR_SCALARS colors 4")?;
        if is_text {
            sink.reals(colors)?;
        } else {
            let byte = |x: f64| (255.0 * x.clamp(0.0, 1.0)).round() as u8;
            let rows: Vec<[u8; 4]> = colors.iter().map(|color| color.map(byte)).collect();
            sink.rows(rows.iter().map(|row| &row[..]), |byte| [byte])?;
        }
    }
    if let Some(normals) = normals {
        writeln!(sink.sink, "NORMALS normals double")?;
        sink.reals(normals)?;
    }
    if let Some(uv) = uv {
        writeln!(sink.sink, "TEXTURE_COORDINATES uv 2 double")?;
        sink.reals(uv)?;
    }
    if count > 0 {
        // Readers take in one array of SCALARS, and all those of a field.
        writeln!(sink.sink, "FIELD FieldData {count}")?;
        for scalars in &file.scalars {
            writeln!(sink.sink, "{} 1 {} double", encoded(&scalars.name), points.len())?;
            sink.reals(scalars.values.as_chunks::<1>().0)?;
        }
    }
    Ok(())
}

/// Returns a name as VTK writes it: one word of ASCII.
fn encoded(name: &str) -> String {
    let mut word = String::new();
    for byte in name.bytes() {
        if byte.is_ascii_graphic() && byte != b'%' && byte != b'"' {
            word.push(char::from(byte));
        } else {
            // Writing to a string does not fail.
            let _ = write!(word, "%{byte:02X}");
        }
    }
    if word.is_empty() { "scalars".into() } else { word }
}
