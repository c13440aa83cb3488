//! The second pass over the rows, to a matrix that is written block by block.

use anyhow::Result;
use catamaran::base::{Workspace, block_rows};
use catamaran::faer::{Mat, MatMut, MatRef};
use catamaran::io::ArraysWriter;

use super::table::Table;
use crate::progress::Bar;
use crate::rows::RowList;

/// Most rows in a block; wide rows have smaller blocks.
const ROWS: usize = 4096;

/// Writes the array `name` of `width` columns: `of_rows` of each block of rows.
///
/// Blocks have a fixed height, so that the result does not depend on any option.
pub fn second_pass(
    table: &Table,
    writer: &mut ArraysWriter,
    name: &str,
    width: usize,
    of_rows: impl Fn(MatRef<'_, f64>) -> catamaran::Result<Mat<f64>>,
) -> Result<()> {
    let (m, n) = (table.nrows(), table.ncols());
    writer.matrix_by_rows(name, m, width)?;
    let height = block_rows::<f64>(n, true).min(ROWS).min(m).max(1);
    let mut memory = Workspace::<f64>::new(height.saturating_mul(n))?;
    let bar = Bar::new("rows");
    table.read(&RowList::from(0..m), false, |rows| {
        for first in (0..m).step_by(height) {
            bar.step(first as f64 / m as f64)?;
            let count = height.min(m - first);
            let block = &mut memory.as_mut_slice()[..count * n];
            rows.read(first, MatMut::from_row_major_slice_mut(block, count, n))?;
            let block = MatRef::from_row_major_slice(block, count, n);
            writer.rows(of_rows(block)?.as_ref())?;
        }
        Ok(())
    })
}
