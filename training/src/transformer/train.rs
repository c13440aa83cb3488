use std::ops::ControlFlow;
use std::time::Instant;

use catamaran::base::{Pin, Rng, ThreadPool};
use catamaran::{Error, Par, Result};
use catamaran_geometry::unions::network::K;
use rayon::prelude::*;

use super::backward::Gradient;
use super::forward::{Tape, forward};
use super::layout::Layout;
use super::{Input, Transformer};
use crate::adam::{Adam, clip};
use crate::mlp::shuffled;
use crate::network::add;
use crate::train::Pair;

/// Options of the training of the transformer.
#[derive(Debug, Clone, Copy)]
pub struct TransformerOptions {
    /// Largest number of passes over the data.
    pub epochs: usize,
    /// Minutes after which the training ends with the current pass; infinity for no limit.
    pub minutes: f64,
    /// Seed of the parameters and of the order.
    pub seed: u64,
    /// Threads. The result does not depend on them, unless the time limit ends the training.
    pub par: Par,
}

impl Default for TransformerOptions {
    /// Returns five cycles of the rate, of 10, 20, 40, 80 and 160 epochs, on all cores.
    fn default() -> Self {
        Self { epochs: 310, minutes: f64::INFINITY, seed: 1, par: Par::all() }
    }
}

/// Mean squared errors of one pass over the data. Eigenvalues are in units of a 20th of the smaller
/// one of the two 20th eigenvalues of the parts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Losses {
    /// Loss on the pairs of the training, each before the step that uses it.
    pub training: f64,
    /// Loss on the pairs of the validation, after the pass.
    pub validation: f64,
}

/// Number of pairs per step.
pub const BATCH: usize = 128;
/// Number of pairs per task: 64 are as fast on one core, but keep fewer cores busy.
const TASK: usize = 16;
/// Largest learning rate of the optimizer (thesis).
const RATE: f64 = 2e-4;
/// Weight decay, as a part of the gradient (thesis).
const DECAY: f32 = 1e-5;
/// Largest norm of the gradient.
const CLIP: f32 = 10.0;
/// Number of epochs of the first cycle of the rate. Each cycle is twice as long as the previous one
/// (thesis).
const CYCLE: f64 = 10.0;

/// Returns the share of the full rate after `epochs` epochs: cosine annealing with warm restarts
/// (Loshchilov and Hutter 2017).
pub fn warm_restarts(epochs: f64) -> f64 {
    let (mut time, mut cycle) = (epochs, CYCLE);
    while time >= cycle {
        time -= cycle;
        cycle *= 2.0;
    }
    0.5 * (1.0 + (std::f64::consts::PI * time / cycle).cos())
}

/// A pair in units of the network.
struct Example {
    input: Input,
    /// Eigenvalues of the union.
    target: [f32; K],
}

fn examples(what: &'static str, pairs: &[Pair]) -> Result<Vec<Example>> {
    if pairs.is_empty() {
        return Err(Error::Argument { what, why: "must not be empty".into() });
    }
    let example = |pair: &Pair| -> Result<Example> {
        let input = Input::new(&pair.first, &pair.second)?;
        Ok(Example { target: pair.union.map(|x| (x / input.scale) as f32), input })
    };
    pairs.iter().map(example).collect()
}

/// Buffers of one task.
struct Worker {
    tape: Tape<f32>,
    gradient: Gradient<f32>,
    by_output: Vec<f32>,
    /// Sum of the losses over pairs and eigenvalues.
    loss: f64,
}

impl Worker {
    fn new(layout: &Layout) -> Self {
        let (tape, gradient) = (Tape::new(layout, TASK), Gradient::new(layout));
        Self { tape, gradient, by_output: vec![0.0; TASK * K], loss: 0.0 }
    }

    /// Computes the loss on at most `TASK` examples, and its gradient with respect to the output.
    fn measure(&mut self, layout: &Layout, parameters: &[f32], examples: &[&Example]) {
        let (first, second) = self.tape.offsets.split_at_mut(TASK * K);
        let rows = first.chunks_exact_mut(K).zip(second.chunks_exact_mut(K));
        for ((first, second), example) in rows.zip(examples) {
            first.copy_from_slice(&example.input.offsets[0]);
            second.copy_from_slice(&example.input.offsets[1]);
        }
        forward(layout, parameters, &mut self.tape);
        self.loss = 0.0;
        let rows = self.by_output.chunks_exact_mut(K).zip(self.tape.output.chunks_exact(K));
        for ((gradient, offsets), example) in rows.zip(examples) {
            let mut value = 0.0;
            for i in 0..K {
                value += offsets[i];
                gradient[i] = value - example.target[i];
                self.loss += f64::from(gradient[i] * gradient[i]);
            }
            // An offset contributes to its eigenvalue and to all later ones.
            let mut behind = 0.0;
            for gradient in gradient.iter_mut().rev() {
                behind += *gradient;
                *gradient = 2.0 * behind / (BATCH * K) as f32;
            }
        }
    }

    /// Computes the loss on `TASK` examples, and the gradient of its mean over the batch.
    fn learn(&mut self, layout: &Layout, parameters: &[f32], examples: &[&Example]) {
        self.measure(layout, parameters, examples);
        self.gradient.values().fill(0.0);
        self.gradient.run(layout, parameters, &self.tape, &self.by_output);
    }
}

/// Distributes the examples over the workers, `TASK` to each, and returns the sum of the losses,
/// added in the order of the tasks.
fn run(
    team: Option<&ThreadPool>,
    workers: &mut [Worker],
    examples: &[&Example],
    work: impl Fn(&mut Worker, &[&Example]) + Sync,
) -> f64 {
    let used = &mut workers[..examples.len().div_ceil(TASK)];
    let task = |(worker, examples): (&mut Worker, &[&Example])| work(worker, examples);
    match team {
        Some(team) => {
            team.run(|| used.par_iter_mut().zip(examples.par_chunks(TASK)).for_each(task));
        }
        None => used.iter_mut().zip(examples.chunks(TASK)).for_each(task),
    }
    used.iter().map(|worker| worker.loss).sum()
}

/// Implements [`Transformer::train`].
pub fn train(
    layout: Layout,
    [training, validation]: [&[Pair]; 2],
    options: &TransformerOptions,
    mut watch: impl FnMut(usize, Losses) -> ControlFlow<()>,
) -> Result<Transformer> {
    let start = Instant::now();
    let (training, validation) =
        (examples("training", training)?, examples("validation", validation)?);
    let mut workers: Vec<_> = (0..BATCH / TASK).map(|_| Worker::new(&layout)).collect();
    let team = match options.par.threads() {
        1 => None,
        threads => Some(ThreadPool::new(threads, Pin::No)?),
    };
    let mut parameters = layout.initial(options.seed);
    let mut adam = Adam::new(layout.len);
    let (mut best, mut least) = (parameters.clone(), f64::INFINITY);
    for epoch in 0..options.epochs {
        let mut rng = Rng::new(options.seed.wrapping_add((epoch as u64 + 1) << 20));
        let (mut loss, mut seen) = (0.0, 0);
        for batch in shuffled(training.len(), &mut rng).chunks(BATCH) {
            let time = epoch as f64 + seen as f64 / training.len() as f64;
            // An incomplete last batch uses its first pairs again.
            let batch: Vec<_> = batch.iter().cycle().take(BATCH).map(|&i| &training[i]).collect();
            let learn = |worker: &mut Worker, examples: &[&Example]| {
                worker.learn(&layout, &parameters, examples);
            };
            loss += run(team.as_ref(), &mut workers, &batch, learn);
            seen += BATCH;
            let (first, rest) = workers.split_at_mut(1);
            let gradient = first[0].gradient.values();
            // The order is that of the tasks, not of the threads.
            rest.iter_mut().for_each(|worker| add(gradient, worker.gradient.values()));
            clip(gradient, CLIP);
            gradient.iter_mut().zip(&parameters).for_each(|(g, x)| *g += DECAY * x);
            adam.step(&mut parameters, gradient, (RATE * warm_restarts(time)) as f32, 0.0);
        }
        let measure = |worker: &mut Worker, examples: &[&Example]| {
            worker.measure(&layout, &parameters, examples);
        };
        let mut validated = 0.0;
        for batch in validation.chunks(BATCH) {
            let batch: Vec<_> = batch.iter().collect();
            validated += run(team.as_ref(), &mut workers, &batch, measure);
        }
        let mean = |loss: f64, pairs: usize| loss / (pairs * K) as f64;
        let losses =
            Losses { training: mean(loss, seen), validation: mean(validated, validation.len()) };
        if losses.validation < least {
            (least, best) = (losses.validation, parameters.clone());
        }
        if watch(epoch, losses).is_break() || start.elapsed().as_secs_f64() > 60.0 * options.minutes
        {
            break;
        }
    }
    Ok(Transformer { layout, parameters: best })
}
