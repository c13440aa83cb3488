//! Constants of plants from exact and noisy measurements.

use catamaran::base::Rng;
use catamaran_simulation::plant::families::{GrowthOptions, grow};
use catamaran_simulation::plant::*;

const LOSS: f64 = 90.0;
const SCALE: f64 = 3e-10;
const KAPPA: f64 = 14.0;
const POT: f64 = 0.25;

fn grown(nodes: usize) -> Plant {
    grow(&GrowthOptions::new().nodes(nodes).seed(3)).unwrap()
}

/// What a plant with these constants is measured to be, exactly.
fn measured(plant: &Plant, nights: bool, heights: bool) -> Measurements {
    let loss = grams_per_hour(LOSS);
    let options = WaterOptions::new().loss(loss).conductivity(Conductivity::Pipe { scale: SCALE });
    let model = WaterModel::new(plant, &options).unwrap();
    // Often in the beginning, when leaves lose what the stem does not replace.
    let seconds: Vec<f64> = (0..25).map(|i| 300.0 * f64::from(i * i)).collect();
    let elasticity = Elasticity::Relative { dry: 3e5, full: 5e7, steepness: KAPPA, shift: 0.75 };
    let cycle = if nights { Interval::day_and_night(loss) } else { vec![] };
    let rods = Rods::new(plant, &RodOptions::new()).unwrap();
    let options = WiltOptions::new().cycle(cycle).elasticity(elasticity);
    let found = wilt(&model, &rods, &seconds, &options).unwrap();
    let height = |pose: &Pose| pose.tails.iter().map(|t| t[2]).fold(f64::NEG_INFINITY, f64::max);
    Measurements {
        weights: found.water.iter().map(|water| POT + water.iter().sum::<f64>()).collect(),
        heights: match heights {
            true => found.poses.iter().map(|pose| height(pose) - plant.base()[2]).collect(),
            false => vec![],
        },
        seconds,
        marks: vec![],
    }
}

fn near(estimate: Estimate, truth: f64, tolerance: f64) {
    assert!((estimate.value / truth - 1.0).abs() <= tolerance, "{estimate:?} {truth}");
}

#[test]
fn exact_weights_and_heights_give_back_the_constants() {
    let plant = grown(90);
    for nights in [false, true] {
        let data = measured(&plant, nights, !nights);
        let found = fit(&plant, &data, &FitOptions::new().nights(nights)).unwrap();
        near(found.loss, grams_per_hour(LOSS), 1e-6);
        near(found.scale, SCALE, 1e-6);
        near(found.weight, data.weights[0], 1e-9);
        assert!(found.loss.error < 1e-6 * found.loss.value);
        assert!(found.weight_deviation < 1e-9);
        match found.steepness[..] {
            [kappa] => near(kappa, KAPPA, 1e-6),
            _ => assert!(nights && found.steepness.is_empty()),
        }
        assert!(found.other_water.is_empty() && found.other_steepness.is_empty());
        assert_eq!(found.heights.len(), data.heights.len());
        for (a, b) in found.weights.iter().zip(&data.weights) {
            assert!((a - b).abs() < 1e-9);
        }
    }
}

#[test]
fn standard_errors_are_the_scatter_of_many_weighings() {
    const REPEATS: usize = 30;
    let plant = grown(30);
    // Noise so small that no other minimum fits better: standard errors are those of one minimum.
    let exact = measured(&plant, false, false);
    let lost = exact.weights[0] - exact.weights[24];
    let mut rng = Rng::new(11);
    let mut found = Vec::new();
    for _ in 0..REPEATS {
        let mut data = exact.clone();
        data.weights.iter_mut().for_each(|w| *w += 1e-5 * lost * rng.normal());
        let one = fit(&plant, &data, &FitOptions::new()).unwrap();
        found.push([(one.loss, grams_per_hour(LOSS)), (one.scale, SCALE)]);
    }
    for i in 0..2 {
        let mean = |f: &dyn Fn(&(Estimate, f64)) -> f64| {
            found.iter().map(|x| f(&x[i])).sum::<f64>() / REPEATS as f64
        };
        let scatter = mean(&|(e, truth)| (e.value - truth).powi(2)).sqrt();
        let stated = mean(&|(e, _)| e.error.powi(2)).sqrt();
        // A deviation of 30 samples is off by 13 %.
        assert!((stated / scatter - 1.0).abs() < 0.35, "{i}: {stated} {scatter}");
    }
}

#[test]
fn a_coarse_scale_leaves_another_minimum_and_a_fine_one_does_not() {
    let plant = grown(30);
    let exact = measured(&plant, false, false);
    let lost = exact.weights[0] - exact.weights[24];
    let weighed = |noise: f64| {
        let mut rng = Rng::new(0);
        let mut data = exact.clone();
        data.weights.iter_mut().for_each(|w| *w += noise * lost * rng.normal());
        fit(&plant, &data, &FitOptions::new()).unwrap()
    };
    assert!(weighed(1e-5).other_water.is_empty());
    // One bucket, whose leaves are filled at once, weighs like leaves that dry before the stem.
    let found = weighed(1e-3);
    assert!((found.scale.value - SCALE).abs() < 3.0 * found.scale.error, "{:?}", found.scale);
    let other = found.other_water.iter().find(|other| other.scale > 1e3 * SCALE).unwrap();
    assert!(other.deviation < 1.2 * found.weight_deviation);
    assert!((other.loss - found.loss.value).abs() < 0.1 * found.loss.value);
    assert!((other.weight - found.weight.value).abs() < 0.01 * lost);
}

#[test]
fn a_bound_holds_and_has_no_error_bar() {
    let plant = grown(30);
    let data = measured(&plant, false, false);
    let options = FitOptions::new().loss([grams_per_hour(1.0), grams_per_hour(60.0)]);
    let found = fit(&plant, &data, &options).unwrap();
    near(found.loss, grams_per_hour(60.0), 1e-12);
    assert!(found.loss.error.is_nan());
}

#[test]
fn measurements_that_tell_nothing_are_named() {
    let plant = grown(30);
    let data = measured(&plant, false, false);
    let says = |data: &Measurements, options: FitOptions<'_>, part: &str| {
        let error = fit(&plant, data, &options).unwrap_err().to_string();
        assert!(error.contains(part), "{error}");
    };
    let changed = |f: &dyn Fn(&mut Measurements)| {
        let mut data = data.clone();
        f(&mut data);
        data
    };
    let few = changed(&|d| {
        d.seconds.truncate(3);
        d.weights.truncate(3);
    });
    says(&few, FitOptions::new(), "must be at least 4, are 3");
    says(&changed(&|d| d.weights[2] = f64::NAN), FitOptions::new(), "weights");
    says(&changed(&|d| d.weights.fill(1.0)), FitOptions::new(), "lost no water");
    says(&changed(&|d| d.heights = vec![1.0]), FitOptions::new(), "heights");
    says(&changed(&|d| d.seconds[3] = 0.0), FitOptions::new(), "ascend");
    says(&data, FitOptions::new().scale([1.0, 0.5]), "scale");
    says(&data, FitOptions::new().loss([0.0, 1.0]), "loss");
    let stem = families::chain(5, 0.1, 1e-3).unwrap();
    let bare = Plant::new(
        stem.segments().iter().map(|s| Segment { leaf: false, ..*s }).collect(),
        &[None, Some(0), Some(1), Some(2), Some(3)],
        None,
    );
    let error = fit(&bare.unwrap(), &data, &FitOptions::new()).unwrap_err();
    assert!(error.to_string().contains("no leaves"), "{error}");
}

#[test]
fn heights_of_marks_tell_the_steepness_of_each_part() {
    let plant = grown(90);
    let of = |steepness| Elasticity::Relative { dry: 3e5, full: 5e7, steepness, shift: 0.75 };
    let tissue = |leaf, stem| Tissue::by_part(&plant, of(stem), &[(Part::Leaf, of(leaf))]);
    let loss = grams_per_hour(LOSS);
    let options = WaterOptions::new().loss(loss).conductivity(Conductivity::Pipe { scale: SCALE });
    let model = WaterModel::new(&plant, &options).unwrap();
    let seconds: Vec<f64> = (0..13).map(|i| 1200.0 * f64::from(i * i)).collect();
    let rods = Rods::new(&plant, &RodOptions::new()).unwrap();
    let (leaf, stem) = (6.0, 18.0);
    let weather = WiltOptions::new().elasticity(tissue(leaf, stem));
    let found = wilt(&model, &rods, &seconds, &weather).unwrap();
    let leaves: Vec<usize> = (0..90).filter(|&v| plant.segments()[v].leaf).collect();
    let stems: Vec<usize> = (0..90).filter(|&v| !plant.segments()[v].leaf).collect();
    let height = |pose: &Pose, v: usize| pose.tails[v][2] - plant.base()[2];
    let mark = |node: usize| Mark {
        node,
        heights: found.poses.iter().map(|pose| height(pose, node)).collect(),
    };
    let measured = Measurements {
        seconds,
        weights: found.water.iter().map(|water| water.iter().sum()).collect(),
        heights: vec![],
        marks: vec![mark(leaves[0]), mark(*leaves.last().unwrap()), mark(stems[stems.len() / 2])],
    };
    let start = FitOptions::new().elasticity(tissue(10.0, 10.0));
    let result = fit(&plant, &measured, &start).unwrap();
    assert_eq!(result.steepness.len(), 2);
    // Poses are at rest to 1e-8 of the largest torque.
    near(result.steepness[0], stem, 1e-4);
    near(result.steepness[1], leaf, 1e-4);
    assert!(result.steepness.iter().all(|kappa| kappa.error < 1e-3 * kappa.value));
    for (model, mark) in result.marks.iter().zip(&measured.marks) {
        assert!(model.iter().zip(&mark.heights).all(|(a, b)| (a - b).abs() < 1e-6));
    }
    // A class that no segment is of is not told, and the others are as before.
    let members = plant.segments().iter().map(|s| if s.leaf { 1 } else { 2 }).collect();
    let unused = Tissue::new(vec![of(10.0); 3], members).unwrap();
    let result = fit(&plant, &measured, &FitOptions::new().elasticity(unused)).unwrap();
    assert_eq!(result.steepness[0].error, f64::INFINITY);
    near(result.steepness[1], leaf, 1e-4);

    let mut wrong = measured.clone();
    wrong.marks[0].node = 90;
    let error = fit(&plant, &wrong, &start).unwrap_err().to_string();
    assert!(error.contains("node 90 is out of range: 90 nodes"), "{error}");
}
