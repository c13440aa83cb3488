//! The power of two that every column is multiplied by before it is rounded to integers.

use std::ops::Range;

use faer::MatRef;

use crate::base::{Arena, Disjoint, Par, widest};
use crate::kernel::int8::{
    EMPTY, IntegerOperand, Kernel, Moduli, NON_FINITE, NORM_BITS, PANEL, STEP, Tile, WIDTH,
};

/// How the columns of an operand become integers.
pub(crate) struct Columns {
    /// Column j is multiplied by `2^exponents[j]`; zeros up to a whole panel.
    pub exponents: Vec<i32>,
    /// Columns with a NaN or an infinity, in order; they count as zeros.
    pub non_finite: Vec<usize>,
    /// Whether the integers may be as large as `2^WIDE_BITS`.
    pub wide: bool,
}

/// Returns the numbers of bands of 64 rows, and of tiles of 16 columns, of an operand.
fn extent<T>(a: MatRef<'_, T>) -> (usize, usize) {
    (a.nrows().div_ceil(STEP), a.ncols().div_ceil(PANEL) * 2)
}

/// Returns the elements of scratch that [`Columns::new`] takes.
pub(super) fn scratch_len<T: IntegerOperand>(m: usize, n: usize) -> usize {
    let count = m.div_ceil(STEP) * n.div_ceil(PANEL) * PANEL;
    Arena::<T>::len_of::<i32>(count) + Arena::<T>::len_of::<f64>(count)
}

impl Columns {
    /// Creates columns of finite entries, which are multiplied by these powers.
    pub fn given(powers: impl Iterator<Item = i32>, wide: bool) -> Self {
        let mut exponents: Vec<i32> = powers.collect();
        exponents.resize(exponents.len().next_multiple_of(PANEL), 0);
        Self { exponents, non_finite: Vec::new(), wide }
    }

    /// Chooses the powers so that the integers are as large as products of two columns allow: by
    /// the Cauchy-Schwarz inequality those are below P/2. The norms are sums of integers, and so
    /// the same in any order.
    pub fn new<T: IntegerOperand>(
        kernel: &dyn Kernel,
        a: MatRef<'_, T>,
        moduli: &Moduli,
        par: Par,
        arena: &mut Arena<'_, T>,
    ) -> Self {
        let (bands, tiles) = extent(a);
        let mut arena = arena.nested();
        let exponents = arena.take_as::<[i32; WIDTH]>(bands * tiles);
        let squares = arena.take_as::<[f64; WIDTH]>(bands * tiles);
        {
            let exponents = Disjoint::of_slice(exponents);
            let squares = Disjoint::of_slice(squares);
            for_tiles(a, 0..bands, 0..tiles, par, |tile, band, column| {
                let norms = T::norms(kernel, tile);
                let at = column * bands + band;
                // SAFETY: each tile is visited once.
                unsafe {
                    *exponents.get(at) = norms.exponents;
                    *squares.get(at) = norms.squares;
                }
            });
        }
        let limit = limit(moduli, a.nrows());
        let (exponents, squares) = (&*exponents, &*squares);
        let found = par.map_blocks(tiles, 1, |tile| {
            let bands = tile.start * bands..tile.end * bands;
            let (exponents, squares) = (&exponents[bands.clone()], &squares[bands]);
            widest(
                #[inline(always)]
                || combine::<T, _>(exponents, squares, limit),
            )
        });
        Self::of_groups(found.len(), found.into_iter())
    }

    /// Collects the exponents of groups of W columns, `None` for columns that are not finite.
    pub fn of_groups<const W: usize>(
        groups: usize,
        found: impl Iterator<Item = [Option<i32>; W]>,
    ) -> Self {
        let mut exponents = Vec::with_capacity(groups * W);
        let mut non_finite = Vec::new();
        for group in found {
            let first = exponents.len();
            non_finite.extend((0..W).filter(|&j| group[j].is_none()).map(|j| first + j));
            exponents.extend(group.iter().map(|exponent| exponent.unwrap_or(0)));
        }
        Self { exponents, non_finite, wide: false }
    }

    /// Makes columns that are not finite zero.
    pub fn clear_non_finite<T: IntegerOperand>(&self, tile: &mut Tile<T>, column: usize) {
        let first = column * WIDTH;
        let from = self.non_finite.partition_point(|&j| j < first);
        for j in self.non_finite[from..].iter().take_while(|&&j| j < first + WIDTH) {
            for row in &mut tile.0 {
                row[j - first] = T::ZERO;
            }
        }
    }

    /// Returns the exponents of the 32 columns of a panel.
    pub fn exponents_of_panel(&self, panel: usize) -> [i32; PANEL] {
        self.exponents.as_chunks().0[panel]
    }

    /// Returns the exponents of 16 columns.
    pub fn exponents_of(&self, tile: usize) -> [i32; WIDTH] {
        self.exponents.as_chunks().0[tile]
    }
}

/// Returns the largest norm of a column of m entries before it is rounded to integers, which adds
/// at most 1/2 per row.
pub(super) fn limit(moduli: &Moduli, m: usize) -> f64 {
    moduli.largest_norm - 0.5 * (m as f64).sqrt() - 1.0
}

/// Returns the exponents of W columns from the bounds of 64 rows each, `None` for columns that are
/// not finite.
#[inline(always)]
pub(super) fn combine<T: IntegerOperand, const W: usize>(
    exponents: &[[i32; W]],
    squares: &[[f64; W]],
    limit: f64,
) -> [Option<i32>; W] {
    let (largest, sums) = add_up(exponents, squares);
    let mut ratios = [0.0; W];
    for (ratio, sum) in ratios.iter_mut().zip(sums) {
        // Empty columns do not use their ratio, and a division by 0 would be seen in the caller's
        // floating-point environment.
        *ratio = limit / (sum.max(1.0).sqrt() * (1.0 + 1.0 / (1_u64 << 40) as f64));
    }
    let mut found = [None; W];
    for j in 0..W {
        let exponent = (ratios[j].to_bits() >> 52) as i32 - 1023 + NORM_BITS;
        found[j] = match largest[j] {
            NON_FINITE => None,
            EMPTY => Some(0),
            largest => Some((exponent - largest).min(T::INTEGER_BITS - largest)),
        };
    }
    found
}

/// Returns the largest exponents of W columns, and the sums of the squares in the units of these.
/// The sum of a column that is not finite has no meaning.
#[inline(always)]
fn add_up<const W: usize>(exponents: &[[i32; W]], squares: &[[f64; W]]) -> ([i32; W], [f64; W]) {
    let mut largest = [EMPTY; W];
    for exponents in exponents {
        for j in 0..W {
            largest[j] = largest[j].max(exponents[j]);
        }
    }
    /// So many sums of a tile, each at most 2^46, fit 64 bits.
    const MOST: usize = 1 << 16;
    let mut parts = exponents.chunks(MOST).zip(squares.chunks(MOST)).map(
        #[inline(always)]
        |(exponents, squares)| {
            let mut part = [0_u64; W];
            for (exponents, squares) in exponents.iter().zip(squares) {
                for j in 0..W {
                    // To the unit of the largest tile, rounded up; a tile of zeros adds none.
                    let shift = largest[j].saturating_sub(exponents[j]).min(31) as u32 * 2;
                    let squares = (squares[j] as u64).saturating_add((1 << shift) - 1) >> shift;
                    // A sum without meaning may overflow.
                    part[j] = part[j].wrapping_add(squares);
                }
            }
            part
        },
    );
    let first = parts.next().unwrap_or([0; W]);
    let mut sums = [0.0; W];
    if exponents.len() <= MOST {
        for (sum, first) in sums.iter_mut().zip(first) {
            *sum = first as f64;
        }
    } else {
        let parts: Vec<_> = std::iter::once(first).chain(parts).collect();
        for (j, sum) in sums.iter_mut().enumerate() {
            *sum = parts.iter().map(|part| u128::from(part[j])).sum::<u128>() as f64;
        }
    }
    (largest, sums)
}

/// Calls `visit(tile, band, column)` for every tile of the bands and tile columns given, each once,
/// from all threads; along the lines of the matrix.
pub(super) fn for_tiles<T: IntegerOperand>(
    a: MatRef<'_, T>,
    bands: Range<usize>,
    columns: Range<usize>,
    par: Par,
    visit: impl Fn(&mut Tile<T>, usize, usize) + Sync,
) {
    let by_rows = a.row_stride().unsigned_abs() >= a.col_stride().unsigned_abs();
    let inner = if by_rows { columns.len() } else { bands.len() };
    let total = bands.len() * columns.len();
    /// Tiles of a ticket: fewer are not worth one.
    const RUN: usize = 16;
    par.map_blocks(total, RUN, |tiles| {
        let mut tile = Tile::zeros();
        for i in tiles {
            let (outer, inner) = (i / inner, i % inner);
            let (band, column) = if by_rows { (outer, inner) } else { (inner, outer) };
            let (band, column) = (bands.start + band, columns.start + column);
            tile.load(a, band * STEP, column * WIDTH);
            visit(&mut tile, band, column);
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn norms_of_millions_of_rows_do_not_overflow() {
        let count = 3 << 16;
        let squares = vec![[(1_u64 << 46) as f64; WIDTH]; count];
        // Column 1 has one large tile; the squares of the others count a quarter.
        let exponents: Vec<_> = (0..count as i32)
            .map(|i| std::array::from_fn(|j| if j == 1 && i > 0 { -1 } else { 0 }))
            .collect();
        let (largest, sums) = add_up(&exponents, &squares);
        assert_eq!(largest, [0; WIDTH]);
        let whole = ((count as u128) << 46) as f64;
        let quarter = (whole + (3_u64 << 46) as f64) / 4.0;
        assert_eq!(sums, std::array::from_fn(|j| if j == 1 { quarter } else { whole }));
    }

    #[test]
    fn tiles_of_zeros_and_much_smaller_ones_add_at_most_a_unit() {
        let exponents = [[7; WIDTH], [EMPTY; WIDTH], [-900; WIDTH]];
        let squares = [[5.0; WIDTH], [0.0; WIDTH], [1e12; WIDTH]];
        assert_eq!(add_up(&exponents, &squares), ([7; WIDTH], [6.0; WIDTH]));
    }
}
