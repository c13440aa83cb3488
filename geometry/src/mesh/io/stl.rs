//! Stereolithography STL (3D Systems 1988), binary and text.

use std::io::{self, BufRead, Read, Write};
use std::iter::Peekable;

use super::super::TriMesh;
use super::super::vector::bits;
use super::attributes::MeshFile;
use super::draft::{Checked, Draft, Fault, Numbers};
use super::text::{quoted, words};
use catamaran::base::{Result, room};
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

/// Most facets that are read at a time.
const BLOCK: usize = 1 << 14;

/// Number of bytes of a file that are read to tell text from binary.
const LOOK: usize = 1 << 12;

pub(super) fn read(source: &mut Source<'_>) -> Result<MeshFile> {
    let start = source.fill_buf().map(|start| &start[..start.len().min(LOOK)]);
    // Binary files may begin with the word solid, too, and text with comments.
    let is_text = start.map(|start| {
        // A file of DOS may end in Ctrl-Z.
        let text = |&byte: &u8| matches!(byte, b'\t'..=b'\r' | 0x1a | b' '..=b'~' | 0x80..);
        start.iter().all(text)
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
    numbers: Numbers,
}

impl Soup {
    fn push(&mut self, corners: [[f64; 3]; 3], place: impl FnOnce() -> String) -> Checked<()> {
        let mut face = [0; 3];
        for (number, position) in face.iter_mut().zip(corners) {
            let vertices = &self.draft.vertices;
            let is_new;
            (*number, is_new) = self.numbers.of(bits(position), |v| vertices[v] == position)?;
            if is_new {
                self.draft.push_vertex(position)?;
            }
        }
        Ok(self.draft.push_triangle(face, place)?)
    }
}

fn binary(source: &mut Source<'_>, soup: &mut Soup) -> Checked<()> {
    let mut header = [0; HEADER + 4];
    let (read, stopped) = read_up_to(source, &mut header);
    if read < header.len() {
        return Err(truncated("the header", stopped, source));
    }
    let count = u32::from_le_bytes([header[80], header[81], header[82], header[83]]);
    // Programs that write while they compute leave one of these in place of the number.
    let is_counted = count != 0 && count != u32::MAX;
    let counted = if is_counted { count as usize } else { 0 };
    let mut facets = Facets { soup, done: 0, colored: 0 };
    let mut block = vec![0; FACET * counted.min(BLOCK)];
    while facets.done < counted {
        let wanted = FACET * (counted - facets.done).min(BLOCK);
        let (read, stopped) = read_up_to(source, &mut block[..wanted]);
        let name = |f: usize| format!("facet {f} of {count}");
        facets.add(&block[..read], name)?;
        if read < wanted {
            return Err(truncated(&name(facets.done), stopped, source));
        }
    }
    let rest = source.read_all()?;
    let tail = &rest[rest.len() / FACET * FACET..];
    // Zeros fill a block of a disk.
    let is_facets = !is_counted || (tail.is_empty() && rest.iter().any(|&byte| byte != 0));
    if is_facets {
        facets.add(&rest, |f| format!("facet {f}"))?;
    }
    let Facets { done, colored, .. } = facets;
    let notes = &mut soup.draft.notes;
    let what = "left out colours, or other numbers in their place, of facets";
    notes.add_many(what, colored, String::new);
    if done > counted {
        let what = format!("took the number of facets from the size, not {count} of the header");
        notes.add_many(what, done, String::new);
    }
    let left_out = if is_facets { tail.len() } else { rest.len() };
    notes.add_many("left out bytes after the last facet", left_out, String::new);
    Ok(())
}

/// Reads until the buffer is full, the file ends, or an error, which it returns. Returns the number
/// of bytes read, too.
fn read_up_to(source: &mut Source<'_>, out: &mut [u8]) -> (usize, Option<io::Error>) {
    let mut count = 0;
    while count < out.len() {
        match source.read(&mut out[count..]) {
            Ok(0) => break,
            Ok(more) => count += more,
            Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
            Err(e) => return (count, Some(e)),
        }
    }
    (count, None)
}

/// Returns the error of a file of which `what` was not read to its end.
fn truncated(what: &str, stopped: Option<io::Error>, source: &Source<'_>) -> Fault {
    match stopped {
        Some(e) if e.kind() != io::ErrorKind::UnexpectedEof => Fault::Error(source.io_error(e)),
        _ => format!("truncated: {what} is incomplete").into(),
    }
}

/// The facets of a binary file that were read so far.
struct Facets<'s> {
    soup: &'s mut Soup,
    done: usize,
    /// Number of those with colours, or other numbers in their place.
    colored: usize,
}

impl Facets<'_> {
    /// Adds the whole facets of these bytes, each of which is a normal, three corners, and two
    /// bytes of attributes. `name` returns the name of a facet with this number.
    fn add(&mut self, bytes: &[u8], name: impl Fn(usize) -> String) -> Checked<()> {
        let (facets, _) = bytes.as_chunks::<FACET>();
        room(&mut self.soup.draft.faces, facets.len())?;
        for bytes in facets {
            let x = |i: usize| {
                let at = 12 + 4 * i;
                let bytes = [bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]];
                f64::from(f32::from_le_bytes(bytes))
            };
            let corners = [[x(0), x(1), x(2)], [x(3), x(4), x(5)], [x(6), x(7), x(8)]];
            self.colored += usize::from(bytes[FACET - 2..] != [0; 2]);
            let place = || name(self.done);
            self.soup.push(corners, place).map_err(|fault| fault.of(place))?;
            self.done += 1;
        }
        Ok(())
    }
}

/// The part of a text file that was read so far.
#[derive(Default)]
struct Text {
    /// Whether a solid has begun and not yet ended, and the same of a facet.
    in_solid: bool,
    in_facet: bool,
    /// Whether a statement has followed the beginning of the facet.
    is_followed: bool,
    corners: Vec<[f64; 3]>,
    /// Whether any statement was one of STL, and the line of the first that was not.
    is_stl: bool,
    unknown: Option<(String, usize)>,
}

fn text(source: &mut Source<'_>, soup: &mut Soup) -> Result<()> {
    let mut text = Text::default();
    loop {
        let number = source.line() + 1;
        let Some(line) = source.next_bytes()? else { break };
        text.line(line, number, soup).map_err(|fault| fault.at(source))?;
    }
    let Text { in_solid, in_facet, is_stl, unknown, .. } = text;
    match unknown {
        _ if in_facet => Err(source.fail("truncated: the last facet has no endfacet")),
        Some((word, line)) if !is_stl => {
            Err(source.fail_at(line, format!("{word} is not a statement of STL")))
        }
        None if !is_stl => Err(source.fail("not STL: it has no solid")),
        _ => {
            let last = format!("line {}", source.line());
            let what = "the last solid has no endsolid; lines after it may be missing";
            soup.draft.notes.add_many(what, usize::from(in_solid), || last);
            Ok(())
        }
    }
}

/// Skips the words before the next statement in a facet, and returns whether there were any.
fn skip_to_statement<'a>(words: &mut Peekable<impl Iterator<Item = &'a [u8]>>) -> bool {
    const STATEMENTS: [&[u8]; 4] = [b"outer", b"vertex", b"endloop", b"endfacet"];
    let is_other = |word: &&[u8]| !STATEMENTS.iter().any(|s| s.eq_ignore_ascii_case(word));
    let mut any = false;
    while words.next_if(is_other).is_some() {
        any = true;
    }
    any
}

/// Skips the name of a solid: up to the end of the line, or a facet with its normal.
fn skip_name<'a>(words: &mut Peekable<impl Iterator<Item = &'a [u8]> + Clone>) {
    loop {
        let mut ahead = words.clone();
        let is = |word: Option<&[u8]>, known: &str| {
            word.is_some_and(|word| word.eq_ignore_ascii_case(known.as_bytes()))
        };
        let begins_facet = is(ahead.next(), "facet") && is(ahead.next(), "normal");
        if begins_facet || words.next().is_none() {
            return;
        }
    }
}

impl Text {
    /// Reads the statements of a line: most programs write one.
    fn line(&mut self, line: &[u8], number: usize, soup: &mut Soup) -> Checked<()> {
        let mut words = words(line).peekable();
        while words.peek().is_some() {
            self.statement(&mut words, number, soup)?;
        }
        Ok(())
    }

    fn statement<'a>(
        &mut self,
        words: &mut Peekable<impl Iterator<Item = &'a [u8]> + Clone>,
        line_number: usize,
        soup: &mut Soup,
    ) -> Checked<()> {
        let Some(keyword) = words.next() else { return Ok(()) };
        let place = || format!("line {line_number}");
        // Longer words are no statements.
        let mut lower = [0; 8];
        let lower = lower.get_mut(..keyword.len()).unwrap_or_default();
        lower.copy_from_slice(&keyword[..lower.len()]);
        lower.make_ascii_lowercase();
        let lower = &*lower;
        if self.in_facet && matches!(lower, b"facet" | b"endsolid") {
            if self.corners.len() == 3 {
                soup.draft.notes.add("took facets without an endfacet", place);
                self.end_facet(soup, place)?;
            }
            // The words that began a facet were part of the name of the solid.
            self.in_facet &= self.is_followed;
        }
        match lower {
            b"solid" if !self.in_facet => {
                self.in_solid = true;
                skip_name(words);
            }
            b"endsolid" if !self.in_facet => {
                self.in_solid = false;
                // The name of the next solid may follow in the line.
                skip_name(words);
                self.in_solid |= words.peek().is_some();
            }
            b"facet" if !self.in_facet => {
                (self.in_facet, self.is_followed) = (true, false);
                skip_to_statement(words);
            }
            b"outer" | b"endloop" if self.in_facet => {
                self.is_followed = true;
                skip_to_statement(words);
            }
            b"vertex" if self.in_facet => {
                if self.corners.len() == 3 {
                    return Err("a facet has more than three vertices".into());
                }
                self.is_followed = true;
                self.corners.push(super::text::numbers(words)?);
                if skip_to_statement(words) {
                    let what = "left out words after the three numbers of vertices";
                    soup.draft.notes.add(what, place);
                }
            }
            b"endfacet" if self.in_facet => self.end_facet(soup, place)?,
            b"solid" | b"endsolid" | b"facet" | b"outer" | b"endloop" | b"vertex" | b"endfacet" => {
                return Err(format!("{} is out of place", quoted(keyword)).into());
            }
            _ => {
                self.unknown.get_or_insert_with(|| (quoted(keyword), line_number));
                soup.draft.notes.add("skipped lines that are not of STL", || {
                    format!("line {line_number} ({})", quoted(keyword))
                });
                words.for_each(drop);
                return Ok(());
            }
        }
        self.is_stl = true;
        Ok(())
    }

    fn end_facet(&mut self, soup: &mut Soup, place: impl Fn() -> String) -> Checked<()> {
        let &[a, b, c] = self.corners.as_slice() else {
            let count = self.corners.len();
            return Err(format!("a facet has {count} vertices, not 3").into());
        };
        soup.push([a, b, c], place)?;
        self.corners.clear();
        self.in_facet = false;
        Ok(())
    }
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
