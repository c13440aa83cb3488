//! Theorem 1.1 and figures 1.4 and 1.5: Dirichlet energies of eigenproducts.

use catamaran::Par;
use catamaran::faer::{Mat, Scale};
use catamaran_geometry::spectral::{Eigenproducts, dirichlet_energies};

use super::shapes::Shape;
use crate::Result;
use crate::curves::Plot;

/// Returns the largest relative error of equation 1.5, `E(phi_i^N) = N^2 / (2 N - 1) lambda_i`,
/// over the first eigenfunctions, for each order from 2 on.
///
/// # Errors
/// The errors of the library.
pub fn eigenpowers(shape: &Shape, functions: usize, orders: usize) -> Result<Vec<f64>> {
    let basis = shape.first(functions)?;
    (2..=orders)
        .map(|order| {
            let phi = basis.functions().subcols(1, functions);
            let powers =
                Mat::from_fn(phi.nrows(), functions, |x, i| phi[(x, i)].powi(order as i32));
            let mass = basis.basis().mass();
            let energies = dirichlet_energies(powers.as_ref(), shape.stiffness.view(), mass)?;
            let factor = (order * order) as f64 / (2 * order - 1) as f64;
            let errors = energies.iter().zip(&basis.values()[1..]);
            Ok(errors.map(|(e, lambda)| (e / (factor * lambda) - 1.0).abs()).fold(0.0, f64::max))
        })
        .collect()
}

/// Figure 1.4 for an order: the positions of the first N K eigenvalues, in ascending order from the
/// first that is not zero, relative to the frequencies of products.
#[derive(Debug, Clone)]
pub struct Frequencies {
    /// The relative distance of each eigenvalue to the nearest frequency.
    pub distances: Vec<f64>,
    /// The expected distance of each eigenvalue for randomly scattered frequencies: half of their
    /// mean gap from the fifth previous eigenvalue to the fifth next one, relative to the
    /// eigenvalue; 0 for the first K, which are products themselves.
    pub expected: Vec<f64>,
}

impl Frequencies {
    /// Returns the means of the distances and of the expected ones.
    pub fn means(&self) -> [f64; 2] {
        [&self.distances, &self.expected]
            .map(|all| all.iter().sum::<f64>() / all.len().max(1) as f64)
    }

    /// Returns the numbers, from 1, of the `count` eigenvalues with the largest distances, the
    /// largest first.
    pub fn farthest(&self, count: usize) -> Vec<usize> {
        let mut numbers: Vec<usize> = (1..=self.distances.len()).collect();
        numbers.sort_by(|&a, &b| self.distances[b - 1].total_cmp(&self.distances[a - 1]));
        numbers.truncate(count);
        numbers
    }

    /// Returns the share of these eigenvalues in the sum of the distances.
    pub fn share(&self, numbers: &[usize]) -> f64 {
        let sum: f64 = numbers.iter().map(|&i| self.distances[i - 1]).sum();
        sum / self.distances.iter().sum::<f64>().max(f64::MIN_POSITIVE)
    }
}

/// Computes figure 1.4: for every one of the first N K eigenvalues, the relative distance to the
/// nearest frequency of a product of at most N of K functions; and figure 1.5, drawn for order 2:
/// energies over the sums of the eigenvalues.
///
/// # Errors
/// The errors of the library.
pub fn frequencies(shape: &Shape, k: usize, orders: usize) -> Result<(Vec<Frequencies>, Plot)> {
    let basis = shape.first(k)?;
    let constant = basis.constant().ok_or("the constant is not among the eigenfunctions")?;
    let factors = Scale(1.0 / constant) * basis.functions().subcols(1, k);
    let mass = basis.basis().mass();
    let mut distances = Vec::new();
    let mut scatter = Vec::new();
    for order in 1..=orders {
        let products = Eigenproducts::new(k, order)?;
        let mut values = Mat::zeros(factors.nrows(), products.len());
        products.evaluate(factors.as_ref(), values.as_mut(), Par::all())?;
        let energies = dirichlet_energies(values.as_ref(), shape.stiffness.view(), mass)?;
        let nearest = |lambda: f64| {
            energies.iter().map(|e| (lambda - e).abs() / lambda).fold(f64::INFINITY, f64::min)
        };
        let values = &shape.eigenbasis.values()[1..];
        let expected = |i: usize| {
            let (low, high) = (values[i.saturating_sub(5)], values[(i + 5).min(order * k - 1)]);
            let beside = energies.iter().filter(|e| (low..=high).contains(e)).count().max(1);
            if i < k { 0.0 } else { (high - low) / (2 * beside) as f64 / values[i] }
        };
        distances.push(Frequencies {
            distances: values[..order * k].iter().map(|&lambda| nearest(lambda)).collect(),
            expected: (0..order * k).map(expected).collect(),
        });
        if order == 2 {
            let sum = |index: usize| {
                let factors = products.factors(index).unwrap_or_default();
                factors.iter().map(|&i| basis.values()[i]).sum::<f64>()
            };
            scatter = (1..products.len()).map(|i| (sum(i), energies[i])).collect();
        }
    }
    let ends = scatter.iter().map(|&(x, _)| x).fold(0.0, f64::max);
    let plot = Plot {
        title: format!("Figure 1.5, {}: energies of products of order 2", shape.name),
        across: "sum of eigenvalues".into(),
        logarithmic: false,
        scattered: true,
        series: vec![
            ("energy".into(), scatter),
            ("sum".into(), (0..=40).map(|i| ends * f64::from(i) / 40.0).map(|x| (x, x)).collect()),
        ],
    };
    Ok((distances, plot))
}
