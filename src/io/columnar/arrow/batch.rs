//! Record batches: where the buffers of their columns are in the file.
//! Source: `Message.fbs` of Arrow's columnar format, version 1.5.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};

use super::flat::Table;
use super::schema::Extent;
use crate::io::columnar::codec::{Codec, too_large, unpack};
use crate::io::columnar::fault::Fault;

/// Where a message is.
#[derive(Debug, Clone, Copy)]
pub struct Block {
    offset: u64,
    /// Bytes of the metadata.
    metadata: u64,
    body: u64,
}

/// Most bytes of the metadata of a message.
const LARGEST_METADATA: u64 = 1 << 28;

impl Block {
    /// Returns the block of a footer, inside a file of `len` bytes, of which `left` are in no block
    /// yet.
    pub fn of(bytes: &[u8; 24], len: u64, left: &mut u64) -> Result<Self, Fault> {
        let number = |at: usize| {
            let eight = bytes[at..].first_chunk::<8>().copied().unwrap_or_default();
            i64::from_le_bytes(eight)
        };
        // The metadata's length has four bytes; four of padding follow.
        let metadata = i64::from(number(8) as i32);
        let block = (u64::try_from(number(0)), u64::try_from(metadata), u64::try_from(number(16)));
        let (Ok(offset), Ok(metadata), Ok(body)) = block else { return Err(outside()) };
        let end = offset.checked_add(metadata).and_then(|end| end.checked_add(body));
        if end.is_none_or(|end| end > len) || metadata > LARGEST_METADATA {
            return Err(outside());
        }
        // Blocks that share bytes would take more memory than the file has bytes.
        *left = left.checked_sub(metadata + body).ok_or("its parts overlap")?;
        Ok(Self { offset, metadata, body })
    }

    /// Returns the metadata.
    pub fn metadata(&self, file: &mut File) -> Result<Vec<u8>, Fault> {
        let mut bytes = vec![0; self.metadata as usize];
        read_at(file, self.offset, &mut bytes)?;
        // Before version 0.15 a message began with its length; now a mark is before it.
        let start = if bytes.starts_with(&[0xff; 4]) { 8 } else { 4 };
        Ok(bytes.split_off(start.min(bytes.len())))
    }
}

fn outside() -> Fault {
    "a part lies outside of the file".into()
}

/// Reads bytes at a place.
pub fn read_at(file: &mut File, at: u64, out: &mut [u8]) -> Result<(), Fault> {
    file.seek(SeekFrom::Start(at)).and_then(|_| file.read_exact(out)).map_err(|e| e.to_string())
}

/// A record batch.
#[derive(Debug, Clone)]
pub struct Batch {
    pub rows: usize,
    /// The missing cells of each column.
    nulls: Vec<usize>,
    /// Where the buffers are in the file, and their bytes.
    buffers: Vec<(u64, u64)>,
    codec: Option<Codec>,
    /// Buffers of columns that have a number of them.
    more: Vec<usize>,
}

/// The buffers of a column of a record batch.
#[derive(Debug, Clone)]
pub struct Place {
    pub rows: usize,
    /// Missing cells.
    pub nulls: usize,
    pub buffers: Vec<(u64, u64)>,
    pub codec: Option<Codec>,
}

impl Batch {
    /// Returns the record batch of a message.
    pub fn of(batch: Table<'_>, block: Block) -> Result<Self, Fault> {
        let rows = count(batch.i64(0)?)?;
        let nodes = batch.vector::<16>(1)?.iter().map(|node| -> Result<usize, Fault> {
            let [len, nulls] = halves(node);
            let (len, nulls) = (count(len)?, count(nulls)?);
            if nulls > len { Err("more missing cells than rows".into()) } else { Ok(nulls) }
        });
        let nulls = nodes.collect::<Result<_, Fault>>()?;
        let buffers = batch.vector::<16>(2)?.iter().map(|buffer| -> Result<(u64, u64), Fault> {
            let [offset, len] = halves(buffer).map(u64::try_from);
            let (Ok(offset), Ok(len)) = (offset, len) else { return Err(outside()) };
            match offset.checked_add(len) {
                Some(end) if end <= block.body => Ok((block.offset + block.metadata + offset, len)),
                _ => Err(outside()),
            }
        });
        let buffers = buffers.collect::<Result<_, Fault>>()?;
        let codec = match batch.table(3)? {
            None => None,
            Some(packed) => match packed.u8(0)? {
                0 => Some(Codec::Lz4Frame),
                1 => Some(Codec::Zstd),
                other => return Err(format!("packed by an unknown method, {other}")),
            },
        };
        let more = batch.vector::<8>(4)?.iter().map(|&more| count(i64::from_le_bytes(more)));
        let more = more.collect::<Result<_, Fault>>()?;
        Ok(Self { rows, nulls, buffers, codec, more })
    }

    /// Returns the buffers of a column, which follows the columns `before`.
    pub fn place<'a>(
        &self,
        before: impl Iterator<Item = &'a Extent>,
        of: &Extent,
    ) -> Result<Place, Fault> {
        let mut first = Extent::default();
        for extent in before {
            first.nodes += extent.nodes;
            first.buffers += extent.buffers;
            first.views += extent.views;
        }
        let some = |from: usize, to: usize| -> Result<usize, &'static str> {
            let some = self.more.get(from..to).ok_or("fewer columns than the schema has")?;
            let sum = some.iter().try_fold(0_usize, |sum, &more| sum.checked_add(more));
            sum.ok_or("too many buffers")
        };
        let start = some(0, first.views)?.saturating_add(first.buffers);
        let end = some(first.views, first.views + of.views)?
            .saturating_add(start)
            .saturating_add(of.buffers);
        match (self.nulls.get(first.nodes), self.buffers.get(start..end)) {
            (Some(&nulls), Some(buffers)) if nulls <= self.rows => {
                if nulls > 0 && buffers.first().is_some_and(|&(_, len)| len == 0) {
                    return Err("missing cells, but no bits that say which".into());
                }
                Ok(Place { rows: self.rows, nulls, buffers: buffers.to_vec(), codec: self.codec })
            }
            _ => Err("fewer columns than the schema has".into()),
        }
    }
}

/// Returns the two numbers of a pair.
fn halves(pair: &[u8; 16]) -> [i64; 2] {
    [0_usize, 8].map(|at| i64::from_le_bytes(pair[at..].first_chunk().copied().unwrap_or_default()))
}

fn count(number: i64) -> Result<usize, Fault> {
    usize::try_from(number).map_err(|_| format!("a length of {number}"))
}

/// A buffer of which parts are read.
#[derive(Debug)]
pub struct Buffer {
    offset: u64,
    len: u64,
    codec: Option<Codec>,
    /// Bytes that it may take.
    limit: u64,
    /// All of it, where it was packed, or the part that was read last.
    held: Vec<u8>,
    is_held: bool,
}

impl Buffer {
    pub fn new((offset, len): (u64, u64), codec: Option<Codec>, limit: u64) -> Self {
        Self { offset, len, codec, limit, held: Vec::new(), is_held: false }
    }

    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Returns `len` bytes from `start` on.
    pub fn read(&mut self, file: &mut File, start: usize, len: usize) -> Result<&[u8], Fault> {
        if self.codec.is_some() && !self.is_held {
            self.unpack(file)?;
        }
        let short = || Fault::from("a buffer ends too early");
        if self.is_held {
            return self.held.get(start..).and_then(|rest| rest.get(..len)).ok_or_else(short);
        }
        let end = start.checked_add(len).filter(|&end| end as u64 <= self.len);
        end.ok_or_else(short)?;
        self.held.resize(len, 0);
        read_at(file, self.offset + start as u64, &mut self.held)?;
        Ok(&self.held)
    }

    /// Returns all bytes, and keeps them.
    pub fn all(&mut self, file: &mut File) -> Result<&[u8], Fault> {
        if !self.is_held {
            match self.codec {
                Some(_) => self.unpack(file)?,
                None => self.hold(file)?,
            }
        }
        Ok(&self.held)
    }

    fn hold(&mut self, file: &mut File) -> Result<(), Fault> {
        if self.len > self.limit {
            return Err(too_large(self.len as f64));
        }
        let mut bytes = vec![0; self.len as usize];
        read_at(file, self.offset, &mut bytes)?;
        (self.held, self.is_held) = (bytes, true);
        Ok(())
    }

    /// Unpacks a buffer, which begins with its unpacked size; -1 says that it is not packed.
    fn unpack(&mut self, file: &mut File) -> Result<(), Fault> {
        self.hold(file)?;
        let (Some((size, packed)), Some(codec)) = (self.held.split_first_chunk::<8>(), self.codec)
        else {
            return Ok(());
        };
        match u64::try_from(i64::from_le_bytes(*size)) {
            Err(_) => self.held = packed.to_vec(),
            Ok(size) if size > self.limit => return Err(too_large(size as f64)),
            Ok(size) => {
                let most = usize::try_from(self.limit).unwrap_or(usize::MAX);
                self.held = unpack(codec, packed, &[], most)?;
                if self.held.len() as u64 != size {
                    return Err("a buffer does not unpack to the size that it says".into());
                }
            }
        }
        Ok(())
    }
}
