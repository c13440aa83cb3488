use std::collections::{BTreeMap, BTreeSet};

use catamaran::base::Rng;
use catamaran::unions::network::{FEATURES, K};
use catamaran::unions::{Localizer, PairFeatures, Scaling};
use catamaran::{Error, Par, Result};

use crate::cuts::id;
use crate::dataset::{Dataset, Samples, Spectrum, TEST_B, TRAIN};
use crate::regions::{Regions, localizer};

/// The spectra of two parts and of their union.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pair {
    /// Of the first part.
    pub first: Spectrum,
    /// Of the second one.
    pub second: Spectrum,
    /// Of the union.
    pub union: Spectrum,
    /// The numbers of all three in [`Examples::regions`], where they are known.
    pub regions: Option<[usize; 3]>,
}

/// A pair of which one part is a union itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Composite {
    /// The parts of the first part of the pair.
    pub parts: [Spectrum; 2],
    /// The pair.
    pub pair: Pair,
}

/// Smaller shares of the bound are taken for this: a closed union has a first eigenvalue of zero.
pub const LEAST_SHARE: f64 = 1e-3;
/// Logits of larger shares are taken for that of this.
const LARGEST_SHARE: f64 = 0.999;

/// How often pairs count that several shapes have, and others whose union is complete: there are
/// few of them, and users cut at joints and middles, and want all of a shape.
const FAVOURED: usize = 4;
/// To choose among results of the training, one pair in so many is kept from it, and one union in
/// so many.
const VALIDATION: usize = 100;
const VALIDATION_UNIONS: usize = 40;

/// Coarser meshes have larger eigenvalues, by a share that grows with them: its standard deviation
/// at the last one.
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
        let (first, second) = (change(&self.first, jitter), change(&self.second, jitter));
        Self { first, second, union, regions: self.regions }
    }

    /// The second part first.
    pub fn swapped(&self) -> Self {
        let regions = self.regions.map(|[first, second, union]| [second, first, union]);
        Self { first: self.second, second: self.first, union: self.union, regions }
    }

    /// A pair whose union is known for certain: a part, or the union, with the union, or a part
    /// with itself.
    pub fn contained(&self, rng: &mut Rng) -> Self {
        let which = usize::from(rng.sign() <= 0.0);
        let part = [self.first, self.second][which];
        let numbers = |of: [usize; 3]| self.regions.map(|own| of.map(|i| own[i]));
        // The union of a closed surface is no part.
        let proper = self.union[0] > LEAST_SHARE * part[0];
        match (3.0 * rng.uniform()) as usize {
            0 if proper => Self {
                first: self.union,
                second: part,
                union: self.union,
                regions: numbers([2, which, 2]),
            },
            1 if proper => Self {
                first: self.union,
                second: self.union,
                union: self.union,
                regions: numbers([2; 3]),
            },
            _ => Self { first: part, second: part, union: part, regions: numbers([which; 3]) },
        }
    }

    /// As the network sees it, and logarithms of union over bound.
    ///
    /// # Errors
    /// As [`PairFeatures::new`], for a part that has no Dirichlet spectrum.
    pub fn example(&self, scaling: &Scaling) -> Result<([f32; 2 * K * FEATURES], [f32; K])> {
        let input = PairFeatures::new(&self.first, &self.second)?;
        let logs = self.shares(&input).map(|share| share.ln() as f32);
        Ok((scaling.features(&input), logs))
    }

    fn shares(&self, input: &PairFeatures) -> [f64; K] {
        std::array::from_fn(|i| (self.union[i] / input.bound[i]).clamp(LEAST_SHARE, 1.0))
    }
}

/// What is learnt from, and what the result is chosen by.
#[derive(Debug, Clone)]
pub struct Examples {
    /// Pairs to learn from; those that several shapes have and those with a complete union are
    /// there 4 times.
    pub training: Vec<Pair>,
    /// Pairs to choose by, likewise.
    pub validation: Vec<Pair>,
    /// Pairs to learn from whose first part may be predicted as well.
    pub composites: Vec<Composite>,
    /// Where parts and unions are.
    pub regions: Regions,
    /// The template that they are on.
    pub localizer: Localizer,
}

impl Examples {
    /// Those of a data set that are for training.
    ///
    /// # Errors
    /// [`Error::Argument`] when there are none, or there is no template.
    pub fn new(dataset: &Dataset, par: Par) -> Result<Self> {
        let none = |why: &str| Error::Argument { what: "data set", why: why.into() };
        let template = dataset.templates.first().ok_or_else(|| none("no template"))?;
        let mut examples = Self {
            training: vec![],
            validation: vec![],
            composites: vec![],
            regions: Regions::new(template, par)?,
            localizer: localizer(template)?,
        };
        let samples = &dataset.samples;
        let all = 0..samples.part1.len();
        let unions = |split: usize| -> BTreeSet<usize> {
            let own = all.clone().filter(|&i| samples.split[i] == split);
            own.map(|i| samples.mask_union[i]).collect()
        };
        let without = unions(TEST_B);
        let mut unions = unions(TRAIN);
        unions.retain(|union| !without.contains(union));
        // Ids are hashes: those that come last are any.
        let kept: BTreeSet<usize> =
            unions.iter().rev().take(unions.len() / VALIDATION_UNIONS).copied().collect();
        let common = common(samples);
        let complete = id(&vec![true; template.vertices.len()]);
        // Of each shape the last pair that makes a union.
        let mut makers = BTreeMap::new();
        for (count, i) in all.filter(|&i| samples.split[i] == TRAIN).enumerate() {
            let masks = [samples.mask1[i], samples.mask2[i], samples.mask_union[i]];
            if without.contains(&masks[2]) {
                continue;
            }
            let number = |id: usize| examples.regions.number(id);
            let regions = match masks.map(number) {
                [Some(first), Some(second), Some(union)] => Some([first, second, union]),
                _ => None,
            };
            let (first, second) = (samples.part1[i], samples.part2[i]);
            let pair = Pair { first, second, union: samples.union[i], regions };
            let favoured = masks[2] == complete || common.contains(&[masks[0], masks[1]]);
            let times = if favoured { FAVOURED } else { 1 };
            if kept.contains(&masks[2]) || (count + 1) % VALIDATION == 0 {
                examples.validation.extend(std::iter::repeat_n(pair, times));
            } else {
                let shape = (samples.family[i], samples.identity[i], samples.pose[i]);
                let orders = [(masks[0], pair), (masks[1], pair.swapped())];
                for (part, pair) in orders {
                    if let Some(&parts) = makers.get(&(shape, part)) {
                        examples.composites.push(Composite { parts, pair });
                    }
                }
                makers.insert((shape, masks[2]), [first, second]);
                examples.training.extend(std::iter::repeat_n(pair, times));
            }
        }
        if examples.training.is_empty() {
            return Err(none("no samples to train on"));
        }
        if examples.validation.is_empty() {
            examples.validation = examples.training.clone();
        }
        Ok(examples)
    }

    /// Means and deviations over the pairs to learn from.
    ///
    /// # Errors
    /// As [`PairFeatures::new`], for a part that has no Dirichlet spectrum.
    pub fn scaling(&self) -> Result<Scaling> {
        let mut features = vec![Moments::default(); K * FEATURES];
        let mut outputs = vec![Moments::default(); K];
        for pair in &self.training {
            let input = PairFeatures::new(&pair.first, &pair.second)?;
            for (j, &value) in input.features.as_flattened().iter().enumerate() {
                features[j % (K * FEATURES)].add(value);
            }
            for (moments, share) in outputs.iter_mut().zip(pair.shares(&input)) {
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

/// Masks of the parts of pairs to train on that several shapes have.
fn common(samples: &Samples) -> BTreeSet<[usize; 2]> {
    let mut shapes = BTreeMap::new();
    for i in (0..samples.part1.len()).filter(|&i| samples.split[i] == TRAIN) {
        *shapes.entry([samples.mask1[i], samples.mask2[i]]).or_insert(0) += 1;
    }
    shapes.into_iter().filter(|(_, count)| *count > 1).map(|(pair, _)| pair).collect()
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
