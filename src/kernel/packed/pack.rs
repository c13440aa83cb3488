//! Packs signed sums of blocks into panels of WIDTH columns.
//!
//! Everything here is inlined into functions that enable the instructions of one [`Vectors`].

use super::geometry::{Area, CACHE_LINE, line_len, piece};
use super::operands::Source;
use super::vectors::{Vectors, low_bits};
use crate::base::Real;
use crate::kernel::finish_stores;

/// Where panels are written.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Panels<T> {
    pub start: *mut T,
    /// Scalars from one panel to the next.
    pub stride: usize,
    /// Whether to write past the caches; then `start` must be the start of a cache line.
    pub past_caches: bool,
}

impl<T> Panels<T> {
    /// Creates panels that are written into the caches.
    pub fn new(start: *mut T, stride: usize) -> Self {
        Self { start, stride, past_caches: false }
    }

    /// Returns the same panels from scalar `offset` on.
    fn at(self, offset: usize) -> Self {
        Self { start: self.start.wrapping_add(offset), ..self }
    }
}

/// Implements [`Kernel::pack`](super::kernel::Kernel::pack).
///
/// # Safety
/// As for the method.
#[inline(always)]
pub(super) unsafe fn pack<V: Vectors>(
    sources: &[Source<'_, V::Scalar>],
    area: &Area,
    out: Panels<V::Scalar>,
) {
    // SAFETY: clause `instructions`; `out` has room for all panels of `area`. `common` is a part of
    // it that all sources have by rows, whole panels unless it has all columns, which `pack_rows`
    // and `pack_many_rows` need. What remains goes to `pack_elements`, at the panel and the row
    // where it begins.
    unsafe {
        let by_rows = sources.iter().all(|s| s.matrix.col_stride() == 1);
        let scaled = sources.iter().filter(|s| s.scale.is_some()).count();
        let shortest = sources.iter().map(|s| s.matrix.nrows()).min().unwrap_or(0);
        let narrowest = sources.iter().map(|s| s.matrix.ncols()).min().unwrap_or(0);
        // The part that is packed row by row: rows that all sources have, and all columns or
        // whole panels.
        let rows = shortest.min(area.rows.end).saturating_sub(area.rows.start);
        let columns = match narrowest.min(area.cols.end).saturating_sub(area.cols.start) {
            _ if !by_rows || rows == 0 => 0,
            common if common == area.cols.len() => common,
            common => common / V::WIDTH * V::WIDTH,
        };
        let common = Area {
            rows: area.rows.start..area.rows.start + rows,
            cols: area.cols.start..area.cols.start + columns,
        };
        macro_rules! by_rows {
            ($scaled:expr) => {
                match *sources {
                    [a] => pack_rows::<V, 1, $scaled>(&[a], &common, out),
                    [a, b] => pack_rows::<V, 2, $scaled>(&[a, b], &common, out),
                    [a, b, c] => pack_rows::<V, 3, $scaled>(&[a, b, c], &common, out),
                    [a, b, c, d] => pack_rows::<V, 4, $scaled>(&[a, b, c, d], &common, out),
                    _ => pack_many_rows::<V>(sources, &common, out),
                }
            };
        }
        match columns {
            0 => {}
            _ if scaled == 0 => by_rows!(false),
            _ if scaled == sources.len() => by_rows!(true),
            _ => pack_many_rows::<V>(sources, &common, out),
        }
        if columns < area.cols.len() {
            let rest = Area { cols: common.cols.end..area.cols.end, ..area.clone() };
            let panels = columns / V::WIDTH;
            pack_elements::<V>(sources, &rest, out.at(panels * out.stride));
        }
        if columns > 0 && rows < area.rows.len() {
            let rest = Area { rows: common.rows.end..area.rows.end, ..common };
            pack_elements::<V>(sources, &rest, out.at(rows * V::WIDTH));
        }
    }
}

/// Packs an area that N sources stored by rows have in full; all of them have a scale if `SCALED`,
/// else none.
#[inline(always)]
unsafe fn pack_rows<V: Vectors, const N: usize, const SCALED: bool>(
    sources: &[Source<'_, V::Scalar>; N],
    area: &Area,
    out: Panels<V::Scalar>,
) {
    // SAFETY: clauses `instructions` and `sources`: the sources have all of `area`, and scales for
    // its columns if SCALED; the last vector of a row is masked. Panels have room for whole vectors
    // in each row of WIDTH scalars. Stores past the caches are aligned by clause `alignment`.
    unsafe {
        // Rows of panels must be whole cache lines: a partly written line is slow to store.
        let past_caches = out.past_caches && V::WIDTH.is_multiple_of(line_len::<V::Scalar>());
        debug_assert!(!past_caches || out.start.addr().is_multiple_of(CACHE_LINE));
        let (columns, first) = (area.cols.len(), area.cols.start);
        let full = columns / V::WIDTH;
        let scales =
            sources.map(|s| s.scale.map_or(std::ptr::null(), |d| d[area.cols.clone()].as_ptr()));
        for (k, row) in area.rows.clone().enumerate() {
            let rows = sources.map(|s| s.matrix.ptr_at(row, first));
            let ahead = sources.map(|s| ahead_of::<V>(&s, row, first));
            let sum = |at: usize, mask: Option<V::Mask>| {
                sum_of::<V, N, SCALED>(sources, &rows, &scales, at, mask)
            };
            for panel in 0..full {
                let to = out.start.add(panel * out.stride + k * V::WIDTH);
                for j in 0..V::COUNT {
                    let at = panel * V::WIDTH + j * V::LANES;
                    for s in 0..N {
                        V::prefetch(ahead[s].wrapping_add(at));
                    }
                    let (to, sum) = (to.add(j * V::LANES), sum(at, None));
                    if past_caches {
                        V::store_past_caches(to, sum);
                    } else {
                        V::store(to, sum);
                    }
                }
            }
            if full * V::WIDTH < columns {
                let to = out.start.add(full * out.stride + k * V::WIDTH);
                for j in 0..V::COUNT {
                    let at = full * V::WIDTH + j * V::LANES;
                    let vector = match columns.saturating_sub(at) {
                        0 => V::splat(V::Scalar::ZERO),
                        rest if rest >= V::LANES => sum(at, None),
                        rest => sum(at, Some(V::mask(low_bits(rest)))),
                    };
                    V::store(to.add(j * V::LANES), vector);
                }
            }
        }
        finish_stores(past_caches);
    }
}

/// Returns the vector at column `at` of the sum of the sources, whose rows and scales begin at
/// `rows` and `scales`; only the lanes of `mask` are read, if any.
#[inline(always)]
unsafe fn sum_of<V: Vectors, const N: usize, const SCALED: bool>(
    sources: &[Source<'_, V::Scalar>; N],
    rows: &[*const V::Scalar; N],
    scales: &[*const V::Scalar; N],
    at: usize,
    mask: Option<V::Mask>,
) -> V::Vector {
    // SAFETY: `pack_rows` passes rows and, if SCALED, scales that have the columns of its area from
    // `at` on: LANES of them, or those of the mask. Clause `instructions`.
    unsafe {
        let load = |from: *const V::Scalar| match mask {
            None => V::load(from.add(at)),
            Some(mask) => V::load_masked(from.add(at), mask),
        };
        let term = |s: usize| match SCALED {
            false => load(rows[s]),
            true => V::mul(load(scales[s]), load(rows[s])),
        };
        let mut sum = term(0);
        if N > 1 || sources[0].coefficient != V::Scalar::ONE {
            sum = V::mul(V::splat(sources[0].coefficient), sum);
        }
        for s in 1..N {
            sum = V::mul_add(V::splat(sources[s].coefficient), term(s), sum);
        }
        sum
    }
}

/// Packs like [`pack_rows`], from any number of sources with or without scales.
#[inline(always)]
unsafe fn pack_many_rows<V: Vectors>(
    sources: &[Source<'_, V::Scalar>],
    area: &Area,
    out: Panels<V::Scalar>,
) {
    // SAFETY: clauses `instructions` and `sources`: `pack` calls this for an area that all sources
    // have by rows, and the mask has only lanes before its last column. A scale has as many
    // elements as its source has columns. Panels have room for whole vectors in each row.
    unsafe {
        let columns = area.cols.len();
        for (k, row) in area.rows.clone().enumerate() {
            for first in (0..columns.next_multiple_of(V::WIDTH)).step_by(V::LANES) {
                let (panel, within) = (first / V::WIDTH, first % V::WIDTH);
                let at = area.cols.start + first;
                let mask = V::mask(low_bits(V::LANES.min(columns.saturating_sub(first))));
                let mut sum = V::splat(V::Scalar::ZERO);
                for s in sources {
                    V::prefetch(ahead_of::<V>(s, row, at));
                    let from = s.matrix.as_ptr();
                    let from = from.wrapping_offset(row as isize * s.matrix.row_stride());
                    let mut term = V::load_masked(from.wrapping_add(at), mask);
                    if let Some(scale) = s.scale {
                        term = V::mul(V::load_masked(scale.as_ptr().wrapping_add(at), mask), term);
                    }
                    sum = V::mul_add(V::splat(s.coefficient), term, sum);
                }
                V::store(out.start.add(panel * out.stride + k * V::WIDTH + within), sum);
            }
        }
    }
}

/// Returns the address to prefetch while entry (row, col) is packed.
#[inline(always)]
fn ahead_of<V: Vectors>(
    source: &Source<'_, V::Scalar>,
    row: usize,
    col: usize,
) -> *const V::Scalar {
    let down = (row + V::TUNING.rows_ahead) as isize * source.matrix.row_stride();
    source.matrix.as_ptr().wrapping_offset(down).wrapping_add(col)
}

/// Packs an area from sources of any strides, which may end inside the area.
#[inline(always)]
unsafe fn pack_elements<V: Vectors>(
    sources: &[Source<'_, V::Scalar>],
    area: &Area,
    out: Panels<V::Scalar>,
) {
    /// Rows per pass, so that matrices stored by columns are read in order.
    const ROWS: usize = 16;
    // SAFETY: clauses `instructions` and `sources`: `count` and `width` end where a source ends, so
    // that only its entries are read. `out` has room for whole rows of WIDTH scalars.
    unsafe {
        let panels = area.cols.len().div_ceil(V::WIDTH);
        for panel in 0..panels {
            let cols = piece(&area.cols, panel, V::WIDTH);
            let to = out.start.add(panel * out.stride);
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
                    for j in 0..width {
                        let from = from.wrapping_offset(j as isize * across);
                        let scale = s.scale.map_or(V::Scalar::ONE, |d| d[cols.start + j]);
                        for k in 0..count {
                            let x = *from.wrapping_offset(k as isize * down);
                            *to.add(k * V::WIDTH + j) += s.coefficient * (scale * x);
                        }
                    }
                }
            }
        }
    }
}
