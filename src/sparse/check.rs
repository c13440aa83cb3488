use sprs::CsMatView;

use crate::base::{Error, Result};

/// Asymmetry that is still rounding, relative to the entries and to the diagonal.
const SYMMETRY: f64 = 1e-10;

/// Whether the matrix is square, finite and symmetric; errors name `what` and the entry.
pub(crate) fn check_symmetric(what: &'static str, matrix: CsMatView<'_, f64>) -> Result<()> {
    let n = matrix.rows();
    Error::check_shape(what, (n, n), matrix.shape())?;
    let mut diagonal = vec![0.0; n];
    for (i, row) in matrix.outer_iterator().enumerate() {
        for (j, &x) in row.iter() {
            if !x.is_finite() {
                return Err(Error::NonFinite { what, index: (i, j) });
            }
            if i == j {
                diagonal[i] = x.abs();
            }
        }
    }
    for (i, row) in matrix.outer_iterator().enumerate() {
        for (j, &x) in row.iter().filter(|&(j, _)| j != i) {
            let mirrored = matrix.outer_view(j).and_then(|row| row.get(i).copied()).unwrap_or(0.0);
            let scale = x.abs().max(mirrored.abs()) + (diagonal[i] * diagonal[j]).sqrt();
            if (x - mirrored).abs() > SYMMETRY * scale {
                let why =
                    format!("not symmetric: entry ({i}, {j}) is {x:e}, ({j}, {i}) is {mirrored:e}");
                return Err(Error::Argument { what, why });
            }
        }
    }
    Ok(())
}
