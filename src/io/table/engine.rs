//! Reads the rows of a table, batch by batch, on several threads.

use std::io::Read;

use faer::MatMut;
use memchr::{memchr, memrchr};

use super::foreign;
use super::layout::{Decided, Layout, decide};
use super::options::TableOptions;
use super::piece::Piece;
use super::reading::TableReading;
use super::text::Text;
use crate::base::{Par, Real, Result};
use crate::io::columns::Columns;
use crate::io::rounding::RoundedIntegers;

/// Bytes of the beginning of a file that decide how it is read, unless it has few lines there.
const SAMPLE: usize = 1 << 16;

/// Bytes of text of a piece.
const PIECE: usize = 1 << 20;

/// Most pieces of a batch, which are in memory together with their numbers.
const MOST_PIECES: usize = 8;

/// Reads rows.
pub(super) struct Engine<R> {
    pub text: Text<R>,
    pub layout: Layout,
    /// The integers that were rounded so far.
    pub rounded: Option<RoundedIntegers>,
    /// Whether a comment so far would be a row without the sign of comments.
    pub has_commented_rows: bool,
    pieces: Vec<Piece>,
    par: Par,
}

/// What a batch has, besides its rows.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Batch {
    pub rows: usize,
    pub dropped: u64,
}

/// Decides how the text is read, which is then at its first row of numbers.
pub(super) fn begin<R: Read>(
    text: &mut Text<R>,
    options: &TableOptions,
    columns: &Columns,
) -> Result<(Layout, TableReading)> {
    let mut size = SAMPLE;
    loop {
        text.hold(size)?;
        let (held, is_last) = (text.held(), text.is_ended());
        // The last line may be cut.
        let whole = if is_last { held.len() } else { end_of_lines(held) };
        if memchr(0, &held[..whole]).is_some() {
            return Err(text.fail(0, foreign::binary(held)));
        }
        let found = match whole {
            0 if !is_last => None,
            _ => decide(text.path(), &held[..whole], is_last, options, columns)?,
        };
        match found {
            Some(Decided { layout, mut reading, first, start }) => {
                if !layout.has_header {
                    let mut piece = Piece::new(&layout);
                    piece.read(&layout, &held[first..start], true, true);
                    reading.has_commented_rows = piece.has_commented_row;
                }
                let line_end = layout.syntax.line_end;
                let lines = memchr::memchr_iter(line_end, &held[..start]).count();
                text.take(start, lines);
                return Ok((layout, reading));
            }
            None if whole == 0 => text.check_length(held.len())?,
            None => {}
        }
        size *= 2;
    }
}

/// Returns the bytes up to the end of the last line.
fn end_of_lines(text: &[u8]) -> usize {
    // A carriage return may be followed by a newline.
    let end = memrchr(b'\n', text).or_else(|| memrchr(b'\r', &text[..text.len().max(1) - 1]));
    end.map_or(0, |end| end + 1)
}

impl<R: Read> Engine<R> {
    pub fn new(text: Text<R>, layout: Layout, par: Par) -> Self {
        let par = par.at_most(MOST_PIECES);
        let pieces = (0..par.threads()).map(|_| Piece::new(&layout)).collect();
        Self { text, layout, rounded: None, has_commented_rows: false, pieces, par }
    }

    /// Reads some rows, or only counts them; `None` at the end of the file. The rows are those of
    /// [`Engine::pieces`].
    pub fn next(&mut self, counts_only: bool) -> Result<Option<Batch>> {
        let mut size = PIECE * self.pieces.len();
        loop {
            self.text.hold(size)?;
            let (held, is_last) = (self.text.held(), self.text.is_ended());
            self.pieces.iter_mut().for_each(Piece::clear);
            if held.is_empty() {
                return Ok(None);
            }
            let line_end = self.layout.syntax.line_end;
            self.pieces[0].is_start = self.text.lines < self.layout.first_line;
            // Quotes may hold the ends of lines, so that a piece could start within a record.
            if memchr(b'"', held).is_some() {
                self.pieces[0].read(&self.layout, held, is_last, counts_only);
            } else {
                let whole = match is_last {
                    true => held.len(),
                    false => memrchr(line_end, held).map_or(0, |end| end + 1),
                };
                let parts = cut(&held[..whole], line_end, self.pieces.len());
                let layout = &self.layout;
                self.par.for_each(self.pieces.iter_mut().zip(parts), |_, (piece, part)| {
                    piece.read(layout, part, true, counts_only);
                });
            }
            let mut batch = Batch::default();
            let (mut bytes, mut lines) = (0, 0);
            let last = self.pieces.iter().rposition(Piece::has_records).unwrap_or(0);
            for piece in &mut self.pieces[..last] {
                piece.fill_gap(&self.layout);
            }
            for piece in &self.pieces {
                if let Some(fault) = &piece.fault {
                    return Err(self.text.fail(lines + fault.line, fault.what.clone()));
                }
                if let Some(more) = &piece.rounded {
                    let line = self.text.lines + lines + more.line + 1;
                    let place = || format!("line {line}, {}", more.column);
                    RoundedIntegers::add(&mut self.rounded, more.count, place);
                }
                self.has_commented_rows |= piece.has_commented_row;
                batch.rows += piece.rows;
                batch.dropped += piece.dropped;
                // Whether blank lines mean anything, the next record decides.
                if let Some(gap) = piece.gap.as_ref().filter(|_| !is_last) {
                    bytes += gap.bytes;
                    lines += gap.line;
                    break;
                }
                bytes += piece.bytes;
                lines += piece.lines;
            }
            if bytes > 0 {
                self.text.take(bytes, lines);
                return Ok(Some(batch));
            }
            self.text.check_length(held.len())?;
            size = 2 * held.len().max(size / 2);
        }
    }

    /// Returns the pieces of the last batch, in order.
    pub fn pieces(&self) -> &[Piece] {
        &self.pieces
    }
}

/// Divides text into at most `count` parts of whole lines.
fn cut(text: &[u8], line_end: u8, count: usize) -> Vec<&[u8]> {
    let (mut parts, mut rest) = (Vec::with_capacity(count), text);
    for left in (1..=count).rev() {
        let about = rest.len() / left;
        let end = match left {
            1 => rest.len(),
            _ => memchr(line_end, &rest[about..]).map_or(rest.len(), |end| about + end + 1),
        };
        let (part, more) = rest.split_at(end);
        parts.push(part);
        rest = more;
    }
    parts
}

/// Copies rows, one after the other, into the rows of `out` from `first` on.
pub(super) fn copy_rows<T: Real>(values: &[f64], first: usize, out: &mut MatMut<'_, T>) {
    let ncols = out.ncols();
    if ncols == 0 {
        return;
    }
    for (i, row) in values.chunks_exact(ncols).enumerate() {
        for (j, &value) in row.iter().enumerate() {
            out[(first + i, j)] = T::from_f64(value);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_cut_behind_lines() {
        let text = b"1,2\n3,4\n5,6\n7,8";
        for count in 1..8 {
            let parts = cut(text, b'\n', count);
            assert_eq!(parts.len(), count);
            assert_eq!(parts.concat(), text);
            let ends = |part: &&[u8]| part.is_empty() || part.ends_with(b"\n");
            assert!(parts[..count - 1].iter().all(ends) || parts.contains(&&text[12..]));
        }
    }

    #[test]
    fn the_last_line_may_be_cut() {
        for (text, end) in [("1\n2", 2), ("1\r2", 2), ("1\r", 0), ("12", 0), ("", 0)] {
            assert_eq!(end_of_lines(text.as_bytes()), end, "{text:?}");
        }
    }
}
