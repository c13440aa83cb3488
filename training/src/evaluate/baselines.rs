use catamaran::Result;
use catamaran::faer::Mat;
use catamaran::faer::linalg::solvers::SolveLstsq;
use catamaran_geometry::unions::K;
use catamaran_geometry::unions::network::sum;

use super::Predictor;
use crate::dataset::Spectrum;
use crate::mlp::{Mlp, Schedule};
use crate::train::Pair;

/// Predicts the upper bound: the smaller one of the two eigenvalues.
pub struct Minimum;

impl Predictor for Minimum {
    fn name(&self) -> &str {
        "minimum"
    }

    fn predict(&self, first: &Spectrum, second: &Spectrum) -> Result<Spectrum> {
        Ok(std::array::from_fn(|i| first[i].min(second[i])))
    }
}

/// Predicts by Weyl's law (1911): eigenvalues grow as 4 pi i / area. The areas of the parts are
/// computed from their last eigenvalues, the area of the union is a linear function of them, and
/// the mean spectrum of the unions of the training is scaled to it.
pub struct Weyl {
    /// Factors of the smaller and of the larger area.
    factors: [f64; 2],
    /// Means of eigenvalue times area.
    shape: [f64; K],
}

/// Returns the area that a spectrum implies, up to a factor.
fn area(spectrum: &Spectrum) -> f64 {
    1.0 / spectrum[K - 1]
}

fn areas(first: &Spectrum, second: &Spectrum) -> [f64; 2] {
    let (a, b) = (area(first), area(second));
    [a.min(b), a.max(b)]
}

impl Weyl {
    /// Fits the factors (by least squares) and the means.
    pub fn fit(pairs: &[Pair]) -> Self {
        let a = Mat::from_fn(pairs.len(), 2, |i, j| areas(&pairs[i].first, &pairs[i].second)[j]);
        let b = Mat::from_fn(pairs.len(), 1, |i, _| area(&pairs[i].union));
        let found = a.qr().solve_lstsq(b);
        let count = pairs.len().max(1) as f64;
        let shape = std::array::from_fn(|i| {
            pairs.iter().map(|pair| pair.union[i] * area(&pair.union)).sum::<f64>() / count
        });
        Self { factors: [found[(0, 0)], found[(1, 0)]], shape }
    }
}

impl Predictor for Weyl {
    fn name(&self) -> &str {
        "Weyl area"
    }

    fn predict(&self, first: &Spectrum, second: &Spectrum) -> Result<Spectrum> {
        let [small, large] = areas(first, second);
        let area = (self.factors[0] * small + self.factors[1] * large).max(large);
        Ok(self.shape.map(|x| x / area))
    }
}

/// Predicts the union of the nearest pair of the training: the one whose logarithms of eigenvalues
/// are nearest, in either order of the parts.
pub struct Nearest {
    pairs: Vec<([f32; 2 * K], Spectrum)>,
}

fn logarithms(first: &Spectrum, second: &Spectrum) -> [f32; 2 * K] {
    std::array::from_fn(|j| if j < K { first[j] } else { second[j - K] }.ln() as f32)
}

impl Nearest {
    /// Stores the pairs.
    pub fn fit(pairs: &[Pair]) -> Self {
        let entry = |pair: &Pair| (logarithms(&pair.first, &pair.second), pair.union);
        Self { pairs: pairs.iter().map(entry).collect() }
    }
}

impl Predictor for Nearest {
    fn name(&self) -> &str {
        "nearest pair"
    }

    fn predict(&self, first: &Spectrum, second: &Spectrum) -> Result<Spectrum> {
        let queries = [logarithms(first, second), logarithms(second, first)];
        let mut best = (f32::INFINITY, *first);
        for (pair, union) in &self.pairs {
            for query in &queries {
                let distance = sum(2 * K, |j| (pair[j] - query[j]) * (pair[j] - query[j]));
                if distance < best.0 {
                    best = (distance, *union);
                }
            }
        }
        Ok(best.1)
    }
}

/// A plain perceptron. Its inputs are the offsets of both spectra, and its outputs are the offsets
/// of the union, each in units of its deviation. The training minimizes the squared errors of the
/// spectra, with the pairs in both orders.
pub struct Perceptron {
    mlp: Mlp,
    inputs: Units,
    outputs: Units,
}

/// Means and deviations, which define the units.
struct Units {
    mean: Vec<f32>,
    deviation: Vec<f32>,
}

impl Units {
    fn of(rows: &[Vec<f32>]) -> Self {
        let count = rows.len().max(1) as f32;
        let width = rows.first().map_or(0, Vec::len);
        let mean: Vec<f32> =
            (0..width).map(|j| rows.iter().map(|row| row[j]).sum::<f32>() / count).collect();
        let deviation = (0..width)
            .map(|j| {
                let squares: f32 = rows.iter().map(|row| (row[j] - mean[j]).powi(2)).sum();
                (squares / count).sqrt().max(1e-3 * mean[j].abs()).max(f32::MIN_POSITIVE)
            })
            .collect();
        Self { mean, deviation }
    }

    fn scaled(&self, row: &[f32]) -> Vec<f32> {
        let units = self.mean.iter().zip(&self.deviation);
        row.iter().zip(units).map(|(x, (mean, deviation))| (x - mean) / deviation).collect()
    }
}

fn offsets(spectrum: &Spectrum) -> impl Iterator<Item = f32> {
    let before = std::iter::once(0.0).chain(*spectrum);
    before.zip(*spectrum).map(|(before, x)| (x - before) as f32)
}

impl Perceptron {
    /// Trains the perceptron.
    ///
    /// # Errors
    /// None in practice.
    pub fn fit(pairs: &[Pair], epochs: usize, seed: u64) -> Result<Self> {
        let rows: Vec<Vec<f32>> = pairs
            .iter()
            .flat_map(|p| [(&p.first, &p.second), (&p.second, &p.first)])
            .map(|(a, b)| offsets(a).chain(offsets(b)).collect())
            .collect();
        let inputs = Units::of(&rows);
        let rows: Vec<Vec<f32>> = rows.iter().map(|row| inputs.scaled(row)).collect();
        let unions: Vec<Vec<f32>> = pairs.iter().map(|p| offsets(&p.union).collect()).collect();
        let outputs = Units::of(&unions);
        let largest = unions.iter().flatten().sum::<f32>() / unions.len().max(1) as f32;
        let mut mlp = Mlp::new(&[2 * K, 128, 128, K], seed);
        let schedule = Schedule { epochs, rate: 1e-3, batch: 64, seed };
        mlp.train(
            rows.len(),
            &schedule,
            |i, _| rows[i].clone(),
            |i, found, gradient| {
                // Sums of offsets minus those of the true spectrum, in units of the mean largest
                // eigenvalue.
                let mut error = 0.0;
                let errors: Vec<f32> = (0..K)
                    .map(|j| {
                        let offset = found[j] * outputs.deviation[j] + outputs.mean[j];
                        error += (offset - unions[i / 2][j]) / largest;
                        error
                    })
                    .collect();
                let mut sum = 0.0;
                for j in (0..K).rev() {
                    sum += errors[j];
                    gradient[j] = 2.0 * sum * outputs.deviation[j] / largest;
                }
                errors.iter().map(|e| f64::from(e * e)).sum()
            },
            |_, _| Ok(()),
        )?;
        Ok(Self { mlp, inputs, outputs })
    }
}

impl Predictor for Perceptron {
    fn name(&self) -> &str {
        "perceptron"
    }

    fn predict(&self, first: &Spectrum, second: &Spectrum) -> Result<Spectrum> {
        let row: Vec<f32> = offsets(first).chain(offsets(second)).collect();
        let found = self.mlp.run(self.inputs.scaled(&row));
        let mut sum = 0.0;
        Ok(std::array::from_fn(|j| {
            sum += f64::from(found[j] * self.outputs.deviation[j] + self.outputs.mean[j]);
            sum
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::super::errors;
    use super::*;

    /// Returns unions whose area is 0.5 times the smaller area plus the larger one, all of the same
    /// shape.
    fn scaled() -> Vec<Pair> {
        let of_area = |area: f64| std::array::from_fn(|i| (i + 1) as f64 / area);
        let areas = (0..40).map(|i| (1.0 + 0.1 * f64::from(i % 7), 2.0 + 0.3 * f64::from(i % 5)));
        areas
            .map(|(a, b)| Pair {
                first: of_area(a),
                second: of_area(b),
                union: of_area(0.5 * a + b),
                regions: None,
            })
            .collect()
    }

    #[test]
    fn weyl_is_exact_where_areas_are_all() {
        let pairs = scaled();
        let found = errors(&Weyl::fit(&pairs[..20]), &pairs[20..]).unwrap();
        assert!(found.relative < 1e-10, "{found:?}");
    }

    #[test]
    fn the_nearest_pair_is_found_in_both_orders() {
        let pairs = scaled();
        let nearest = Nearest::fit(&pairs);
        let Pair { first, second, union, .. } = pairs[3];
        assert_eq!(nearest.predict(&second, &first).unwrap(), union);
    }

    #[test]
    fn a_perceptron_learns_them() {
        let pairs = scaled();
        let before = errors(&Minimum, &pairs).unwrap();
        let after = errors(&Perceptron::fit(&pairs, 60, 1).unwrap(), &pairs).unwrap();
        assert!(after.mse < 0.1 * before.mse && after.pairs == 40, "{before:?} {after:?}");
    }
}
