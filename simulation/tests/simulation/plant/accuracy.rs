//! Accuracy, conservation and reproducibility.

use catamaran::Par;
use catamaran::base::Rng;
use catamaran_simulation::plant::families::{GrowthOptions, chain, grow};
use catamaran_simulation::plant::*;

use super::reference::{Coefficients, relative_mse};

fn grown(nodes: usize, scale: f64) -> (Plant, WaterOptions, WaterModel) {
    let plant = grow(&GrowthOptions::new().nodes(nodes)).unwrap();
    let conductivity = Conductivity::Pipe { scale };
    let options = WaterOptions::new().conductivity(conductivity);
    let model = WaterModel::new(&plant, &options).unwrap();
    (plant, options, model)
}

/// When about half of the water is gone.
fn half_time(model: &WaterModel) -> f64 {
    let full = model.full();
    let lost: f64 = full.iter().zip(model.losses()).map(|(m, l)| m * l).sum();
    std::f64::consts::LN_2 * full.iter().sum::<f64>() / lost
}

fn steps(model: &WaterModel, water: &[f64], step: f64, start: Start, count: usize) -> Vec<f64> {
    let mut bdf = Bdf6::new(model, water, step, start, Par::Seq).unwrap();
    (0..count).for_each(|_| bdf.step());
    bdf.water()
}

#[test]
fn both_solvers_agree_with_the_double_double_reference() {
    for scale in [1.0, 1e-4, 1e-7] {
        let (plant, options, model) = grown(37, scale);
        let full = model.full();
        let seconds = half_time(&model);
        let exact = Coefficients::new(&plant, &options).water_after(&full, seconds);
        let left = exact.iter().sum::<f64>() / full.iter().sum::<f64>();
        assert!((0.3..0.8).contains(&left), "{left}");
        let rational = model.water_after(&full, seconds, Par::Seq).unwrap();
        for v in 0..37 {
            let gap = (rational[v] - exact[v]).abs();
            assert!(gap < 1e-12 * full[v], "{scale:e}, node {v}: {gap:e} of {}", full[v]);
        }
        let bdf = steps(&model, &full, seconds / 16.0, Start::Radau, 16);
        let error = relative_mse(&bdf, &exact);
        assert!(error <= 1e-12, "{scale:e}: {error:e}");
        // Late, when a thousandth is left.
        let late = Coefficients::new(&plant, &options).water_after(&full, 10.0 * seconds);
        let rational = model.water_after(&full, 10.0 * seconds, Par::Seq).unwrap();
        let error = relative_mse(&rational, &late).sqrt();
        assert!(error < 1e-9, "{scale:e}: {error:e}");
    }
}

#[test]
fn the_two_references_agree() {
    for scale in [1e-9, 1e-4] {
        let (plant, options, model) = grown(37, scale);
        let coefficients = Coefficients::new(&plant, &options);
        for seconds in [0.1 * half_time(&model), half_time(&model)] {
            let a = coefficients.water_after(&model.full(), seconds);
            let b = coefficients.water_by_contour(&model.full(), seconds);
            let gap = a.iter().zip(&b).map(|(a, b)| (a / b - 1.0).abs()).fold(0.0, f64::max);
            assert!(gap < 1e-15, "{scale:e}: {gap:e}");
        }
    }
}

/// The largest error of the water of a node as a part of that water.
fn largest_error(water: &[f64], exact: &[f64]) -> f64 {
    water.iter().zip(exact).map(|(x, y)| (x / y - 1.0).abs()).fold(0.0, f64::max)
}

#[test]
fn twelve_digits_are_right_at_the_usual_conductance() {
    let scale = 1e-9;
    let mut plants = vec![grow(&GrowthOptions::new().nodes(1500)).unwrap()];
    let real = ["002", "006"].map(|number| format!("plants/plant{number}.txt"));
    plants.extend(
        real.iter().filter_map(|name| crate::common::data(name)).map(|path| read(&path).unwrap()),
    );
    let options = WaterOptions::new().conductivity(Conductivity::Pipe { scale });
    for plant in plants {
        let model = WaterModel::new(&plant, &options).unwrap();
        let full = model.full();
        let seconds = half_time(&model);
        let exact = Coefficients::new(&plant, &options).water_by_contour(&full, seconds);
        let water = model.water_after(&full, seconds, Par::all()).unwrap();
        let error = largest_error(&water, &exact);
        assert!(error < 1e-12, "{} nodes: {error:e}", plant.len());
        // 64 steps of the formula.
        let error = relative_mse(&steps(&model, &full, seconds / 64.0, Start::Radau, 64), &exact);
        assert!(error < 1e-11, "{} nodes: {error:e}", plant.len());
    }
}

#[test]
fn the_slowest_rate_has_all_its_digits() {
    for scale in [1.0, 1e-7, 1e-11] {
        let (plant, options, model) = grown(211, scale);
        let exact = Coefficients::new(&plant, &options).slowest_rate();
        let rate = model.slowest_rate(Par::Seq).unwrap();
        assert!((rate - exact).abs() <= 1e-13 * exact, "{scale:e}: {rate} {exact}");
    }
}

#[test]
fn bdf6_has_order_6_and_a_constant_start_has_order_1() {
    let plant = chain(7, 0.07, 1e-3).unwrap();
    let options = WaterOptions::new().conductivity(Conductivity::Pipe { scale: 1e-11 });
    let model = WaterModel::new(&plant, &options).unwrap();
    let full = model.full();
    let seconds = 4e4;
    let exact = model.water_after(&full, seconds, Par::Seq).unwrap();
    let order = |start| {
        let error = |n: usize| {
            relative_mse(&steps(&model, &full, seconds / n as f64, start, n), &exact).sqrt()
        };
        (error(20) / error(40)).log2()
    };
    for start in [Start::Radau, Start::Exact] {
        assert!(order(start) >= 5.7, "{start:?}: {}", order(start));
    }
    assert!(order(Start::Constant) < 1.5, "{}", order(Start::Constant));
}

#[test]
fn without_loss_no_water_is_lost_and_balance_stays_balance() {
    let (_, _, mut model) = grown(500, 1e-7);
    model.set_loss(0.0).unwrap();
    let full = model.full();
    let mut rng = Rng::new(3);
    let uneven: Vec<f64> = full.iter().map(|m| m * rng.uniform()).collect();
    let total = |water: &[f64]| water.iter().sum::<f64>();
    for step in [1e-3, 10.0, 1e5] {
        for start in [Start::Radau, Start::Constant] {
            let water = steps(&model, &uneven, step, start, 1000);
            let drift = (total(&water) / total(&uneven) - 1.0).abs();
            assert!(drift <= 1e-12, "{step} {start:?}: {drift:e}");
            let even = model.relative(&steps(&model, &full, step, start, 100)).unwrap();
            assert!(even.iter().all(|w| (w - 1.0).abs() < 1e-12), "{step}");
        }
    }
    let water = model.water_after(&uneven, 1e9, Par::Seq).unwrap();
    assert!((total(&water) / total(&uneven) - 1.0).abs() <= 1e-12);
}

#[test]
fn water_never_goes_below_zero_by_more_than_rounding() {
    let (_, _, model) = grown(300, 1e-9);
    let full = model.full();
    for seconds in [1.0, 1e3, 1e5, 1e6] {
        let water = model.water_after(&full, seconds, Par::Seq).unwrap();
        assert!(water.iter().zip(&full).all(|(x, m)| *x > -1e-12 * m));
    }
}

#[test]
fn times_conductances_and_losses_that_overflow_are_refused() {
    // Nothing is left after the largest time that is accepted.
    let (_, _, model) = grown(20, 1e-9);
    let full = model.full();
    let left = model.water_after(&full, 1e90, Par::Seq).unwrap();
    assert!(left.iter().zip(&full).all(|(x, m)| x.abs() < 1e-12 * m));
    let says = |model: &WaterModel, seconds: f64| {
        let single = model.water_after(&full, seconds, Par::Seq).unwrap_err().to_string();
        let curve = water_curve(model, &full, &[0.0, seconds], &CurveOptions::new());
        for refused in [single, curve.unwrap_err().to_string()] {
            assert!(refused.starts_with("seconds: must be at most"), "{refused}");
        }
    };
    says(&model, 1e160);
    says(&grown(20, 1e200).2, 3600.0);
    let mut model = model;
    model.set_loss(1e200).unwrap();
    says(&model, 3600.0);
    model.set_loss(0.0).unwrap();
    model.weaken(3, 1e200).unwrap();
    says(&model, 3600.0);
}

#[test]
fn threads_change_no_bit() {
    let (_, _, model) = grown(40_000, 1e-7);
    let full = model.full();
    let run = |par| {
        let mut bdf = Bdf6::new(&model, &full, 600.0, Start::Radau, par).unwrap();
        (0..7).for_each(|_| bdf.step());
        (bdf.water(), model.water_after(&full, 3e4, par).unwrap(), model.slowest_rate(par).unwrap())
    };
    assert_eq!(run(Par::Seq), run(Par::Threads(3)));
}

#[test]
fn models_share_no_state() {
    let (_, _, mut a) = grown(90, 1e-7);
    let (_, _, b) = grown(120, 1e-8);
    let alone = |model: &WaterModel| steps(model, &model.full(), 500.0, Start::Radau, 20);
    let (first, second) = (alone(&a), alone(&b));
    let start = |model: &WaterModel| {
        Bdf6::new(model, &model.full(), 500.0, Start::Radau, Par::Seq).unwrap()
    };
    let (mut x, mut y) = (start(&a), start(&b));
    for _ in 0..20 {
        x.step();
        y.step();
    }
    assert_eq!((x.water(), y.water()), (first, second));
    // A change of the model changes no solver that was made before, and a restart is as good as a
    // new solver.
    a.set_loss(grams_per_hour(200.0)).unwrap();
    a.weaken(5, 0.1).unwrap();
    let before = x.water();
    let total = |water: &[f64]| water.iter().sum::<f64>();
    x.restart(&a, 250.0).unwrap();
    assert_eq!(x.water(), before);
    let mut again = Bdf6::new(&a, &before, 250.0, Start::Radau, Par::Seq).unwrap();
    for _ in 0..10 {
        x.step();
        again.step();
        assert!(total(&x.water()) < total(&before));
    }
    let gap = |v: usize| (x.water()[v] - again.water()[v]).abs() / before[v];
    assert!((0..90).all(|v| gap(v) < 1e-13));
}
