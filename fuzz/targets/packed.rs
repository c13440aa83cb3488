//! Any bytes as packed files: what they unpack to is read or refused.
#![no_main]

use catamaran::io::read;
use catamaran_fuzz::{file, matrix_options, source_options};
use catamaran_geometry::mesh::io::read_with;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    std::hint::black_box(read(&file("a.csv.gz", bytes), &matrix_options()).ok());
    std::hint::black_box(read(&file("a.csv.bz2", bytes), &matrix_options()).ok());
    std::hint::black_box(read(&file("a.csv.zip", bytes), &matrix_options()).ok());
    std::hint::black_box(read_with(&file("a.off.gz", bytes), &source_options()).ok());
    std::hint::black_box(read_with(&file("a.off.xz", bytes), &source_options()).ok());
});
