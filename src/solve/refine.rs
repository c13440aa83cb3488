//! Solutions of `C X = B` that are refined with all three parts of C.

use super::cholesky::PivotedCholesky;
use super::columns::{Columns, LANES};
use super::double::{DoubleDouble, scaled};
use super::slices::{add_triples, normalize_triples};
use crate::base::{Par, Result, widest};

/// Rows of a residual that stay in the first-level cache.
const ROWS: usize = 8 * LANES;

/// Operations that a product takes in three times the precision, and the sum with it.
pub(super) const TRIPLED: f64 = 60.0;

/// Largest number of corrections.
const MOST: usize = 40;

/// A symmetric matrix of three parts, scaled and ordered as its factor.
pub(super) struct Refined<'a> {
    factor: &'a PivotedCholesky,
    /// Columns of the matrix, both triangles; those that depend on others are left out.
    matrix: Columns<3>,
    par: Par,
}

/// How refinement ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Outcome {
    /// Corrections have become smaller than 2^-60 of the solution.
    Converged,
    /// Corrections have stopped getting smaller before that.
    Stalled,
}

impl<'a> Refined<'a> {
    /// Creates the matrix with these entries, of which `factor` is the factor.
    pub fn new(
        factor: &'a PivotedCholesky,
        par: Par,
        entry: impl Fn(usize, usize) -> [f64; 3],
    ) -> Result<Self> {
        Ok(Self { factor, matrix: scaled_columns(factor, entry)?, par })
    }

    /// Returns `B - C X`: B and the result have a column for each right-hand side, X has them by
    /// rows.
    pub fn residual(&self, b: &Columns<3>, x: &Columns<2>) -> Result<Columns<3>> {
        let mut residual = b.clone();
        let stride = b.stride;
        let operations = TRIPLED * (ROWS * b.cols * self.matrix.cols) as f64;
        let blocks = self.par.map_blocks_asking(stride, ROWS, operations, |rows| {
            let mut sums = Vec::with_capacity(b.cols);
            widest(
                #[inline(always)]
                || {
                    for q in 0..b.cols {
                        let [mut s, mut t, mut u] = b.col(q, 0).map(|part| {
                            let mut own = [0.0; ROWS];
                            own[..rows.len()].copy_from_slice(&part[rows.clone()]);
                            own
                        });
                        for j in 0..self.matrix.cols {
                            let column = self.matrix.col(j, 0).map(|part| &part[rows.clone()]);
                            let [hi, lo] = x.get(q, j);
                            let sum = [&mut s, &mut t, &mut u].map(|s| &mut s[..rows.len()]);
                            add_triples(sum, column, [-hi, -lo, 0.0]);
                        }
                        normalize_triples([&mut s, &mut t, &mut u]);
                        sums.push([s, t, u]);
                    }
                },
            );
            (rows, sums)
        })?;
        for (rows, sums) in blocks {
            for (q, sum) in sums.into_iter().enumerate() {
                let at = q * stride;
                for (part, sum) in residual.parts.iter_mut().zip(sum) {
                    part[at + rows.start..at + rows.end].copy_from_slice(&sum[..rows.len()]);
                }
            }
        }
        Ok(residual)
    }

    /// Returns X by rows, for B (rank x k) with a column for each right-hand side.
    pub fn solve(&self, b: &Columns<3>) -> Result<(Columns<2>, Outcome)> {
        let mut x = by_rows(b)?;
        self.correction(&mut x)?;
        let mut last = f64::INFINITY;
        for _ in 0..MOST {
            let mut change = by_rows(&self.residual(b, &x)?)?;
            self.correction(&mut change)?;
            let (norm, share) = sizes(&change, &x);
            if norm.is_nan() || norm > 0.5 * last {
                let outcome =
                    if share <= CONVERGED { Outcome::Converged } else { Outcome::Stalled };
                // A correction as large as the one before is noise, and so is the one before.
                let fine = if norm <= NOISE { Outcome::Converged } else { outcome };
                return Ok((x, fine));
            }
            for i in 0..x.cols {
                for q in 0..x.rows {
                    x.set_double(q, i, x.double(q, i) + change.double(q, i));
                }
            }
            if share <= CONVERGED || norm <= NOISE {
                return Ok((x, Outcome::Converged));
            }
            last = norm;
        }
        Ok((x, Outcome::Stalled))
    }

    fn correction(&self, x: &mut Columns<2>) -> Result<()> {
        self.factor.solve_transposed(x, self.par)?;
        self.factor.solve(x, self.par)
    }
}

/// Returns the columns, both triangles, of a symmetric matrix with these entries, scaled and
/// ordered as its factor; columns that depend on others are left out.
pub(super) fn scaled_columns(
    factor: &PivotedCholesky,
    entry: impl Fn(usize, usize) -> [f64; 3],
) -> Result<Columns<3>> {
    let n = factor.rank;
    let mut matrix = Columns::new(n, n)?;
    for j in 0..n {
        for i in 0..n {
            let (a, b) = (factor.order[i], factor.order[j]);
            let exponent = -factor.exponents[a] - factor.exponents[b];
            matrix.set(i, j, entry(a, b).map(|part| scaled(part, exponent)));
        }
    }
    Ok(matrix)
}

/// The size of a correction, relative to each unknown, that ends refinement.
const CONVERGED: f64 = 1.0 / (1u64 << 60) as f64;

/// The size of a correction, relative to the largest unknown, below which unknowns that are zero
/// have no digits.
const NOISE: f64 = CONVERGED * (1.0 / (1u64 << 40) as f64);

/// Returns the largest correction of any right-hand side, relative to its largest unknown, and to
/// the unknown itself.
fn sizes(change: &Columns<2>, x: &Columns<2>) -> (f64, f64) {
    let (mut norm, mut share) = (0.0_f64, 0.0_f64);
    for q in 0..x.rows {
        let largest = |of: &Columns<2>| {
            let sizes = (0..of.cols).map(|i| of.get(q, i)[0].abs());
            // Keeps a NaN.
            sizes.fold(0.0, |a: f64, b| if b <= a { a } else { b })
        };
        let ratio = |a: f64, b: f64| if a == 0.0 { 0.0 } else { a / b };
        let size = ratio(largest(change), largest(x));
        norm = if size <= norm { norm } else { size };
        for i in 0..x.cols {
            share = share.max(ratio(change.get(q, i)[0].abs(), x.get(q, i)[0].abs()));
        }
    }
    (norm, share)
}

/// Returns columns by rows, rounded to double-double.
fn by_rows(b: &Columns<3>) -> Result<Columns<2>> {
    let mut x = Columns::new(b.cols, b.rows)?;
    for q in 0..b.cols {
        for i in 0..b.rows {
            let [hi, mid, low] = b.get(i, q);
            x.set_double(q, i, DoubleDouble::new(hi, mid + low));
        }
    }
    Ok(x)
}
