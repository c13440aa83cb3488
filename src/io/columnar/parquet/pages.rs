//! The pages of a column. Crate parquet reads their headers and gives the packed bytes, which are
//! unpacked here: by crates without C, within the memory that the file may take. Words become their
//! numbers here, so that the crate decodes integers: a word of a dictionary is looked up once.

use std::fs::File;
use std::sync::Arc;

use bytes::Bytes;
use parquet::basic::{Compression, Encoding};
use parquet::column::page::{Page, PageMetadata, PageReader};
use parquet::errors::{ParquetError, Result};
use parquet::file::metadata::ColumnChunkMetaData;
use parquet::file::serialized_reader::SerializedPageReader;

use crate::io::columnar::codec::{Codec, unpack};
use crate::io::columnar::fault::Fault;
use crate::io::columnar::words::{Numbering, Words};

/// The pages of a column in a row group.
pub struct Pages {
    packed: SerializedPageReader<File>,
    codec: Option<Codec>,
    /// Bytes of an unpacked page at most.
    most: usize,
    /// The words, if the column has words.
    words: Option<Arc<Words>>,
    is_nullable: bool,
    has_dictionary: bool,
}

impl Pages {
    /// Opens the pages, each of at most `limit` bytes.
    pub fn new(
        file: File,
        column: &ColumnChunkMetaData,
        rows: usize,
        limit: u64,
        words: Option<Arc<Words>>,
    ) -> Result<Self, Fault> {
        let codec = match column.compression() {
            Compression::UNCOMPRESSED => None,
            Compression::SNAPPY => Some(Codec::Snappy),
            Compression::GZIP(_) => Some(Codec::Gzip),
            Compression::ZSTD(_) => Some(Codec::Zstd),
            Compression::LZ4_RAW => Some(Codec::Lz4Block),
            other => {
                return Err(format!(
                    "packed by {other}, which is not read; snappy, gzip, zstd and lz4_raw are"
                ));
            }
        };
        let of_column = u64::try_from(column.uncompressed_size()).unwrap_or(0);
        // Without a codec the crate leaves the pages as they are.
        let column = column.clone().into_builder().set_compression(Compression::UNCOMPRESSED);
        let column = column.build().map_err(|e| e.to_string())?;
        let packed = SerializedPageReader::new(Arc::new(file), &column, rows, None);
        Ok(Self {
            packed: packed.map_err(|e| e.to_string())?,
            codec,
            most: usize::try_from(limit.min(of_column)).unwrap_or(usize::MAX),
            words,
            is_nullable: column.column_descr().max_def_level() > 0,
            has_dictionary: false,
        })
    }

    /// Returns the bytes of a page of which the first `start` are not packed.
    fn unpacked(&self, page: &Bytes, start: usize, is_packed: bool) -> Result<Bytes> {
        let Some((start, packed)) = page.split_at_checked(start) else {
            return Err(fail("a page is shorter than its header says"));
        };
        match self.codec.filter(|_| is_packed) {
            None => Ok(page.clone()),
            Some(codec) => unpack(codec, packed, start, self.most).map(Bytes::from).map_err(fail),
        }
    }

    /// Returns a page with numbers in the place of words. `levels` is where its words begin.
    fn numbered(&self, page: Bytes, levels: usize, encoding: Encoding) -> Result<Bytes> {
        let Some(words) = &self.words else { return Ok(page) };
        match encoding {
            Encoding::PLAIN => numbers(&page, levels, &mut words.numbering()).map_err(fail),
            Encoding::RLE_DICTIONARY | Encoding::PLAIN_DICTIONARY => Ok(page),
            other => Err(fail(format!("words in encoding {other}, which are not read"))),
        }
    }

    /// Checks that a page of numbers of a dictionary follows one.
    fn check_dictionary(&self, encoding: Encoding) -> Result<()> {
        match encoding {
            Encoding::RLE_DICTIONARY | Encoding::PLAIN_DICTIONARY if !self.has_dictionary => {
                Err(fail("a page without its dictionary"))
            }
            _ => Ok(()),
        }
    }
}

/// Returns `page` with the numbers of its words, which are from `start` on.
fn numbers(page: &[u8], start: usize, numbering: &mut Numbering) -> Result<Bytes, Fault> {
    let short = || Fault::from("a page of words ends too early");
    let (head, mut rest) = page.split_at_checked(start).ok_or_else(short)?;
    let mut out = head.to_vec();
    while !rest.is_empty() {
        let (size, behind) = rest.split_first_chunk::<4>().ok_or_else(short)?;
        let size = u32::from_le_bytes(*size) as usize;
        let (word, behind) = behind.split_at_checked(size).ok_or_else(short)?;
        out.extend_from_slice(&numbering.number(word)?.to_le_bytes());
        rest = behind;
    }
    Ok(out.into())
}

/// Returns the bytes of the definition levels at the start of a page of version 1.
fn levels(page: &[u8], encoding: Encoding, count: u32) -> Result<usize> {
    match (encoding, page.first_chunk::<4>()) {
        (Encoding::RLE, Some(size)) => Ok(u32::from_le_bytes(*size) as usize + 4),
        // A bit each.
        #[expect(deprecated, reason = "old writers use it")]
        (Encoding::BIT_PACKED, _) => Ok((count as usize).div_ceil(8)),
        _ => Err(fail("a page without levels")),
    }
}

fn fail(what: impl Into<String>) -> ParquetError {
    ParquetError::General(what.into())
}

impl Iterator for Pages {
    type Item = Result<Page>;

    fn next(&mut self) -> Option<Self::Item> {
        self.get_next_page().transpose()
    }
}

impl PageReader for Pages {
    fn get_next_page(&mut self) -> Result<Option<Page>> {
        let Some(mut page) = self.packed.get_next_page()? else { return Ok(None) };
        match &mut page {
            Page::DictionaryPage { buf, num_values, .. } => {
                *buf = self.numbered(self.unpacked(buf, 0, true)?, 0, Encoding::PLAIN)?;
                // The crate allocates so many entries before it decodes them.
                if *num_values as usize > buf.len() {
                    return Err(fail("a dictionary with fewer entries than its header says"));
                }
                self.has_dictionary = true;
            }
            Page::DataPage { buf, encoding, def_level_encoding, num_values, .. } => {
                self.check_dictionary(*encoding)?;
                *buf = self.unpacked(buf, 0, true)?;
                let start = match self.is_nullable {
                    true => levels(buf, *def_level_encoding, *num_values)?,
                    false => 0,
                };
                *buf = self.numbered(buf.clone(), start, *encoding)?;
            }
            Page::DataPageV2 {
                buf,
                encoding,
                def_levels_byte_len,
                rep_levels_byte_len,
                is_compressed,
                ..
            } => {
                self.check_dictionary(*encoding)?;
                let start = *def_levels_byte_len as usize + *rep_levels_byte_len as usize;
                *buf = self.unpacked(buf, start, *is_compressed)?;
                *buf = self.numbered(buf.clone(), start, *encoding)?;
            }
        }
        Ok(Some(page))
    }

    fn peek_next_page(&mut self) -> Result<Option<PageMetadata>> {
        self.packed.peek_next_page()
    }

    fn skip_next_page(&mut self) -> Result<()> {
        self.packed.skip_next_page()
    }
}
