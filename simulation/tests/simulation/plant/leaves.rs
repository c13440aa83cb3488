//! Conductances and the closing of stomata from the weights of drying leaves.

use std::collections::BTreeMap;

use crate::common::data;
use catamaran::base::Rng;
use catamaran_simulation::plant::*;

const OPEN: [f64; 3] = [0.03, 0.045, 0.06];
const CLOSING: [f64; 3] = [0.87, 0.85, 0.89];
const CUTICULAR: f64 = 0.002;
const STEEPNESS: f64 = 28.0;

/// The derivative of the weight by the demand of the air, by the definition.
fn slope(leaf: &DryingLeaf, i: usize, cuticular: f64, weight: f64) -> f64 {
    let w = (weight - leaf.dry) / (leaf.saturated - leaf.dry);
    let dryness = |w: f64| (STEEPNESS * (CLOSING[i] - w)).exp();
    let open = (dryness(1.0) - dryness(w)).exp2();
    -leaf.area * 18.015_28e-3 * ((OPEN[i] - cuticular) * open + cuticular) * w
}

/// Leaves that dry by these constants, weighed with errors of `noise` kg.
fn drying(cuticular: f64, noise: f64, seed: u64) -> Vec<DryingLeaf> {
    let mut rng = Rng::new(seed);
    (0..OPEN.len())
        .map(|i| {
            let demand: Vec<f64> = (0..24).map(|k| 0.9 * f64::from(k * k)).collect();
            let mut leaf = DryingLeaf {
                name: format!("{i}"),
                demand: demand.clone(),
                weights: vec![],
                dry: 5e-4,
                saturated: 6e-3 + 2e-4 * i as f64,
                area: 0.012,
            };
            // The classical method of Runge and Kutta.
            let mut weight = leaf.saturated;
            let mut weights = vec![weight];
            for pair in demand.windows(2) {
                let h = (pair[1] - pair[0]) / 200.0;
                for _ in 0..200 {
                    let f = |weight: f64| slope(&leaf, i, cuticular, weight);
                    let a = f(weight);
                    let b = f(weight + 0.5 * h * a);
                    let c = f(weight + 0.5 * h * b);
                    let d = f(weight + h * c);
                    weight += h / 6.0 * (a + 2.0 * (b + c) + d);
                }
                weights.push(weight);
            }
            leaf.weights = weights.iter().map(|weight| weight + noise * rng.normal()).collect();
            leaf
        })
        .collect()
}

#[test]
fn exact_weights_give_back_the_constants() {
    let found = fit_leaves(&drying(CUTICULAR, 0.0, 1), &LeafOptions::new()).unwrap();
    let near = |estimate: Estimate, truth: f64| {
        assert!((estimate.value / truth - 1.0).abs() < 1e-4, "{estimate:?} {truth}");
    };
    near(found.cuticular, CUTICULAR);
    near(found.steepness, STEEPNESS);
    for (i, leaf) in found.leaves.iter().enumerate() {
        near(leaf.open, OPEN[i]);
        near(leaf.closing, CLOSING[i]);
    }
    assert!(found.rms < 1e-9 && found.warnings.is_empty(), "{:?}", found.warnings);
}

#[test]
fn noisy_weights_give_back_the_constants_within_three_standard_errors() {
    const NOISE: f64 = 2e-6;
    let options = LeafOptions::new().instrument(NOISE);
    for seed in 1..=3 {
        let leaves = drying(CUTICULAR, NOISE, seed);
        for prior in [None, Some(Estimate { value: 0.87, error: 0.03 })] {
            let found = fit_leaves(&leaves, &options.clone().prior(prior)).unwrap();
            let near = |estimate: Estimate, truth: f64| {
                let gap = (estimate.value - truth).abs();
                assert!(gap < 3.0 * estimate.error, "{seed} {estimate:?} {truth}");
                assert!(estimate.error < 0.1 * truth, "{estimate:?}");
            };
            near(found.cuticular, CUTICULAR);
            near(found.steepness, STEEPNESS);
            for (i, leaf) in found.leaves.iter().enumerate() {
                near(leaf.open, OPEN[i]);
                near(leaf.closing, CLOSING[i]);
            }
            assert!(found.rms > 0.5 * NOISE && found.rms < 1.5 * NOISE, "{}", found.rms);
            assert!(found.warnings.is_empty(), "{:?}", found.warnings);
        }
    }
}

#[test]
fn a_misfit_and_constants_at_a_bound_are_warned_of() {
    let leaves = drying(CUTICULAR, 1e-5, 1);
    let says = |options: &LeafOptions<'_>, part: &str| {
        let warnings = fit_leaves(&leaves, options).unwrap().warnings;
        assert!(warnings.iter().any(|warning| warning.contains(part)), "{part}: {warnings:?}");
    };
    says(&LeafOptions::new(), "times the error of the scale");
    let bounded = LeafOptions::new().instrument(1e-5).steepness([1.0, 5.0]);
    says(&bounded, "the steepness is at its bound, 5.000e0");
    // Leaves that lose 50 mg at once follow no model of drying.
    let mut leaves = leaves.clone();
    leaves[1].weights[12..].iter_mut().for_each(|weight| *weight -= 5e-5);
    let found = fit_leaves(&leaves, &LeafOptions::new().instrument(1e-6)).unwrap();
    assert!(found.warnings[0].contains("times the error of the scale"), "{:?}", found.warnings);
}

#[test]
fn a_leaf_that_was_not_fitted_follows_from_its_first_weights() {
    let leaves = drying(CUTICULAR, 1e-7, 4);
    let found = fit_leaves(&leaves[..2], &LeafOptions::new()).unwrap();
    let error = |used| found.unseen(&leaves[2], used, &LeafOptions::new()).unwrap().rms;
    let errors = [0, 6, 12, 24].map(error);
    assert!(errors[3] < 1e-6 && errors[2] < 0.2 * errors[0], "{errors:?}");
    let one = fit_leaves(&leaves[..1], &LeafOptions::new()).unwrap();
    let refused = one.unseen(&leaves[2], 5, &LeafOptions::new()).unwrap_err().to_string();
    assert!(refused.contains("at least 2 fitted ones"), "{refused}");
}

#[test]
fn inconsistent_leaves_are_refused_by_name() {
    let good = drying(CUTICULAR, 0.0, 1).swap_remove(0);
    let says = |leaf: DryingLeaf, part: &str| {
        let refused = fit_leaves(&[leaf], &LeafOptions::new()).unwrap_err().to_string();
        assert!(refused.contains(part), "{refused}");
    };
    let leaf = || DryingLeaf { name: "B7".into(), ..good.clone() };
    says(DryingLeaf { area: -0.01, ..leaf() }, "B7: its area must be positive");
    says(DryingLeaf { dry: 7e-3, ..leaf() }, "B7: its dry weight must be at least 0 and below");
    says(DryingLeaf { dry: 5.9e-3, ..leaf() }, "must be above its dry weight, 0.0059 kg");
    says(DryingLeaf { saturated: f64::NAN, ..leaf() }, "B7: its dry weight");
    let demand = good.demand.iter().map(|demand| -demand).collect();
    says(DryingLeaf { demand, ..leaf() }, "B7: the demand must ascend from 0");
    says(DryingLeaf { demand: vec![0.0; 3], ..leaf() }, "demand");
    says(DryingLeaf { weights: vec![6e-3], demand: vec![0.0], ..leaf() }, "at least 2 weights");
    assert!(fit_leaves(&[], &LeafOptions::new()).is_err());
    let refused = fit_leaves(&[leaf()], &LeafOptions::new().closing([0.9, 0.4])).unwrap_err();
    assert!(refused.to_string().contains("closing: bounds must be positive and ascend"));
    let prior = Some(Estimate { value: 0.9, error: 0.0 });
    assert!(fit_leaves(&[leaf()], &LeafOptions::new().prior(prior)).is_err());
    assert!(fit_leaves(&[leaf()], &LeafOptions::new().instrument(0.0)).is_err());
}

/// Returns the rows of a table with the cells of some columns.
fn rows<const N: usize>(text: &str, columns: [&str; N]) -> Vec<[String; N]> {
    let cells = |line: &str| -> Vec<String> { line.split(',').map(String::from).collect() };
    let header = cells(text.lines().next().unwrap());
    let at = columns.map(|name| header.iter().position(|cell| cell == name).unwrap());
    let row = |line: &str| {
        let line = cells(line);
        at.map(|column| line[column].clone())
    };
    text.lines().skip(1).map(row).collect()
}

/// Returns the seconds of a day and time such as `2019-03-26 08:48:00` since the first of its
/// month.
fn seconds(text: &str) -> f64 {
    let part = |range: std::ops::Range<usize>| text[range].parse::<f64>().unwrap();
    86_400.0 * part(8..10) + 3600.0 * part(11..13) + 60.0 * part(14..16) + part(17..19)
}

/// Leaves of kohlrabi (the R package pvldcurve): eight are fitted, four are not.
#[test]
fn real_leaves_dry_as_the_model_says() {
    let Some(folder) = data("plants/leaves") else { return };
    let read = |name: &str| std::fs::read_to_string(folder.join(name)).unwrap();
    let air: Vec<Air> =
        rows(&read("weather_data.csv"), ["date.and.time", "temperature", "humidity"])
            .iter()
            .map(|[time, celsius, humidity]| Air {
                seconds: seconds(time),
                celsius: celsius.parse().unwrap(),
                humidity: 0.01 * humidity.parse::<f64>().unwrap(),
            })
            .collect();
    let columns = [
        "treatment",
        "sample",
        "dry.weight",
        "fresh.weight.saturated",
        "leaf.area",
        "date.and.time",
        "fresh.weight",
        "fw.plateau",
    ];
    let mut leaves: BTreeMap<usize, (String, DryingLeaf)> = BTreeMap::new();
    for [treatment, sample, dry, saturated, area, time, weight, plateau] in
        rows(&read("leaf_drying_data.csv"), columns)
    {
        if plateau == "yes" {
            continue;
        }
        let number = |text: &str| text.parse::<f64>().unwrap();
        let new = || DryingLeaf {
            name: sample.clone(),
            dry: 1e-3 * number(&dry),
            saturated: 1e-3 * number(&saturated),
            area: 1e-4 * number(&area),
            ..DryingLeaf::default()
        };
        let (_, leaf) = leaves.entry(sample.parse().unwrap()).or_insert((treatment, new()));
        leaf.demand.push(seconds(&time));
        leaf.weights.push(1e-3 * number(&weight));
    }
    for (_, leaf) in leaves.values_mut() {
        leaf.demand = air_demand(&air, &leaf.demand).unwrap();
    }
    let mut curves: BTreeMap<(String, String), Vec<[f64; 2]>> = BTreeMap::new();
    let columns = [
        "treatment",
        "sample",
        "fresh.weight",
        "dry.weight",
        "fresh.weight.saturated",
        "water.potential",
    ];
    for [treatment, sample, fresh, dry, saturated, potential] in
        rows(&read("pressure_volume_data.csv"), columns)
    {
        let [fresh, dry, saturated, potential] =
            [fresh, dry, saturated, potential].map(|text| text.parse::<f64>().unwrap());
        let point = [(fresh - dry) / (saturated - dry), potential];
        curves.entry((treatment, sample)).or_default().push(point);
    }
    assert_eq!(leaves.len(), 12);
    let (mut first, mut count) = (0.0, 0);
    for treatment in ["10%", "40%"] {
        let points: Vec<f64> = curves
            .iter()
            .filter(|((of, _), _)| of == treatment)
            .filter_map(|(_, curve)| turgor_loss_point(curve).ok())
            .map(|point| point.value)
            .collect();
        assert!(points.len() >= 6, "{points:?}");
        let mean = points.iter().sum::<f64>() / points.len() as f64;
        let squares = points.iter().map(|point| (point - mean).powi(2)).sum::<f64>();
        let deviation = (squares / (points.len() - 1) as f64).sqrt();
        assert!((0.83..0.93).contains(&mean), "{mean}");
        let prior = Some(Estimate { value: mean, error: deviation });
        let options = LeafOptions::new().prior(prior);
        let of = |range: std::ops::RangeInclusive<usize>| -> Vec<DryingLeaf> {
            leaves
                .range(range)
                .filter(|(_, (of, _))| of == treatment)
                .map(|(_, (_, leaf))| leaf.clone())
                .collect()
        };
        let (seen, unseen) = (of(1..=8), of(9..=12));
        let found = fit_leaves(&seen, &options).unwrap();
        // In g: .007 of all eight.
        assert!(found.leaves.iter().all(|leaf| leaf.rms < 0.04e-3), "{:?}", found.leaves);
        assert!(found.rms < 0.01e-3, "{}", found.rms);
        // The cuticle of kohlrabi, 1 to 3 mmol / (m^2 s) of one side, and not at a bound.
        let Estimate { value, error } = found.cuticular;
        assert!((0.5e-3..4e-3).contains(&value) && error < 0.25 * value, "{value} {error}");
        for leaf in &found.leaves {
            // Stomata close where cells lose their pressure.
            assert!((leaf.closing.value - mean).abs() < 3.0 * deviation, "{leaf:?} {mean}");
        }
        // The scale reads a tenth of a milligram, so that the model is a misfit.
        assert!(found.warnings[0].contains("times the error of the scale"));
        for leaf in &unseen {
            let rms = found.unseen(leaf, usize::MAX, &options).unwrap().rms;
            assert!(rms < 0.08e-3, "leaf {}: {rms}", leaf.name);
            let early = found.unseen(leaf, 5, &options).unwrap();
            first += early.rms.powi(2) * leaf.weights.len() as f64;
            count += leaf.weights.len();
        }
    }
    // From the first five weights of each unseen leaf.
    let first = (first / f64::from(count as u32)).sqrt();
    assert!(first < 0.08e-3, "{first}");
}
