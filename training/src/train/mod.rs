//! Training of the spectral union operator (thesis, section 2.4).

mod checkpoint;
mod examples;

pub use checkpoint::{read_state, write_state};
pub use examples::{Example, Examples, LEAST_SHARE, Pair};

use std::borrow::Cow;

use catamaran::base::{Pin, Rng, ThreadPool};
use catamaran::{Par, Result};
use catamaran_geometry::unions::network::{
    Architecture, FEATURES, K, ParameterLayout, Tape, forward, quantize, sigmoid,
};
use catamaran_geometry::unions::{OodDetector, PartFeatures, Scaling, SpectralUnion};
use rayon::prelude::*;

use crate::adam::{Adam, CHUNK, annealing, clip};
use crate::cuts::below;
use crate::mlp::shuffled;
use crate::network::{Backward, Outputs, initial_parameters};
use crate::regions::{Regions, UNIT};

/// Options of the training of the network.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrainOptions {
    /// Sizes of the network.
    pub sizes: Architecture,
    /// Number of pairs per step, a multiple of 64.
    pub batch: usize,
    /// Largest learning rate of the optimizer; thesis: 2e-4.
    pub rate: f64,
    /// Weight decay, decoupled from the gradient; thesis: 1e-5, as a part of the gradient.
    pub decay: f64,
    /// Number of passes over the data, during which the rate rises, then falls as half a cosine;
    /// thesis: restarts after 10, 30, 70, ...
    pub epochs: usize,
    /// Seed of all random numbers.
    pub seed: u64,
}

/// More pairs in a step would only take memory.
const MOST_IN_BATCH: usize = 1 << 16;

impl TrainOptions {
    /// Returns an error unless every option is in its range.
    ///
    /// # Errors
    /// [`catamaran::Error::Argument`] names the option.
    pub fn check(&self) -> Result<()> {
        self.sizes.check()?;
        let refuse = |what, why| Err(catamaran::Error::Argument { what, why });
        if !(TASK..=MOST_IN_BATCH).contains(&self.batch) || !self.batch.is_multiple_of(TASK) {
            return refuse(
                "batch",
                format!(
                    "must be a multiple of {TASK} from {TASK} to {MOST_IN_BATCH}, is {}",
                    self.batch
                ),
            );
        }
        for (what, value) in [("rate", self.rate), ("decay", self.decay)] {
            if !value.is_finite() || value < 0.0 {
                return refuse(what, format!("must be finite and at least 0, is {value}"));
            }
        }
        Ok(())
    }
}

impl Default for TrainOptions {
    fn default() -> Self {
        let sizes = Architecture::default();
        Self { sizes, batch: 128, rate: 2.5e-3, decay: 0.1, epochs: 40, seed: 1 }
    }
}

/// The state of a training.
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    /// Parameters.
    pub parameters: Vec<f32>,
    /// State of the optimizer.
    pub adam: Adam,
    /// The parameters with the smallest validation error so far.
    pub best: Vec<f32>,
    /// Errors of each epoch.
    pub history: Vec<Epoch>,
    /// The units of the network, which do not depend on later data.
    pub scaling: Scaling,
}

impl State {
    /// Returns an error unless all numbers are finite, and units are those of a network.
    fn check(&self) -> Result<()> {
        let Scaling { feature_mean, feature_deviation, output_mean, output_deviation } =
            &self.scaling;
        let features = K * FEATURES;
        let lengths = [
            (feature_mean, features),
            (feature_deviation, features),
            (output_mean, K),
            (output_deviation, K),
        ];
        let numbers = [&self.parameters, &self.best, &self.adam.mean, &self.adam.square];
        let all = numbers.into_iter().chain(lengths.iter().map(|(values, _)| *values));
        let is_sound = lengths.iter().all(|(values, len)| values.len() == *len)
            && all.flatten().all(|x| x.is_finite())
            && self.adam.square.iter().all(|&x| x >= 0.0);
        if is_sound {
            return Ok(());
        }
        let why = "is damaged: units or parameters of no network".into();
        Err(catamaran::Error::Argument { what: "state", why })
    }
}

/// Mean errors of one pass over the data, of logarithms of eigenvalues; small ones are relative
/// errors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Epoch {
    /// Error on the pairs of the training, disturbed.
    pub training: f64,
    /// Error on the pairs of the validation.
    pub validation: f64,
}

/// Number of unions per task, all of equally many parts.
const TASK: usize = 64;
/// Largest number of parts of a union.
const MOST_PARTS: usize = 4;
/// Shares of the tasks with three parts and with four.
const MANY: [f64; 2] = [0.12, 0.08];
/// Share of the pairs that consist of a part and a union that contains it.
const CONTAINED: f64 = 0.06;
/// Largest norm of the gradient.
const CLIP: f32 = 10.0;
/// Errors of logarithms of about this size or more count less than by their square (Fair 1974).
const OUTLIER: f32 = 0.3;
/// Weight of the squared distance of a region from its prediction, relative to the area of the
/// template.
const REGION: f64 = 0.2;
/// Weight of the log-likelihood that a pair is of the template or not.
const OOD_WEIGHT: f64 = 0.05;
/// Share of the pairs of the template with an out-of-distribution score of at most 1.
const WITHIN: f64 = 0.995;

/// Buffers of one task.
struct Worker {
    /// For unions of two parts and more, the tape and the gradient with respect to the outputs.
    passes: [(Tape<f32>, Outputs<f32>); MOST_PARTS - 1],
    /// Number of parts of each union.
    parts: usize,
    backward: Backward<f32>,
    targets: Vec<[f32; K]>,
    /// Regions of the example in each slot.
    regions: Vec<Option<Vec<usize>>>,
    /// Sum of the absolute errors of logarithms.
    error: f64,
}

/// Trains on examples, one epoch per call.
pub struct Trainer {
    options: TrainOptions,
    examples: Examples,
    layout: ParameterLayout,
    state: State,
    /// The parameters, rounded to the precision of the files of weights.
    rounded: Vec<f32>,
    /// The validation error of the best network.
    best: f64,
    /// The detector of pairs that differ from those of the training.
    detector: OodDetector,
    workers: Vec<Worker>,
    team: Option<ThreadPool>,
}

impl Trainer {
    /// Starts a training, or continues from a state. The result does not depend on the number of
    /// threads, nor on interruptions.
    ///
    /// # Errors
    /// When the architecture is invalid, the state belongs to another architecture, or a spectrum
    /// is invalid.
    pub fn new(
        examples: Examples,
        options: TrainOptions,
        state: Option<State>,
        par: Par,
    ) -> Result<Self> {
        options.check()?;
        let modes = examples.regions.modes();
        if options.sizes.modes != modes {
            let why = format!("must be {modes}, as in the regions, is {}", options.sizes.modes);
            return Err(catamaran::Error::Argument { what: "modes", why });
        }
        let layout = options.sizes.layout();
        let goes_on = state.is_some();
        let state = match state {
            Some(state) => state,
            None => {
                let parameters = initial_parameters(&options.sizes, options.seed);
                let adam = Adam::new(parameters.len());
                let (best, scaling) = (parameters.clone(), examples.scaling()?);
                State { best, parameters, adam, history: Vec::new(), scaling }
            }
        };
        let lengths = [&state.parameters, &state.best, &state.adam.mean, &state.adam.square];
        if lengths.iter().any(|x| x.len() != layout.len) {
            let why = format!("must belong to a network with {} parameters", layout.len);
            return Err(catamaran::Error::Argument { what: "state", why });
        }
        state.check()?;
        let sizes = &options.sizes;
        let pass = |parts| (Tape::new(sizes, TASK, parts), Outputs::new(sizes, TASK, parts));
        let worker = || Worker {
            passes: std::array::from_fn(|i| pass(i + 2)),
            parts: 2,
            backward: Backward::new(sizes),
            targets: vec![[0.0; K]; TASK],
            regions: vec![None; TASK],
            error: 0.0,
        };
        let workers = (0..options.batch / TASK).map(|_| worker()).collect();
        let team = match par.threads() {
            1 => None,
            threads => Some(ThreadPool::new(threads, Pin::No)?),
        };
        let rounded = vec![0.0; layout.len];
        let symmetric =
            |pair: &Pair| Ok(PartFeatures::of_pair(&pair.first, &pair.second)?.symmetric());
        let of_template =
            examples.training.iter().filter(|pair| examples.is_familiar(pair.regions.is_some()));
        let detector =
            OodDetector::fit(&of_template.map(symmetric).collect::<Result<Vec<_>>>()?, WITHIN)?;
        let best = f64::INFINITY;
        let mut trainer =
            Self { options, examples, layout, state, rounded, best, detector, workers, team };
        if goes_on {
            // On the present examples, which may differ from those by which it was chosen.
            let (error, probabilities) = trainer.validate(true)?;
            trainer.choose(error, probabilities);
        }
        Ok(trainer)
    }

    /// Stores the error of the best network, and fits the detector to its out-of-distribution
    /// probabilities of pairs of the template.
    fn choose(&mut self, error: f64, probabilities: Vec<f64>) {
        self.best = error;
        self.detector = self.detector.clone().with_probabilities(probabilities, WITHIN);
    }

    /// Returns the state.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// Returns the examples.
    pub fn examples(&self) -> &Examples {
        &self.examples
    }

    /// Returns the mean error of logarithms of the best network so far, on the pairs of the
    /// validation.
    pub fn best_error(&self) -> f64 {
        self.best
    }

    /// Returns the best network so far.
    ///
    /// # Errors
    /// Those of [`SpectralUnion::new`].
    pub fn model(&self) -> Result<SpectralUnion> {
        let State { best, scaling, .. } = self.state.clone();
        let localizer = self.examples.localizer.clone();
        SpectralUnion::new(self.options.sizes, best, scaling, self.detector.clone(), localizer)
    }

    /// Does one pass over the data.
    ///
    /// # Errors
    /// When a spectrum is invalid.
    pub fn epoch(&mut self) -> Result<Epoch> {
        let number = self.state.history.len();
        let seed = self.options.seed.wrapping_add((number as u64 + 1) << 20);
        let mut rng = Rng::new(seed);
        let count = self.examples.training.len();
        let order = shuffled(count, &mut rng);
        let whole = self.workers.len() * TASK;
        let (mut error, mut seen) = (0.0, 0);
        for (step, batch) in order.chunks(whole).enumerate() {
            // The last tasks of an incomplete batch use its first pairs again.
            let batch: Vec<usize> = batch.iter().copied().cycle().take(whole).collect();
            let time = number as f64 + (step * whole) as f64 / count as f64;
            let share = annealing(time / self.options.epochs as f64);
            error += self.step(&batch, seed + 1 + step as u64, share)?;
            seen += whole;
        }
        let (validation, probabilities) = self.validate(false)?;
        if validation < self.best {
            self.state.best.clone_from(&self.state.parameters);
            self.choose(validation, probabilities);
        }
        let epoch = Epoch { training: error / (seen * K) as f64, validation };
        self.state.history.push(epoch);
        Ok(epoch)
    }

    /// Does one step of the optimizer, at this share of the full rate, and returns the sum of the
    /// errors. Disturbances are proportional to the rate.
    fn step(&mut self, batch: &[usize], seed: u64, share: f64) -> Result<f64> {
        self.round(false);
        let Self { options, examples, layout, state, rounded, workers, team, .. } = self;
        let (parameters, scaling) = (&*rounded, &state.scaling);
        let work = |(task, worker): (usize, &mut Worker)| -> Result<()> {
            let mut rng = Rng::new(seed.wrapping_mul(1 << 10).wrapping_add(task as u64));
            let choice = rng.uniform();
            worker.parts = match examples.composites.is_empty() {
                false if choice < MANY[0] => 3,
                false if choice < MANY[0] + MANY[1] => 4,
                _ => 2,
            };
            for (slot, &i) in batch[task * TASK..(task + 1) * TASK].iter().enumerate() {
                let example = if worker.parts > 2 {
                    let composites = &examples.composites;
                    let number = composites[below(composites.len(), &mut rng)];
                    examples.of_many(number, worker.parts, &mut rng)
                } else if rng.uniform() < CONTAINED {
                    examples.training[i].contained(&mut rng).example()
                } else {
                    examples.training[i].example()
                };
                let example = example.disturbed(share, &mut rng);
                worker.put(slot, scaling, &example)?;
                worker.regions[slot] = example.regions;
            }
            worker.run(options, examples, scaling, layout, parameters);
            Ok(())
        };
        let done: Result<Vec<()>> = match team {
            Some(team) => team.run(|| workers.par_iter_mut().enumerate().map(work).collect()),
            None => workers.iter_mut().enumerate().map(work).collect(),
        };
        done?;
        // The order is that of the tasks, not of the threads.
        let (first, rest) = workers.split_at_mut(1);
        let gradient = &mut first[0].backward.gradient;
        let add = |(chunk, sum): (usize, &mut [f32])| {
            for worker in rest.iter() {
                let part = &worker.backward.gradient[chunk * CHUNK..];
                sum.iter_mut().zip(part).for_each(|(sum, g)| *sum += g);
            }
        };
        let (rate, decay) = ((options.rate * share) as f32, options.decay as f32);
        let State { parameters, adam, .. } = state;
        match team {
            Some(team) => {
                team.run(|| gradient.par_chunks_mut(CHUNK).enumerate().for_each(add));
                clip(gradient, CLIP);
                team.run(|| adam.par_step(parameters, gradient, rate, decay));
            }
            None => {
                gradient.chunks_mut(CHUNK).enumerate().for_each(add);
                clip(gradient, CLIP);
                adam.step(parameters, gradient, rate, decay);
            }
        }
        let error = first[0].error + rest.iter().map(|worker| worker.error).sum::<f64>();
        Ok(error)
    }

    /// Rounds the parameters, or the best ones.
    fn round(&mut self, best: bool) {
        let State { parameters, best: best_ones, .. } = &self.state;
        self.rounded.copy_from_slice(if best { best_ones } else { parameters });
        let mut parts = Vec::new();
        let mut rest = self.rounded.as_mut_slice();
        for (_, parameter) in &self.layout.named {
            let (part, behind) = rest.split_at_mut(parameter.range().len());
            parts.push((parameter, part));
            rest = behind;
        }
        match &self.team {
            Some(team) => {
                team.run(|| {
                    parts.into_par_iter().for_each(|(parameter, part)| quantize(parameter, part))
                });
            }
            None => parts.into_iter().for_each(|(parameter, part)| quantize(parameter, part)),
        }
    }

    /// Returns the mean error of logarithms on the pairs of the validation, of the current or the
    /// best network, and its out-of-distribution probabilities of those of the template.
    fn validate(&mut self, best: bool) -> Result<(f64, Vec<f64>)> {
        self.round(best);
        let Self { examples, options, layout, state, rounded, workers, .. } = self;
        let (worker, scaling) = (&mut workers[0], &state.scaling);
        worker.parts = 2;
        let (mut error, mut probabilities) = (0.0, Vec::new());
        for pairs in examples.validation.chunks(TASK) {
            for (slot, pair) in pairs.iter().enumerate() {
                worker.put(slot, scaling, &pair.example())?;
            }
            forward(&options.sizes, layout, rounded, worker.tape());
            for (slot, pair) in pairs.iter().enumerate() {
                for i in 0..K {
                    let (log, _) = worker.log(scaling, slot, i);
                    error += f64::from((log - worker.targets[slot][i]).abs());
                }
                if examples.is_familiar(pair.regions.is_some()) {
                    probabilities.push(sigmoid(f64::from(worker.tape().ood_logit[slot])));
                }
            }
        }
        Ok((error / (examples.validation.len() * K).max(1) as f64, probabilities))
    }
}

impl Worker {
    fn tape(&mut self) -> &mut Tape<f32> {
        &mut self.passes[self.parts - 2].0
    }

    /// Writes an example to a slot, in the units of the network.
    fn put(&mut self, slot: usize, scaling: &Scaling, example: &Example) -> Result<()> {
        let (input, logs) = example.features()?;
        for (part, features) in input.features.iter().enumerate() {
            let row = (part * TASK + slot) * K * FEATURES;
            self.tape().features[row..row + K * FEATURES]
                .copy_from_slice(&scaling.features(features));
        }
        self.targets[slot] = logs;
        Ok(())
    }

    /// Returns the logarithm of the predicted share, and its derivative with respect to the output.
    fn log(&self, scaling: &Scaling, slot: usize, i: usize) -> (f32, f32) {
        let deviation = scaling.output_deviation[i];
        let (tape, _) = &self.passes[self.parts - 2];
        let logit = tape.output[slot * K + i] * deviation + scaling.output_mean[i];
        // Computes ln(1 / (1 + e^-x)) without overflow.
        let small = (-logit.abs()).exp();
        let log = logit.min(0.0) - small.ln_1p();
        let rest = if logit > 0.0 { small / (1.0 + small) } else { 1.0 / (1.0 + small) };
        (log, rest * deviation)
    }

    /// Runs the network forward and backward; adds the gradient of the mean over the batch.
    fn run(
        &mut self,
        options: &TrainOptions,
        examples: &Examples,
        scaling: &Scaling,
        layout: &ParameterLayout,
        parameters: &[f32],
    ) {
        forward(&options.sizes, layout, parameters, self.tape());
        self.error = 0.0;
        let share = 1.0 / (options.batch * K) as f32;
        for slot in 0..TASK {
            for i in 0..K {
                let (log, derivative) = self.log(scaling, slot, i);
                let error = log - self.targets[slot][i];
                let weakened = error / (OUTLIER + error.abs());
                let (_, outputs) = &mut self.passes[self.parts - 2];
                outputs.output[slot * K + i] = share * weakened * derivative;
                self.error += f64::from(error.abs());
            }
        }
        let (tape, outputs) = &mut self.passes[self.parts - 2];
        let logits = outputs.ood_logit.iter_mut().zip(&tape.ood_logit);
        for ((logit, found), regions) in logits.zip(&self.regions) {
            let truth = if examples.is_familiar(regions.is_some()) { 0.0 } else { 1.0 };
            *logit = (OOD_WEIGHT / options.batch as f64) as f32 * (sigmoid(*found) - truth);
        }
        self.compare_regions(&examples.regions, options.batch);
        let (tape, outputs) = &self.passes[self.parts - 2];
        self.backward.gradient.fill(0.0);
        self.backward.run(layout, parameters, tape, outputs);
    }

    /// Computes the gradient with respect to the regions.
    fn compare_regions(&mut self, regions: &Regions, batch: usize) {
        let modes = regions.modes();
        let factor = (2.0 * REGION * UNIT * UNIT / batch as f64) as f32;
        let difference = |gradient: &mut [f32], found: &[f32], wanted: Option<&[f32]>| {
            let Some(wanted) = wanted else { return gradient.fill(0.0) };
            for (gradient, (found, wanted)) in gradient.iter_mut().zip(found.iter().zip(wanted)) {
                *gradient = factor * (found - wanted);
            }
        };
        let (tape, outputs) = &mut self.passes[self.parts - 2];
        for slot in 0..TASK {
            let numbers = self.regions[slot].as_deref();
            for part in 0..self.parts {
                let row = (part * TASK + slot) * modes..(part * TASK + slot + 1) * modes;
                let wanted = numbers.map(|numbers| regions.on_the_left(numbers[part]));
                let found = &tape.part_region[row.clone()];
                difference(&mut outputs.part_region[row], found, wanted.as_deref());
            }
            let row = slot * modes..(slot + 1) * modes;
            let wanted = numbers.map(|numbers| {
                let (&union, parts) = numbers.split_last().expect("a union behind its parts");
                match parts.iter().all(|&part| part == union) {
                    true => regions.on_the_left(union),
                    false => Cow::Borrowed(regions.coefficients(union)),
                }
            });
            let found = &tape.region[row.clone()];
            difference(&mut outputs.region[row], found, wanted.as_deref());
        }
    }
}

#[cfg(test)]
mod tests;
