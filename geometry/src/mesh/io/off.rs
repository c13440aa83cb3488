//! Geomview OFF (Phillips, Levy and Munzner 1993), ASCII, three-dimensional.

use std::fmt::Display;
use std::io::{self, Write};

use super::attributes::{Attribute, MeshFile};
use super::colors::Colors;
use super::draft::{Checked, Draft, Fault, roomy};
use super::text::{count, integer, number, quoted, words};
use catamaran::base::{Result, push};
use catamaran::io::Source;

/// The attributes of a vertex besides its position.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Kind {
    normals: bool,
    colors: bool,
    uv: bool,
}

/// The words of a file, regardless of line breaks.
struct Tokens<'s, 'a> {
    source: &'s mut Source<'a>,
    /// The last line without its comment, and how many of its bytes are consumed.
    line: Vec<u8>,
    taken: usize,
}

impl<'s, 'a> Tokens<'s, 'a> {
    fn new(source: &'s mut Source<'a>) -> Self {
        Self { source, line: Vec::new(), taken: 0 }
    }

    fn rest(&self) -> &[u8] {
        self.line.get(self.taken..).unwrap_or_default()
    }

    /// Returns the number of words left on the line, at most `COLOR + 3`.
    fn left(&self) -> usize {
        words(self.rest()).take(COLOR + 3).count()
    }

    /// Moves to the next line that has words; returns false at the end of the file.
    fn next_line(&mut self) -> Result<bool> {
        while self.left() == 0 {
            let Some(line) = self.source.next_bytes()? else { return Ok(false) };
            self.line.clear();
            self.line.extend(line.iter().take_while(|&&byte| byte != b'#'));
            self.taken = 0;
        }
        Ok(true)
    }

    /// Returns the next word; an error at the end of the file names `what`.
    fn next(&mut self, what: impl Display) -> Checked<&[u8]> {
        if !self.next_line()? {
            return Err(format!("truncated: the file ends before {what}").into());
        }
        let rest = self.rest();
        let start = rest.iter().take_while(|byte| byte.is_ascii_whitespace()).count();
        let length = rest.iter().skip(start).take_while(|byte| !byte.is_ascii_whitespace()).count();
        let start = self.taken + start;
        self.taken = start + length;
        Ok(self.line.get(start..self.taken).unwrap_or_default())
    }

    /// Returns the next `N` numbers, of `what`.
    fn numbers<const N: usize>(&mut self, what: impl Display) -> Checked<[f64; N]> {
        let mut values = [0.0; N];
        for (i, value) in values.iter_mut().enumerate() {
            *value = number(self.next(format_args!("{what} ({i} of {N} numbers)"))?)?;
        }
        Ok(values)
    }
}

pub(super) fn read(source: &mut Source<'_>) -> Result<MeshFile> {
    let mut tokens = Tokens::new(source);
    match Reader::read(&mut tokens) {
        Ok(reader) => reader.finish(),
        Err(fault) => Err(fault.at(tokens.source)),
    }
}

/// Parses the word OFF with its prefixes.
fn header(word: &[u8]) -> Checked<Kind> {
    let not_ours = || Fault::from(format!("{} is not OFF with prefixes ST, C, N", quoted(word)));
    kind_of(word).ok_or_else(not_ours)
}

/// Returns the attributes that the first word of a file announces, if the file is OFF.
pub(super) fn kind_of(word: &[u8]) -> Option<Kind> {
    let mut prefix = word.strip_suffix(b"OFF")?;
    let mut strip = |part: &[u8]| match prefix.strip_prefix(part) {
        Some(rest) => {
            prefix = rest;
            true
        }
        None => false,
    };
    let kind = Kind { uv: strip(b"ST"), colors: strip(b"C"), normals: strip(b"N") };
    prefix.is_empty().then_some(kind)
}

/// Reads the numbers of vertices and faces. The number of edges is ignored, and may be missing
/// where the other two are on one line.
fn counts(tokens: &mut Tokens<'_, '_>) -> Checked<[usize; 2]> {
    let what = "counts of vertices and faces";
    let vertices = count(tokens.next(what)?)?;
    let on_one_line = tokens.left() > 0;
    let faces = count(tokens.next(what)?)?;
    if tokens.left() > 0 || (!on_one_line && tokens.next_line()? && tokens.left() == 1) {
        count(tokens.next("count of edges")?)?;
    }
    Ok([vertices, faces])
}

/// Largest number of components of a colour.
const COLOR: usize = 4;

#[derive(Default)]
struct Reader {
    kind: Kind,
    draft: Draft,
    normals: Vec<[f64; 3]>,
    colors: Colors,
    uv: Vec<[f64; 2]>,
    polygon: Vec<u32>,
    /// Whether some line holds more than one vertex, or face: then all numbers are those that the
    /// header announces.
    packed: bool,
}

impl Reader {
    fn read(tokens: &mut Tokens<'_, '_>) -> Checked<Self> {
        let mut reader = Self { kind: header(tokens.next("header")?)?, ..Self::default() };
        if words(tokens.rest()).next() == Some(b"BINARY") {
            return Err("binary OFF files are not supported".into());
        }
        let [vertices, faces] = counts(tokens)?;
        reader.draft.vertices = roomy(vertices);
        for v in 0..vertices {
            reader.vertex(tokens, &format_args!("vertex {v} of {vertices}"))?;
        }
        reader.draft.faces = roomy(faces);
        reader.packed = false;
        for f in 0..faces {
            reader.face(tokens, &format_args!("face {f} of {faces}"))?;
        }
        if tokens.next_line()? {
            return Err("text after the last face".into());
        }
        Ok(reader)
    }

    fn vertex(&mut self, tokens: &mut Tokens<'_, '_>, what: &dyn Display) -> Checked<()> {
        self.draft.push_vertex(tokens.numbers(what)?)?;
        let line = tokens.source.line();
        let place = || format!("line {line}");
        if self.kind.normals {
            let normal = self.draft.finite(tokens.numbers(what)?, place);
            push(&mut self.normals, normal)?;
        }
        let uv = if self.kind.uv { 2 } else { 0 };
        self.packed |= tokens.left() > COLOR + uv;
        let least = uv + if self.kind.colors { 3 } else { 0 };
        // Texture coordinates come last, so one more number is the opacity. Some programs write
        // colours without the prefix.
        let given = if self.packed { least } else { tokens.left().max(least) };
        let mut rest = [0.0; COLOR + 2];
        for (i, value) in rest.iter_mut().take(given).enumerate() {
            let word = tokens.next(what)?;
            *value = number(word)?;
            if i < given - uv {
                self.colors.see(word);
            }
        }
        let rest = self.draft.finite(rest, place);
        let (color, uv) = rest[..given].split_at(given - uv);
        match *color {
            [] => {}
            [r, g, b] => push(&mut self.colors.values, [r, g, b, 1.0])?,
            [r, g, b, a] => {
                self.colors.has_opacity = true;
                push(&mut self.colors.values, [r, g, b, a])?;
            }
            _ => return Err(format!("a colour has 3 or 4 numbers, not {}", color.len()).into()),
        }
        if let [u, v] = *uv {
            push(&mut self.uv, [u, v])?;
        }
        Ok(())
    }

    fn face(&mut self, tokens: &mut Tokens<'_, '_>, what: &dyn Display) -> Checked<()> {
        let corners = count(tokens.next(what)?)?;
        self.polygon.clear();
        for i in 0..corners {
            let word = tokens.next(format_args!("{what} ({i} of {corners} corners)"))?;
            let vertex = integer(word)?;
            let count = self.draft.vertices.len();
            let known = u32::try_from(vertex).ok().filter(|&v| (v as usize) < count);
            let wrong =
                || format!("vertex {vertex} is out of range: {count} vertices, numbered from 0");
            push(&mut self.polygon, known.ok_or_else(wrong)?)?;
        }
        let line = tokens.source.line();
        let place = || format!("line {line}");
        // The rest of the line is a colour, unless it is the next face.
        let left = tokens.left();
        self.packed |= left > COLOR;
        if left > 0 && !self.packed {
            self.draft.notes.add("left out colours of faces", place);
            tokens.taken = tokens.line.len();
        }
        self.draft.push_polygon(&self.polygon, place)?;
        Ok(())
    }

    fn finish(self) -> Result<MeshFile> {
        let mut file = self.draft.finish(&mut [], &mut [])?;
        let count = file.mesh.vertices().len();
        if self.kind.normals && count > 0 {
            file.normals = Some(Attribute { values: self.normals, corners: None });
        }
        if self.kind.uv && count > 0 {
            file.uv = Some(Attribute { values: self.uv, corners: None });
        }
        file.colors = self.colors.finish(count, &mut file.notes);
        Ok(file)
    }
}

/// Writes colours or, where there are none, normals: other programs read OFF, COFF and NOFF, and
/// refuse the other prefixes.
pub(super) fn write(sink: &mut dyn Write, file: &MeshFile) -> io::Result<()> {
    let colors = file.colors.as_deref();
    let normals = file.normals.as_ref().and_then(Attribute::of_vertices);
    let normals = normals.filter(|_| colors.is_none());
    let prefix = match (colors, normals) {
        (Some(_), _) => "C",
        (None, Some(_)) => "N",
        (None, None) => "",
    };
    writeln!(sink, "{prefix}OFF")?;
    writeln!(sink, "{} {} 0", file.mesh.vertices().len(), file.mesh.faces().len())?;
    let opaque = colors.iter().copied().flatten().all(|color| color[3] == 1.0);
    for (v, position) in file.mesh.vertices().iter().enumerate() {
        let normal = normals.map_or(&[][..], |normals| &normals[v]);
        let color = colors.map_or(&[][..], |colors| &colors[v][..if opaque { 3 } else { 4 }]);
        let mut blank = "";
        for x in [&position[..], normal, color].concat() {
            write!(sink, "{blank}{x:?}")?;
            blank = " ";
        }
        writeln!(sink)?;
    }
    for [a, b, c] in file.mesh.faces() {
        writeln!(sink, "3 {a} {b} {c}")?;
    }
    Ok(())
}
