//! Any bytes as arrays of numpy: the file itself, or, behind a zero, the content of its first
//! array.
#![no_main]

use std::io::{Cursor, Write};

use catamaran::io::read_arrays;
use catamaran_fuzz::file;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let path = match bytes {
        [0, content @ ..] => file("a.npz", &archive(content)),
        _ => file("a.npz", bytes),
    };
    let Ok(arrays) = read_arrays(&path) else { return };
    for name in arrays.names() {
        std::hint::black_box((arrays.vector(name).ok(), arrays.matrix(name).ok()));
        std::hint::black_box(arrays.indices(name).ok());
    }
});

/// Returns the bytes as an array of an archive whose checksum holds, which no fuzzer finds.
fn archive(content: &[u8]) -> Vec<u8> {
    let mut writer = ZipWriter::new(Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
    writer.start_file("a.npy", options).expect("an archive is begun");
    writer.write_all(content).expect("memory for an archive");
    writer.finish().expect("an archive is ended").into_inner()
}
