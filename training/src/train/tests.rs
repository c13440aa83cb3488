use catamaran::io::{Output, Overwrite};

use super::*;
use crate::dataset::{Dataset, Spectrum, TEST_B, TRAIN};

/// Rectangles of height 1 that overlap to one of the widths 2 and 3: unions in closed form.
pub fn strips(count: usize, seed: u64) -> Vec<Pair> {
    let mut rng = Rng::new(seed);
    let mut between = |low: f64, high: f64| low + (high - low) * rng.uniform();
    (0..count)
        .map(|i| {
            let width = 2.0 + (i % 2) as f64;
            let end = between(0.4, 0.9) * width;
            let start = between(0.1, 0.8) * end;
            Pair {
                first: rectangle(end),
                second: rectangle(width - start),
                union: rectangle(width),
            }
        })
        .collect()
}

/// The Dirichlet spectrum of a rectangle with sides `width` and 1.
fn rectangle(width: f64) -> Spectrum {
    let square = |x: f64| (std::f64::consts::PI * x).powi(2);
    let mut all: Vec<f64> = (1..=20)
        .flat_map(|i| (1..=20).map(move |j| square(f64::from(i) / width) + square(f64::from(j))))
        .collect();
    all.sort_unstable_by(f64::total_cmp);
    std::array::from_fn(|i| all[i])
}

fn dataset(pairs: &[Pair]) -> Dataset {
    let mut dataset = Dataset::default();
    let samples = &mut dataset.samples;
    samples.part1 = pairs.iter().map(|pair| pair.first).collect();
    samples.part2 = pairs.iter().map(|pair| pair.second).collect();
    samples.union = pairs.iter().map(|pair| pair.union).collect();
    samples.split = vec![TRAIN; pairs.len()];
    for column in [
        &mut samples.family,
        &mut samples.identity,
        &mut samples.pose,
        &mut samples.mask1,
        &mut samples.mask2,
        &mut samples.mask_union,
    ] {
        column.resize(pairs.len(), 0);
    }
    dataset
}

const SMALL: Architecture =
    Architecture { width: 32, hidden: 32, first_layers: 1, second_layers: 1 };

fn trainer(par: Par) -> Trainer {
    let examples = Examples::new(&[dataset(&strips(200, 1))]).unwrap();
    let options = TrainOptions { sizes: SMALL, batch: 32, epochs: 10, ..TrainOptions::default() };
    Trainer::new(examples, options, None, par).unwrap()
}

fn relative_error(model: &SpectralUnion, pairs: &[Pair]) -> f64 {
    let errors: Vec<f64> = pairs
        .iter()
        .flat_map(|pair| {
            let found = model.predict(&pair.first, &pair.second).unwrap();
            (0..K).map(move |i| (found[i] / pair.union[i] - 1.0).abs())
        })
        .collect();
    errors.iter().sum::<f64>() / errors.len() as f64
}

#[test]
fn unions_of_strips_are_learnt() {
    let mut trainer = trainer(Par::Seq);
    let unseen = strips(60, 7);
    let before = relative_error(&trainer.model().unwrap(), &unseen);
    for _ in 0..10 {
        trainer.epoch().unwrap();
    }
    let model = trainer.model().unwrap();
    let after = relative_error(&model, &unseen);
    assert!(after < 0.7 * before, "{before} {after}");
    let strange = |pair: &Pair| model.strangeness(&[&pair.first, &pair.second]).unwrap();
    assert!(unseen.iter().filter(|pair| strange(pair) > 1.0).count() <= 10);
    // An interval is no strip.
    let interval: Spectrum = std::array::from_fn(|i| ((i + 1) * (i + 1)) as f64);
    assert!(model.strangeness(&[&interval, &interval]).unwrap() > 1.0);
}

#[test]
fn training_does_not_depend_on_threads_nor_interruptions() {
    let mut whole = trainer(Par::Seq);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("state.npz");
    let mut parallel = trainer(Par::Threads(3));
    whole.epoch().unwrap();
    parallel.epoch().unwrap();
    assert_eq!(whole.state(), parallel.state());

    let output = Output::create(&path, Overwrite::Never).unwrap();
    write_state(output, &whole.options, whole.state()).unwrap();
    let (options, state) = read_state(&path).unwrap();
    assert_eq!((options, &state), (whole.options, whole.state()));
    let examples = Examples::new(&[dataset(&strips(200, 1))]).unwrap();
    let mut resumed = Trainer::new(examples, options, Some(state), Par::Seq).unwrap();
    whole.epoch().unwrap();
    resumed.epoch().unwrap();
    assert_eq!(whole.state(), resumed.state());
    let bytes = |trainer: &Trainer| trainer.model().unwrap().to_bytes().unwrap();
    assert_eq!(bytes(&whole), bytes(&resumed));
}

#[test]
fn states_of_other_networks_and_empty_data_are_refused() {
    let one = trainer(Par::Seq);
    let examples = Examples::new(&[dataset(&strips(30, 1))]).unwrap();
    let other = TrainOptions::default();
    let refused = Trainer::new(examples, other, Some(one.state().clone()), Par::Seq);
    assert!(refused.err().unwrap().to_string().starts_with("state"));
    assert!(Examples::new(&[]).unwrap_err().to_string().starts_with("data set"));
}

#[test]
fn pairs_of_known_union_are_right_and_within_the_bound() {
    let mut rng = Rng::new(1);
    for pair in strips(50, 3) {
        let known = pair.contained(&mut rng);
        assert!(known.union == known.first || known.union == known.second);
        let disturbed = pair.disturbed(1.0, &mut rng);
        for values in [disturbed.first, disturbed.second, disturbed.union] {
            assert!(values.is_sorted() && values[0] > 0.0);
        }
        assert!((disturbed.first[K - 1] / pair.first[K - 1] - 1.0).abs() < 0.1);
    }
}

#[test]
fn what_tests_in_one_data_set_is_left_out_of_all() {
    let pairs = strips(40, 5);
    let (mut one, mut other) = (dataset(&pairs), dataset(&pairs));
    for (i, union) in other.samples.mask_union.iter_mut().enumerate() {
        *union = i % 4;
    }
    one.samples.split.fill(TEST_B);
    one.samples.mask_union.fill(2);
    let examples = Examples::new(&[one, other]).unwrap();
    assert_eq!(examples.training.len(), 30);
    assert!(examples.training.iter().all(|pair| *pair != pairs[2] && *pair != pairs[6]));
}
