//! Signed sums of blocks: the additions of fast schemes.
//!
//! Blocks of one sum may differ by a row or a column (odd sizes); a missing row or column counts
//! as zero, so nothing is ever padded.

use std::ops::Range;

use faer::prelude::{Reborrow, ReborrowMut};
use faer::{MatMut, MatRef};

use super::options::Uplo;
use crate::base::{Real, Result, widest};

/// Computes `dst := reuse * dst + sum coefficient * block`, where no block is larger than `dst` and
/// the missing entries of a smaller block count as zero. `reuse == 0` does not read `dst`.
pub(crate) fn combine<T: Real>(dst: MatMut<'_, T>, reuse: T, terms: &[(T, MatRef<'_, T>)]) {
    let by_rows = dst.col_stride() == 1 || dst.row_stride() != 1;
    if by_rows {
        combine_rows(dst, reuse, terms);
    } else {
        let terms: Vec<_> = terms.iter().map(|&(c, block)| (c, block.transpose())).collect();
        combine_rows(dst.transpose_mut(), reuse, &terms);
    }
}

fn combine_rows<T: Real>(mut dst: MatMut<'_, T>, reuse: T, terms: &[(T, MatRef<'_, T>)]) {
    let unit = |view: MatRef<'_, T>| view.col_stride() == 1 || view.ncols() <= 1;
    if unit(dst.rb()) && terms.iter().all(|&(_, block)| unit(block)) {
        widest(
            #[inline(always)]
            || {
                for i in 0..dst.nrows() {
                    combine_row(row_mut(dst.rb_mut(), i), reuse, terms, i);
                }
            },
        );
    } else {
        for i in 0..dst.nrows() {
            for j in 0..dst.ncols() {
                let mut sum = if reuse == T::ZERO { T::ZERO } else { reuse * dst[(i, j)] };
                for &(coefficient, block) in terms {
                    if i < block.nrows() && j < block.ncols() {
                        sum += coefficient * block[(i, j)];
                    }
                }
                dst[(i, j)] = sum;
            }
        }
    }
}

/// Computes row `i` of [`combine`]: term after term, while the row is in the first-level cache.
#[inline(always)]
fn combine_row<T: Real>(dst: &mut [T], mut reuse: T, terms: &[(T, MatRef<'_, T>)], i: usize) {
    let mut terms = terms;
    if let &[(p, a), (q, b), ref rest @ ..] = terms
        && reuse == T::ZERO
    {
        let (a, b) = (row(a, i), row(b, i));
        if a.len() == dst.len() && b.len() == dst.len() {
            for ((d, &a), &b) in dst.iter_mut().zip(a).zip(b) {
                *d = p * a + q * b;
            }
            (reuse, terms) = (T::ONE, rest);
        }
    }
    if terms.is_empty() {
        scale_row(dst, reuse);
    }
    for &(coefficient, block) in terms {
        let block = row(block, i);
        let (covered, missing) = dst.split_at_mut(block.len());
        if reuse == T::ZERO {
            for (d, &s) in covered.iter_mut().zip(block) {
                *d = coefficient * s;
            }
        } else if reuse == T::ONE {
            for (d, &s) in covered.iter_mut().zip(block) {
                *d += coefficient * s;
            }
        } else {
            for (d, &s) in covered.iter_mut().zip(block) {
                *d = reuse * *d + coefficient * s;
            }
        }
        scale_row(missing, reuse);
        reuse = T::ONE;
    }
}

#[inline(always)]
fn scale_row<T: Real>(dst: &mut [T], factor: T) {
    if factor == T::ZERO {
        dst.fill(T::ZERO);
    } else if factor != T::ONE {
        for d in dst {
            *d *= factor;
        }
    }
}

/// Returns row `i` of a view with contiguous rows; empty beyond its last row.
#[inline(always)]
fn row<T>(view: MatRef<'_, T>, i: usize) -> &[T] {
    if i >= view.nrows() || view.ncols() == 0 {
        return &[];
    }
    debug_assert!(view.col_stride() == 1 || view.ncols() == 1);
    // SAFETY: row `i` is inside the view and its `ncols` elements are adjacent.
    unsafe { std::slice::from_raw_parts(view.ptr_at(i, 0), view.ncols()) }
}

/// Returns the mutable form of [`row`].
#[inline(always)]
fn row_mut<T>(view: MatMut<'_, T>, i: usize) -> &mut [T] {
    if i >= view.nrows() || view.ncols() == 0 {
        return &mut [];
    }
    debug_assert!(view.col_stride() == 1 || view.ncols() == 1);
    // SAFETY: row `i` is inside the view, its `ncols` elements are adjacent, and the view is
    // consumed, so nothing else reaches them for the lifetime of the slice.
    unsafe { std::slice::from_raw_parts_mut(view.ptr_at_mut(i, 0), view.ncols()) }
}

/// Computes `dst := beta * dst + coefficient * src` where they overlap, and `beta * dst` where
/// `src` ends first; `src` may be larger too. `beta == 0` does not read `dst`.
pub(crate) fn accumulate<T: Real>(dst: MatMut<'_, T>, beta: T, coefficient: T, src: MatRef<'_, T>) {
    let src = src.submatrix(0, 0, src.nrows().min(dst.nrows()), src.ncols().min(dst.ncols()));
    combine(dst, beta, &[(coefficient, src)]);
}

/// Computes `dst := beta dst`; `beta == 0` writes zeros without reading.
pub(crate) fn scale<T: Real>(dst: MatMut<'_, T>, beta: T) {
    if beta != T::ONE {
        combine(dst, beta, &[]);
    }
}

/// Computes `dst := beta dst` on the lower triangle.
pub(crate) fn scale_lower<T: Real>(dst: MatMut<'_, T>, beta: T) {
    accumulate_lower(dst, beta, T::ZERO, MatRef::from_column_major_slice(&[], 0, 0));
}

/// Computes [`accumulate`] on and below the diagonal of `dst` only.
pub(crate) fn accumulate_lower<T: Real>(
    dst: MatMut<'_, T>,
    beta: T,
    coefficient: T,
    src: MatRef<'_, T>,
) {
    let lines = 0..dst.nrows();
    accumulate_lower_lines(dst, lines, beta, coefficient, src);
}

/// Computes [`accumulate_lower`] on the given rows of `dst` if its rows are contiguous, else on the
/// given columns.
pub(crate) fn accumulate_lower_lines<T: Real>(
    mut dst: MatMut<'_, T>,
    lines: Range<usize>,
    beta: T,
    coefficient: T,
    src: MatRef<'_, T>,
) {
    let by_rows = dst.col_stride() == 1;
    for line in lines {
        // A row up to the diagonal, or a column from it: whichever is contiguous.
        let (row, col, nrows, ncols) =
            if by_rows { (line, 0, 1, line + 1) } else { (line, line, dst.nrows() - line, 1) };
        let piece = dst.rb_mut().submatrix_mut(row, col, nrows, ncols);
        let (nrows, ncols) = (
            nrows.min(src.nrows().saturating_sub(row)),
            ncols.min(src.ncols().saturating_sub(col)),
        );
        if nrows == 0 || ncols == 0 {
            scale(piece, beta);
        } else {
            combine(piece, beta, &[(coefficient, src.submatrix(row, col, nrows, ncols))]);
        }
    }
}

/// Applies `work`, which computes a lower triangle, to the triangles of `uplo`.
#[inline(always)]
pub(crate) fn in_lower<T: Real>(
    mut c: MatMut<'_, T>,
    uplo: Uplo,
    work: impl FnOnce(MatMut<'_, T>) -> Result<()>,
) -> Result<()> {
    let lower = match uplo {
        Uplo::Upper => c.rb_mut().transpose_mut(),
        Uplo::Lower | Uplo::Both => c.rb_mut(),
    };
    work(lower)?;
    if uplo == Uplo::Both {
        mirror_lower(c);
    }
    Ok(())
}

/// Copies the strict lower triangle onto the strict upper one.
pub(crate) fn mirror_lower<T: Real>(mut c: MatMut<'_, T>) {
    const BLOCK: usize = 32;
    let n = c.nrows();
    for j0 in (0..n).step_by(BLOCK) {
        for i0 in (j0..n).step_by(BLOCK) {
            for j in j0..n.min(j0 + BLOCK) {
                for i in i0.max(j + 1)..n.min(i0 + BLOCK) {
                    c[(j, i)] = c[(i, j)];
                }
            }
        }
    }
}

/// Copies `a` to `out`, of the same shape, converted to its scalar (f32 to f64 is exact).
pub(crate) fn convert<S: Real, T: Real>(a: MatRef<'_, S>, mut out: MatMut<'_, T>) {
    /// Rows that are converted together: entries of a cache line. More rows of a power of two
    /// columns would push each other out of the cache.
    const RUN: usize = 8;
    if a.ncols() == 0 {
        return;
    }
    if a.col_stride().unsigned_abs() <= a.row_stride().unsigned_abs() {
        for i in 0..a.nrows() {
            for (out, x) in out.rb_mut().row_mut(i).iter_mut().zip(a.row(i).iter()) {
                *out = T::from_f64(x.to_f64());
            }
        }
        return;
    }
    for start in (0..a.nrows()).step_by(RUN) {
        let count = RUN.min(a.nrows() - start);
        let mut out = out.rb_mut().subrows_mut(start, count);
        let a = a.subrows(start, count);
        for j in 0..a.ncols() {
            for (out, x) in out.rb_mut().col_mut(j).iter_mut().zip(a.col(j).iter()) {
                *out = T::from_f64(x.to_f64());
            }
        }
    }
}
