use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef};

use super::by_rows;
use crate::spectral::dense::check_finite;
use catamaran::base::{Error, Par, Progress, Result, positive};

/// Number of rows that are processed together.
const BLOCK: usize = 1 << 10;

/// Eigenvalues up to this share of the largest count as zero, which are those of constants, up to
/// rounding.
const ZERO: f64 = 1e-9;

/// Eigenvalues that differ by less than this share are one multiple eigenvalue, up to rounding.
const EQUAL: f64 = 1e-9;

/// Computes the heat kernel signature of Sun, Ovsjanikov and Guibas, A Concise and Provably
/// Informative Multi-Scale Signature Based on Heat Diffusion (2009):
/// `sum_i exp(-lambda_i t) phi_i(x)^2`, one row for each vertex x and one column for each time t.
///
/// `values` are k eigenvalues (1 / length^2) and `vectors` (n x k) their M-orthonormal
/// eigenfunctions, constants included; times (length^2) are at least 0. The unit of the signature
/// is 1 / area. Divide column t by [`heat_trace`] for the scaled signature of that paper, in which
/// the weighted sum of each column is 1.
///
/// ```
/// use catamaran::{Par, faer::Mat};
/// use catamaran_geometry::spectral::descriptors::heat_kernel_signature;
///
/// // At time 0 a signature is the sum of the squares of the functions.
/// let vectors = Mat::<f64>::identity(3, 2);
/// let found = heat_kernel_signature(&[0.0, 1.0], vectors.as_ref(), &[1e-9], Par::Seq)?;
/// assert!((found[(0, 0)] - 1.0).abs() < 1e-6 && found[(2, 0)].abs() < 1e-6);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Shape`] unless there are as many values as vectors; [`Error::NonFinite`],
/// [`Error::Argument`] for a time that is negative or not finite.
pub fn heat_kernel_signature(
    values: &[f64],
    vectors: MatRef<'_, f64>,
    times: &[f64],
    par: Par,
) -> Result<Mat<f64>> {
    check(values, vectors)?;
    check_times(times)?;
    let weights = Mat::from_fn(values.len(), times.len(), |i, t| (-values[i] * times[t]).exp());
    squares_times(vectors, weights.as_ref(), par)
}

/// Computes the heat trace `sum_i exp(-lambda_i t)` of a time (length^2).
///
/// ```
/// use catamaran_geometry::spectral::descriptors::heat_trace;
///
/// assert_eq!(heat_trace(&[0.0, 0.0], 3.0), 2.0);
/// ```
pub fn heat_trace(values: &[f64], time: f64) -> f64 {
    values.iter().map(|lambda| (-lambda * time).exp()).sum()
}

/// Returns times from `4 ln 10 / lambda_k` to `4 ln 10 / lambda_1` in equal ratios, where lambda_k
/// is the largest and lambda_1 the smallest eigenvalue that is not zero, as in Sun et al. (2009),
/// section 5.
///
/// ```
/// use catamaran_geometry::spectral::descriptors::heat_times;
///
/// let times = heat_times(&[0.0, 1.0, 16.0], 3)?;
/// assert!((times[1] / times[0] - 4.0).abs() < 1e-12 && (times[2] / times[1] - 4.0).abs() < 1e-12);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Argument`] when no eigenvalue is positive, [`Error::NonFinite`].
pub fn heat_times(values: &[f64], count: usize) -> Result<Vec<f64>> {
    let (low, high) = positive_range(values)?;
    let scale = 4.0 * std::f64::consts::LN_10;
    Ok(between((scale / high).ln(), (scale / low).ln(), count).into_iter().map(f64::exp).collect())
}

/// Computes the heat that flows from one vertex to every other in a time (length^2), per area:
/// `sum_i exp(-lambda_i t) phi_i(source) phi_i(x)`. Arguments as in [`heat_kernel_signature`].
///
/// ```
/// use catamaran::faer::mat;
/// use catamaran_geometry::spectral::descriptors::heat_kernel;
///
/// // Two vertices of mass 1: all heat is at the source at first, and half of it in the end.
/// let h = 0.5_f64.sqrt();
/// let vectors = mat![[h, h], [h, -h]];
/// let at = |time| heat_kernel(&[0.0, 1.0], vectors.as_ref(), 0, time);
/// assert!((at(0.0)?[0] - 1.0).abs() < 1e-12 && (at(100.0)?[0] - 0.5).abs() < 1e-12);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// As [`heat_kernel_signature`], and [`Error::Argument`] for a source that does not exist.
pub fn heat_kernel(
    values: &[f64],
    vectors: MatRef<'_, f64>,
    source: usize,
    time: f64,
) -> Result<Vec<f64>> {
    check(values, vectors)?;
    check_times(&[time])?;
    let n = vectors.nrows();
    if source >= n {
        let why = format!("vertex {source} is out of range: {n} vertices, numbered from 0");
        return Err(Error::Argument { what: "source", why });
    }
    let mut heat = vec![0.0; n];
    for (i, lambda) in values.iter().enumerate() {
        let amount = (-lambda * time).exp() * vectors[(source, i)];
        for (x, heat) in heat.iter_mut().enumerate() {
            *heat += amount * vectors[(x, i)];
        }
    }
    Ok(heat)
}

/// Energies of a wave kernel signature, as logarithms of eigenvalues (1 / length^2), and their
/// common width sigma.
#[derive(Debug, Clone, PartialEq)]
pub struct WaveScales {
    /// Logarithms of energies, ascending.
    pub energies: Vec<f64>,
    /// Standard deviation of the logarithm; positive.
    pub sigma: f64,
}

/// Returns equally spaced logarithms of energies as in Aubry, Schlickewei and Cremers, The Wave
/// Kernel Signature (2011), section 5: sigma is seven times their spacing, and both ends lie 2
/// sigma inside of the logarithms of the smallest and largest eigenvalue that are not zero. Where
/// these are D apart, sigma is `7 D / (count + 27)`.
///
/// ```
/// use catamaran_geometry::spectral::descriptors::wave_scales;
///
/// let scales = wave_scales(&[0.0, 1.0, 10.0, 100.0], 8)?;
/// assert_eq!(scales.sigma, 7.0 * 100_f64.ln() / 35.0);
/// assert!((scales.energies[0] - 2.0 * scales.sigma).abs() < 1e-12);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Argument`] unless two different eigenvalues are not zero, [`Error::NonFinite`].
pub fn wave_scales(values: &[f64], count: usize) -> Result<WaveScales> {
    let (low, high) = positive_range(values)?;
    let (low, high) = (low.ln(), high.ln());
    let sigma = 7.0 * (high - low) / (count as f64 + 27.0);
    if high - low <= EQUAL {
        let why =
            "must have at least two different positive values, has one: more are needed".into();
        return Err(Error::Argument { what: "eigenvalues", why });
    }
    Ok(WaveScales { energies: between(low + 2.0 * sigma, high - 2.0 * sigma, count), sigma })
}

/// Computes the wave kernel signature of Aubry et al. (2011): the mean of `phi_i(x)^2` with weights
/// `exp(-(e - ln lambda_i)^2 / 2 sigma^2)`, one row for each vertex x and one column for each
/// energy e. Eigenvalues that are zero are left out. Arguments and unit are those of
/// [`heat_kernel_signature`].
///
/// ```
/// use catamaran::{Par, faer::Mat};
/// use catamaran_geometry::spectral::descriptors::{wave_kernel_signature, wave_scales};
///
/// let (values, vectors) = ([0.0, 1.0, 10.0, 100.0], Mat::<f64>::identity(4, 4));
/// let scales = wave_scales(&values, 8)?;
/// let found = wave_kernel_signature(&values, vectors.as_ref(), &scales, Par::Seq)?;
/// // The weights sum to 1; the constant has weight zero.
/// for column in found.col_iter() {
///     assert!(column[0] == 0.0 && (column.iter().sum::<f64>() - 1.0).abs() < 1e-12);
/// }
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Shape`], [`Error::NonFinite`]; [`Error::Argument`] for a sigma that is not positive and
/// when no eigenvalue is positive.
pub fn wave_kernel_signature(
    values: &[f64],
    vectors: MatRef<'_, f64>,
    scales: &WaveScales,
    par: Par,
) -> Result<Mat<f64>> {
    check(values, vectors)?;
    let least = ZERO * positive_range(values)?.1;
    positive("sigma", scales.sigma)?;
    if let Some(e) = scales.energies.iter().position(|e| !e.is_finite()) {
        return Err(Error::NonFinite { what: "energies", index: (e, 0) });
    }
    let mut weights = Mat::zeros(values.len(), scales.energies.len());
    for (e, energy) in scales.energies.iter().enumerate() {
        let exponents: Vec<f64> = values
            .iter()
            .map(|&lambda| match lambda > least {
                true => -((energy - lambda.ln()) / scales.sigma).powi(2) / 2.0,
                false => f64::NEG_INFINITY,
            })
            .collect();
        // An energy far from all eigenvalues still has weights, those of the nearest eigenvalue.
        let largest = exponents.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let sum: f64 = exponents.iter().map(|x| (x - largest).exp()).sum();
        for (i, x) in exponents.iter().enumerate() {
            weights[(i, e)] = (x - largest).exp() / sum;
        }
    }
    squares_times(vectors, weights.as_ref(), par)
}

/// Computes the global point signature of Rustamov, Laplace-Beltrami Eigenfunctions for Deformation
/// Invariant Shape Representation (2007): `phi_i(x) / sqrt(lambda_i)`, one column for each
/// eigenvalue that is not zero. Signs follow those of the vectors.
///
/// ```
/// use catamaran::faer::{Mat, mat};
/// use catamaran_geometry::spectral::descriptors::global_point_signature;
///
/// let vectors = Mat::<f64>::identity(3, 3);
/// let found = global_point_signature(&[0.0, 1.0, 4.0], vectors.as_ref())?;
/// assert_eq!(found, mat![[0.0, 0.0], [1.0, 0.0], [0.0, 0.5]]);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Shape`], [`Error::NonFinite`].
pub fn global_point_signature(values: &[f64], vectors: MatRef<'_, f64>) -> Result<Mat<f64>> {
    check(values, vectors)?;
    let least = ZERO * values.iter().copied().fold(0.0, f64::max);
    let used: Vec<usize> = (0..values.len()).filter(|&i| values[i] > least).collect();
    Ok(Mat::from_fn(vectors.nrows(), used.len(), |x, j| {
        vectors[(x, used[j])] / values[used[j]].sqrt()
    }))
}

/// Computes the squares of all entries, times a matrix.
fn squares_times(vectors: MatRef<'_, f64>, weights: MatRef<'_, f64>, par: Par) -> Result<Mat<f64>> {
    let (n, k, columns) = (vectors.nrows(), vectors.ncols(), weights.ncols());
    by_rows(n, columns, BLOCK, par, Progress::none(), |range, rows| {
        let squares = Mat::from_fn(range.len(), k, |i, j| vectors[(range.start + i, j)].powi(2));
        let rows = faer::MatMut::from_row_major_slice_mut(rows, range.len(), columns);
        matmul(rows, Accum::Replace, squares.as_ref(), weights, 1.0, faer::Par::Seq);
        Ok(())
    })
}

/// Returns `count` numbers at equal distances, the ends included; a single number is the middle.
fn between(low: f64, high: f64, count: usize) -> Vec<f64> {
    match count {
        1 => vec![(low + high) / 2.0],
        _ => (0..count).map(|i| low + (high - low) * (i as f64 / (count - 1) as f64)).collect(),
    }
}

/// Returns the smallest and the largest eigenvalue that are not zero.
fn positive_range(values: &[f64]) -> Result<(f64, f64)> {
    check_values(values)?;
    let high = values.iter().copied().fold(0.0, f64::max);
    let low = values.iter().copied().filter(|&x| x > ZERO * high).fold(high, f64::min);
    if high > 0.0 {
        return Ok((low, high));
    }
    let why = format!("must have a positive value, but none of {} is positive", values.len());
    Err(Error::Argument { what: "eigenvalues", why })
}

fn check(values: &[f64], vectors: MatRef<'_, f64>) -> Result<()> {
    check_values(values)?;
    Error::check_shape("eigenvectors", (vectors.nrows(), values.len()), vectors.shape())?;
    check_finite("eigenvectors", vectors)
}

fn check_values(values: &[f64]) -> Result<()> {
    match values.iter().position(|x| !x.is_finite()) {
        Some(i) => Err(Error::NonFinite { what: "eigenvalues", index: (i, 0) }),
        None => Ok(()),
    }
}

fn check_times(times: &[f64]) -> Result<()> {
    match times.iter().find(|t| !(**t >= 0.0 && t.is_finite())) {
        Some(time) => {
            let why = format!("must be finite and at least 0, but one is {time}");
            Err(Error::Argument { what: "times", why })
        }
        None => Ok(()),
    }
}
