//! How a file is packed, and what is said about packed files that can't be read.

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
}

/// Packers that are not supported: where their files have which bytes.
const OTHERS: [(usize, &[u8], &str); 6] = [
    (0, b"\x28\xb5\x2f\xfd", "zstd (.zst)"),
    // Of the first block: text may begin like the file itself.
    (4, b"1AY&SY", "bzip2 (.bz2)"),
    (0, b"PK\x03\x04", "zip (.zip)"),
    (0, b"7z\xbc\xaf\x27\x1c", "7-Zip (.7z)"),
    (0, b"\x04\x22\x4d\x18", "LZ4 (.lz4)"),
    (0, b"\x1f\x9d", "compress (.Z)"),
];

impl Packing {
    /// Returns the file name (in lower case) without the ending of a packed file, and the packing.
    #[doc(hidden)]
    pub fn of(name: &str) -> (&str, Self) {
        if let Some(stem) = name.strip_suffix(".gz") {
            (stem, Self::Gzip)
        } else if let Some(stem) = name.strip_suffix(".xz") {
            (stem, Self::Xz)
        } else {
            (name, Self::None)
        }
    }

    /// Returns the packing of a file that begins with these bytes.
    pub(super) fn of_content(head: &[u8]) -> Self {
        match head {
            [0x1f, 0x8b, ..] => Self::Gzip,
            [0xfd, b'7', b'z', b'X', b'Z', 0, ..] => Self::Xz,
            _ => Self::None,
        }
    }

    /// Refuses the first bytes of a file that is not packed so: packed by another program, or not
    /// packed at all.
    pub(super) fn check(self, head: &[u8]) -> io::Result<()> {
        let is_other = |(at, magic, _): &&(usize, &[u8], &str)| {
            head.get(*at..).is_some_and(|head| head.starts_with(magic))
        };
        if let Some((.., packer)) = OTHERS.iter().find(is_other) {
            return Err(io::Error::other(format!(
                "is packed by {packer}, which is not supported: .gz and .xz are; or unpack it first"
            )));
        }
        let (magic, ending): (&[u8], _) = match self {
            Self::None => return Ok(()),
            Self::Gzip => (b"\x1f\x8b", ".gz"),
            Self::Xz => (b"\xfd7zXZ\0", ".xz"),
        };
        // The readers say that a file is truncated.
        if head.starts_with(magic) || magic.starts_with(head) {
            return Ok(());
        }
        Err(io::Error::other(format!("is not a {ending} file: damaged, or not packed")))
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_is_packed_otherwise_is_refused_by_the_name_of_its_packer() {
        let refused = |packing: Packing, head: &[u8]| packing.check(head).unwrap_err().to_string();
        for packing in [Packing::None, Packing::Gzip, Packing::Xz] {
            let zstd = refused(packing, b"\x28\xb5\x2f\xfd\x04\x58");
            assert!(zstd.contains("packed by zstd (.zst), which is not supported"), "{zstd}");
            let zip = refused(packing, b"PK\x03\x04\x14\0");
            assert!(zip.contains("packed by zip (.zip), which is not supported"), "{zip}");
            let bzip2 = refused(packing, b"BZh91AY&SY\x94");
            assert!(bzip2.contains("packed by bzip2 (.bz2), which is not"), "{bzip2}");
        }
        // Text that only begins in the same way.
        assert!(Packing::None.check(b"BZh 1 2 3\n").is_ok());
        let plain = refused(Packing::Gzip, b"1,2\n3,4\n");
        assert_eq!(plain, "is not a .gz file: damaged, or not packed");
        for (packing, head) in [
            (Packing::None, &b"1,2\n"[..]),
            (Packing::None, b""),
            (Packing::Gzip, b"\x1f\x8b\x08"),
            (Packing::Gzip, b""),
            (Packing::Xz, b"\xfd7zX"),
        ] {
            assert!(packing.check(head).is_ok(), "{packing:?} {head:?}");
        }
    }
}
