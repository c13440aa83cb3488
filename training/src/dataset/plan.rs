//! Which shapes a data set has, and what they are for.

use std::collections::BTreeSet;

use catamaran::base::Rng;
use catamaran::{Error, Result};

use super::{
    KNOWN_IDENTITY, TEST_A, TEST_B, TRAIN, UNKNOWN_BODY, UNKNOWN_FAMILY, UNKNOWN_IDENTITY,
};
use crate::cuts::{CutOptions, Cuts, Mask, Pair, below};
use crate::families::{Family, mixed};

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
    /// Further shapes to train on: the known humanoids in turn, each time in another pose and with parts of its own: as
    /// many regions as a family, more pairs, and no triples. What is learnt about unions never seen comes from them. Default 256.
    pub varied: usize,
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
            varied: 256,
        }
    }
}

impl DatasetOptions {
    /// A tenth, with small templates: to try things.
    pub fn small() -> Self {
        let cuts = CutOptions { regions: 24, pairs: 36, splits: 24, triples: 5, seed: 1 };
        Self {
            vertices: 2000,
            known: 8,
            unknown: 2,
            others: 1,
            poses: 2,
            cuts,
            varied: 8,
            ..Self::default()
        }
    }

    /// How a varied shape is cut.
    pub(super) fn own_cuts(&self, job: &Job) -> CutOptions {
        let seed =
            mixed(&[self.seed, self.cuts.seed, job.identity as u64, job.pose as u64, 0x0C75]);
        let CutOptions { regions, pairs, splits, .. } = self.cuts;
        CutOptions { regions, pairs: 3 * pairs, splits: 2 * splits, triples: 0, seed }
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
    /// Whether its parts are its own, not those of its family.
    pub varied: bool,
}

impl Job {
    /// Whether no training sample has this pose.
    pub fn is_test(&self, poses: usize) -> bool {
        let last = poses > 1 && self.pose + 1 == poses;
        self.remeshed
            || self.knowledge != KNOWN_IDENTITY
            || (last && !self.varied && self.identity.is_multiple_of(HELD_OUT_POSES))
    }
}

/// Of one in so many known identities the last pose is a test.
const HELD_OUT_POSES: usize = 5;

/// Of the unions one in so many is a test, of the pairs whose union others have as well.
const HELD_OUT_UNIONS: usize = 12;
const HELD_OUT_PAIRS: usize = 8;

/// Masks nearer to each other than this (intersection over union) count as the same union.
const SAME: f64 = 0.95;

/// The shapes, in the order in which the data set has them: humanoids first, the varied ones last.
pub(super) fn jobs(options: &DatasetOptions) -> Vec<Job> {
    let DatasetOptions { known, unknown, .. } = *options;
    let mut jobs = Vec::new();
    for family in Family::ALL {
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
                let (remeshed, varied) = (false, false);
                let job = Job { family, identity, body, pose, knowledge, remeshed, varied };
                jobs.push(job);
                // Of every tested identity one pose.
                if pose + 1 == options.poses && job.is_test(options.poses) {
                    jobs.push(Job { remeshed: true, ..job });
                }
            }
        }
    }
    for number in 0..options.varied {
        jobs.push(Job {
            family: Family::Humanoid,
            identity: number % known,
            body: 0,
            // Those below are taken.
            pose: options.poses + number / known,
            knowledge: KNOWN_IDENTITY,
            remeshed: false,
            varied: true,
        });
    }
    jobs
}

/// Which pairs of a family are tests, whatever the shape.
pub(super) struct HeldOut {
    /// For each pair [`TRAIN`], [`TEST_A`] or [`TEST_B`].
    splits: Vec<usize>,
}

impl HeldOut {
    /// Some unions, and some pairs whose union others have.
    pub fn new(cuts: &Cuts, family: Family, seed: u64) -> Self {
        if family != Family::Humanoid {
            return Self { splits: vec![TEST_B; cuts.pairs.len()] };
        }
        let mut rng = Rng::new(mixed(&[seed, 0x5911]));
        let mut unions: Vec<usize> = cuts.pairs.iter().map(|pair| pair.union).collect();
        unions.sort_unstable();
        unions.dedup();
        let complete = cuts.complete();
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
        Self { splits }
    }

    /// What a pair of a shape is for.
    pub fn split(&self, pair: usize, job: &Job, poses: usize) -> usize {
        if job.varied {
            return TRAIN;
        }
        match self.splits[pair] {
            TRAIN if job.is_test(poses) => TEST_A,
            split => split,
        }
    }

    /// Takes the pairs out of the cuts of a varied shape whose union is a test of its family, or close to one, and the masks
    /// that nothing needs any more.
    pub fn withhold(&self, family: &Cuts, own: &mut Cuts) {
        let tests = family.pairs.iter().zip(&self.splits).filter(|(_, split)| **split == TEST_B);
        let tests: BTreeSet<usize> = tests.map(|(pair, _)| pair.union).collect();
        let tests: Vec<&Mask> = tests.iter().map(|union| &family.masks[union]).collect();
        let masks = &own.masks;
        own.pairs.retain(|pair| {
            let union = &masks[&pair.union];
            tests.iter().all(|test| overlap_over_union(test, union) < SAME)
        });
        let used: BTreeSet<usize> =
            own.pairs.iter().flat_map(|pair| [pair.parts[0], pair.parts[1], pair.union]).collect();
        own.masks.retain(|id, _| used.contains(id));
    }
}

/// Vertices in both masks over vertices in either.
fn overlap_over_union(a: &[bool], b: &[bool]) -> f64 {
    let count = |of: fn(bool, bool) -> bool| a.iter().zip(b).filter(|(a, b)| of(**a, **b)).count();
    count(|a, b| a && b) as f64 / count(|a, b| a || b).max(1) as f64
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
