//! Which shapes a data set has, and what they are for.

use std::collections::BTreeSet;

use catamaran::base::Rng;
use catamaran::{Error, Result};

use super::{
    KNOWN_IDENTITY, TEST_A, TEST_B, TRAIN, UNKNOWN_BODY, UNKNOWN_FAMILY, UNKNOWN_IDENTITY, packed,
};
use crate::cuts::{CutOptions, Cuts, Pair, below};
use crate::families::{CARICATURE, Family, mixed};

/// How large a data set is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DatasetOptions {
    /// Seed of everything. Default 1.
    pub seed: u64,
    /// Vertices of a template, about. Default 2500.
    pub vertices: usize,
    /// Humanoids of body type A to train on. Default 32.
    pub known: usize,
    /// Humanoids never trained on, of each body type. Default 5.
    pub unknown: usize,
    /// Identities of each other family. Default 2.
    pub others: usize,
    /// Poses of each identity. Default 2.
    pub poses: usize,
    /// Parts of each family.
    pub cuts: CutOptions,
    /// Further shapes to train on, each in another pose and with parts of its own, half of them
    /// remeshed: in every fourth round the known humanoids, in two new ones of type A, in one
    /// caricatures. What is learnt about identities and unions never seen comes from them. Default
    /// 4000.
    pub varied: usize,
    /// Creatures to train on, half of them remeshed: what is learnt about shapes of families never
    /// seen comes from them. Default 320.
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
    /// A tenth, with small templates: to try things.
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

    /// How a shape is cut that has parts of its own.
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

    /// [`Error::Argument`] names what is too small or too large.
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
                let why = format!("{value}, not from {least} to 10000");
                return Err(Error::Argument { what, why });
            }
        }
        Ok(())
    }
}

/// A shape.
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

/// Which parts a shape has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Parts {
    /// Those of its family.
    Common,
    /// Its own, to test with.
    Fresh,
    /// Its own, to train on.
    Varied,
    /// Its own, on a template of its own, to train on.
    Creature,
}

impl Job {
    /// Whether no training sample has this pose.
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

/// Of one in so many known identities the last pose is a test.
const HELD_OUT_POSES: usize = 5;

/// Of the unions one in so many is a test, of the pairs whose union others have as well.
const HELD_OUT_UNIONS: usize = 12;
const HELD_OUT_PAIRS: usize = 8;

/// Masks nearer to each other than this (intersection over union) count as the same union.
const SAME: f64 = 0.95;

/// Rounds of varied shapes: one of the known humanoids, then new ones of type A, then caricatures.
const ROUNDS: usize = 4;
/// Identities from here on are those of varied shapes that are not known ones.
const FIRST_VARIED: usize = 100_000;

/// The shapes, in the order in which the data set has them: humanoids first, then the other
/// families, the varied ones and creatures.
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
                // Of every tested identity one pose.
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
            // Those below are taken.
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

/// Which pairs of a family are tests, whatever the shape.
pub(super) struct HeldOut {
    /// For each pair [`TRAIN`], [`TEST_A`] or [`TEST_B`].
    splits: Vec<usize>,
    /// The complete shape.
    complete: usize,
    /// Unions of fresh parts that are complete, or close to it: some training samples have them.
    nearly_complete: BTreeSet<usize>,
    /// Unions that test, packed.
    tests: Vec<Vec<usize>>,
}

impl HeldOut {
    /// Some unions, and some pairs whose union others have.
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
            // One of those that share a union stays to be trained on.
            if trained.iter().any(|&j| shares(i, j) && splits[j] == TRAIN) {
                splits[i] = TEST_A;
            }
        }
        let tests = unions.iter().map(|union| packed(&cuts.masks[union])).collect();
        Self { splits, complete, nearly_complete: BTreeSet::from([complete]), tests }
    }

    /// What the pair of this number and union is for, of a shape.
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

    /// Counts the unions of these fresh parts among those that test.
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

    /// Takes the pairs out of the cuts of a varied shape whose union is a test, or close to one,
    /// but not complete, and the masks that nothing needs any more.
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

/// Vertices in both packed masks over vertices in either.
fn overlap_over_union(a: &[usize], b: &[usize]) -> f64 {
    let count = |of: fn(usize, usize) -> usize| -> u32 {
        a.iter().zip(b).map(|(&a, &b)| of(a, b).count_ones()).sum()
    };
    f64::from(count(|a, b| a & b)) / f64::from(count(|a, b| a | b).max(1))
}

/// `count` of these numbers, at random.
fn drawn(mut numbers: Vec<usize>, count: usize, rng: &mut Rng) -> Vec<usize> {
    for i in 0..count.min(numbers.len()) {
        let j = i + below(numbers.len() - i, rng);
        numbers.swap(i, j);
    }
    numbers.truncate(count);
    numbers
}
