//! Stereolithography STL (3D Systems 1988), binary and text.

use std::io::{self, BufRead, Read, Write};

use super::super::TriMesh;
use super::attributes::MeshFile;
use super::draft::{Checked, Draft, Fault, Numbers, bits};
use super::text::{number, quoted, words};
use catamaran::base::Result;
use catamaran::io::Source;

/// The encoding of an STL file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StlEncoding {
    /// Text, with every digit of double precision.
    Ascii,
    /// Binary, in single precision: coordinates are rounded.
    Binary,
}

/// Sizes of the header and of a facet of a binary file, in bytes.
const HEADER: usize = 80;
const FACET: usize = 50;

/// Number of bytes of a file that are read to tell text from binary.
const LOOK: usize = 512;

pub(super) fn read(source: &mut Source<'_>) -> Result<MeshFile> {
    let start = source.fill_buf().map(|start| &start[..start.len().min(LOOK)]);
    // Binary files may begin with the word solid, too.
    let is_text = start.map(|start| {
        let text = |&byte: &u8| matches!(byte, b'\t'..=b'\r' | b' '..=b'~' | 0x80..);
        start.trim_ascii_start().starts_with(b"solid") && start.iter().all(text)
    });
    let mut soup = Soup::default();
    match is_text {
        Err(e) => return Err(source.io_error(e)),
        Ok(true) => text(source, &mut soup)?,
        Ok(false) => binary(source, &mut soup).map_err(|fault| fault.at(source))?,
    }
    soup.draft.finish(&mut [], &mut [])
}

/// Triangles whose corners become one vertex where their positions are equal.
#[derive(Default)]
struct Soup {
    draft: Draft,
    numbers: Numbers<[u64; 3]>,
}

impl Soup {
    fn push(&mut self, corners: [[f64; 3]; 3], place: impl Fn() -> String) -> Checked<()> {
        let mut face = [0; 3];
        for (number, position) in face.iter_mut().zip(corners) {
            let is_new;
            (*number, is_new) = self.numbers.of(bits(position))?;
            if is_new {
                self.draft.push_vertex(position)?;
            }
        }
        self.draft.push_polygon(&face, place)?;
        Ok(())
    }
}

fn binary(source: &mut Source<'_>, soup: &mut Soup) -> Checked<()> {
    let truncated = |what: &str, e: io::Error, source: &Source<'_>| match e.kind() {
        io::ErrorKind::UnexpectedEof => Fault::from(format!("truncated: {what} is incomplete")),
        _ => Fault::Error(source.io_error(e)),
    };
    let mut header = [0; HEADER + 4];
    source.read_exact(&mut header).map_err(|e| truncated("the header", e, source))?;
    let count = u32::from_le_bytes([header[80], header[81], header[82], header[83]]);
    let mut facet = [0; FACET];
    for f in 0..count {
        let what = || format!("facet {f} of {count}");
        source.read_exact(&mut facet).map_err(|e| truncated(&what(), e, source))?;
        // A facet is its normal, its corners, and two bytes of attributes.
        let x = |i: usize| {
            let at = 12 + 4 * i;
            let bytes = [facet[at], facet[at + 1], facet[at + 2], facet[at + 3]];
            f64::from(f32::from_le_bytes(bytes))
        };
        let corners = [[x(0), x(1), x(2)], [x(3), x(4), x(5)], [x(6), x(7), x(8)]];
        soup.push(corners, what).map_err(|fault| fault.of(what))?;
    }
    match source.fill_buf().map(<[u8]>::is_empty) {
        Ok(true) => Ok(()),
        Ok(false) => Err(format!("bytes after the last of {count} facets").into()),
        Err(e) => Err(Fault::Error(source.io_error(e))),
    }
}

fn text(source: &mut Source<'_>, soup: &mut Soup) -> Result<()> {
    let mut corners = Vec::with_capacity(3);
    // Whether a solid has begun and not yet ended.
    let mut open = false;
    loop {
        let number = source.line() + 1;
        let Some(line) = source.next_bytes()? else { break };
        statement(line, number, &mut corners, &mut open, soup).map_err(|fault| fault.at(source))?;
    }
    if open {
        return Err(source.fail("truncated: no endsolid"));
    }
    Ok(())
}

fn statement(
    line: &[u8],
    line_number: usize,
    corners: &mut Vec<[f64; 3]>,
    open: &mut bool,
    soup: &mut Soup,
) -> Checked<()> {
    let mut words = words(line);
    let Some(keyword) = words.next() else { return Ok(()) };
    match keyword.to_ascii_lowercase().as_slice() {
        b"solid" if !*open => *open = true,
        b"endsolid" if *open && corners.is_empty() => *open = false,
        b"facet" | b"outer" | b"endloop" if *open => {}
        b"vertex" if *open => {
            if corners.len() == 3 {
                return Err("a facet has more than three vertices".into());
            }
            corners.push(super::text::numbers(&mut words)?);
            if let Some(word) = words.next() {
                number(word)?;
                return Err("a vertex has more than three numbers".into());
            }
        }
        b"endfacet" if *open => {
            let &[a, b, c] = corners.as_slice() else {
                return Err(format!("a facet has {} vertices, not 3", corners.len()).into());
            };
            soup.push([a, b, c], || format!("line {line_number}"))?;
            corners.clear();
        }
        _ => return Err(format!("{} is out of place", quoted(keyword)).into()),
    }
    Ok(())
}

pub(super) fn write(sink: &mut dyn Write, mesh: &TriMesh, encoding: StlEncoding) -> io::Result<()> {
    let normals = mesh.face_normals();
    let corners = mesh.faces().iter().map(|f| f.map(|v| mesh.vertices()[v as usize]));
    if encoding == StlEncoding::Ascii {
        writeln!(sink, "solid")?;
        for ([x, y, z], corners) in normals.into_iter().zip(corners) {
            writeln!(sink, "facet normal {x:?} {y:?} {z:?}\nouter loop")?;
            for [x, y, z] in corners {
                writeln!(sink, "vertex {x:?} {y:?} {z:?}")?;
            }
            writeln!(sink, "endloop\nendfacet")?;
        }
        return writeln!(sink, "endsolid");
    }
    let too_many = |_| io::Error::other("more than 2^32 facets");
    let count = u32::try_from(mesh.faces().len()).map_err(too_many)?;
    let mut header = [0; HEADER + 4];
    header[..16].copy_from_slice(b"binary STL file ");
    header[HEADER..].copy_from_slice(&count.to_le_bytes());
    sink.write_all(&header)?;
    for (normal, corners) in normals.into_iter().zip(corners) {
        for x in normal.iter().chain(corners.as_flattened()) {
            sink.write_all(&(*x as f32).to_le_bytes())?;
        }
        sink.write_all(&[0; 2])?;
    }
    Ok(())
}
