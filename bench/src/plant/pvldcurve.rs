//! Minimum conductance and the point of stomatal closure as the R package pvldcurve 1.2.6 defines
//! them (Raesch 2020), for comparison.

use catamaran_simulation::plant::DryingLeaf;

/// The mass of a mole of water, in kg.
const MOLE: f64 = 18.015_28e-3;

/// The default of the package for the slope at which stomata count as closed.
const SENSITIVITY: f64 = 60.0;

/// The trust in the largest conductance, as a part of it.
const LEAST_TRUST: f64 = 1.0 / 60.0;

/// Fewest weighings after the closing from which the package takes its values.
const FEWEST: usize = 3;

/// Bounds of the rate of an exponential over the whole time.
const RATES: [f64; 2] = [0.3, 200.0];

/// What the package finds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Closure {
    /// The relative water content when stomata are closed.
    pub relative: f64,
    /// The mean conductance from then on, in mmol / (m^2 s) of one side of the leaf; the package
    /// refers to both sides. Stomata that are not quite closed contribute to it, so it is above the
    /// conductance of the cuticle alone.
    pub minimum: f64,
}

/// Finds the point of closure. The weights are smoothed by the sum of an exponential and a line;
/// the conductances between them are fitted by such a sum over the minutes, small ones with a
/// larger weight; stomata are closed when the slope of its exponential rises above `-60 b^2`, with
/// its rate b per minute. Returns `None` with fewer than three weighings after that.
pub fn closure(leaf: &DryingLeaf, seconds: &[f64]) -> Option<Closure> {
    let minutes: Vec<f64> = seconds.iter().map(|s| s / 60.0).collect();
    let smooth = Sum::fit(&minutes, &leaf.weights, &vec![1.0; minutes.len()])?;
    let weights: Vec<f64> = minutes.iter().map(|x| smooth.at(*x)).collect();
    let part = |weight: f64| (weight - leaf.dry) / (leaf.saturated - leaf.dry);
    let (mut conductances, mut contents) = (Vec::new(), Vec::new());
    for i in 1..weights.len() {
        let demand = leaf.demand[i] - leaf.demand[i - 1];
        let moles = (weights[i - 1] - weights[i]) / MOLE;
        conductances.push(1e3 * moles / (leaf.area * demand));
        contents.push(0.5 * (part(weights[i - 1]) + part(weights[i])));
    }
    let first = minutes[1];
    let minutes: Vec<f64> = minutes[1..].iter().map(|x| x - first).collect();
    let largest = conductances.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let trust: Vec<f64> =
        conductances.iter().map(|g| (largest * (1.0 + LEAST_TRUST) - g).abs()).collect();
    let sum = Sum::fit(&minutes, &conductances, &trust)?;
    // The threshold of the package is for conductances of both sides.
    let slope = |x: f64| 0.5 * (sum.exponential(x + 1.0) - sum.exponential(x));
    let last = *minutes.last()? as usize;
    let closed =
        (1..=last).map(|x| x as f64).find(|x| slope(*x) > -SENSITIVITY * sum.rate.powi(2))?;
    let after: Vec<usize> = (0..minutes.len()).filter(|&i| minutes[i] > closed).collect();
    if after.len() < FEWEST {
        return None;
    }
    // The content at the closing, on a line through those after it.
    let count = after.len() as f64;
    let mean = |values: &[f64]| after.iter().map(|&i| values[i]).sum::<f64>() / count;
    let (time, content) = (mean(&minutes), mean(&contents));
    let product = |i: &usize| (minutes[*i] - time) * (contents[*i] - content);
    let squares: f64 = after.iter().map(|&i| (minutes[i] - time).powi(2)).sum();
    let relative = content + after.iter().map(product).sum::<f64>() / squares * (closed - time);
    let below = (0..contents.len()).filter(|&i| contents[i] < relative);
    let minimum: Vec<f64> = below.map(|i| conductances[i]).chain([sum.at(closed)]).collect();
    Some(Closure { relative, minimum: minimum.iter().sum::<f64>() / minimum.len() as f64 })
}

/// `a exp(-rate x) + b x + c`.
struct Sum {
    rate: f64,
    terms: [f64; 3],
}

impl Sum {
    /// Fits the sum by weighted least squares: the terms for each of many rates.
    fn fit(x: &[f64], y: &[f64], weights: &[f64]) -> Option<Self> {
        const COUNT: usize = 2000;
        let length = *x.last()?;
        let mut best: Option<(f64, Self)> = None;
        for k in 0..=COUNT {
            let part = k as f64 / COUNT as f64;
            let rate = RATES[0] * (RATES[1] / RATES[0]).powf(part);
            // Over the whole time as the unit of x, so that columns are of order 1.
            let columns = |x: f64| [(-rate * x / length).exp(), x / length, 1.0];
            let rows: Vec<[f64; 3]> = x.iter().map(|x| columns(*x)).collect();
            let entry = |i: usize, j: usize| -> f64 {
                rows.iter().zip(weights).map(|(row, weight)| weight * row[i] * row[j]).sum()
            };
            let right = |i: usize| -> f64 {
                let products = rows.iter().zip(y).zip(weights);
                products.map(|((row, y), weight)| weight * row[i] * y).sum()
            };
            let matrix = [0, 1, 2].map(|i| [0, 1, 2].map(|j| entry(i, j)));
            let right = [0, 1, 2].map(right);
            let Some(terms) = solve(matrix, right) else { continue };
            let residual =
                |(row, y): (&[f64; 3], &f64)| (0..3).map(|i| terms[i] * row[i]).sum::<f64>() - y;
            let residuals = rows.iter().zip(y).map(residual).zip(weights);
            let sum: f64 = residuals.map(|(residual, weight)| weight * residual * residual).sum();
            if best.as_ref().is_none_or(|(least, _)| sum < *least) {
                let [a, b, c] = terms;
                best = Some((sum, Self { rate: rate / length, terms: [a, b / length, c] }));
            }
        }
        best.map(|(_, sum)| sum)
    }

    fn exponential(&self, x: f64) -> f64 {
        self.terms[0] * (-self.rate * x).exp()
    }

    fn at(&self, x: f64) -> f64 {
        self.exponential(x) + self.terms[1] * x + self.terms[2]
    }
}

/// Solves three equations by Cramer's rule; returns `None` for a singular matrix.
fn solve(matrix: [[f64; 3]; 3], right: [f64; 3]) -> Option<[f64; 3]> {
    let determinant = |m: &[[f64; 3]; 3]| {
        m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1])
            - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
            + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])
    };
    let whole = determinant(&matrix);
    let column = |k: usize| {
        let mut replaced = matrix;
        (0..3).for_each(|i| replaced[i][k] = right[i]);
        determinant(&replaced) / whole
    };
    let terms = [0, 1, 2].map(column);
    terms.iter().all(|term| term.is_finite()).then_some(terms)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_leaf_that_closes_by_the_law_of_the_package_has_its_minimum() {
        // 40 mmol / (m^2 s) that decay in an hour to 3, of one side.
        let seconds: Vec<f64> = (0..40).map(|i| 900.0 * f64::from(i)).collect();
        let (area, deficit) = (0.012, 0.018);
        let lost = |s: f64| {
            let integral = 3.0 * s + 40.0 * 3600.0 * (1.0 - (-s / 3600.0).exp());
            1e-3 * integral * area * deficit * MOLE
        };
        let leaf = DryingLeaf {
            name: String::new(),
            demand: seconds.iter().map(|s| deficit * s).collect(),
            weights: seconds.iter().map(|s| 6e-3 - lost(*s)).collect(),
            dry: 5e-4,
            saturated: 6e-3,
            area,
        };
        let found = closure(&leaf, &seconds).unwrap();
        assert!((found.minimum - 3.0).abs() < 0.5, "{found:?}");
        let end = (leaf.weights[39] - leaf.dry) / (leaf.saturated - leaf.dry);
        assert!(found.relative > end && found.relative < 0.95, "{found:?}");
        assert!(closure(&leaf, &seconds[..1]).is_none());
    }
}
