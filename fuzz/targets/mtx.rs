//! Any bytes as a Matrix Market file: a matrix or an error.
#![no_main]

use catamaran::io::read;
use catamaran_fuzz::{file, matrix_options};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    std::hint::black_box(read(&file("a.mtx", bytes), &matrix_options()).ok());
});
