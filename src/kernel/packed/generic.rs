//! The algorithm, once, for any vectors: tiles of products, packing, and write-back.
//!
//! Everything here is inlined into functions that enable the instructions of one [`Vectors`].

use std::ops::Range;

use super::operands::{Source, Target};
use super::{Area, piece};
use crate::base::Real;

/// Vectors of one instruction set.
pub(super) trait Vectors {
    type Scalar: Real;
    type Vector: Copy;
    /// Scalars of a vector.
    const LANES: usize;
    /// Rows of a tile.
    const ROWS: usize;
    /// Vectors of a row of a tile.
    const COUNT: usize;
    /// Columns of a panel.
    const WIDTH: usize = Self::LANES * Self::COUNT;

    /// # Safety
    /// The CPU has the instructions; so for all of these.
    unsafe fn splat(x: Self::Scalar) -> Self::Vector;
    /// # Safety
    /// `from` points to [`Vectors::LANES`] scalars.
    unsafe fn load(from: *const Self::Scalar) -> Self::Vector;
    /// # Safety
    /// `to` points to room for [`Vectors::LANES`] scalars.
    unsafe fn store(to: *mut Self::Scalar, vector: Self::Vector);
    /// `a b + c`.
    ///
    /// # Safety
    /// As above.
    unsafe fn mul_add(a: Self::Vector, b: Self::Vector, c: Self::Vector) -> Self::Vector;
    /// # Safety
    /// As above.
    unsafe fn add(a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// # Safety
    /// As above.
    unsafe fn mul(a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// Asks for a cache line; any address will do.
    fn prefetch(_address: *const Self::Scalar) {}
    /// The same, for the second-level cache.
    fn prefetch_far(_address: *const Self::Scalar) {}
}

/// A row of tiles: ROWS columns of a left panel times some right panels, one after another.
pub(crate) struct Row<'r, T> {
    /// Rows of the panels.
    pub steps: usize,
    pub left: *const T,
    /// What the next row begins with, to be fetched meanwhile.
    pub next_left: *const T,
    /// A part of what the next steps begin with, to be fetched too: this many lines per tile.
    pub next_right: *const T,
    pub next_lines: usize,
    /// The first panel of `panels`; the others follow.
    pub right: *const T,
    pub panels: Range<usize>,
    /// Columns of the product that somebody wants of these rows.
    pub wanted: Range<usize>,
    /// The sums of the tiles: one tile for all when `kept` is false.
    pub sums: *mut T,
    pub kept: bool,
    /// Whether the sums hold those of earlier steps.
    pub add: bool,
    /// Where the sums go when they are complete; empty before.
    pub targets: &'r [Target<T>],
    /// First row of the product.
    pub corner: usize,
}

/// Computes a row of tiles, and writes it if it is complete.
///
/// # Safety
/// The panels hold `steps` rows, the sums a tile per panel (or one); nobody else uses the sums and
/// these entries of the targets.
#[inline(always)]
pub(super) unsafe fn multiply_row<V: Vectors, const ROWS: usize, const COUNT: usize>(
    row: &Row<'_, V::Scalar>,
) {
    let share = row.steps.div_ceil(row.panels.len().max(1));
    for (j, panel) in row.panels.clone().enumerate() {
        let col = panel * V::WIDTH;
        if col >= row.wanted.end || col + V::WIDTH <= row.wanted.start {
            continue;
        }
        // SAFETY: the caller's promise.
        unsafe {
            let sums = row.sums.add(if row.kept { j * V::ROWS * V::WIDTH } else { 0 });
            let right = row.right.add(j * row.steps * V::WIDTH);
            let left = Stream {
                start: row.next_left.wrapping_add(j * share * V::WIDTH),
                stride: V::WIDTH as isize,
                count: share,
                lines: 1,
            };
            let then = match row.targets.first() {
                Some(target) => target.stream(V::ROWS, V::WIDTH, row.corner, col),
                None => {
                    let line = const { line_len::<V::Scalar>() };
                    let start = row.next_right.wrapping_add(j * row.next_lines * line);
                    Stream { start, stride: line as isize, count: row.next_lines, lines: 1 }
                }
            };
            let ahead = &[then, left];
            let rest = row.wanted.end - col;
            if rest >= V::WIDTH || rest.div_ceil(V::LANES) >= COUNT {
                multiply::<V, ROWS, COUNT>(row.steps, row.left, right, sums, row.add, ahead);
            } else if rest > V::LANES {
                multiply::<V, ROWS, 2>(row.steps, row.left, right, sums, row.add, ahead);
            } else {
                multiply::<V, ROWS, 1>(row.steps, row.left, right, sums, row.add, ahead);
            }
            for target in row.targets {
                write::<V>(sums, target, row.corner, col);
            }
        }
    }
}

/// Lines to fetch: some at each of several places.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stream<T> {
    pub start: *const T,
    /// Scalars from one place to the next.
    pub stride: isize,
    /// Places.
    pub count: usize,
    /// Lines at each.
    pub lines: usize,
}

/// Scalars of a cache line.
pub(super) const fn line_len<T>() -> usize {
    64 / size_of::<T>()
}

/// Steps between the places of a [`Stream`].
const PACE: usize = 4;

/// Steps ahead that operands are asked for.
const AHEAD: usize = 16;

/// `sums := left^T right`, or `+=` when `add`: ROWS columns of a panel times the first N vectors of
/// another, over `steps` rows. Sums start at zero each time, so that roundings stay those of short
/// sums. Meanwhile what is `ahead` is fetched, a bit every few steps: all at once it would stand in
/// the way of the operands.
///
/// # Safety
/// The panels hold `steps` rows of WIDTH, the sums ROWS x WIDTH.
#[inline(always)]
pub(super) unsafe fn multiply<V: Vectors, const ROWS: usize, const N: usize>(
    steps: usize,
    mut left: *const V::Scalar,
    mut right: *const V::Scalar,
    sums: *mut V::Scalar,
    add: bool,
    ahead: &[Stream<V::Scalar>],
) {
    // SAFETY: the caller's promise.
    unsafe {
        let mut tile = [[V::splat(V::Scalar::ZERO); N]; ROWS];
        let mut rest = steps;
        for stream in ahead {
            let mut line = stream.start;
            for _ in 0..stream.count.min(rest / PACE) {
                for i in 0..stream.lines {
                    V::prefetch_far(line.wrapping_add(i * const { line_len::<V::Scalar>() }));
                }
                line = line.wrapping_offset(stream.stride);
                for _ in 0..PACE {
                    step::<V, ROWS, N>(&mut left, &mut right, &mut tile);
                }
                rest -= PACE;
            }
        }
        for _ in 0..rest {
            step::<V, ROWS, N>(&mut left, &mut right, &mut tile);
        }
        for i in 0..ROWS {
            for j in 0..N {
                let at = sums.add(i * V::WIDTH + j * V::LANES);
                let sum = if add { V::add(V::load(at), tile[i][j]) } else { tile[i][j] };
                V::store(at, sum);
            }
        }
    }
}

/// One step of [`multiply`].
///
/// # Safety
/// As there.
#[inline(always)]
unsafe fn step<V: Vectors, const ROWS: usize, const N: usize>(
    left: &mut *const V::Scalar,
    right: &mut *const V::Scalar,
    tile: &mut [[V::Vector; N]; ROWS],
) {
    // SAFETY: the caller's promise.
    unsafe {
        let mut r = [V::splat(V::Scalar::ZERO); N];
        for j in 0..N {
            r[j] = V::load(right.add(j * V::LANES));
            V::prefetch(right.wrapping_add(AHEAD * V::WIDTH + j * V::LANES));
        }
        V::prefetch(left.wrapping_add(AHEAD * V::WIDTH));
        for i in 0..ROWS {
            let l = V::splat(*left.add(i));
            for j in 0..N {
                tile[i][j] = V::mul_add(l, r[j], tile[i][j]);
            }
        }
        *left = left.add(V::WIDTH);
        *right = right.add(V::WIDTH);
    }
}

/// Writes the panels that hold columns `area.cols` of the sum of `sources`, rows `area.rows`: the
/// i-th panel at `out + i * panel_stride`, row after row, WIDTH columns each. What a source lacks
/// counts as zero.
///
/// # Safety
/// `out` has room for all panels.
#[inline(always)]
pub(super) unsafe fn pack<V: Vectors>(
    sources: &[Source<'_, V::Scalar>],
    area: &Area,
    out: *mut V::Scalar,
    panel_stride: usize,
) {
    // SAFETY: the caller's promise.
    unsafe {
        let plain = |s: &Source<'_, V::Scalar>| s.matrix.col_stride() == 1 && s.scale.is_none();
        let complete = |s: &Source<'_, V::Scalar>| area.rows.end <= s.matrix.nrows();
        let narrowest = sources.iter().map(|s| s.matrix.ncols()).min().unwrap_or(0);
        // Columns that can be taken row by row: all, or whole panels.
        let columns = match narrowest.min(area.cols.end).saturating_sub(area.cols.start) {
            _ if !sources.iter().all(|s| plain(s) && complete(s)) => 0,
            common if common == area.cols.len() => common,
            common => common / V::WIDTH * V::WIDTH,
        };
        match *sources {
            _ if columns == 0 => {}
            [a] => pack_rows::<V, 1>(&[a], area, columns, out, panel_stride),
            [a, b] => pack_rows::<V, 2>(&[a, b], area, columns, out, panel_stride),
            [a, b, c] => pack_rows::<V, 3>(&[a, b, c], area, columns, out, panel_stride),
            [a, b, c, d] => pack_rows::<V, 4>(&[a, b, c, d], area, columns, out, panel_stride),
            _ => pack_many_rows::<V>(sources, area, columns, out, panel_stride),
        }
        if columns < area.cols.len() {
            let panels = columns / V::WIDTH;
            let cols = area.cols.start + columns..area.cols.end;
            let rest = Area { cols, ..area.clone() };
            pack_elements::<V>(sources, &rest, out.add(panels * panel_stride), panel_stride);
        }
    }
}

/// Rows ahead that sources are asked for.
const ROWS_AHEAD: usize = 6;

/// [`pack`] of the first `columns` columns, from N sources stored by rows.
#[inline(always)]
unsafe fn pack_rows<V: Vectors, const N: usize>(
    sources: &[Source<'_, V::Scalar>; N],
    area: &Area,
    columns: usize,
    out: *mut V::Scalar,
    panel_stride: usize,
) {
    // SAFETY: the caller's promise, and the columns lie inside of all sources.
    unsafe {
        for (k, row) in area.rows.clone().enumerate() {
            let rows = sources.map(|s| s.matrix.ptr_at(row, area.cols.start));
            let ahead = sources.map(|s| ahead_of(&s, row, area.cols.start));
            let full = columns / V::WIDTH;
            for panel in 0..full {
                let to = out.add(panel * panel_stride + k * V::WIDTH);
                for j in 0..V::COUNT {
                    let at = panel * V::WIDTH + j * V::LANES;
                    for s in 0..N {
                        V::prefetch(ahead[s].wrapping_add(at));
                    }
                    V::store(to.add(j * V::LANES), sum_of::<V, N>(sources, &rows, at));
                }
            }
            // Beyond its last vector nobody looks at a panel.
            let to = out.add(full * panel_stride + k * V::WIDTH);
            let mut at = full * V::WIDTH;
            while at + V::LANES <= columns {
                V::store(to.add(at - full * V::WIDTH), sum_of::<V, N>(sources, &rows, at));
                at += V::LANES;
            }
            if at < columns {
                let terms = || (0..N).map(|s| (sources[s].coefficient, rows[s]));
                pack_tail::<V, _>(terms, at..columns, to.add(at - full * V::WIDTH));
            }
        }
    }
}

/// A vector of the sum of the sources, whose rows begin at `rows`.
#[inline(always)]
unsafe fn sum_of<V: Vectors, const N: usize>(
    sources: &[Source<'_, V::Scalar>; N],
    rows: &[*const V::Scalar; N],
    at: usize,
) -> V::Vector {
    // SAFETY: the caller's promise: the vector lies inside of the rows.
    unsafe {
        let mut sum = V::load(rows[0].add(at));
        if N > 1 || sources[0].coefficient != V::Scalar::ONE {
            sum = V::mul(V::splat(sources[0].coefficient), sum);
        }
        for s in 1..N {
            sum = V::mul_add(V::splat(sources[s].coefficient), V::load(rows[s].add(at)), sum);
        }
        sum
    }
}

/// As [`pack_rows`], for any number of sources.
#[inline(always)]
unsafe fn pack_many_rows<V: Vectors>(
    sources: &[Source<'_, V::Scalar>],
    area: &Area,
    columns: usize,
    out: *mut V::Scalar,
    panel_stride: usize,
) {
    // SAFETY: as for `pack_rows`.
    unsafe {
        for (k, row) in area.rows.clone().enumerate() {
            for first in (0..columns).step_by(V::LANES) {
                let (panel, within) = (first / V::WIDTH, first % V::WIDTH);
                let to = out.add(panel * panel_stride + k * V::WIDTH + within);
                let at = area.cols.start + first;
                if first + V::LANES > columns {
                    let term = |s: &Source<'_, V::Scalar>| (s.coefficient, s.matrix.ptr_at(row, 0));
                    let terms = || sources.iter().map(term);
                    pack_tail::<V, _>(terms, at..area.cols.start + columns, to);
                    break;
                }
                let mut sum = V::splat(V::Scalar::ZERO);
                for s in sources {
                    let c = V::splat(s.coefficient);
                    V::prefetch(ahead_of(s, row, at));
                    sum = V::mul_add(c, V::load(s.matrix.ptr_at(row, at)), sum);
                }
                V::store(to, sum);
            }
        }
    }
}

/// The same columns some rows further down.
#[inline(always)]
fn ahead_of<T>(source: &Source<'_, T>, row: usize, col: usize) -> *const T {
    let down = (row + ROWS_AHEAD) as isize * source.matrix.row_stride();
    source.matrix.as_ptr().wrapping_offset(down).wrapping_add(col)
}

/// One vector whose end lies beyond the sources: sums of `coefficient * row[columns]`, then zeros.
#[inline(always)]
unsafe fn pack_tail<V: Vectors, I: Iterator<Item = (V::Scalar, *const V::Scalar)>>(
    terms: impl Fn() -> I,
    columns: Range<usize>,
    to: *mut V::Scalar,
) {
    // SAFETY: the caller's promise: the columns are inside of the rows, a vector fits at `to`.
    unsafe {
        V::store(to, V::splat(V::Scalar::ZERO));
        for (i, at) in columns.enumerate() {
            let mut sum = V::Scalar::ZERO;
            for (c, row) in terms() {
                sum += c * *row.add(at);
            }
            *to.add(i) = sum;
        }
    }
}

/// [`pack`] for edges and for sources stored in any way.
#[inline(always)]
unsafe fn pack_elements<V: Vectors>(
    sources: &[Source<'_, V::Scalar>],
    area: &Area,
    out: *mut V::Scalar,
    panel_stride: usize,
) {
    /// Rows taken together, so that columns stored one after another are read in order.
    const ROWS: usize = 16;
    // SAFETY: the caller's promise; only entries inside of a source are read.
    unsafe {
        let panels = area.cols.len().div_ceil(V::WIDTH);
        for panel in 0..panels {
            let cols = piece(&area.cols, panel, V::WIDTH);
            let to = out.add(panel * panel_stride);
            for first in (0..area.rows.len()).step_by(ROWS) {
                let count = ROWS.min(area.rows.len() - first);
                let to = to.add(first * V::WIDTH);
                for i in 0..count * V::COUNT {
                    V::store(to.add(i * V::LANES), V::splat(V::Scalar::ZERO));
                }
                for s in sources {
                    let m = s.matrix;
                    let row = area.rows.start + first;
                    let count = count.min(m.nrows().saturating_sub(row));
                    let width = cols.end.min(m.ncols()).saturating_sub(cols.start);
                    let (down, across) = (m.row_stride(), m.col_stride());
                    let from = m
                        .as_ptr()
                        .wrapping_offset(row as isize * down + cols.start as isize * across);
                    if across == 1 && s.scale.is_none() {
                        for k in 0..count {
                            let from = from.wrapping_offset(k as isize * down);
                            for j in 0..width {
                                *to.add(k * V::WIDTH + j) += s.coefficient * *from.add(j);
                            }
                        }
                    } else {
                        for j in 0..width {
                            let from = from.wrapping_offset(j as isize * across);
                            let scale = s.scale.map_or(V::Scalar::ONE, |d| d[cols.start + j]);
                            let c = s.coefficient * scale;
                            for k in 0..count {
                                *to.add(k * V::WIDTH + j) +=
                                    c * *from.wrapping_offset(k as isize * down);
                            }
                        }
                    }
                }
            }
        }
    }
}

/// Adds a tile, whose corner is entry `(row, col)` of the product, to a block of C:
/// `C := beta C + coefficient sums`, where C is inside and wanted.
///
/// # Safety
/// `sums` holds ROWS x WIDTH; nobody else uses these entries of C.
#[inline(always)]
pub(super) unsafe fn write<V: Vectors>(
    sums: *const V::Scalar,
    target: &Target<V::Scalar>,
    row: usize,
    col: usize,
) {
    // SAFETY: the caller's promise; the entries lie inside the block.
    unsafe {
        if target.is_plain() && target.wants_all(row..row + V::ROWS, col..col + V::WIDTH) {
            return write_all::<V>(sums, target, row, col);
        }
        let rows = V::ROWS.min(target.rows.saturating_sub(row));
        for i in 0..rows {
            let wanted = target.wanted(row + i);
            let (first, end) = (wanted.start.max(col), wanted.end.min(col + V::WIDTH));
            if first >= end {
                continue;
            }
            let from = sums.add(i * V::WIDTH + first - col);
            let to = target.at(row + i, first);
            let (len, beta, c) = (end - first, target.beta, target.coefficient);
            if target.is_plain() {
                let (vc, vb) = (V::splat(c), V::splat(beta));
                let mut j = 0;
                while j + V::LANES <= len {
                    let sum = V::mul(vc, V::load(from.add(j)));
                    let sum = if beta == V::Scalar::ZERO {
                        sum
                    } else {
                        V::add(V::mul(vb, V::load(to.add(j))), sum)
                    };
                    V::store(to.add(j), sum);
                    j += V::LANES;
                }
                while j < len {
                    write_element(to.add(j), beta, c, *from.add(j));
                    j += 1;
                }
            } else {
                for j in 0..len {
                    let sum = target.unscaled(row + i, first + j, *from.add(j));
                    write_element(to.offset(j as isize * target.col_stride), beta, c, sum);
                }
            }
        }
    }
}

/// [`write()`] of a whole tile, stored by rows.
#[inline(always)]
unsafe fn write_all<V: Vectors>(
    sums: *const V::Scalar,
    target: &Target<V::Scalar>,
    row: usize,
    col: usize,
) {
    // SAFETY: as for `write`.
    unsafe {
        let (c, beta) = (V::splat(target.coefficient), V::splat(target.beta));
        let start = target.at(row, col);
        for i in 0..V::ROWS {
            let to = start.offset(i as isize * target.row_stride);
            for j in 0..V::COUNT {
                let sum = V::mul(c, V::load(sums.add(i * V::WIDTH + j * V::LANES)));
                let to = to.add(j * V::LANES);
                if target.beta == V::Scalar::ONE {
                    V::store(to, V::add(V::load(to), sum));
                } else if target.beta == V::Scalar::ZERO {
                    V::store(to, sum);
                } else {
                    V::store(to, V::add(V::mul(beta, V::load(to)), sum));
                }
            }
        }
    }
}

#[inline(always)]
unsafe fn write_element<T: Real>(to: *mut T, beta: T, coefficient: T, sum: T) {
    // SAFETY: the caller's promise.
    unsafe {
        let sum = coefficient * sum;
        *to = if beta == T::ZERO { sum } else { beta * *to + sum };
    }
}
