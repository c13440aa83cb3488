//! Conductances and the closing of stomata from the weights of drying leaves.

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

/// Leaves of kohlrabi (the R package pvldcurve): eight are fitted, four are not.
#[test]
fn real_leaves_dry_as_the_model_says() {
    let Some(folder) = data("plants/leaves") else { return };
    let paths = ["leaf_drying_data.csv", "weather_data.csv", "pressure_volume_data.csv"]
        .map(|name| folder.join(name));
    let texts = paths.each_ref().map(|path| std::fs::read_to_string(path).unwrap());
    let [drying, air, curves] = [0, 1, 2].map(|i| LeafTable { path: &paths[i], text: &texts[i] });
    let groups = read_leaves(drying, air, Some(curves)).unwrap();
    assert_eq!(groups.len(), 2);
    let (mut squares, mut count) = (0.0, 0.0);
    for group in &groups {
        assert_eq!(group.leaves.len(), 6);
        assert!(group.turgor_loss.len() >= 6, "{:?}", group.notes);
        let prior = group.prior().unwrap();
        assert!((0.83..0.93).contains(&prior.value), "{prior:?}");
        let options = LeafOptions::new().prior(Some(prior));
        let is_seen = |leaf: &DryingLeaf| leaf.name.parse::<usize>().unwrap() <= 8;
        let (seen, unseen): (Vec<_>, Vec<_>) = group.leaves.iter().cloned().partition(is_seen);
        let found = fit_leaves(&seen, &options).unwrap();
        assert!(found.leaves.iter().all(|leaf| leaf.rms < 0.04e-3), "{:?}", found.leaves);
        assert!(found.rms < 0.012e-3, "{}", found.rms);
        // The cuticle of one side, in mol / (m^2 s), and not at a bound.
        let Estimate { value, error } = found.cuticular;
        assert!((0.5e-3..4e-3).contains(&value) && error < 0.25 * value, "{value} {error}");
        for leaf in &found.leaves {
            // Stomata close where cells lose their pressure.
            assert!((leaf.closing.value - prior.value).abs() < 3.0 * prior.error, "{leaf:?}");
        }
        // The scale shows a tenth of a milligram: the model is not all that happened.
        assert!(found.warnings[0].contains("times the error of the scale"));
        for leaf in &unseen {
            let rms = found.unseen(leaf, usize::MAX, &options).unwrap().rms;
            assert!(rms < 0.08e-3, "leaf {}: {rms}", leaf.name);
            // The whole curve, from the first five weights.
            let early = found.unseen(leaf, 5, &options).unwrap();
            squares += early.rms.powi(2) * leaf.weights.len() as f64;
            count += leaf.weights.len() as f64;
        }
    }
    let early: f64 = (squares / count).sqrt();
    assert!(early < 0.08e-3, "{early}");
}
