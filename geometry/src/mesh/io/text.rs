//! Text of other encodings and line ends, and the words and numbers in a line of bytes.

use super::draft::Checked;

/// Number of bytes of a file that are read to detect its format.
pub(super) const LOOK: usize = 1 << 16;

/// Returns the UTF-8 of text in UTF-16 that begins with a byte order mark.
pub(super) fn of_utf16(bytes: &[u8]) -> Option<Vec<u8>> {
    let unit: fn([u8; 2]) -> u16 = match bytes {
        [0xff, 0xfe, ..] => u16::from_le_bytes,
        [0xfe, 0xff, ..] => u16::from_be_bytes,
        _ => return None,
    };
    let (units, _) = bytes.as_chunks::<2>();
    let text = char::decode_utf16(units.iter().map(|&bytes| unit(bytes)));
    // The mark stays, which readers of UTF-8 skip.
    let text: String = text.map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER)).collect();
    Some(text.into_bytes())
}

/// Returns text in UTF-8 without its byte order mark.
pub(super) fn without_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)
}

/// Returns whether the lines of a file that begins so end in a carriage return alone.
pub(super) fn ends_in_returns(head: &[u8]) -> bool {
    let head = &head[..head.len().min(LOOK)];
    let first_lines = head.split(|&byte| byte == b'\n').next().unwrap_or_default();
    let returns = first_lines.iter().filter(|&&byte| byte == b'\r').count();
    // A file with a few stray ones has line feeds, too; binary files have zeros.
    returns > 2 && (is_ply(first_lines) || !head.contains(&0))
}

/// Returns whether a file begins as PLY does.
pub(super) fn is_ply(head: &[u8]) -> bool {
    head.get(..3).is_some_and(|start| start.eq_ignore_ascii_case(b"ply"))
}

/// Replaces the carriage returns of text by line feeds: those of the header in binary PLY.
pub(super) fn returns_to_feeds(bytes: &mut [u8]) {
    let find = |what: &[u8]| bytes.windows(what.len()).position(|window| window == what);
    let end = match (find(b"\rformat binary"), find(b"\rend_header")) {
        (Some(_), Some(last)) if is_ply(bytes) => {
            let length = bytes[last + 1..].iter().position(|&byte| byte == b'\r');
            last + 1 + length.map_or(0, |length| length + 1)
        }
        _ => bytes.len(),
    };
    bytes[..end].iter_mut().filter(|byte| **byte == b'\r').for_each(|byte| *byte = b'\n');
}

/// Returns the words of a line.
pub(super) fn words(line: &[u8]) -> Words<'_> {
    Words(line)
}

/// The words of a line that are left.
#[derive(Clone)]
pub(super) struct Words<'a>(&'a [u8]);

impl<'a> Iterator for Words<'a> {
    type Item = &'a [u8];

    #[inline]
    fn next(&mut self) -> Option<&'a [u8]> {
        let (blanks, length) = first_word(self.0)?;
        let (word, rest) = self.0[blanks..].split_at(length);
        self.0 = rest;
        Some(word)
    }
}

/// Returns the number of blanks before the first word, and the length of that; `None` where there
/// are only blanks.
#[inline]
pub(super) fn first_word(text: &[u8]) -> Option<(usize, usize)> {
    let blanks = text.iter().position(|byte| !byte.is_ascii_whitespace())?;
    let rest = &text[blanks..];
    let length = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
    Some((blanks, length))
}

/// Returns a line without its comment, which begins with a #, unless that is part of a number, as
/// in `1.#IND`.
pub(super) fn uncommented(line: &[u8]) -> &[u8] {
    const KINDS: [&[u8]; 4] = [b"ind", b"inf", b"qnan", b"snan"];
    if !line.contains(&b'#') {
        return line;
    }
    let mut from = 0;
    while let Some(at) = line[from..].iter().position(|&byte| byte == b'#') {
        let (before, rest) = (&line[..from + at], &line[from + at + 1..]);
        let is_kind = |kind: &&[u8]| {
            rest.get(..kind.len()).is_some_and(|word| word.eq_ignore_ascii_case(kind))
        };
        if !before.ends_with(b"1.") || !KINDS.iter().any(is_kind) {
            return before;
        }
        from += at + 1;
    }
    line
}

/// Parses a floating-point number, including the forms in which C libraries print numbers that are
/// not finite, such as `-nan(ind)` and `1.#QNAN`, and the exponents of Fortran, as in `1.5D-3`.
pub(super) fn number(word: &[u8]) -> Checked<f64> {
    match decimal(word) {
        Some(value) => Ok(value),
        None => unusual_number(word),
    }
}

/// Returns a number with few enough digits that one operation on two exact numbers gives the
/// nearest to it (Clinger 1990), as most numbers of files; `None` for others.
fn decimal(word: &[u8]) -> Option<f64> {
    const POWERS: [f64; 23] = [
        1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16,
        1e17, 1e18, 1e19, 1e20, 1e21, 1e22,
    ];
    /// Bytes of digits and a point that are less than 2^64 together.
    const MOST: usize = 19;
    let (is_negative, text) = match word {
        [b'-', text @ ..] => (true, text),
        [b'+', text @ ..] => (false, text),
        text => (false, text),
    };
    let (mut mantissa, mut point, mut length) = (0u64, None, 0);
    for &byte in text {
        let digit = byte.wrapping_sub(b'0');
        if digit < 10 {
            mantissa = mantissa.wrapping_mul(10).wrapping_add(u64::from(digit));
        } else if byte == b'.' && point.is_none() {
            point = Some(length);
        } else {
            break;
        }
        length += 1;
    }
    let exponent = match text[length..] {
        [] => 0,
        [b'e' | b'E', ref exponent @ ..] if exponent.len() <= 4 => integer(exponent).ok()?,
        _ => return None,
    };
    let digits = length - usize::from(point.is_some());
    if digits == 0 || length > MOST || mantissa > 1 << 53 {
        return None;
    }
    let exponent = exponent - point.map_or(0, |point| (length - point - 1) as i64);
    let power = POWERS.get(exponent.unsigned_abs() as usize)?;
    let mantissa = mantissa as i64 as f64;
    let value = if exponent < 0 { mantissa / power } else { mantissa * power };
    Some(if is_negative { -value } else { value })
}

/// Parses a number in any form that [`number()`] knows.
#[cold]
fn unusual_number(word: &[u8]) -> Checked<f64> {
    let parsed = std::str::from_utf8(word).ok().and_then(|word| word.parse().ok());
    parsed.or_else(|| not_a_number(word)).or_else(|| with(word, b"dD", b'e')).ok_or_else(|| {
        let has_comma = with(word, b",", b'.').is_some();
        let why = if has_comma { ": it needs a point in place of the comma" } else { "" };
        format!("{} is not a number{why}", quoted(word)).into()
    })
}

/// Returns the number of a word in which `mark` stands in place of one of the bytes `marks`, after
/// a digit or a point.
fn with(word: &[u8], marks: &[u8], mark: u8) -> Option<f64> {
    let at = word.iter().position(|byte| marks.contains(byte))?;
    if !word[..at].last().is_some_and(|byte| byte.is_ascii_digit() || *byte == b'.') {
        return None;
    }
    let mut word = word.to_vec();
    word[at] = mark;
    std::str::from_utf8(&word).ok()?.parse().ok()
}

fn not_a_number(word: &[u8]) -> Option<f64> {
    let word = word.strip_prefix(b"-").or(word.strip_prefix(b"+")).unwrap_or(word);
    let word = word.to_ascii_lowercase();
    let is_one = word.starts_with(b"nan(") || word.starts_with(b"1.#");
    is_one.then_some(f64::NAN)
}

/// Parses a whole number.
pub(super) fn integer(word: &[u8]) -> Checked<i64> {
    let (negative, digits) = match word {
        [b'-', digits @ ..] => (true, digits),
        [b'+', digits @ ..] => (false, digits),
        digits => (false, digits),
    };
    let magnitude = digits.iter().try_fold(0i64, |sum, byte| match byte.wrapping_sub(b'0') {
        digit @ 0..10 => sum.checked_mul(10)?.checked_add(i64::from(digit)),
        _ => None,
    });
    match magnitude.filter(|_| !digits.is_empty()) {
        Some(value) => Ok(if negative { -value } else { value }),
        None => Err(format!("{} is not a whole number", quoted(word)).into()),
    }
}

/// Parses a count, from 0.
pub(super) fn count(word: &[u8]) -> Checked<usize> {
    let value = integer(word)?;
    usize::try_from(value).map_err(|_| format!("{value} is not a count").into())
}

/// Parses the next `N` numbers.
pub(super) fn numbers<'a, const N: usize>(
    words: &mut impl Iterator<Item = &'a [u8]>,
) -> Checked<[f64; N]> {
    let mut values = [0.0; N];
    for (i, value) in values.iter_mut().enumerate() {
        let word = words.next().ok_or_else(|| format!("{i} numbers where {N} are needed"))?;
        *value = number(word)?;
    }
    Ok(values)
}

/// Returns the beginning of a word in quotes, for a message.
pub(super) fn quoted(word: &[u8]) -> String {
    const SHOWN: usize = 30;
    let shown = String::from_utf8_lossy(&word[..word.len().min(SHOWN)]);
    let more = if word.len() > SHOWN { "..." } else { "" };
    format!("{:?}", format!("{shown}{more}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_the_nearest_to_their_decimals() {
        let mut state = 1u64;
        let mut random = |below: u64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 33) % below
        };
        for _ in 0..50_000 {
            let sign = ["", "-", "+"][random(3) as usize];
            let digits = |count: u64, random: &mut dyn FnMut(u64) -> u64| -> String {
                (0..count).map(|_| char::from(b'0' + random(10) as u8)).collect()
            };
            let (before, after) = (random(12), random(12));
            let (before, after) = (digits(before, &mut random), digits(after, &mut random));
            let point = ["", "."][random(2) as usize];
            let exponent = match random(3) {
                0 => format!("e{}", random(40)),
                1 => format!("E-{}", random(40)),
                _ => String::new(),
            };
            let word = format!("{sign}{before}{point}{after}{exponent}");
            let expected: Option<f64> = word.parse().ok();
            let found = number(word.as_bytes()).ok();
            assert_eq!(found.map(f64::to_bits), expected.map(f64::to_bits), "{word:?}");
        }
        for word in ["9007199254740992", "9007199254740993", "18446744073709551616", "-0", "1e22"] {
            let expected: f64 = word.parse().unwrap();
            assert_eq!(number(word.as_bytes()).ok().map(f64::to_bits), Some(expected.to_bits()));
        }
        for word in ["", "-", ".", "1e", "e5", "1.2.3", "1e+-2", "0x1", "1 2"] {
            assert!(number(word.as_bytes()).is_err(), "{word:?}");
        }
    }

    #[test]
    fn words_are_what_is_between_blanks() {
        let found: Vec<&[u8]> = words(b" \ta  bc\x0c\r d\n").collect();
        assert_eq!(found, [&b"a"[..], b"bc", b"d"]);
        assert_eq!(words(b" \t ").next(), None);
        assert_eq!(words(b"one").next(), Some(&b"one"[..]));
    }
}
