//! XML files of VTK: PolyData and UnstructuredGrid.

use std::borrow::Cow;

use super::super::attributes::MeshFile;
use super::super::cursor::Cursor;
use super::super::dataset::{Array, Dataset, Ends, Lists, Role, cell, not_a_surface};
use super::super::draft::{Checked, roomy};
use super::super::stored::{Budget, Indices, Kind, from_base64, text_numbers, whole};
use super::super::text::count;
use super::super::xml::{Event, Tag, Xml};
use catamaran::base::{Result, push};
use catamaran::io::Source;

pub(in super::super) fn read(source: &mut Source<'_>) -> Result<MeshFile> {
    let bytes = source.read_all()?;
    let mut xml = Xml::new(&bytes);
    match Document::read(&mut xml) {
        Ok(document) => {
            let dataset = document.dataset(&mut Budget::new(source));
            dataset.map_err(|fault| fault.at(source))?.finish()
        }
        Err(fault) => Err(xml.cursor.fail(fault, source)),
    }
}

/// Where the numbers of an array are.
enum Place {
    Text,
    /// In base64 in the element.
    Inline,
    /// From this position in the appended data on.
    Appended(usize),
}

/// How numbers that are no text are packed.
enum Packing<'a> {
    None,
    Zlib,
    Lz4,
    Xz,
    /// By the compressor of this name, which is not supported.
    Other(Cow<'a, str>),
}

/// An array as the file describes it.
struct Raw<'a> {
    piece: usize,
    /// The name of the element around it.
    section: &'a [u8],
    name: String,
    role: Option<Role>,
    /// `None` for what is not numbers.
    kind: Option<Kind>,
    width: usize,
    place: Place,
    text: &'a [u8],
}

struct Document<'a> {
    is_big: bool,
    /// The type of the numbers of headers of arrays.
    word: Kind,
    packing: Packing<'a>,
    arrays: Vec<Raw<'a>>,
    /// The appended data, and whether they are in base64.
    appended: Option<(&'a [u8], bool)>,
    /// Where arrays of the appended data begin, in ascending order.
    starts: Vec<usize>,
}

impl<'a> Document<'a> {
    fn read(xml: &mut Xml<'a>) -> Checked<Self> {
        let mut document = Self {
            is_big: false,
            word: Kind::U32,
            packing: Packing::None,
            arrays: Vec::new(),
            appended: None,
            starts: Vec::new(),
        };
        let mut pieces = 0;
        let mut is_vtk = false;
        // The names of the arrays that are normals and texture coordinates.
        let mut roles: [Option<Cow<'a, str>>; 2] = [None, None];
        while let Some(event) = xml.next()? {
            match event {
                Event::Start(tag) => match tag.name {
                    b"VTKFile" => {
                        document.header(&tag)?;
                        is_vtk = true;
                    }
                    b"Piece" => pieces += 1,
                    b"PointData" => roles = [tag.get("Normals"), tag.get("TCoords")],
                    b"DataArray" | b"Array" => {
                        let section = xml.open().iter().rev().nth(1).copied().unwrap_or_default();
                        let array = Raw::new(&tag, pieces, section, &roles)?;
                        push(&mut document.arrays, array)?;
                    }
                    b"AppendedData" => {
                        let is_base64 = tag.get("encoding").as_deref() != Some("raw");
                        let rest = xml.cursor.rest();
                        let start = rest.iter().position(|&byte| byte == b'_');
                        let start = start.ok_or("appended data without _ before them")?;
                        let data = &rest[start + 1..];
                        let text = data.split(|&byte| byte == b'<').next().unwrap_or_default();
                        document.appended = Some((if is_base64 { text } else { data }, is_base64));
                        // Raw data are not XML.
                        break;
                    }
                    _ => {}
                },
                Event::Text(text) => {
                    let is_own = matches!(xml.open().last(), Some(&(b"DataArray" | b"Array")));
                    // There may be elements with blanks around them, too.
                    let text = text.trim_ascii();
                    let array = document.arrays.last_mut().filter(|_| is_own && !text.is_empty());
                    if let Some(array) = array {
                        if !array.text.is_empty() {
                            let name = &array.name;
                            return Err(format!("array {name:?} is in several pieces").into());
                        }
                        array.text = text;
                    }
                }
                Event::End(_) => {}
            }
        }
        for array in &document.arrays {
            if let Place::Appended(start) = array.place {
                push(&mut document.starts, start)?;
            }
        }
        document.starts.sort_unstable();
        if is_vtk { Ok(document) } else { Err("has no <VTKFile>".into()) }
    }

    fn header(&mut self, tag: &Tag<'a>) -> Checked<()> {
        let kind = tag.need("type")?;
        if kind != "PolyData" && kind != "UnstructuredGrid" {
            return Err(not_a_surface(&format!("VTKFile of type {kind:?}")));
        }
        self.is_big = tag.get("byte_order").as_deref() == Some("BigEndian");
        if tag.get("header_type").as_deref() == Some("UInt64") {
            self.word = Kind::U64;
        }
        self.packing = match tag.get("compressor") {
            None => Packing::None,
            Some(name) => match name.as_ref() {
                "" => Packing::None,
                "vtkZLibDataCompressor" => Packing::Zlib,
                "vtkLZ4DataCompressor" => Packing::Lz4,
                "vtkLZMADataCompressor" => Packing::Xz,
                _ => Packing::Other(name),
            },
        };
        Ok(())
    }

    fn dataset(&self, budget: &mut Budget<'_, '_>) -> Checked<Dataset> {
        let mut dataset = Dataset::default();
        let pieces = self.arrays.chunk_by(|a, b| a.piece == b.piece);
        // Arrays before the first piece are not of vertices.
        let pieces = pieces.filter(|piece| piece[0].piece > 0);
        for piece in pieces {
            let base = dataset.draft.vertices.len();
            let mut values = |section: &[u8], name: &str| -> Checked<Option<Vec<f64>>> {
                let found = |raw: &&Raw<'_>| {
                    raw.section == section && (name.is_empty() || raw.name == name)
                };
                piece.iter().find(found).map(|raw| self.values(raw, budget)).transpose()
            };
            if let Some(points) = values(b"Points", "")? {
                dataset.points(&points)?;
            }
            let own = dataset.draft.vertices.len() - base;
            let sections: [(&[u8], usize); 5] = [
                (b"Polys", cell::POLYGON),
                (b"Strips", cell::STRIP),
                (b"Lines", cell::OTHER),
                (b"Verts", cell::OTHER),
                (b"Cells", cell::OTHER),
            ];
            for (section, kind) in sections {
                let lists = (values(section, "connectivity")?, values(section, "offsets")?);
                let lists = match lists {
                    (Some(corners), Some(ends)) => Lists {
                        corners: Indices::of_numbers(corners)?,
                        ends: Ends::At(Indices::of_numbers(ends)?),
                    },
                    (None, None) => continue,
                    _ => {
                        let section = String::from_utf8_lossy(section).into_owned();
                        return Err(format!("<{section}> lacks connectivity or offsets").into());
                    }
                };
                let kinds = values(section, "types")?;
                dataset.cells(&lists, base, |i| match &kinds {
                    None => Ok(kind),
                    Some(kinds) => match kinds.get(i) {
                        Some(&kind) => whole(kind),
                        None => Err(format!("cell {i} has no type").into()),
                    },
                })?;
            }
            for raw in piece.iter().filter(|raw| raw.section == b"CellData") {
                dataset.draft.notes.add("left out values of cells", || raw.name.clone());
            }
            let of_points = piece.iter().filter(|raw| raw.section == b"PointData");
            let of_numbers = of_points.filter_map(|raw| Some((raw, raw.kind?)));
            for (i, (raw, kind)) in of_numbers.enumerate() {
                let values = self.values(raw, budget)?;
                // Pieces have the same arrays in the same order. Others lack values of vertices.
                let fits = |known: &&mut Array| {
                    known.name == raw.name
                        && known.width == raw.width
                        && known.values.len() == base * raw.width
                        && values.len() == own * raw.width
                };
                if let Some(known) = dataset.arrays.get_mut(i).filter(fits) {
                    known.values.extend(values);
                    continue;
                }
                let array = Array::named(raw.name.clone(), raw.width, values, kind)?;
                let role = raw.role.unwrap_or(array.role);
                push(&mut dataset.arrays, Array { role, ..array })?;
            }
        }
        Ok(dataset)
    }

    fn values(&self, raw: &Raw<'_>, budget: &mut Budget<'_, '_>) -> Checked<Vec<f64>> {
        self.unnamed_values(raw, budget)
            .map_err(|fault| fault.of(|| format!("array {:?}", raw.name)))
    }

    fn unnamed_values(&self, raw: &Raw<'_>, budget: &mut Budget<'_, '_>) -> Checked<Vec<f64>> {
        let decoded;
        let stored = match raw.place {
            Place::Text => return text_numbers(raw.text),
            Place::Inline => {
                decoded = from_base64(raw.text)?;
                &decoded[..]
            }
            Place::Appended(start) => {
                let (data, is_base64) = self.appended.ok_or("the file has no appended data")?;
                let beyond = || format!("offset {start} is beyond the appended data");
                let data = data.get(start..).ok_or_else(beyond)?;
                if is_base64 {
                    // Up to the next array.
                    let next = self.starts.partition_point(|&other| other <= start);
                    let next = self.starts.get(next).map_or(data.len(), |next| next - start);
                    let length = next.min(data.len());
                    budget.take(length)?;
                    decoded = from_base64(&data[..length])?;
                    &decoded[..]
                } else {
                    data
                }
            }
        };
        let kind = raw.kind.ok_or("is not of numbers")?;
        let bytes = self.unpacked(stored, budget)?;
        budget.take_numbers(bytes.len() / kind.size())?;
        kind.numbers(&bytes, self.is_big)
    }

    /// Returns the bytes of numbers, which a header comes before.
    fn unpacked<'b>(
        &self,
        stored: &'b [u8],
        budget: &mut Budget<'_, '_>,
    ) -> Checked<Cow<'b, [u8]>> {
        let mut cursor = Cursor::new(stored);
        // An array without numbers may have no header, either.
        if stored.is_empty() {
            return Ok(stored.into());
        }
        if let Packing::None = self.packing {
            let length = self.word(&mut cursor)?;
            budget.take(length)?;
            return Ok(cursor.bytes(length, "the last number")?.into());
        }
        let blocks = self.word(&mut cursor)?;
        if blocks == 0 {
            return Ok(Cow::default());
        }
        let size = self.word(&mut cursor)?;
        let last = self.word(&mut cursor)?;
        let mut lengths = roomy(blocks);
        for _ in 0..blocks {
            push(&mut lengths, self.word(&mut cursor)?)?;
        }
        let mut bytes = Vec::new();
        for (i, &length) in lengths.iter().enumerate() {
            let unpacked = if i + 1 == blocks && last > 0 { last } else { size };
            let packed = cursor.bytes(length, format_args!("block {i} of {blocks}"))?;
            match &self.packing {
                Packing::Lz4 => budget.lz4(packed, unpacked, &mut bytes)?,
                Packing::Xz => budget.xz(packed, unpacked, &mut bytes)?,
                Packing::Other(name) => {
                    let what = format!(
                        "packed by {name}, where zlib, LZ4 and LZMA are read: write the file anew \
                         with one of them (ParaView: compressor type; vtkXMLWriter: \
                         SetCompressorTypeToZLib)"
                    );
                    return Err(what.into());
                }
                _ => budget.inflate(packed, unpacked, &mut bytes)?,
            }
        }
        Ok(bytes.into())
    }

    fn word(&self, cursor: &mut Cursor<'_>) -> Checked<usize> {
        whole(cursor.stored(self.word, self.is_big, "the header of the array")?)
    }
}

impl<'a> Raw<'a> {
    fn new(
        tag: &Tag<'a>,
        piece: usize,
        section: &'a [u8],
        roles: &[Option<Cow<'a, str>>; 2],
    ) -> Checked<Self> {
        let name = tag.get("Name").unwrap_or_default().into_owned();
        let width = match tag.get("NumberOfComponents") {
            Some(width) => count(width.trim().as_bytes())?,
            None => 1,
        };
        if section == b"Points" && !matches!(width, 1 | 3) {
            return Err(format!("points of {width} coordinates, where 3 are needed").into());
        }
        let is = |role: &Option<Cow<'a, str>>| role.as_deref() == Some(name.as_str());
        let role = match width {
            3 if is(&roles[0]) => Some(Role::Normals),
            2 | 3 if is(&roles[1]) => Some(Role::Uv),
            _ => None,
        };
        let place = match tag.get("format").as_deref() {
            None | Some("ascii") => Place::Text,
            Some("binary") => Place::Inline,
            Some("appended") => Place::Appended(count(tag.bytes("offset")?)?),
            Some(other) => return Err(format!("unknown format {other:?} of array {name:?}").into()),
        };
        let kind = match tag.need("type")?.as_ref() {
            "Int8" => Some(Kind::I8),
            "UInt8" => Some(Kind::U8),
            "Int16" => Some(Kind::I16),
            "UInt16" => Some(Kind::U16),
            "Int32" => Some(Kind::I32),
            "UInt32" => Some(Kind::U32),
            "Int64" => Some(Kind::I64),
            "UInt64" => Some(Kind::U64),
            "Float32" => Some(Kind::F32),
            "Float64" => Some(Kind::F64),
            _ => None,
        };
        Ok(Self { piece, section, name, role, kind, width, place, text: b"" })
    }
}
