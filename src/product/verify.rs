//! A probabilistic check of a finished product (Freivalds 1977): `C x` against `A^T (A x)`.

use faer::prelude::{Reborrow, ReborrowMut};
use faer::{Mat, MatMut, MatRef};

use super::combine::convert;
use super::options::Uplo;
use crate::base::{Error, Real, Result, Rng, Workspace, block_rows};
use crate::blas;

/// Most rounds: the probability of an error is 2^-1000 with these.
const MAX_ROUNDS: u32 = 1000;

/// The result of [`verify`]. It says nothing about C where the tolerance is not finite, as when the
/// squares of a column of A add up to infinity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Verification {
    /// Whether `residual <= tolerance`, both finite.
    pub passed: bool,
    /// Largest entry of `|C X - alpha A^T W (A X)|` over all random vectors.
    pub residual: f64,
    /// The residual that rounding may cause.
    pub tolerance: f64,
    /// Probability, over the random vectors, that a C with an entry wrong by more than twice the
    /// tolerance passes: 2^-rounds at most.
    pub false_accept_probability: f64,
}

/// Checks `C = alpha A^T A` (m x n matrix A) with `rounds` random vectors of signs, in
/// O(rounds (m n + n^2)).
///
/// For a sign vector x and an entry `E_ij` of the error `E = C - alpha A^T A`, flipping `x_j` moves
/// `(E x)_i` by `2 |E_ij|`, so at least one of the two vectors shows an error of `|E_ij|`: each
/// round misses it with probability at most 1/2. The tolerance is the probabilistic rounding bound
/// of Higham and Mary (2019), `8 u sqrt(m n) max_j ||a_j||^2` with u the unit roundoff of T, so a
/// correct result fails with negligible probability. The check itself runs in f64.
///
/// ```
/// use catamaran::{AtaOptions, Uplo, ata_into, product::verify, faer::Mat};
///
/// let a = Mat::<f64>::from_fn(50, 8, |i, j| ((3 * i + j) % 7) as f64);
/// let mut c = Mat::zeros(8, 8);
/// ata_into(1.0, a.as_ref(), 0.0, c.as_mut(), &AtaOptions::new())?;
/// assert!(verify(1.0, a.as_ref(), c.as_ref(), Uplo::Lower, 20, 0)?.passed);
/// c[(5, 2)] += 1.0;
/// assert!(!verify(1.0, a.as_ref(), c.as_ref(), Uplo::Lower, 20, 0)?.passed);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Shape`] when C is not n x n, [`Error::Argument`] unless `rounds` is in 1..=1000,
/// [`Error::NonFinite`] names the first NaN or infinity of A, whose product nothing can check;
/// [`Error::OutOfMemory`].
pub fn verify<T: Real>(
    alpha: f64,
    a: MatRef<'_, T>,
    c: MatRef<'_, T>,
    uplo: Uplo,
    rounds: u32,
    seed: u64,
) -> Result<Verification> {
    let read = |first, block: MatMut<'_, f64>| {
        convert(a.subrows(first, block.nrows()), block);
        Ok(())
    };
    check_blocks(alpha, a.shape(), read, None, c, uplo, rounds, seed)
}

/// Checks `C = alpha X^T W X`, where `read(first, block)` fills a block with the rows of X (m x n)
/// from `first` on, as [`verify`] does.
pub(crate) fn check_blocks<T: Real>(
    alpha: f64,
    (m, n): (usize, usize),
    mut read: impl FnMut(usize, MatMut<'_, f64>) -> Result<()>,
    weights: Option<&[f64]>,
    c: MatRef<'_, T>,
    uplo: Uplo,
    rounds: u32,
    seed: u64,
) -> Result<Verification> {
    let r = rounds as usize;
    Error::check_shape("C", (n, n), c.shape())?;
    check_rounds(rounds)?;
    let x = signs(n, rounds, seed);
    let backend = blas::native();
    let kernels: &dyn blas::Kernels<f64> = backend.as_ref();

    // Z = -alpha X^T W (X x)
    let mut z = Mat::<f64>::zeros(n, r);
    let mut norms = vec![0.0; n];
    // Rows without columns have no part in C, however many they are.
    let with_entries = if n == 0 { 0 } else { m };
    let height = block_rows::<f64>(n, false).min(m);
    let mut memory = Workspace::new(height * n)?;
    for first in (0..with_entries).step_by(height.max(1)) {
        let count = height.min(m - first);
        let memory = &mut memory.as_mut_slice()[..count * n];
        let mut block = MatMut::from_row_major_slice_mut(memory, count, n);
        read(first, block.rb_mut())?;
        let mut y = Mat::<f64>::zeros(count, r);
        kernels.gemm(1.0, block.rb().transpose(), x.as_ref(), 0.0, y.as_mut());
        for i in 0..count {
            let w = weights.map_or(1.0, |w| w[first + i]);
            for j in 0..r {
                y[(i, j)] *= w;
            }
            for (j, norm) in norms.iter_mut().enumerate() {
                *norm += w.abs() * block[(i, j)] * block[(i, j)];
            }
        }
        refuse_non_finite(&norms, block.rb(), (first, 0))?;
        kernels.gemm(-alpha, block.rb(), y.as_ref(), 1.0, z.as_mut());
    }

    // + C x, in strips of C with both triangles filled in
    const STRIP: usize = 64;
    for first in (0..n).step_by(STRIP) {
        let count = STRIP.min(n - first);
        let strip = Mat::from_fn(n, count, |j, i| {
            let i = first + i;
            let (row, col) = match uplo {
                Uplo::Lower => (i.max(j), i.min(j)),
                Uplo::Upper => (i.min(j), i.max(j)),
                Uplo::Both => (i, j),
            };
            c[(row, col)].to_f64()
        });
        kernels.gemm(1.0, strip.as_ref(), x.as_ref(), 1.0, z.as_mut().subrows_mut(first, count));
    }

    Ok(verdict::<T>(alpha, m, z.as_ref(), &norms))
}

/// Refuses a block whose first entry is A(i, j), if it holds a NaN or an infinity; only then, or
/// after an overflow, are its `norms` not finite.
pub(crate) fn refuse_non_finite<T: Real>(
    norms: &[f64],
    block: MatRef<'_, T>,
    (i, j): (usize, usize),
) -> Result<()> {
    if norms.iter().all(|norm| norm.is_finite()) {
        return Ok(());
    }
    let column = |row: usize| (0..block.ncols()).find(|&j| !block[(row, j)].to_f64().is_finite());
    match (0..block.nrows()).find_map(|row| Some((row, column(row)?))) {
        None => Ok(()),
        Some((row, column)) => Err(Error::NonFinite { what: "A", index: (i + row, j + column) }),
    }
}

pub(crate) fn check_rounds(rounds: u32) -> Result<()> {
    if (1..=MAX_ROUNDS).contains(&rounds) {
        return Ok(());
    }
    let why = format!("must be between 1 and {MAX_ROUNDS}");
    Err(Error::Argument { what: "rounds", why })
}

/// Returns the random vectors: n x rounds.
pub(crate) fn signs(n: usize, rounds: u32, seed: u64) -> Mat<f64> {
    let mut rng = Rng::new(seed);
    Mat::from_fn(n, rounds as usize, |_, _| rng.sign())
}

/// Returns the verdict on the residuals `z = C x - alpha A^T W (A x)`, n x rounds; `norms` are
/// `sum_i |w_i| a_ij^2`.
pub(crate) fn verdict<T: Real>(
    alpha: f64,
    m: usize,
    z: MatRef<'_, f64>,
    norms: &[f64],
) -> Verification {
    // A NaN is kept.
    let mut residual = 0.0_f64;
    for j in 0..z.ncols() {
        for i in 0..z.nrows() {
            let entry = z[(i, j)].abs();
            residual = if entry > residual || entry.is_nan() { entry } else { residual };
        }
    }
    let largest = norms.iter().copied().fold(0.0, f64::max);
    let size = ((m + 1) as f64 * (z.nrows() + 1) as f64).sqrt();
    let tolerance = 8.0 * T::UNIT_ROUNDOFF * size * alpha.abs() * largest;
    Verification {
        // Norms that overflow prove nothing.
        passed: residual <= tolerance && tolerance.is_finite(),
        residual,
        tolerance,
        false_accept_probability: 0.5_f64.powi(z.ncols() as i32),
    }
}
