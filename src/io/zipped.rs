//! The only file of a `.zip` as a stream. Crate zip finds where it is in the archive.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};
use std::path::Path;

use flate2::bufread::DeflateDecoder;
use zip::result::ZipError;
use zip::{CompressionMethod, ZipArchive};

use super::columns::listed;
use super::gzip;
use super::packing::damaged;

/// A file being unpacked.
pub(super) struct Unpacker<'a> {
    inner: Box<dyn Read + 'a>,
    member: Member,
    found: u64,
    check: crc32fast::Hasher,
}

/// Where a file is in an archive, and what it unpacks to.
struct Member {
    /// Bytes before it.
    start: u64,
    packed: u64,
    is_deflated: bool,
    size: u64,
    check: u32,
}

impl<'a> Unpacker<'a> {
    /// Opens the file of the archive at `path`, which `archive` reads from its start.
    ///
    /// # Errors
    /// An archive that is damaged or in a pipe, or does not have one file; a file that is encrypted
    /// or packed by another method than deflate.
    pub(super) fn open(path: &Path, mut archive: impl BufRead + 'a) -> io::Result<Self> {
        let member = Member::find(path)?;
        io::copy(&mut (&mut archive).take(member.start), &mut io::sink())?;
        let packed = archive.take(member.packed);
        let inner: Box<dyn Read + 'a> = match member.is_deflated {
            true => Box::new(DeflateDecoder::new(packed)),
            false => Box::new(packed),
        };
        Ok(Self { inner, member, found: 0, check: crc32fast::Hasher::new() })
    }
}

impl Member {
    fn find(path: &Path) -> io::Result<Self> {
        let fail = |what: &str| io::Error::other(what);
        let broken = |e: ZipError| io::Error::other(format!("damaged .zip file: {e}"));
        if !path.is_file() {
            let what = "a zip archive in a pipe, which has the list of its files at its end: give \
                        the file";
            return Err(fail(what));
        }
        let file = File::open(path)?;
        let mut archive = ZipArchive::new(BufReader::new(file)).map_err(broken)?;
        let mut found = Vec::new();
        for (number, name) in archive.file_names().enumerate() {
            let name = name.map_err(broken)?;
            // Folders, and what macOS knows about each file, are no content.
            if !name.ends_with('/') && !name.starts_with("__MACOSX/") {
                found.push((number, name.into_owned()));
            }
        }
        let number = match &found[..] {
            [(number, _)] => *number,
            [] => return Err(fail("a zip archive without a file")),
            several if several.iter().any(|(_, name)| name.starts_with("xl/")) => {
                return Err(fail("an Excel workbook (.xlsx): save a sheet as CSV"));
            }
            several if several.iter().any(|(_, name)| name == "content.xml") => {
                return Err(fail("a file of OpenDocument (.ods): save a sheet as CSV"));
            }
            several => {
                let (count, names) = (several.len(), several.iter().map(|(_, name)| name));
                let names = listed(&names.collect::<Vec<_>>());
                let what = format!("a zip archive of {count} files, not of one: {names}");
                return Err(fail(&format!("{what}; unpack it first")));
            }
        };
        let entry = archive.by_index_raw(number).map_err(broken)?;
        let is_deflated = match entry.compression() {
            _ if entry.encrypted() => return Err(fail("an encrypted zip archive")),
            CompressionMethod::Stored => false,
            CompressionMethod::Deflated => true,
            other => {
                let what = "a zip archive whose file is packed by";
                return Err(fail(&format!("{what} {other}, which is not read; deflate is")));
            }
        };
        let start = entry.data_start().ok_or_else(|| damaged(".zip"))?;
        let (packed, size, check) = (entry.compressed_size(), entry.size(), entry.crc32());
        Ok(Self { start, packed, is_deflated, size, check })
    }
}

impl Read for Unpacker<'_> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        if out.is_empty() {
            return Ok(0);
        }
        let count = self.inner.read(out).map_err(|e| gzip::plain(e, ".zip"))?;
        self.check.update(&out[..count]);
        self.found += count as u64;
        let found = (self.found, self.check.clone().finalize());
        match count == 0 && found != (self.member.size, self.member.check) {
            true => Err(damaged(".zip")),
            false => Ok(count),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write as _;
    use std::path::PathBuf;

    use zip::ZipWriter;
    use zip::write::SimpleFileOptions;

    use super::*;

    const TEXT: &str = "1,2\n3,4\n";

    fn archive(folder: &Path, names: &[&str], method: CompressionMethod) -> PathBuf {
        let path = folder.join("a.zip");
        let mut zip = ZipWriter::new(File::create(&path).unwrap());
        let options = SimpleFileOptions::default().compression_method(method);
        for name in names {
            match name.strip_suffix('/') {
                Some(name) => zip.add_directory(name, options).unwrap(),
                None => {
                    zip.start_file(*name, options).unwrap();
                    zip.write_all(TEXT.repeat(1000).as_bytes()).unwrap();
                }
            }
        }
        zip.finish().unwrap();
        path
    }

    fn unpacked(path: &Path) -> Result<String, String> {
        let file = BufReader::new(File::open(path).unwrap());
        let mut text = String::new();
        let mut unpacker = Unpacker::open(path, file).map_err(|e| e.to_string())?;
        unpacker.read_to_string(&mut text).map(|_| text).map_err(|e| e.to_string())
    }

    #[test]
    fn the_only_file_of_an_archive_is_read_by_either_method() {
        let folder = tempfile::tempdir().unwrap();
        for method in [CompressionMethod::Stored, CompressionMethod::Deflated] {
            for names in [&["a.csv"][..], &["b/", "__MACOSX/b/._a.csv", "b/a.csv"]] {
                let path = archive(folder.path(), names, method);
                assert_eq!(unpacked(&path).unwrap(), TEXT.repeat(1000), "{names:?}");
            }
        }
    }

    #[test]
    fn several_files_are_listed_and_none_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        let refused = |names: &[&str]| {
            unpacked(&archive(folder.path(), names, CompressionMethod::Stored)).unwrap_err()
        };
        let several = refused(&["a.csv", "b/c.csv"]);
        assert!(several.contains("archive of 2 files, not of one: a.csv, b/c.csv"), "{several}");
        let excel = refused(&["[Content_Types].xml", "xl/workbook.xml"]);
        assert!(excel.ends_with("an Excel workbook (.xlsx): save a sheet as CSV"), "{excel}");
        let open = refused(&["mimetype", "content.xml"]);
        assert!(open.ends_with("a file of OpenDocument (.ods): save a sheet as CSV"), "{open}");
        let none = refused(&["b/"]);
        assert!(none.ends_with("a zip archive without a file"), "{none}");
    }

    #[test]
    fn what_is_not_read_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = archive(folder.path(), &["a.csv"], CompressionMethod::Stored);
        let whole = std::fs::read(&path).unwrap();
        // Flags and method of the file in the list at the end.
        let entry = whole.windows(4).rposition(|four| four == b"PK\x01\x02").unwrap();
        for (at, value, what) in
            [(8, 1, "an encrypted zip archive"), (10, 12, "file is packed by Bzip2, which is not")]
        {
            let mut bytes = whole.clone();
            bytes[entry + at] = value;
            std::fs::write(&path, bytes).unwrap();
            let refused = unpacked(&path).unwrap_err();
            assert!(refused.contains(what), "{refused}");
        }
        #[cfg(unix)]
        assert!(unpacked(Path::new("/dev/null")).unwrap_err().contains("archive in a pipe"));
    }

    #[test]
    fn damage_is_found() {
        let folder = tempfile::tempdir().unwrap();
        for method in [CompressionMethod::Stored, CompressionMethod::Deflated] {
            let path = archive(folder.path(), &["a.csv"], method);
            let whole = std::fs::read(&path).unwrap();
            // Behind the header of the file, and its name.
            for at in 36..40 {
                let mut bytes = whole.clone();
                bytes[at] ^= 0x11;
                std::fs::write(&path, bytes).unwrap();
                let refused = unpacked(&path).unwrap_err();
                let known = ["damaged .zip file", "truncated: the file"];
                assert!(known.iter().any(|known| refused.contains(known)), "{at}: {refused}");
            }
            std::fs::write(&path, &whole[..whole.len() / 2]).unwrap();
            assert!(unpacked(&path).unwrap_err().contains("damaged .zip file"));
        }
    }
}
