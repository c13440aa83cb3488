//! The optimizer Adam (Kingma and Ba 2015) with decoupled weight decay (Loshchilov and Hutter
//! 2019), and its learning rates.

use catamaran_geometry::unions::network::sum;
use rayon::prelude::*;

/// Number of parameters that are processed together.
pub(crate) const CHUNK: usize = 1 << 14;

/// The state of the optimizer.
#[derive(Debug, Clone, PartialEq)]
pub struct Adam {
    /// Number of steps done.
    pub steps: usize,
    /// Running means of the gradient.
    pub mean: Vec<f32>,
    /// Running means of the squares of the gradient.
    pub square: Vec<f32>,
}

const MEAN_DECAY: f32 = 0.9;
const SQUARE_DECAY: f32 = 0.999;
const SMALL: f32 = 1e-8;

impl Adam {
    /// Creates the state for `len` parameters.
    pub fn new(len: usize) -> Self {
        Self { steps: 0, mean: vec![0.0; len], square: vec![0.0; len] }
    }

    /// Does one step along the negative gradient; `decay` is the share of each parameter that is
    /// subtracted at rate 1.
    pub fn step(&mut self, parameters: &mut [f32], gradient: &[f32], rate: f32, decay: f32) {
        self.steps = self.steps.saturating_add(1);
        let descent = self.descent(rate, decay);
        descent.apply(parameters, gradient, &mut self.mean, &mut self.square);
    }

    /// Does the same as [`step`](Self::step) on the threads of the pool that calls it.
    pub fn par_step(&mut self, parameters: &mut [f32], gradient: &[f32], rate: f32, decay: f32) {
        self.steps = self.steps.saturating_add(1);
        let descent = self.descent(rate, decay);
        let states = self.mean.par_chunks_mut(CHUNK).zip(self.square.par_chunks_mut(CHUNK));
        let chunks = parameters.par_chunks_mut(CHUNK).zip(gradient.par_chunks(CHUNK));
        chunks.zip(states).for_each(|((x, g), (mean, square))| descent.apply(x, g, mean, square));
    }

    fn descent(&self, rate: f32, decay: f32) -> Descent {
        let unbiased = |decay: f32| 1.0 - decay.powi(self.steps.min(100_000) as i32);
        Descent { rate, decay, first: unbiased(MEAN_DECAY), second: unbiased(SQUARE_DECAY) }
    }
}

/// The factors of a step.
struct Descent {
    rate: f32,
    decay: f32,
    first: f32,
    second: f32,
}

impl Descent {
    fn apply(&self, x: &mut [f32], gradient: &[f32], mean: &mut [f32], square: &mut [f32]) {
        let Self { rate, decay, first, second } = *self;
        let states = mean.iter_mut().zip(square);
        for ((x, &g), (mean, square)) in x.iter_mut().zip(gradient).zip(states) {
            *mean = MEAN_DECAY * *mean + (1.0 - MEAN_DECAY) * g;
            *square = SQUARE_DECAY * *square + (1.0 - SQUARE_DECAY) * g * g;
            let step = (*mean / first) / ((*square / second).sqrt() + SMALL);
            *x -= rate * (step + decay * *x);
        }
    }
}

/// Scales the gradient down to the norm `longest` if its norm is larger; returns the norm before.
pub fn clip(gradient: &mut [f32], longest: f32) -> f32 {
    let square = |part: &[f32]| f64::from(sum(part.len(), |i| part[i] * part[i]));
    let norm = gradient.chunks(CHUNK).map(square).sum::<f64>().sqrt() as f32;
    if norm > longest {
        gradient.iter_mut().for_each(|g| *g *= longest / norm);
    }
    norm
}

/// Share of the training in which the rate rises.
const WARM_UP: f64 = 0.03;

/// Returns the share of the full learning rate when the share `done` of the training, from 0 to 1,
/// is done: it rises, then falls as half a cosine to 1 %.
pub fn annealing(done: f64) -> f64 {
    let cosine = (std::f64::consts::PI * done.min(1.0)).cos();
    (done / WARM_UP).min(1.0) * (0.01 + 0.99 * 0.5 * (1.0 + cosine))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_rise_and_fall_to_a_hundredth() {
        for (done, share) in [(0.0, 0.0), (0.5, 0.505), (1.0, 0.01), (2.0, 0.01)] {
            assert!((annealing(done) - share).abs() < 1e-12);
        }
    }

    #[test]
    fn a_parabola_is_descended() {
        let mut adam = Adam::new(2);
        let mut x = [3.0, -2.0];
        for _ in 0..2000 {
            let gradient = [x[0] - 1.0, 10.0 * (x[1] - 0.5)];
            adam.step(&mut x, &gradient, 1e-2, 0.0);
        }
        assert!((x[0] - 1.0).abs() < 1e-3 && (x[1] - 0.5).abs() < 1e-3, "{x:?}");
    }

    #[test]
    fn long_gradients_are_cut() {
        let mut long = [30.0, 40.0];
        assert_eq!(clip(&mut long, 10.0), 50.0);
        assert!((long[0] - 6.0).abs() < 1e-5 && (long[1] - 8.0).abs() < 1e-5);
        let mut short = [0.3, 0.4];
        clip(&mut short, 10.0);
        assert_eq!(short, [0.3, 0.4]);
    }
}
