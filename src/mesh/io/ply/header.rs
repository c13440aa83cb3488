use std::io::BufRead;

use super::super::draft::{Checked, Fault};
use super::super::text::{count, quoted, words};
use super::PlyEncoding;
use super::rows::Name;
use crate::base::Result;
use crate::io::Source;

/// The type of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Type {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Type {
    fn parse(word: &[u8]) -> Checked<Self> {
        Ok(match word {
            b"char" | b"int8" => Self::I8,
            b"uchar" | b"uint8" => Self::U8,
            b"short" | b"int16" => Self::I16,
            b"ushort" | b"uint16" => Self::U16,
            b"int" | b"int32" => Self::I32,
            b"uint" | b"uint32" => Self::U32,
            b"float" | b"float32" => Self::F32,
            b"double" | b"float64" => Self::F64,
            _ => return Err(format!("type {} is not of PLY", quoted(word)).into()),
        })
    }

    /// Its bytes in a binary file.
    pub fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// What stands for 1 where integers stand for fractions.
    fn full_scale(self) -> f64 {
        match self {
            Self::I8 => f64::from(i8::MAX),
            Self::U8 => f64::from(u8::MAX),
            Self::I16 => f64::from(i16::MAX),
            Self::U16 => f64::from(u16::MAX),
            Self::I32 => f64::from(i32::MAX),
            Self::U32 => f64::from(u32::MAX),
            Self::F32 | Self::F64 => 1.0,
        }
    }
}

/// A property: its place among the scalars or the lists of a row.
#[derive(Debug)]
pub(super) struct Property {
    pub name: Option<Name>,
    pub item: Type,
    /// The type of the count of a list.
    pub counted_by: Option<Type>,
}

/// Rows of one kind.
#[derive(Debug)]
pub(super) struct Element {
    pub name: String,
    pub count: usize,
    pub properties: Vec<Property>,
}

impl Element {
    /// The place of a scalar among the scalars.
    pub fn scalar(&self, name: Name) -> Option<usize> {
        self.properties.iter().filter(|p| p.counted_by.is_none()).position(|p| p.name == Some(name))
    }

    /// The places of scalars, when all are there.
    pub fn scalars<const N: usize>(&self, names: [Name; N]) -> Option<[usize; N]> {
        let places = names.map(|name| self.scalar(name));
        places.iter().all(Option::is_some).then(|| places.map(Option::unwrap_or_default))
    }

    /// The place of a list among the lists.
    pub fn list(&self, name: Name) -> Option<usize> {
        self.properties.iter().filter(|p| p.counted_by.is_some()).position(|p| p.name == Some(name))
    }

    /// What scalar number i has for 1, as a colour.
    pub fn full_scale(&self, i: usize) -> f64 {
        let mut scalars = self.properties.iter().filter(|p| p.counted_by.is_none());
        scalars.nth(i).map_or(1.0, |p| p.item.full_scale())
    }
}

/// What comes before the numbers.
pub(super) struct Header {
    pub encoding: PlyEncoding,
    pub elements: Vec<Element>,
}

impl Header {
    pub fn read(source: &mut Source<'_>) -> Result<Self> {
        if source.next_bytes()?.unwrap_or_default() != b"ply" {
            return Err(source.fail("not a PLY file: its first line must be 'ply'"));
        }
        let mut encoding = None;
        let mut elements = Vec::new();
        loop {
            let Some(line) = source.next_bytes()? else {
                return Err(source.fail("truncated: the header has no end_header"));
            };
            match statement(line, &mut encoding, &mut elements) {
                Ok(false) => {}
                Ok(true) => break,
                Err(fault) => return Err(fault.at(source)),
            }
        }
        let Some(encoding) = encoding else {
            return Err(source.fail("a header without format"));
        };
        Ok(Self { encoding, elements })
    }

    /// That the file ends here.
    pub fn nothing_more(&self, source: &mut Source<'_>) -> Result<()> {
        if self.encoding == PlyEncoding::Ascii {
            while let Some(line) = source.next_bytes()? {
                if words(line).next().is_some() {
                    return Err(source.fail("text after the elements announced"));
                }
            }
            return Ok(());
        }
        match source.fill_buf().map(<[u8]>::is_empty) {
            Ok(true) => Ok(()),
            Ok(false) => Err(source.fail_at(0, "bytes after the elements announced")),
            Err(e) => Err(source.io_error(&e)),
        }
    }
}

/// One line of a header; whether it was the last.
fn statement(
    line: &[u8],
    encoding: &mut Option<PlyEncoding>,
    elements: &mut Vec<Element>,
) -> Checked<bool> {
    let words: Vec<&[u8]> = words(line).collect();
    match words[..] {
        [] | [b"comment" | b"obj_info", ..] => {}
        [b"format", name, version] => {
            *encoding = Some(match name {
                b"ascii" => PlyEncoding::Ascii,
                b"binary_little_endian" => PlyEncoding::LittleEndian,
                b"binary_big_endian" => PlyEncoding::BigEndian,
                _ => return Err(format!("format {} is not of PLY", quoted(name)).into()),
            });
            if version != b"1.0" {
                return Err(format!("version {} of PLY, not 1.0", quoted(version)).into());
            }
        }
        [b"element", name, number] => {
            let name = String::from_utf8_lossy(name).into_owned();
            if elements.iter().any(|element: &Element| element.name == name) {
                return Err(format!("element {} twice", quoted(name.as_bytes())).into());
            }
            elements.push(Element { name, count: count(number)?, properties: Vec::new() });
        }
        [b"property", b"list", counted_by, item, name] => {
            let counted_by = Type::parse(counted_by)?;
            if matches!(counted_by, Type::F32 | Type::F64) {
                return Err("a list counted by a floating-point number".into());
            }
            let name = Name::parse(name);
            property(
                elements,
                Property { name, item: Type::parse(item)?, counted_by: Some(counted_by) },
            )?;
        }
        [b"property", item, name] => {
            let name = Name::parse(name);
            property(elements, Property { name, item: Type::parse(item)?, counted_by: None })?;
        }
        [b"end_header"] => return Ok(true),
        [word, ..] => {
            return Err(format!("broken statement {} in the header", quoted(word)).into());
        }
    }
    Ok(false)
}

fn property(elements: &mut [Element], property: Property) -> Checked<()> {
    let element = elements.last_mut().ok_or_else(|| Fault::from("a property of no element"))?;
    element.properties.push(property);
    Ok(())
}
