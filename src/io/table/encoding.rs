//! The encoding of text, through crate encoding_rs.

use std::borrow::Cow;
use std::io::{self, Read};

use encoding_rs::{Decoder, Encoding, UTF_8, UTF_16BE, UTF_16LE, WINDOWS_1252};

use crate::base::{Error, Result};

/// Bytes from which the encoding is found.
pub(super) const HEAD: usize = 1 << 10;

/// Bytes that are decoded at a time.
const CHUNK: usize = 1 << 16;

/// Least bytes of UTF-16 without a mark that are recognized.
const LEAST: usize = 4;

/// Returns the encoding of a file that begins with `head`, if it is not one in which ASCII is
/// ASCII. A name decides; otherwise the byte order mark, or zeros in every second byte.
pub(super) fn detect(head: &[u8], name: Option<&str>) -> Result<Option<&'static Encoding>> {
    let found = match name {
        Some(name) => Some(Encoding::for_label(name.as_bytes()).ok_or_else(|| {
            let why = format!("{name:?} is none of the WHATWG standard, such as utf-8 or latin1");
            Error::Argument { what: "encoding", why }
        })?),
        None => {
            Encoding::for_bom(head).map(|(encoding, _)| encoding).or_else(|| without_mark(head))
        }
    };
    Ok(found.filter(|&encoding| encoding != UTF_8))
}

/// Returns the UTF-16 of a text whose first characters are ASCII.
fn without_mark(head: &[u8]) -> Option<&'static Encoding> {
    let pairs = head[..head.len().min(HEAD)].as_chunks::<2>().0;
    if 2 * pairs.len() < LEAST {
        return None;
    }
    let is_text = |byte: u8| byte != 0 && byte.is_ascii();
    match pairs {
        _ if pairs.iter().all(|pair| pair[1] == 0 && is_text(pair[0])) => Some(UTF_16LE),
        _ if pairs.iter().all(|pair| pair[0] == 0 && is_text(pair[1])) => Some(UTF_16BE),
        _ => None,
    }
}

/// Returns text in UTF-8, or else in Windows-1252, which every text of bytes is.
pub(super) fn text(bytes: &[u8]) -> Cow<'_, str> {
    match std::str::from_utf8(bytes) {
        Ok(text) => Cow::Borrowed(text),
        Err(_) => WINDOWS_1252.decode_without_bom_handling(bytes).0,
    }
}

/// Text in UTF-8, decoded while it is read. Without an encoding bytes stay as they are.
pub(super) struct Decoded<R> {
    inner: R,
    decoder: Option<Decoder>,
    encoded: Vec<u8>,
    decoded: Vec<u8>,
    /// The bytes of `decoded` that were read.
    done: usize,
    is_ended: bool,
}

impl<R: Read> Decoded<R> {
    pub fn new(inner: R, encoding: Option<&'static Encoding>) -> Self {
        let decoder = encoding.map(Encoding::new_decoder_with_bom_removal);
        let (encoded, decoded) = (Vec::new(), Vec::new());
        Self { inner, decoder, encoded, decoded, done: 0, is_ended: false }
    }
}

impl<R: Read> Read for Decoded<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let Some(decoder) = &mut self.decoder else { return self.inner.read(out) };
        while self.done == self.decoded.len() && !self.is_ended {
            self.encoded.resize(CHUNK, 0);
            let count = self.inner.read(&mut self.encoded)?;
            self.is_ended = count == 0;
            let most = decoder.max_utf8_buffer_length(count).unwrap_or(usize::MAX);
            self.decoded.resize(most, 0);
            let (_, _, written, _) =
                decoder.decode_to_utf8(&self.encoded[..count], &mut self.decoded, self.is_ended);
            self.decoded.truncate(written);
            self.done = 0;
        }
        let count = out.len().min(self.decoded.len() - self.done);
        out[..count].copy_from_slice(&self.decoded[self.done..][..count]);
        self.done += count;
        Ok(count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn utf16(text: &str, big: bool, has_mark: bool) -> Vec<u8> {
        let mark = has_mark.then_some(0xfeff);
        let units = mark.into_iter().chain(text.encode_utf16());
        units.flat_map(|u| if big { u.to_be_bytes() } else { u.to_le_bytes() }).collect()
    }

    #[test]
    fn encodings_are_found_and_decoded() {
        let plain = "a;b\n1;2\n";
        let text = "h\u{f6}he;b\n1;2\n";
        let cases = [
            (utf16(text, false, true), None, text),
            (utf16(text, true, true), None, text),
            (utf16(plain, false, false), None, plain),
            (utf16(plain, true, false), None, plain),
            (b"h\xf6he;b\n1;2\n".to_vec(), Some("latin1"), text),
            (plain.as_bytes().to_vec(), None, plain),
            (text.as_bytes().to_vec(), Some("UTF-8"), text),
        ];
        for (bytes, name, expected) in cases {
            let encoding = detect(&bytes, name).unwrap();
            let mut found = String::new();
            Decoded::new(&bytes[..], encoding).read_to_string(&mut found).unwrap();
            assert_eq!(found, expected, "{bytes:?}");
        }
        assert!(detect(b"", Some("latin-99")).is_err());
        assert_eq!(super::text(b"h\xf6he"), "h\u{f6}he");
    }
}
