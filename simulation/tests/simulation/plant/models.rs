//! The model against closed forms.

use std::f64::consts::PI;
use std::ops::ControlFlow;

use catamaran::Par;
use catamaran_simulation::plant::families::{GrowthOptions, chain, grow};
use catamaran_simulation::plant::*;

fn grown(nodes: usize) -> Plant {
    grow(&GrowthOptions::new().nodes(nodes)).unwrap()
}

fn close(a: f64, b: f64, tolerance: f64) {
    assert!((a - b).abs() <= tolerance * b.abs().max(1e-300), "{a} {b}");
}

/// All solutions of the same problem.
fn everywhere(model: &WaterModel, water: &[f64], seconds: f64) -> [Vec<f64>; 3] {
    let rational = model.water_after(water, seconds, Par::Seq).unwrap();
    let spectral = SpectralSolution::new(model).unwrap().water_after(water, seconds).unwrap();
    let mut bdf = Bdf6::new(model, water, seconds / 200.0, Start::Radau, Par::Seq).unwrap();
    (0..200).for_each(|_| bdf.step());
    [rational, spectral, bdf.water()]
}

#[test]
fn one_node_decays_exponentially() {
    let plant = chain(1, 0.01, 1e-3).unwrap();
    let model = WaterModel::new(&plant, &WaterOptions::default()).unwrap();
    let (full, rate) = (model.full(), model.losses()[0]);
    close(full[0], 1000.0 * PI * 1e-6 * 0.01, 1e-14);
    close(rate, grams_per_hour(60.0) * 1e-3 * 0.01 / full[0], 1e-14);
    for seconds in [0.0, 1.0, 3600.0, 3e4] {
        for water in everywhere_or_now(&model, &full, seconds) {
            close(water[0], full[0] * (-rate * seconds).exp(), 1e-12);
        }
    }
    close(model.slowest_rate(Par::Seq).unwrap(), rate, 1e-15);
}

fn everywhere_or_now(model: &WaterModel, water: &[f64], seconds: f64) -> Vec<Vec<f64>> {
    if seconds == 0.0 {
        return vec![model.water_after(water, 0.0, Par::Seq).unwrap()];
    }
    everywhere(model, water, seconds).into()
}

#[test]
fn two_nodes_follow_the_closed_form() {
    let segments = vec![Segment::stem([0.0, 0.0, 0.1], 2e-3), Segment::vein([0.0, 0.0, 0.2], 1e-3)];
    let plant = Plant::from_edges(segments, &[[0, 1]], None).unwrap();
    let scale = 1e-9;
    let options = WaterOptions::new().conductivity(Conductivity::Pipe { scale });
    let model = WaterModel::new(&plant, &options).unwrap();
    let resistance = |r: f64| 8.0 * 1e-3 * 0.1 / (PI * r.powi(4) * scale);
    let flow = 1e6 * 1000.0 / ((resistance(2e-3) + resistance(1e-3)) / 2.0);
    let [m, n] = [0, 1].map(|v| model.full()[v]);
    let loss = model.losses()[1];
    // The matrix of water, its eigenvalues by the quadratic equation.
    let [[a, b], [c, d]] = [[-flow / m, flow / n], [flow / m, -flow / n - loss]];
    let root = ((a - d) * (a - d) + 4.0 * b * c).sqrt();
    let [x, y] = [(a + d + root) / 2.0, (a + d - root) / 2.0];
    let full = model.full();
    let seconds = 0.7 / loss;
    let derivative = [a * m + b * n, c * m + d * n];
    for water in everywhere(&model, &full, seconds) {
        for v in 0..2 {
            let late = (derivative[v] - y * full[v]) / (x - y);
            let early = full[v] - late;
            let exact = late * (x * seconds).exp() + early * (y * seconds).exp();
            close(water[v], exact, 1e-9);
        }
    }
    close(model.slowest_rate(Par::Seq).unwrap(), -x, 1e-9);
}

#[test]
fn a_uniform_chain_has_the_rates_of_a_path() {
    for n in [2, 3, 31] {
        let plant = chain(n, 0.01 * n as f64, 1e-3).unwrap();
        let model = WaterModel::new(&plant, &WaterOptions::new().loss(0.0)).unwrap();
        let unit = 1e6 * 1000.0 * PI * 1e-12 * 1e-9 / (8.0 * 1e-3 * 0.01) / model.full()[0];
        let solution = SpectralSolution::new(&model).unwrap();
        for (k, rate) in solution.rates().iter().enumerate() {
            let exact = 4.0 * unit * (k as f64 * PI / (2.0 * n as f64)).sin().powi(2);
            assert!((rate - exact).abs() < 1e-12 * unit, "{n}, {k}: {rate} {exact}");
        }
        assert_eq!(model.slowest_rate(Par::Seq).unwrap(), 0.0);
    }
}

#[test]
fn a_star_has_three_rates() {
    let arms = 5;
    let mut segments = vec![Segment::stem([0.0, 0.0, 0.1], 1e-3)];
    for i in 0..arms {
        let angle = i as f64;
        segments.push(Segment::stem([0.1 * angle.cos(), 0.1 * angle.sin(), 0.1], 1e-3));
    }
    let edges: Vec<_> = (1..=arms as u32).map(|v| [v, 0]).collect();
    let plant = Plant::from_edges(segments, &edges, None).unwrap();
    let model = WaterModel::new(&plant, &WaterOptions::new().loss(0.0)).unwrap();
    let unit = 1e6 * 1000.0 * PI * 1e-12 * 1e-9 / (8.0 * 1e-3 * 0.1) / model.full()[0];
    let rates = SpectralSolution::new(&model).unwrap().rates().to_vec();
    let exact = [0.0, 1.0, 1.0, 1.0, 1.0, 1.0 + arms as f64];
    for (rate, exact) in rates.iter().zip(exact) {
        assert!((rate - exact * unit).abs() < 1e-12 * unit, "{rates:?}");
    }
}

#[test]
fn water_from_the_soil_keeps_a_plant_where_leaves_lose_as_much() {
    let plant = grown(60);
    let mut model = WaterModel::new(&plant, &WaterOptions::default()).unwrap();
    let full = model.full();
    let lost: f64 = full.iter().zip(model.losses()).map(|(m, l)| m * l).sum();
    model.set_intake(lost / 2.0).unwrap();
    let [rational, spectral, bdf] = everywhere(&model, &full, 2e4);
    for v in 0..60 {
        assert!((rational[v] - bdf[v]).abs() < 1e-8 * full[v], "{v}: {} {}", rational[v], bdf[v]);
        assert!((rational[v] - spectral[v]).abs() < 1e-6 * full[v], "{v}");
    }
    // In the end what comes in goes out.
    let late = model.water_after(&full, 1e9, Par::Seq).unwrap();
    let out: f64 = late.iter().zip(model.losses()).map(|(m, l)| m * l).sum();
    close(out, lost / 2.0, 1e-9);
}

#[test]
fn splitting_segments_changes_the_water_to_second_order() {
    // A stem of 4 cm, the upper half of it a leaf's, in n segments; the middle of its leaf is where
    // two segments meet.
    let relative = |n: usize| {
        let segments: Vec<_> = (1..=n)
            .map(|i| {
                let tail = [0.0, 0.0, 0.04 * i as f64 / n as f64];
                if 2 * i > n { Segment::vein(tail, 1e-3) } else { Segment::stem(tail, 1e-3) }
            })
            .collect();
        let parents: Vec<_> = (0..n as u32).map(|v| v.checked_sub(1)).collect();
        let plant = Plant::new(segments, &parents, Some([0.0; 3])).unwrap();
        let options = WaterOptions::new().conductivity(Conductivity::Pipe { scale: 3e-11 });
        let model = WaterModel::new(&plant, &options).unwrap();
        let water = model.water_after(&model.full(), 4e4, Par::Seq).unwrap();
        let moduli = Elasticity::default().moduli(&water, &model.full()).unwrap();
        let w = model.relative(&water).unwrap();
        let middle = 3 * n / 4;
        [(w[middle - 1] + w[middle]) / 2.0, (moduli[middle - 1] + moduli[middle]) / 2.0]
    };
    let fine = relative(1024);
    let (coarse, middle) = (relative(8), relative(16));
    for i in 0..2 {
        let [a, b] = [&coarse, &middle].map(|w| (w[i] - fine[i]).abs() / fine[i]);
        assert!(a < 0.05 && a / b > 3.5 && a / b < 4.5, "{a} {b}");
    }
    assert!(fine[0] > 0.05 && fine[0] < 0.9, "{fine:?}");
}

#[test]
fn days_and_nights_are_exact_interval_by_interval() {
    let plant = grown(80);
    let model = WaterModel::new(&plant, &WaterOptions::default()).unwrap();
    let [day, night] = [120.0, 6.0].map(grams_per_hour);
    let cycle = vec![
        Interval { seconds: 16.0 * 3600.0, loss: day },
        Interval { seconds: 8.0 * 3600.0, loss: night },
    ];
    let times: Vec<f64> = (0..=30).map(|h| f64::from(h) * 3600.0).collect();
    let options = CurveOptions::new().cycle(cycle.clone());
    let curve = water_curve(&model, &model.full(), &times, &options).unwrap();
    let mut water = model.full();
    let mut by_hand = model.clone();
    for (loss, hours) in [(day, 16.0), (night, 8.0), (day, 6.0)] {
        by_hand.set_loss(loss).unwrap();
        water = by_hand.water_after(&water, hours * 3600.0, Par::Seq).unwrap();
    }
    for v in 0..80 {
        assert!((curve[30][v] - water[v]).abs() < 1e-11 * model.full()[v]);
    }
    let total = |h: usize| curve[h].iter().sum::<f64>();
    assert!(total(15) - total(16) > 5.0 * (total(17) - total(18)));
    // The other methods agree.
    let step = 60.0;
    let options = CurveOptions::new().cycle(cycle).method(Method::Bdf6 { step });
    let bdf = water_curve(&model, &model.full(), &times, &options).unwrap();
    let gap = |a: f64, b: f64| (a - b).abs();
    assert!((0..80).all(|v| gap(bdf[30][v], water[v]) < 1e-7 * model.full()[v]));
}

#[test]
fn arguments_out_of_range_are_named() {
    let plant = chain(3, 0.1, 1e-3).unwrap();
    let mut model = WaterModel::new(&plant, &WaterOptions::default()).unwrap();
    let says =
        |error: catamaran::Error, part: &str| assert!(error.to_string().contains(part), "{error}");
    says(model.set_loss(-1.0).unwrap_err(), "loss: must be finite and at least 0, is -1");
    says(model.weaken(0, 0.5).unwrap_err(), "node 0 is the root");
    says(model.cut(3).unwrap_err(), "node 3 is out of range: 3 nodes");
    says(model.water_after(&[1.0], 1.0, Par::Seq).unwrap_err(), "water: expected 3 x 1");
    says(model.water_after(&[1.0, f64::NAN, 1.0], 1.0, Par::Seq).unwrap_err(), "row 1");
    says(model.water_after(&[1.0; 3], -1.0, Par::Seq).unwrap_err(), "seconds");
    let times = [2.0, 1.0];
    says(water_curve(&model, &[1.0; 3], &times, &CurveOptions::default()).unwrap_err(), "ascend");
    // Days and nights of 114,000 years.
    let options = CurveOptions::new().cycle(Interval::day_and_night(1e-5));
    let refused = water_curve(&model, &[1.0; 3], &[0.0, 3.6e12], &options).unwrap_err();
    says(refused, "cycle: has 8.333e7 intervals in 3.600e12 s, and each is a step; must have at");
    let cancel = |_: f64| ControlFlow::Break(());
    let options = CurveOptions::new().progress(&cancel);
    says(water_curve(&model, &[1.0; 3], &[1.0], &options).unwrap_err(), "cancelled");
    says(Bdf6::new(&model, &[1.0; 3], 0.0, Start::Exact, Par::Seq).unwrap_err(), "step");
    let options = WaterOptions::new().viscosity(0.0);
    says(WaterModel::new(&plant, &options).unwrap_err(), "viscosity");
    assert!(water_curve(&model, &[1.0; 3], &[], &CurveOptions::default()).unwrap().is_empty());
}
