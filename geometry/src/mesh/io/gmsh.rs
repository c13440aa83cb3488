//! Gmsh `.msh`: faces, and values of nodes. Versions 2 and 4.1 in text and binary, 1 and 4.0 in
//! text.
//!
//! Format: "Gmsh reference manual", chapter "File formats".

use std::collections::HashMap;

use super::attributes::MeshFile;
use super::cursor::Cursor;
use super::dataset::{Array, Dataset, cell};
use super::draft::{Checked, Fault};
use super::stored::{Budget, Kind, whole};
use super::text::{count, quoted, without_mark, words};
use catamaran::base::{Result, push, reserved};
use catamaran::io::Source;

pub(super) fn read(source: &mut Source<'_>) -> Result<MeshFile> {
    let bytes = source.read_all()?;
    let mut reader = Reader {
        cursor: Cursor::new(without_mark(&bytes)),
        version: Version::Two,
        word: Kind::U64,
        stored: None,
        vertices: HashMap::new(),
        budget: Budget::new(source),
        dataset: Dataset::default(),
        cells: 0,
    };
    match reader.sections() {
        Ok(()) => reader.dataset.finish(),
        Err(fault) => Err(reader.cursor.fail(fault, source)),
    }
}

/// Largest number of values of a node: those of a tensor.
const MOST_VALUES: usize = 9;

#[derive(Clone, Copy, PartialEq, Eq)]
enum Version {
    One,
    Two,
    /// Version 4.0, whose rows begin with the number of the entity or node.
    FourZero,
    Four,
}

impl Version {
    /// Returns whether nodes and elements are in blocks.
    fn has_blocks(self) -> bool {
        matches!(self, Self::FourZero | Self::Four)
    }
}

/// Returns the number of nodes of an element of this type, and the type of the cell that it is;
/// `None` for an unknown type.
fn element(kind: usize) -> Option<(usize, usize)> {
    const NODES: [usize; 31] = [
        2, 3, 4, 4, 8, 6, 5, 3, 6, 9, 10, 27, 18, 14, 1, 8, 20, 15, 13, 9, 10, 12, 15, 15, 21, 4,
        5, 6, 20, 35, 56,
    ];
    let nodes = match kind {
        1..=31 => NODES[kind - 1],
        36 => 16,
        37 => 25,
        38 => 36,
        92 => 64,
        93 => 125,
        _ => return None,
    };
    let cell = match kind {
        2 => cell::TRIANGLE,
        3 => cell::QUAD,
        9 | 20..=25 => cell::CURVED_TRIANGLE,
        10 | 16 | 36..=38 => cell::CURVED_QUAD,
        _ => cell::OTHER,
    };
    Some((nodes, cell))
}

struct Reader<'s, 'a> {
    cursor: Cursor<'s>,
    version: Version,
    /// The type of counts and numbers in binary blocks.
    word: Kind,
    /// Whether a binary file is big endian; `None` for text.
    stored: Option<bool>,
    /// The vertex that a node with this number is.
    vertices: HashMap<u64, u32>,
    budget: Budget<'s, 'a>,
    dataset: Dataset,
    /// Number of elements so far.
    cells: usize,
}

impl Reader<'_, '_> {
    fn sections(&mut self) -> Checked<()> {
        let mut has_format = false;
        while let Some(line) = self.cursor.full_line() {
            let Some(name) = line.strip_prefix(b"$") else {
                return Err(format!("{} where a section is due", quoted(line)).into());
            };
            match name {
                b"MeshFormat" => {
                    self.format()?;
                    has_format = true;
                }
                b"NOD" if !has_format => {
                    self.version = Version::One;
                    has_format = true;
                    self.nodes()?;
                }
                b"Comments" => {}
                _ if !has_format => return Err("has no $MeshFormat before other sections".into()),
                b"Nodes" => self.nodes()?,
                b"Elements" | b"ELM" => self.elements()?,
                b"NodeData" => match self.node_data() {
                    Err(Fault::What(what)) => {
                        let cursor = &self.cursor;
                        let place = || format!("line {} ({what})", cursor.line_number());
                        let notes = &mut self.dataset.draft.notes;
                        notes.add("left out values of nodes that can't be read", place);
                    }
                    read => read?,
                },
                b"ElementData" | b"ElementNodeData" => {
                    let notes = &mut self.dataset.draft.notes;
                    notes.add("left out values of elements", String::new);
                }
                b"ParametricNodes" => return Err("parametric nodes are not supported".into()),
                _ => {}
            }
            self.skip_to_end(name)?;
        }
        if has_format { Ok(()) } else { Err("has no $MeshFormat".into()) }
    }

    /// Skips the rest of a section.
    fn skip_to_end(&mut self, name: &[u8]) -> Checked<()> {
        let end = [b"$End", name].concat();
        let rest = self.cursor.rest();
        // Its first byte is rare in numbers, too.
        let mut starts = rest.iter().enumerate().filter(|(_, byte)| **byte == b'$');
        // Version 1 has capitals.
        let ends = |at: usize| {
            rest[at..].get(..end.len()).is_some_and(|own| own.eq_ignore_ascii_case(&end))
        };
        let Some((at, _)) = starts.find(|(at, _)| ends(*at)) else {
            let end = String::from_utf8_lossy(&end).into_owned();
            return Err(format!("truncated: the file ends before {end}").into());
        };
        self.cursor.skip(at + end.len());
        Ok(())
    }

    fn format(&mut self) -> Checked<()> {
        let what = "the version";
        let version = self.cursor.word(what)?;
        self.version = match version {
            _ if version.starts_with(b"2") => Version::Two,
            b"4.1" => Version::Four,
            b"4" | b"4.0" => Version::FourZero,
            _ => return Err(not_supported(&quoted(version))),
        };
        let is_binary = self.cursor.count(what)? == 1;
        if is_binary && self.version == Version::FourZero {
            return Err(not_supported("4.0 in binary"));
        }
        self.word = match (self.cursor.count(what)?, self.version) {
            (8, _) => Kind::U64,
            (4, Version::Four) => Kind::U32,
            (size, _) => return Err(format!("numbers of {size} bytes are not supported").into()),
        };
        if is_binary {
            self.cursor.line();
            let one = self.cursor.bytes(4, "the byte order")?;
            self.stored = match one {
                b"\x01\0\0\0" => Some(false),
                b"\0\0\0\x01" => Some(true),
                _ => return Err("the number after the version is not 1 in any byte order".into()),
            };
        }
        Ok(())
    }

    /// Returns the next number, of this type in a binary file.
    fn number(&mut self, kind: Kind, what: &str) -> Checked<f64> {
        match self.stored {
            Some(is_big) => self.cursor.stored(kind, is_big, what),
            None => self.cursor.number(what),
        }
    }

    fn count(&mut self, kind: Kind, what: &str) -> Checked<usize> {
        whole(self.number(kind, what)?)
    }

    fn numbers(&mut self, count: usize, kind: Kind, what: &str) -> Checked<Vec<f64>> {
        self.cursor.numbers(count, self.stored.map(|is_big| (kind, is_big)), what)
    }

    /// Returns the number on the next line, which is text in binary files, too.
    fn counted(&mut self, what: &str) -> Checked<usize> {
        let line = self.cursor.full_line().unwrap_or_default();
        count(words(line).next().ok_or_else(|| format!("truncated before {what}"))?)
    }

    fn node(&mut self, number: f64, position: &[f64]) -> Checked<()> {
        let v = self.dataset.draft.vertices.len() as u32;
        let number = whole(number)? as u64;
        self.dataset.points(position).map_err(|fault| fault.of(|| format!("node {number}")))?;
        self.vertices.insert(number, v);
        Ok(())
    }

    fn nodes(&mut self) -> Checked<()> {
        const WHAT: &str = "the nodes";
        if !self.version.has_blocks() {
            let count = self.counted(WHAT)?;
            for _ in 0..count {
                let number = self.number(Kind::I32, WHAT)?;
                let position = self.numbers(3, Kind::F64, WHAT)?;
                self.node(number, &position)?;
            }
            return Ok(());
        }
        for _ in 0..self.blocks(WHAT)? {
            let [dimension, _, parametric] = self.block()?;
            let count = self.count(self.word, WHAT)?;
            let parameters = if parametric == 0.0 { 0 } else { whole(dimension)? };
            if parameters > 3 {
                return Err(
                    format!("nodes with {parameters} parameters, which have up to 3").into()
                );
            }
            let width = 3 + parameters;
            if self.version == Version::FourZero {
                for _ in 0..count {
                    let row = self.numbers(1 + width, Kind::F64, WHAT)?;
                    self.node(row[0], &row[1..4])?;
                }
                continue;
            }
            let numbers = self.numbers(count, self.word, WHAT)?;
            let values = self.numbers(count.saturating_mul(width), Kind::F64, WHAT)?;
            for (number, position) in numbers.into_iter().zip(values.chunks_exact(width)) {
                self.node(number, &position[..3])?;
            }
        }
        Ok(())
    }

    /// Returns the number of blocks of a section of version 4.
    fn blocks(&mut self, what: &str) -> Checked<usize> {
        let numbers = if self.version == Version::FourZero { 2 } else { 4 };
        whole(self.numbers(numbers, self.word, what)?[0])
    }

    /// Returns the three integers that begin a block of version 4, the dimension of its entity
    /// first, or of elements in binary version 2.
    fn block(&mut self) -> Checked<[f64; 3]> {
        let what = "the head of a block";
        let [a, b, c] = [
            self.number(Kind::I32, what)?,
            self.number(Kind::I32, what)?,
            self.number(Kind::I32, what)?,
        ];
        Ok(if self.version == Version::FourZero { [b, a, c] } else { [a, b, c] })
    }

    fn elements(&mut self) -> Checked<()> {
        const WHAT: &str = "the elements";
        if self.version.has_blocks() {
            for _ in 0..self.blocks(WHAT)? {
                let [_, _, kind] = self.block()?;
                let count = self.count(self.word, WHAT)?;
                let (nodes, cell) = known(kind)?;
                for _ in 0..count {
                    let row = self.numbers(1 + nodes, self.word, WHAT)?;
                    self.element(cell, &row[1..])?;
                }
            }
            return Ok(());
        }
        let count = self.counted(WHAT)?;
        let end = self.cells.saturating_add(count);
        while self.cells < end {
            if self.stored.is_none() {
                self.number(Kind::I32, WHAT)?;
                let (nodes, cell) = known(self.number(Kind::I32, WHAT)?)?;
                if self.version == Version::One {
                    // Two regions and the number of nodes.
                    let row = self.numbers(3 + nodes, Kind::I32, WHAT)?;
                    if row[2] != nodes as f64 {
                        let i = self.cells;
                        return Err(format!("element {i}: {} nodes, not {nodes}", row[2]).into());
                    }
                    self.element(cell, &row[3..])?;
                    continue;
                }
                let tags = self.count(Kind::I32, WHAT)?;
                let row = self.numbers(tags.saturating_add(nodes), Kind::I32, WHAT)?;
                self.element(cell, &row[tags..])?;
                continue;
            }
            let [kind, count, tags] = self.block()?;
            let (nodes, cell) = known(kind)?;
            let tags = whole(tags)?;
            for _ in 0..whole(count)?.max(1) {
                let length = tags.saturating_add(1 + nodes);
                let row = self.numbers(length, Kind::I32, WHAT)?;
                self.element(cell, &row[1 + tags..])?;
            }
        }
        Ok(())
    }

    fn element(&mut self, cell: usize, nodes: &[f64]) -> Checked<()> {
        let i = self.cells;
        self.cells += 1;
        // Nodes of volumes need not be looked up.
        let nodes = if cell == cell::OTHER { &[] } else { nodes };
        let mut vertices = Vec::with_capacity(nodes.len());
        for &number in nodes {
            let known = whole(number).ok().and_then(|number| self.vertices.get(&(number as u64)));
            let missing = || format!("element {i}: node {number} does not exist");
            vertices.push(*known.ok_or_else(missing)?);
        }
        self.dataset.cell(cell, &mut vertices, i)
    }

    /// Reads values of nodes; those without a value have NaN.
    fn node_data(&mut self) -> Checked<()> {
        const WHAT: &str = "the values of nodes";
        let mut name = None;
        for _ in 0..self.counted(WHAT)? {
            let line = self.cursor.full_line().ok_or("truncated before the name of values")?;
            let text = String::from_utf8_lossy(line);
            name.get_or_insert_with(|| text.trim_matches('"').to_owned());
        }
        for _ in 0..self.counted(WHAT)? {
            self.cursor.full_line().ok_or("truncated before the time of values")?;
        }
        // The step, the number of values of a node, and that of nodes.
        let mut sizes = [0, 1, 0];
        for i in 0..self.counted(WHAT)? {
            let size = self.counted(WHAT)?;
            if let Some(slot) = sizes.get_mut(i) {
                *slot = size;
            }
        }
        let [_, width, count] = sizes;
        if !(1..=MOST_VALUES).contains(&width) {
            return Err(format!("{width} values of a node").into());
        }
        if count == 0 {
            return Ok(());
        }
        // A value for each vertex, whatever the file gives.
        let length = self.dataset.draft.vertices.len().saturating_mul(width);
        self.budget.take_numbers(length)?;
        let mut values = reserved(length)?;
        values.resize(length, f64::NAN);
        for _ in 0..count {
            let number = self.count(Kind::I32, WHAT)?;
            let row = self.numbers(width, Kind::F64, WHAT)?;
            let Some(&v) = self.vertices.get(&(number as u64)) else {
                return Err(format!("values of node {number}, which does not exist").into());
            };
            values[v as usize * width..][..width].copy_from_slice(&row);
        }
        let array = Array::named(name.unwrap_or_default(), width, values, Kind::F64)?;
        Ok(push(&mut self.dataset.arrays, array)?)
    }
}

/// Returns the error about a version of the format.
fn not_supported(version: &str) -> Fault {
    let what = "where 2 and 4.1, and 1 and 4.0 in text, are supported: `gmsh OLD.msh -save -format \
                msh41 -o NEW.msh` converts";
    format!("version {version}, {what}").into()
}

/// Returns the number of nodes and the cell of a type of elements.
fn known(kind: f64) -> Checked<(usize, usize)> {
    let found = whole(kind).ok().and_then(element);
    Ok(found.ok_or_else(|| format!("unknown type {kind} of elements"))?)
}
