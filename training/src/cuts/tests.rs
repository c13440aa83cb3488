use std::collections::BTreeSet;

use super::regions::{overlap, union};
use super::*;
use crate::families::Family;

fn options() -> CutOptions {
    CutOptions { regions: 15, pairs: 15, composites: 5, splits: 12, triples: 4, seed: 3 }
}

fn of(family: Family) -> (Model, Cuts) {
    let model = Model::new(family, 1500).unwrap();
    let cuts = cuts(&model, &options(), Par::all()).unwrap();
    (model, cuts)
}

#[test]
fn pairs_overlap_and_make_their_unions() {
    for family in [Family::Humanoid, Family::Sheet] {
        let (_, cuts) = of(family);
        assert!(cuts.pairs.len() >= 20, "{family:?}: {}", cuts.pairs.len());
        for pair in &cuts.pairs {
            let [a, b] = pair.parts.map(|part| &cuts.masks[&part]);
            assert!(overlap(a, b) >= OVERLAP);
            assert_eq!(union(a, b), cuts.masks[&pair.union]);
        }
        let distinct: BTreeSet<_> = cuts.pairs.iter().map(|pair| pair.parts).collect();
        assert_eq!(distinct.len(), cuts.pairs.len());
        for (&key, mask) in &cuts.masks {
            assert_eq!(key, id(mask));
        }
        assert!(cuts.pairs.iter().any(|pair| pair.union == cuts.complete()));
    }
}

#[test]
fn of_the_unions_that_mirrored_parts_make_the_least_is_kept_on_the_left() {
    let (model, cuts) = of(Family::Humanoid);
    let surface = Surface::new(model.template(), model.mirror(), Par::all()).unwrap();
    for pair in &cuts.pairs {
        let [a, b] = pair.parts.map(|part| &cuts.masks[&part]);
        let whole = &cuts.masks[&pair.union];
        assert!(surface.leaning(whole) >= -1e-12);
        let other = union(a, &surface.mirrored(b));
        assert!(surface.area(whole) <= surface.area(&other) * (1.0 + 1e-12));
    }
}

#[test]
fn triples_unite_both_ways_to_the_same() {
    let (_, cuts) = of(Family::Humanoid);
    assert!(!cuts.triples.is_empty());
    for triple in &cuts.triples {
        let [a, b, c] = triple.parts.map(|part| &cuts.masks[&part]);
        let [ab, bc] = triple.unions.map(|union| &cuts.masks[&union]);
        assert_eq!((&union(a, b), &union(b, c)), (ab, bc));
        assert_eq!(union(ab, c), cuts.masks[&triple.whole]);
        assert_eq!(union(a, bc), cuts.masks[&triple.whole]);
    }
}

#[test]
fn the_same_options_cut_the_same_for_any_number_of_threads() {
    let model = Model::new(Family::Quadruped, 1000).unwrap();
    let one = cuts(&model, &options(), Par::Seq).unwrap();
    assert_eq!(cuts(&model, &options(), Par::Threads(3)).unwrap(), one);
    let other = CutOptions { seed: 4, ..options() };
    assert_ne!(cuts(&model, &other, Par::Seq).unwrap(), one);
}

#[test]
fn mirror_images_are_equally_far_from_the_middle() {
    let model = Model::new(Family::Humanoid, 1500).unwrap();
    let surface = Surface::new(model.template(), model.mirror(), Par::all()).unwrap();
    let middle: Vec<u32> =
        (0..).zip(model.mirror()).filter(|(v, m)| v == *m).map(|(v, _)| v).collect();
    assert!(middle.len() > 10);
    for from in middle.into_iter().step_by(7) {
        let distances = surface.distances(from).unwrap();
        let images: Vec<f64> = model.mirror().iter().map(|&m| distances[m as usize]).collect();
        assert_eq!(images, distances);
    }
}
