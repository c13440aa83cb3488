//! Wavefront OBJ (Wavefront Technologies, Advanced Visualizer manual, appendix B1). Only polygons
//! are read. Colours follow the positions, as MeshLab and Blender write them, or are in comments
//! that begin with #MRGB, as ZBrush writes them.

use std::io::{self, Write};

use super::super::TriMesh;
use super::attributes::{Attribute, MeshFile};
use super::colors::Colors;
use super::draft::{Checked, Draft, Fault, Numbers};
use super::labels::{Labels, clean_name};
use super::polygon::fan;
use super::text::{integer, number, numbers, quoted, uncommented, words};
use catamaran::base::{Result, push};
use catamaran::io::Source;

/// A corner without texture coordinates or normal.
const ABSENT: u32 = u32::MAX;

/// An index that no item has.
const MISSING: u32 = ABSENT - 1;

/// Statements about the appearance of triangles, which are skipped and counted.
const LOOKS: [&[u8]; 12] = [
    b"mg",
    b"usemap",
    b"maplib",
    b"bevel",
    b"lod",
    b"c_interp",
    b"d_interp",
    b"shadow_obj",
    b"trace_obj",
    b"vp",
    b"call",
    b"csh",
];

/// Statements that do not describe polygons, which are skipped and counted.
#[rustfmt::skip]
const NOT_POLYGONS: [&[u8]; 19] = [
    b"l", b"p", b"cstype", b"deg", b"bmat", b"step", b"curv", b"curv2", b"surf", b"parm", b"trim",
    b"hole", b"scrv", b"sp", b"end", b"con", b"ctech", b"stech", b"res",
];

pub(super) fn read(source: &mut Source<'_>) -> Result<MeshFile> {
    let mut reader = Reader::default();
    let mut joined = Vec::new();
    loop {
        let number = source.line() + 1;
        let Some(line) = source.next_bytes()? else { break };
        let read = match (continued(line), joined.is_empty()) {
            (Some(start), _) => {
                let room = joined.try_reserve(start.len() + 1);
                joined.extend_from_slice(start);
                joined.push(b' ');
                // A statement may be as long as a single line may be.
                if room.is_err() || joined.len() > 1 << 24 {
                    Err(Fault::from("a statement over several lines of more than 16 MiB"))
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
    // The last line may continue on none.
    let read = reader.statement(&joined, source.line());
    read.map_err(|fault| fault.at(source))?;
    reader.finish(source)
}

/// Returns a line that continues on the next one, without the backslash at its end, which blanks
/// may follow. A comment does not continue: the name of a folder may end it.
fn continued(line: &[u8]) -> Option<&[u8]> {
    let start = line.trim_ascii_end().strip_suffix(b"\\")?;
    (uncommented(start).len() == start.len()).then_some(start)
}

#[derive(Default)]
struct Reader {
    draft: Draft,
    colors: Colors,
    /// The colours of comments that begin with #MRGB.
    polypaint: Vec<[f64; 4]>,
    uv: Values<2>,
    normals: Values<3>,
    vertex_refs: Furthest,
    /// Corners of the current face: vertices, and the indices of their attributes.
    corners: Vec<u32>,
    uv_corners: Vec<u32>,
    normal_corners: Vec<u32>,
    materials: Names,
    groups: Names,
    objects: Names,
    material_files: Vec<String>,
    /// Whether the first vertex has two coordinates.
    is_planar: Option<bool>,
    /// Whether any statement was one of OBJ, and the line of the first that was not.
    is_obj: bool,
    unknown: Option<(String, usize)>,
}

impl Reader {
    fn statement(&mut self, line: &[u8], number: usize) -> Checked<()> {
        let mut words = words(uncommented(line));
        let Some(keyword) = words.next() else { return self.polypaint(line, number) };
        let faces = self.draft.faces.len();
        // A name may contain a #, so names keep what other statements take for a comment.
        let rest = || line.trim_ascii_start().get(keyword.len()..).unwrap_or_default();
        match keyword {
            b"v" => self.vertex(words, number)?,
            b"vt" => self.uv.statement(words, &mut self.draft, number)?,
            b"vn" => self.normals.statement(words, &mut self.draft, number)?,
            b"f" | b"fo" => self.face(words, number)?,
            b"usemtl" => self.materials.begin(rest(), faces)?,
            b"g" => self.groups.begin(rest(), faces)?,
            b"o" => self.objects.begin(rest(), faces)?,
            b"mtllib" => {
                let name = name_of(rest());
                if !name.is_empty() {
                    push(&mut self.material_files, name)?;
                }
            }
            b"s" => self.smoothing(words, number),
            _ if LOOKS.contains(&keyword) => {
                let place = || format!("line {number} ({})", quoted(keyword));
                let what = "left out statements about the appearance of triangles";
                self.draft.notes.add(what, place);
            }
            _ if NOT_POLYGONS.contains(&keyword) => {
                self.draft
                    .notes
                    .add("left out lines, points and free-form geometry: statements", || {
                        format!("line {number} ({})", quoted(keyword))
                    });
            }
            _ => {
                self.unknown.get_or_insert_with(|| (quoted(keyword), number));
                self.draft.notes.add("skipped statements that are not of OBJ", || {
                    format!("line {number} ({})", quoted(keyword))
                });
                return Ok(());
            }
        }
        self.is_obj = true;
        Ok(())
    }

    fn vertex<'a>(
        &mut self,
        mut words: impl Iterator<Item = &'a [u8]>,
        line: usize,
    ) -> Checked<()> {
        let [x, y] = numbers(&mut words)?;
        let third = words.next();
        let z = match (*self.is_planar.get_or_insert(third.is_none()), third) {
            (false, Some(word)) => number(word)?,
            (false, None) => return Err("2 numbers where 3 are needed".into()),
            (true, Some(_)) => return Err("3 numbers where the first vertex has 2".into()),
            (true, None) => {
                self.draft
                    .notes
                    .add("took 0 for z, which is missing: vertices", || format!("line {line}"));
                0.0
            }
        };
        let position = [x, y, z];
        let mut color = [0.0, 0.0, 0.0, 1.0];
        let mut written = [&[][..]; 4];
        let mut given = 0;
        for word in words {
            given += 1;
            match (color.get_mut(given - 1), written.get_mut(given - 1), number(word)) {
                (Some(x), Some(place), Ok(value)) => (*x, *place) = (value, word),
                // No colour: these have 3 or 4 numbers.
                _ => given = 5,
            }
        }
        match given {
            // A fourth number is a weight, which only curves use.
            0 | 1 => {}
            3 | 4 => {
                self.colors.has_opacity |= given == 4;
                written[..given].iter().for_each(|word| self.colors.see(word));
                let color = self.draft.finite(color, || format!("line {line}"));
                push(&mut self.colors.values, color)?;
            }
            _ => {
                let what = "left out numbers after positions, which have 3 or 4 where they are \
                            colours: vertices";
                self.draft.notes.add(what, || format!("line {line}"));
            }
        }
        Ok(self.draft.push_vertex_or_lose(position, Some(line))?)
    }

    /// Notes a smoothing group; 0 and off end one.
    fn smoothing<'a>(&mut self, mut words: impl Iterator<Item = &'a [u8]>, line: usize) {
        if !matches!(words.next(), None | Some(b"0" | b"off")) {
            let what = "left out smoothing groups: statements";
            self.draft.notes.add(what, || format!("line {line}"));
        }
    }

    /// Reads the colours in a comment of ZBrush: a mask, red, green and blue of each vertex, of two
    /// hexadecimal digits each.
    fn polypaint(&mut self, line: &[u8], number: usize) -> Checked<()> {
        let Some(colors) = line.trim_ascii().strip_prefix(b"#MRGB") else { return Ok(()) };
        for digits in colors.trim_ascii().chunks(8) {
            let text = std::str::from_utf8(digits).ok().filter(|text| text.len() == 8);
            let Some(color) = text.and_then(|text| u32::from_str_radix(text, 16).ok()) else {
                let what = "left out colours (#MRGB) that are not hexadecimal numbers";
                self.draft.notes.add(what, || format!("line {number}"));
                continue;
            };
            let [_, r, g, b] = color.to_be_bytes().map(|byte| f64::from(byte) / 255.0);
            push(&mut self.polypaint, [r, g, b, 1.0])?;
        }
        Ok(())
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
            push(&mut self.uv_corners, self.uv.resolve(parts.next(), line)?)?;
            let normal = self.normals.resolve(parts.next(), line)?;
            push(&mut self.normal_corners, normal)?;
            if parts.next().is_some() {
                return Err(format!("{} is not a corner v/vt/vn", quoted(word)).into());
            }
        }
        let faces = self.draft.faces.len();
        let place = || format!("line {line}");
        if !self.draft.push_polygon(&self.corners, place)? {
            return Ok(());
        }
        let mixed = [
            self.uv.push_polygon(&self.uv_corners, faces)?,
            self.normals.push_polygon(&self.normal_corners, faces)?,
        ];
        let what = "left out texture coordinates or normals that some corners of a face lack";
        let count = mixed.iter().filter(|&&mixed| mixed).count();
        self.draft.notes.add_many(what, count, place);
        Ok(())
    }

    fn finish(mut self, source: &Source<'_>) -> Result<MeshFile> {
        if let (false, Some((word, line))) = (self.is_obj, &self.unknown) {
            return Err(source.fail_at(*line, format!("{word} is not a statement of OBJ")));
        }
        let (count, faces) = (self.draft.vertices.len(), self.draft.faces.len());
        self.vertex_refs.check("vertex", count, source, self.unknown.as_ref())?;
        self.uv.leave_out_missing("texture coordinates", &mut self.draft);
        self.normals.leave_out_missing("normals", &mut self.draft);
        let lost = self.draft.lost()?;
        let names = [&mut self.materials, &mut self.groups, &mut self.objects];
        names.into_iter().filter(|n| !n.names.is_empty()).try_for_each(|n| n.label(faces))?;
        let mut file = self.draft.finish(
            &mut [&mut self.uv.corners, &mut self.normals.corners],
            &mut [
                &mut self.materials.of_faces,
                &mut self.groups.of_faces,
                &mut self.objects.of_faces,
            ],
        )?;
        if self.colors.values.is_empty() {
            self.colors.values = self.polypaint;
        }
        let colors = self.colors.finish(count, &mut file.notes);
        lost.removed_from(MeshFile {
            uv: self.uv.finish(&file.mesh),
            normals: self.normals.finish(&file.mesh),
            colors,
            materials: self.materials.finish(),
            groups: self.groups.finish(),
            objects: self.objects.finish(),
            material_files: self.material_files,
            ..file
        })
    }
}

/// Returns the name after a keyword; bytes that are not UTF-8 are replaced.
fn name_of(rest: &[u8]) -> String {
    clean_name(&String::from_utf8_lossy(rest))
}

/// Names of which each holds for the faces after it.
#[derive(Default)]
struct Names {
    names: Vec<String>,
    numbers: Numbers,
    /// The index of the current name.
    current: Option<u32>,
    /// The name of each face before the current name.
    of_faces: Vec<u32>,
}

impl Names {
    /// Begins a name that holds from face `faces` on; an empty name ends the previous one.
    fn begin(&mut self, rest: &[u8], faces: usize) -> Checked<()> {
        self.label(faces)?;
        let name = name_of(rest);
        if name.is_empty() {
            self.current = None;
            return Ok(());
        }
        let words = name.bytes().map(u64::from);
        let (number, is_new) = self.numbers.of(words, |k| self.names[k] == name)?;
        if is_new {
            push(&mut self.names, name)?;
        }
        self.current = Some(number);
        Ok(())
    }

    /// Gives the current name to the faces before number `faces` that have none yet.
    fn label(&mut self, faces: usize) -> Result<()> {
        while self.of_faces.len() < faces {
            push(&mut self.of_faces, self.current.unwrap_or(Labels::ABSENT))?;
        }
        Ok(())
    }

    fn finish(self) -> Option<Labels> {
        let any = self.of_faces.iter().any(|&number| number != Labels::ABSENT);
        any.then_some(Labels { names: self.names, of_faces: self.of_faces })
    }
}

/// Returns the index from 0 of a number in a face: positive numbers count from 1, negative ones
/// backwards from the last of the `count` items so far. `None` where no item can have it.
fn index_of(number: i64, count: usize) -> Option<u32> {
    let index = match number {
        0 => None,
        1.. => u32::try_from(number - 1).ok(),
        _ => u32::try_from(number.saturating_add_unsigned(count as u64)).ok(),
    };
    index.filter(|&index| index < MISSING)
}

/// The largest index used so far, and its line: OBJ allows an index before the item that it names.
#[derive(Default)]
struct Furthest {
    end: usize,
    line: usize,
}

impl Furthest {
    /// Returns the index of a number in a face.
    fn resolve(&mut self, what: &str, word: &[u8], count: usize, line: usize) -> Checked<u32> {
        let number = integer(word)?;
        let wrong = || format!("{what} {number} is out of range: {count} so far");
        let index = index_of(number, count).ok_or_else(wrong)?;
        if index as usize >= self.end {
            *self = Self { end: index as usize + 1, line };
        }
        Ok(index)
    }

    /// Checks the largest index. The error names the statement that was not of OBJ: it may be the
    /// item that is missing.
    fn check(
        &self,
        what: &str,
        count: usize,
        source: &Source<'_>,
        unknown: Option<&(String, usize)>,
    ) -> Result<()> {
        if self.end <= count {
            return Ok(());
        }
        let mut why = format!("{what} {} is out of range: the file has {count}", self.end);
        if let Some((word, line)) = unknown {
            why += &format!("; {word} in line {line} is not a statement of OBJ");
        }
        Err(source.fail_at(self.line, why))
    }
}

/// The texture coordinates, or the normals.
struct Values<const N: usize> {
    values: Vec<[f64; N]>,
    /// The indices of each face, empty until a face has any.
    corners: Vec<[u32; 3]>,
    /// The line of the first index of an item that the file did not have there.
    ahead: Option<usize>,
}

impl<const N: usize> Default for Values<N> {
    fn default() -> Self {
        Self { values: Vec::new(), corners: Vec::new(), ahead: None }
    }
}

impl<const N: usize> Values<N> {
    fn statement<'a>(
        &mut self,
        mut words: impl Iterator<Item = &'a [u8]>,
        draft: &mut Draft,
        line: usize,
    ) -> Checked<()> {
        let mut value = [0.0; N];
        let needed = if N == 2 { 1 } else { N };
        let mut is_whole = true;
        for (i, x) in value.iter_mut().enumerate() {
            match words.next().map(number) {
                Some(Ok(given)) => *x = given,
                None if i >= needed => {}
                _ => is_whole = false,
            }
        }
        if !is_whole {
            let what = "took 0 for numbers of normals and texture coordinates that are missing";
            draft.notes.add(what, || format!("line {line}"));
        }
        let value = draft.finite(value, || format!("line {line}"));
        Ok(push(&mut self.values, value)?)
    }

    fn resolve(&mut self, word: Option<&[u8]>, line: usize) -> Checked<u32> {
        let Some(word) = word.filter(|word| !word.is_empty()) else { return Ok(ABSENT) };
        let index = index_of(integer(word)?, self.values.len()).unwrap_or(MISSING);
        if index as usize >= self.values.len() {
            self.ahead.get_or_insert(line);
        }
        Ok(index)
    }

    /// Takes the indices from triangles of which the file lacks an item of this kind, `what`.
    fn leave_out_missing(&mut self, what: &str, draft: &mut Draft) {
        let Some(line) = self.ahead else { return };
        let count = self.values.len();
        let lacks = |corners: &[u32; 3]| {
            *corners != [ABSENT; 3] && corners.iter().any(|&index| index as usize >= count)
        };
        let mut left_out = 0;
        for corners in self.corners.iter_mut().filter(|corners| lacks(corners)) {
            *corners = [ABSENT; 3];
            left_out += 1;
        }
        let what = format!("left out {what} that the file lacks, of triangles");
        draft.notes.add_many(what, left_out, || format!("line {line}"));
    }

    /// Adds the values of a polygon, as [`Draft::push_polygon`] does, after `faces` faces. Returns
    /// whether some corners have values and others have none; then the polygon gets none.
    fn push_polygon(&mut self, corners: &[u32], faces: usize) -> Result<bool> {
        let absent = corners.iter().filter(|&&corner| corner == ABSENT).count();
        if absent == corners.len() && self.corners.is_empty() {
            return Ok(false);
        }
        while self.corners.len() < faces {
            push(&mut self.corners, [ABSENT; 3])?;
        }
        for triangle in fan(corners) {
            push(&mut self.corners, if absent == 0 { triangle } else { [ABSENT; 3] })?;
        }
        Ok(absent != 0 && absent != corners.len())
    }

    fn finish(self, mesh: &TriMesh) -> Option<Attribute<N>> {
        let any = self.corners.iter().any(|corners| *corners != [ABSENT; 3]);
        any.then(|| Attribute::simplified(self.values, self.corners, mesh))
    }
}

pub(super) fn write(sink: &mut dyn Write, file: &MeshFile) -> io::Result<()> {
    let opaque = file.colors.iter().flatten().all(|color| color[3] == 1.0);
    // Readers take an empty file for one that was cut off.
    if file.mesh.vertices().is_empty() {
        writeln!(sink, "# no vertices")?;
    }
    for name in &file.material_files {
        writeln!(sink, "mtllib {name}")?;
    }
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
    let labels = [("o", &file.objects), ("g", &file.groups), ("usemtl", &file.materials)];
    let faces = file.mesh.faces();
    let uv = file.uv.as_ref().map_or(&[][..], |uv| uv.corners.as_deref().unwrap_or(faces));
    let normals = file.normals.as_ref().map_or(&[][..], |n| n.corners.as_deref().unwrap_or(faces));
    let of_face = |corners: &[[u32; 3]], f: usize| corners.get(f).copied().unwrap_or([ABSENT; 3]);
    for (f, face) in faces.iter().enumerate() {
        for (keyword, labels) in labels {
            let Some(labels) = labels else { continue };
            let before = f.checked_sub(1).and_then(|f| labels.of_face(f));
            match labels.of_face(f) {
                name if name == before => {}
                Some(name) => writeln!(sink, "{keyword} {name}")?,
                None => writeln!(sink, "{keyword}")?,
            }
        }
        let (uv, normals) = (of_face(uv, f), of_face(normals, f));
        write!(sink, "f")?;
        for i in 0..3 {
            // As u64, because the largest index plus one would not fit u32.
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
