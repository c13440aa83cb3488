//! Geomview OFF (Phillips, Levy and Munzner 1993), ASCII, of three dimensions; one vertex or face a line.

use std::io::{self, Write};

use super::attributes::{Attribute, MeshFile};
use super::draft::{Checked, Draft, Fault, push, roomy};
use super::text::{count, finite, integer, number, numbers, quoted, scaled_colors, words};
use crate::base::Result;
use crate::io::Source;

/// What a vertex has besides its position.
#[derive(Debug, Clone, Copy, Default)]
struct Kind {
    normals: bool,
    colors: bool,
    uv: bool,
}

pub(super) fn read(source: &mut Source<'_>) -> Result<MeshFile> {
    let mut kind = Kind::default();
    let mut sizes = None;
    content(source, &"header", |line| {
        (kind, sizes) = header(line)?;
        Ok(())
    })?;
    let [vertices, faces] = match sizes {
        Some(sizes) => sizes,
        None => content(source, &"line of counts", |line| counts(words(line)))?,
    };

    let mut reader = Reader { kind, ..Reader::default() };
    reader.draft.vertices = roomy(vertices);
    for v in 0..vertices {
        content(source, &format_args!("vertex {v} of {vertices}"), |line| reader.vertex(line))?;
    }
    reader.draft.faces = roomy(faces);
    for f in 0..faces {
        content(source, &format_args!("face {f} of {faces}"), |line| reader.face(line))?;
    }
    while let Some(line) = source.next_bytes()? {
        if words(bare(line)).next().is_some() {
            return Err(source.fail("text after the faces announced"));
        }
    }
    reader.finish()
}

/// A line without its comment.
fn bare(line: &[u8]) -> &[u8] {
    line.split(|&byte| byte == b'#').next().unwrap_or_default()
}

/// What `read` makes of the next line that says something.
fn content<T>(
    source: &mut Source<'_>,
    what: &dyn std::fmt::Display,
    mut read: impl FnMut(&[u8]) -> Checked<T>,
) -> Result<T> {
    loop {
        let Some(line) = source.next_bytes()? else {
            return Err(source.fail(format!("truncated: no {what}")));
        };
        let line = bare(line);
        if words(line).next().is_some() {
            return read(line).map_err(|fault| fault.at(source));
        }
    }
}

/// The word OFF with its prefixes, and counts if they are on the same line.
fn header(line: &[u8]) -> Checked<(Kind, Option<[usize; 2]>)> {
    let mut words = words(line);
    let word = words.next().unwrap_or_default();
    let not_ours = || Fault::from(format!("{} is not OFF with prefixes ST, C, N", quoted(word)));
    let mut prefix = word.strip_suffix(b"OFF").ok_or_else(not_ours)?;
    let mut strip = |part: &[u8]| match prefix.strip_prefix(part) {
        Some(rest) => {
            prefix = rest;
            true
        }
        None => false,
    };
    let kind = Kind { uv: strip(b"ST"), colors: strip(b"C"), normals: strip(b"N") };
    if !prefix.is_empty() {
        return Err(not_ours());
    }
    let mut rest = words.peekable();
    match rest.peek() {
        None => Ok((kind, None)),
        Some(&word) if word == b"BINARY" => Err("binary OFF files are not read".into()),
        Some(_) => Ok((kind, Some(counts(rest)?))),
    }
}

/// Numbers of vertices and faces; that of edges, which may be missing, says nothing.
fn counts<'a>(mut words: impl Iterator<Item = &'a [u8]>) -> Checked<[usize; 2]> {
    let mut next =
        || words.next().ok_or_else(|| Fault::from("counts of vertices and faces missing"));
    Ok([count(next()?)?, count(next()?)?])
}

#[derive(Default)]
struct Reader {
    kind: Kind,
    draft: Draft,
    normals: Vec<[f64; 3]>,
    colors: Vec<[f64; 4]>,
    has_opacity: bool,
    uv: Vec<[f64; 2]>,
    polygon: Vec<u32>,
}

impl Reader {
    fn vertex(&mut self, line: &[u8]) -> Checked<()> {
        let mut words = words(line);
        self.draft.push_vertex(numbers(&mut words)?)?;
        if self.kind.normals {
            push(&mut self.normals, finite(numbers(&mut words)?)?)?;
        }
        // Texture coordinates come last, so the opacity is there when one more number is.
        let mut rest = [0.0; 6];
        let mut given = 0;
        for word in words {
            *rest.get_mut(given).ok_or("too many numbers")? = number(word)?;
            given += 1;
        }
        let rest = &finite(rest)?[..given];
        let (colors, uv) = rest.split_at(given - if self.kind.uv { 2.min(given) } else { 0 });
        match (colors, self.kind.colors) {
            ([], false) => {}
            // Some write colours without saying so.
            (&[r, g, b], _) => push(&mut self.colors, [r, g, b, 1.0])?,
            (&[r, g, b, a], _) => {
                self.has_opacity = true;
                push(&mut self.colors, [r, g, b, a])?;
            }
            (others, _) => return Err(format!("{} numbers of a colour", others.len()).into()),
        }
        match (uv, self.kind.uv) {
            ([], false) => Ok(()),
            (&[u, v], _) => Ok(push(&mut self.uv, [u, v])?),
            _ => Err("texture coordinates missing".into()),
        }
    }

    fn face(&mut self, line: &[u8]) -> Checked<()> {
        let mut words = words(line);
        let corners = count(words.next().unwrap_or_default())?;
        self.polygon.clear();
        for i in 0..corners {
            let word = words.next().ok_or_else(|| format!("{i} of {corners} corners"))?;
            let vertex = integer(word)?;
            let count = self.draft.vertices.len();
            let known = u32::try_from(vertex).ok().filter(|&v| (v as usize) < count);
            push(&mut self.polygon, known.ok_or_else(|| format!("vertex {vertex} of {count}"))?)?;
        }
        // What follows is a colour of the face.
        self.draft.push_polygon(&self.polygon)
    }

    fn finish(self) -> Result<MeshFile> {
        let mesh = self.draft.finish()?;
        let count = mesh.vertices().len();
        let mut file = MeshFile::from(mesh);
        if self.kind.normals && count > 0 {
            file.normals = Some(Attribute { values: self.normals, corners: None });
        }
        if self.kind.uv && count > 0 {
            file.uv = Some(Attribute { values: self.uv, corners: None });
        }
        if count > 0 && self.colors.len() == count {
            file.colors = Some(scaled_colors(self.colors, self.has_opacity));
        }
        Ok(file)
    }
}

pub(super) fn write(sink: &mut dyn Write, file: &MeshFile) -> io::Result<()> {
    let normals = file.normals.as_ref().and_then(Attribute::of_vertices);
    let uv = file.uv.as_ref().and_then(Attribute::of_vertices);
    let colors = file.colors.as_deref();
    let prefix = |there: bool, prefix| if there { prefix } else { "" };
    let st = prefix(uv.is_some(), "ST");
    let c = prefix(colors.is_some(), "C");
    let n = prefix(normals.is_some(), "N");
    writeln!(sink, "{st}{c}{n}OFF")?;
    writeln!(sink, "{} {} 0", file.mesh.vertices().len(), file.mesh.faces().len())?;
    let opaque = colors.iter().copied().flatten().all(|color| color[3] == 1.0);
    for (v, position) in file.mesh.vertices().iter().enumerate() {
        let normal = normals.map_or(&[][..], |normals| &normals[v]);
        let color = colors.map_or(&[][..], |colors| &colors[v][..if opaque { 3 } else { 4 }]);
        let uv = uv.map_or(&[][..], |uv| &uv[v]);
        let mut blank = "";
        for x in [&position[..], normal, color, uv].concat() {
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
