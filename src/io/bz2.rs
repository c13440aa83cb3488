//! `.bz2` through crate bzip2 (its decoder in Rust), a stream after the other, as `pbzip2` writes
//! them.

use std::io::{self, BufRead, Read};
use std::panic::{AssertUnwindSafe, catch_unwind};

use bzip2::{Decompress, Status};

use super::packing::{damaged, followed, truncated};

/// The byte with which a stream begins.
const START: u8 = b'B';

/// A file being unpacked.
pub(super) struct Unpacker<R> {
    packed: R,
    decoder: Decompress,
    /// Whether a stream has ended and no other has begun.
    has_ended: bool,
    /// The error, once there was one; every later read returns it again.
    failed: Option<Fault>,
}

/// What is wrong with a file.
#[derive(Debug, Clone, Copy)]
enum Fault {
    Truncated,
    Damaged,
    /// Other bytes follow the last stream; bzip2 itself leaves them out with a warning.
    Followed,
    NoMemory,
}

impl From<Fault> for io::Error {
    fn from(fault: Fault) -> Self {
        match fault {
            Fault::Truncated => truncated(),
            Fault::Damaged => damaged(".bz2"),
            Fault::Followed => followed(".bz2"),
            Fault::NoMemory => io::ErrorKind::OutOfMemory.into(),
        }
    }
}

impl<R: BufRead> Unpacker<R> {
    /// Creates an unpacker of a packed file at its start.
    pub(super) fn new(packed: R) -> Self {
        Self { packed, decoder: Decompress::new(false), has_ended: false, failed: None }
    }

    fn unpack(&mut self, out: &mut [u8]) -> io::Result<usize> {
        loop {
            let packed = self.packed.fill_buf()?;
            if self.has_ended {
                match packed.first() {
                    None => return Ok(0),
                    Some(&START) => {}
                    Some(_) => return Err(self.fail(Fault::Followed)),
                }
                self.decoder = Decompress::new(false);
                self.has_ended = false;
            }
            let is_last = packed.is_empty();
            let decoder = &mut self.decoder;
            let before = (decoder.total_in(), decoder.total_out());
            // The crate may panic on unexpected input.
            let decoded = catch_unwind(AssertUnwindSafe(|| decoder.decompress(packed, out)));
            let (taken, written) = (decoder.total_in() - before.0, decoder.total_out() - before.1);
            self.packed.consume(taken as usize);
            match decoded {
                Ok(Ok(Status::StreamEnd)) => self.has_ended = true,
                Ok(Ok(Status::MemNeeded)) => return Err(self.fail(Fault::NoMemory)),
                Ok(Ok(_)) if is_last && written == 0 => return Err(self.fail(Fault::Truncated)),
                Ok(Ok(_)) => {}
                Ok(Err(_)) | Err(_) => return Err(self.fail(Fault::Damaged)),
            }
            if written > 0 {
                return Ok(written as usize);
            }
        }
    }

    fn fail(&mut self, fault: Fault) -> io::Error {
        self.failed = Some(fault);
        fault.into()
    }
}

impl<R: BufRead> Read for Unpacker<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        match self.failed {
            Some(fault) => Err(fault.into()),
            None if out.is_empty() => Ok(0),
            None => self.unpack(out),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write as _;

    use bzip2::Compression;
    use bzip2::write::BzEncoder;

    use super::*;

    // By Python's bz2, that is, the library in C: `one`, and nothing at all.
    const ONE: [u8; 42] = [
        0x42, 0x5a, 0x68, 0x39, 0x31, 0x41, 0x59, 0x26, 0x53, 0x59, 0x78, 0x13, 0xc0, 0x82, 0x00,
        0x00, 0x01, 0xc1, 0x00, 0x00, 0x10, 0x02, 0x01, 0xa0, 0x00, 0x21, 0x9a, 0x68, 0x33, 0x4d,
        0x0c, 0xbc, 0x5d, 0xc9, 0x14, 0xe1, 0x42, 0x41, 0xe0, 0x4f, 0x02, 0x08,
    ];

    const EMPTY: [u8; 14] = *b"BZh9\x17\x72\x45\x38\x50\x90\0\0\0\0";

    const DAMAGED: &str = "damaged .bz2 file: it can't be unpacked";

    const FOLLOWED: &str = "damaged .bz2 file: behind what is packed there are other bytes";

    fn packed(text: &[u8]) -> Vec<u8> {
        let mut encoder = BzEncoder::new(Vec::new(), Compression::fast());
        encoder.write_all(text).unwrap();
        encoder.finish().unwrap()
    }

    fn unpacked(packed: &[u8]) -> Result<Vec<u8>, String> {
        let mut text = Vec::new();
        // Small pieces, so that streams end within and between them.
        let read = Unpacker::new(io::BufReader::with_capacity(7, packed)).read_to_end(&mut text);
        read.map(|_| text).map_err(|e| e.to_string())
    }

    fn text() -> Vec<u8> {
        // More than a block of the fastest level, 100 kB.
        (0..40_000_u64).flat_map(|i| format!("{},{}\n", i * i % 977, i % 13).into_bytes()).collect()
    }

    #[test]
    fn streams_follow_one_another() {
        assert_eq!(unpacked(&ONE).unwrap(), b"one\n");
        assert_eq!(unpacked(&EMPTY).unwrap(), b"");
        let all = [&ONE[..], &packed(&text()), &EMPTY, &ONE].concat();
        assert_eq!(unpacked(&all).unwrap(), [b"one\n", &text()[..], b"one\n"].concat());
    }

    #[test]
    fn a_file_that_ends_early_is_an_error() {
        let two = [ONE, ONE].concat();
        for cut in (0..two.len()).filter(|&cut| cut != ONE.len()) {
            let refused = unpacked(&two[..cut]).unwrap_err();
            assert_eq!(refused, "truncated: the file ends too early", "{cut}");
        }
        let whole = packed(&text());
        for cut in (1..whole.len()).step_by(whole.len() / 20) {
            assert!(unpacked(&whole[..cut]).unwrap_err().starts_with("truncated"), "{cut}");
        }
    }

    #[test]
    fn damage_and_what_follows_the_last_stream_are_errors() {
        for (at, bit) in (0..ONE.len()).flat_map(|at| (0..8).map(move |bit| (at, bit))) {
            let mut bytes = ONE;
            bytes[at] ^= 1 << bit;
            match unpacked(&bytes) {
                // The size of blocks, tables of what does not occur, and bits that fill the last
                // byte change nothing.
                Ok(text) => assert_eq!(text, b"one\n", "{at}, {bit}"),
                Err(e) => assert!(e == DAMAGED || e.starts_with("truncated"), "{at}: {e}"),
            }
        }
        for more in [&b"and more"[..], b"\0", b"1,2\n"] {
            assert_eq!(unpacked(&[&ONE[..], more].concat()).unwrap_err(), FOLLOWED);
        }
        assert_eq!(unpacked(&[&ONE[..], b"BZ2"].concat()).unwrap_err(), DAMAGED);
    }

    #[test]
    fn an_error_is_returned_again_and_again() {
        let bytes = [&ONE[..], b"more"].concat();
        let mut unpacker = Unpacker::new(&bytes[..]);
        assert_eq!(unpacker.read(&mut [0; 64]).unwrap(), 4);
        for _ in 0..2 {
            assert_eq!(unpacker.read(&mut [0; 64]).unwrap_err().to_string(), FOLLOWED);
        }
    }
}
