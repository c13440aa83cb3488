//! `.zst` through crate ruzstd, a frame after the other.

use std::hash::Hasher;
use std::io::{self, BufRead, Read};
use std::panic::{AssertUnwindSafe, catch_unwind};

use ruzstd::decoding::errors::{FrameDecoderError, ReadFrameHeaderError};
use ruzstd::decoding::{BlockDecodingStrategy, DEFAULT_MAX_WINDOW_SIZE, FrameDecoder};
use twox_hash::XxHash64;

use super::limits::LARGER_MAX_MEMORY;
use super::packing::{damaged, followed, truncated};
use crate::base::byte_size;

/// A file being unpacked.
pub(super) struct Unpacker<R> {
    packed: Packed<R>,
    decoder: FrameDecoder,
    /// Checksum of what the frame has unpacked to.
    check: XxHash64,
    /// Bytes that the frame has unpacked to.
    found: u64,
    has_failed: bool,
}

impl<R: BufRead> Unpacker<R> {
    /// Creates an unpacker of a packed file at its start, which may take `memory` bytes.
    pub(super) fn new(packed: R, memory: u64) -> Self {
        let mut decoder = FrameDecoder::new();
        decoder.set_max_window_size(memory.min(DEFAULT_MAX_WINDOW_SIZE));
        let packed = Packed { inner: packed, has_ended: false, failed: None };
        Self { packed, decoder, check: XxHash64::default(), found: 0, has_failed: false }
    }

    fn unpack(&mut self, out: &mut [u8]) -> io::Result<usize> {
        loop {
            if self.decoder.can_collect() > 0 {
                let count = self.decoder.read(out)?;
                self.check.write(&out[..count]);
                self.found += count as u64;
                return Ok(count);
            }
            let Self { packed, decoder, .. } = &mut *self;
            if !decoder.is_finished() {
                let one = BlockDecodingStrategy::UptoBlocks(1);
                // The crate may panic on unexpected input.
                let decoded = catch_unwind(AssertUnwindSafe(|| decoder.decode_blocks(packed, one)));
                if !matches!(decoded, Ok(Ok(_))) {
                    return Err(self.fault());
                }
                continue;
            }
            // The low half of the hash is stored.
            let expected = decoder.get_checksum_from_data();
            let is_other = expected.is_some_and(|check| check != self.check.finish() as u32);
            // A frame without a size has 0.
            if is_other || ![0, self.found].contains(&self.decoder.content_size()) {
                return Err(damaged(".zst"));
            }
            if !self.begin_next()? {
                return Ok(0);
            }
        }
    }

    /// Begins the next frame, or skips one without content. Returns whether there was one.
    fn begin_next(&mut self) -> io::Result<bool> {
        let Self { packed, decoder, .. } = &mut *self;
        match packed.inner.fill_buf()?.first() {
            None => return Ok(false),
            // A frame, or one that is skipped.
            Some(0x28 | 0x50..=0x5f) => {}
            Some(_) => return Err(followed(".zst")),
        }
        let begun = catch_unwind(AssertUnwindSafe(|| decoder.reset(&mut *packed)));
        match begun {
            Ok(Ok(())) => (self.check, self.found) = (XxHash64::default(), 0),
            Ok(Err(FrameDecoderError::ReadFrameHeaderError(ReadFrameHeaderError::SkipFrame {
                length,
                ..
            }))) => {
                let length = u64::from(length);
                let skipped = io::copy(&mut (&mut packed.inner).take(length), &mut io::sink())?;
                if skipped < length {
                    return Err(truncated());
                }
            }
            Ok(Err(FrameDecoderError::WindowSizeTooBig { max, .. })) => {
                let is_default = max == DEFAULT_MAX_WINDOW_SIZE;
                let how = if is_default { "zstd -19 needs less" } else { LARGER_MAX_MEMORY };
                let max = byte_size(max as f64);
                let what = format!("needs a window of more than {max} of memory: {how}");
                return Err(io::Error::other(what));
            }
            Ok(Err(FrameDecoderError::DictNotProvided { .. })) => {
                return Err(io::Error::other(
                    "is packed with a dictionary, which is not supported",
                ));
            }
            _ => return Err(self.fault()),
        }
        Ok(true)
    }

    /// Returns why the decoder failed: a failed read, the end of the file, or its content.
    fn fault(&mut self) -> io::Error {
        match self.packed.failed.take() {
            Some(e) => e,
            None if self.packed.has_ended => truncated(),
            None => damaged(".zst"),
        }
    }
}

impl<R: BufRead> Read for Unpacker<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        if self.has_failed {
            return Err(damaged(".zst"));
        }
        if out.is_empty() {
            return Ok(0);
        }
        let count = self.unpack(out);
        let fails = |e: &io::Error| e.kind() != io::ErrorKind::Interrupted;
        self.has_failed = count.as_ref().is_err_and(fails);
        count
    }
}

/// What is read of the packed file, whose errors the decoder hides in its own.
struct Packed<R> {
    inner: R,
    has_ended: bool,
    failed: Option<io::Error>,
}

impl<R: Read> Read for Packed<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        match self.inner.read(out) {
            Ok(count) => {
                self.has_ended |= count == 0 && !out.is_empty();
                Ok(count)
            }
            Err(e) if e.kind() == io::ErrorKind::Interrupted => Err(e),
            Err(e) => {
                let kind = e.kind();
                self.failed = Some(e);
                Err(kind.into())
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use ruzstd::encoding::{CompressionLevel, compress_to_vec};

    use super::*;

    /// Returns a frame with a check, which the encoder leaves out.
    fn packed(text: &str) -> Vec<u8> {
        let mut frame = compress_to_vec(text.as_bytes(), CompressionLevel::Fastest);
        // The bit of the descriptor behind the magic that announces the check.
        frame[4] |= 4;
        let mut check = XxHash64::default();
        check.write(text.as_bytes());
        frame.extend((check.finish() as u32).to_le_bytes());
        frame
    }

    fn unpacked(packed: &[u8]) -> Result<String, String> {
        let mut text = String::new();
        let mut unpacker = Unpacker::new(packed, u64::MAX);
        unpacker.read_to_string(&mut text).map(|_| text).map_err(|e| e.to_string())
    }

    fn text() -> String {
        (0..30_000).map(|i| format!("{},{}\n", i * i % 977, i % 13)).collect()
    }

    #[test]
    fn frames_follow_one_another_also_skipped_ones() {
        let skipped = b"\x53\x2a\x4d\x18\x03\0\0\0abc";
        let all = [&skipped[..], &packed(&text())[..], skipped, &packed("two\n")[..]].concat();
        assert_eq!(unpacked(&all).unwrap(), text() + "two\n");
        assert!(unpacked(&[&all[..], &skipped[..9]].concat()).unwrap_err().contains("truncated"));
        let refused = |more: &[u8]| unpacked(&[&all[..], more].concat()).unwrap_err();
        assert_eq!(refused(b"(more than a header"), DAMAGED);
        for more in [&b"x"[..], b"and more"] {
            let expected = "damaged .zst file: behind what is packed there are other bytes";
            assert_eq!(refused(more), expected);
        }
    }

    const DAMAGED: &str = "damaged .zst file: it can't be unpacked";

    #[test]
    fn a_file_that_ends_early_is_an_error() {
        let whole = packed(&text());
        for cut in (1..whole.len()).step_by(whole.len() / 200 + 1) {
            let refused = unpacked(&whole[..cut]).unwrap_err();
            assert_eq!(refused, "truncated: the file ends too early", "{cut}");
        }
    }

    #[test]
    fn damage_is_found() {
        let whole = packed(&text());
        // Behind the header, which has bits without a meaning.
        for at in (16..whole.len()).step_by(whole.len() / 200 + 1) {
            let mut bytes = whole.clone();
            bytes[at] ^= 0x10;
            let refused = unpacked(&bytes).unwrap_err();
            assert!(refused == DAMAGED || refused.starts_with("truncated"), "{at}: {refused}");
        }
    }

    #[test]
    fn a_frame_without_a_check_has_the_size_that_it_says() {
        // Three bytes as they are; the byte before the block is their number.
        let mut frame = *b"\x28\xb5\x2f\xfd\x20\x03\x19\0\0abc";
        assert_eq!(unpacked(&[frame, frame].concat()).unwrap(), "abcabc");
        for size in [2, 4] {
            frame[5] = size;
            assert_eq!(unpacked(&frame).unwrap_err(), DAMAGED, "{size}");
        }
    }

    #[test]
    fn a_window_larger_than_the_memory_is_refused_before_it_is_allocated() {
        // A window of 2^41 bytes.
        let large = b"\x28\xb5\x2f\xfd\x00\xf8\x01\0\0";
        assert!(unpacked(large).unwrap_err().contains("needs a window of more than"));
        let usual = packed(&text());
        let refused = Unpacker::new(&usual[..], 1 << 10).read(&mut [0]).unwrap_err().to_string();
        assert!(refused.ends_with(LARGER_MAX_MEMORY), "{refused}");
    }
}
