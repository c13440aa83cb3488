//! The shapes of a data set, and the use of each.

use std::collections::BTreeSet;

use catamaran::base::Rng;
use catamaran::{Error, Result};

use super::{
    KNOWN_IDENTITY, TEST_A, TEST_B, TRAIN, UNKNOWN_BODY, UNKNOWN_FAMILY, UNKNOWN_IDENTITY, packed,
};
use crate::cuts::{CutOptions, Cuts, Pair, below};
use crate::families::{CARICATURE, Family, mixed};

/// The size of a data set.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DatasetOptions {
    /// Seed of all random numbers. Default 1.
    pub seed: u64,
    /// Approximate number of vertices of a template. Default 2500.
    pub vertices: usize,
    /// Number of humanoids of body type A in the training. Default 32.
    pub known: usize,
    /// Number of humanoids of each body type that are not in the training. Default 5.
    pub unknown: usize,
    /// Number of identities of each other family. Default 2.
    pub others: usize,
    /// Number of poses of each identity. Default 2.
    pub poses: usize,
    /// Numbers of parts of each family.
    pub cuts: CutOptions,
    /// Number of further shapes of the training, each in another pose and with its own parts; half
    /// of them are remeshed. Of every four rounds, one has the known humanoids, two have new ones
    /// of type A, and one has caricatures. They teach the network about unknown identities and
    /// unions. Default 4000.
    pub varied: usize,
    /// Number of creatures in the training; half of them are remeshed. They teach the network about
    /// unknown families. Default 320.
    pub creatures: usize,
}

impl Default for DatasetOptions {
    fn default() -> Self {
        let cuts = CutOptions::default();
        Self {
            seed: 1,
            vertices: 2500,
            known: 32,
            unknown: 5,
            others: 2,
            poses: 2,
            cuts,
            varied: 4000,
            creatures: 320,
        }
    }
}

impl DatasetOptions {
    /// Returns the options of a small data set for experiments: about 60 shapes instead of 4,500,
    /// with smaller templates and fewer parts.
    pub fn small() -> Self {
        let cuts =
            CutOptions { regions: 24, pairs: 36, composites: 0, splits: 24, triples: 5, seed: 1 };
        Self {
            vertices: 2000,
            known: 8,
            unknown: 2,
            others: 1,
            poses: 2,
            cuts,
            varied: 8,
            creatures: 4,
            ..Self::default()
        }
    }

    /// Returns the cuts of a shape with its own parts.
    pub(super) fn own_cuts(&self, job: &Job) -> CutOptions {
        let mut seeds =
            vec![self.seed, self.cuts.seed, job.identity as u64, job.pose as u64, 0x0C75];
        if job.parts == Parts::Creature {
            seeds.push(job.family as u64);
        }
        let seed = mixed(&seeds);
        let CutOptions { regions, pairs, splits, .. } = self.cuts;
        match job.parts {
            Parts::Fresh | Parts::Creature => CutOptions {
                regions: regions / 2,
                pairs: pairs / 2,
                composites: pairs / 4,
                splits: splits / 2,
                triples: 0,
                seed,
            },
            Parts::Common | Parts::Varied => CutOptions {
                regions: regions / 2,
                pairs: pairs / 2,
                composites: pairs,
                splits: splits / 2,
                triples: 0,
                seed,
            },
        }
    }

    /// Checks the sizes; [`Error::Argument`] names the one that is out of range.
    pub(super) fn check(&self) -> Result<()> {
        let ranges = [
            ("known", self.known, 1),
            ("unknown", self.unknown, 0),
            ("others", self.others, 0),
            ("poses", self.poses, 1),
            ("regions", self.cuts.regions, 2),
            ("pairs", self.cuts.pairs, 1),
            ("splits", self.cuts.splits, 0),
            ("triples", self.cuts.triples, 0),
            ("varied", self.varied, 0),
            ("creatures", self.creatures, 0),
        ];
        for (what, value, least) in ranges {
            if !(least..=10_000).contains(&value) {
                let why = format!("must be from {least} to 10000, is {value}");
                return Err(Error::Argument { what, why });
            }
        }
        Ok(())
    }
}

/// A shape of the plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Job {
    pub family: Family,
    pub identity: usize,
    pub body: usize,
    pub pose: usize,
    pub knowledge: usize,
    pub remeshed: bool,
    pub parts: Parts,
}

/// The parts of a shape.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Parts {
    /// The parts of its family.
    Common,
    /// Its own parts, for tests.
    Fresh,
    /// Its own parts, for the training.
    Varied,
    /// Its own parts on its own template, for the training.
    Creature,
}

impl Job {
    /// Returns whether the pose is in no training sample.
    pub fn is_test(&self, poses: usize) -> bool {
        let last = poses > 1 && self.pose + 1 == poses;
        match self.parts {
            Parts::Varied | Parts::Creature => false,
            Parts::Fresh => true,
            Parts::Common => {
                let held_out = last && self.identity.is_multiple_of(HELD_OUT_POSES);
                self.remeshed || self.knowledge != KNOWN_IDENTITY || held_out
            }
        }
    }
}

/// The last pose of one in this many known identities is for tests.
const HELD_OUT_POSES: usize = 5;

/// One in this many unions is for tests, and one in this many pairs that share their union with
/// others.
const HELD_OUT_UNIONS: usize = 12;
const HELD_OUT_PAIRS: usize = 8;

/// Masks count as the same union when their intersection over union is larger than this.
const SAME: f64 = 0.95;

/// Number of rounds of varied shapes: one of the known humanoids, two of new ones of type A, and
/// one of caricatures.
const ROUNDS: usize = 4;
/// First identity of the varied shapes that are not known humanoids.
const FIRST_VARIED: usize = 100_000;

/// Returns the shapes in the order of the data set: humanoids, the other families, varied shapes,
/// and creatures.
pub(super) fn jobs(options: &DatasetOptions) -> Vec<Job> {
    let DatasetOptions { known, unknown, .. } = *options;
    let mut jobs = Vec::new();
    for family in Family::TEMPLATED {
        let identities = match family {
            Family::Humanoid => known + 2 * unknown,
            _ => options.others,
        };
        for identity in 0..identities {
            let (body, knowledge) = match family {
                Family::Humanoid if identity < known => (0, KNOWN_IDENTITY),
                Family::Humanoid if identity < known + unknown => (0, UNKNOWN_IDENTITY),
                Family::Humanoid => (1, UNKNOWN_BODY),
                _ => (identity % 2, UNKNOWN_FAMILY),
            };
            for pose in 0..options.poses {
                let (remeshed, parts) = (false, Parts::Common);
                let job = Job { family, identity, body, pose, knowledge, remeshed, parts };
                jobs.push(job);
                // One pose of every test identity.
                if pose + 1 == options.poses && job.is_test(options.poses) {
                    jobs.push(Job { remeshed: true, ..job });
                    if family == Family::Humanoid {
                        let fresh = Job { pose: options.poses, parts: Parts::Fresh, ..job };
                        jobs.extend([fresh, Job { remeshed: true, ..fresh }]);
                    }
                }
            }
        }
    }
    for number in 0..options.varied {
        let round = number / known;
        let (identity, body) = match round % ROUNDS {
            0 => (number % known, 0),
            last if last + 1 == ROUNDS => (FIRST_VARIED + number, CARICATURE),
            _ => (FIRST_VARIED + number, 0),
        };
        jobs.push(Job {
            family: Family::Humanoid,
            identity,
            body,
            // Smaller numbers are in use.
            pose: options.poses + 1 + round,
            knowledge: KNOWN_IDENTITY,
            remeshed: (number + round) % 2 == 1,
            parts: Parts::Varied,
        });
    }
    jobs.extend((0..options.creatures).map(|identity| Job {
        family: Family::Creature,
        identity,
        body: 0,
        pose: 0,
        knowledge: KNOWN_IDENTITY,
        remeshed: identity % 2 == 1,
        parts: Parts::Creature,
    }));
    jobs
}

/// The pairs of a family that are for tests, in all shapes.
pub(super) struct HeldOut {
    /// For each pair, [`TRAIN`], [`TEST_A`] or [`TEST_B`].
    splits: Vec<usize>,
    /// Id of the mask of the complete shape.
    complete: usize,
    /// Unions of fresh parts that are complete, or nearly so; some training samples have them.
    nearly_complete: BTreeSet<usize>,
    /// Unions of the tests, packed.
    tests: Vec<Vec<usize>>,
}

impl HeldOut {
    /// Draws some unions, and some pairs that share their union with others.
    pub fn new(cuts: &Cuts, family: Family, seed: u64) -> Self {
        let complete = cuts.complete();
        if family != Family::Humanoid {
            let splits = vec![TEST_B; cuts.pairs.len()];
            return Self { splits, complete, nearly_complete: BTreeSet::new(), tests: vec![] };
        }
        let mut rng = Rng::new(mixed(&[seed, 0x5911]));
        let mut unions: Vec<usize> = cuts.pairs.iter().map(|pair| pair.union).collect();
        unions.sort_unstable();
        unions.dedup();
        unions.retain(|&union| union != complete);
        let count = unions.len().div_ceil(HELD_OUT_UNIONS);
        let unions = drawn(unions, count, &mut rng);
        let split = |pair: &Pair| if unions.contains(&pair.union) { TEST_B } else { TRAIN };
        let mut splits: Vec<usize> = cuts.pairs.iter().map(split).collect();
        let trained: Vec<usize> = (0..splits.len()).filter(|&i| splits[i] == TRAIN).collect();
        let shares = |i: usize, j: usize| i != j && cuts.pairs[i].union == cuts.pairs[j].union;
        let shared: Vec<usize> =
            trained.iter().copied().filter(|&i| trained.iter().any(|&j| shares(i, j))).collect();
        let count = shared.len() / HELD_OUT_PAIRS;
        for i in drawn(shared, count, &mut rng) {
            // One of the pairs that share a union remains for the training.
            if trained.iter().any(|&j| shares(i, j) && splits[j] == TRAIN) {
                splits[i] = TEST_A;
            }
        }
        let tests = unions.iter().map(|union| packed(&cuts.masks[union])).collect();
        Self { splits, complete, nearly_complete: BTreeSet::from([complete]), tests }
    }

    /// Returns the use of a pair with this number and union, of a shape.
    pub fn split(&self, pair: usize, union: usize, job: &Job, poses: usize) -> usize {
        match job.parts {
            Parts::Varied | Parts::Creature => TRAIN,
            Parts::Fresh if self.nearly_complete.contains(&union) => TEST_A,
            Parts::Fresh => TEST_B,
            Parts::Common => match self.splits[pair] {
                TRAIN if job.is_test(poses) => TEST_A,
                split => split,
            },
        }
    }

    /// Adds the unions of fresh parts to those of the tests.
    pub fn test_with(&mut self, fresh: &Cuts) {
        let unions: BTreeSet<usize> = fresh.pairs.iter().map(|pair| pair.union).collect();
        for union in unions.into_iter().filter(|union| *union != self.complete) {
            let mask = &fresh.masks[&union];
            let inside = mask.iter().filter(|inside| **inside).count();
            if inside as f64 >= SAME * mask.len() as f64 {
                self.nearly_complete.insert(union);
            }
            self.tests.push(packed(mask));
        }
    }

    /// Removes those pairs of a varied shape whose union is equal or similar to a union of the
    /// tests, unless the union is complete, and the masks that are not used any more.
    pub fn withhold(&self, own: &mut Cuts) {
        let masks = &own.masks;
        own.pairs.retain(|pair| {
            let union = packed(&masks[&pair.union]);
            pair.union == self.complete
                || self.tests.iter().all(|test| overlap_over_union(test, &union) < SAME)
        });
        let used: BTreeSet<usize> =
            own.pairs.iter().flat_map(|pair| [pair.parts[0], pair.parts[1], pair.union]).collect();
        own.masks.retain(|id, _| used.contains(id));
    }
}

/// Returns the number of vertices in both packed masks, divided by the number in either.
fn overlap_over_union(a: &[usize], b: &[usize]) -> f64 {
    let count = |of: fn(usize, usize) -> usize| -> u32 {
        a.iter().zip(b).map(|(&a, &b)| of(a, b).count_ones()).sum()
    };
    f64::from(count(|a, b| a & b)) / f64::from(count(|a, b| a | b).max(1))
}

/// Draws `count` of the numbers at random.
fn drawn(mut numbers: Vec<usize>, count: usize, rng: &mut Rng) -> Vec<usize> {
    for i in 0..count.min(numbers.len()) {
        let j = i + below(numbers.len() - i, rng);
        numbers.swap(i, j);
    }
    numbers.truncate(count);
    numbers
}
