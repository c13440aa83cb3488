use faer::prelude::ReborrowMut;
use faer::{Mat, MatRef};

use super::cholesky::{Factor, Symbolic};
use super::shifted::Shifted;
use super::space::Pencil;
use crate::base::{Par, Result};

/// Columns that are looked at together.
const COLUMNS: usize = 8;

/// The residuals of [`super::Eigenpairs`]; `scale` is its s.
pub(crate) fn residuals(
    pencil: &dyn Pencil,
    values: &[f64],
    vectors: MatRef<'_, f64>,
    scale: f64,
    par: Par,
) -> Result<Vec<f64>> {
    // Squares of |W phi|, |M phi| and |W phi - lambda M phi|.
    let mut squares = Mat::zeros(3, values.len());
    let mut w = Mat::zeros(vectors.nrows(), COLUMNS.min(values.len()));
    let mut m = w.clone();
    for (chunk, values) in values.chunks(COLUMNS).enumerate() {
        let x = vectors.subcols(chunk * COLUMNS, values.len());
        let mut w = w.as_mut().subcols_mut(0, values.len());
        let mut m = m.as_mut().subcols_mut(0, values.len());
        pencil.apply_stiffness(x, w.rb_mut(), par)?;
        pencil.inner().apply_mass(x, m.rb_mut(), par)?;
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
    let residual = |j| {
        let [left, right, gap] = [0, 1, 2].map(|i| squares[(i, j)].sqrt());
        gap / left.max(scale * right)
    };
    Ok((0..values.len()).map(residual).collect())
}

/// Distance of two eigenvalues, relative to them, from which on they are counted apart.
const APART: f64 = 1e-6;

/// Whether no eigenvalue is missing among `values` (any order), between two of them that are apart, as close to both
/// ends as possible; `from_below`: from the lower end of the spectrum on.
pub(crate) fn count_is_complete(
    symbolic: &Symbolic,
    shifted: &Shifted<'_>,
    values: &[f64],
    from_below: bool,
    scale: f64,
) -> Result<bool> {
    let mut values = values.to_vec();
    values.sort_by(f64::total_cmp);
    let below = |i: usize| {
        let middle = 0.5 * (values[i - 1] + values[i]);
        Factor::indefinite(symbolic, shifted, middle).map(|factor| factor.below_shift())
    };
    let apart = |i: &usize| values[*i] - values[i - 1] > APART * (values[*i].abs() + scale);
    let Some(last) = (1..values.len()).rev().find(apart) else { return Ok(true) };
    if from_below {
        return Ok(below(last)? == last);
    }
    let first = (1..values.len()).find(apart).expect("there is a last one");
    Ok(first == last || below(last)?.checked_sub(below(first)?) == Some(last - first))
}
