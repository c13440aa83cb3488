use faer::prelude::ReborrowMut;
use faer::{Mat, MatRef};

use super::options::EigenOptions;
use super::space::Pencil;
use crate::base::{Result, spend};

/// Columns that are processed together.
const COLUMNS: usize = 8;

/// Rounding errors of each entry of W phi that no solver can avoid, in units of epsilon.
pub(crate) const ROUNDINGS: f64 = 8.0;

/// The accuracy of eigenpairs.
pub(crate) struct Certificate {
    /// The residuals as in [`super::Eigenpairs`].
    pub residuals: Vec<f64>,
    /// The largest residual.
    pub largest: f64,
    /// The largest ratio of a residual to its bound: 1 or less is good; infinite where a residual
    /// is not a number.
    pub excess: f64,
}

/// Returns the certificate of pairs. The bound of a residual is `options.tolerance`, or, where that
/// is more, the residual of so many `roundings` of phi: with `eps | |W| |phi| |` each in place of
/// `|W phi - lambda M phi|` (Oettli and Prager 1964). `scale` is the s of [`super::Eigenpairs`].
pub(crate) fn certify(
    pencil: &dyn Pencil,
    values: &[f64],
    vectors: MatRef<'_, f64>,
    scale: f64,
    roundings: f64,
    options: &EigenOptions<'_>,
) -> Result<Certificate> {
    let (par, tolerance) = (options.par, options.tolerance);
    // Squares of |W phi|, |M phi| and |W phi - lambda M phi|.
    let mut squares = Mat::zeros(3, values.len());
    let mut w = Mat::zeros(vectors.nrows(), COLUMNS.min(values.len()));
    let mut m = w.clone();
    for (chunk, values) in values.chunks(COLUMNS).enumerate() {
        let x = vectors.subcols(chunk * COLUMNS, values.len());
        let mut w = w.as_mut().subcols_mut(0, values.len());
        let mut m = m.as_mut().subcols_mut(0, values.len());
        pencil.apply_differences(x, w.rb_mut(), par)?;
        pencil.inner().apply_mass(x, m.rb_mut(), par)?;
        spend(7.0 * (x.nrows() * x.ncols()) as f64)?;
        for (j, value) in values.iter().enumerate() {
            let (mut left, mut right, mut gap) = (0.0f64, 0.0f64, 0.0f64);
            for i in 0..x.nrows() {
                let (w, m) = (w[(i, j)], m[(i, j)]);
                left += w * w;
                right += m * m;
                gap += (w - value * m).powi(2);
            }
            let column = chunk * COLUMNS + j;
            [left, right, gap].into_iter().enumerate().for_each(|(i, x)| squares[(i, column)] = x);
        }
    }
    pencil.inner().sum(squares.as_mut())?;
    let mut found =
        Certificate { residuals: Vec::with_capacity(values.len()), largest: 0.0, excess: 0.0 };
    let number = |x: f64| if x.is_nan() { f64::INFINITY } else { x };
    for j in 0..values.len() {
        let [left, right, gap] = [0, 1, 2].map(|i| squares[(i, j)].sqrt());
        let size = left.max(scale * right);
        let residual = gap / size;
        let mut allowed = tolerance;
        if residual > tolerance {
            let rounding = magnitudes(pencil, vectors.subcols(j, 1))?.norm / size;
            allowed = allowed.max(roundings * f64::EPSILON * rounding);
        }
        found.largest = found.largest.max(number(residual));
        found.excess = found.excess.max(number(residual / allowed));
        found.residuals.push(residual);
    }
    Ok(found)
}

/// What bounds the rounding of `W phi` and of `phi^T W phi`.
pub(crate) struct Magnitudes {
    /// The norm `| |W| |phi| |`.
    pub norm: f64,
    /// The product `|phi|^T |W| |phi|`.
    pub dot: f64,
}

/// Computes the magnitudes of one vector.
pub(crate) fn magnitudes(pencil: &dyn Pencil, phi: MatRef<'_, f64>) -> Result<Magnitudes> {
    let mut sums = Mat::zeros(phi.nrows(), 1);
    pencil.apply_magnitudes(phi, sums.as_mut())?;
    let mut found = Mat::<f64>::zeros(2, 1);
    found[(0, 0)] = sums.squared_norm_l2();
    found[(1, 0)] = (0..phi.nrows()).map(|i| phi[(i, 0)].abs() * sums[(i, 0)]).sum::<f64>();
    pencil.inner().sum(found.as_mut())?;
    Ok(Magnitudes { norm: found[(0, 0)].sqrt(), dot: found[(1, 0)] })
}

/// Distance of two eigenvalues, relative to them, above which they can be counted apart.
const APART: f64 = 1e-6;

/// Returns whether two eigenvalues, the lower one first, are so far apart that the count of
/// eigenvalues below a shift between them is correct.
pub(crate) fn apart(low: f64, high: f64, scale: f64) -> bool {
    high - low > APART * (high.abs() + scale)
}

/// Returns whether no eigenvalue is missing among the lowest ones, `values` (any order), up to the
/// last two of them that are apart. `below` counts the eigenvalues below a shift.
pub(crate) fn is_complete_from_below(
    values: &[f64],
    scale: f64,
    below: impl Fn(f64) -> Result<usize>,
) -> Result<bool> {
    let mut values = values.to_vec();
    values.sort_by(f64::total_cmp);
    let is_gap = |i: &usize| apart(values[*i - 1], values[*i], scale);
    let Some(last) = (1..values.len()).rev().find(is_gap) else { return Ok(true) };
    Ok(below(0.5 * (values[last - 1] + values[last]))? == last)
}

/// Returns whether no eigenvalue that is nearer to a shift than the farthest of `values` (any
/// order) is missing among them. Eigenvalues as far from the shift as the farthest, to within what
/// can be counted apart, may be missing. `below` counts the eigenvalues below a shift.
pub(crate) fn is_complete_around(
    values: &[f64],
    shift: f64,
    scale: f64,
    below: impl Fn(f64) -> Result<usize>,
) -> Result<bool> {
    let mut distances: Vec<f64> = values.iter().map(|value| (value - shift).abs()).collect();
    distances.sort_by(f64::total_cmp);
    let Some(farthest) = distances.last() else { return Ok(true) };
    let margin = APART * (shift.abs() + farthest + scale);
    // The ends of the counted interval are apart from all values.
    let nearer = |i: usize| if i == 0 { 0.0 } else { distances[i - 1] };
    let is_gap = |i: &usize| distances[*i] - nearer(*i) > 2.0 * margin;
    let Some(inside) = (0..distances.len()).rev().find(is_gap) else { return Ok(true) };
    let radius = distances[inside] - margin;
    Ok(below(shift + radius)?.checked_sub(below(shift - radius)?) == Some(inside))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns whether values are complete around a shift, in the given spectrum.
    fn is_complete(values: &[f64], shift: f64, spectrum: &[f64]) -> bool {
        let below = |end: f64| Ok(spectrum.iter().filter(|value| **value < end).count());
        is_complete_around(values, shift, 1e-3, below).unwrap()
    }

    #[test]
    fn what_is_nearer_to_the_shift_than_the_farthest_value_must_be_there() {
        let spectrum = [1.0, 1.0, 1.0, 1.0, 2.0, 3.0, 3.0, 3.0, 7.0];
        // Any of equally far ones.
        assert!(is_complete(&[1.0; 2], 0.5, &spectrum));
        assert!(is_complete(&[2.0, 3.0], 2.1, &spectrum));
        assert!(is_complete(&[2.0, 1.0, 3.0], 2.0, &spectrum));
        assert!(is_complete(&[3.0; 3], 3.0, &spectrum));
        assert!(is_complete(&[], 3.0, &spectrum));
        // The nearest, one in the middle, or some of equal ones are missing, on either side.
        assert!(!is_complete(&[2.0], 1.1, &spectrum));
        assert!(!is_complete(&[1.0, 3.0], 1.9, &spectrum));
        assert!(!is_complete(&[1.0, 1.0, 1.0, 2.0], 0.5, &spectrum));
        assert!(!is_complete(&[3.0, 3.0, 2.0], 3.4, &spectrum));
    }
}
