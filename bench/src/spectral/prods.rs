//! The baseline "prods" (Nogneng et al. 2018), with the published tolerance and with others.

/// Share of the largest singular value up to which others are rounding errors: that of MATLAB's
/// `pinv` for about 10^4 rows, which the code published with the thesis uses for approximation.
pub const ROUNDING: f64 = 2e-12;

/// Tolerances to try besides the published one.
pub const TOLERANCES: [f64; 11] =
    [ROUNDING, 1e-9, 1e-6, 1e-4, 1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.2, 0.4];

/// Returns the tolerance of the published code for transfer with `k` eigenfunctions besides the
/// constant: 2e-3 times the number of eigenfunctions, the constant included, minus two.
pub fn published(k: usize) -> f64 {
    2e-3 * (k as f64 - 1.0)
}

/// Returns the published tolerance, then all others of [`TOLERANCES`].
pub fn tolerances(published: f64) -> impl Iterator<Item = f64> {
    let others = TOLERANCES.into_iter().filter(move |&tolerance| tolerance != published);
    std::iter::once(published).chain(others)
}

/// Errors of the baseline by tolerance.
#[derive(Debug, Clone)]
pub struct Sweep {
    /// The tolerances, as from [`tolerances`].
    pub tolerances: Vec<f64>,
    /// A row for each tolerance, an error for each kind of function.
    pub errors: Vec<Vec<f64>>,
}

impl Sweep {
    /// Splits the columns of the tolerances from the end of each row of a table of errors, which
    /// has a row for each kind of function.
    pub fn split(published: f64, rows: &mut [Vec<f64>]) -> Self {
        let tolerances: Vec<f64> = tolerances(published).collect();
        let count = tolerances.len();
        let columns: Vec<Vec<f64>> =
            rows.iter_mut().map(|row| row.split_off(row.len() - count)).collect();
        let errors = (0..count).map(|t| columns.iter().map(|c| c[t]).collect()).collect();
        Self { tolerances, errors }
    }

    /// Returns the error with the published tolerance.
    pub fn published(&self, function: usize) -> f64 {
        self.errors[0][function]
    }

    /// Returns the least error with any tolerance.
    pub fn best(&self, function: usize) -> f64 {
        self.errors.iter().map(|errors| errors[function]).fold(f64::INFINITY, f64::min)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_of_tolerances_are_split_off() {
        let count = TOLERANCES.len() + 1;
        let row = |first: f64| -> Vec<f64> {
            [0.5, 0.25].into_iter().chain((0..count).map(|t| first - t as f64)).collect()
        };
        let mut rows = vec![row(20.0), row(30.0)];
        let sweep = Sweep::split(published(30), &mut rows);
        assert_eq!(rows, [[0.5, 0.25], [0.5, 0.25]]);
        assert_eq!((sweep.tolerances[0], sweep.tolerances[1]), (0.058, ROUNDING));
        assert_eq!((sweep.published(1), sweep.errors[3][0]), (30.0, 17.0));
        assert_eq!(sweep.best(0), 20.0 - TOLERANCES.len() as f64);
    }
}
