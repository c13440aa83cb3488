//! Files of Arrow's IPC format, which Feather calls version 2. Their metadata is small, and read
//! here: crate arrow-ipc would take three minutes of a processor to compile.
//! Source: "Arrow columnar format", version 1.5, section "IPC file format".

mod batch;
mod flat;
mod schema;
mod values;

use std::collections::HashMap;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};

use self::batch::{Batch, Block, read_at};
use self::flat::Table;
use self::schema::{Column, Entry, Extent};
use self::values::{Numbers, Values};
use super::fault::Fault;
use super::store::{ColumnReader, Contents, Kind, Store};
use super::words::Words;
use crate::base::Error;
use crate::io::source::{error, error_at};

pub use self::schema::DURATIONS;

/// How a file begins and ends.
const MAGIC: &[u8; 6] = b"ARROW1";

/// How files of version 1 of Feather begin.
const FEATHER1: &[u8; 4] = b"FEA1";

/// The first version of the metadata that is read, and the one after it, as they are encoded.
const VERSION4: i16 = 3;
const VERSION5: i16 = 4;

/// Kinds of messages.
const DICTIONARY: u8 = 2;
const RECORDS: u8 = 3;

/// The words of a dictionary; `None` for one that is missing.
type Dictionary = Vec<Option<Vec<u8>>>;

/// An open Arrow file.
pub struct ArrowStore {
    path: PathBuf,
    contents: Contents,
    columns: Vec<Column>,
    batches: Vec<Batch>,
    /// The parts of each dictionary, in order.
    parts: HashMap<i64, Vec<Batch>>,
    /// The dictionaries that were read.
    dictionaries: Mutex<HashMap<i64, Arc<Dictionary>>>,
    /// Bytes that a buffer may take.
    limit: u64,
}

/// Returns the names of the columns of durations, as the metadata of a Parquet file have them: a
/// message with a schema, in base64; none where the metadata are of another form.
pub fn durations(metadata: &str) -> Vec<String> {
    let config =
        GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent);
    let found = || -> Option<Vec<Column>> {
        let bytes = GeneralPurpose::new(&STANDARD, config).decode(metadata).ok()?;
        // Behind a mark, which older versions do not have, and the length.
        let message = match bytes.strip_prefix(&[0xff; 4]) {
            Some(rest) => rest.get(4..)?,
            None => bytes.get(4..)?,
        };
        let message = Table::root(message).ok()?;
        let version = message.i16(0).ok()?;
        let schema = message.table(2).ok()??;
        schema::columns(schema, version < VERSION5).ok()
    };
    let is_one = |column: &Column| column.field.kind == Kind::Other(DURATIONS.into());
    let columns = found().unwrap_or_default().into_iter().filter(is_one);
    columns.map(|column| column.field.name).collect()
}

impl ArrowStore {
    /// Reads the footer and the metadata of a file of `len` bytes.
    pub fn open(path: &Path, len: u64, limit: u64) -> Result<Self, Error> {
        let mut file = File::open(path).map_err(|e| error_at(path, None, e))?;
        Self::read(path, &mut file, len, limit)
            .map_err(|what| error(path, None, format!("broken Arrow file: {what}")))
    }

    fn read(path: &Path, file: &mut File, len: u64, limit: u64) -> Result<Self, Fault> {
        const ENDS: u64 = 8 + 4 + MAGIC.len() as u64;
        let mut head = [0; 6];
        if len < ENDS {
            return Err("it is too short".into());
        }
        read_at(file, 0, &mut head)?;
        if head.starts_with(FEATHER1) {
            return Err("version 1 of Feather, which is not read; version 2 is".into());
        }
        if head != *MAGIC {
            return Err("it does not begin with ARROW1, as a file does; is it a stream?".into());
        }
        let mut tail = [0; 10];
        read_at(file, len - 10, &mut tail)?;
        let (size, magic) = tail.split_first_chunk::<4>().ok_or("it is too short")?;
        let size = u64::from(u32::from_le_bytes(*size));
        if magic != MAGIC || size > len - ENDS {
            return Err("it is truncated: its end is missing".into());
        }
        let mut footer = vec![0; size as usize];
        read_at(file, len - 10 - size, &mut footer)?;
        let footer = Table::root(&footer)?;
        let version = footer.i16(0)?;
        if version < VERSION4 {
            return Err("metadata of a version before 4, which is not read".into());
        }
        let schema = footer.table(1)?.ok_or("no schema")?;
        let index = schema::index(schema)?;
        let columns = schema::columns(schema, version < VERSION5)?;
        let (mut batches, mut groups, mut all) = (Vec::new(), Vec::new(), 0_usize);
        let mut left = len;
        for block in footer.vector::<24>(3)? {
            let block = Block::of(block, len, &mut left)?;
            let metadata = block.metadata(file)?;
            let message = Table::root(&metadata)?;
            if message.u8(1)? != RECORDS {
                return Err("a message that is no record batch".into());
            }
            let batch = Batch::of(message.table(2)?.ok_or("an empty message")?, block)?;
            all = all.checked_add(batch.rows).ok_or("more rows than can be counted")?;
            groups.push(batch.rows);
            batches.push(batch);
        }
        let mut parts: HashMap<i64, Vec<Batch>> = HashMap::new();
        for block in footer.vector::<24>(2)? {
            let block = Block::of(block, len, &mut left)?;
            let metadata = block.metadata(file)?;
            let message = Table::root(&metadata)?;
            if message.u8(1)? != DICTIONARY {
                return Err("a message that is no dictionary".into());
            }
            let dictionary = message.table(2)?.ok_or("an empty message")?;
            let batch = Batch::of(dictionary.table(1)?.ok_or("an empty dictionary")?, block)?;
            let known = parts.entry(dictionary.i64(0)?).or_default();
            // Which of the record batches have the first one is not known.
            if dictionary.u8(2)? == 0 && !known.is_empty() {
                return Err(
                    "a dictionary that replaces another one, which a file may not have".into()
                );
            }
            known.push(batch);
        }
        let fields = columns.iter().map(|column| column.field.clone()).collect();
        Ok(Self {
            path: path.into(),
            contents: Contents { fields, index, groups, group_name: "record batch" },
            columns,
            batches,
            parts,
            dictionaries: Mutex::default(),
            limit,
        })
    }

    fn file(&self) -> Result<File, Fault> {
        File::open(&self.path).map_err(|e| e.to_string())
    }

    fn before(&self, field: usize) -> impl Iterator<Item = &Extent> {
        self.columns[..field].iter().map(|column| &column.extent)
    }

    /// Returns a dictionary of words that are stored so.
    fn dictionary(&self, id: i64, stored: &Entry) -> Result<Arc<Dictionary>, Fault> {
        let mut known = self.dictionaries.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(dictionary) = known.get(&id) {
            return Ok(dictionary.clone());
        }
        let extent = match stored {
            Entry::View => Extent { nodes: 1, buffers: 2, views: 1 },
            _ => Extent { nodes: 1, buffers: 3, views: 0 },
        };
        let (mut words, mut left) = (Dictionary::new(), self.limit);
        for part in self.parts.get(&id).ok_or("a column without its dictionary")? {
            let place = part.place(std::iter::empty(), &extent)?;
            let (rows, stored) = (part.rows, stored.clone());
            let mut values = Values::new(self.file()?, place, stored, Numbers::None, self.limit);
            words.extend(values.words(rows, &mut left)?);
        }
        let words = Arc::new(words);
        known.insert(id, words.clone());
        Ok(words)
    }
}

impl Store for ArrowStore {
    fn contents(&self) -> &Contents {
        &self.contents
    }

    fn may_round(&self, field: usize) -> bool {
        let entry = self.columns[field].entry.as_ref();
        let is_long = |entry: &Entry| match *entry {
            Entry::Signed(bytes) | Entry::Unsigned(bytes) | Entry::Decimal(bytes, 0) => bytes >= 8,
            _ => false,
        };
        entry.is_some_and(is_long)
    }

    fn column(
        &self,
        group: usize,
        field: usize,
        words: Option<&Arc<Words>>,
    ) -> Result<Box<dyn ColumnReader>, Fault> {
        let Column { entry, extent, dictionary, .. } = &self.columns[field];
        let entry = entry.clone().ok_or("no numbers")?;
        let place = self.batches[group].place(self.before(field), extent)?;
        let numbers = match (words, &entry, dictionary) {
            (Some(words), Entry::Coded(_, id), Some(stored)) => {
                Numbers::Coded(words.of_dictionary(&self.dictionary(*id, stored)?)?)
            }
            (Some(words), ..) => Numbers::Of(words.clone()),
            (None, ..) => Numbers::None,
        };
        Ok(Box::new(Values::new(self.file()?, place, entry, numbers, self.limit)))
    }
}
