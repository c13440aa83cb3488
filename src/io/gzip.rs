//! `.gz` through crate flate2, a member after the other, with errors in the words of this crate.

use std::io::{self, BufRead, Read};

use flate2::bufread::GzDecoder;

use super::packing::{damaged, followed, truncated};

/// The byte with which a member begins.
const START: u8 = 0x1f;

/// A file being unpacked: a member of it, or nothing behind the last one.
pub(super) struct Unpacker<R>(Option<GzDecoder<R>>);

impl<R: BufRead> Unpacker<R> {
    /// Creates an unpacker of a packed file at its start.
    pub(super) fn new(packed: R) -> Self {
        Self(Some(GzDecoder::new(packed)))
    }
}

impl<R: BufRead> Read for Unpacker<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        while let Some(mut member) = self.0.take() {
            let read = member.read(out).map_err(|e| plain(e, ".gz"));
            if out.is_empty() || !matches!(read, Ok(0)) {
                self.0 = Some(member);
                return read;
            }
            self.0 = next(member.into_inner())?;
        }
        Ok(0)
    }
}

/// Returns the member that follows another, if one does. Zeros, with which tapes and blocks are
/// filled, are none.
fn next<R: BufRead>(mut packed: R) -> io::Result<Option<GzDecoder<R>>> {
    let mut is_filled = false;
    loop {
        let held = packed.fill_buf()?;
        let zeros = held.iter().take_while(|&&byte| byte == 0).count();
        match held.get(zeros) {
            Some(&START) if zeros == 0 && !is_filled => {
                return Ok(Some(GzDecoder::new(packed)));
            }
            Some(_) => return Err(followed(".gz")),
            None if zeros == 0 => return Ok(None),
            None => {}
        }
        packed.consume(zeros);
        is_filled = true;
    }
}

/// Returns the error of a decoder of deflated data in a file that ends so, in words of this crate,
/// and any other error, as of a disk, unchanged.
pub(super) fn plain(e: io::Error, ending: &str) -> io::Error {
    match e.kind() {
        _ if e.raw_os_error().is_some() => e,
        io::ErrorKind::UnexpectedEof => truncated(),
        io::ErrorKind::InvalidInput | io::ErrorKind::InvalidData => damaged(ending),
        _ => e,
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write as _;

    use flate2::Compression;
    use flate2::write::GzEncoder;

    use super::*;

    fn packed(text: &str) -> Vec<u8> {
        let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
        encoder.write_all(text.as_bytes()).unwrap();
        encoder.finish().unwrap()
    }

    fn unpacked(packed: &[u8]) -> io::Result<String> {
        let mut text = String::new();
        Unpacker::new(packed).read_to_string(&mut text).map(|_| text)
    }

    #[test]
    fn members_follow_one_another() {
        let both = [packed("one\n"), packed("two\n")].concat();
        assert_eq!(unpacked(&both).unwrap(), "one\ntwo\n");
    }

    #[test]
    fn zeros_behind_the_last_member_are_no_content() {
        for zeros in [1, 4, 512, 1 << 20] {
            let filled = [&packed("one\n")[..], &vec![0; zeros]].concat();
            assert_eq!(unpacked(&filled).unwrap(), "one\n", "{zeros}");
        }
    }

    #[test]
    fn errors_say_whether_the_file_is_truncated_or_damaged() {
        let whole = packed(&"some text\n".repeat(100));
        for cut in 1..whole.len() {
            let error = unpacked(&whole[..cut]).unwrap_err().to_string();
            assert_eq!(error, "truncated: the file ends too early", "{cut}");
        }
        let damaged = "damaged .gz file: it can't be unpacked";
        for at in [2, whole.len() / 2, whole.len() - 6] {
            let mut bytes = whole.clone();
            bytes[at] ^= 0xff;
            let error = unpacked(&bytes).unwrap_err().to_string();
            assert!(error == damaged || error.starts_with("truncated"), "{at}: {error}");
        }
        for other in [&b"and more than that"[..], b"\0\0and more", b"\0\x1f\x8b"] {
            let error = unpacked(&[&whole[..], other].concat()).unwrap_err().to_string();
            assert_eq!(error, "damaged .gz file: behind what is packed there are other bytes");
        }
    }
}
