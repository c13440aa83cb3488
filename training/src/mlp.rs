//! Multilayer perceptrons with rectified hidden layers, and their training, for the baseline and
//! the decoder of regions.

use catamaran::Result;
use catamaran::base::Rng;
use catamaran_geometry::unions::network::gemm;

use crate::adam::{Adam, annealing, clip};

/// A perceptron: for each layer the weights, inputs x outputs by rows, and a bias for each output.
#[derive(Debug, Clone, PartialEq)]
pub struct Mlp {
    /// Numbers of neurons, from the inputs to the outputs.
    pub widths: Vec<usize>,
    /// Weights and bias of each layer, one after the other.
    pub parameters: Vec<f32>,
}

/// Options of the training of a perceptron.
#[derive(Debug, Clone, Copy)]
pub struct Schedule {
    /// Number of passes over the data.
    pub epochs: usize,
    /// Largest learning rate, of [`annealing`].
    pub rate: f64,
    /// Number of examples per step.
    pub batch: usize,
    /// Seed of the weights and of the order of the examples.
    pub seed: u64,
}

impl Mlp {
    /// Creates a perceptron with random weights (He et al. 2015) and biases of zero.
    pub fn new(widths: &[usize], seed: u64) -> Self {
        let mut rng = Rng::new(seed);
        let mut parameters = Vec::new();
        for pair in widths.windows(2) {
            let deviation = (2.0 / pair[0] as f64).sqrt();
            parameters.extend((0..pair[0] * pair[1]).map(|_| (deviation * rng.normal()) as f32));
            parameters.extend(vec![0.0; pair[1]]);
        }
        Self { widths: widths.to_vec(), parameters }
    }

    /// Returns the outputs of every layer for rows of inputs; the inputs come first.
    fn layers(&self, inputs: Vec<f32>) -> Vec<Vec<f32>> {
        let mut start = 0;
        let mut all = vec![inputs];
        let last = self.widths.len() - 2;
        for (layer, pair) in self.widths.windows(2).enumerate() {
            let (inner, columns) = (pair[0], pair[1]);
            let weights = &self.parameters[start..start + inner * columns];
            let bias = &self.parameters[start + inner * columns..][..columns];
            start += (inner + 1) * columns;
            let x = &all[layer];
            let rows = x.len() / inner;
            let mut y = bias.repeat(rows);
            gemm((rows, inner, columns), x, (inner, 1), weights, &mut y);
            if layer < last {
                y.iter_mut().for_each(|y| *y = y.max(0.0));
            }
            all.push(y);
        }
        all
    }

    /// Returns the outputs for rows of inputs.
    pub fn run(&self, inputs: Vec<f32>) -> Vec<f32> {
        self.layers(inputs).pop().unwrap_or_default()
    }

    /// Returns the gradient with respect to the parameters, computed from the outputs of the layers
    /// and the gradient with respect to the outputs of the perceptron.
    fn gradient(&self, layers: &[Vec<f32>], mut dy: Vec<f32>) -> Vec<f32> {
        let mut gradient = vec![0.0; self.parameters.len()];
        let mut end = self.parameters.len();
        for (layer, pair) in self.widths.windows(2).enumerate().rev() {
            let (inner, columns) = (pair[0], pair[1]);
            let start = end - (inner + 1) * columns;
            let (weights, bias) = gradient[start..end].split_at_mut(inner * columns);
            let rows = dy.len() / columns;
            for row in dy.chunks_exact(columns) {
                bias.iter_mut().zip(row).for_each(|(sum, g)| *sum += g);
            }
            gemm((inner, rows, columns), &layers[layer], (1, inner), &dy, weights);
            if layer > 0 {
                let weights = &self.parameters[start..start + inner * columns];
                let transposed: Vec<f32> = (0..inner * columns)
                    .map(|at| weights[at % inner * columns + at / inner])
                    .collect();
                let mut dx = vec![0.0; rows * inner];
                gemm((rows, columns, inner), &dy, (columns, 1), &transposed, &mut dx);
                for (gradient, &value) in dx.iter_mut().zip(&layers[layer]) {
                    *gradient = if value > 0.0 { *gradient } else { 0.0 };
                }
                dy = dx;
            }
            end = start;
        }
        gradient
    }

    /// Trains on `count` examples. `inputs(i)` returns the inputs of example i, and
    /// `loss(i, outputs, gradient)` returns its loss and writes the gradient. After each epoch,
    /// `watch(epoch, mean loss)` is called.
    ///
    /// # Errors
    /// The errors of `watch`.
    pub fn train(
        &mut self,
        count: usize,
        schedule: &Schedule,
        mut inputs: impl FnMut(usize, &mut Rng) -> Vec<f32>,
        loss: impl Fn(usize, &[f32], &mut [f32]) -> f64,
        mut watch: impl FnMut(usize, f64) -> Result<()>,
    ) -> Result<()> {
        let mut adam = Adam::new(self.parameters.len());
        let outputs = self.widths.last().copied().unwrap_or(0);
        for epoch in 0..schedule.epochs {
            let mut rng = Rng::new(schedule.seed ^ (epoch as u64) << 32);
            let order = shuffled(count, &mut rng);
            let mut total = 0.0;
            for (step, batch) in order.chunks(schedule.batch).enumerate() {
                let rows: Vec<f32> = batch.iter().flat_map(|&i| inputs(i, &mut rng)).collect();
                let layers = self.layers(rows);
                let found = &layers[layers.len() - 1];
                let mut dy = vec![0.0; found.len()];
                for ((&i, found), dy) in
                    batch.iter().zip(found.chunks(outputs)).zip(dy.chunks_mut(outputs))
                {
                    total += loss(i, found, dy);
                }
                dy.iter_mut().for_each(|g| *g /= batch.len() as f32);
                let mut gradient = self.gradient(&layers, dy);
                clip(&mut gradient, 10.0);
                let time = epoch as f64 + (step * schedule.batch) as f64 / count as f64;
                let rate = schedule.rate * annealing(time / schedule.epochs as f64);
                adam.step(&mut self.parameters, &gradient, rate as f32, 1e-5);
            }
            watch(epoch, total / count.max(1) as f64)?;
        }
        Ok(())
    }
}

/// Returns `0..n` in random order (Fisher and Yates).
pub fn shuffled(n: usize, rng: &mut Rng) -> Vec<usize> {
    let mut order: Vec<usize> = (0..n).collect();
    for i in (1..n).rev() {
        order.swap(i, (rng.uniform() * (i + 1) as f64) as usize);
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gradients_are_those_of_finite_differences() {
        let mut mlp = Mlp::new(&[3, 5, 4, 2], 1);
        let mut rng = Rng::new(2);
        mlp.parameters.iter_mut().for_each(|x| *x += 0.1 * rng.normal() as f32);
        let inputs: Vec<f32> = (0..12).map(|_| rng.normal() as f32).collect();
        let value = |mlp: &Mlp| -> f64 {
            mlp.run(inputs.clone()).iter().enumerate().map(|(i, &y)| i as f64 * f64::from(y)).sum()
        };
        let layers = mlp.layers(inputs.clone());
        let gradient = mlp.gradient(&layers, (0..8).map(|i| i as f32).collect());
        for at in 0..mlp.parameters.len() {
            let before = mlp.parameters[at];
            let mut at_step = |step: f32| {
                mlp.parameters[at] = before + step;
                value(&mlp)
            };
            let slope = (at_step(1e-2) - at_step(-1e-2)) / 2e-2;
            mlp.parameters[at] = before;
            let error = (slope - f64::from(gradient[at])).abs();
            assert!(error < 1e-2 * (1.0 + slope.abs()), "{at}: {slope} is not {}", gradient[at]);
        }
    }

    #[test]
    fn a_product_is_learnt() {
        let mut rng = Rng::new(1);
        let data: Vec<[f32; 2]> =
            (0..200).map(|_| [rng.normal() as f32, rng.normal() as f32]).collect();
        let mut mlp = Mlp::new(&[2, 16, 1], 3);
        let schedule = Schedule { epochs: 60, rate: 1e-2, batch: 20, seed: 1 };
        let mut losses = Vec::new();
        mlp.train(
            data.len(),
            &schedule,
            |i, _| data[i].to_vec(),
            |i, y, dy| {
                dy[0] = 2.0 * (y[0] - data[i][0] * data[i][1]);
                f64::from(dy[0] * dy[0]) / 4.0
            },
            |_, loss| {
                losses.push(loss);
                Ok(())
            },
        )
        .unwrap();
        assert!(losses[59] < 0.1 * losses[0], "{} {}", losses[0], losses[59]);
    }
}
