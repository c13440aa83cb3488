//! Any bytes as an array of numpy: a matrix or an error, read as a whole and by rows.
#![no_main]

use catamaran::faer::Mat;
use catamaran::io::{RowFile, read};
use catamaran::rows::RowBlocks;
use catamaran_fuzz::{file, matrix_options};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let path = file("a.npy", bytes);
    let whole = read(&path, &matrix_options());
    let Ok(mut rows) = RowFile::open(&path) else { return };
    let (m, n) = (rows.nrows(), rows.ncols());
    let count = m.min(5);
    if n <= bytes.len() {
        let mut block = Mat::<f64>::zeros(count, n);
        if rows.read(m - count, block.as_mut()).is_ok() && m * n * 8 < 1 << 20 {
            whole.expect("what is read by rows is read as a whole");
        }
    }
});
