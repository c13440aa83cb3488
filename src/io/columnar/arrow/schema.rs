//! The columns of an Arrow file. Source: `Schema.fbs` of Arrow's columnar format, version 1.5.

use super::flat::Table;
use crate::io::columnar::store::{Fault, Field, Kind};

/// Columns within columns at most.
const DEEPEST: usize = 64;

/// What the entries of a column are.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Entry {
    Bool,
    /// Of this number of bytes.
    Signed(usize),
    Unsigned(usize),
    Float(usize),
    /// Of this number of bytes, and with this scale.
    Decimal(usize, i32),
    /// Words whose places have this number of bytes.
    Text(usize),
    /// Words in views of 16 bytes.
    View,
    /// Numbers of words in a dictionary.
    Coded(Box<Entry>, i64),
    /// Nothing: each cell is missing.
    Null,
}

/// What a column takes of a record batch.
#[derive(Debug, Clone, Copy, Default)]
pub struct Extent {
    pub nodes: usize,
    pub buffers: usize,
    /// Columns whose number of buffers each record batch says.
    pub views: usize,
}

/// A column of the file.
#[derive(Debug, Clone)]
pub struct Column {
    pub field: Field,
    /// `None`: of another kind.
    pub entry: Option<Entry>,
    pub extent: Extent,
    /// The words of its dictionary.
    pub dictionary: Option<Entry>,
}

/// Returns the columns of a schema.
pub fn columns(schema: Table<'_>) -> Result<Vec<Column>, Fault> {
    if schema.i16(0)? != 0 {
        return Err("numbers with the highest byte first".into());
    }
    schema.tables(1)?.into_iter().map(column).collect()
}

fn column(field: Table<'_>) -> Result<Column, Fault> {
    let extent = extent(field, 0)?;
    let (mut found, mut dictionary) = (entry(field)?, None);
    if let Some(encoding) = field.table(4)? {
        let values = std::mem::replace(&mut found, Err("categories that are no words"));
        if let Ok(values @ (Entry::Text(_) | Entry::View)) = values {
            let index = match encoding.table(1)? {
                Some(int) => integer(int)?,
                None => Some(Entry::Signed(4)),
            };
            if let Some(index) = index {
                found = Ok(Entry::Coded(Box::new(index), encoding.i64(0)?));
                dictionary = Some(values);
            }
        }
    }
    let kind = match &found {
        Ok(Entry::Text(_) | Entry::View | Entry::Coded(..)) => Kind::Words,
        Ok(_) => Kind::Numbers,
        Err(what) => Kind::Other((*what).into()),
    };
    let field = Field { name: field.text(0)?, kind };
    Ok(Column { field, entry: found.ok(), extent, dictionary })
}

/// Returns an integer.
fn integer(int: Table<'_>) -> Result<Option<Entry>, Fault> {
    let bytes = int.i32(0)? / 8;
    Ok(match (bytes, int.u8(1)? != 0) {
        (1 | 2 | 4 | 8, true) => Some(Entry::Signed(bytes as usize)),
        (1 | 2 | 4 | 8, false) => Some(Entry::Unsigned(bytes as usize)),
        _ => None,
    })
}

/// Returns what the entries of a column are, or what they are instead of numbers and words.
fn entry(field: Table<'_>) -> Result<Result<Entry, &'static str>, Fault> {
    const OTHER: &str = "values of another type";
    let Some(of) = field.table(3)? else { return Ok(Err(OTHER)) };
    Ok(match field.u8(2)? {
        1 => Ok(Entry::Null),
        2 => integer(of)?.ok_or(OTHER),
        3 => match of.i16(0)? {
            0 => Ok(Entry::Float(2)),
            1 => Ok(Entry::Float(4)),
            2 => Ok(Entry::Float(8)),
            _ => Err(OTHER),
        },
        4 | 15 | 19 | 23 => Err("bytes"),
        5 => Ok(Entry::Text(4)),
        6 => Ok(Entry::Bool),
        7 => match if of.has(2) { of.i32(2)? } else { 128 } {
            bits @ (32 | 64 | 128) => Ok(Entry::Decimal(bits as usize / 8, of.i32(1)?)),
            _ => Err("decimals of more than 38 digits"),
        },
        8 => Err("dates"),
        9 | 10 | 11 | 18 => Err("times"),
        12 | 16 | 17 | 21 | 25 | 26 => Err("lists"),
        13 | 14 => Err("nested values"),
        20 => Ok(Entry::Text(8)),
        24 => Ok(Entry::View),
        _ => Err(OTHER),
    })
}

/// Returns what a column takes of a record batch, with the columns within it.
fn extent(field: Table<'_>, depth: usize) -> Result<Extent, Fault> {
    if depth > DEEPEST {
        return Err("broken metadata: columns within columns without end".into());
    }
    // The words of a dictionary are elsewhere.
    if field.table(4)?.is_some() {
        return Ok(Extent { nodes: 1, buffers: 2, views: 0 });
    }
    let (own, has_children) = match field.u8(2)? {
        1 => (0, false),
        4 | 5 | 19 | 20 => (3, false),
        23 | 24 => (2, false),
        12 | 17 | 21 => (2, true),
        13 | 16 => (1, true),
        // Dense unions have places besides types.
        14 => (if field.table(3)?.map_or(Ok(0), |of| of.i16(0))? == 1 { 2 } else { 1 }, true),
        22 => (0, true),
        25 | 26 => (3, true),
        _ => (2, false),
    };
    let views = usize::from(matches!(field.u8(2)?, 23 | 24));
    let mut all = Extent { nodes: 1, buffers: own, views };
    if has_children {
        for child in field.tables(5)? {
            let Extent { nodes, buffers, views } = extent(child, depth + 1)?;
            all.nodes += nodes;
            all.buffers += buffers;
            all.views += views;
        }
    }
    Ok(all)
}
