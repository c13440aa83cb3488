use faer::Mat;

use super::diffusion::WaterModel;
use catamaran::base::{Result, at_least_zero, zeros};
use catamaran::dense::{self, SymmetricEigen, symmetric_eigen};

/// The solution by eigenvalues (thesis, equations 4.6 and 4.7) of the symmetric matrix
/// `D^(-1/2) S D^(1/2)`, with real numbers and orthonormal vectors, and without an inverse.
///
/// It costs O(n^3) once and O(n^2) for each time, for small plants and for the analysis of modes.
/// The error of dense eigenvalues is the rounding error of the largest one, so slow rates of a
/// stiff plant have few correct digits; [`WaterModel::water_after`] has no such limit.
///
/// ```
/// use catamaran::Par;
/// use catamaran_simulation::plant::{SpectralSolution, WaterModel, WaterOptions, families};
///
/// let model = WaterModel::new(&families::chain(20, 0.3, 1e-3)?, &WaterOptions::new())?;
/// let (full, solution) = (model.full(), SpectralSolution::new(&model)?);
/// let exact = model.water_after(&full, 600.0, Par::Seq)?;
/// let found = solution.water_after(&full, 600.0)?;
/// assert!(found.iter().zip(&exact).all(|(x, y)| (x / y - 1.0).abs() < 1e-6));
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct SpectralSolution {
    model: WaterModel,
    /// Rates, ascending, in 1 / s.
    rates: Vec<f64>,
    modes: Mat<f64>,
}

impl SpectralSolution {
    /// Decomposes the matrix of the model, n x n.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`](catamaran::Error::OutOfMemory),
    /// [`Error::NotConverged`](catamaran::Error::NotConverged).
    pub fn new(model: &WaterModel) -> Result<Self> {
        let n = model.len();
        let roots: Vec<f64> = model.full.iter().map(|m| m.sqrt()).collect();
        let mut matrix = dense::zeros(n, n)?;
        for k in 0..n {
            matrix[(k, k)] += model.losses[k];
            if let Some(p) = model.order.parent(k) {
                let w = model.exchange[k];
                matrix[(k, k)] += w / model.full[k];
                matrix[(p, p)] += w / model.full[p];
                matrix[(k, p)] -= w / (roots[k] * roots[p]);
                matrix[(p, k)] = matrix[(k, p)];
            }
        }
        let SymmetricEigen { values, vectors } = symmetric_eigen(matrix.as_ref())?;
        // Rates below zero are rounding errors.
        let rates = values.into_iter().map(|x| x.max(0.0)).collect();
        Ok(Self { model: model.clone(), rates, modes: vectors })
    }

    /// Returns the rates of decay of the modes, ascending, in 1 / s.
    pub fn rates(&self) -> &[f64] {
        &self.rates
    }

    /// Computes the water of every node, as [`WaterModel::water_after`] does.
    ///
    /// # Errors
    /// As [`WaterModel::water_after`].
    pub fn water_after(&self, water: &[f64], seconds: f64) -> Result<Vec<f64>> {
        at_least_zero("seconds", seconds)?;
        let mut relative = self.model.relative_by_positions(water)?;
        let n = relative.len();
        let roots: Vec<f64> = self.model.full.iter().map(|m| m.sqrt()).collect();
        let root = self.model.root();
        let mut result: Vec<f64> = zeros(n)?;
        for (j, &rate) in self.rates.iter().enumerate() {
            let mode = self.modes.col(j);
            let part: f64 = (0..n).map(|k| mode[k] * relative[k] * roots[k]).sum();
            // The water that the root took in, decayed since then.
            let z = rate * seconds;
            let worn = if z == 0.0 { seconds } else { -(-z).exp_m1() / rate };
            let intake = self.model.intake / roots[root] * mode[root] * worn;
            let amount = part * (-z).exp() + intake;
            for k in 0..n {
                result[k] += amount * mode[k];
            }
        }
        for k in 0..n {
            relative[k] = result[k] / roots[k];
        }
        Ok(self.model.water_by_nodes(&relative))
    }
}
