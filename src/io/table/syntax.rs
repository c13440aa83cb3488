//! Which separator a table has.

use super::missing::MissingWords;
use super::number;
use super::options::{Separator, TableOptions};
use super::sample::{Cell, Sample, SampleRow, divide, has_torn_field};
use super::splitter::{Between, Syntax};

/// The separators that are tried, in this order.
const TRIED: [Between; 5] = [
    Between::Byte(b'\t'),
    Between::Byte(b';'),
    Between::Byte(b','),
    Between::Byte(b'|'),
    Between::Blanks,
];

/// Returns the byte that ends the lines of a text: a carriage return only where there is no
/// newline.
pub(super) fn line_end(text: &[u8]) -> u8 {
    let has = |byte| memchr::memchr(byte, text).is_some();
    if has(b'\r') && !has(b'\n') { b'\r' } else { b'\n' }
}

/// Returns the separator that a first line `sep=;` announces, as Excel writes it.
pub(super) fn announced(line: &[u8]) -> Option<Separator> {
    let line = line.trim_ascii_end();
    let line = match line {
        [b'"', inner @ .., b'"'] => inner,
        line => line,
    };
    let (name, rest) = line.split_at_checked(4)?;
    match rest {
        [] if name.eq_ignore_ascii_case(b"sep=") => Some(Separator::Char('\t')),
        [byte] if name.eq_ignore_ascii_case(b"sep=") => Some(char::from(*byte).into()),
        _ => None,
    }
}

/// Returns the syntax that divides a text best, and its records.
pub(super) fn find(
    text: &[u8],
    is_last: bool,
    line: usize,
    separator: Option<Separator>,
    options: &TableOptions,
    missing: &MissingWords,
) -> (Syntax, Sample) {
    let between = separator.map(|separator| match separator {
        Separator::Char(c) => Between::Byte(c as u8),
        Separator::Blanks => Between::Blanks,
    });
    let comment = options.comment.unwrap_or('#') as u8;
    let syntax = |between, has_trailing_comments| Syntax {
        between,
        line_end: line_end(text),
        comment,
        has_trailing_comments,
        has_escapes: false,
    };
    let tried: Vec<Between> = match between {
        Some(between) => vec![between],
        // The comma can be both where quotes tell one from the other.
        None if options.decimal == Some(',') && !has_quotes_below_header(text) => {
            TRIED.into_iter().filter(|&b| b != Between::Byte(b',')).collect()
        }
        None => TRIED.into(),
    };
    // Comments after rows are looked for only where rows need it: words may have a `#`, too.
    let is_asked = options.comment.is_some();
    let trailing: &[bool] = if is_asked { &[true] } else { &[false, true] };
    let mut best: Option<(f64, Syntax, Sample)> = None;
    for &has_trailing in trailing {
        if has_trailing && !is_asked && memchr::memchr(comment, text).is_none() {
            continue;
        }
        for &between in &tried {
            let syntax = syntax(between, has_trailing);
            let sample = divide(text, syntax, is_last, line);
            let (syntax, sample) = with_escapes(text, is_last, line, syntax, sample);
            let score = score(&sample, missing, separator.is_some());
            if best.as_ref().is_none_or(|(most, _, _)| score > most + MARGIN) {
                best = Some((score, syntax, sample));
            }
        }
    }
    match best {
        Some((_, syntax, sample)) => (syntax, sample),
        None => {
            let syntax = syntax(Between::Byte(b','), is_asked);
            (syntax, divide(text, syntax, is_last, line))
        }
    }
}

/// Returns whether the first record of a text that goes on may be longer than the text: for some
/// separator its quotes hold the ends of all lines.
pub(super) fn may_hold_all(text: &[u8], syntax: Syntax, line: usize) -> bool {
    let mut bytes = TRIED.into_iter().filter(|between| *between != Between::Blanks);
    bytes.any(|between| divide(text, Syntax { between, ..syntax }, false, line).rows.is_empty())
}

/// Returns a syntax in which a backslash makes a quote one of its field, with its records, if
/// fields are torn without it and none is with it; else what is given.
fn with_escapes(
    text: &[u8],
    is_last: bool,
    line: usize,
    syntax: Syntax,
    sample: Sample,
) -> (Syntax, Sample) {
    let Between::Byte(separator) = syntax.between else { return (syntax, sample) };
    let has_torn = |sample: &Sample, syntax: Syntax| {
        let is_torn =
            |row: &SampleRow| has_torn_field(&text[row.start..row.end], separator, syntax);
        sample.rows.iter().any(is_torn)
    };
    if memchr::memmem::find(text, b"\\\"").is_some() && has_torn(&sample, syntax) {
        let escaped = Syntax { has_escapes: true, ..syntax };
        let other = divide(text, escaped, is_last, line);
        if !has_torn(&other, escaped) {
            return (escaped, other);
        }
    }
    (syntax, sample)
}

/// The weight of the first row in the score of a separator.
const TIE: f64 = 1e-3;

fn has_quotes_below_header(text: &[u8]) -> bool {
    let end = memchr::memchr(line_end(text), text).unwrap_or(text.len());
    memchr::memchr(b'"', &text[end..]).is_some()
}

/// A later separator must be better than an earlier one by this much.
const MARGIN: f64 = 1e-9;

/// Returns how well a separator divides the rows, from 0 to 3.5: the share of rows of the usual
/// width whose first field ends with its quotes, the share of fields that are numbers or missing,
/// up to 1 if there are several fields, and a half if the first row, which may be a header, has as
/// many, or one less but several: names of rows may have none. Numbers in the first row break ties.
fn score(sample: &Sample, missing: &MissingWords, is_given: bool) -> f64 {
    let rows = &sample.rows;
    if rows.is_empty() {
        return 0.0;
    }
    let width = width(sample);
    let data = if rows.len() > 1 { &rows[1..] } else { &rows[..] };
    let even = data.iter().filter(|row| row.fields.len() == width && !row.is_torn).count();
    let (mut fields, mut numbers) = (0_usize, 0_usize);
    for field in data.iter().flat_map(|row| &row.fields) {
        fields += 1;
        numbers += usize::from(Cell::of(field, missing) != Cell::Word);
    }
    let (even, numbers) = (even as f64 / data.len() as f64, numbers as f64 / fields.max(1) as f64);
    // Fields that are all words may have been divided anywhere.
    let several = if width > 1 || is_given { 0.5 + 0.5 * numbers } else { 0.0 };
    let names = rows[0].fields.len();
    let is_whole = names > 1 && (names == width || names + 1 == width);
    let is_word = |field: &&Vec<u8>| Cell::of(field, missing) == Cell::Word;
    let words = rows[0].fields.iter().filter(is_word).count() as f64;
    let tie = TIE * (1.0 - words / rows[0].fields.len().max(1) as f64);
    even + numbers + several + 0.5 * f64::from(u8::from(is_whole)) + tie
}

/// Returns the number of fields that most rows have; of the first rows, when as many have another.
/// A row of words above a single row counts for a header, which may have a name less.
pub(super) fn width(sample: &Sample) -> usize {
    let mut counts: Vec<(usize, usize)> = Vec::new();
    // The first row may be a title or a header.
    let is_header = |row: &SampleRow| row.fields.iter().all(|field| number::readings(field) == 0);
    let data = match &sample.rows[..] {
        [first, rest @ ..] if rest.len() > 1 || !rest.is_empty() && is_header(first) => rest,
        rows => rows,
    };
    for row in data {
        let width = row.fields.len();
        match counts.iter_mut().find(|(known, _)| *known == width) {
            Some((_, count)) => *count += 1,
            None => counts.push((width, 1)),
        }
    }
    let most = counts.iter().map(|(_, count)| *count).max();
    counts.into_iter().find(|(_, count)| Some(*count) == most).map_or(0, |(width, _)| width)
}
