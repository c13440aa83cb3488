//! The entries of a column of a record batch as numbers.

use std::fs::File;
use std::sync::Arc;

use super::batch::{Buffer, Place};
use super::schema::Entry;
use crate::io::columnar::codec::too_large;
use crate::io::columnar::decimal::{decimal, little_endian};
use crate::io::columnar::fault::Fault;
use crate::io::columnar::store::{Cells, ColumnReader, Integer};
use crate::io::columnar::words::{self, Words};
use crate::io::npy::half;

/// A column of a record batch, from its first row on.
pub struct Values {
    file: File,
    entry: Entry,
    /// The first row that was not read.
    next: usize,
    rows: usize,
    /// A bit for each cell that is there; empty if none is missing.
    present: Option<Buffer>,
    buffers: Vec<Buffer>,
    words: Numbers,
}

/// The numbers of words.
pub enum Numbers {
    None,
    Of(Arc<Words>),
    /// The numbers of words of a dictionary, some of which may be missing.
    Coded(Arc<[Option<i32>]>),
}

impl Values {
    pub fn new(file: File, place: Place, entry: Entry, words: Numbers, limit: u64) -> Self {
        let Place { rows, nulls, buffers, codec } = place;
        let mut buffers =
            buffers.into_iter().map(|buffer| Buffer::new(buffer, codec, limit)).collect::<Vec<_>>();
        let present = (!buffers.is_empty()).then(|| buffers.remove(0));
        let present = present.filter(|bits| nulls > 0 && !bits.is_empty());
        Self { file, entry, next: 0, rows, present, buffers, words }
    }

    /// Reads the next `rows` words; `None` for missing ones. They take some of the `left` bytes of
    /// memory.
    pub fn words(&mut self, rows: usize, left: &mut u64) -> Result<Vec<Option<Vec<u8>>>, Fault> {
        if u32::try_from(rows).is_err() {
            return Err("more words than have numbers".into());
        }
        let (mut found, most) = (Vec::new(), *left);
        self.each_word(rows, |word| {
            // Views may share the bytes of a long word.
            let bytes = size_of::<Option<Vec<u8>>>() + word.map_or(0, <[u8]>::len);
            *left = left.checked_sub(bytes as u64).ok_or_else(|| too_large(most as f64))?;
            found.push(word.map(<[u8]>::to_vec));
            Ok(())
        })?;
        Ok(found)
    }

    /// Returns a bit for each of the next `rows` cells, and how many bits are before them.
    fn present(&mut self, rows: usize) -> Result<Option<(Vec<u8>, usize)>, Fault> {
        let (first, file) = (self.next, &mut self.file);
        let Some(bits) = &mut self.present else { return Ok(None) };
        Ok(Some((bits_of(bits, file, first, rows)?, first % 8)))
    }

    /// Returns bytes of the buffer of entries.
    fn entries(&mut self, buffer: usize, start: usize, len: usize) -> Result<&[u8], Fault> {
        let buffer = self.buffers.get_mut(buffer).ok_or("a column without its buffers")?;
        buffer.read(&mut self.file, start, len)
    }

    /// Adds the next rows, whose entries have N bytes.
    fn numbers<const N: usize>(
        &mut self,
        rows: usize,
        cells: &mut Cells,
        number: impl Fn([u8; N]) -> f64,
    ) -> Result<(), Fault> {
        self.entries_of(rows, cells, |entry, cells| cells.values.push(number(entry)))
    }

    /// Adds the next rows, whose entries are integers of N bytes.
    fn integers<const N: usize, I: Integer>(
        &mut self,
        rows: usize,
        cells: &mut Cells,
        integer: impl Fn([u8; N]) -> I,
    ) -> Result<(), Fault> {
        self.entries_of(rows, cells, |entry, cells| cells.push_integer(integer(entry)))
    }

    /// Adds the next rows, whose entries have N bytes, by `push`.
    fn entries_of<const N: usize>(
        &mut self,
        rows: usize,
        cells: &mut Cells,
        push: impl Fn([u8; N], &mut Cells),
    ) -> Result<(), Fault> {
        let present = self.present(rows)?;
        let bytes = self.entries(0, self.next * N, rows * N)?.as_chunks::<N>().0;
        match present {
            None => {
                cells.values.reserve(rows);
                bytes.iter().for_each(|&entry| push(entry, cells));
            }
            Some((bits, before)) => {
                for (i, &entry) in bytes.iter().enumerate() {
                    match bit(&bits, before + i) {
                        true => push(entry, cells),
                        false => cells.miss(),
                    }
                }
            }
        }
        Ok(())
    }

    /// Calls `work` with the next words; `None` for missing ones.
    fn each_word(
        &mut self,
        rows: usize,
        work: impl FnMut(Option<&[u8]>) -> Result<(), Fault>,
    ) -> Result<(), Fault> {
        match self.entry {
            Entry::Text(4) => self.texts::<4>(rows, |b| u32::from_le_bytes(b) as usize, work),
            Entry::Text(_) => self.texts::<8>(rows, |b| u64::from_le_bytes(b) as usize, work),
            _ => self.views(rows, work),
        }
    }

    fn texts<const N: usize>(
        &mut self,
        rows: usize,
        number: impl Fn([u8; N]) -> usize,
        mut work: impl FnMut(Option<&[u8]>) -> Result<(), Fault>,
    ) -> Result<(), Fault> {
        if rows == 0 {
            return Ok(());
        }
        let present = self.present(rows)?;
        let ends = self.entries(0, self.next * N, (rows + 1) * N)?.as_chunks::<N>().0;
        let ends: Vec<usize> = ends.iter().map(|&end| number(end)).collect();
        let (first, last) = (ends[0], ends[rows]);
        let len = last.checked_sub(first).ok_or("words that end before they begin")?;
        let bytes: &[u8] = if len == 0 { &[] } else { self.entries(1, first, len)? };
        for (i, pair) in ends.windows(2).enumerate() {
            if present.as_ref().is_some_and(|(bits, before)| !bit(bits, before + i)) {
                work(None)?;
                continue;
            }
            let (start, end) = (pair[0].wrapping_sub(first), pair[1].wrapping_sub(first));
            work(Some(bytes.get(start..end).ok_or("words that end before they begin")?))?;
        }
        Ok(())
    }

    fn views(
        &mut self,
        rows: usize,
        mut work: impl FnMut(Option<&[u8]>) -> Result<(), Fault>,
    ) -> Result<(), Fault> {
        const SHORT: usize = 12;
        let present = self.present(rows)?;
        let views = self.entries(0, self.next * 16, rows * 16)?.as_chunks::<16>().0.to_vec();
        let number = |view: &[u8; 16], at: usize| {
            u32::from_le_bytes(view[at..].first_chunk().copied().unwrap_or_default()) as usize
        };
        for (i, view) in views.iter().enumerate() {
            if present.as_ref().is_some_and(|(bits, before)| !bit(bits, before + i)) {
                work(None)?;
                continue;
            }
            let len = number(view, 0);
            if len <= SHORT {
                work(Some(&view[4..4 + len]))?;
                continue;
            }
            let (buffer, start) = (number(view, 8), number(view, 12));
            let Self { buffers, file, .. } = &mut *self;
            let buffer = buffers.get_mut(buffer + 1).ok_or("a word in no buffer")?;
            let word = buffer.all(file)?.get(start..).and_then(|rest| rest.get(..len));
            work(Some(word.ok_or("a word beyond its buffer")?))?;
        }
        Ok(())
    }

    fn read_words(&mut self, rows: usize, cells: &mut Cells) -> Result<(), Fault> {
        let Numbers::Of(words) = &self.words else { return Err("words without numbers".into()) };
        let words = words.clone();
        let mut numbering = words.numbering();
        self.each_word(rows, |word| {
            match word {
                Some(word) => cells.values.push(words::entry(numbering.number(word)?)),
                None => cells.miss(),
            }
            Ok(())
        })
    }

    fn read_coded(&mut self, index: &Entry, rows: usize, cells: &mut Cells) -> Result<(), Fault> {
        let start = cells.values.len();
        self.read_numbers(index, rows, cells)?;
        let Numbers::Coded(numbers) = &self.words else {
            return Err("words without numbers".into());
        };
        for value in &mut cells.values[start..] {
            if value.is_nan() {
                continue;
            }
            let number = (*value >= 0.0).then(|| numbers.get(*value as usize)).flatten();
            let number = number.ok_or("a word that its dictionary does not have")?;
            *value = number.map_or(f64::NAN, words::entry);
        }
        Ok(())
    }

    fn read_numbers(&mut self, entry: &Entry, rows: usize, cells: &mut Cells) -> Result<(), Fault> {
        match *entry {
            Entry::Signed(1) => self.numbers(rows, cells, |b| i8::from_le_bytes(b).into()),
            Entry::Signed(2) => self.numbers(rows, cells, |b| i16::from_le_bytes(b).into()),
            Entry::Signed(4) => self.numbers(rows, cells, |b| i32::from_le_bytes(b).into()),
            Entry::Signed(_) => self.integers(rows, cells, i64::from_le_bytes),
            Entry::Unsigned(1) => self.numbers(rows, cells, |b| u8::from_le_bytes(b).into()),
            Entry::Unsigned(2) => self.numbers(rows, cells, |b| u16::from_le_bytes(b).into()),
            Entry::Unsigned(4) => self.numbers(rows, cells, |b| u32::from_le_bytes(b).into()),
            Entry::Unsigned(_) => self.integers(rows, cells, u64::from_le_bytes),
            Entry::Float(2) => self.numbers(rows, cells, |b| half(u16::from_le_bytes(b))),
            Entry::Float(4) => self.numbers(rows, cells, |b| f32::from_le_bytes(b).into()),
            Entry::Float(_) => self.numbers(rows, cells, f64::from_le_bytes),
            Entry::Decimal(4, scale) => {
                self.numbers(rows, cells, |b| decimal(i32::from_le_bytes(b).into(), scale))
            }
            Entry::Decimal(8, 0) => self.integers(rows, cells, i64::from_le_bytes),
            Entry::Decimal(16, 0) => self.integers(rows, cells, i128::from_le_bytes),
            Entry::Decimal(8, scale) => {
                self.numbers(rows, cells, |b| decimal(i64::from_le_bytes(b).into(), scale))
            }
            Entry::Decimal(32, 0) => {
                self.entries_of(rows, cells, |b: [u8; 32], cells| match little_endian(b) {
                    Some(integer) => cells.push_integer(integer),
                    None => cells.miss(),
                })
            }
            Entry::Decimal(32, scale) => self.numbers(rows, cells, |b: [u8; 32]| {
                little_endian(b).map_or(f64::NAN, |value| decimal(value, scale))
            }),
            Entry::Decimal(_, scale) => {
                self.numbers(rows, cells, |b| decimal(i128::from_le_bytes(b), scale))
            }
            Entry::Bool => {
                let present = self.present(rows)?;
                let (first, file) = (self.next, &mut self.file);
                let buffer = self.buffers.first_mut().ok_or("a column without its buffers")?;
                let bits = bits_of(buffer, file, first, rows)?;
                for i in 0..rows {
                    match present.as_ref().is_none_or(|(bits, before)| bit(bits, before + i)) {
                        true => cells.values.push(u8::from(bit(&bits, first % 8 + i)).into()),
                        false => cells.miss(),
                    }
                }
                Ok(())
            }
            Entry::Null => {
                (0..rows).for_each(|_| cells.miss());
                Ok(())
            }
            Entry::Text(_) | Entry::View | Entry::Coded(..) => Err("no numbers".into()),
        }
    }
}

/// Returns the bytes with the bits of rows.
fn bits_of(
    buffer: &mut Buffer,
    file: &mut File,
    first: usize,
    rows: usize,
) -> Result<Vec<u8>, Fault> {
    let start = first / 8;
    Ok(buffer.read(file, start, (first + rows).div_ceil(8) - start)?.to_vec())
}

fn bit(bits: &[u8], at: usize) -> bool {
    bits.get(at / 8).is_some_and(|byte| byte >> (at % 8) & 1 == 1)
}

impl ColumnReader for Values {
    fn read(&mut self, rows: usize, cells: &mut Cells) -> Result<(), Fault> {
        if rows > self.rows - self.next {
            return Err("fewer entries than rows".into());
        }
        match self.entry.clone() {
            Entry::Text(_) | Entry::View => self.read_words(rows, cells)?,
            Entry::Coded(index, _) => self.read_coded(&index, rows, cells)?,
            entry => self.read_numbers(&entry, rows, cells)?,
        }
        self.next += rows;
        Ok(())
    }
}
