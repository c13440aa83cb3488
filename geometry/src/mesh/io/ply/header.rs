use std::io::BufRead;

use super::super::draft::{Checked, Fault};
use super::super::notes::Notes;
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
    /// Reads the header, and notes the lines that it skips.
    pub fn read(source: &mut Source<'_>, notes: &mut Notes) -> Result<Self> {
        let first = source.next_bytes()?.unwrap_or_default().trim_ascii();
        if !first.eq_ignore_ascii_case(b"ply") {
            return Err(source.fail("not a PLY file: its first line must be 'ply'"));
        }
        let mut encoding = None;
        let mut elements = Vec::new();
        loop {
            let number = source.line() + 1;
            let Some(line) = source.next_bytes()? else {
                return Err(source.fail("truncated: the header has no end_header"));
            };
            match statement(line, &mut encoding, &mut elements) {
                Ok(Statement::Known) => {}
                Ok(Statement::Last) => break,
                Ok(Statement::Unknown(word)) => {
                    let place = || format!("line {number} ({word})");
                    notes.add("skipped lines of the header that are not of PLY", place);
                }
                Err(fault) => return Err(fault.at(source)),
            }
        }
        let Some(encoding) = encoding else {
            return Err(source.fail("the header has no format"));
        };
        Ok(Self { encoding, elements })
    }

    /// Reads the file to its end, and notes what follows the last element: `left` bytes that were
    /// read, and the rest.
    pub fn skip_rest(&self, source: &mut Source<'_>, left: usize, notes: &mut Notes) -> Result<()> {
        if self.encoding == PlyEncoding::Ascii {
            loop {
                let number = source.line() + 1;
                let Some(line) = source.next_bytes()? else { return Ok(()) };
                if words(line).next().is_some() {
                    let place = || format!("line {number}");
                    notes.add("left out lines after the last element", place);
                }
            }
        }
        let mut count = left;
        loop {
            let length = source.fill_buf().map(<[u8]>::len).map_err(|e| source.io_error(e))?;
            if length == 0 {
                notes.add_many("left out bytes after the last element", count, String::new);
                return Ok(());
            }
            source.consume(length);
            count += length;
        }
    }
}

/// What a line of a header is.
enum Statement {
    Known,
    Last,
    /// Not a statement of PLY: its first word.
    Unknown(String),
}

/// Parses one line of a header.
fn statement(
    line: &[u8],
    encoding: &mut Option<PlyEncoding>,
    elements: &mut Vec<Element>,
) -> Checked<Statement> {
    let words: Vec<&[u8]> = words(line).collect();
    match words[..] {
        [] | [b"comment" | b"obj_info", ..] => {}
        // Programs that leave the version out, or its decimals, write the only one.
        [b"format", name] | [b"format", name, b"1.0" | b"1"] => {
            *encoding = Some(match name {
                b"ascii" => PlyEncoding::Ascii,
                b"binary_little_endian" => PlyEncoding::LittleEndian,
                b"binary_big_endian" => PlyEncoding::BigEndian,
                _ => return Err(format!("unknown format {}", quoted(name)).into()),
            });
        }
        [b"format", _, version] => {
            return Err(format!("version {} of PLY, must be 1.0", quoted(version)).into());
        }
        [b"element", name, number] => {
            let name = String::from_utf8_lossy(name).into_owned();
            if elements.iter().any(|element: &Element| element.name == name) {
                return Err(format!("element {} is declared twice", quoted(name.as_bytes())).into());
            }
            elements.push(Element { name, count: count(number)?, properties: Vec::new() });
        }
        [b"property", b"list", counted_by, item, name] => {
            property(elements, name, item, Some(Type::parse(counted_by)?))?;
        }
        [b"property", item, name] => property(elements, name, item, None)?,
        [b"end_header"] => return Ok(Statement::Last),
        [word @ (b"format" | b"element" | b"property" | b"end_header"), ..] => {
            return Err(format!("invalid statement {} in the header", quoted(word)).into());
        }
        // Comments of some programs lack the word comment.
        [word, ..] => return Ok(Statement::Unknown(quoted(word))),
    }
    Ok(Statement::Known)
}

/// Adds a property of this name and type to the last element; `counted_by` is the type of the
/// length of a list.
fn property(
    elements: &mut [Element],
    name: &[u8],
    item: &[u8],
    counted_by: Option<Type>,
) -> Checked<()> {
    let item = Type::parse(item)?;
    let element =
        elements.last_mut().ok_or_else(|| Fault::from("a property without an element"))?;
    let (name, word) = (Name::parse(name), quoted(name));
    element.properties.push(Property { name, word, item, counted_by });
    Ok(())
}
