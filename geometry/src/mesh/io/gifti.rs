//! GIFTI: surfaces of brains and values on them, in XML.
//!
//! Format: "GIFTI surface data format 1.0" (Harwell and others, nitrc.org/projects/gifti).

use std::io::{self, Write};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::ZlibEncoder;

use super::attributes::{Attribute, MeshFile, Scalars};
use super::beside::beside;
use super::dataset::{Array, Dataset, Ends, Lists, Role, cell};
use super::draft::Checked;
use super::rounding::Rounding;
use super::stored::{Budget, Indices, Kind, from_base64, text_numbers};
use super::text::{count, words};
use super::xml::{Event, Tag, Xml, escaped, unescaped};
use catamaran::base::{Result, push};
use catamaran::io::Source;

pub(super) fn read(source: &mut Source<'_>) -> Result<MeshFile> {
    let reader = Reader::read(source)?;
    if !reader.has_points {
        let what = "has values of vertices, but no surface (NIFTI_INTENT_POINTSET): read the file \
                    of the surface, and this one as its functions (read_scalars, or filter \
                    --functions)";
        return Err(source.fail(what));
    }
    reader.dataset.finish()
}

/// Reads the values of vertices of a file, with or without a surface.
pub(super) fn scalars(source: &mut Source<'_>) -> Result<Vec<Scalars>> {
    Ok(Reader::read(source)?.dataset.scalars())
}

/// The matrix of points that stay in their space.
const IDENTITY: [f64; 16] =
    [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];

/// An array as the file describes it.
struct Raw<'a> {
    intent: String,
    name: String,
    kind: Kind,
    shape: Vec<usize>,
    by_columns: bool,
    is_big: bool,
    encoding: String,
    /// The name of the file that has the numbers, and the byte where they begin there.
    file: String,
    start: u64,
    data: &'a [u8],
    /// Whether a matrix takes the points to another space.
    is_moved: bool,
}

#[derive(Default)]
struct Reader {
    dataset: Dataset,
    has_points: bool,
    has_triangles: bool,
}

impl Reader {
    fn read(source: &mut Source<'_>) -> Result<Self> {
        let bytes = source.read_all()?;
        let mut xml = Xml::new(&bytes);
        let mut reader = Self::default();
        match reader.arrays(&mut xml, &mut Budget::new(source)) {
            Ok(()) => Ok(reader),
            Err(fault) => Err(xml.cursor.fail(fault, source)),
        }
    }

    fn arrays(&mut self, xml: &mut Xml<'_>, budget: &mut Budget<'_, '_>) -> Checked<()> {
        let mut array = None;
        let mut key: &[u8] = b"";
        let mut number = 0;
        while let Some(event) = xml.next()? {
            match event {
                Event::Start(tag) if tag.name == b"DataArray" => array = Some(Raw::new(&tag)?),
                Event::Start(_) => {}
                Event::Text(text) => {
                    // There may be blanks around CDATA.
                    let text = text.trim_ascii();
                    let Some(array) = array.as_mut().filter(|_| !text.is_empty()) else { continue };
                    match xml.open().last() {
                        Some(&b"Data") => array.data = text,
                        Some(&b"Name") => key = text,
                        Some(&b"Value") if key == b"Name" => {
                            array.name = unescaped(text).into_owned();
                        }
                        Some(&b"MatrixData") => array.is_moved |= text_numbers(text)? != IDENTITY,
                        _ => {}
                    }
                }
                Event::End(b"DataArray") => {
                    if let Some(array) = array.take() {
                        let added = self.add(array, budget);
                        added.map_err(|fault| fault.of(|| format!("data array {number}")))?;
                        number += 1;
                    }
                }
                Event::End(_) => {}
            }
        }
        Ok(())
    }

    fn add(&mut self, mut array: Raw<'_>, budget: &mut Budget<'_, '_>) -> Checked<()> {
        if array.by_columns && array.has_lines_of_rows() {
            // nibabel writes so, whatever the order that it states.
            array.by_columns = false;
            let what = "took numbers of text row by row, as its lines have them, although the file \
                        says ColumnMajorOrder";
            self.dataset.draft.notes.add(what, || array.intent.clone());
        }
        let values = array.values(budget)?;
        let rows = array.shape.first().copied().unwrap_or_default();
        let width = array.shape.iter().skip(1).fold(1, |width: usize, &n| width.saturating_mul(n));
        match (array.intent.as_str(), width) {
            ("NIFTI_INTENT_POINTSET", 3) if !self.has_points => {
                self.has_points = true;
                if array.is_moved {
                    let what = "left out matrices that take the points to other spaces";
                    self.dataset.draft.notes.add(what, String::new);
                }
                self.dataset.points(&values)
            }
            ("NIFTI_INTENT_TRIANGLE", 3) if !self.has_triangles => {
                self.has_triangles = true;
                let corners = Indices::of_numbers(values)?;
                let lists = Lists { corners, ends: Ends::Each(3, rows) };
                self.dataset.cells(&lists, 0, |_| Ok(cell::TRIANGLE))
            }
            ("NIFTI_INTENT_POINTSET" | "NIFTI_INTENT_TRIANGLE", _) => {
                let what = "left out points and triangles of further surfaces, or not of three \
                            numbers each";
                self.dataset.draft.notes.add(what, || array.intent.clone());
                Ok(())
            }
            (intent, _) => {
                let short = intent.strip_prefix("NIFTI_INTENT_").unwrap_or(intent);
                let named = !array.name.is_empty();
                let name = if named { array.name } else { short.to_ascii_lowercase() };
                let found = Array::named(name, width, values, array.kind)?;
                let role = match (short, width) {
                    ("RGB_VECTOR", 3) | ("RGBA_VECTOR", 4) => Role::Colors,
                    _ => found.role,
                };
                Ok(push(&mut self.dataset.arrays, Array { role, ..found })?)
            }
        }
    }
}

impl<'a> Raw<'a> {
    fn new(tag: &Tag<'a>) -> Checked<Self> {
        let kind = match tag.need("DataType")?.as_ref() {
            "NIFTI_TYPE_INT8" => Kind::I8,
            "NIFTI_TYPE_UINT8" => Kind::U8,
            "NIFTI_TYPE_INT16" => Kind::I16,
            "NIFTI_TYPE_UINT16" => Kind::U16,
            "NIFTI_TYPE_INT32" => Kind::I32,
            "NIFTI_TYPE_UINT32" => Kind::U32,
            "NIFTI_TYPE_INT64" => Kind::I64,
            "NIFTI_TYPE_UINT64" => Kind::U64,
            "NIFTI_TYPE_FLOAT32" => Kind::F32,
            "NIFTI_TYPE_FLOAT64" => Kind::F64,
            other => return Err(format!("unknown DataType {other:?}").into()),
        };
        let dimensions = count(tag.bytes("Dimensionality")?)?.min(6);
        let size = |i: usize| count(tag.bytes(&format!("Dim{i}"))?);
        Ok(Self {
            intent: tag.need("Intent")?.into_owned(),
            name: String::new(),
            kind,
            shape: (0..dimensions).map(size).collect::<Checked<_>>()?,
            by_columns: matches!(
                tag.get("ArrayIndexingOrder").as_deref(),
                Some("ColumnMajorOrder" | "GIFTI_IND_ORD_COL_MAJOR")
            ),
            is_big: matches!(tag.get("Endian").as_deref(), Some("BigEndian" | "GIFTI_ENDIAN_BIG")),
            encoding: tag.need("Encoding")?.into_owned(),
            file: tag.get("ExternalFileName").unwrap_or_default().into_owned(),
            start: match tag.get("ExternalFileOffset").as_deref().map(str::trim) {
                None | Some("") => 0,
                Some(start) => count(start.as_bytes())? as u64,
            },
            data: b"",
            is_moved: false,
        })
    }

    /// Returns whether the array is text, each line of which has the numbers of a row.
    fn has_lines_of_rows(&self) -> bool {
        let [rows, columns] = self.shape[..] else { return false };
        // A single row or column is the same in both orders.
        if !self.is_text() || rows == columns || rows == 1 || columns == 1 {
            return false;
        }
        let lines = self.data.split(|&byte| byte == b'\n').map(|line| words(line).count());
        let mut lines = lines.filter(|&count| count > 0);
        lines.by_ref().take(rows).filter(|&count| count == columns).count() == rows
            && lines.next().is_none()
    }

    fn is_text(&self) -> bool {
        // The names of nibabel and of the library in C are other ones.
        matches!(self.encoding.as_str(), "ASCII" | "GIFTI_ENCODING_ASCII")
    }

    /// Returns the numbers, row by row.
    fn values(&self, budget: &mut Budget<'_, '_>) -> Checked<Vec<f64>> {
        let size = self.shape.iter().fold(1, |size: usize, &n| size.saturating_mul(n));
        budget.take_numbers(size)?;
        let values = match self.encoding.as_str() {
            _ if self.is_text() => text_numbers(self.data)?,
            "Base64Binary" | "GIFTI_ENCODING_B64BIN" => {
                self.kind.numbers(&from_base64(self.data)?, self.is_big)?
            }
            "GZipBase64Binary" | "GIFTI_ENCODING_B64GZ" => {
                let mut bytes = Vec::new();
                let length = size.saturating_mul(self.kind.size());
                budget.inflate(&from_base64(self.data)?, length, &mut bytes)?;
                self.kind.numbers(&bytes, self.is_big)?
            }
            "ExternalFileBinary" | "GIFTI_ENCODING_EXTBIN" => {
                let length = size.saturating_mul(self.kind.size());
                budget.take(length)?;
                let bytes = beside(&self.file, budget.path(), self.start, length)?;
                self.kind.numbers(&bytes, self.is_big)?
            }
            other => return Err(format!("unknown Encoding {other:?}").into()),
        };
        if values.len() != size {
            return Err(format!("has {} of {size} numbers", values.len()).into());
        }
        match self.shape[..] {
            [rows, columns] if self.by_columns => {
                let row = |i: usize| (0..columns).map(move |j| j * rows + i);
                Ok((0..rows).flat_map(row).map(|at| values[at]).collect())
            }
            [_, _, _, ..] if self.by_columns => {
                Err("ColumnMajorOrder of more than two dimensions is not supported".into())
            }
            _ => Ok(values),
        }
    }
}

/// Writes a surface in single precision, the only one that all programs read, packed by zlib.
pub(super) fn write(sink: &mut dyn Write, file: &MeshFile, rounding: &Rounding) -> io::Result<()> {
    let (points, faces) = (file.mesh.vertices(), file.mesh.faces());
    let normals = file.normals.as_ref().and_then(Attribute::of_vertices);
    let count = 2 + usize::from(normals.is_some()) + file.scalars.len();
    write!(
        sink,
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
         <!DOCTYPE GIFTI SYSTEM \"http://www.nitrc.org/frs/download.php/115/gifti.dtd\">\n\
         <GIFTI Version=\"1.0\" NumberOfDataArrays=\"{count}\">\n"
    )?;
    let too_many = |_| io::Error::other("more than 2^31 vertices");
    i32::try_from(points.len()).map_err(too_many)?;
    let single = |x: &f64| (*x as f32).to_le_bytes();
    let bytes = points.iter().flat_map(|&p| rounding.single(p)).flat_map(f32::to_le_bytes);
    write_array(sink, "POINTSET", "", [points.len(), 3], bytes)?;
    let bytes = faces.as_flattened().iter().flat_map(|v| v.to_le_bytes());
    write_array(sink, "TRIANGLE", "", [faces.len(), 3], bytes)?;
    if let Some(normals) = normals {
        let bytes = normals.as_flattened().iter().flat_map(single);
        write_array(sink, "VECTOR", "normals", [normals.len(), 3], bytes)?;
    }
    for Scalars { name, values } in &file.scalars {
        let bytes = values.iter().flat_map(single);
        write_array(sink, "SHAPE", name, [values.len(), 1], bytes)?;
    }
    writeln!(sink, "</GIFTI>")
}

fn write_array(
    sink: &mut dyn Write,
    intent: &str,
    name: &str,
    [rows, columns]: [usize; 2],
    bytes: impl Iterator<Item = u8>,
) -> io::Result<()> {
    let kind = if intent == "TRIANGLE" { "INT32" } else { "FLOAT32" };
    // Values of vertices have one dimension.
    let shape = match columns {
        1 => format!("Dimensionality=\"1\" Dim0=\"{rows}\""),
        _ => format!("Dimensionality=\"2\" Dim0=\"{rows}\" Dim1=\"{columns}\""),
    };
    writeln!(
        sink,
        "<DataArray Intent=\"NIFTI_INTENT_{intent}\" DataType=\"NIFTI_TYPE_{kind}\" \
         ArrayIndexingOrder=\"RowMajorOrder\" {shape} Encoding=\"GZipBase64Binary\" \
         Endian=\"LittleEndian\" ExternalFileName=\"\" ExternalFileOffset=\"\">"
    )?;
    if name.is_empty() {
        writeln!(sink, "<MetaData/>")?;
    } else {
        let name = escaped(name);
        writeln!(sink, "<MetaData><MD><Name>Name</Name><Value>{name}</Value></MD></MetaData>")?;
    }
    if intent == "POINTSET" {
        writeln!(
            sink,
            "<CoordinateSystemTransformMatrix><DataSpace>NIFTI_XFORM_UNKNOWN</DataSpace>\
             <TransformedSpace>NIFTI_XFORM_UNKNOWN</TransformedSpace>\
             <MatrixData>1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1</MatrixData>\
             </CoordinateSystemTransformMatrix>"
        )?;
    }
    let mut packer = ZlibEncoder::new(Vec::new(), Compression::default());
    packer.write_all(&bytes.collect::<Vec<u8>>())?;
    writeln!(sink, "<Data>{}</Data>\n</DataArray>", STANDARD.encode(packer.finish()?))
}
