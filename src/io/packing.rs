//! How a file is packed, and what is said about packed files that can't be read.

use std::fmt;
use std::io;

/// How a file is packed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Packing {
    /// As it is.
    None,
    /// By gzip.
    Gzip,
    /// By xz.
    Xz,
    /// By bzip2.
    Bzip2,
    /// By zstd (feature `columnar`).
    Zstd,
    /// The only file of a zip archive.
    Zip,
}

/// How packed files begin, what their names end in, and what packs them.
const PACKED: [(Packing, &[u8], &str, &str); 5] = [
    (Packing::Gzip, b"\x1f\x8b", ".gz", "gzip"),
    (Packing::Xz, b"\xfd7zXZ\0", ".xz", "xz"),
    // Text may begin so, too: see `is_bzip2`.
    (Packing::Bzip2, b"BZh", ".bz2", "bzip2"),
    (Packing::Zstd, b"\x28\xb5\x2f\xfd", ".zst", "zstd"),
    (Packing::Zip, b"PK\x03\x04", ".zip", "zip"),
];

/// Packers that are not supported: where their files have which bytes.
const OTHERS: [(usize, &[u8], &str); 4] = [
    (0, b"7z\xbc\xaf\x27\x1c", "7-Zip (.7z)"),
    (0, b"\x04\x22\x4d\x18", "LZ4 (.lz4)"),
    (0, b"\x1f\x9d", "compress (.Z)"),
    (0, b"\x5d\0\0", "LZMA (.lzma)"),
];

impl Packing {
    /// Returns the file name (in lower case) without the ending of a packed file, and the packing.
    #[doc(hidden)]
    pub fn of(name: &str) -> (&str, Self) {
        let stem = |&(packing, _, ending, _): &(Self, &[u8], &str, &str)| {
            Some((name.strip_suffix(ending)?, packing))
        };
        PACKED.iter().find_map(stem).unwrap_or((name, Self::None))
    }

    /// Returns the packing of a file that begins with these bytes.
    #[doc(hidden)]
    pub fn of_content(head: &[u8]) -> Self {
        let begins = |(packing, magic, ..): &&(Self, &[u8], &str, &str)| {
            head.starts_with(magic) && (*packing != Self::Bzip2 || is_bzip2(head))
        };
        match PACKED.iter().find(begins) {
            Some(&(packing, ..)) => packing,
            // A frame of zstd that is skipped.
            None if matches!(head, [0x50..=0x5f, 0x2a, 0x4d, 0x18, ..]) => Self::Zstd,
            None => Self::None,
        }
    }

    /// Returns the packing of a file that begins with these bytes, or else this one, which its name
    /// ends in.
    pub(super) fn or_of_content(self, head: &[u8]) -> Self {
        match Self::of_content(head) {
            Self::None => self,
            found => found,
        }
    }

    /// Refuses the first bytes of a file that is not packed so: packed by another program, or not
    /// packed at all.
    pub(super) fn check(self, head: &[u8]) -> io::Result<()> {
        let is_other = |(at, magic, _): &&(usize, &[u8], &str)| {
            head.get(*at..).is_some_and(|head| head.starts_with(magic))
        };
        if let Some((.., packer)) = OTHERS.iter().find(is_other) {
            let zstd = if cfg!(feature = "columnar") { ", .zst" } else { "" };
            return Err(io::Error::other(format!(
                "is packed by {packer}, which is not supported: .gz, .xz, .bz2{zstd} and .zip are; \
                 or unpack it first"
            )));
        }
        if self == Self::Zstd && cfg!(not(feature = "columnar")) {
            let what = "is packed by zstd, which is not part of this program: build it with \
                        --features columnar";
            return Err(io::Error::other(what));
        }
        let Some((_, magic, ending, _)) = self.named() else { return Ok(()) };
        // The readers say that a file is truncated.
        let is_cut = magic.starts_with(head) || self == Self::Bzip2 && is_start_of_bzip2(head);
        if Self::of_content(head) == self || is_cut {
            return Ok(());
        }
        Err(io::Error::other(format!("is not a {ending} file: damaged, or not packed")))
    }

    /// Returns what the name of a file that is packed so ends in.
    #[doc(hidden)]
    pub fn ending(self) -> &'static str {
        self.named().map_or("", |(_, _, ending, _)| *ending)
    }

    fn named(self) -> Option<&'static (Self, &'static [u8], &'static str, &'static str)> {
        PACKED.iter().find(|(packing, ..)| *packing == self)
    }
}

/// What follows the size of blocks in a stream of bzip2: a block, or the end of an empty stream.
const BZIP2: [&[u8; 6]; 2] = [b"1AY&SY", b"\x17\x72\x45\x38\x50\x90"];

/// Bytes of a stream of bzip2 before its first block.
const BZIP2_HEADER: usize = 4;

/// Returns whether a file that begins with these bytes is packed by bzip2.
fn is_bzip2(head: &[u8]) -> bool {
    head.len() >= BZIP2_HEADER + BZIP2[0].len() && is_start_of_bzip2(head)
}

/// Returns whether these bytes, of which there may be few, begin a stream of bzip2.
fn is_start_of_bzip2(head: &[u8]) -> bool {
    let (header, rest) = head.split_at(head.len().min(BZIP2_HEADER));
    let is_header = match header {
        [b'B', b'Z', b'h', size] => matches!(size, b'1'..=b'9'),
        header => b"BZh".starts_with(header),
    };
    let rest = &rest[..rest.len().min(BZIP2[0].len())];
    is_header && BZIP2.iter().any(|magic| magic.starts_with(rest))
}

impl fmt::Display for Packing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.named() {
            None => f.write_str("not packed"),
            Some((.., packer)) => write!(f, "packed by {packer}"),
        }
    }
}

/// Returns the error of a file that ends before its content does.
pub(super) fn truncated() -> io::Error {
    io::Error::new(io::ErrorKind::UnexpectedEof, TRUNCATED)
}

/// What is said of a file that ends too early.
pub(super) const TRUNCATED: &str = "truncated: the file ends too early";

/// Returns the error of a file that is damaged, of the kind that its name ends in.
pub(super) fn damaged(ending: &str) -> io::Error {
    io::Error::other(format!("damaged {ending} file: it can't be unpacked"))
}

/// Returns the error of a file in which other bytes follow what is packed.
pub(super) fn followed(ending: &str) -> io::Error {
    let what = format!("damaged {ending} file: behind what is packed there are other bytes");
    io::Error::other(what)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_is_packed_otherwise_is_refused_by_the_name_of_its_packer() {
        let refused = |packing: Packing, head: &[u8]| packing.check(head).unwrap_err().to_string();
        for packing in [Packing::None, Packing::Gzip, Packing::Zip] {
            let lz4 = refused(packing, b"\x04\x22\x4d\x18\x60");
            assert!(lz4.contains("packed by LZ4 (.lz4), which is not"), "{lz4}");
            assert_eq!(lz4.contains(".zst"), cfg!(feature = "columnar"), "{lz4}");
        }
        let lzma = refused(Packing::None, b"\x5d\0\0\x80\0\xff");
        assert!(lzma.contains("packed by LZMA (.lzma), which is not"), "{lzma}");
        for text in [&b"BZh,1AY\n"[..], b"BZh01AY&SY", b"BZh91AY&SX", b"BZh9,2\n"] {
            let refused = refused(Packing::Bzip2, text);
            assert_eq!(refused, "is not a .bz2 file: damaged, or not packed");
        }
        let plain = refused(Packing::Gzip, b"1,2\n3,4\n");
        assert_eq!(plain, "is not a .gz file: damaged, or not packed");
        for (packing, head) in [
            (Packing::None, &b"1,2\n"[..]),
            (Packing::None, b""),
            (Packing::Gzip, b"\x1f\x8b\x08"),
            (Packing::Gzip, b""),
            (Packing::Xz, b"\xfd7zX"),
            #[cfg(feature = "columnar")]
            (Packing::Zstd, b"\x5e\x2a\x4d\x18\x04\0\0\0"),
            (Packing::Zip, b"PK"),
            (Packing::Bzip2, b""),
            (Packing::Bzip2, b"BZh9"),
            (Packing::Bzip2, b"BZh91AY&S"),
            // Text that only begins as a packed file does.
            (Packing::None, b"BZh9,1AY&SY\n"),
        ] {
            assert!(packing.check(head).is_ok(), "{packing:?} {head:?}");
        }
    }

    #[test]
    fn content_decides_before_the_name() {
        assert_eq!(Packing::Gzip.or_of_content(b"\x28\xb5\x2f\xfd\x04\x58"), Packing::Zstd);
        assert_eq!(Packing::None.or_of_content(b"PK\x03\x04\x14\0"), Packing::Zip);
        assert_eq!(Packing::Gzip.or_of_content(b"1,2\n"), Packing::Gzip);
        assert_eq!(Packing::of("a.csv.zst"), ("a.csv", Packing::Zstd));
        for head in [b"BZh11AY&SY", b"BZh9\x17\x72\x45\x38\x50\x90"] {
            assert_eq!(Packing::Gzip.or_of_content(head), Packing::Bzip2);
        }
        for text in [&b"BZh 1 2 3\n"[..], b"BZh91AY&S", b"BZh01AY&SY", b"BZh9,1AY&SY"] {
            assert_eq!(Packing::of_content(text), Packing::None, "{text:?}");
        }
        assert_eq!(Packing::of("a.csv.bz2"), ("a.csv", Packing::Bzip2));
        assert_eq!(Packing::Zip.to_string(), "packed by zip");
    }
}
