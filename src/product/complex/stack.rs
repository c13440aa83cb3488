//! A block of complex rows as real ones.

use std::ops::Range;

use faer::complex::Complex;
use faer::prelude::{Reborrow, ReborrowMut};
use faer::{MatMut, MatRef};

use super::write::{by_rows, pieces};
use crate::base::{Par, Real};

/// The parts of complex rows `X + i Y`, one above the other: X, Y and, of three parts, -X. With X
/// and Y exchanged: Y, X and -Y.
pub(super) struct Stack<'a, T> {
    matrix: MatMut<'a, T>,
    /// Rows of a part.
    height: usize,
}

impl<'a, T: Real> Stack<'a, T> {
    /// Splits `block` into 2 or 3 parts, in that many times its entries of `memory`.
    pub fn new(
        block: MatRef<'_, Complex<T>>,
        parts: usize,
        exchanged: bool,
        memory: &'a mut [T],
        par: Par,
    ) -> Self {
        let ((height, n), by_rows) = (block.shape(), by_rows(block));
        let memory = &mut memory[..parts * height * n];
        let mut matrix = if by_rows {
            MatMut::from_row_major_slice_mut(memory, parts * height, n)
        } else {
            MatMut::from_column_major_slice_mut(memory, parts * height, n)
        };
        let source = if by_rows { block.transpose() } else { block };
        let mut jobs = Vec::new();
        let mut rest = matrix.rb_mut();
        for part in 0..parts {
            let (this, others) = rest.split_at_row_mut(height);
            rest = others;
            let lines = if by_rows { this.transpose_mut() } else { this };
            jobs.extend(pieces(lines).map(|(first, piece)| (first, part, piece)));
        }
        // The parts of a piece follow each other: its source is in the cache for all but the first.
        jobs.sort_by_key(|&(first, part, _)| (first, part));
        par.for_each(jobs.into_iter(), |_, (first, part, piece)| {
            let source = source.subcols(first, piece.ncols());
            match (part, exchanged) {
                (0, false) | (1, true) => convert(source, piece, |z| z.re),
                (1, false) | (0, true) => convert(source, piece, |z| z.im),
                (_, false) => convert(source, piece, |z| -z.re),
                (_, true) => convert(source, piece, |z| -z.im),
            }
        });
        Self { matrix, height }
    }

    /// Returns a view of these parts, one above the other.
    pub fn parts(&self, parts: &Range<usize>) -> MatRef<'_, T> {
        self.matrix.rb().subrows(parts.start * self.height, parts.len() * self.height)
    }
}

#[inline(always)]
fn convert<T: Real>(
    source: MatRef<'_, Complex<T>>,
    mut piece: MatMut<'_, T>,
    part: impl Fn(&Complex<T>) -> T,
) {
    for j in 0..piece.ncols() {
        for (x, z) in piece.rb_mut().col_mut(j).iter_mut().zip(source.col(j).iter()) {
            *x = part(z);
        }
    }
}
