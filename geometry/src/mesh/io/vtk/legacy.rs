//! Legacy files of VTK, versions 1 to 5.1, text and binary.

use super::super::attributes::MeshFile;
use super::super::cursor::Cursor;
use super::super::dataset::{Array, Dataset, Ends, Lists, Role, cell, not_a_surface};
use super::super::draft::Checked;
use super::super::stored::{Indices, Kind};
use super::super::text::{count, quoted, without_mark, words};
use catamaran::base::{Result, push};
use catamaran::io::Source;

pub(in super::super) fn read(source: &mut Source<'_>) -> Result<MeshFile> {
    let bytes = source.read_all()?;
    let cursor = Cursor::new(without_mark(&bytes));
    let mut reader = Reader { cursor, is_binary: false, dataset: Dataset::default() };
    match reader.read() {
        Ok(()) => reader.dataset.finish(),
        Err(fault) => Err(reader.cursor.fail(fault, source)),
    }
}

struct Reader<'a> {
    cursor: Cursor<'a>,
    is_binary: bool,
    dataset: Dataset,
}

/// Returns word number `i` of a line of a header.
fn operand(line: &[u8], i: usize) -> Checked<&[u8]> {
    Ok(words(line).nth(i).ok_or_else(|| format!("{} lacks a word", quoted(line)))?)
}

/// Returns word number `i` of a line of a header as a count.
fn operand_count(line: &[u8], i: usize) -> Checked<usize> {
    count(operand(line, i)?)
}

impl<'a> Reader<'a> {
    fn read(&mut self) -> Checked<()> {
        let head = self.cursor.line().unwrap_or_default();
        if !head.to_ascii_lowercase().starts_with(b"# vtk datafile") {
            return Err("does not begin with \"# vtk DataFile Version\"".into());
        }
        // The title.
        self.cursor.line();
        let encoding = self.cursor.full_line().unwrap_or_default();
        self.is_binary = match encoding.to_ascii_uppercase().as_slice() {
            b"ASCII" => false,
            b"BINARY" => true,
            _ => return Err(format!("{} is not ASCII or BINARY", quoted(encoding)).into()),
        };
        // Cells of an unstructured grid until their types are known.
        let mut cells = None;
        // Whether the points are those of a grid, and how many it has along each side.
        let (mut is_grid, mut sides) = (false, None);
        while let Some(line) = self.cursor.full_line() {
            let keyword = operand(line, 0)?.to_ascii_uppercase();
            match keyword.as_slice() {
                b"DATASET" => match operand(line, 1)?.to_ascii_uppercase().as_slice() {
                    b"POLYDATA" | b"UNSTRUCTURED_GRID" => {}
                    b"STRUCTURED_GRID" => is_grid = true,
                    _ => {
                        let what = quoted(operand(line, 1)?);
                        return Err(not_a_surface(&format!("a dataset {what}")));
                    }
                },
                b"DIMENSIONS" if is_grid => {
                    let side = |i: usize| operand_count(line, i);
                    sides = Some([side(1)?, side(2)?, side(3)?]);
                }
                b"POINTS" if self.dataset.draft.vertices.is_empty() => {
                    let values = operand_count(line, 1)?.saturating_mul(3);
                    let values = self.values(values, operand(line, 2)?, "the points")?;
                    self.dataset.points(&values)?;
                }
                b"CELLS" if cells.is_none() => cells = Some(self.lists(line)?),
                b"CELL_TYPES" => {
                    let kinds = self.indices(operand_count(line, 1)?, b"int", "types of cells")?;
                    let Some(lists) = cells.take() else {
                        return Err("CELL_TYPES without CELLS before".into());
                    };
                    let kind = |i: usize| match i < kinds.len() {
                        true => kinds.whole(i),
                        false => Err(format!("cell {i} has no type").into()),
                    };
                    self.dataset.cells(&lists, 0, kind)?;
                }
                b"POLYGONS" | b"TRIANGLE_STRIPS" | b"LINES" | b"VERTICES" => {
                    let kind = match keyword.as_slice() {
                        b"POLYGONS" => cell::POLYGON,
                        b"TRIANGLE_STRIPS" => cell::STRIP,
                        _ => cell::OTHER,
                    };
                    let lists = self.lists(line)?;
                    self.dataset.cells(&lists, 0, |_| Ok(kind))?;
                }
                b"POINT_DATA" => {
                    if !self.attributes(operand_count(line, 1)?, true)? {
                        break;
                    }
                }
                b"CELL_DATA" => {
                    if !self.attributes(operand_count(line, 1)?, false)? {
                        break;
                    }
                }
                b"FIELD" => {
                    if !self.field(operand_count(line, 2)?, None)? {
                        break;
                    }
                }
                b"METADATA" => self.metadata(),
                _ => return Err(format!("{} is out of place", quoted(line)).into()),
            }
        }
        match (cells, sides) {
            (Some(_), _) => Err("CELLS without CELL_TYPES".into()),
            (None, Some(sides)) => self.grid(sides),
            (None, None) if is_grid => Err("a structured grid lacks its DIMENSIONS".into()),
            (None, None) => Ok(()),
        }
    }

    /// Adds the quadrilaterals of a grid with so many points along each side, the first of which
    /// runs fastest.
    fn grid(&mut self, sides: [usize; 3]) -> Checked<()> {
        let points = sides.iter().try_fold(1usize, |product, &side| product.checked_mul(side));
        let count = self.dataset.draft.vertices.len();
        if points != Some(count) {
            let [x, y, z] = sides;
            return Err(format!("{count} points of a grid of {x} x {y} x {z}").into());
        }
        let mut long = sides.into_iter().filter(|&side| side > 1);
        let (Some(across), Some(along), None) = (long.next(), long.next(), long.next()) else {
            return Err(not_a_surface("a structured grid of volumes or lines"));
        };
        let rows = (0..along - 1).flat_map(|j| (0..across - 1).map(move |i| j * across + i));
        for (i, first) in rows.enumerate() {
            let corners = [first, first + 1, first + 1 + across, first + across];
            // Points are counted by 32 bits.
            let mut corners = corners.map(|corner| corner as u32).to_vec();
            self.dataset.cell(cell::QUAD, &mut corners, i)?;
        }
        Ok(())
    }

    /// Returns the type of numbers with this name, and whether it is that of bits, eight of which
    /// are a byte.
    fn kind(name: &[u8]) -> Option<(Kind, bool)> {
        let kind = match name.to_ascii_lowercase().as_slice() {
            b"bit" => return Some((Kind::U8, true)),
            b"char" | b"signed_char" | b"vtktypeint8" => Kind::I8,
            b"unsigned_char" | b"vtktypeuint8" => Kind::U8,
            b"short" | b"vtktypeint16" => Kind::I16,
            b"unsigned_short" | b"vtktypeuint16" => Kind::U16,
            b"int" | b"vtktypeint32" | b"vtkidtype" => Kind::I32,
            b"unsigned_int" | b"vtktypeuint32" => Kind::U32,
            b"long" | b"vtktypeint64" | b"long_long" => Kind::I64,
            b"unsigned_long" | b"vtktypeuint64" | b"unsigned_long_long" => Kind::U64,
            b"float" | b"vtktypefloat32" => Kind::F32,
            b"double" | b"vtktypefloat64" => Kind::F64,
            _ => return None,
        };
        Some((kind, false))
    }

    fn values(&mut self, count: usize, kind: &[u8], what: &str) -> Checked<Vec<f64>> {
        let unknown = || format!("{what}: unknown type {}", quoted(kind));
        let (kind, is_bit) = Self::kind(kind).ok_or_else(unknown)?;
        if !self.is_binary {
            return self.cursor.numbers(count, None, what);
        }
        if !is_bit {
            return self.cursor.numbers(count, Some((kind, true)), what);
        }
        let bytes = self.cursor.bytes(count.div_ceil(8), what)?;
        let mut values = Vec::new();
        for i in 0..count {
            push(&mut values, f64::from((bytes[i / 8] >> (7 - i % 8)) & 1))?;
        }
        Ok(values)
    }

    /// Reads as [`Reader::values`] does, numbers that are indices.
    fn indices(&mut self, count: usize, kind: &[u8], what: &str) -> Checked<Indices<'a>> {
        match Self::kind(kind) {
            Some((kind, false)) if self.is_binary => self.cursor.indices(count, (kind, true), what),
            _ => Indices::of_numbers(self.values(count, kind, what)?),
        }
    }

    /// Reads lists of vertices that `line` announces.
    fn lists(&mut self, line: &[u8]) -> Checked<Lists<'a>> {
        let [lists, size] = [operand_count(line, 1)?, operand_count(line, 2)?];
        let before = self.cursor.rest();
        // From version 5 on, two arrays instead of one.
        let next = words(&before[..before.len().min(64)]).next().unwrap_or_default();
        if next.eq_ignore_ascii_case(b"OFFSETS") {
            let line = self.cursor.full_line().unwrap_or_default();
            let mut ends = self.indices(lists, operand(line, 1)?, "offsets of cells")?;
            if ends.len() > 0 && ends.number(0) != 0.0 {
                return Err("the first of the offsets of cells is not 0".into());
            }
            ends.drop_first();
            let line = self.cursor.full_line().unwrap_or_default();
            if !operand(line, 0)?.eq_ignore_ascii_case(b"CONNECTIVITY") {
                return Err(format!("{} where CONNECTIVITY is due", quoted(line)).into());
            }
            let corners = self.indices(size, operand(line, 1)?, "vertices of cells")?;
            return Ok(Lists { corners, ends: Ends::At(ends) });
        }
        let corners = self.indices(size, b"int", "vertices of cells")?;
        let mut at = 0;
        for i in 0..lists {
            let length = if at < corners.len() { Some(corners.whole(at)?) } else { None };
            let end = length.and_then(|length| (at + 1).checked_add(length));
            let beyond = || format!("cell {i} of {lists} is beyond the {size} numbers of all");
            at = end.filter(|&end| end <= corners.len()).ok_or_else(beyond)?;
        }
        match corners.len() - at {
            0 => Ok(Lists { corners, ends: Ends::Counted(lists) }),
            left => Err(format!("{left} numbers come after those of the {lists} cells").into()),
        }
    }

    /// Reads the arrays of `count` vertices or cells, up to the next section. Returns whether the
    /// rest of the file can be read.
    fn attributes(&mut self, count: usize, of_points: bool) -> Checked<bool> {
        let read = |width: usize| (count.saturating_mul(width), width);
        loop {
            let before = self.cursor.rest();
            let next = before.trim_ascii_start();
            let next = words(&next[..next.len().min(64)]).next().unwrap_or_default();
            if next.is_empty()
                || matches!(next.to_ascii_uppercase().as_slice(), b"POINT_DATA" | b"CELL_DATA")
            {
                return Ok(true);
            }
            let line = self.cursor.full_line().unwrap_or_default();
            let keyword = operand(line, 0)?.to_ascii_uppercase();
            let mut role = None;
            let (kind, (length, width)) = match keyword.as_slice() {
                b"SCALARS" => {
                    let width = operand_count(line, 3).unwrap_or(1);
                    self.lookup_table();
                    (operand(line, 2)?, read(width))
                }
                b"COLOR_SCALARS" => {
                    role = Some(Role::Colors);
                    let kind: &[u8] = if self.is_binary { b"unsigned_char" } else { b"float" };
                    (kind, read(operand_count(line, 2)?))
                }
                b"NORMALS" => {
                    role = Some(Role::Normals);
                    (operand(line, 2)?, read(3))
                }
                b"TEXTURE_COORDINATES" => {
                    role = Some(Role::Uv);
                    (operand(line, 3)?, read(operand_count(line, 2)?))
                }
                b"VECTORS" => (operand(line, 2)?, read(3)),
                b"TENSORS" => (operand(line, 2)?, read(9)),
                b"TENSORS6" => (operand(line, 2)?, read(6)),
                b"GLOBAL_IDS" | b"PEDIGREE_IDS" => (operand(line, 2)?, read(1)),
                b"LOOKUP_TABLE" => {
                    let kind: &[u8] = if self.is_binary { b"unsigned_char" } else { b"float" };
                    self.values(operand_count(line, 2)?.saturating_mul(4), kind, "a table")?;
                    continue;
                }
                b"METADATA" => {
                    self.metadata();
                    continue;
                }
                b"FIELD" => match self.field(operand_count(line, 2)?, Some((count, of_points)))? {
                    true => continue,
                    false => return Ok(false),
                },
                _ => {
                    self.stop(line);
                    return Ok(false);
                }
            };
            let name = operand(line, 1)?;
            let Some((stored, _)) = Self::kind(kind) else {
                self.stop(line);
                return Ok(false);
            };
            let values = self.values(length, kind, "values of vertices or cells")?;
            let is_wide = role != Some(Role::Uv) || width >= 2;
            let is_color = role != Some(Role::Colors) || matches!(width, 3 | 4);
            if of_points {
                let role = role.filter(|_| is_wide && is_color);
                self.keep(name, role, width, values, stored)?;
            } else {
                self.dataset.draft.notes.add("left out values of cells", || decoded(name));
            }
        }
    }

    /// Notes that the attributes from this line on can't be read.
    fn stop(&mut self, line: &[u8]) {
        let what = "left out arrays of a kind that is not supported, and those after them";
        self.dataset.draft.notes.add(what, || quoted(line));
    }

    fn keep(
        &mut self,
        name: &[u8],
        role: Option<Role>,
        width: usize,
        values: Vec<f64>,
        kind: Kind,
    ) -> Checked<()> {
        let array = Array::named(decoded(name), width, values, kind)?;
        let role = role.unwrap_or(array.role);
        Ok(push(&mut self.dataset.arrays, Array { role, ..array })?)
    }

    /// Skips the line of a table of colours after SCALARS, if it is there.
    fn lookup_table(&mut self) {
        let next = self.cursor.rest().trim_ascii_start();
        if next.get(..12).is_some_and(|word| word.eq_ignore_ascii_case(b"LOOKUP_TABLE")) {
            self.cursor.full_line();
        }
    }

    /// Reads the arrays of a field: of so many vertices (`true`), which are kept, of so many cells,
    /// or of the whole file (`None`). Returns whether the rest of the file can be read.
    fn field(&mut self, arrays: usize, owner: Option<(usize, bool)>) -> Checked<bool> {
        for _ in 0..arrays {
            let line = loop {
                let line = self.cursor.full_line().ok_or("truncated: an array is missing")?;
                if !line.eq_ignore_ascii_case(b"METADATA") {
                    break line;
                }
                self.metadata();
            };
            let (width, rows) = (operand_count(line, 1)?, operand_count(line, 2)?);
            let kind = operand(line, 3)?;
            if kind.eq_ignore_ascii_case(b"string") {
                self.skip_texts(width.saturating_mul(rows))?;
                continue;
            }
            let Some((stored, _)) = Self::kind(kind) else {
                self.stop(line);
                return Ok(false);
            };
            let values = self.values(width.saturating_mul(rows), kind, "an array of a field")?;
            let name = operand(line, 0)?;
            let what = match owner {
                None => continue,
                Some((count, true)) if count == rows => {
                    self.keep(name, None, width, values, stored)?;
                    continue;
                }
                Some((_, true)) => "left out arrays without a value for each vertex",
                Some((_, false)) => "left out values of cells",
            };
            self.dataset.draft.notes.add(what, || decoded(name));
        }
        Ok(true)
    }

    /// Skips texts: lines or, in a binary file, bytes after their number, whose first two bits say
    /// how long it is.
    fn skip_texts(&mut self, count: usize) -> Checked<()> {
        let what = "a text";
        for _ in 0..count {
            if !self.is_binary {
                self.cursor.line().ok_or("truncated: the file ends before a text")?;
                continue;
            }
            let first = self.cursor.bytes(1, what)?[0];
            let more = match first >> 6 {
                3 => 0,
                2 => 1,
                1 => 3,
                _ => 7,
            };
            let rest = self.cursor.bytes(more, what)?.iter();
            let length = rest.fold(u64::from(first & 0x3f), |n, &byte| (n << 8) | u64::from(byte));
            self.cursor.bytes(usize::try_from(length).unwrap_or(usize::MAX), what)?;
        }
        Ok(())
    }

    /// Skips information about an array: lines up to a blank one.
    fn metadata(&mut self) {
        while self.cursor.line().is_some_and(|line| !line.trim_ascii().is_empty()) {}
    }
}

/// Returns a name of an array, in which VTK writes blanks and the like as `%20`.
fn decoded(name: &[u8]) -> String {
    let mut plain = Vec::with_capacity(name.len());
    let mut rest = name;
    while let Some((&byte, after)) = rest.split_first() {
        let digits = after.get(..2).and_then(|digits| std::str::from_utf8(digits).ok());
        let code = digits.and_then(|digits| u8::from_str_radix(digits, 16).ok());
        match code.filter(|_| byte == b'%') {
            Some(code) => {
                plain.push(code);
                rest = &after[2..];
            }
            None => {
                plain.push(byte);
                rest = after;
            }
        }
    }
    String::from_utf8_lossy(&plain).into_owned()
}
