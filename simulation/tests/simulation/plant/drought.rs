//! Stomata that close, and soil that empties and is watered.

use catamaran::Par;
use catamaran_simulation::plant::families::{GrowthOptions, chain, grow};
use catamaran_simulation::plant::*;

const HOUR: f64 = 3600.0;

fn grown(nodes: usize, loss: f64) -> WaterModel {
    let plant = grow(&GrowthOptions::new().nodes(nodes)).unwrap();
    WaterModel::new(&plant, &WaterOptions::new().loss(grams_per_hour(loss))).unwrap()
}

fn hours(count: usize, each: f64) -> Vec<f64> {
    (0..=count).map(|i| each * HOUR * i as f64).collect()
}

fn total(water: &[f64]) -> f64 {
    water.iter().sum()
}

/// The largest difference as a part of the water of a full node.
fn gap(model: &WaterModel, a: &[f64], b: &[f64]) -> f64 {
    let gaps = a.iter().zip(b).zip(model.full()).map(|((a, b), full)| (a - b).abs() / full);
    gaps.fold(0.0, f64::max)
}

/// The derivative of water (kg, by nodes) and of the soil, by the definition.
fn derivative(
    plant: &Plant,
    model: &WaterModel,
    stomata: &Stomata,
    soil: Option<&Soil>,
    state: &[f64],
) -> Vec<f64> {
    let n = plant.len();
    let (full, losses, exchanges) = (model.full(), model.losses(), model.exchanges());
    let w: Vec<f64> = (0..n).map(|v| state[v] / full[v]).collect();
    let mut rates: Vec<f64> =
        (0..n).map(|v| -losses[v] * stomata.openness(w[v]) * state[v]).collect();
    for v in 0..n {
        if let Some(p) = plant.parent(v) {
            let flow = exchanges[v] * (w[v] - w[p]);
            rates[v] -= flow;
            rates[p] += flow;
        }
    }
    if let Some(soil) = soil {
        let x = state[n] / soil.capacity;
        let supply = (1.0 + soil.half) * x / (soil.half + x);
        let uptake = soil.conductance.unwrap() * supply * (1.0 - w[plant.root()]);
        rates[plant.root()] += uptake;
        rates.push(-uptake);
    }
    rates
}

/// The classical method of Runge and Kutta.
fn runge_kutta(
    f: impl Fn(&[f64]) -> Vec<f64>,
    start: &[f64],
    seconds: f64,
    steps: usize,
) -> Vec<f64> {
    let h = seconds / steps as f64;
    let plus = |x: &[f64], k: &[f64], s: f64| -> Vec<f64> {
        x.iter().zip(k).map(|(x, k)| x + s * k).collect()
    };
    let mut x = start.to_vec();
    for _ in 0..steps {
        let a = f(&x);
        let b = f(&plus(&x, &a, 0.5 * h));
        let c = f(&plus(&x, &b, 0.5 * h));
        let d = f(&plus(&x, &c, h));
        x = (0..x.len()).map(|i| x[i] + h / 6.0 * (a[i] + 2.0 * (b[i] + c[i]) + d[i])).collect();
    }
    x
}

#[test]
fn stomata_and_soil_follow_their_equations() {
    let plant = grow(&GrowthOptions::new().nodes(40)).unwrap();
    // So little conductance that an explicit method can follow.
    let options = WaterOptions::new()
        .loss(grams_per_hour(200.0))
        .conductivity(Conductivity::Pipe { scale: 1e-11 });
    let model = WaterModel::new(&plant, &options).unwrap();
    let full = model.full();
    let seconds = 40.0 * HOUR;
    for (half, steepness) in [(0.8, 25.0), (0.4, 6.0)] {
        let stomata = Stomata::new().half(half).steepness(steepness);
        let lost: f64 = full.iter().zip(model.losses()).map(|(m, l)| m * l).sum();
        let soil = Soil::new(1e-4 * total(&full)).conductance(Some(3.0 * lost));
        for soil in [None, Some(soil)] {
            let options = CurveOptions::new().stomata(Some(stomata)).soil(soil);
            let course = water_course(&model, &full, &[seconds], &options).unwrap();
            let mut start = full.clone();
            start.extend(soil.map(|s| s.capacity));
            let f = |x: &[f64]| derivative(&plant, &model, &stomata, soil.as_ref(), x);
            let exact = runge_kutta(f, &start, seconds, 4000);
            assert!(total(&exact[..40]) < 0.99 * total(&full));
            let error = gap(&model, &course.water[0], &exact[..40]);
            assert!(error < 2e-8, "{half} {soil:?}: {error:e}");
            if let Some(soil) = soil {
                assert!((course.balance[0].soil - exact[40]).abs() < 1e-7 * soil.capacity);
                assert!(exact[40] < 0.9 * soil.capacity);
            }
        }
    }
}

#[test]
fn all_water_is_accounted_for() {
    for nodes in [1, 50, 700] {
        let model = grown(nodes, 300.0);
        let full = model.full();
        let times = hours(240, 1.0);
        let pours: Vec<Rewatering> =
            [(30.0, None), (70.0, Some(0.2)), (90.0, Some(5.0)), (90.5, None)]
                .map(|(hour, part)| Rewatering {
                    seconds: hour * HOUR,
                    amount: part.map(|part: f64| part * total(&full)),
                })
                .into();
        let soil = Soil::new(0.7 * total(&full)).content(0.5 * total(&full));
        let cycle = Interval::day_and_night(grams_per_hour(300.0));
        for (stomata, cycle) in [(Some(Stomata::new()), vec![]), (None, cycle)] {
            let options = CurveOptions::new()
                .stomata(stomata)
                .soil(Some(soil))
                .rewatering(pours.clone())
                .cycle(cycle);
            let course = water_course(&model, &full, &times, &options).unwrap();
            let initial = total(&full) + soil.content;
            let mut before = Balance::default();
            for (water, balance) in course.water.iter().zip(&course.balance) {
                assert!((balance.plant / total(water) - 1.0).abs() < 1e-13);
                let now = balance.plant + balance.soil + balance.transpired;
                let then = initial + balance.supplied;
                assert!((now / then - 1.0).abs() <= 1e-12, "{nodes}: {:e}", now / then - 1.0);
                assert!(balance.transpired >= before.transpired);
                assert!(balance.soil > -1e-9 * soil.capacity);
                assert!(balance.soil <= soil.capacity * (1.0 + 1e-12));
                assert!(
                    water.iter().zip(&full).all(|(x, m)| *x > -1e-7 * m && *x <= m * (1.0 + 1e-9))
                );
                before = *balance;
            }
            // What the soil could not hold of 5 times the water of the plant.
            assert!(before.drained > 4.0 * total(&full) && before.supplied > 0.2 * total(&full));
        }
    }
}

#[test]
fn a_plant_recovers_monotonically_after_it_is_watered() {
    let model = grown(300, 150.0);
    let full = model.full();
    let times = hours(400, 1.0);
    // It is watered when it has dried for 200 hours, in the dark, so that leaves lose nothing.
    let cycle = vec![
        Interval { seconds: 200.0 * HOUR, loss: grams_per_hour(600.0) },
        Interval { seconds: 1e9, loss: 0.0 },
    ];
    let pour = Rewatering { seconds: 200.0 * HOUR, amount: None };
    for stomata in [None, Some(Stomata::new())] {
        let soil = Soil::new(3.0 * total(&full)).content(0.0);
        let options = CurveOptions::new()
            .stomata(stomata)
            .soil(Some(soil))
            .rewatering(vec![pour])
            .cycle(cycle.clone());
        let course = water_course(&model, &full, &times, &options).unwrap();
        let dry = total(&course.water[200]);
        assert!(dry < 0.9 * total(&full), "{}", dry / total(&full));
        for (before, after) in course.water[200..].iter().zip(&course.water[201..]) {
            assert!(total(after) >= total(before) - 1e-10 * total(&full));
        }
        // Every node, when water has come to all of them.
        for v in 0..300 {
            assert!(course.water[400][v] > course.water[200][v] - 1e-9 * full[v], "{v}");
        }
        assert!(total(&course.water[400]) > 0.5 * (dry + total(&full)));
    }
}

#[test]
fn open_stomata_and_soil_that_gives_nothing_are_the_linear_model() {
    let model = grown(200, 100.0);
    let full = model.full();
    let times = hours(6, 8.0);
    let linear = water_curve(&model, &full, &times, &CurveOptions::new()).unwrap();
    let open = CurveOptions::new().stomata(Some(Stomata::new().steepness(0.0)));
    let none = CurveOptions::new().soil(Some(Soil::new(1.0).conductance(Some(0.0))));
    let empty = CurveOptions::new().soil(Some(Soil::new(1.0).content(0.0)));
    for options in [open, none, empty] {
        let course = water_course(&model, &full, &times, &options).unwrap();
        for (a, b) in course.water.iter().zip(&linear) {
            assert!(gap(&model, a, b) < 1e-7, "{:e}", gap(&model, a, b));
        }
    }
    // Options that are off change no bit.
    let off = CurveOptions::new().stomata(None).soil(None).rewatering(vec![]);
    assert_eq!(water_curve(&model, &full, &times, &off).unwrap(), linear);
    for (i, &time) in times.iter().enumerate().skip(1) {
        let step = time - times[i - 1];
        let by_hand = model.water_after(&linear[i - 1], step, Par::all()).unwrap();
        assert!(gap(&model, &by_hand, &linear[i]) < 1e-15);
    }
}

#[test]
fn wet_soil_and_closed_stomata_keep_water_back() {
    let model = grown(300, 300.0);
    let full = model.full();
    let left = |options: CurveOptions<'_>| {
        total(&water_curve(&model, &full, &[100.0 * HOUR], &options).unwrap()[0]) / total(&full)
    };
    let bare = left(CurveOptions::new());
    let closing = left(CurveOptions::new().stomata(Some(Stomata::new())));
    let wet = left(CurveOptions::new().soil(Some(Soil::new(100.0 * total(&full)))));
    let little = left(CurveOptions::new().soil(Some(Soil::new(0.1 * total(&full)))));
    assert!(closing > 1.1 * bare && wet > 1.1 * bare, "{bare} {closing} {wet}");
    assert!(little > bare && little < wet, "{little}");
}

#[test]
fn threads_change_no_bit_of_a_drought() {
    let model = grown(20_000, 100.0);
    let run = |par| {
        let options =
            CurveOptions::new().stomata(Some(Stomata::new())).soil(Some(Soil::new(1e-3))).par(par);
        water_course(&model, &model.full(), &[2.0 * HOUR], &options).unwrap()
    };
    assert_eq!(run(Par::Seq), run(Par::Threads(3)));
}

#[test]
fn options_of_a_drought_out_of_range_are_named() {
    let model = WaterModel::new(&chain(3, 0.1, 1e-3).unwrap(), &WaterOptions::new()).unwrap();
    let says = |options: CurveOptions<'_>, part: &str| {
        let error = water_curve(&model, &model.full(), &[1.0], &options).unwrap_err().to_string();
        assert!(error.contains(part), "{error}");
    };
    let pour = |seconds, amount| vec![Rewatering { seconds, amount }];
    says(CurveOptions::new().rewatering(pour(1.0, None)), "requires a soil");
    let soil = Some(Soil::new(1.0));
    says(CurveOptions::new().soil(soil).rewatering(pour(-1.0, None)), "time of rewatering");
    says(CurveOptions::new().soil(soil).rewatering(pour(1.0, Some(-1.0))), "amount of rewatering");
    says(CurveOptions::new().soil(Some(Soil::new(-1.0))), "capacity");
    says(CurveOptions::new().stomata(Some(Stomata::new().steepness(-1.0))), "steepness");
    says(CurveOptions::new().soil(soil).method(Method::Spectral), "method");
}

#[test]
fn a_plant_that_is_watered_rises_again() {
    let plant = grow(&GrowthOptions::new().nodes(120)).unwrap();
    let options = WaterOptions::new().loss(grams_per_hour(1500.0));
    let model = WaterModel::new(&plant, &options).unwrap();
    let rods = Rods::new(&plant, &RodOptions::new()).unwrap();
    let full = total(&model.full());
    let height = |pose: &Pose| pose.tails.iter().map(|tail| tail[2]).sum::<f64>();
    let soil = Soil::new(2.0 * full).content(0.0).conductance(Some(1e-6));
    let pour = Rewatering { seconds: 60.0 * HOUR, amount: None };
    let cycle = vec![
        Interval { seconds: 60.0 * HOUR, loss: options.loss },
        Interval { seconds: 1e9, loss: 0.0 },
    ];
    let times = hours(12, 10.0);
    let weather = WiltOptions::new().soil(Some(soil)).rewatering(vec![pour]).cycle(cycle.clone());
    let found = wilt(&model, &rods, &times, &weather).unwrap();
    assert_eq!(found.balance.len(), 13);
    let [first, dry, wet] = [0, 5, 12].map(|i| height(&found.poses[i]));
    assert!(dry < 0.9 * first && wet > dry + 0.8 * (first - dry), "{first} {dry} {wet}");
    // In motion, the same water.
    let film = SwayOptions::new()
        .drought(times[12])
        .seconds(2.0)
        .frames(12)
        .soil(Some(soil))
        .rewatering(vec![pour])
        .cycle(cycle);
    let film = sway(&model, &rods, &film).unwrap();
    for (a, b) in film.water.iter().zip(&found.water) {
        assert!(gap(&model, a, b) < 1e-6, "{:e}", gap(&model, a, b));
    }
    assert!((film.balance[12].supplied / found.balance[12].supplied - 1.0).abs() < 1e-6);
}

#[test]
fn soil_that_holds_next_to_nothing_takes_few_steps_and_is_as_none() {
    let model = grown(300, 150.0);
    let times = hours(4, 12.0);
    let curve = |soil: Option<Soil>| {
        let options = CurveOptions::new().soil(soil).par(Par::Seq);
        water_course(&model, &model.full(), &times, &options).unwrap()
    };
    let none = curve(None);
    for capacity in [1e-12, 1e-15] {
        let course = curve(Some(Soil::new(capacity)));
        for ((water, bare), balance) in course.water.iter().zip(&none.water).zip(&course.balance) {
            let apart = gap(&model, water, bare);
            assert!(apart < 1e-7, "{capacity}: {apart}");
            assert!(balance.soil.abs() <= capacity, "{capacity}: {balance:?}");
        }
    }
}
