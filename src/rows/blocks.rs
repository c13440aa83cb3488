//! Reads the rows of a source block by block: the next block is read while `work` processes the
//! last one.

use std::ops::ControlFlow;
use std::sync::mpsc;
use std::thread;

use faer::MatMut;

use super::coding::Coding;
use super::source::RowBlocks;
use crate::base::{Error, FloatEnv, Par, Real, Result, Scratch};

/// Checks the number of rows of a block.
///
/// # Errors
/// [`Error::Argument`] for 0.
pub(super) fn check_block_rows(block_rows: usize) -> Result<()> {
    match block_rows {
        0 => Err(Error::Argument { what: "block rows", why: "must be at least 1".into() }),
        _ => Ok(()),
    }
}

/// The coded rows of a source, as rows.
pub(super) struct CodedRows<'r, T> {
    rows: &'r mut (dyn RowBlocks<T> + Send),
    width: usize,
}

impl<'r, T> CodedRows<'r, T> {
    /// Creates the rows of a source with this coding.
    pub fn new(rows: &'r mut (dyn RowBlocks<T> + Send), coding: &Coding) -> Self {
        Self { rows, width: coding.width() }
    }
}

impl<T> RowBlocks<T> for CodedRows<'_, T> {
    fn nrows(&self) -> usize {
        self.rows.nrows()
    }

    fn ncols(&self) -> usize {
        self.width
    }

    fn read(&mut self, first: usize, out: MatMut<'_, T>) -> Result<()> {
        self.rows.read_coded(first, out)
    }
}

/// Calls `work(first, block)` with the rows from `start` on, `height` (>= 1) at a time, the last
/// block with what is left; `block` holds row after row. Two blocks are allocated and no more; one
/// where there is nothing to overlap: a single block, or [`Par::Seq`], which has no other thread to
/// read.
pub(crate) fn for_each_block<T: Real>(
    rows: &mut (dyn RowBlocks<T> + Send),
    start: usize,
    height: usize,
    par: Par,
    mut work: impl FnMut(usize, &mut [T]) -> Result<()>,
) -> Result<()> {
    let left = rows.nrows().saturating_sub(start);
    if left == 0 {
        return Ok(());
    }
    let len = height.min(left).saturating_mul(rows.ncols());
    if left > height
        && par != Par::Seq
        && let ControlFlow::Break(done) = overlapped(rows, start, height, len, &mut work)
    {
        return done;
    }
    let mut block = Scratch::new::<T>(len)?;
    for first in (start..rows.nrows()).step_by(height) {
        let filled = fill(rows, first, height, &mut block)?;
        work(first, filled)?;
    }
    Ok(())
}

/// Computes [`for_each_block`] with a thread that reads. Returns `Continue`, with nothing done,
/// when the system refuses the thread.
fn overlapped<T: Real>(
    rows: &mut (dyn RowBlocks<T> + Send),
    start: usize,
    height: usize,
    len: usize,
    work: &mut impl FnMut(usize, &mut [T]) -> Result<()>,
) -> ControlFlow<Result<()>> {
    let blocks = Scratch::new::<T>(len).and_then(|first| Ok([first, Scratch::new::<T>(len)?]));
    let blocks = match blocks {
        Ok(blocks) => blocks,
        Err(e) => return ControlFlow::Break(Err(e)),
    };
    let (m, n) = (rows.nrows(), rows.ncols());
    thread::scope(|scope| {
        let (give, empty) = mpsc::channel();
        let (full_end, full) = mpsc::channel();
        let reader = move || {
            // Threads inherit the environment of the thread that makes them.
            let _nearest = FloatEnv::nearest();
            for first in (start..m).step_by(height) {
                // Both ends fail when the other side has ended.
                let Ok(mut block) = empty.recv() else { return };
                let filled = fill(rows, first, height, &mut block).map(drop);
                let failed = filled.is_err();
                if full_end.send(filled.map(|()| (first, block))).is_err() || failed {
                    return;
                }
            }
        };
        let named = thread::Builder::new().name("catamaran-rows".into());
        if named.spawn_scoped(scope, reader).is_err() {
            return ControlFlow::Continue(());
        }
        for block in blocks {
            // If the reader has ended, its error is returned below.
            let _ = give.send(block);
        }
        // Ends with the last block, with the first error, or with a panic of the source, which the
        // end of the scope propagates.
        let done = full.iter().try_for_each(|filled| {
            let (first, mut block): (usize, Scratch) = filled?;
            let count = height.min(m - first);
            work(first, &mut block.as_mut_slice::<T>()[..count * n])?;
            let _ = give.send(block);
            Ok(())
        });
        drop((give, full));
        ControlFlow::Break(done)
    })
}

/// Reads the block from row `first` on; rows without columns are not read.
fn fill<'b, T: Real>(
    rows: &mut (dyn RowBlocks<T> + Send),
    first: usize,
    height: usize,
    block: &'b mut Scratch,
) -> Result<&'b mut [T]> {
    let (count, n) = (height.min(rows.nrows() - first), rows.ncols());
    let block = &mut block.as_mut_slice::<T>()[..count * n];
    if n > 0 {
        rows.read(first, MatMut::from_row_major_slice_mut(block, count, n))?;
    }
    Ok(block)
}
