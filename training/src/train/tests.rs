use catamaran::io::{Array, Output, Overwrite, read_arrays, write_arrays};

use super::*;
use catamaran::faer::Mat;

use crate::dataset::{Dataset, Spectrum, TEST_B, TRAIN, Template};

/// Returns rectangles of height 1 that overlap to one of the widths 2 and 3; the spectra of the
/// unions are known in closed form.
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
                regions: Some([0; 3]),
            }
        })
        .collect()
}

/// Returns the Dirichlet spectrum of a rectangle with sides `width` and 1.
fn rectangle(width: f64) -> Spectrum {
    let square = |x: f64| (std::f64::consts::PI * x).powi(2);
    let mut all: Vec<f64> = (1..=20)
        .flat_map(|i| (1..=20).map(move |j| square(f64::from(i) / width) + square(f64::from(j))))
        .collect();
    all.sort_unstable_by(f64::total_cmp);
    std::array::from_fn(|i| all[i])
}

/// Returns a square with the masks 0 to 3, which all cover it.
fn template() -> Template {
    Template {
        vertices: vec![[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]],
        faces: vec![0, 1, 2, 0, 2, 3],
        mirror: vec![1, 0, 3, 2],
        mass: vec![0.5; 4],
        eigenvalues: vec![0.0],
        eigenfunctions: Mat::full(4, 1, 0.5_f64.sqrt()),
        masks: (0..4).collect(),
        mask_words: vec![15; 4],
    }
}

fn dataset(pairs: &[Pair]) -> Dataset {
    let mut dataset = Dataset { templates: vec![template()], ..Dataset::default() };
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
    samples.mask1.fill(1);
    samples.mask2.fill(2);
    dataset
}

const SMALL: Architecture =
    Architecture { width: 32, hidden: 32, first_layers: 1, second_layers: 1, modes: 1 };

fn trainer(par: Par) -> Trainer {
    let examples = Examples::new(&dataset(&strips(200, 1)), Par::Seq).unwrap();
    let options = TrainOptions { sizes: SMALL, batch: 64, epochs: 20, ..TrainOptions::default() };
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
    for _ in 0..20 {
        trainer.epoch().unwrap();
    }
    let model = trainer.model().unwrap();
    let after = relative_error(&model, &unseen);
    assert!(after < 0.7 * before, "{before} {after}");
    let strange = |pair: &Pair| model.ood_score(&[&pair.first, &pair.second]).unwrap();
    assert!(unseen.iter().filter(|pair| strange(pair) > 1.0).count() <= 10);
    // An interval is not a strip.
    let interval: Spectrum = std::array::from_fn(|i| ((i + 1) * (i + 1)) as f64);
    assert!(model.ood_score(&[&interval, &interval]).unwrap() > 1.0);
}

#[test]
fn shapes_of_another_kind_are_told_from_the_template() {
    let interval =
        |length: f64| -> Spectrum { std::array::from_fn(|i| ((i + 1) as f64 / length).powi(2)) };
    let mut pairs = strips(300, 3);
    for (i, pair) in pairs.iter_mut().enumerate().filter(|(i, _)| i % 3 == 0) {
        let [a, b] = [i % 7, i % 11].map(|j| 1.0 + 0.1 * j as f64);
        *pair = Pair { first: interval(a), second: interval(b), union: interval(a + b), ..*pair };
    }
    let mut set = dataset(&pairs);
    // A mask that the template does not have.
    (0..300).step_by(3).for_each(|i| set.samples.mask_union[i] = 9);
    let examples = Examples::new(&set, Par::Seq).unwrap();
    let options = TrainOptions { sizes: SMALL, batch: 64, epochs: 20, ..TrainOptions::default() };
    let mut trainer = Trainer::new(examples, options, None, Par::Seq).unwrap();
    for _ in 0..20 {
        trainer.epoch().unwrap();
    }
    let model = trainer.model().unwrap();
    for pair in strips(30, 4) {
        assert!(model.ood_probability(&pair.first, &pair.second).unwrap() < 0.2);
        let (a, b) = (interval(1.33), interval(1.77));
        assert!(
            model.ood_probability(&a, &b).unwrap() > 0.8
                && model.ood_score(&[&a, &b]).unwrap() > 1.0
        );
    }
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
    let examples = Examples::new(&dataset(&strips(200, 1)), Par::Seq).unwrap();
    let mut resumed = Trainer::new(examples, options, Some(state), Par::Seq).unwrap();
    whole.epoch().unwrap();
    resumed.epoch().unwrap();
    assert_eq!(whole.state(), resumed.state());
    let bytes = |trainer: &Trainer| trainer.model().unwrap().to_bytes().unwrap();
    assert_eq!(bytes(&whole), bytes(&resumed));
}

#[test]
fn states_of_other_versions_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("state.npz");
    let one = trainer(Par::Seq);
    write_state(Output::create(&path, Overwrite::Never).unwrap(), &one.options, one.state())
        .unwrap();
    let arrays = read_arrays(&path).unwrap();
    assert_eq!(arrays.indices("version").unwrap(), [1]);
    for (version, why) in [
        (None, "was written by an earlier version of catamaran"),
        (Some(0), "was written by an earlier version of catamaran"),
        (Some(2), "was written by a later version of catamaran"),
    ] {
        let steps = ("adam_steps", Array::Indices(&[3]));
        let version = version.map(|version| [version]);
        let version = version.as_ref().map(|version| ("version", Array::Indices(version)));
        let arrays: Vec<_> = version.into_iter().chain([steps]).collect();
        write_arrays(Output::create(&path, Overwrite::Replace).unwrap(), &arrays).unwrap();
        let error = read_state(&path).unwrap_err().to_string();
        assert!(error.ends_with(&format!("state.npz: {why}")), "{error}");
    }
    write_arrays(Output::create(&path, Overwrite::Replace).unwrap(), &[]).unwrap();
    assert!(read_state(&path).unwrap_err().to_string().ends_with("is not a training state"));
}

#[test]
fn damaged_states_are_refused() {
    let one = trainer(Par::Seq);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("state.npz");
    let output = Output::create(&path, Overwrite::Never).unwrap();
    write_state(output, &one.options, one.state()).unwrap();
    let (file, whole) = (std::fs::read(&path).unwrap(), read_state(&path).unwrap());
    let mut refused = 0;
    let mut check = |bytes: &[u8], what: &str| {
        std::fs::write(&path, bytes).unwrap();
        match read_state(&path) {
            // Of the archive, times and the like are in no checksum: they change nothing.
            Ok(read) => assert!(read == whole, "{what}"),
            Err(e) => {
                assert!(e.to_string().contains("state.npz"), "{what}: {e}");
                refused += 1;
            }
        }
    };
    // Some 50 bytes, and those of the directory of the archive, which is at its end.
    let spread = (0..file.len()).step_by(file.len() / 50);
    for at in spread.chain(file.len() - 200..file.len()) {
        let mut bytes = file.clone();
        bytes[at] ^= 0x10;
        check(&bytes, &format!("byte {at}"));
    }
    check(&file[..file.len() - 1], "truncated");
    check(&[], "empty");
    assert!(refused > 40, "{refused}");
}

#[test]
fn states_of_other_networks_and_empty_data_are_refused() {
    let one = trainer(Par::Seq);
    let examples = Examples::new(&dataset(&strips(30, 1)), Par::Seq).unwrap();
    let sizes = Architecture { width: 16, ..SMALL };
    let other = TrainOptions { sizes, ..TrainOptions::default() };
    let refused = Trainer::new(examples, other, Some(one.state().clone()), Par::Seq);
    assert!(refused.err().unwrap().to_string().starts_with("state"));
    let empty = Examples::new(&Dataset::default(), Par::Seq);
    assert!(empty.unwrap_err().to_string().starts_with("data set"));
}

#[test]
fn pairs_of_known_union_are_right_and_within_the_bound() {
    let mut rng = Rng::new(1);
    for pair in strips(50, 3) {
        let known = pair.contained(&mut rng);
        assert!(known.union == known.first || known.union == known.second);
        let disturbed = pair.example().disturbed(1.0, &mut rng);
        for values in disturbed.parts.iter().chain([&disturbed.union]) {
            assert!(values.is_sorted() && values[0] > 0.0);
        }
        assert!((disturbed.parts[0][K - 1] / pair.first[K - 1] - 1.0).abs() < 0.2);
    }
}

#[test]
fn parts_that_are_unions_give_way_to_their_own_parts_or_get_them_beside() {
    let pairs = strips(3, 2);
    let mut set = dataset(&pairs);
    let samples = &mut set.samples;
    (samples.mask1, samples.mask2, samples.mask_union) =
        (vec![1, 3, 1], vec![2, 1, 3], vec![3, 0, 0]);
    let examples = Examples::new(&set, Par::Seq).unwrap();
    assert_eq!(examples.makers, [[None, None], [Some(0), None], [None, Some(0)]]);
    assert_eq!(examples.composites, [1, 2]);
    let mut rng = Rng::new(3);
    let three = examples.of_many(2, 3, &mut rng);
    let [a, b] = [pairs[0].first, pairs[0].second];
    assert_eq!((three.parts, three.union), (vec![pairs[2].first, a, b], pairs[2].union));
    assert_eq!(three.regions, Some(vec![1, 1, 2, 0]));
    // With four parts, one part is repeated, or the union of two is a part as well.
    let (mut twice, mut beside) = (0, 0);
    for _ in 0..50 {
        let four = examples.of_many(1, 4, &mut rng);
        assert_eq!((four.parts.len(), four.regions.map(|r| r.len())), (4, Some(5)));
        match four.parts.contains(&pairs[1].first) {
            true => {
                assert_eq!(four.parts, [a, b, pairs[1].first, pairs[1].second]);
                beside += 1;
            }
            false => twice += 1,
        }
    }
    assert!(twice > 5 && beside > 5, "{twice} {beside}");
    // A pair without unions: one part is repeated, with its region.
    let doubled = examples.of_many(0, 3, &mut rng);
    let copies = doubled.parts.iter().filter(|part| **part == doubled.parts[1]).count();
    assert!(copies == 2 && doubled.regions.is_some());
}

#[test]
fn unions_that_test_are_not_trained_on() {
    let pairs = strips(40, 5);
    let mut set = dataset(&pairs);
    for (i, union) in set.samples.mask_union.iter_mut().enumerate() {
        *union = i % 4;
    }
    set.samples.split[2] = TEST_B;
    // No two pairs have the same parts.
    set.samples.mask1 = (0..40).collect();
    let examples = Examples::new(&set, Par::Seq).unwrap();
    assert_eq!(examples.training.len(), 30);
    assert!(examples.validates_on_training());
    assert!(examples.training.iter().all(|pair| pair.union != pairs[2].union
        || pairs.iter().enumerate().any(|(i, other)| i % 4 != 2 && other.first == pair.first)));
}
