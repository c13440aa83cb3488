use faer::Mat;
use sprs::CsMatView;

use super::Mass;
use super::options::EigenOptions;
use crate::base::{Error, Result, apart};
use crate::dense::{
    SymmetricEigen, cholesky, lower_solve_in_place, symmetric_eigen, upper_solve_in_place, zeros,
};

/// Operations for all eigenpairs, in units of n^3.
const OPERATIONS: f64 = 12.0;

/// Computes all eigenpairs of a pencil that is small enough to be dense: `M = L L^T`, and the pairs
/// of `L^-1 W L^-T`. Values ascend, vectors are M-orthonormal.
pub(crate) fn dense_pairs(
    stiffness: CsMatView<'_, f64>,
    mass: &Mass,
    options: &EigenOptions<'_>,
) -> Result<(Vec<f64>, Mat<f64>)> {
    let n = stiffness.rows();
    let mut l = zeros(n, n)?;
    match mass {
        Mass::Lumped(masses) => masses.iter().enumerate().for_each(|(i, m)| l[(i, i)] = *m),
        Mass::Full(matrix) => scatter(matrix.view(), &mut l),
    }
    let mut w = zeros(n, n)?;
    scatter(stiffness, &mut w);
    options.progress.report(0.1)?;
    apart(OPERATIONS * (n as f64).powi(3), move || {
        if let Err(i) = cholesky(l.as_mut())? {
            let why = format!("not positive definite (elimination fails at row {i})");
            return Err(Error::Argument { what: "mass", why });
        }
        lower_solve_in_place(l.as_ref(), w.as_mut());
        lower_solve_in_place(l.as_ref(), w.as_mut().transpose_mut());
        let SymmetricEigen { values, mut vectors } = symmetric_eigen(w.as_ref())?;
        upper_solve_in_place(l.transpose(), vectors.as_mut());
        Ok((values, vectors))
    })?
}

fn scatter(matrix: CsMatView<'_, f64>, dense: &mut Mat<f64>) {
    for (i, row) in matrix.outer_iterator().enumerate() {
        for (j, &x) in row.iter() {
            dense[(i, j)] = x;
        }
    }
}
