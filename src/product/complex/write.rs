//! Writes sums into the complex result, on many threads.

use faer::complex::Complex;
use faer::prelude::{Reborrow, ReborrowMut};
use faer::{MatMut, MatRef};

use crate::base::{Par, Real};
use crate::product::options::Uplo;

/// Entries of a piece of work: parts of it stay in the second-level cache.
const PIECE: usize = 1 << 14;

/// Largest side of a tile of a triangle: a transposed tile stays in the first-level cache.
const TILE: usize = 64;

/// Returns whether entries of a row are nearer to each other than those of a column.
pub(super) fn by_rows<T>(matrix: MatRef<'_, T>) -> bool {
    matrix.col_stride().unsigned_abs() <= matrix.row_stride().unsigned_abs()
}

/// Returns the columns in pieces of [`PIECE`] entries, each with the number of its first column.
pub(super) fn pieces<T>(matrix: MatMut<'_, T>) -> impl Iterator<Item = (usize, MatMut<'_, T>)> {
    let size = (PIECE / matrix.nrows().max(1)).max(1);
    let (mut first, mut rest) = (0, Some(matrix));
    std::iter::from_fn(move || {
        let matrix = rest.take().filter(|rest| rest.ncols() > 0)?;
        let count = size.min(matrix.ncols());
        let (piece, others) = matrix.split_at_col_mut(count);
        rest = Some(others);
        first += count;
        Some((first - count, piece))
    })
}

/// Computes `s z`; a real s multiplies both parts, so that infinities stay in their part.
#[inline(always)]
pub(super) fn times<T: Real>(s: Complex<T>, z: Complex<T>) -> Complex<T> {
    if s.im == T::ZERO {
        return Complex { re: s.re * z.re, im: s.re * z.im };
    }
    Complex { re: s.re * z.re - s.im * z.im, im: s.re * z.im + s.im * z.re }
}

/// Computes `value + beta old`, without what is `None`; `old` is not called when beta is 0.
#[inline(always)]
fn updated<T: Real>(
    value: Option<Complex<T>>,
    beta: Complex<T>,
    old: impl FnOnce() -> Complex<T>,
) -> Complex<T> {
    let zero = Complex { re: T::ZERO, im: T::ZERO };
    if beta == zero {
        return value.unwrap_or(zero);
    }
    let old = times(beta, old());
    value.map_or(old, |value| Complex { re: value.re + old.re, im: value.im + old.im })
}

/// Computes `C := V + beta C` with `V_ij = value(i, j)`; without V where that is `None`.
pub(super) fn write_general<T: Real>(
    c: MatMut<'_, Complex<T>>,
    value: impl Fn(usize, usize) -> Option<Complex<T>> + Sync,
    beta: Complex<T>,
    par: Par,
) {
    let by_rows = by_rows(c.rb());
    let lines = if by_rows { c.transpose_mut() } else { c };
    let jobs: Vec<_> = pieces(lines).collect();
    par.for_each(jobs.into_iter(), |_, (first, mut piece)| {
        for j in 0..piece.ncols() {
            for (i, c) in piece.rb_mut().col_mut(j).iter_mut().enumerate() {
                let at = if by_rows { (first + j, i) } else { (i, first + j) };
                *c = updated(value(at.0, at.1), beta, || *c);
            }
        }
    });
}

/// Computes [`write_general`] for the triangle or triangles of `uplo` of a Hermitian C; `value(i,
/// j)` is called for i >= j only, and the imaginary parts of the diagonal become zero.
pub(super) fn write_hermitian<T: Real>(
    c: MatMut<'_, Complex<T>>,
    value: impl Fn(usize, usize) -> Option<Complex<T>> + Sync,
    beta: T,
    uplo: Uplo,
    par: Par,
) {
    // The upper triangle is the lower one of the transpose, conjugated.
    let upper = uplo == Uplo::Upper;
    let lower = if upper { c.transpose_mut() } else { c };
    let own = |z: Complex<T>| if upper { conjugate(z) } else { z };
    let both = uplo == Uplo::Both;
    let beta = Complex { re: beta, im: T::ZERO };
    let mut tiles = Vec::new();
    cut_triangle(lower, 0, &mut tiles);
    par.for_each(tiles.into_iter(), |_, tile| {
        let Tile { row, col, mut below, mut above } = tile;
        for i in 0..below.nrows() {
            let diagonal = above.is_none();
            let end = if diagonal { i + 1 } else { below.ncols() };
            for j in 0..end {
                let value = value(row + i, col + j);
                let mut z = updated(value, beta, || own(below[(i, j)]));
                if diagonal && i == j {
                    z.im = T::ZERO;
                    below[(i, j)] = z;
                    continue;
                }
                below[(i, j)] = own(z);
                if both {
                    match &mut above {
                        Some(above) => above[(j, i)] = conjugate(z),
                        None => below[(j, i)] = conjugate(z),
                    }
                }
            }
        }
    });
}

fn conjugate<T: Real>(z: Complex<T>) -> Complex<T> {
    Complex { re: z.re, im: -z.im }
}

/// A tile of a lower triangle.
struct Tile<'c, T> {
    row: usize,
    col: usize,
    below: MatMut<'c, Complex<T>>,
    /// Its mirror image; `None` on the diagonal, whose tiles contain theirs.
    above: Option<MatMut<'c, Complex<T>>>,
}

/// Cuts the square `c`, which begins at (first, first), into tiles.
fn cut_triangle<'c, T>(c: MatMut<'c, Complex<T>>, first: usize, tiles: &mut Vec<Tile<'c, T>>) {
    let n = c.nrows();
    if n <= TILE {
        return tiles.push(Tile { row: first, col: first, below: c, above: None });
    }
    let half = n / 2;
    let (start, above, below, end) = c.split_at_mut(half, half);
    cut_triangle(start, first, tiles);
    cut_square(Tile { row: first + half, col: first, below, above: Some(above) }, tiles);
    cut_triangle(end, first + half, tiles);
}

/// Cuts a part below the diagonal into tiles.
fn cut_square<'c, T>(tile: Tile<'c, T>, tiles: &mut Vec<Tile<'c, T>>) {
    let (nrows, ncols) = tile.below.shape();
    if nrows.max(ncols) <= TILE {
        return tiles.push(tile);
    }
    let Tile { row, col, below, above } = tile;
    let Some(above) = above else { return };
    if nrows >= ncols {
        let half = nrows / 2;
        let (below, other_below) = below.split_at_row_mut(half);
        let (above, other_above) = above.split_at_col_mut(half);
        cut_square(Tile { row, col, below, above: Some(above) }, tiles);
        let (row, below, above) = (row + half, other_below, Some(other_above));
        cut_square(Tile { row, col, below, above }, tiles);
    } else {
        let half = ncols / 2;
        let (below, other_below) = below.split_at_col_mut(half);
        let (above, other_above) = above.split_at_row_mut(half);
        cut_square(Tile { row, col, below, above: Some(above) }, tiles);
        let (col, below, above) = (col + half, other_below, Some(other_above));
        cut_square(Tile { row, col, below, above }, tiles);
    }
}
