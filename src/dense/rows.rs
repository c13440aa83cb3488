use faer::prelude::ReborrowMut;
use faer::{MatMut, MatRef};

use crate::base::{PIECE, Par, Result, spend};

/// Rows of a block, for work whose blocks stay in the second-level cache.
pub const ROW_BLOCK: usize = 1024;

/// Calls `work(first row, block)` for blocks of `rows` rows each of the matrix, on the threads of
/// `par`. The blocks are the same for any number of threads.
pub fn for_row_blocks(
    matrix: MatMut<'_, f64>,
    rows: usize,
    par: Par,
    work: impl Fn(usize, MatMut<'_, f64>) + Sync,
) {
    let mut blocks = Vec::with_capacity(matrix.nrows().div_ceil(rows));
    let mut rest = matrix;
    while rest.nrows() > rows {
        let (head, tail) = rest.split_at_row_mut(rows);
        blocks.push(head);
        rest = tail;
    }
    blocks.push(rest);
    par.for_each(blocks.into_iter(), |i, block| work(i * rows, block));
}

/// Copies a matrix of the same shape, on the threads of `par`.
pub fn copy(to: MatMut<'_, f64>, from: MatRef<'_, f64>, par: Par) {
    for_row_blocks(to, ROW_BLOCK, par, |first, mut block| {
        block.copy_from(from.subrows(first, block.nrows()));
    });
}

/// Calls [`for_row_blocks`] for some blocks at a time, and asks in between whether to go on. A row
/// takes so many `operations`.
///
/// # Errors
/// [`Error::Cancelled`](crate::Error::Cancelled).
pub fn by_pieces(
    mut matrix: MatMut<'_, f64>,
    rows: usize,
    operations: usize,
    par: Par,
    work: impl Fn(usize, MatMut<'_, f64>) + Sync,
) -> Result<()> {
    for (first, height, spent) in pieces(matrix.nrows(), rows, operations, par.threads()) {
        let piece = matrix.rb_mut().subrows_mut(first, height);
        for_row_blocks(piece, rows, par, |start, block| work(first + start, block));
        spend(spent)?;
    }
    Ok(())
}

/// Returns the pieces of n rows, after each of which the calling thread asks whether to go on: the
/// first row, the number of rows, and the operations of one thread. A piece has whole blocks of
/// `rows` rows for every thread; a row takes so many `operations`.
pub(super) fn pieces(
    n: usize,
    rows: usize,
    operations: usize,
    threads: usize,
) -> impl Iterator<Item = (usize, usize, f64)> {
    let most = (PIECE / operations.max(1) / rows).max(1) * rows * threads;
    (0..n).step_by(most).map(move |first| {
        let height = most.min(n - first);
        let of_one = (height.div_ceil(rows).div_ceil(threads) * rows).min(height);
        (first, height, of_one as f64 * operations as f64)
    })
}

/// Returns how many rows a block has, at most `largest`, where each takes so many `operations`.
pub(super) fn block(operations: usize, largest: usize) -> usize {
    (PIECE / operations.max(1)).clamp(largest / 32, largest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use faer::Mat;

    #[test]
    fn pieces_are_whole_blocks_for_every_thread() {
        let all = |threads| pieces(1000, 100, PIECE / 200, threads).collect::<Vec<_>>();
        let of_rows = |rows: usize| rows as f64 * (PIECE / 200) as f64;
        let some = of_rows(200);
        assert_eq!(all(1), [0, 200, 400, 600, 800].map(|first| (first, 200, some)));
        assert_eq!(all(3), [(0, 600, some), (600, 400, some)]);
        assert_eq!(all(50), [(0, 1000, of_rows(100))]);
        assert_eq!(pieces(30, 100, 7, 4).collect::<Vec<_>>(), [(0, 30, 210.0)]);
        assert_eq!(pieces(0, 100, 7, 4).count(), 0);
    }

    #[test]
    fn every_row_is_visited_once_for_any_number_of_threads() {
        for n in [0, 1, 6, 7, 8, 29] {
            for threads in 1..4 {
                let mut matrix = Mat::<f64>::zeros(n, 2);
                for_row_blocks(matrix.as_mut(), 7, Par::Threads(threads), |first, mut block| {
                    for i in 0..block.nrows() {
                        block[(i, 0)] += 1.0;
                        block[(i, 1)] += (first + i) as f64;
                    }
                });
                assert_eq!(matrix, Mat::from_fn(n, 2, |i, j| if j == 0 { 1.0 } else { i as f64 }));
            }
        }
    }
}
