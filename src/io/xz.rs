//! `.xz` through crate xz4rust, a stream after the other.

use std::io::{self, BufRead, Read};
use std::panic::{AssertUnwindSafe, catch_unwind};

use xz4rust::{XzDecoder, XzError};

use super::packing::{damaged, followed, truncated};

/// The byte with which a stream begins.
const START: u8 = 0xfd;

/// The largest dictionary that a file may need, in bytes: 256 MiB. `xz -9` takes 64 MiB.
const LARGEST_DICTIONARY: usize = 1 << 28;

/// The dictionary that is allocated before a file asks for one, in bytes.
const FIRST_DICTIONARY: usize = 1 << 12;

/// Returns a reader of what bytes packed by xz unpack to.
#[doc(hidden)]
pub fn unxz(packed: &[u8]) -> impl Read {
    Unpacker::new(packed)
}

/// A file being unpacked.
pub(super) struct Unpacker<R> {
    packed: R,
    decoder: Box<XzDecoder<'static>>,
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
    /// Other bytes follow the last stream.
    Followed,
    /// It needs what is not supported.
    Unsupported(&'static str),
}

impl From<Fault> for io::Error {
    fn from(fault: Fault) -> Self {
        match fault {
            Fault::Truncated => truncated(),
            Fault::Damaged => damaged(".xz"),
            Fault::Followed => followed(".xz"),
            Fault::Unsupported(what) => Self::other(what),
        }
    }
}

impl<R: BufRead> Unpacker<R> {
    /// Creates an unpacker of a packed file at its start.
    pub(super) fn new(packed: R) -> Self {
        let decoder = XzDecoder::in_heap_with_alloc_dict_size(FIRST_DICTIONARY, LARGEST_DICTIONARY);
        Self { packed, decoder, has_ended: false, failed: None }
    }

    fn unpack(&mut self, out: &mut [u8]) -> io::Result<usize> {
        loop {
            if self.has_ended && !self.begin_next()? {
                return Ok(0);
            }
            let packed = self.packed.fill_buf()?;
            if packed.is_empty() {
                return Err(self.fail(Fault::Truncated));
            }
            // The crate is safe code, which may panic on unexpected input.
            let decoded = catch_unwind(AssertUnwindSafe(|| self.decoder.decode(packed, out)));
            let result = match decoded {
                Ok(Ok(result)) => result,
                Ok(Err(e)) => return Err(self.fail(fault(&e))),
                Err(_) => return Err(self.fail(Fault::Damaged)),
            };
            self.packed.consume(result.input_consumed());
            self.has_ended = result.is_end_of_stream();
            if result.output_produced() > 0 {
                return Ok(result.output_produced());
            }
        }
    }

    /// Skips the zeros behind a stream, a multiple of four. Returns whether another stream follows.
    fn begin_next(&mut self) -> io::Result<bool> {
        let mut zeros = 0_usize;
        loop {
            let packed = self.packed.fill_buf()?;
            let length = packed.len();
            let skipped = packed.iter().take_while(|&&byte| byte == 0).count();
            let begins = packed.get(skipped).is_none_or(|&byte| byte == START);
            self.packed.consume(skipped);
            zeros += skipped;
            if skipped == length && length > 0 {
                continue;
            }
            if !begins {
                return Err(self.fail(Fault::Followed));
            }
            if !zeros.is_multiple_of(4) {
                return Err(self.fail(Fault::Damaged));
            }
            if length == 0 {
                return Ok(false);
            }
            self.decoder.reset();
            self.has_ended = false;
            return Ok(true);
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

/// Returns what an error of the decoder means.
fn fault(e: &XzError) -> Fault {
    match e {
        // Code 40 stands for 4 GiB less a byte, the largest dictionary of the format.
        XzError::DictionaryTooLarge(_) | XzError::UnsupportedLzmaProperties(40) => {
            Fault::Unsupported(
                "needs a dictionary of more than 256 MiB, which is not supported; xz -9 needs less",
            )
        }
        XzError::Sha256NotSupported => Fault::Unsupported(
            "has checks by SHA-256, which are not supported; xz --check=crc64 writes others",
        ),
        XzError::UnsupportedStreamHeaderOption
        | XzError::UnsupportedBlockHeaderOption
        | XzError::UnsupportedCheckType(_)
        | XzError::UnsupportedBcjFilter(_) => Fault::Unsupported(
            "uses a part of .xz that is not supported, or is damaged; xz without options uses none",
        ),
        _ => Fault::Damaged,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // By Python's lzma: `one` with CRC64, `two` with CRC32, `one` with SHA-256.
    const ONE: [u8; 60] = [
        0xfd, 0x37, 0x7a, 0x58, 0x5a, 0x00, 0x00, 0x04, 0xe6, 0xd6, 0xb4, 0x46, 0x02, 0x00, 0x21,
        0x01, 0x16, 0x00, 0x00, 0x00, 0x74, 0x2f, 0xe5, 0xa3, 0x01, 0x00, 0x03, 0x6f, 0x6e, 0x65,
        0x0a, 0x00, 0xf5, 0x5c, 0xbb, 0x56, 0x1f, 0xc6, 0xfd, 0x86, 0x00, 0x01, 0x1c, 0x04, 0x6f,
        0x2c, 0x9c, 0xc1, 0x1f, 0xb6, 0xf3, 0x7d, 0x01, 0x00, 0x00, 0x00, 0x00, 0x04, 0x59, 0x5a,
    ];

    const TWO: [u8; 56] = [
        0xfd, 0x37, 0x7a, 0x58, 0x5a, 0x00, 0x00, 0x01, 0x69, 0x22, 0xde, 0x36, 0x02, 0x00, 0x21,
        0x01, 0x16, 0x00, 0x00, 0x00, 0x74, 0x2f, 0xe5, 0xa3, 0x01, 0x00, 0x03, 0x74, 0x77, 0x6f,
        0x0a, 0x00, 0x74, 0x08, 0x17, 0x96, 0x00, 0x01, 0x18, 0x04, 0x6b, 0xe9, 0xf0, 0xa5, 0x90,
        0x42, 0x99, 0x0d, 0x01, 0x00, 0x00, 0x00, 0x00, 0x01, 0x59, 0x5a,
    ];

    const WITH_SHA256: [u8; 84] = [
        0xfd, 0x37, 0x7a, 0x58, 0x5a, 0x00, 0x00, 0x0a, 0xe1, 0xfb, 0x0c, 0xa1, 0x02, 0x00, 0x21,
        0x01, 0x16, 0x00, 0x00, 0x00, 0x74, 0x2f, 0xe5, 0xa3, 0x01, 0x00, 0x03, 0x6f, 0x6e, 0x65,
        0x0a, 0x00, 0x2c, 0x8b, 0x08, 0xda, 0x5c, 0xe6, 0x03, 0x98, 0xe1, 0xf1, 0x9a, 0xf0, 0xe5,
        0xdc, 0xcc, 0x74, 0x4d, 0xf2, 0x74, 0xb8, 0x26, 0xab, 0xe5, 0x85, 0xea, 0xba, 0x68, 0xc5,
        0x25, 0x43, 0x48, 0x06, 0x00, 0x01, 0x34, 0x04, 0xc5, 0x82, 0xc1, 0x9c, 0x18, 0x9b, 0x4b,
        0x9a, 0x01, 0x00, 0x00, 0x00, 0x00, 0x0a, 0x59, 0x5a,
    ];

    fn unpacked(packed: &[u8]) -> io::Result<String> {
        let mut text = String::new();
        Unpacker::new(packed).read_to_string(&mut text).map(|_| text)
    }

    #[test]
    fn streams_follow_one_another_with_zeros_between_them() {
        assert_eq!(unpacked(&ONE).unwrap(), "one\n");
        for zeros in 0..9_usize {
            let packed = [&ONE[..], &[0; 8][..zeros], &TWO].concat();
            match zeros.is_multiple_of(4) {
                true => assert_eq!(unpacked(&packed).unwrap(), "one\ntwo\n", "{zeros}"),
                false => assert!(unpacked(&packed).is_err(), "{zeros}"),
            }
            let packed = [&ONE[..], &[0; 8][..zeros]].concat();
            assert_eq!(unpacked(&packed).is_ok(), zeros.is_multiple_of(4), "{zeros}");
        }
    }

    #[test]
    fn bytes_behind_the_last_stream_are_no_truncated_one() {
        let expected = "damaged .xz file: behind what is packed there are other bytes";
        for more in [&b"x"[..], b"more than a header has", b"\0\0\0\0x"] {
            let refused = unpacked(&[&ONE[..], more].concat()).unwrap_err().to_string();
            assert_eq!(refused, expected, "{more:?}");
        }
        let refused = unpacked(&[&ONE[..], &TWO[..9]].concat()).unwrap_err().to_string();
        assert_eq!(refused, "truncated: the file ends too early");
    }

    #[test]
    fn a_file_that_ends_early_is_an_error() {
        for cut in 0..ONE.len() {
            let refused = unpacked(&ONE[..cut]).unwrap_err().to_string();
            assert_eq!(refused, "truncated: the file ends too early", "{cut}");
        }
    }

    #[test]
    fn damage_is_named_without_the_words_of_the_decoder() {
        for at in 0..ONE.len() {
            for bit in 0..8 {
                let mut packed = ONE;
                packed[at] ^= 1 << bit;
                let Err(refused) = unpacked(&packed) else { continue };
                let refused = refused.to_string();
                let known = [
                    "truncated: the",
                    "damaged .xz file: it",
                    "needs a dict",
                    "has checks",
                    "uses a",
                ];
                assert!(known.iter().any(|known| refused.starts_with(known)), "{at}: {refused}");
            }
        }
    }

    #[test]
    fn a_dictionary_of_more_than_256_mib_is_refused_by_name() {
        // The sizes that block headers have a code for: 32 is 256 MiB, 40 the largest.
        let large = Some("256 MiB");
        for (code, why) in
            [(32, None), (33, large), (39, large), (40, large), (41, Some("damaged .xz file"))]
        {
            let mut packed = ONE;
            packed[16] = code;
            let check = crc32fast::hash(&packed[12..20]).to_le_bytes();
            packed[20..24].copy_from_slice(&check);
            match (unpacked(&packed), why) {
                (Ok(text), None) => assert_eq!(text, "one\n"),
                (Err(refused), Some(why)) => {
                    assert!(refused.to_string().contains(why), "{code}: {refused}");
                }
                (found, _) => panic!("{code}: {found:?}"),
            }
        }
    }

    #[test]
    fn a_check_by_sha256_is_refused_by_name_again_and_again() {
        let mut unpacker = Unpacker::new(&WITH_SHA256[..]);
        for _ in 0..2 {
            let refused = unpacker.read(&mut [0; 8]).unwrap_err().to_string();
            assert!(refused.contains("SHA-256"), "{refused}");
        }
    }
}
