use std::collections::{BTreeMap, BTreeSet, HashMap};

use catamaran::base::Rng;

use super::Pair;
use crate::dataset::{Dataset, Spectrum, TEST_B, TRAIN, Template};

/// Least number of vertices that two parts have in common.
const OVERLAP: u32 = 50;

/// Further unions among the masks of the training samples: every two masks whose union is a third one, for every shape that has
/// spectra of all three.
///
/// Left out are pairs that test, unions that test, and those that the protocol rules out as ambiguous: where
/// the mirror image of one part, which has the same spectrum, gives a smaller union.
#[derive(Debug, Clone, Default)]
pub struct Mined {
    shapes: Vec<Shape>,
    families: Vec<Family>,
}

/// Spectra of a shape by mask, and its family.
#[derive(Debug, Clone)]
struct Shape {
    family: usize,
    spectra: BTreeMap<usize, Spectrum>,
}

/// Masks of pairs and their union.
#[derive(Debug, Clone, Default)]
struct Family {
    proper: Vec<[usize; 3]>,
    /// A part of the other.
    contained: Vec<[usize; 2]>,
}

impl Mined {
    /// Adds those of a data set, but for unions `without`.
    pub fn add(&mut self, dataset: &Dataset, without: &BTreeSet<usize>) {
        let before = self.families.len();
        let samples = &dataset.samples;
        let all = 0..samples.part1.len();
        let mut shapes: BTreeMap<[usize; 3], Shape> = BTreeMap::new();
        let (mut trained, mut tested) = (BTreeSet::new(), BTreeSet::new());
        let mut unions = without.clone();
        for i in all {
            let family = samples.family[i];
            let pair = sorted(samples.mask1[i], samples.mask2[i]);
            if samples.split[i] == TEST_B {
                unions.insert(samples.mask_union[i]);
            }
            if samples.split[i] != TRAIN {
                tested.insert((family, pair));
                continue;
            }
            trained.insert((family, pair));
            let shape = shapes
                .entry([family, samples.identity[i], samples.pose[i]])
                .or_insert_with(|| Shape { family: before + family, spectra: BTreeMap::new() });
            shape.spectra.insert(samples.mask1[i], samples.part1[i]);
            shape.spectra.insert(samples.mask2[i], samples.part2[i]);
            shape.spectra.insert(samples.mask_union[i], samples.union[i]);
        }
        let shapes: Vec<Shape> = shapes.into_values().collect();
        for (family, template) in dataset.templates.iter().enumerate() {
            let mut ids: Vec<usize> = shapes
                .iter()
                .filter(|shape| shape.family == before + family)
                .flat_map(|shape| shape.spectra.keys().copied())
                .collect();
            ids.sort_unstable();
            ids.dedup();
            ids.retain(|id| !unions.contains(id));
            let mut found = unions_among(template, &ids);
            found.proper.retain(|[a, b, _]| {
                let pair = (family, sorted(*a, *b));
                trained.contains(&pair) || !tested.contains(&pair)
            });
            self.families.push(found);
        }
        self.shapes.extend(shapes);
    }

    /// Pairs of masks with a union that is neither of them, and pairs of which one lies in the other.
    pub fn counts(&self) -> (usize, usize) {
        let sum = |of: fn(&Family) -> usize| self.families.iter().map(of).sum();
        (sum(|family| family.proper.len()), sum(|family| family.contained.len()))
    }

    /// A random pair, of a part and a mask around it if `contained`; `None` if there is none.
    pub fn draw(&self, contained: bool, rng: &mut Rng) -> Option<Pair> {
        /// A shape may lack a mask.
        const ATTEMPTS: usize = 20;
        let below = |n: usize, rng: &mut Rng| (rng.uniform() * n as f64) as usize;
        (0..ATTEMPTS).find_map(|_| {
            let shape = self.shapes.get(below(self.shapes.len(), rng))?;
            let family = self.families.get(shape.family)?;
            let [a, b, c] = if contained {
                let [a, b] = *family.contained.get(below(family.contained.len(), rng))?;
                [a, b, b]
            } else {
                *family.proper.get(below(family.proper.len(), rng))?
            };
            let spectrum = |mask: usize| shape.spectra.get(&mask).copied();
            let pair = Pair { first: spectrum(a)?, second: spectrum(b)?, union: spectrum(c)? };
            // A closed surface is no part.
            let part = |values: &Spectrum| values[0] > 1e-6 * values[values.len() - 1];
            (part(&pair.first) && part(&pair.second)).then_some(pair)
        })
    }
}

fn sorted(a: usize, b: usize) -> [usize; 2] {
    [a.min(b), a.max(b)]
}

type Bits = Vec<u64>;

/// All of these masks of a template whose union is one of them.
fn unions_among(template: &Template, ids: &[usize]) -> Family {
    let words = template.vertices.len().div_ceil(64);
    let bits = |vertices: &mut dyn Iterator<Item = usize>| {
        let mut bits: Bits = vec![0; words];
        vertices.for_each(|v| bits[v / 64] |= 1 << (v % 64));
        bits
    };
    let masks: Vec<(usize, Bits, Bits)> = ids
        .iter()
        .filter_map(|&id| {
            let vertices = template.mask(id)?;
            let mirrored = bits(&mut vertices.iter().map(|&v| template.mirror[v]));
            Some((id, bits(&mut vertices.iter().copied()), mirrored))
        })
        .collect();
    let known: HashMap<&Bits, usize> = masks.iter().map(|(id, bits, _)| (bits, *id)).collect();
    let joined = |a: &Bits, b: &Bits| -> Bits { a.iter().zip(b).map(|(a, b)| a | b).collect() };
    let count = |bits: &Bits| bits.iter().map(|word| word.count_ones()).sum::<u32>();
    let mut found = Family::default();
    for (at, (a, bits_a, mirrored)) in masks.iter().enumerate() {
        for (b, bits_b, _) in &masks[..at] {
            let union = joined(bits_a, bits_b);
            let Some(&c) = known.get(&union) else { continue };
            if c == *a {
                found.contained.push([*b, *a]);
            } else if c == *b {
                found.contained.push([*a, *b]);
            } else {
                let size = count(&union);
                let overlap = count(bits_a) + count(bits_b) - size;
                if overlap >= OVERLAP && count(&joined(mirrored, bits_b)) >= size {
                    found.proper.push([*a, *b, c]);
                }
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use catamaran::faer::Mat;

    use super::*;

    /// A row of 400 vertices, mirrored end to end, whose masks are ranges; spectra tell them apart.
    fn dataset(pairs: &[([usize; 2], [usize; 2], usize)]) -> Dataset {
        let mut ranges: Vec<[usize; 2]> =
            pairs.iter().flat_map(|&(a, b, _)| [a, b, [a[0].min(b[0]), a[1].max(b[1])]]).collect();
        ranges.sort_unstable();
        ranges.dedup();
        let mut template = Template {
            vertices: vec![[0.0; 3]; 400],
            faces: vec![],
            mirror: (0..400).rev().collect(),
            mass: vec![],
            eigenvalues: vec![],
            eigenfunctions: Mat::zeros(0, 0),
            masks: (0..ranges.len()).collect(),
            mask_starts: vec![0],
            mask_vertices: vec![],
        };
        for range in &ranges {
            template.mask_vertices.extend(range[0]..range[1]);
            template.mask_starts.push(template.mask_vertices.len());
        }
        let mut dataset = Dataset { templates: vec![template], ..Dataset::default() };
        let samples = &mut dataset.samples;
        for &(a, b, split) in pairs {
            let union = [a[0].min(b[0]), a[1].max(b[1])];
            let id = |range| ranges.binary_search(&range).unwrap();
            let spectrum = |range: [usize; 2]| [1.0 / (range[1] - range[0]) as f64; 20];
            samples.mask1.push(id(a));
            samples.mask2.push(id(b));
            samples.mask_union.push(id(union));
            samples.part1.push(spectrum(a));
            samples.part2.push(spectrum(b));
            samples.union.push(spectrum(union));
            samples.split.push(split);
            for column in [&mut samples.family, &mut samples.identity, &mut samples.pose] {
                column.push(0);
            }
        }
        dataset
    }

    fn mined(dataset: &Dataset) -> Mined {
        let mut mined = Mined::default();
        mined.add(dataset, &BTreeSet::new());
        mined
    }

    #[test]
    fn unions_are_found_that_no_sample_has() {
        // [0, 180) and [120, 240) are of no sample together, but all three masks are there.
        let set = dataset(&[
            ([0, 180], [0, 100], TRAIN),
            ([100, 240], [0, 160], TRAIN),
            ([120, 240], [110, 130], TRAIN),
        ]);
        let mut both = mined(&set);
        let (proper, contained) = both.counts();
        both.add(&set, &BTreeSet::new());
        assert_eq!(both.counts(), (2 * proper, 2 * contained));
        assert!(proper >= 2 && contained >= 3, "{proper} {contained}");
        let mut rng = Rng::new(1);
        for _ in 0..50 {
            let pair = both.draw(false, &mut rng).unwrap();
            assert!(pair.union[0] < pair.first[0].min(pair.second[0]));
            let pair = both.draw(true, &mut rng).unwrap();
            assert_eq!(pair.union, pair.second);
        }
    }

    #[test]
    fn what_tests_is_left_out_and_so_is_what_is_ambiguous() {
        let known = ([0, 180], [120, 240], TRAIN);
        assert_eq!(mined(&dataset(&[known])).counts().0, 1);
        // The same pair, and the same union of others, as a test.
        let tested = ([0, 200], [100, 240], TEST_B);
        assert_eq!(mined(&dataset(&[known, tested])).counts().0, 0);
        // The mirror image of [0, 180), [220, 400), gives a smaller union with [150, 400).
        let ambiguous = ([0, 180], [120, 400], TRAIN);
        assert_eq!(mined(&dataset(&[ambiguous])).counts().0, 0);
        assert!(mined(&Dataset::default()).draw(false, &mut Rng::new(1)).is_none());
    }
}
