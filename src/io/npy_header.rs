//! The header of a NumPy array: magic bytes, version, length, and a Python dict of the type, the
//! order and the shape. Source: NEP 1 and the reference of `numpy.lib.format`, versions 1.0 to 3.0.

use std::fmt::Display;
use std::io::{self, Read, Write};
use std::iter::repeat_n;

use super::extents::{padded_bytes, tuple};
use super::table::option;

const MAGIC: [u8; 6] = *b"\x93NUMPY";

/// Most bytes of the dict; its three entries take some hundred.
const LONGEST: usize = 1 << 20;

/// Most characters of a file in a message, escapes included.
const EXCERPT: usize = 60;

/// The first entry of a file that numpy writes is at a multiple of this.
const ALIGNMENT: usize = 64;

/// Digits and blanks that numpy writes for the extent along which a file can grow.
const GROWTH: usize = 21;

/// The contents of a header.
#[derive(Debug)]
pub(super) struct Header {
    /// The type of the entries, such as `<f8`.
    pub descr: String,
    /// Whether the first index runs fastest.
    pub by_columns: bool,
    pub shape: Vec<usize>,
    /// The number of entries.
    pub len: usize,
    /// Bytes before the first entry.
    pub offset: u64,
}

impl Header {
    /// Returns the message for entries that are not what a reader takes.
    pub fn refusal(&self, wanted: &str) -> String {
        format!("entries of type '{}' are not {wanted}", excerpt(&self.descr))
    }
}

/// Reads the header from the start of `source`, and nothing behind it.
///
/// # Errors
/// Those of `source`; [`io::ErrorKind::InvalidData`] says what is wrong with the header.
pub(super) fn read(source: &mut impl Read) -> io::Result<Header> {
    let mut start = Vec::new();
    source.by_ref().take(8).read_to_end(&mut start)?;
    // A short file that begins otherwise is no truncated array.
    if !MAGIC.starts_with(&start[..start.len().min(MAGIC.len())]) {
        let format = option("format");
        return Err(broken(format!(
            "magic bytes of numpy are missing, so it is not an npy file; {format} = table reads \
             text"
        )));
    }
    let [.., major, minor] = <[u8; 8]>::try_from(&start[..]).map_err(|_| truncated())?;
    let width = match (major, minor) {
        (1, 0) => 2,
        (2 | 3, 0) => 4,
        _ => return Err(broken(format!("version {major}.{minor} is none of 1.0, 2.0 and 3.0"))),
    };
    let mut length = [0; 4];
    fill(source, &mut length[..width])?;
    let length = u32::from_le_bytes(length) as usize;
    if length > LONGEST {
        return Err(broken(format!("it announces {length} bytes")));
    }
    let mut dict = vec![0; length];
    fill(source, &mut dict)?;
    let dict: String = match major {
        3 => String::from_utf8(dict).map_err(|_| broken("it is not UTF-8"))?,
        // The first 256 characters of Unicode are those of Latin-1.
        _ => dict.into_iter().map(char::from).collect(),
    };
    let (descr, by_columns, shape) = Text(&dict).dict()?;
    padded_bytes(&shape, entry_bytes(descr)).map_err(too_large)?;
    let len = shape.iter().product();
    let offset = (start.len() + width + length) as u64;
    Ok(Header { descr: descr.into(), by_columns, shape, len, offset })
}

fn fill(source: &mut impl Read, bytes: &mut [u8]) -> io::Result<()> {
    source.read_exact(bytes).map_err(|e| match e.kind() {
        io::ErrorKind::UnexpectedEof => truncated(),
        _ => e,
    })
}

/// Returns the number at the end of a type string such as `<f8`; 1 without one.
fn entry_bytes(descr: &str) -> usize {
    let digits = descr.trim_start_matches(|c: char| !c.is_ascii_digit());
    digits.parse().unwrap_or(1).max(1)
}

/// Returns the text without the white space and the comments at its start, which Python's tokenizer
/// skips between the words of a dict and behind it.
fn skip_blanks(mut text: &str) -> &str {
    loop {
        text = text.trim_ascii_start();
        let Some(comment) = text.strip_prefix('#') else { return text };
        text = comment.trim_start_matches(|c: char| c != '\n' && c != '\r');
    }
}

/// The part of a header that has not been read.
struct Text<'a>(&'a str);

impl<'a> Text<'a> {
    /// Reads all of the text; returns the values of `descr`, `fortran_order` and `shape`.
    fn dict(mut self) -> io::Result<(&'a str, bool, Vec<usize>)> {
        let (mut descr, mut by_columns, mut shape) = (None, None, None);
        self.require("{")?;
        while !self.skip("}") {
            let key = self.string()?;
            self.require(":")?;
            let twice = match key {
                "descr" => descr.replace(self.descr()?).is_some(),
                "fortran_order" => by_columns.replace(self.boolean()?).is_some(),
                "shape" => shape.replace(self.shape()?).is_some(),
                _ => return Err(broken(format!("unknown key '{}'", excerpt(key)))),
            };
            if twice {
                return Err(broken(format!("key '{key}' comes twice")));
            }
            if !self.skip(",") {
                self.require("}")?;
                break;
            }
        }
        if !skip_blanks(self.0).is_empty() {
            return Err(broken("more than blanks after its dict"));
        }
        let missing = |key: &str| broken(format!("key '{key}' is missing"));
        Ok((
            descr.ok_or_else(|| missing("descr"))?,
            by_columns.ok_or_else(|| missing("fortran_order"))?,
            shape.ok_or_else(|| missing("shape"))?,
        ))
    }

    fn descr(&mut self) -> io::Result<&'a str> {
        let text = skip_blanks(self.0);
        if text.starts_with('[') {
            let end = text.rfind(']').map_or(text.len(), |last| last + 1);
            let list = excerpt(&text[..end]);
            let what = format!(
                "entries of the structured type {list} are not real numbers: \
                 numpy.lib.recfunctions.structured_to_unstructured makes columns of its fields"
            );
            return Err(io::Error::new(io::ErrorKind::InvalidData, what));
        }
        self.string()
    }

    fn boolean(&mut self) -> io::Result<bool> {
        if self.skip("True") {
            Ok(true)
        } else if self.skip("False") {
            Ok(false)
        } else {
            Err(self.unexpected("True or False"))
        }
    }

    fn shape(&mut self) -> io::Result<Vec<usize>> {
        self.require("(")?;
        let mut shape = Vec::new();
        while !self.skip(")") {
            shape.push(self.number()?);
            if self.skip(",") {
                continue;
            }
            // In Python (3) is a number, and (3,) a tuple.
            if shape.len() == 1 {
                return Err(self.unexpected("','"));
            }
            self.require(")")?;
            break;
        }
        Ok(shape)
    }

    /// Reads a whole number; Python 2 wrote an L behind some.
    fn number(&mut self) -> io::Result<usize> {
        let text = skip_blanks(self.0);
        let rest = text.trim_start_matches(|c: char| c.is_ascii_digit());
        let digits = &text[..text.len() - rest.len()];
        // In Python 2 a number that begins with 0 is octal, in Python 3 an error.
        if digits.is_empty() || (digits.len() > 1 && digits.starts_with('0')) {
            return Err(self.unexpected("a whole number"));
        }
        self.0 = rest.strip_prefix('L').unwrap_or(rest);
        digits.parse().map_err(|_| too_large(format!("shape too large: extent {digits}")))
    }

    /// Reads a string; Python 2 wrote a letter before some. Those with escapes are refused.
    fn string(&mut self) -> io::Result<&'a str> {
        let text = skip_blanks(self.0);
        let text = text.strip_prefix(['u', 'b']).unwrap_or(text);
        let split = ['\'', '"'].into_iter().find_map(|quote| {
            let (string, rest) = text.strip_prefix(quote)?.split_once(quote)?;
            (!string.contains(['\\', '\n', '\r'])).then_some((string, rest))
        });
        let (string, rest) = split.ok_or_else(|| self.unexpected("a string"))?;
        self.0 = rest;
        Ok(string)
    }

    /// Skips blanks and, if it comes next, `token`; returns whether it does.
    fn skip(&mut self, token: &str) -> bool {
        self.0 = skip_blanks(self.0);
        let rest = self.0.strip_prefix(token);
        self.0 = rest.unwrap_or(self.0);
        rest.is_some()
    }

    fn require(&mut self, token: &str) -> io::Result<()> {
        if self.skip(token) { Ok(()) } else { Err(self.unexpected(&format!("'{token}'"))) }
    }

    fn unexpected(&self, wanted: &str) -> io::Error {
        match skip_blanks(self.0).trim_ascii_end() {
            "" => broken(format!("{wanted} expected, but it ends")),
            rest => broken(format!("{wanted} expected, not {}", excerpt(rest))),
        }
    }
}

/// Returns the start of a part of a file, fit for a message of one line: control characters and
/// other line breaks are escaped.
fn excerpt(text: &str) -> String {
    let (mut start, mut width) = (String::new(), 0);
    for c in text.chars() {
        let is_plain = !c.is_control() && !matches!(c, '\u{2028}' | '\u{2029}');
        width += if is_plain { 1 } else { c.escape_default().len() };
        if width > EXCERPT {
            start.push_str("...");
            break;
        }
        if is_plain { start.push(c) } else { start.extend(c.escape_default()) }
    }
    start
}

fn broken(what: impl Display) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, format!("broken npy header: {what}"))
}

fn truncated() -> io::Error {
    broken("truncated: the file ends too early")
}

/// Returns the error for a shape; `what` may be as long as the header.
fn too_large(what: impl AsRef<str>) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, excerpt(what.as_ref()))
}

/// Writes the bytes that `numpy.save` writes before the entries of an array. `code` is the kind and
/// the size of the entries, of more than one byte, such as `f8`; their byte order is that of the
/// machine.
///
/// # Errors
/// Those of `sink`.
pub(super) fn write(
    sink: &mut dyn Write,
    code: &str,
    by_columns: bool,
    shape: &[usize],
) -> io::Result<()> {
    let order = if cfg!(target_endian = "big") { '>' } else { '<' };
    let fortran_order = if by_columns { "True" } else { "False" };
    let tuple = tuple(shape);
    let mut dict = format!(
        "{{'descr': '{order}{code}', 'fortran_order': {fortran_order}, 'shape': {tuple}, }}"
    );
    let grows = if by_columns { shape.last() } else { shape.first() };
    let room = grows.map_or(0, |extent| GROWTH.saturating_sub(extent.to_string().len()));
    dict.extend(repeat_n(' ', room));
    // A header that is aligned without blanks gets 64 of them.
    let end = |start: usize| (start + dict.len() + 1) / ALIGNMENT * ALIGNMENT + ALIGNMENT;
    let mut bytes = MAGIC.to_vec();
    let end = match u16::try_from(end(10) - 10) {
        Ok(length) => {
            bytes.extend([1, 0]);
            bytes.extend(length.to_le_bytes());
            end(10)
        }
        Err(_) => {
            let length = u32::try_from(end(12) - 12).map_err(io::Error::other)?;
            bytes.extend([2, 0]);
            bytes.extend(length.to_le_bytes());
            end(12)
        }
    };
    bytes.extend(dict.bytes());
    bytes.resize(end - 1, b' ');
    bytes.push(b'\n');
    sink.write_all(&bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a file of this version and dict, with two bytes of entries.
    fn file(major: u8, dict: &[u8]) -> Vec<u8> {
        let length = (dict.len() as u32).to_le_bytes();
        let width = if major == 1 { 2 } else { 4 };
        [&MAGIC, &[major, 0][..], &length[..width], dict, b"\x01\x02"].concat()
    }

    fn read_dict(dict: impl AsRef<[u8]>) -> io::Result<Header> {
        read(&mut &file(2, dict.as_ref())[..])
    }

    fn refusal(bytes: &[u8]) -> String {
        let error = read(&mut &bytes[..]).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::InvalidData);
        let said = error.to_string();
        assert!(said.len() < 200 && !said.contains(char::is_control), "{said:?}");
        said
    }

    #[test]
    fn every_version_is_read_and_what_follows_is_left() {
        let dict = b"{'descr': '<f8', 'fortran_order': False, 'shape': (3, 4), }     \n";
        for (major, width) in [(1, 2), (2, 4), (3, 4)] {
            let bytes = file(major, dict);
            let mut rest = &bytes[..];
            let header = read(&mut rest).unwrap();
            assert_eq!((&header.descr[..], header.by_columns), ("<f8", false));
            assert_eq!((&header.shape[..], header.len), (&[3, 4][..], 12));
            assert_eq!((header.offset, rest), (8 + width + dict.len() as u64, &[1, 2][..]));
        }
    }

    #[test]
    fn dicts_are_read_however_they_are_written() {
        for dict in [
            "{'descr': '>i2', 'fortran_order': True, 'shape': (3, 4)}",
            "{'shape': (3, 4), 'fortran_order': True, 'descr': '>i2'}",
            "{\"descr\": \">i2\", \"shape\": (3, 4), 'fortran_order': True,}\n",
            "{'descr':'>i2','fortran_order':True,'shape':(3,4)}",
            " {\n\t'descr' : '>i2' ,\r\n 'fortran_order' : True , 'shape' : ( 3 , 4 , ) , } \n\n ",
            // White space and comments as Python's tokenizer skips them.
            "{'descr': '>i2', 'fortran_order': True, 'shape': (3, 4)}\t",
            "{'descr': '>i2', 'fortran_order': True, 'shape': (3, 4)}\r",
            "{'descr': '>i2', 'fortran_order': True, 'shape': (3, 4)} \x0c\t\r\n\t \n",
            "{'descr': '>i2', 'fortran_order': True, 'shape': (3, 4)} # saved by hand",
            "{'descr': '>i2', # big\n\x0c'fortran_order': True, # {\r'shape': (3, 4)}\n# }\n",
            // Of Python 2.
            "{'descr': '>i2', 'fortran_order': True, 'shape': (3L, 4L), }\n",
            "{u'descr': u'>i2', b'fortran_order': True, u\"shape\": (3L, 4), }\n",
        ] {
            let header = read_dict(dict).unwrap();
            assert_eq!((&header.descr[..], header.by_columns), (">i2", true), "{dict}");
            assert_eq!((&header.shape[..], header.len), (&[3, 4][..], 12), "{dict}");
        }
    }

    #[test]
    fn shapes_have_any_number_of_extents() {
        for (tuple, shape, len) in [
            ("()", &[0; 0][..], 1),
            ("( )", &[], 1),
            ("(3,)", &[3], 3),
            ("(3L , )", &[3], 3),
            ("(0,)", &[0], 0),
            ("(0, 4294967296)", &[0, 1 << 32], 0),
            ("(2, 3, 4, 5)", &[2, 3, 4, 5], 120),
        ] {
            let dict = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {tuple}, }}\n");
            let header = read_dict(dict).unwrap();
            assert_eq!((&header.shape[..], header.len), (shape, len), "{tuple}");
        }
    }

    #[test]
    fn broken_dicts_are_refused_with_what_is_wrong() {
        let [descr, order, shape] = ["'descr': '<f8'", "'fortran_order': False", "'shape': (3,)"];
        for (dict, expected) in [
            (String::new(), "'{' expected, but it ends"),
            ("[]".into(), "'{' expected, not []"),
            ("{".into(), "a string expected, but it ends"),
            ("{}".into(), "key 'descr' is missing"),
            (format!("{{{order}, {shape}}}"), "key 'descr' is missing"),
            (format!("{{{descr}, {shape}}}"), "key 'fortran_order' is missing"),
            (format!("{{{descr}, {order}}}"), "key 'shape' is missing"),
            (format!("{{{descr}, {order}, {shape}, {order}}}"), "key 'fortran_order' comes twice"),
            (format!("{{{descr}, {order}, {shape}, 'a\tb': 3}}"), r"unknown key 'a\tb'"),
            (format!("{{{descr}, {order}, {shape}}}\u{b}"), "more than blanks after its dict"),
            (format!("{{{descr}, {order}, {shape}}}#\n1"), "more than blanks after its dict"),
            (format!("{{{descr}, {order}, {shape}, 3: 3}}"), "a string expected, not 3: 3}"),
            (format!("{{{descr}, {order}, {shape},,}}"), "a string expected, not ,}"),
            (format!("{{{descr}, {order}, {shape}"), "'}' expected, but it ends"),
            (format!("{{{descr}, {order} {shape}}}"), "'}' expected, not 'shape': (3,)}"),
            (format!("{{{descr}, {order}, 'shape' (3,)}}"), "':' expected, not (3,)}"),
            (format!("{{{descr}, {order}, {shape}}} {{}}"), "more than blanks after its dict"),
            (format!("{{{descr}, {order}, {shape}}}\n\0"), "more than blanks after its dict"),
            (format!("{{'descr': '<f8, {order}, {shape}}}"), "'}' expected, not fortran_order"),
            (format!("{{'descr': '\\x3cf8', {order}, {shape}}}"), "a string expected, not '\\x3c"),
            (format!("{{'descr': ('<f8', (2,)), {order}, {shape}}}"), "a string expected, not ("),
            (format!("{{'descr': 8, {order}, {shape}}}"), "a string expected, not 8, "),
            (format!("{{{descr}, 'fortran_order': 0, {shape}}}"), "True or False expected, not 0"),
            (format!("{{{descr}, 'fortran_order': Falsey, {shape}}}"), "'}' expected, not y, "),
        ] {
            let said = refusal(&file(1, dict.as_bytes()));
            let why = said.strip_prefix("broken npy header: ").unwrap();
            assert!(why.starts_with(expected), "{said:?} instead of {expected:?}");
        }
    }

    #[test]
    fn shapes_that_are_none_or_too_large_are_refused() {
        for (shape, expected) in [
            ("3", "'(' expected, not 3"),
            ("[3]", "'(' expected, not [3]"),
            ("(3)", "',' expected, not )"),
            ("(,)", "a whole number expected, not ,)"),
            ("(3,,)", "a whole number expected, not ,)"),
            ("(3, 4", "')' expected, not }"),
            ("(3 4)", "',' expected, not 4)"),
            ("(-3,)", "a whole number expected, not -3"),
            ("(3.0,)", "',' expected, not .0"),
            ("(03,)", "a whole number expected, not 03"),
            ("(3LL,)", "',' expected, not L"),
            ("(3 L,)", "',' expected, not L"),
            ("(18446744073709551616,)", "shape too large: extent 18446744073709551616"),
            ("(0, 99999999999999999999)", "shape too large: extent 99999999999999999999"),
            ("(4294967296, 4294967296)", "shape too large: (4294967296, 4294967296)"),
            ("(2, 4294967296, 4294967296)", "shape too large: (2, 4294967296, 4294967296)"),
            ("(0, 18446744073709551615)", "shape too large: (0, 18446744073709551615)"),
            ("(2305843009213693952, 0)", "shape too large: (2305843009213693952, 0)"),
            ("(0, 9223372036854775808)", "shape too large: (0, 9223372036854775808)"),
            // Of f8 2^56 entries and more.
            ("(72057594037927936,)", "shape too large: (72057594037927936,)"),
        ] {
            let dict = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}}}\n");
            let said = refusal(&file(1, dict.as_bytes()));
            let why = said.strip_prefix("broken npy header: ").unwrap_or(&said);
            assert!(why.starts_with(expected), "{said:?} instead of {expected:?}");
        }
    }

    #[test]
    fn structured_types_are_named_in_the_encoding_of_the_version() {
        let rest = "'fortran_order': False, 'shape': (2,), }\n";
        let dict = format!("{{'descr': [('ä', '<f8'), ('b', '<i4', (2,))], {rest}");
        let latin: Vec<u8> = dict.chars().map(|c| c as u8).collect();
        let expected = "entries of the structured type [('ä', '<f8'), ('b', '<i4', (2,))] are not \
                        real numbers: numpy.lib.recfunctions.structured_to_unstructured makes \
                        columns of its fields";
        assert_eq!(refusal(&file(1, &latin)), expected);
        assert_eq!(refusal(&file(2, &latin)), expected);
        assert_eq!(refusal(&file(3, dict.as_bytes())), expected);
        assert_eq!(refusal(&file(3, &latin)), "broken npy header: it is not UTF-8");
        assert!(refusal(&file(1, b"{'descr': [")).contains("structured type [ are not"));
    }

    #[test]
    fn other_files_versions_and_truncated_headers_are_refused() {
        let missing = "broken npy header: magic bytes of numpy are missing, so it is not an npy \
                       file; option `format` = table reads text";
        for other in [&b"PK\x03\x04 an archive"[..], b"PK\x03\x04", b"1,2\n", b"\x93NUMP\n"] {
            assert_eq!(refusal(other), missing);
        }
        let truncated = "broken npy header: truncated: the file ends too early";
        let whole = file(2, b"{'descr': '<f8', 'fortran_order': False, 'shape': (1,)}\n");
        for length in 0..whole.len() - 2 {
            assert_eq!(refusal(&whole[..length]), truncated);
        }
        for version in [[0, 0], [1, 1], [4, 0], [255, 255]] {
            let said = refusal(&[&MAGIC, &version[..], &[0; 100]].concat());
            let expected = format!("version {}.{} is none of", version[0], version[1]);
            assert!(said.contains(&expected), "{said}");
        }
    }

    #[test]
    fn headers_that_would_take_memory_or_time_are_refused() {
        for major in [2, 3] {
            let long = [&MAGIC, &[major, 0][..], b"\xff\xff\xff\x7f{"].concat();
            assert_eq!(refusal(&long), "broken npy header: it announces 2147483647 bytes");
            let absent = [&MAGIC, &[major, 0][..], &(LONGEST as u32).to_le_bytes()].concat();
            assert!(refusal(&absent).contains("truncated"));
        }
        for piece in ["{", "[", "(", "((1,", "'", "u", "9", "1,", "0,", " ", "{'descr':", "\u{0}"] {
            let many = piece.repeat(LONGEST / 2 / piece.len());
            for dict in [
                many.clone(),
                format!("{{'descr': {many}, 'fortran_order': False, 'shape': (1,)}}"),
                format!("{{'descr': '{many}"),
                format!("{{'descr': '<f8', 'fortran_order': {many}, 'shape': (1,)}}"),
                format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {many}}}"),
                format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({many}}}"),
                format!("{{'descr': '<f8', 'fortran_order': False, 'shape': (1,), {many}: 1}}"),
                format!("{{'descr': '<f8', 'fortran_order': False, 'shape': (1,)}}x{many}"),
            ] {
                refusal(&file(2, dict.as_bytes()));
            }
        }
    }

    #[test]
    fn excerpts_of_a_header_are_one_printable_line() {
        for (c, shown) in [
            ('\n', r"\n"),
            ('\0', r"\u{0}"),
            ('\u{85}', r"\u{85}"),
            ('\u{2028}', r"\u{2028}"),
            ('\u{2029}', r"\u{2029}"),
            ('ä', "ä"),
        ] {
            assert_eq!(excerpt(&format!("a{c}b")), format!("a{shown}b"));
            let long = excerpt(&c.to_string().repeat(EXCERPT + 1));
            assert!(long.ends_with("...") && long.chars().count() <= EXCERPT + 3, "{long}");
        }
        assert_eq!(excerpt(&"x".repeat(EXCERPT)), "x".repeat(EXCERPT));
        let dict = "{'descr': '<f8', 'fortran_order': False, 'a\u{2028}b': 3}";
        assert!(refusal(&file(3, dict.as_bytes())).ends_with(r"unknown key 'a\u{2028}b'"));
    }

    #[test]
    fn a_type_of_any_length_is_named_in_one_line() {
        let descr = format!("<\u{1b}{}", "M8".repeat(1000));
        let dict = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': (1,)}}");
        let said = read_dict(dict).unwrap().refusal("real numbers");
        assert!(said.starts_with(r"entries of type '<\u{1b}M8M8") && said.len() < 200, "{said}");
        assert!(said.ends_with("M8M...' are not real numbers"), "{said}");
    }

    /// The bytes are those of numpy 2.4.6.
    #[test]
    fn headers_are_written_as_numpy_writes_them() {
        let long = "(1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 100)";
        let mut shape = [1; 14];
        shape[13] = 100;
        for (code, by_columns, shape, length, dict) in [
            ("f8", false, &[3, 4][..], 0x76, "'<f8', 'fortran_order': False, 'shape': (3, 4)"),
            ("f4", true, &[3, 4], 0x76, "'<f4', 'fortran_order': True, 'shape': (3, 4)"),
            ("u8", false, &[3], 0x76, "'<u8', 'fortran_order': False, 'shape': (3,)"),
            ("i8", false, &[0], 0x76, "'<i8', 'fortran_order': False, 'shape': (0,)"),
            ("f8", false, &[], 0x76, "'<f8', 'fortran_order': False, 'shape': ()"),
            // With room for the extent that may grow, once aligned without blanks, once with less.
            ("f8", false, &shape, 0xb6, &format!("'<f8', 'fortran_order': False, 'shape': {long}")),
            ("f8", true, &shape, 0x76, &format!("'<f8', 'fortran_order': True, 'shape': {long}")),
        ] {
            let mut written = Vec::new();
            write(&mut written, code, by_columns, shape).unwrap();
            let dict = format!("{{'descr': {dict}, }}");
            let blanks = " ".repeat(length - dict.len() - 1);
            let start = [&b"\x93NUMPY\x01\x00"[..], &[length as u8, 0]].concat();
            let expected = [&start[..], dict.as_bytes(), blanks.as_bytes(), b"\n"].concat();
            assert!(written == expected, "{}", String::from_utf8_lossy(&written));
            assert_eq!(written.len() % 64, 0);
        }
    }

    #[test]
    fn a_header_of_more_than_64_kib_has_version_2() {
        for (count, start, end) in [
            (21_811, &b"\x93NUMPY\x01\x00\xf6\xff{'descr"[..], 65_536),
            (21_820, b"\x93NUMPY\x02\x00\x34\x00\x01\x00{'descr", 65_600),
        ] {
            let mut written = Vec::new();
            write(&mut written, "f8", false, &vec![1; count]).unwrap();
            assert_eq!((&written[..start.len()], written.len()), (start, end));
            let header = read(&mut &written[..]).unwrap();
            assert_eq!((header.shape.len(), header.offset), (count, end as u64));
        }
    }
}
