//! The columns of an Arrow file. Source: `Schema.fbs` of Arrow's columnar format, version 1.5.

use super::flat::Table;
use crate::io::columnar::fault::Fault;
use crate::io::columnar::pandas;
use crate::io::columnar::store::{Field, Kind};

/// What the entries of a column are that are no numbers: their unit is not that of others.
pub const DURATIONS: &str = "durations";

/// Most digits of a decimal, whose integer then fits 128 bits, whatever its width.
const MOST_DIGITS: i32 = 38;

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

/// Most bytes of the names of columns, each of which counts [`OF_COLUMN`] more. Columns may share
/// bytes of the metadata, so that these alone are no bound.
const MOST: usize = 1 << 26;
const OF_COLUMN: usize = 64;

/// Returns the columns of a schema. Before version 5 unions have bits of missing cells.
pub fn columns(schema: Table<'_>, unions_have_bits: bool) -> Result<Vec<Column>, Fault> {
    if schema.i16(0)? != 0 {
        return Err("numbers with the highest byte first".into());
    }
    let mut walk = Walk { unions_have_bits, left: MOST };
    schema.tables(1)?.into_iter().map(|field| walk.column(field)).collect()
}

/// Returns the names of the columns that are the index of a pandas frame.
pub fn index(schema: Table<'_>) -> Result<Vec<String>, Fault> {
    for pair in schema.tables(2)? {
        if pair.text(0)? == pandas::KEY {
            return Ok(pandas::index_columns(&pair.text(1)?));
        }
    }
    Ok(Vec::new())
}

/// What columns have in common.
struct Walk {
    unions_have_bits: bool,
    /// What is left of [`MOST`].
    left: usize,
}

impl Walk {
    fn take(&mut self, bytes: usize) -> Result<(), Fault> {
        self.left =
            self.left.checked_sub(bytes).ok_or("more columns, or longer names, than fit")?;
        Ok(())
    }

    fn column(&mut self, field: Table<'_>) -> Result<Column, Fault> {
        let extent = self.extent(field, 0)?;
        let name = field.text(0)?;
        self.take(name.len())?;
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
        Ok(Column { field: Field { name, kind }, entry: found.ok(), extent, dictionary })
    }

    /// Returns what a column takes of a record batch, with the columns within it.
    fn extent(&mut self, field: Table<'_>, depth: usize) -> Result<Extent, Fault> {
        if depth > DEEPEST {
            return Err("broken metadata: columns within columns without end".into());
        }
        self.take(OF_COLUMN)?;
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
            14 => {
                // Dense unions have places besides types.
                let is_dense = field.table(3)?.map_or(Ok(0), |of| of.i16(0))? == 1;
                (1 + usize::from(is_dense) + usize::from(self.unions_have_bits), true)
            }
            22 => (0, true),
            25 | 26 => (3, true),
            _ => (2, false),
        };
        let views = usize::from(matches!(field.u8(2)?, 23 | 24));
        let mut all = Extent { nodes: 1, buffers: own, views };
        if has_children {
            for child in field.tables(5)? {
                let Extent { nodes, buffers, views } = self.extent(child, depth + 1)?;
                all.nodes += nodes;
                all.buffers += buffers;
                all.views += views;
            }
        }
        Ok(all)
    }
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
            256 if of.i32(0)? <= MOST_DIGITS => Ok(Entry::Decimal(32, of.i32(1)?)),
            _ => Err("decimals of more than 38 digits"),
        },
        8 => Err("dates"),
        9..=11 => Err("times"),
        18 => Err(DURATIONS),
        12 | 16 | 17 | 21 | 25 | 26 => Err("lists"),
        13 | 14 => Err("nested values"),
        20 => Ok(Entry::Text(8)),
        24 => Ok(Entry::View),
        _ => Err(OTHER),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns tables of columns, each with two columns, both of which are the next one; the last
    /// one has none. All are of the kind `kind`.
    fn nested(kind: u32, count: usize) -> Vec<u8> {
        let mut bytes = 20_u32.to_le_bytes().to_vec();
        for left in (0..count).rev() {
            let inner = if left > 0 { 4 } else { 0 };
            let places = [16_u16, 12, 0, 0, 8, 0, 0, inner];
            bytes.extend(places.iter().flat_map(|place| place.to_le_bytes()));
            // The distances of the places and of the inner columns; their number and distances.
            let words = [16, 8, kind, 2, 24, 20];
            bytes.extend(words.iter().flat_map(|word: &u32| word.to_le_bytes()));
        }
        bytes
    }

    fn extent(kind: u32, count: usize, unions_have_bits: bool) -> Result<Extent, Fault> {
        let mut walk = Walk { unions_have_bits, left: MOST };
        walk.extent(Table::root(&nested(kind, count))?, 0)
    }

    #[test]
    fn columns_within_columns_are_counted_once_for_each_place() {
        const STRUCT: u32 = 13;
        let found = extent(STRUCT, 4, false).unwrap();
        assert_eq!((found.nodes, found.buffers), (15, 15));
        // 2^40 columns in 1604 bytes.
        let refused = extent(STRUCT, 40, false).unwrap_err();
        assert!(refused.contains("more columns"), "{refused}");
    }

    #[test]
    fn unions_have_bits_of_missing_cells_before_version_5() {
        const UNION: u32 = 14;
        let found = [false, true].map(|old| extent(UNION, 1, old).unwrap().buffers);
        assert_eq!(found, [1, 2]);
    }
}
