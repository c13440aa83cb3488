//! `.gz` through crate flate2, a member after the other, with errors in the words of this crate.

use std::io::{self, BufRead, Read};

use flate2::bufread::MultiGzDecoder;

use super::packing::{damaged, truncated};

/// A file being unpacked.
pub(super) struct Unpacker<R>(MultiGzDecoder<R>);

impl<R: BufRead> Unpacker<R> {
    /// Creates an unpacker of a packed file at its start.
    pub(super) fn new(packed: R) -> Self {
        Self(MultiGzDecoder::new(packed))
    }
}

impl<R: BufRead> Read for Unpacker<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        self.0.read(out).map_err(|e| plain(e, ".gz"))
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
        let more = [&whole[..], b"and more than that"].concat();
        assert_eq!(unpacked(&more).unwrap_err().to_string(), damaged);
    }
}
