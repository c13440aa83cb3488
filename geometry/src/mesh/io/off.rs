//! Geomview OFF (Phillips, Levy and Munzner 1993), ASCII.

use std::fmt::Display;
use std::io::{self, Write};

use super::attributes::{Attribute, MeshFile};
use super::colors::Colors;
use super::draft::{Checked, Draft, roomy};
use super::text::{count, first_word, integer, number, quoted, uncommented, words};
use catamaran::base::{Result, push};
use catamaran::io::Source;

/// What the header says of the vertices.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Kind {
    normals: bool,
    colors: bool,
    uv: bool,
    /// Whether a weight follows the coordinates, by which they are divided.
    weighted: bool,
    /// Whether the number of coordinates is in the file.
    dimensions: bool,
}

/// The words of a file, regardless of line breaks.
struct Tokens<'s, 'a> {
    source: &'s mut Source<'a>,
    /// The last line without its comment, and how many of its bytes are consumed.
    line: Vec<u8>,
    taken: usize,
    /// The kind of element, vertex or face, for which [`Tokens::guess_color`] was called last, and
    /// what an error says of the first line with such an element.
    guess: Option<(&'static str, String)>,
}

impl<'s, 'a> Tokens<'s, 'a> {
    fn new(source: &'s mut Source<'a>) -> Self {
        Self { source, line: Vec::new(), taken: 0, guess: None }
    }

    fn rest(&self) -> &[u8] {
        self.line.get(self.taken..).unwrap_or_default()
    }

    /// Returns the number of words left on the line, at most [`MOST_LEFT`].
    fn left(&self) -> usize {
        words(self.rest()).take(MOST_LEFT).count()
    }

    /// Moves to the next line that has words; returns false at the end of the file.
    fn next_line(&mut self) -> Result<bool> {
        while first_word(self.rest()).is_none() {
            let Some(line) = self.source.next_bytes()? else { return Ok(false) };
            self.line.clear();
            self.line.extend_from_slice(uncommented(line));
            self.taken = 0;
        }
        Ok(true)
    }

    /// Records that the rest of the line is taken for the colour of an element although the header
    /// announces none. The words may be another element, which is then missing at the end of the
    /// file.
    fn guess_color(&mut self, element: &'static str) {
        if self.guess.as_ref().is_none_or(|(last, _)| *last != element) {
            let (line, rest) = (self.source.line(), quoted(self.rest().trim_ascii()));
            let text = format!("; in line {line}, {rest} was taken for the colour of a {element}");
            self.guess = Some((element, text));
        }
    }

    /// Returns the next word; an error at the end of the file names `what`.
    fn next(&mut self, what: impl Display) -> Checked<&[u8]> {
        if !self.next_line()? {
            let guess = self.guess.as_ref().map_or("", |(_, text)| text.as_str());
            return Err(format!("truncated: the file ends before {what}{guess}").into());
        }
        let (blanks, length) = first_word(self.rest()).unwrap_or_default();
        let start = self.taken + blanks;
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

/// Returns what the first word of a file says of the vertices, if the file is OFF, and the number
/// of digits after OFF: some programs write the number of vertices without a blank before it.
pub(super) fn kind_of(word: &[u8]) -> Option<(Kind, usize)> {
    if word == b"off" {
        return Some((Kind::default(), 0));
    }
    let end = word.windows(3).position(|part| part == b"OFF")?;
    let (mut prefix, digits) = (&word[..end], &word[end + 3..]);
    let mut kind = Kind::default();
    while !prefix.is_empty() {
        let (flag, length) = match prefix {
            [b'S', b'T', ..] => (&mut kind.uv, 2),
            [b'C', ..] => (&mut kind.colors, 1),
            [b'N', ..] => (&mut kind.normals, 1),
            [b'4', ..] => (&mut kind.weighted, 1),
            [b'n', ..] => (&mut kind.dimensions, 1),
            _ => return None,
        };
        *flag = true;
        prefix = &prefix[length..];
    }
    digits.iter().all(u8::is_ascii_digit).then_some((kind, digits.len()))
}

/// Reads the numbers of vertices and faces. The number of edges is ignored, and may be missing
/// where the other two are on one line.
fn counts(tokens: &mut Tokens<'_, '_>) -> Checked<[usize; 2]> {
    let what = "counts of vertices and faces";
    let vertices = count(tokens.next(what)?)?;
    let on_one_line = tokens.left() > 0;
    let faces = count(tokens.next(what)?)?;
    if tokens.left() > 0 || (!on_one_line && tokens.next_line()? && tokens.left() == 1) {
        integer(tokens.next("count of edges")?)?;
    }
    Ok([vertices, faces])
}

/// Largest number of components of a colour.
const COLOR: usize = 4;

/// Words of a line that are counted: those of two vertices with all attributes.
const MOST_LEFT: usize = 32;

#[derive(Default)]
struct Reader {
    kind: Kind,
    /// The number of coordinates of a vertex.
    dimensions: usize,
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
        let header = tokens.next("header")?;
        // The keyword may be missing: then the counts come first.
        let has_keyword = !header.iter().all(u8::is_ascii_digit);
        let (kind, digits) = match kind_of(header) {
            Some(found) => found,
            None if !has_keyword => (Kind::default(), header.len()),
            None => {
                let what = format!("{} is not OFF with prefixes ST, C, N, 4, n", quoted(header));
                return Err(what.into());
            }
        };
        tokens.taken -= digits;
        if words(tokens.rest()).next() == Some(b"BINARY") {
            let what = "binary OFF is not read: save it as text (OFF), or as binary PLY";
            return Err(what.into());
        }
        let dimensions =
            if kind.dimensions { count(tokens.next("number of coordinates")?)? } else { 3 };
        if dimensions == 0 {
            return Err("vertices without coordinates".into());
        }
        let mut reader = Self { kind, dimensions, ..Self::default() };
        if !has_keyword {
            let line = tokens.source.line();
            let what = "took OFF for the keyword, which is missing";
            reader.draft.notes.add(what, || format!("line {line}"));
        }
        let [vertices, faces] = counts(tokens)?;
        // No vertex of three coordinates is alone on this line.
        if tokens.left() == 1 && dimensions > 2 {
            let line = tokens.source.line();
            reader.draft.notes.add("left out a number after the counts", || format!("line {line}"));
            tokens.taken = tokens.line.len();
        }
        reader.draft.vertices = roomy(vertices);
        for v in 0..vertices {
            reader.vertex(tokens, &format_args!("vertex {v} of {vertices}"))?;
        }
        reader.draft.faces = roomy(faces);
        let shared = reader.packed && kind.colors;
        reader.packed = false;
        for f in 0..faces {
            reader.face(tokens, &format_args!("face {f} of {faces}"))?;
        }
        while tokens.next_line()? {
            if shared {
                let what = "numbers follow the last face: where vertices share a line, their \
                            colours have 3 numbers";
                return Err(what.into());
            }
            let line = tokens.source.line();
            reader.draft.notes.add("left out lines after the last face", || format!("line {line}"));
            tokens.taken = tokens.line.len();
        }
        Ok(reader)
    }

    /// Reads a position of any number of coordinates, of which the first three count, and which a
    /// weight may follow.
    fn position(&mut self, tokens: &mut Tokens<'_, '_>, what: &dyn Display) -> Checked<[f64; 3]> {
        if self.dimensions == 3 && !self.kind.weighted {
            return tokens.numbers(what);
        }
        let mut position = [0.0; 3];
        for k in 0..self.dimensions {
            let x = number(tokens.next(what)?)?;
            if let Some(place) = position.get_mut(k) {
                *place = x;
            }
        }
        let line = tokens.source.line();
        if self.dimensions > 3 {
            let what = "left out coordinates beyond the third, of vertices";
            self.draft.notes.add(what, || format!("line {line}"));
        }
        let weight = if self.kind.weighted { number(tokens.next(what)?)? } else { 1.0 };
        Ok(position.map(|x| x / weight))
    }

    fn vertex(&mut self, tokens: &mut Tokens<'_, '_>, what: &dyn Display) -> Checked<()> {
        let position = self.position(tokens, what)?;
        let line = tokens.source.line();
        self.draft.push_vertex_or_lose(position, Some(line))?;
        let place = || format!("line {line}");
        if self.kind.normals {
            let normal = self.draft.finite(tokens.numbers(what)?, place);
            push(&mut self.normals, normal)?;
        }
        let uv = if self.kind.uv { 2 } else { 0 };
        let least = uv + if self.kind.colors { 3 } else { 0 };
        let numbers = self.dimensions
            + usize::from(self.kind.weighted)
            + if self.kind.normals { 3 } else { 0 };
        let left = tokens.left();
        self.packed |= left > COLOR + uv && left >= least + numbers + least;
        // Some programs write colours without the prefix. Texture coordinates come after them, so
        // one number more is the opacity.
        let left = if self.packed { least } else { left.max(least) };
        let color = match left - uv {
            0..3 => 0,
            3 => 3,
            _ => COLOR,
        };
        if color > 0 && !self.kind.colors {
            tokens.guess_color("vertex");
        }
        let mut rest = [0.0; COLOR + 2];
        for (i, value) in rest.iter_mut().take(color + uv).enumerate() {
            let word = tokens.next(what)?;
            *value = number(word)?;
            if i < color {
                self.colors.see(word);
            }
        }
        if left > color + uv {
            self.draft.notes.add("left out numbers after the others, of vertices", place);
            tokens.taken = tokens.line.len();
        }
        let rest = self.draft.finite(rest, place);
        let (color, uv) = rest[..color + uv].split_at(color);
        match *color {
            [r, g, b] => push(&mut self.colors.values, [r, g, b, 1.0])?,
            [r, g, b, a] => {
                self.colors.has_opacity = true;
                push(&mut self.colors.values, [r, g, b, a])?;
            }
            _ => {}
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
            tokens.guess_color("face");
            self.draft.notes.add("left out colours of faces", place);
            tokens.taken = tokens.line.len();
        }
        self.draft.push_polygon(&self.polygon, place)?;
        Ok(())
    }

    fn finish(mut self) -> Result<MeshFile> {
        let lost = self.draft.lost()?;
        let mut file = self.draft.finish(&mut [], &mut [])?;
        let count = file.mesh.vertices().len();
        if self.kind.normals && count > 0 {
            file.normals = Some(Attribute { values: self.normals, corners: None });
        }
        if self.kind.uv && count > 0 {
            file.uv = Some(Attribute { values: self.uv, corners: None });
        }
        file.colors = self.colors.finish(count, &mut file.notes);
        lost.removed_from(file)
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
