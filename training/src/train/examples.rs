use std::collections::BTreeSet;

use catamaran::base::Rng;
use catamaran::unions::network::{FEATURES, K};
use catamaran::unions::{Question, Scaling};
use catamaran::{Error, Result};

use crate::dataset::{Dataset, KNOWN_IDENTITY, Spectrum, TEST_B, TRAIN};

/// The spectra of two parts and of their union.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pair {
    /// Of the first part.
    pub first: Spectrum,
    /// Of the second one.
    pub second: Spectrum,
    /// Of the union.
    pub union: Spectrum,
}

/// Unions of a part and another union, of which the first has to be predicted itself: (1, 2), 3 and 1, (2, 3).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Triple {
    /// Of the three parts.
    pub parts: [Spectrum; 3],
    /// Of all three.
    pub whole: Spectrum,
}

/// Smaller shares of the bound are taken for this: a closed union has a first eigenvalue of zero.
pub const LEAST_SHARE: f64 = 1e-3;
/// Logits of larger shares are taken for that of this.
const LARGEST_SHARE: f64 = 0.999;

/// To choose among results of the training, one pair in so many is kept from it, and one union in so many.
const VALIDATION: usize = 100;
const VALIDATION_UNIONS: usize = 40;
/// One triple of known shapes in two is trained on; the others test.
pub const TRAINED_TRIPLES: usize = 2;

/// Coarser meshes have larger eigenvalues, by a share that grows with them: its standard deviation at the last one.
const DRIFT: f64 = 0.03;
/// What is left of the differences between meshes.
const JITTER: f64 = 0.003;

impl Pair {
    /// What a coarser or finer mesh might have given; less so for a `size` below 1.
    pub fn disturbed(&self, size: f64, rng: &mut Rng) -> Self {
        let drift = size * DRIFT * rng.normal() / self.first[K - 1].max(self.second[K - 1]);
        let drift = drift.max(-0.5 / self.first[K - 1].max(self.second[K - 1]));
        let mut change = |values: &Spectrum, jitter: f64| {
            let mut changed = values.map(|x| x * (1.0 + drift * x) * (1.0 + jitter * rng.normal()));
            changed.sort_unstable_by(f64::total_cmp);
            changed
        };
        let union = change(&self.union, 0.0);
        let jitter = size * JITTER;
        Self { first: change(&self.first, jitter), second: change(&self.second, jitter), union }
    }

    /// A pair whose union is known for certain: a part, or the union, with the union, or a part with itself.
    pub fn contained(&self, rng: &mut Rng) -> Self {
        let part = if rng.sign() > 0.0 { self.first } else { self.second };
        // The union of a closed surface is no part.
        let proper = self.union[0] > LEAST_SHARE * part[0];
        match (3.0 * rng.uniform()) as usize {
            0 if proper => Self { first: self.union, second: part, union: self.union },
            1 if proper => Self { first: self.union, second: self.union, union: self.union },
            _ => Self { first: part, second: part, union: part },
        }
    }

    /// As the network sees it, and logarithms of union over bound.
    ///
    /// # Errors
    /// As [`Question::new`], for a part that has no Dirichlet spectrum.
    pub fn example(&self, scaling: &Scaling) -> Result<([f32; 2 * K * FEATURES], [f32; K])> {
        let question = Question::new(&self.first, &self.second)?;
        let logs = self.shares(&question).map(|share| share.ln() as f32);
        Ok((scaling.features(&question), logs))
    }

    fn shares(&self, question: &Question) -> [f64; K] {
        std::array::from_fn(|i| (self.union[i] / question.bound[i]).clamp(LEAST_SHARE, 1.0))
    }
}

/// What is learnt from, and what the result is chosen by.
#[derive(Debug, Clone, Default)]
pub struct Examples {
    /// Pairs to learn from.
    pub training: Vec<Pair>,
    /// Pairs to choose by.
    pub validation: Vec<Pair>,
    /// Triples to learn from.
    pub triples: Vec<Triple>,
}

impl Examples {
    /// Those of data sets that are for training. What tests in one of them is left out of all.
    ///
    /// # Errors
    /// [`Error::Argument`] when there are none.
    pub fn new(datasets: &[Dataset]) -> Result<Self> {
        let mut examples = Self::default();
        let of_split = |wanted: fn(usize) -> bool| {
            datasets.iter().flat_map(move |dataset| {
                let samples = &dataset.samples;
                let all = 0..samples.part1.len();
                all.filter(move |&i| wanted(samples.split[i])).map(move |i| samples.mask_union[i])
            })
        };
        let without: BTreeSet<usize> = of_split(|split| split == TEST_B).collect();
        let unions: BTreeSet<usize> =
            of_split(|split| split == TRAIN).filter(|union| !without.contains(union)).collect();
        // Ids are hashes: those that come last are any.
        let kept: BTreeSet<usize> =
            unions.iter().rev().take(unions.len() / VALIDATION_UNIONS).copied().collect();
        let mut count = 0;
        for dataset in datasets {
            let samples = &dataset.samples;
            for i in (0..samples.part1.len()).filter(|&i| samples.split[i] == TRAIN) {
                let (first, second) = (samples.part1[i], samples.part2[i]);
                let pair = Pair { first, second, union: samples.union[i] };
                count += 1;
                if without.contains(&samples.mask_union[i]) {
                    continue;
                }
                let chosen = kept.contains(&samples.mask_union[i]) || count % VALIDATION == 0;
                let list = if chosen { &mut examples.validation } else { &mut examples.training };
                list.push(pair);
            }
        }
        if examples.training.is_empty() {
            return Err(Error::Argument { what: "data set", why: "no samples to train on".into() });
        }
        if examples.validation.is_empty() {
            examples.validation = examples.training.clone();
        }
        for dataset in datasets {
            let triples = &dataset.triples;
            let known =
                (0..triples.part1.len()).filter(|&i| triples.knowledge[i] == KNOWN_IDENTITY);
            for i in known.step_by(TRAINED_TRIPLES) {
                let parts = [triples.part1[i], triples.part2[i], triples.part3[i]];
                examples.triples.push(Triple { parts, whole: triples.whole[i] });
            }
        }
        Ok(examples)
    }

    /// Means and deviations over the pairs to learn from.
    ///
    /// # Errors
    /// As [`Question::new`], for a part that has no Dirichlet spectrum.
    pub fn scaling(&self) -> Result<Scaling> {
        let mut features = vec![Moments::default(); K * FEATURES];
        let mut outputs = vec![Moments::default(); K];
        for pair in &self.training {
            let question = Question::new(&pair.first, &pair.second)?;
            for (j, &value) in question.features.as_flattened().iter().enumerate() {
                features[j % (K * FEATURES)].add(value);
            }
            for (moments, share) in outputs.iter_mut().zip(pair.shares(&question)) {
                let share = share.min(LARGEST_SHARE);
                moments.add((share / (1.0 - share)).ln());
            }
        }
        let means = |all: &[Moments]| all.iter().map(|m| m.mean() as f32).collect();
        let deviations = |all: &[Moments]| all.iter().map(|m| m.deviation() as f32).collect();
        Ok(Scaling {
            feature_mean: means(&features),
            feature_deviation: deviations(&features),
            output_mean: means(&outputs),
            output_deviation: deviations(&outputs),
        })
    }
}

#[derive(Clone, Default)]
struct Moments {
    count: f64,
    sum: f64,
    squares: f64,
}

impl Moments {
    fn add(&mut self, x: f64) {
        self.count += 1.0;
        self.sum += x;
        self.squares += x * x;
    }

    fn mean(&self) -> f64 {
        self.sum / self.count.max(1.0)
    }

    /// What hardly varies is not blown up.
    fn deviation(&self) -> f64 {
        let variance = self.squares / self.count.max(1.0) - self.mean() * self.mean();
        variance.max(0.0).sqrt().max(1e-2)
    }
}
