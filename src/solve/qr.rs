use faer::{Mat, MatMut};

use super::cholesky::{PivotedCholesky, Pivoting, named};
use super::columns::Columns;
use super::double::{DoubleDouble, scaled};
use super::refine::{TRIPLED, scaled_columns};
use super::slices::{PairsMut, add_triples, normalize_triples};
use crate::base::{Error, Par, Result, widest};
use crate::dense::by_pieces;
use crate::rows::ExtendedGram;

/// Rows of A that are multiplied at a time.
const ROWS: usize = 64;

/// Distance of `Q^T Q` from the identity at which it has no correct digits.
const FAR: f64 = 0.5;

/// Columns of a product that one thread computes at a time.
const TASK: usize = 16;

/// The factors of `A = Q R` with orthonormal columns of Q, from the Gram matrix of A (m x n): R and
/// its inverse, by which blocks of rows of A become rows of Q in a second pass.
///
/// Let K be the condition number of A with columns of norm 1. The columns of Q are orthonormal up
/// to rounding for K up to 10^14 where the entries of A are exact, and up to an error of `n K^2
/// 2^-79` where they were rounded. Where double-double does not suffice for the Cholesky factor,
/// it is corrected once by the factor of `R^-T C R^-1`, which is computed with three parts.
///
/// ```
/// use catamaran::rows::ExtendedGram;
/// use catamaran::solve::GramQr;
/// use catamaran::{Par, faer::mat};
///
/// let a = mat![[3.0, 1.0], [4.0, 1.0]];
/// let c = a.transpose() * &a;
/// let qr = GramQr::from_gram(&ExtendedGram::from_f64(c.as_ref(), 2, &[])?, Par::Seq)?;
/// let mut q = a.clone();
/// qr.apply(q.as_mut(), Par::Seq)?;
/// assert_eq!(q, mat![[0.6, 0.8], [0.8, -0.6]]);
/// assert!((&q * qr.r() - a).norm_max() < 1e-15);
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct GramQr {
    r: Mat<f64>,
    /// The inverse of the R of A with scaled columns, by rows.
    inverse: Columns<2>,
    exponents: Vec<i32>,
}

impl GramQr {
    /// Factors a Gram matrix. The result is the same, bit for bit, for every `par`.
    ///
    /// # Errors
    /// [`Error::Argument`] that names columns which depend on those before them, or says that the
    /// columns do so to the precision of a Gram matrix with rounded entries; else as
    /// [`PivotedCholesky::from_gram`].
    pub fn from_gram(gram: &ExtendedGram, par: Par) -> Result<Self> {
        /// Distance of `Q^T Q` from the identity that is negligible.
        const FINE: f64 = 1.0 / (1u64 << 54) as f64;
        let factor = PivotedCholesky::from_gram(gram, Pivoting::Natural, par)?;
        let n = factor.n();
        if factor.rank() < n {
            let why = format!("dependent on the columns before: {}", named(factor.dependent()));
            return Err(Error::Argument { what: "A", why });
        }
        let mut inverse = factor.inverse(par)?;
        // Columns of R^T are rows of R.
        let mut rows = factor.lower.clone();
        let square = n as f64 * factor.scaled_condition()?.powi(2);
        if !gram.is_exact() && square * 2f64.powi(-79) > FAR {
            let why = "its columns are dependent, to the precision of its rounded entries".into();
            return Err(Error::Argument { what: "A", why });
        }
        if gram.is_exact() && square * 2f64.powi(-104) > FINE {
            let far = gram_of_inverse(&factor, gram, &inverse, par)?;
            (rows, inverse) = corrected(&far, &rows, &inverse, par)?;
        }
        let mut r = crate::dense::zeros(n, n)?;
        for j in 0..n {
            for i in 0..=j {
                r[(i, j)] = scaled(rows.get(j, i)[0], factor.exponents[j]);
            }
        }
        Ok(Self { r, inverse, exponents: factor.exponents })
    }

    /// Returns R (n x n), upper triangular with a positive diagonal, rounded to f64.
    pub fn r(&self) -> &Mat<f64> {
        &self.r
    }

    /// Computes `X := X R^-1` for a block of rows of A (any number x n). The results are rows of Q,
    /// computed in double-double and rounded once: substitution in f64 would lose as many digits as
    /// the condition number of A has. The result is the same, bit for bit, for every `par` and any
    /// blocks.
    ///
    /// # Errors
    /// [`Error::Shape`] when X does not have n columns.
    pub fn apply(&self, x: MatMut<'_, f64>, par: Par) -> Result<()> {
        let n = self.exponents.len();
        Error::check_shape("X", (x.nrows(), n), x.shape())?;
        by_pieces(x, ROWS, 10 * n * n, par, |_, mut x| {
            let rows = x.nrows();
            let mut a = vec![0.0; ROWS * n];
            for (j, column) in a.chunks_mut(ROWS).enumerate() {
                for i in 0..rows {
                    column[i] = scaled(x[(i, j)], -self.exponents[j]);
                }
            }
            for j in 0..n {
                let (mut hi, mut lo) = ([0.0; ROWS], [0.0; ROWS]);
                widest(
                    #[inline(always)]
                    || {
                        let mut sum = PairsMut { hi: &mut hi, lo: &mut lo };
                        for (k, column) in a.chunks(ROWS).take(j + 1).enumerate() {
                            sum.subtract_f64(column, -self.inverse.double(j, k));
                        }
                        sum.normalize();
                    },
                );
                (0..rows).for_each(|i| x[(i, j)] = hi[i]);
            }
        })
    }
}

/// Returns the upper triangle of `R^-T C R^-1`, the identity up to the error of R.
fn gram_of_inverse(
    factor: &PivotedCholesky,
    gram: &ExtendedGram,
    inverse: &Columns<2>,
    par: Par,
) -> Result<Columns<2>> {
    let n = factor.n();
    let matrix = scaled_columns(factor, |i, j| gram.entry(i, j))?;
    let zeros = vec![0.0; n];
    let column = |j: usize| {
        let [mut a, mut b, mut c] = [zeros.clone(), zeros.clone(), zeros.clone()];
        let [mut d, mut e, mut f] = [zeros.clone(), zeros.clone(), zeros.clone()];
        widest(
            #[inline(always)]
            || {
                for k in 0..=j {
                    let [hi, lo] = inverse.get(j, k);
                    let sum = [&mut a, &mut b, &mut c].map(|part| &mut part[..=j]);
                    add_triples(sum, matrix.col(k, 0), [hi, lo, 0.0]);
                }
                normalize_triples([&mut a, &mut b, &mut c]);
                for k in 0..=j {
                    let [hi, lo] = inverse.col(k, k);
                    let sum = [&mut d, &mut e, &mut f].map(|part| &mut part[k..=j]);
                    add_triples(sum, [hi, lo, &zeros], [a[k], b[k], c[k]]);
                }
                normalize_triples([&mut d, &mut e, &mut f]);
            },
        );
        (d, e, f)
    };
    let operations = TRIPLED * (TASK * n * n) as f64;
    let blocks =
        par.map_blocks_asking(n, TASK, operations, |cols| cols.map(column).collect::<Vec<_>>())?;
    let mut product = Columns::new(n, n)?;
    for (j, (d, e, f)) in blocks.into_iter().flatten().enumerate() {
        for i in 0..=j {
            product.set_double(i, j, DoubleDouble::new(d[i], e[i] + f[i]));
        }
    }
    Ok(product)
}

/// Returns the rows of `S R` and of `R^-1 S^-1` for the factor S of `product`.
fn corrected(
    product: &Columns<2>,
    rows: &Columns<2>,
    inverse: &Columns<2>,
    par: Par,
) -> Result<(Columns<2>, Columns<2>)> {
    let n = product.rows;
    let far = |i: usize, j: usize| (product.get(i, j)[0] - f64::from(i == j)).abs();
    for j in 0..n {
        if (0..=j).any(|i| far(i, j) > FAR || far(i, j).is_nan()) {
            let why = format!("column {j} depends on those before it");
            return Err(Error::Argument { what: "A", why });
        }
    }
    let entry = |i: usize, j: usize| {
        let [hi, lo] = product.get(i.min(j), i.max(j));
        [hi, lo, 0.0]
    };
    let factor = PivotedCholesky::of(n, 0.0, Pivoting::Natural, par, entry)?;
    if factor.rank() < n {
        let why = format!("dependent on the columns before: {}", named(factor.dependent()));
        return Err(Error::Argument { what: "A", why });
    }
    let mut own = factor.inverse(par)?;
    for k in 0..n {
        for j in k..n {
            own.set_double(j, k, own.double(j, k).scaled(-factor.exponents[k]));
        }
    }
    let next_rows = upper_product(|i, k| factor.entry(i, k), rows, par)?;
    let next_inverse = upper_product(|i, k| inverse.double(k, i), &own, par)?;
    Ok((next_rows, next_inverse))
}

/// Returns the rows of the product of two upper triangular matrices, the second one by rows.
fn upper_product(
    left: impl Fn(usize, usize) -> DoubleDouble + Sync,
    right: &Columns<2>,
    par: Par,
) -> Result<Columns<2>> {
    let n = right.rows;
    let mut product = Columns::new(n, n)?;
    let stride = product.stride;
    let [hi, lo] = &mut product.parts;
    let rows = hi.chunks_mut(stride).zip(lo.chunks_mut(stride));
    let operations = 10.0 * (n * stride) as f64;
    par.for_each_asking(rows, operations, |i, (hi, lo)| {
        widest(
            #[inline(always)]
            || {
                let mut row = PairsMut { hi, lo };
                row.subtract(
                    right.columns().starting(0, i),
                    n - i,
                    #[inline(always)]
                    |k| -left(i, i + k),
                );
                row.normalize();
            },
        );
    })?;
    Ok(product)
}
