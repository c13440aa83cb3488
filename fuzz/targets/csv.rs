//! Any bytes as a table of text, in any dialect: a matrix or an error, the same read at once or by
//! blocks, by one thread or several, and also where columns are chosen.
#![no_main]

use catamaran::Par;
use catamaran::faer::Mat;
use catamaran::io::{Columns, Matrix, Missing, TableFile, TableOptions, Words, read_file};
use catamaran::rows::RowBlocks;
use catamaran_fuzz::{file, matrix_options};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    // The first byte decides about options, of which a file of text has none.
    let (choice, text) = bytes.split_first().map_or((0, bytes), |(first, rest)| (*first, rest));
    let table = TableOptions::new()
        .missing(if choice & 1 == 0 { Missing::Nan } else { Missing::Drop })
        .words(if choice & 2 == 0 { Words::LeaveOut } else { Words::Factor })
        .decimal((choice & 4 != 0).then_some(','))
        .header((choice & 8 != 0).then_some(choice & 16 != 0))
        .par(Par::Seq);
    let path = file("a.csv", text);
    let options = matrix_options().table(table.clone());
    let Ok(whole) = read_file(&path, &options) else { return };
    let Matrix::F64(matrix) = &whole.matrix else { panic!("a table that is not dense") };
    let (a, (m, n)) = (matrix.as_ref(), matrix.as_ref().shape());
    let numbers: Vec<String> = (0..n).map(|j| whole.number(j).to_string()).collect();
    let same = |x: f64, y: f64| x == y || x.is_nan() && y.is_nan();
    if let Ok(Some(mut rows)) = TableFile::open(&path, &options) {
        let mut block = Mat::<f64>::zeros(m, n);
        rows.read(0, block.as_mut()).expect("a table that is read at once is read by blocks");
        assert!((0..m).all(|i| (0..n).all(|j| same(block[(i, j)], a[(i, j)]))));
    }
    // Names come before numbers, so a name that is a number would choose another column.
    if whole.names.is_empty() {
        let options = matrix_options().table(table.par(Par::Threads(3)));
        let part = read_file(&path, &options.columns(Columns::list(numbers)));
        let part = part.expect("the columns that were read can be chosen");
        assert_eq!((part.matrix.nrows(), part.matrix.ncols()), (m, n));
    }
});
