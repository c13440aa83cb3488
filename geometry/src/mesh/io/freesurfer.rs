//! FreeSurfer: surfaces of brains (`.white`, `.pial` and others), values of their vertices
//! (`.curv`, `.thickness` and others) and labels of their vertices (`.annot`), all big endian;
//! surfaces in text (`.asc`), too.
//!
//! Formats: "Surface files", "Curv files" and "Label and annotation files" (FreeSurfer wiki,
//! FileFormats).

use std::collections::HashMap;

use super::attributes::{MeshFile, Scalars};
use super::cursor::Cursor;
use super::dataset::{Dataset, Ends, Lists, cell};
use super::draft::{Checked, roomy};
use super::format::MeshFormat;
use super::stored::{Indices, Kind, whole};
use catamaran::base::{Result, push};
use catamaran::io::Source;

/// The first bytes of files. Those of old surfaces are also those of values, of which the size is
/// known from the header.
const TRIANGLES: &[u8] = b"\xff\xff\xfe";
const QUADS: &[u8] = b"\xff\xff\xfd";
const OLD_QUADS: &[u8] = b"\xff\xff\xff";

/// The beginning of surfaces in text, as `mris_convert` writes them (`.asc`).
const TEXT: &[u8] = b"#!ascii";

/// Returns whether a file that begins so has a surface or values of vertices.
pub(super) fn begins(head: &[u8]) -> bool {
    [TRIANGLES, QUADS, OLD_QUADS, TEXT].iter().any(|magic| head.starts_with(magic))
}

pub(super) fn read(source: &mut Source<'_>) -> Result<MeshFile> {
    let bytes = source.read_all()?;
    let mut cursor = Cursor::new(&bytes);
    match surface(&mut cursor) {
        Ok(dataset) => dataset.finish(),
        Err(fault) => Err(cursor.fail(fault, source)),
    }
}

/// Reads the values or labels of vertices.
pub(super) fn scalars(source: &mut Source<'_>) -> Result<Vec<Scalars>> {
    let name = MeshFormat::ending(source.path());
    let bytes = source.read_all()?;
    let mut cursor = Cursor::new(&bytes);
    let values =
        if name == "annot" { labels(&mut cursor) } else { values_of_vertices(&mut cursor) };
    match values {
        Ok(values) => Ok(vec![Scalars { name, values }]),
        Err(fault) => Err(cursor.fail(fault, source)),
    }
}

/// Returns the integer in the next bytes.
fn integer(cursor: &mut Cursor<'_>, what: &str) -> Checked<usize> {
    whole(cursor.stored(Kind::I32, true, what)?)
}

/// Returns the integer of three bytes at the start of `bytes`.
fn short(bytes: &[u8]) -> f64 {
    bytes.iter().take(3).fold(0.0, |sum, &byte| 256.0 * sum + f64::from(byte))
}

fn surface(cursor: &mut Cursor<'_>) -> Checked<Dataset> {
    if cursor.rest().starts_with(TEXT) {
        return text_surface(cursor);
    }
    let mut dataset = Dataset::default();
    let magic = cursor.bytes(3, "the header")?;
    if magic == TRIANGLES {
        // Who made the file, and an empty line.
        cursor.line();
        cursor.line();
        let vertices = integer(cursor, "the header")?;
        let faces = integer(cursor, "the header")?;
        let coordinates = 3usize.saturating_mul(vertices);
        dataset.points(&cursor.numbers(coordinates, Some((Kind::F32, true)), "the vertices")?)?;
        let corners = 3usize.saturating_mul(faces);
        let corners = cursor.indices(corners, (Kind::I32, true), "the faces")?;
        let lists = Lists { corners, ends: Ends::Each(3, faces) };
        dataset.cells(&lists, 0, |_| Ok(cell::TRIANGLE))?;
        return Ok(dataset);
    }
    if magic != QUADS && magic != OLD_QUADS {
        return Err("does not begin as a surface of FreeSurfer".into());
    }
    if magic == OLD_QUADS && is_values(cursor.rest()) {
        let what = "has values of vertices, but no surface: read the file of the surface, and this \
                    one as its functions (read_scalars, or filter --functions)";
        return Err(what.into());
    }
    let vertices = whole(short(cursor.bytes(3, "the header")?))?;
    let faces = whole(short(cursor.bytes(3, "the header")?))?;
    let coordinates = 3 * vertices;
    let points = if magic == QUADS {
        cursor.numbers(coordinates, Some((Kind::F32, true)), "the vertices")?
    } else {
        // Hundredths of a millimetre.
        let stored = cursor.numbers(coordinates, Some((Kind::I16, true)), "the vertices")?;
        stored.into_iter().map(|x| x / 100.0).collect()
    };
    dataset.points(&points)?;
    let corners = cursor.bytes(12 * faces, "the faces")?;
    let mut triangles = Vec::new();
    for quad in corners.chunks_exact(12) {
        let [a, b, c, d] = [0, 3, 6, 9].map(|at| short(&quad[at..]));
        // FreeSurfer takes either diagonal, by this number; nibabel and MNE by the parity of `a`.
        let which = ((1.9 * a).sqrt() + (3.5 * b).sqrt()).round();
        let cut = if which % 2.0 == 0.0 { [a, b, d, c, d, b] } else { [a, b, c, a, c, d] };
        for corner in cut {
            push(&mut triangles, corner)?;
        }
    }
    let corners = Indices::of_numbers(triangles)?;
    let lists = Lists { corners, ends: Ends::Each(3, 2 * faces) };
    dataset.cells(&lists, 0, |_| Ok(cell::TRIANGLE))?;
    Ok(dataset)
}

/// Reads a surface in text: who made it, the numbers of vertices and faces, and rows of three
/// numbers and a mark of what was cut away.
fn text_surface(cursor: &mut Cursor<'_>) -> Checked<Dataset> {
    let mut dataset = Dataset::default();
    cursor.line();
    let vertices = cursor.count("the number of vertices")?;
    let faces = cursor.count("the number of faces")?;
    let mut marked = 0;
    let mut rows = |count: usize, what: &str| -> Checked<Vec<f64>> {
        let mut values = roomy(count.saturating_mul(3));
        for i in 0..count {
            for _ in 0..3 {
                let number = cursor.number(format_args!("{what} {i} of {count}"))?;
                push(&mut values, number)?;
            }
            marked += usize::from(cursor.number("the mark of a row")? != 0.0);
        }
        Ok(values)
    };
    dataset.points(&rows(vertices, "vertex")?)?;
    let corners = Indices::of_numbers(rows(faces, "face")?)?;
    let what = "took vertices and faces that the file marks as cut away";
    dataset.draft.notes.add_many(what, marked, String::new);
    let lists = Lists { corners, ends: Ends::Each(3, faces) };
    dataset.cells(&lists, 0, |_| Ok(cell::TRIANGLE))?;
    Ok(dataset)
}

/// Returns whether what follows the first three bytes is a header of values of vertices, and as
/// many values.
fn is_values(rest: &[u8]) -> bool {
    let number = |at: usize| {
        let bytes = rest.get(at..at + 4)?.first_chunk::<4>()?;
        Some(u64::from(u32::from_be_bytes(*bytes)))
    };
    let (Some(vertices), Some(width)) = (number(0), number(8)) else { return false };
    vertices.checked_mul(4 * width).and_then(|size| size.checked_add(12)) == Some(rest.len() as u64)
}

fn values_of_vertices(cursor: &mut Cursor<'_>) -> Checked<Vec<f64>> {
    let magic = cursor.bytes(3, "the header")?;
    if magic == TRIANGLES || magic == QUADS || TEXT.starts_with(magic) {
        return Err("is a surface, without values of its vertices".into());
    }
    if magic != OLD_QUADS {
        // The old form begins with the number of vertices.
        let count = whole(short(magic))?;
        cursor.bytes(3, "the number of faces")?;
        let values = cursor.numbers(count, Some((Kind::I16, true)), "the values")?;
        // The old form has no other mark.
        if !cursor.rest().is_empty() {
            return Err("is no file of values of vertices".into());
        }
        return Ok(values.into_iter().map(|x| x / 100.0).collect());
    }
    let vertices = integer(cursor, "the number of vertices")?;
    integer(cursor, "the number of faces")?;
    match integer(cursor, "the number of values of a vertex")? {
        1 => cursor.numbers(vertices, Some((Kind::F32, true)), "the values"),
        other => Err(format!("{other} values for each vertex, where 1 is supported").into()),
    }
}

/// Returns the number of each vertex's label in the table of the file, -1 where it has none.
fn labels(cursor: &mut Cursor<'_>) -> Checked<Vec<f64>> {
    let count = integer(cursor, "the number of vertices")?;
    let pairs = cursor.numbers(
        count.saturating_mul(2),
        Some((Kind::I32, true)),
        "the labels of vertices",
    )?;
    let table = table(cursor)?;
    let mut values = roomy(count);
    for _ in 0..count {
        push(&mut values, -1.0)?;
    }
    for &[v, color] in pairs.as_chunks::<2>().0 {
        let slot = whole(v).ok().and_then(|v| values.get_mut(v));
        let slot = slot.ok_or_else(|| format!("vertex {v} is out of range: {count} vertices"))?;
        *slot = match &table {
            Some(table) => table.get(&(color as i64)).copied().unwrap_or(-1.0),
            None => color,
        };
    }
    Ok(values)
}

/// Returns the number of each colour of the table of labels; `None` where the file has no table.
fn table(cursor: &mut Cursor<'_>) -> Checked<Option<HashMap<i64, f64>>> {
    const WHAT: &str = "the table of labels";
    let number = |cursor: &mut Cursor<'_>| cursor.stored(Kind::I32, true, WHAT);
    if cursor.rest().is_empty() || number(cursor)? == 0.0 {
        return Ok(None);
    }
    let mut entries = number(cursor)?;
    let has_numbers = entries < 0.0;
    if has_numbers {
        if entries != -2.0 {
            return Err(format!("version {} of a table of labels", -entries).into());
        }
        number(cursor)?;
    }
    let length = integer(cursor, WHAT)?;
    cursor.bytes(length, WHAT)?;
    if has_numbers {
        entries = number(cursor)?;
    }
    let mut table = HashMap::new();
    for i in 0..whole(entries)? {
        let own = if has_numbers { number(cursor)? } else { i as f64 };
        let length = integer(cursor, WHAT)?;
        cursor.bytes(length, WHAT)?;
        let [r, g, b] = [number(cursor)?, number(cursor)?, number(cursor)?].map(|x| x as i64);
        number(cursor)?;
        table.entry(r + (g << 8) + (b << 16)).or_insert(own);
    }
    Ok(Some(table))
}
