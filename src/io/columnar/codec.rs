//! Unpacks pages and buffers, by crates without C.

use std::fmt::Display;
use std::io::Read;

use lz4_flex::block::DecompressError;

use super::fault::Fault;
use crate::base::byte_size;
use crate::io::limits::LARGER_MAX_MEMORY;

/// How bytes are packed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Codec {
    Snappy,
    Gzip,
    Zstd,
    /// A block of LZ4, which does not say its size.
    Lz4Block,
    Lz4Frame,
}

/// Returns `start` with the unpacked bytes behind it, of which there are at most `most`.
pub fn unpack(codec: Codec, packed: &[u8], start: &[u8], most: usize) -> Result<Vec<u8>, Fault> {
    let mut out = start.to_vec();
    if packed.is_empty() {
        return Ok(out);
    }
    match codec {
        Codec::Snappy => {
            let size = snap::raw::decompress_len(packed).map_err(broken)?;
            let room = grow(&mut out, size, most)?;
            let found = snap::raw::Decoder::new().decompress(packed, room).map_err(broken)?;
            out.truncate(start.len() + found);
        }
        Codec::Lz4Block => {
            // Room is filled with zeros first: for usual pages the least is enough.
            let mut ratio = 4;
            loop {
                out.truncate(start.len());
                let room = grow(&mut out, most.min(packed.len().saturating_mul(ratio)), most)?;
                match lz4_flex::block::decompress_into(packed, room) {
                    Err(DecompressError::OutputTooSmall { .. }) if ratio < LZ4_RATIO => ratio *= 4,
                    found => {
                        out.truncate(start.len() + found.map_err(broken)?);
                        break;
                    }
                }
            }
        }
        Codec::Gzip => all(flate2::read::MultiGzDecoder::new(packed), &mut out, most)?,
        Codec::Lz4Frame => all(lz4_flex::frame::FrameDecoder::new(packed), &mut out, most)?,
        Codec::Zstd => {
            let decoder = ruzstd::decoding::StreamingDecoder::new(packed).map_err(broken)?;
            all(decoder, &mut out, most)?;
        }
    }
    Ok(out)
}

/// A byte of LZ4 unpacks to fewer bytes than this.
const LZ4_RATIO: usize = 256;

/// Returns room for `size` bytes at the end of `out`.
fn grow(out: &mut Vec<u8>, size: usize, most: usize) -> Result<&mut [u8], Fault> {
    let start = out.len();
    if size > most {
        return Err(too_large(size as f64));
    }
    out.try_reserve_exact(size).map_err(|_| too_large(size as f64))?;
    out.resize(start + size, 0);
    Ok(&mut out[start..])
}

/// Appends all that `reader` gives.
fn all(reader: impl Read, out: &mut Vec<u8>, most: usize) -> Result<(), Fault> {
    let found = reader.take((most as u64).saturating_add(1)).read_to_end(out).map_err(broken)?;
    if found > most { Err(too_large(found as f64)) } else { Ok(()) }
}

fn broken(e: impl Display) -> Fault {
    format!("broken packed data: {e}")
}

/// Returns the message for data that takes too much memory.
pub fn too_large(bytes: f64) -> Fault {
    let bytes = byte_size(bytes);
    format!("data of {bytes} or more, too much for a page or buffer: {LARGER_MAX_MEMORY}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_of_lz4_of_any_ratio_are_unpacked_behind_the_start() {
        let usual: Vec<u8> = (0..1000_u32).flat_map(|i| (i * i).to_le_bytes()).collect();
        for data in [usual, vec![7; 100_000]] {
            let packed = lz4_flex::block::compress(&data);
            let found = unpack(Codec::Lz4Block, &packed, &[1, 2], 1 << 20).unwrap();
            assert!(found[..2] == [1, 2] && found[2..] == data);
            assert!(unpack(Codec::Lz4Block, &packed, &[], data.len() - 1).is_err());
        }
    }
}
