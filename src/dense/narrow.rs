//! Matrices of at most eight columns by rows: a row is one register, and an entry of a matrix that
//! they are multiplied with is read once for all columns.

use faer::{MatMut, MatRef};

use crate::base::widest;

/// Columns.
pub(crate) const WIDTH: usize = 8;

/// A row, with zeros for columns that are not there.
pub(crate) type Row = [f64; WIDTH];

/// Rows that stay in the first-level cache, with what they are multiplied with.
const ROWS: usize = 256;

/// `a b + c`; with `FUSED` the product is not rounded first.
#[inline(always)]
pub(crate) fn add<const FUSED: bool>(a: f64, b: &Row, c: Row) -> Row {
    std::array::from_fn(|j| if FUSED { a.mul_add(b[j], c[j]) } else { a * b[j] + c[j] })
}

/// Whether the registers that [`widest`] takes multiply and add at once; elsewhere that would be a
/// call of a function.
pub(crate) fn has_fused() -> bool {
    #[cfg(target_arch = "x86_64")]
    return pulp::x86::V3::is_available();
    #[cfg(not(target_arch = "x86_64"))]
    cfg!(target_arch = "aarch64")
}

/// Whether products of `a` with a matrix of `columns` columns are for this module.
pub(super) fn is_narrow(a: MatRef<'_, f64>, columns: usize) -> bool {
    (1..=WIDTH).contains(&columns) && a.row_stride() == 1
}

/// The rows of a matrix.
fn rows_of(x: MatRef<'_, f64>) -> Vec<Row> {
    let mut rows = vec![[0.0; WIDTH]; x.nrows()];
    for j in 0..x.ncols() {
        rows.iter_mut().zip(x.col(j).iter()).for_each(|(row, x)| row[j] = *x);
    }
    rows
}

/// Column `j` of a matrix whose columns are contiguous.
#[inline(always)]
fn column<'a>(a: MatRef<'a, f64>, j: usize) -> &'a [f64] {
    a.col(j).try_as_col_major().map_or(&[], |column| column.as_slice())
}

/// `C := A^T B` for A (n x p) with contiguous columns, B (n x q) and C (p x q), q at most [`WIDTH`].
pub(super) fn transposed(c: MatMut<'_, f64>, a: MatRef<'_, f64>, b: MatRef<'_, f64>) {
    if has_fused() { transposed_as::<true>(c, a, b) } else { transposed_as::<false>(c, a, b) }
}

fn transposed_as<const FUSED: bool>(
    mut c: MatMut<'_, f64>,
    a: MatRef<'_, f64>,
    b: MatRef<'_, f64>,
) {
    let rows = rows_of(b);
    let mut sums = vec![[0.0; WIDTH]; a.ncols()];
    widest(
        #[inline(always)]
        || {
            for (block, rows) in rows.chunks(ROWS).enumerate() {
                let of_block = |j: usize| &column(a, j)[block * ROWS..][..rows.len()];
                let (eights, ones) = sums.as_chunks_mut::<WIDTH>();
                let first = eights.len() * WIDTH;
                for (i, sums) in eights.iter_mut().enumerate() {
                    add_products::<WIDTH, FUSED>(sums, |r| of_block(i * WIDTH + r), rows);
                }
                for (i, sum) in ones.as_chunks_mut::<1>().0.iter_mut().enumerate() {
                    add_products::<1, FUSED>(sum, |_| of_block(first + i), rows);
                }
            }
        },
    );
    for (i, sum) in sums.iter().enumerate() {
        (0..c.ncols()).for_each(|j| c[(i, j)] = sum[j]);
    }
}

/// Adds the products of N columns with the rows to their sums.
#[inline(always)]
fn add_products<'a, const N: usize, const FUSED: bool>(
    sums: &mut [Row; N],
    column: impl Fn(usize) -> &'a [f64],
    rows: &[Row],
) {
    let columns: [&[f64]; N] = std::array::from_fn(|r| &column(r)[..rows.len()]);
    let mut own = *sums;
    for (k, row) in rows.iter().enumerate() {
        for r in 0..N {
            own[r] = add::<FUSED>(columns[r][k], row, own[r]);
        }
    }
    *sums = own;
}

/// `X := X - A B` for A (n x p) with contiguous columns, B (p x q) and X (n x q), q at most
/// [`WIDTH`].
pub(super) fn subtract(x: MatMut<'_, f64>, a: MatRef<'_, f64>, b: MatRef<'_, f64>) {
    if has_fused() { subtract_as::<true>(x, a, b) } else { subtract_as::<false>(x, a, b) }
}

fn subtract_as<const FUSED: bool>(mut x: MatMut<'_, f64>, a: MatRef<'_, f64>, b: MatRef<'_, f64>) {
    /// Columns of A that are streams of their own.
    const STREAMS: usize = 16;
    let (n, factors) = (x.nrows(), rows_of(b));
    let mut sums = vec![[0.0; WIDTH]; ROWS];
    for first in (0..n).step_by(ROWS) {
        let sums = &mut sums[..ROWS.min(n - first)];
        sums.fill([0.0; WIDTH]);
        widest(
            #[inline(always)]
            || {
                for (chunk, factors) in factors.chunks(STREAMS).enumerate() {
                    let of_block = |k: usize| &column(a, chunk * STREAMS + k)[first..];
                    let (eights, ones) = sums.as_chunks_mut::<WIDTH>();
                    let rest = eights.len() * WIDTH;
                    for (i, sums) in eights.iter_mut().enumerate() {
                        let mut own = *sums;
                        for (k, factor) in factors.iter().enumerate() {
                            let entries = &of_block(k)[i * WIDTH..][..WIDTH];
                            for r in 0..WIDTH {
                                own[r] = add::<FUSED>(entries[r], factor, own[r]);
                            }
                        }
                        *sums = own;
                    }
                    for (i, sum) in ones.iter_mut().enumerate() {
                        for (k, factor) in factors.iter().enumerate() {
                            *sum = add::<FUSED>(of_block(k)[rest + i], factor, *sum);
                        }
                    }
                }
            },
        );
        for j in 0..x.ncols() {
            for (i, sum) in sums.iter().enumerate() {
                x[(first + i, j)] -= sum[j];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use faer::Mat;

    use super::*;
    use crate::base::Rng;

    #[test]
    fn products_are_those_by_the_definition_with_and_without_fused_additions() {
        let mut rng = Rng::new(5);
        let mut random = |n: usize, p: usize| Mat::from_fn(n, p, |_, _| rng.uniform() - 0.5);
        for n in [0, 1, 7, 8, 255, 256, 257, 530] {
            for p in [0, 1, 2, 8, 17, 33] {
                for q in [1, 3, 8] {
                    let (a, b, x) = (random(n, p), random(n, q), random(n, q));
                    let factor = random(p, q);
                    let (expected, left) = (a.transpose() * &b, &x - &a * &factor);
                    let near = |x: &Mat<f64>, y: &Mat<f64>| (x - y).norm_max() < 1e-12;
                    let mut dirty = Mat::full(p, q, f64::NAN);
                    transposed_as::<true>(dirty.as_mut(), a.as_ref(), b.as_ref());
                    assert!(near(&dirty, &expected), "{n} {p} {q}");
                    transposed_as::<false>(dirty.as_mut(), a.as_ref(), b.as_ref());
                    assert!(near(&dirty, &expected), "{n} {p} {q}");
                    let mut found = x.clone();
                    subtract_as::<true>(found.as_mut(), a.as_ref(), factor.as_ref());
                    assert!(near(&found, &left), "{n} {p} {q}");
                    let mut found = x.clone();
                    subtract_as::<false>(found.as_mut(), a.as_ref(), factor.as_ref());
                    assert!(near(&found, &left), "{n} {p} {q}");
                }
            }
        }
    }
}
