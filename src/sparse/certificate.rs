use faer::prelude::ReborrowMut;
use faer::{Mat, MatRef};
use sprs::CsMatView;

use super::Mass;
use super::product::multiply_by_differences;
use crate::base::{Par, Result};

/// Columns that are looked at together.
const COLUMNS: usize = 8;

/// Roundings of each entry of W phi that no solver can do without, in units of epsilon.
pub(crate) const ROUNDINGS: f64 = 8.0;

/// How good pairs are.
pub(crate) struct Certificate {
    /// Those of [`super::Eigenpairs`].
    pub residuals: Vec<f64>,
    /// The largest of them.
    pub largest: f64,
    /// The largest of them as a part of what it may be: 1 or less is good; infinite where one is not a number.
    pub excess: f64,
}

/// The certificate of pairs for residuals of `tolerance`, or of so many `roundings` of phi, where that is more:
/// `eps | |W| |phi| |` each in place of `|W phi - lambda M phi|` (Oettli and Prager 1964). `scale` is the s of
/// [`super::Eigenpairs`].
pub(crate) fn certify(
    stiffness: CsMatView<'_, f64>,
    mass: &Mass,
    values: &[f64],
    vectors: MatRef<'_, f64>,
    scale: f64,
    (tolerance, roundings): (f64, f64),
    par: Par,
) -> Result<Certificate> {
    let mut found =
        Certificate { residuals: Vec::with_capacity(values.len()), largest: 0.0, excess: 0.0 };
    let mut w = Mat::zeros(vectors.nrows(), COLUMNS.min(values.len()));
    let mut m = w.clone();
    for (chunk, values) in values.chunks(COLUMNS).enumerate() {
        let x = vectors.subcols(chunk * COLUMNS, values.len());
        let mut w = w.as_mut().subcols_mut(0, values.len());
        let mut m = m.as_mut().subcols_mut(0, values.len());
        multiply_by_differences(stiffness, x, w.rb_mut(), par);
        mass.multiply(x, m.rb_mut(), par)?;
        for (j, value) in values.iter().enumerate() {
            let (mut left, mut right, mut gap) = (0.0f64, 0.0f64, 0.0f64);
            for i in 0..x.nrows() {
                let (w, m) = (w[(i, j)], m[(i, j)]);
                left += w * w;
                right += m * m;
                gap += (w - value * m).powi(2);
            }
            let size = left.sqrt().max(scale * right.sqrt());
            let residual = gap.sqrt() / size;
            let mut allowed = tolerance;
            if residual > tolerance {
                let rounding = magnitude(stiffness, x.subcols(j, 1)) / size;
                allowed = allowed.max(roundings * f64::EPSILON * rounding);
            }
            let number = |x: f64| if x.is_nan() { f64::INFINITY } else { x };
            found.largest = found.largest.max(number(residual));
            found.excess = found.excess.max(number(residual / allowed));
            found.residuals.push(residual);
        }
    }
    Ok(found)
}

/// `| |W| |phi| |`.
fn magnitude(stiffness: CsMatView<'_, f64>, phi: MatRef<'_, f64>) -> f64 {
    let row_sum = |row: sprs::CsVecView<'_, f64>| -> f64 {
        row.iter().map(|(j, w)| (w * phi[(j, 0)]).abs()).sum()
    };
    stiffness.outer_iterator().map(|row| row_sum(row).powi(2)).sum::<f64>().sqrt()
}

/// Distance of two eigenvalues, relative to them, from which on they are counted apart.
const APART: f64 = 1e-6;

/// Whether two eigenvalues, the lower one first, are so far apart that a shift between them counts right.
pub(crate) fn apart(low: f64, high: f64, scale: f64) -> bool {
    high - low > APART * (high.abs() + scale)
}

/// Whether no eigenvalue is missing among `values` (any order), between two of them that are apart, as close to both
/// ends as possible; `from_below`: from the lower end of the spectrum on. `below` counts the eigenvalues below a shift.
pub(crate) fn count_is_complete(
    values: &[f64],
    from_below: bool,
    scale: f64,
    below: impl Fn(f64) -> Result<usize>,
) -> Result<bool> {
    let mut values = values.to_vec();
    values.sort_by(f64::total_cmp);
    let below = |i: usize| below(0.5 * (values[i - 1] + values[i]));
    let is_gap = |i: &usize| apart(values[*i - 1], values[*i], scale);
    let Some(last) = (1..values.len()).rev().find(is_gap) else { return Ok(true) };
    if from_below {
        return Ok(below(last)? == last);
    }
    let first = (1..values.len()).find(is_gap).expect("there is a last one");
    Ok(first == last || below(last)?.checked_sub(below(first)?) == Some(last - first))
}
