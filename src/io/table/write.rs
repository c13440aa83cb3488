//! Writes text tables.

use std::fmt::Debug;
use std::io::{self, Write};

use faer::MatRef;

pub(in crate::io) fn write<T: Debug>(
    sink: &mut dyn Write,
    matrix: MatRef<'_, T>,
    separator: char,
) -> io::Result<()> {
    for i in 0..matrix.nrows() {
        for j in 0..matrix.ncols() {
            if j > 0 {
                write!(sink, "{separator}")?;
            }
            // The shortest text that reads back as the same number.
            write!(sink, "{:?}", matrix[(i, j)])?;
        }
        writeln!(sink)?;
    }
    Ok(())
}
