use std::io::BufRead;

use super::super::draft::{Checked, Fault};
use super::super::text::{count, quoted, words};
use super::element::{Element, Name, Property, Type};
use super::encoding::PlyEncoding;
use catamaran::base::Result;
use catamaran::io::Source;

/// The header of a PLY file.
pub(super) struct Header {
    pub encoding: PlyEncoding,
    pub elements: Vec<Element>,
}

impl Header {
    /// Reads the header.
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
            return Err(source.fail("the header has no format"));
        };
        Ok(Self { encoding, elements })
    }

    /// Returns an error unless the file ends at the current position.
    pub fn nothing_more(&self, source: &mut Source<'_>) -> Result<()> {
        if self.encoding == PlyEncoding::Ascii {
            while let Some(line) = source.next_bytes()? {
                if words(line).next().is_some() {
                    return Err(source.fail("text after the last element"));
                }
            }
            return Ok(());
        }
        match source.fill_buf().map(<[u8]>::is_empty) {
            Ok(true) => Ok(()),
            Ok(false) => Err(source.fail_at(None, "bytes after the last element")),
            Err(e) => Err(source.io_error(e)),
        }
    }
}

/// Parses one line of a header; returns whether it was the last.
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
                _ => return Err(format!("unknown format {}", quoted(name)).into()),
            });
            if version != b"1.0" {
                return Err(format!("version {} of PLY, must be 1.0", quoted(version)).into());
            }
        }
        [b"element", name, number] => {
            let name = String::from_utf8_lossy(name).into_owned();
            if elements.iter().any(|element: &Element| element.name == name) {
                return Err(format!("element {} is declared twice", quoted(name.as_bytes())).into());
            }
            elements.push(Element { name, count: count(number)?, properties: Vec::new() });
        }
        [b"property", b"list", counted_by, item, name] => {
            let counted_by = Type::parse(counted_by)?;
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
            return Err(format!("invalid statement {} in the header", quoted(word)).into());
        }
    }
    Ok(false)
}

fn property(elements: &mut [Element], property: Property) -> Checked<()> {
    let element =
        elements.last_mut().ok_or_else(|| Fault::from("a property without an element"))?;
    element.properties.push(property);
    Ok(())
}
