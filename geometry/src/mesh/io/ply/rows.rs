use std::io::BufRead;

use super::super::draft::{Checked, Fault};
use super::super::text;
use super::element::{Element, Property, Type};
use super::encoding::PlyEncoding;
use catamaran::base::push;
use catamaran::io::Source;

/// One row of an element.
#[derive(Default)]
pub(super) struct Row {
    pub index: usize,
    pub scalars: Vec<f64>,
    pub lists: Vec<Vec<f64>>,
}

/// Bytes of a binary file that were read, of which those up to `at` are taken.
#[derive(Default)]
pub(super) struct Block {
    bytes: Vec<u8>,
    at: usize,
}

impl Block {
    /// Returns the bytes that are not taken.
    pub fn left(&self) -> usize {
        self.bytes.len() - self.at
    }

    /// Takes the next `size` bytes of the file.
    #[inline]
    fn take(&mut self, source: &mut Source<'_>, size: usize) -> Checked<&[u8]> {
        if self.left() < size {
            self.fill(source, size)?;
        }
        let start = self.at;
        self.at += size;
        Ok(&self.bytes[start..self.at])
    }

    /// Reads on until there are `size` bytes.
    fn fill(&mut self, source: &mut Source<'_>, size: usize) -> Checked<()> {
        self.bytes.drain(..self.at);
        self.at = 0;
        while self.bytes.len() < size {
            let piece = match source.fill_buf() {
                Ok([]) => return Err("truncated: the file ends too early".into()),
                Ok(piece) => piece,
                Err(e) => match e.kind() {
                    std::io::ErrorKind::Interrupted => continue,
                    std::io::ErrorKind::UnexpectedEof => {
                        return Err("truncated: the file ends too early".into());
                    }
                    _ => return Err(Fault::Error(source.io_error(e))),
                },
            };
            let count = piece.len().min(BLOCK);
            self.bytes.extend_from_slice(&piece[..count]);
            source.consume(count);
        }
        Ok(())
    }
}

/// Most bytes of a block that are read at a time.
const BLOCK: usize = 1 << 16;

/// Reads the rows of an element one by one.
pub(super) struct Rows<'s, 'a> {
    source: &'s mut Source<'a>,
    encoding: PlyEncoding,
    element: &'s Element,
    /// Size of a row in bytes, if all rows have the same.
    fixed: Option<usize>,
    done: usize,
    row: Row,
    block: &'s mut Block,
    /// The number of lines of text with more numbers than the header declares, and the first.
    pub longer: (usize, usize),
}

impl<'s, 'a> Rows<'s, 'a> {
    /// Creates a reader of the rows of an element.
    pub fn new(
        source: &'s mut Source<'a>,
        block: &'s mut Block,
        encoding: PlyEncoding,
        element: &'s Element,
    ) -> Self {
        let (mut scalars, mut lists, mut bytes) = (0, 0, 0);
        for property in &element.properties {
            match property.counted_by {
                Some(_) => lists += 1,
                None => {
                    scalars += 1;
                    bytes += property.item.size();
                }
            }
        }
        let row = Row { index: 0, scalars: vec![0.0; scalars], lists: vec![Vec::new(); lists] };
        let fixed = (lists == 0).then_some(bytes);
        Self { source, encoding, element, fixed, done: 0, row, block, longer: (0, 0) }
    }

    /// Reads the next row; `None` after the last one.
    pub fn next(&mut self) -> Checked<Option<&Row>> {
        // A row without properties takes no bytes, so any count of them would be accepted.
        if self.done == self.element.count || self.element.properties.is_empty() {
            return Ok(None);
        }
        self.row.index = self.done;
        match self.encoding {
            PlyEncoding::Ascii => self.text_row()?,
            PlyEncoding::LittleEndian | PlyEncoding::BigEndian => {
                let read = self.binary_row();
                let (name, index) = (&self.element.name, self.done);
                read.map_err(|fault| fault.of(|| format!("{name} {index}")))?;
            }
        }
        self.done += 1;
        Ok(Some(&self.row))
    }

    /// Skips all rows, for elements that are no part of a mesh.
    pub fn skip(&mut self) -> Checked<()> {
        while self.next()?.is_some() {}
        Ok(())
    }

    fn text_row(&mut self) -> Checked<()> {
        let Self { source, element, done, row, longer, .. } = self;
        loop {
            let number = source.line() + 1;
            let Some(line) = source.next_bytes()? else {
                let (name, count) = (&element.name, element.count);
                return Err(format!("truncated: {done} of {count} rows of element {name}").into());
            };
            // Whether there are more numbers; `None`: fewer.
            let more = {
                let mut words = text::words(line).peekable();
                if words.peek().is_none() {
                    continue;
                }
                filled(row, element, &mut words)?.map(|()| words.next().is_some())
            };
            match more {
                None => {
                    let first = line.to_vec();
                    return self.continued_row(&first, number);
                }
                Some(true) => {
                    *longer = (longer.0 + 1, if longer.0 == 0 { number } else { longer.1 });
                }
                Some(false) => {}
            }
            return Ok(());
        }
    }

    /// Reads a row of text whose first line, number `number`, has too few numbers: those of the
    /// next lines must be just the others.
    fn continued_row(&mut self, first: &[u8], number: usize) -> Checked<()> {
        let Self { source, element, row, .. } = self;
        let too_few = |source: &Source<'_>| Fault::Error(source.fail_at(number, "too few numbers"));
        let (mut scalars, mut lists) = (row.scalars.iter_mut(), row.lists.iter_mut());
        let mut properties = element.properties.iter().peekable();
        // The list that is being read, and how many numbers it lacks.
        let mut open: Option<(&mut Vec<f64>, usize)> = None;
        let mut line = first.to_vec();
        loop {
            {
                let mut words = text::words(&line);
                loop {
                    if let Some((list, left @ 1..)) = &mut open {
                        let Some(word) = words.next() else { break };
                        push(list, text::number(word)?)?;
                        *left -= 1;
                        continue;
                    }
                    let Some(property) = properties.peek() else {
                        let is_longer = words.next().is_some();
                        return if is_longer { Err(too_few(source)) } else { Ok(()) };
                    };
                    let Some(word) = words.next() else { break };
                    let value = text::number(word)?;
                    if property.counted_by.is_none() {
                        if let Some(scalar) = scalars.next() {
                            *scalar = value;
                        }
                    } else if let Some(list) = lists.next() {
                        list.clear();
                        open = Some((list, list_length(value)?));
                    }
                    properties.next();
                }
            }
            line.clear();
            match source.next_bytes()? {
                Some(next) => line.extend_from_slice(next),
                None => return Err(too_few(source)),
            }
        }
    }

    fn binary_row(&mut self) -> Checked<()> {
        let Self { source, element, row, block, .. } = self;
        let is_big = self.encoding == PlyEncoding::BigEndian;
        let decode = |kind: Type, own: &[u8]| kind.number(own, is_big);
        if let Some(size) = self.fixed {
            let mut rest = block.take(source, size)?;
            for (scalar, property) in row.scalars.iter_mut().zip(&element.properties) {
                let (own, after) = rest.split_at(property.item.size());
                *scalar = decode(property.item, own);
                rest = after;
            }
            return Ok(());
        }
        let (mut scalars, mut lists) = (row.scalars.iter_mut(), row.lists.iter_mut());
        for &Property { item, counted_by, .. } in &element.properties {
            let Some(counted_by) = counted_by else {
                let own = block.take(source, item.size())?;
                if let Some(scalar) = scalars.next() {
                    *scalar = decode(item, own);
                }
                continue;
            };
            let count = decode(counted_by, block.take(source, counted_by.size())?);
            let count = list_length(count)?;
            let Some(list) = lists.next() else { continue };
            list.clear();
            // In pieces, because the count may exceed the data that follows.
            let mut left = count;
            while left > 0 {
                let piece = left.min(1 << 12);
                let bytes = block.take(source, piece * item.size())?;
                for own in bytes.chunks_exact(item.size()) {
                    push(list, decode(item, own))?;
                }
                left -= piece;
            }
        }
        Ok(())
    }
}

/// Fills a row with the numbers of a line; `None` if there are too few.
fn filled<'w>(
    row: &mut Row,
    element: &Element,
    words: &mut impl Iterator<Item = &'w [u8]>,
) -> Checked<Option<()>> {
    let (mut scalars, mut lists) = (row.scalars.iter_mut(), row.lists.iter_mut());
    for property in &element.properties {
        let Some(word) = words.next() else { return Ok(None) };
        let value = text::number(word)?;
        if property.counted_by.is_none() {
            if let Some(scalar) = scalars.next() {
                *scalar = value;
            }
        } else if let Some(list) = lists.next() {
            list.clear();
            for _ in 0..list_length(value)? {
                let Some(word) = words.next() else { return Ok(None) };
                push(list, text::number(word)?)?;
            }
        }
    }
    Ok(Some(()))
}

/// Returns the length of a list, which may be stored in any type.
fn list_length(count: f64) -> Checked<usize> {
    // A file has no longer list than 32 bits count.
    let length = count as u32;
    if f64::from(length) == count {
        Ok(length as usize)
    } else {
        Err(format!("{count} is not the length of a list").into())
    }
}
