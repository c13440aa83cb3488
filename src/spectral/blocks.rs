//! Independent pieces of work on threads.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use faer::MatMut;

use crate::base::{Error, Flow, Par, Progress, Result};

/// Calls `work` once on each of the `count` pieces, whichever thread is free. Pieces are made by the caller, not by
/// the number of threads, so that results can't depend on it.
pub(super) fn for_each<T: Send>(
    pieces: impl Iterator<Item = T> + Send,
    count: usize,
    par: Par,
    progress: Option<Progress<'_>>,
    work: impl Fn(T) + Sync,
) -> Result<()> {
    let pieces = Mutex::new(pieces);
    let done = AtomicUsize::new(0);
    let cancelled = AtomicBool::new(false);
    let lanes = Par::Threads(par.threads().min(count).max(1));
    lanes.run_lanes(|_| {
        while !cancelled.load(Ordering::Relaxed) {
            let next = pieces.lock().unwrap_or_else(PoisonError::into_inner).next();
            let Some(piece) = next else { return };
            work(piece);
            let done = done.fetch_add(1, Ordering::Relaxed) + 1;
            if let Some(progress) = progress
                && progress(done as f64 / count as f64) == Flow::Cancel
            {
                cancelled.store(true, Ordering::Relaxed);
            }
        }
    });
    if cancelled.into_inner() { Err(Error::Cancelled) } else { Ok(()) }
}

/// The matrix in blocks of `height` rows, the last one of what is left.
pub(super) fn row_blocks(mut rest: MatMut<'_, f64>, height: usize) -> Vec<MatMut<'_, f64>> {
    let mut blocks = Vec::with_capacity(rest.nrows().div_ceil(height));
    while rest.nrows() > 0 {
        let here = height.min(rest.nrows());
        let (block, below) = rest.split_at_row_mut(here);
        blocks.push(block);
        rest = below;
    }
    blocks
}

/// The matrix in blocks of `width` columns, the last one of what is left.
pub(super) fn column_blocks(rest: MatMut<'_, f64>, width: usize) -> Vec<MatMut<'_, f64>> {
    let blocks = row_blocks(rest.transpose_mut(), width);
    blocks.into_iter().map(MatMut::transpose_mut).collect()
}
