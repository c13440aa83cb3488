//! Farthest points in batches: nearly as uniform as farthest points one after the other, and in
//! parallel.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

use super::cells::{Growth, Seed};
use super::surface::{SHORTEST, Surface};
use crate::mesh::vector::distance;
use catamaran::base::{Error, Par, Progress, Result};

/// Ratio of successive thresholds. The result covers the surface within 2 / 0.9 times the best
/// radius, where single farthest points (Gonzalez 1985) achieve 2.
const SHRINK: f32 = 0.9;

/// Bound of the ratio of the length of a path along edges to the distance in space, which is rarely
/// exceeded.
const DETOUR: f32 = 1.5;

/// Number of vertices that one thread tests at a time.
const BLOCK: usize = 1 << 16;

/// Adds samples, each the start of a cell, until there are `n`; the samples so far have not grown
/// yet. `area` is the area of the surface. All lengths are stretched.
///
/// All vertices farther from the samples than a threshold are candidates; among them, the farthest
/// first, vertices are taken whose distance from each other in space, and therefore along edges, is
/// at least the threshold. The threshold is lowered when none is left. So samples are always at
/// least the threshold apart, and whenever it is lowered, no vertex is farther from them.
pub(super) fn add_samples(
    surface: &Surface<'_>,
    area: f64,
    growth: &mut Growth,
    samples: &mut Vec<u32>,
    n: usize,
    par: Par,
    progress: Progress<'_>,
) -> Result<()> {
    // At this distance, about half of all samples fit into the area.
    let spacing = (1.6 * area / n as f64).sqrt() / surface.scale;
    let mut threshold = (spacing as f32).max(SHORTEST);
    let mut cutoff = DETOUR * threshold;
    let mut settled = false;
    growth.grow(surface, &seeds(samples, 0), cutoff)?;
    while samples.len() < n {
        progress.report(samples.len() as f64 / n as f64)?;
        let candidates = farther_than(surface, growth, threshold, par);
        if candidates.is_empty() {
            // From here on every vertex is in a cell, and cells end where others are nearer.
            cutoff = f32::INFINITY;
            settled = true;
            let farthest = farthest(growth, surface.len());
            if farthest <= 0.0 {
                let why = format!("{n}, but there are no more than {} vertices", samples.len());
                return Err(Error::Argument { what: "n", why });
            }
            threshold = SHRINK * threshold.min(farthest);
            continue;
        }
        let left = n - samples.len();
        let mut taken = apart(surface, &candidates, f64::from(threshold) * surface.scale);
        if !settled && taken.len() > (3 * left).div_ceil(4) {
            // The area is a poor measure of the size of this surface.
            threshold *= 1.4;
            cutoff = DETOUR * threshold;
            growth.clear();
            growth.grow(surface, &seeds(samples, 0), cutoff)?;
            continue;
        }
        settled = true;
        taken.truncate(left);
        let first = samples.len();
        samples.extend(taken);
        growth.grow(surface, &seeds(samples, first), cutoff)?;
    }
    growth.grow_on(surface)?;
    Ok(())
}

/// Returns the samples from `first` on as starts of cells with the same indices.
pub(super) fn seeds(samples: &[u32], first: usize) -> Vec<Seed> {
    let numbered = samples.iter().zip(0..).skip(first);
    numbered.map(|(&vertex, cell)| Seed { vertex, distance: 0.0, cell }).collect()
}

fn farthest(growth: &Growth, vertices: usize) -> f32 {
    (0..vertices as u32).map(|v| growth.distance(v)).filter(|d| d.is_finite()).fold(0.0, f32::max)
}

/// Returns the vertices that have faces and are at least that far from the samples, the farthest
/// first, in order of index for equal distances.
fn farther_than(surface: &Surface<'_>, growth: &Growth, threshold: f32, par: Par) -> Vec<u32> {
    let blocks = par.map_blocks(surface.len(), BLOCK, |range| {
        let keys = range.map(|v| (growth.distance(v as u32), v as u32));
        let far =
            keys.filter(|&(distance, v)| distance >= threshold && !surface.links(v).is_empty());
        far.map(|(distance, v)| u64::from(!distance.to_bits()) << 32 | u64::from(v))
            .collect::<Vec<_>>()
    });
    let mut keys = blocks.concat();
    keys.sort_unstable();
    keys.into_iter().map(|key| key as u32).collect()
}

/// Returns those of these vertices, in their order, whose stretched distance from all taken before
/// is at least `least`.
fn apart(surface: &Surface<'_>, candidates: &[u32], least: f64) -> Vec<u32> {
    let near = |v: u32, w: u32| {
        let away = distance(surface.position(v), surface.position(w));
        away * surface.stretch.between(v, w) < least
    };
    let mut taken: Vec<u32> = Vec::new();
    // For each taken vertex the previous one in its box.
    let mut before: Vec<u32> = Vec::new();
    let mut layers = Layers::new(surface.stretch.range(), least);
    // Neighbours in the list are neighbours in space: the sample that covered the last vertex often
    // covers this one.
    let mut cover: Option<u32> = None;
    for &v in candidates {
        if cover.is_some_and(|w| near(v, w)) {
            continue;
        }
        let p = surface.position(v);
        let covering = layers.all.iter().find_map(|layer| {
            let middle = layer.place(p);
            NEIGHBOURHOOD.iter().find_map(|step| {
                let key = key([0, 1, 2].map(|k| middle[k].wrapping_add(step[k])));
                let mut at = layer.boxes.get(&key).copied();
                while let Some(number) = at {
                    let w = taken[number as usize];
                    if near(v, w) {
                        return Some(w);
                    }
                    at = Some(before[number as usize]).filter(|&number| number != NONE);
                }
                None
            })
        });
        cover = covering.or(Some(v));
        if covering.is_none() {
            let number = taken.len() as u32;
            let layer = layers.of(surface.stretch.at(v));
            let key = key(layer.place(p));
            before.push(layer.boxes.insert(key, number).unwrap_or(NONE));
            taken.push(v);
        }
    }
    taken
}

/// Taken vertices in boxes: a layer for those whose stretches are within a factor of two.
struct Layers {
    all: Vec<Layer>,
    /// The least stretch.
    first: f64,
}

/// Boxes as large as the largest distance of a vertex that one in them covers.
struct Layer {
    side: f64,
    /// For each box the last vertex taken in it.
    boxes: HashMap<u64, u32, BuildHasherDefault<Multiply>>,
}

impl Layers {
    fn new([first, last]: [f64; 2], least: f64) -> Self {
        let count = 1 + (last / first).log2().max(0.0) as i32;
        // A vertex with a small stretch is covered at up to twice the distance.
        let reach = if count == 1 { 1.0 } else { 2.0 };
        let side = |layer: i32| reach * least / (first * 2f64.powi(layer));
        let layer = |layer| Layer { side: side(layer), boxes: HashMap::default() };
        Self { all: (0..count).map(layer).collect(), first }
    }

    /// Returns the layer of vertices with this stretch.
    fn of(&mut self, stretch: f64) -> &mut Layer {
        let last = self.all.len() - 1;
        &mut self.all[((stretch / self.first).log2().max(0.0) as usize).min(last)]
    }
}

impl Layer {
    fn place(&self, p: [f64; 3]) -> [i64; 3] {
        p.map(|x| (x / self.side).floor() as i64)
    }
}

const NONE: u32 = u32::MAX;

/// The offsets of a box and those around it.
const NEIGHBOURHOOD: [[i64; 3]; 27] = {
    let mut steps = [[0; 3]; 27];
    let mut i = 0;
    while i < 27 {
        // In order of distance from the middle: steps of 0, 1 and -1 in each direction.
        let step = [i % 3, i / 3 % 3, i / 9];
        let mut k = 0;
        while k < 3 {
            steps[i][k] = [0, 1, -1][step[k]];
            k += 1;
        }
        i += 1;
    }
    steps
};

/// Returns a key with 21 bits for each coordinate; distances distinguish boxes with the same key.
fn key(place: [i64; 3]) -> u64 {
    place.iter().fold(0, |key, &x| key << 21 | (x as u64 & 0x1f_ffff))
}

/// A hash by one multiplication (Fibonacci hashing, Knuth), for keys that are numbers.
#[derive(Default)]
pub(super) struct Multiply(u64);

impl Hasher for Multiply {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.write_u64(u64::from(byte));
        }
    }

    fn write_u32(&mut self, x: u32) {
        self.write_u64(u64::from(x));
    }

    fn write_u64(&mut self, x: u64) {
        let product = (self.0 ^ x).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        self.0 = product ^ product >> 32;
    }
}
