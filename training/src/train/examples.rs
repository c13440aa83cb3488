use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::slice;

use catamaran::base::Rng;
use catamaran::{Error, Par, Result};
use catamaran_geometry::unions::network::{FEATURES, K};
use catamaran_geometry::unions::{Localizer, PartFeatures, Scaling};

use crate::cuts::{below, id};
use crate::dataset::{Dataset, Samples, Spectrum, TEST_B, TRAIN};
use crate::regions::{Regions, localizer};

/// The spectra of two parts and of their union.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pair {
    /// The spectrum of the first part.
    pub first: Spectrum,
    /// The spectrum of the second part.
    pub second: Spectrum,
    /// The spectrum of the union.
    pub union: Spectrum,
    /// The numbers of all three in [`Examples::regions`], if they are known.
    pub regions: Option<[usize; 3]>,
}

/// The spectra of some parts and of their union.
#[derive(Debug, Clone, PartialEq)]
pub struct Example {
    /// The spectra of the parts.
    pub parts: Vec<Spectrum>,
    /// The spectrum of the union.
    pub union: Spectrum,
    /// The numbers of the parts, then of the union, in [`Examples::regions`], if they are known.
    pub regions: Option<Vec<usize>>,
}

/// Smaller shares of the bound are replaced by this one: the first eigenvalue of a closed union is
/// zero.
pub const LEAST_SHARE: f64 = 1e-3;
/// Logits of larger shares are replaced by the logit of this share.
const LARGEST_SHARE: f64 = 0.999;

/// Weight of pairs that several shapes share, and of other pairs with a complete union: there are
/// few of them, but users cut at joints and middles, and unite complete shapes.
const FAVOURED: usize = 4;
/// One pair in this many, and one union in this many, are reserved for validation, which chooses
/// among the results of the training.
const VALIDATION: usize = 100;
const VALIDATION_UNIONS: usize = 40;

/// Probability that a part that is itself a union stays when its parts are added.
const KEPT: f64 = 0.3;

/// Coarser meshes have larger eigenvalues, by a relative difference that grows with the eigenvalue;
/// this is its standard deviation at the last one.
const DRIFT: f64 = 0.03;
/// Standard deviation of the remaining relative differences between meshes.
const JITTER: f64 = 0.003;

impl Example {
    /// Returns the example as a coarser or finer mesh might give it; a `size` below 1 reduces the
    /// differences.
    pub fn disturbed(mut self, size: f64, rng: &mut Rng) -> Self {
        let largest = self.parts.iter().map(|part| part[K - 1]).fold(0.0, f64::max);
        let drift = (size * DRIFT * rng.normal()).max(-0.5) / largest;
        let mut change = |values: &mut Spectrum, jitter: f64| {
            let change = |x: f64| x * (1.0 + drift * x) * (1.0 + jitter * rng.normal());
            *values = values.map(change);
            values.sort_unstable_by(f64::total_cmp);
        };
        change(&mut self.union, 0.0);
        self.parts.iter_mut().for_each(|part| change(part, size * JITTER));
        self
    }

    /// Returns the features, and the logarithms of the union divided by the bound.
    ///
    /// # Errors
    /// Those of [`PartFeatures::new`], for a part that has no Dirichlet spectrum.
    pub fn features(&self) -> Result<(PartFeatures, [f32; K])> {
        let input = PartFeatures::new(&self.parts)?;
        let logs = shares(&self.union, &input).map(|share| share.ln() as f32);
        Ok((input, logs))
    }

    /// Replaces some parts by others.
    fn replace(&mut self, range: Range<usize>, parts: &[Spectrum], regions: Option<&[usize]>) {
        self.parts.splice(range.clone(), parts.iter().copied());
        self.regions = self.regions.take().zip(regions).map(|(mut own, regions)| {
            own.splice(range, regions.iter().copied());
            own
        });
    }
}

fn shares(union: &Spectrum, input: &PartFeatures) -> [f64; K] {
    std::array::from_fn(|i| (union[i] / input.bound[i]).clamp(LEAST_SHARE, 1.0))
}

impl Pair {
    /// Returns the pair as an example of two parts.
    pub fn example(&self) -> Example {
        let parts = vec![self.first, self.second];
        Example { parts, union: self.union, regions: self.regions.map(Vec::from) }
    }

    /// Returns a pair whose union is known exactly: a part and the union, the union twice, or a
    /// part twice.
    pub fn contained(&self, rng: &mut Rng) -> Self {
        let which = usize::from(rng.sign() <= 0.0);
        let part = [self.first, self.second][which];
        let numbers = |of: [usize; 3]| self.regions.map(|own| of.map(|i| own[i]));
        // The union must not be a closed surface, which is not a part.
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
}

/// The examples of the training and of the validation.
#[derive(Debug, Clone)]
pub struct Examples {
    /// Pairs of the training; those that several shapes share and those with a complete union are
    /// repeated 4 times.
    pub training: Vec<Pair>,
    /// Pairs of the validation, repeated likewise; those of the training if there are no others.
    pub validation: Vec<Pair>,
    /// For each pair of the training and each of its parts, the number of a pair whose union is
    /// this part.
    pub makers: Vec<[Option<usize>; 2]>,
    /// The numbers of the pairs with such a part.
    pub composites: Vec<usize>,
    /// Whether all pairs, also those without regions, are of the kind of shape that the network is
    /// for.
    all_familiar: bool,
    /// The regions of parts and unions.
    pub regions: Regions,
    /// The localizer of the template of the regions.
    pub localizer: Localizer,
}

impl Examples {
    /// Collects the training samples of a data set.
    ///
    /// # Errors
    /// [`Error::Argument`] when there are no training samples, or there is no template.
    pub fn new(dataset: &Dataset, par: Par) -> Result<Self> {
        let none = |why: &str| Error::Argument { what: "data set", why: why.into() };
        let template = dataset.templates.first().ok_or_else(|| none("no template"))?;
        let mut examples = Self {
            training: vec![],
            validation: vec![],
            makers: vec![],
            composites: vec![],
            all_familiar: false,
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
        // The ids are hashes, so the last ones are random.
        let kept: BTreeSet<usize> =
            unions.iter().rev().take(unions.len() / VALIDATION_UNIONS).copied().collect();
        let common = common(samples);
        let complete = id(&vec![true; template.vertices.len()]);
        // For each shape, the number of the last pair with each union.
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
                let own = [masks[0], masks[1]].map(|part| makers.get(&(shape, part)).copied());
                let number = examples.training.len();
                if own.iter().any(Option::is_some) {
                    examples.composites.extend(number..number + times);
                }
                makers.insert((shape, masks[2]), number);
                examples.makers.extend(std::iter::repeat_n(own, times));
                examples.training.extend(std::iter::repeat_n(pair, times));
            }
        }
        if examples.training.is_empty() {
            return Err(none("must contain training samples"));
        }
        if examples.validation.is_empty() {
            examples.validation = examples.training.clone();
        }
        Ok(examples)
    }

    /// Collects the pairs of a family without known regions, for a network with this localizer.
    ///
    /// # Errors
    /// [`Error::Argument`] when there are no pairs for the training, or none for the validation.
    pub fn of_family(
        training: Vec<Pair>,
        validation: Vec<Pair>,
        localizer: Localizer,
    ) -> Result<Self> {
        if training.is_empty() || validation.is_empty() {
            let why = "too few pairs of parts could be cut from them".into();
            return Err(Error::Argument { what: "meshes", why });
        }
        let makers = vec![[None; 2]; training.len()];
        let regions = Regions::none(localizer.modes());
        let (composites, all_familiar) = (vec![], true);
        Ok(Self { training, validation, makers, composites, all_familiar, regions, localizer })
    }

    /// Returns whether the pairs of the training are those of the validation too, because the data
    /// set is too small for others: then errors of the validation are too small.
    pub fn validates_on_training(&self) -> bool {
        self.validation == self.training
    }

    /// Returns whether a pair is of the kind of shape that the network is for, given whether its
    /// regions are known.
    pub fn is_familiar(&self, known: bool) -> bool {
        known || self.all_familiar
    }

    /// Extends the pair with this number to `count` parts. Parts that are themselves unions are
    /// replaced by their parts, or these are added; if no part is a union, a part is repeated.
    pub fn of_many(&self, number: usize, count: usize, rng: &mut Rng) -> Example {
        let mut example = self.training[number].example();
        let mut makers = self.makers[number].to_vec();
        while example.parts.len() < count {
            let unions: Vec<usize> = (0..makers.len()).filter(|&i| makers[i].is_some()).collect();
            if unions.is_empty() {
                let at = below(makers.len(), rng);
                let regions = example.regions.as_ref().map(|regions| regions[at]);
                example.replace(
                    at..at,
                    &[example.parts[at]],
                    regions.as_ref().map(slice::from_ref),
                );
                makers.insert(at, None);
                continue;
            }
            let at = unions[below(unions.len(), rng)];
            let maker = makers[at].unwrap_or(number);
            let Pair { first, second, regions, .. } = self.training[maker];
            let kept = example.parts.len() + 2 <= count && rng.uniform() < KEPT;
            let place = at..at + usize::from(!kept);
            makers.splice(place.clone(), self.makers[maker]);
            if kept {
                makers[at + 2] = None;
            }
            let regions = regions.as_ref().map(|regions| &regions[..2]);
            example.replace(place, &[first, second], regions);
        }
        example
    }

    /// Computes the means and deviations over the pairs of the training.
    ///
    /// # Errors
    /// Those of [`PartFeatures::of_pair`], for a part that has no Dirichlet spectrum.
    pub fn scaling(&self) -> Result<Scaling> {
        let mut features = vec![Moments::default(); K * FEATURES];
        let mut outputs = vec![Moments::default(); K];
        for pair in &self.training {
            let input = PartFeatures::of_pair(&pair.first, &pair.second)?;
            for part in &input.features {
                let values = features.iter_mut().zip(part.as_flattened());
                values.for_each(|(moments, &value)| moments.add(value));
            }
            for (moments, share) in outputs.iter_mut().zip(shares(&pair.union, &input)) {
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

/// Returns the masks of the parts of those training pairs that several shapes share.
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

    /// Returns the deviation; at least a minimum, so that nearly constant values are not amplified.
    fn deviation(&self) -> f64 {
        let variance = self.squares / self.count.max(1.0) - self.mean() * self.mean();
        variance.max(0.0).sqrt().max(1e-2)
    }
}
