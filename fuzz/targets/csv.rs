//! Any bytes as a table of text: a matrix or an error, also where a column is left out.
#![no_main]

use catamaran::io::{Matrix, read};
use catamaran_fuzz::{file, matrix_options};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let path = file("a.csv", bytes);
    let Ok(Matrix::F64(whole)) = read(&path, &matrix_options()) else { return };
    let (m, n) = (whole.as_ref().nrows(), whole.as_ref().ncols());
    let Ok(Matrix::F64(part)) = read(&path, &matrix_options().columns(1.min(n)..n)) else {
        panic!("a part of a table that is whole can't be read");
    };
    assert_eq!(part.as_ref().shape(), (m, n - 1.min(n)));
});
