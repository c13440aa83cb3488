//! Wavefront OBJ (Wavefront Technologies, Advanced Visualizer manual, appendix B1), of which polygons are read; colours
//! after positions as MeshLab and Blender write them.

use std::io::{self, Write};

use super::super::TriMesh;
use super::attributes::{Attribute, MeshFile};
use super::draft::{Checked, Draft, Fault, push};
use super::text::{finite, integer, number, numbers, quoted, scaled_colors, words};
use crate::base::Result;
use crate::io::Source;

/// A corner without texture coordinates or normal.
const ABSENT: u32 = u32::MAX;

/// Statements that say nothing about triangles.
#[rustfmt::skip]
const SKIPPED: [&[u8]; 36] = [
    b"o", b"g", b"s", b"mg", b"usemtl", b"mtllib", b"usemap", b"maplib", b"l", b"p", b"vp", b"bevel", b"lod",
    b"c_interp", b"d_interp", b"shadow_obj", b"trace_obj", b"cstype", b"deg", b"bmat", b"step", b"curv", b"curv2",
    b"surf", b"parm", b"trim", b"hole", b"scrv", b"sp", b"end", b"con", b"ctech", b"stech", b"call", b"csh", b"res",
];

pub(super) fn read(source: &mut Source<'_>) -> Result<MeshFile> {
    let mut reader = Reader::default();
    let mut joined = Vec::new();
    loop {
        let number = source.line() + 1;
        let Some(line) = source.next_bytes()? else { break };
        // A line that ends in a backslash goes on.
        let read = match (line.split_last(), joined.is_empty()) {
            (Some((b'\\', start)), _) => {
                let room = joined.try_reserve(start.len() + 1);
                joined.extend_from_slice(start);
                joined.push(b' ');
                // One statement is as long as one line may be.
                if room.is_err() || joined.len() > 1 << 24 {
                    Err(Fault::from("a statement that never ends"))
                } else {
                    Ok(())
                }
            }
            (_, true) => reader.statement(line, number),
            (_, false) => {
                joined.extend_from_slice(line);
                let read = reader.statement(&joined, number);
                joined.clear();
                read
            }
        };
        read.map_err(|fault| fault.at(source))?;
    }
    reader.finish(source)
}

#[derive(Default)]
struct Reader {
    draft: Draft,
    colors: Vec<[f64; 4]>,
    has_opacity: bool,
    uv: Values<2>,
    normals: Values<3>,
    vertex_refs: Furthest,
    /// Corners of the face at hand: vertices, and the numbers of their attributes.
    corners: Vec<u32>,
    uv_corners: Vec<u32>,
    normal_corners: Vec<u32>,
}

impl Reader {
    fn statement(&mut self, line: &[u8], number: usize) -> Checked<()> {
        let mut words = words(line.split(|&byte| byte == b'#').next().unwrap_or_default());
        match words.next() {
            None => Ok(()),
            Some(b"v") => self.vertex(words),
            Some(b"vt") => self.uv.statement(words),
            Some(b"vn") => self.normals.statement(words),
            Some(b"f" | b"fo") => self.face(words, number),
            Some(keyword) if SKIPPED.contains(&keyword) => Ok(()),
            Some(keyword) => Err(format!("{} is not a statement of OBJ", quoted(keyword)).into()),
        }
    }

    fn vertex<'a>(&mut self, mut words: impl Iterator<Item = &'a [u8]>) -> Checked<()> {
        let position = numbers::<3>(&mut words)?;
        let mut color = [0.0, 0.0, 0.0, 1.0];
        let mut given = 0;
        for word in words {
            if given == 4 {
                return Err("more than 7 numbers of a vertex".into());
            }
            color[given] = number(word)?;
            given += 1;
        }
        match given {
            // A fourth number is a weight, of which only curves know.
            0 | 1 => {}
            2 => return Err("5 numbers of a vertex".into()),
            _ => {
                self.has_opacity |= given == 4;
                push(&mut self.colors, finite(color)?)?;
            }
        }
        self.draft.push_vertex(position)
    }

    fn face<'a>(&mut self, words: impl Iterator<Item = &'a [u8]>, line: usize) -> Checked<()> {
        self.corners.clear();
        self.uv_corners.clear();
        self.normal_corners.clear();
        for word in words {
            let mut parts = word.split(|&byte| byte == b'/');
            let vertex = parts.next().unwrap_or_default();
            let count = self.draft.vertices.len();
            push(&mut self.corners, self.vertex_refs.resolve("vertex", vertex, count, line)?)?;
            let uv = self.uv.resolve("texture coordinate", parts.next(), line)?;
            push(&mut self.uv_corners, uv)?;
            let normal = self.normals.resolve("normal", parts.next(), line)?;
            push(&mut self.normal_corners, normal)?;
            if parts.next().is_some() {
                return Err(format!("{} is not a corner v/vt/vn", quoted(word)).into());
            }
        }
        let faces = self.draft.faces.len();
        self.draft.push_polygon(&self.corners)?;
        self.uv.push_polygon(&self.uv_corners, faces)?;
        self.normals.push_polygon(&self.normal_corners, faces)
    }

    fn finish(self, source: &Source<'_>) -> Result<MeshFile> {
        let count = self.draft.vertices.len();
        self.vertex_refs.check("vertex", count, source)?;
        let mesh = self.draft.finish()?;
        let colored = count > 0 && self.colors.len() == count;
        let colors = colored.then(|| scaled_colors(self.colors, self.has_opacity));
        let uv = self.uv.finish("texture coordinate", &mesh, source)?;
        let normals = self.normals.finish("normal", &mesh, source)?;
        Ok(MeshFile { uv, normals, colors, ..MeshFile::from(mesh) })
    }
}

/// Numbers may be used before what they number: the furthest such use.
#[derive(Default)]
struct Furthest {
    end: usize,
    line: usize,
}

impl Furthest {
    /// The number from 0 that a word means after `count` items: from 1, or from the last one backwards.
    fn resolve(&mut self, what: &str, word: &[u8], count: usize, line: usize) -> Checked<u32> {
        let number = integer(word)?;
        let index = match number {
            0 => None,
            1.. => u32::try_from(number - 1).ok().filter(|&index| index != ABSENT),
            _ => u32::try_from(number.saturating_add_unsigned(count as u64)).ok(),
        };
        let index = index.ok_or_else(|| format!("{what} {number} of {count}"))?;
        if index as usize >= self.end {
            *self = Self { end: index as usize + 1, line };
        }
        Ok(index)
    }

    fn check(&self, what: &str, count: usize, source: &Source<'_>) -> Result<()> {
        if self.end <= count {
            return Ok(());
        }
        Err(source.fail_at(self.line, format!("{what} {} of {count}", self.end)))
    }
}

/// Texture coordinates, or normals.
struct Values<const N: usize> {
    values: Vec<[f64; N]>,
    /// One for each face once a face had any.
    corners: Vec<[u32; 3]>,
    refs: Furthest,
}

impl<const N: usize> Default for Values<N> {
    fn default() -> Self {
        Self { values: Vec::new(), corners: Vec::new(), refs: Furthest::default() }
    }
}

impl<const N: usize> Values<N> {
    fn statement<'a>(&mut self, mut words: impl Iterator<Item = &'a [u8]>) -> Checked<()> {
        let mut value = [0.0; N];
        let needed = if N == 2 { 1 } else { N };
        for (i, x) in value.iter_mut().enumerate() {
            match words.next() {
                Some(word) => *x = number(word)?,
                None if i >= needed => {}
                None => return Err(format!("{i} numbers where {needed} are needed").into()),
            }
        }
        Ok(push(&mut self.values, finite(value)?)?)
    }

    fn resolve(&mut self, what: &str, word: Option<&[u8]>, line: usize) -> Checked<u32> {
        match word {
            None | Some([]) => Ok(ABSENT),
            Some(word) => self.refs.resolve(what, word, self.values.len(), line),
        }
    }

    /// As [`Draft::push_polygon`]; `faces` came before.
    fn push_polygon(&mut self, corners: &[u32], faces: usize) -> Checked<()> {
        let absent = corners.iter().filter(|&&corner| corner == ABSENT).count();
        if absent == corners.len() && self.corners.is_empty() {
            return Ok(());
        }
        if absent != 0 && absent != corners.len() {
            return Err("a face with corners of different kinds".into());
        }
        while self.corners.len() < faces {
            push(&mut self.corners, [ABSENT; 3])?;
        }
        for pair in corners[1..].windows(2) {
            push(&mut self.corners, [corners[0], pair[0], pair[1]])?;
        }
        Ok(())
    }

    fn finish(
        self,
        what: &str,
        mesh: &TriMesh,
        source: &Source<'_>,
    ) -> Result<Option<Attribute<N>>> {
        self.refs.check(what, self.values.len(), source)?;
        if self.corners.is_empty() {
            return Ok(None);
        }
        Ok(Some(Attribute::simplified(self.values, self.corners, mesh)))
    }
}

pub(super) fn write(sink: &mut dyn Write, file: &MeshFile) -> io::Result<()> {
    let opaque = file.colors.iter().flatten().all(|color| color[3] == 1.0);
    for (v, [x, y, z]) in file.mesh.vertices().iter().enumerate() {
        write!(sink, "v {x:?} {y:?} {z:?}")?;
        if let Some([r, g, b, a]) = file.colors.as_ref().map(|colors| colors[v]) {
            write!(sink, " {r:?} {g:?} {b:?}")?;
            if !opaque {
                write!(sink, " {a:?}")?;
            }
        }
        writeln!(sink)?;
    }
    for [u, v] in file.uv.iter().flat_map(|uv| &uv.values) {
        writeln!(sink, "vt {u:?} {v:?}")?;
    }
    for [x, y, z] in file.normals.iter().flat_map(|normals| &normals.values) {
        writeln!(sink, "vn {x:?} {y:?} {z:?}")?;
    }
    for (f, face) in file.mesh.faces().iter().enumerate() {
        let of = |corners: Option<&[[u32; 3]]>| corners.map_or([ABSENT; 3], |corners| corners[f]);
        let uv = of(file.uv.as_ref().map(|uv| uv.corners.as_deref().unwrap_or(file.mesh.faces())));
        let normals = file.normals.as_ref();
        let normals = of(normals.map(|n| n.corners.as_deref().unwrap_or(file.mesh.faces())));
        write!(sink, "f")?;
        for i in 0..3 {
            // From 1, as u64: the highest number plus one would not fit.
            let [v, t, n] = [face[i], uv[i], normals[i]].map(|number| u64::from(number) + 1);
            match (uv[i], normals[i]) {
                (ABSENT, ABSENT) => write!(sink, " {v}")?,
                (_, ABSENT) => write!(sink, " {v}/{t}")?,
                (ABSENT, _) => write!(sink, " {v}//{n}")?,
                _ => write!(sink, " {v}/{t}/{n}")?,
            }
        }
        writeln!(sink)?;
    }
    Ok(())
}
