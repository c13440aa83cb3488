//! Rods against beam theory.

use std::f64::consts::PI;
use std::ops::ControlFlow;

use catamaran::base::Progress;
use catamaran::{Error, Par};
use catamaran_simulation::plant::families::{GrowthOptions, grow};
use catamaran_simulation::plant::*;

const RADIUS: f64 = 1e-3;
const INERTIA: f64 = PI * RADIUS * RADIUS * RADIUS * RADIUS / 4.0;
const GRAVITY: f64 = 9.81;

/// A straight chain of n segments in a direction.
fn chain(n: usize, length: f64, direction: [f64; 3]) -> (Vec<Segment>, Vec<Option<u32>>) {
    let at = |i: usize| direction.map(|x| x * length * i as f64 / n as f64);
    let segments = (1..=n).map(|i| Segment::stem(at(i), RADIUS)).collect();
    (segments, (0..n as u32).map(|v| v.checked_sub(1)).collect())
}

fn rods(segments: Vec<Segment>, parents: &[Option<u32>], dry_density: f64) -> Rods {
    let plant = Plant::new(segments, parents, Some([0.0; 3])).unwrap();
    let options = RodOptions::new().dry_density(dry_density);
    Rods::new(&plant, &options).unwrap()
}

/// The tip of a horizontal chain of length 1 with modulus E = 1e9 and a mass in the middle of its
/// last segment.
fn loaded_tip(n: usize, mass: f64) -> [f64; 3] {
    let (segments, parents) = chain(n, 1.0, [1.0, 0.0, 0.0]);
    let mut rods = rods(segments, &parents, 0.0);
    let mut water = vec![0.0; n];
    water[n - 1] = mass;
    rods.set_state(&vec![1e9; n], &water).unwrap();
    let mut pose = rods.rest_pose();
    let done = rods.relax(&mut pose, &RelaxOptions::default()).unwrap();
    assert!(done.iterations <= 30 && done.residual <= 1e-8, "{done:?}");
    pose.tails[n - 1]
}

fn within(a: f64, b: f64, tolerance: f64) {
    assert!((a - b).abs() <= tolerance * b.abs(), "{a} {b}");
}

#[test]
fn a_cantilever_sinks_as_beams_do() {
    let stiffness = 1e9 * INERTIA;
    // A load at a: P a^2 (3 L - a) / 6 E I at the end.
    let (n, mass) = (100, 1e-4 * stiffness);
    let a = 1.0 - 0.5 / n as f64;
    let exact = mass * GRAVITY * a * a * (3.0 - a) / (6.0 * stiffness);
    within(-loaded_tip(n, mass)[2], exact, 1e-3);
    // Its own weight: w L^4 / 8 E I.
    for n in [20, 101] {
        let (segments, parents) = chain(n, 1.0, [1.0, 0.0, 0.0]);
        let mut rods = rods(segments, &parents, 1e-3);
        rods.set_state(&vec![1e9; n], &vec![0.0; n]).unwrap();
        let mut pose = rods.rest_pose();
        rods.relax(&mut pose, &RelaxOptions::default()).unwrap();
        let weight = 1e-3 * PI * RADIUS * RADIUS * GRAVITY;
        within(-pose.tails[n - 1][2], weight / (8.0 * stiffness), 0.01);
    }
}

#[test]
fn large_deflections_are_those_of_the_elastica() {
    // P L^2 / E I, vertical and horizontal displacement of the end (Bisshopp and Drucker 1945;
    // Mattiasson 1981).
    for (load, down, back) in
        [(1.0, 0.30172, 0.05643), (5.0, 0.71379, 0.38763), (10.0, 0.81061, 0.55500)]
    {
        let tip = loaded_tip(400, load * 1e9 * INERTIA / GRAVITY);
        within(-tip[2], down, 0.005);
        within(1.0 - tip[0], back, 0.01);
    }
}

#[test]
fn a_column_buckles_at_the_height_of_greenhill() {
    let density = 1000.0;
    let modulus: f64 = 1e9;
    let critical = (7.8373 * modulus * INERTIA / (density * GRAVITY * PI * RADIUS * RADIUS)).cbrt();
    let n = 200;
    let tip = |height: f64| {
        let (segments, parents) = chain(n, height, [0.0, 0.0, 1.0]);
        let mut rods = rods(segments, &parents, density);
        rods.set_state(&vec![modulus; n], &vec![0.0; n]).unwrap();
        let mut pose = rods.rest_pose();
        for rotation in &mut pose.rotations {
            *rotation = [0.05_f64.cos(), 0.0, 0.05_f64.sin(), 0.0];
        }
        rods.relax(&mut pose, &RelaxOptions::default()).unwrap();
        pose.tails[n - 1][0].abs() / height
    };
    assert!(tip(0.99 * critical) < 1e-4, "{}", tip(0.99 * critical));
    assert!(tip(1.01 * critical) > 0.1, "{}", tip(1.01 * critical));
}

#[test]
fn a_column_that_stands_exactly_upright_buckles() {
    let (density, modulus, n) = (1000.0, 1e9_f64, 60);
    let critical = (7.8373 * modulus * INERTIA / (density * GRAVITY * PI * RADIUS * RADIUS)).cbrt();
    let tip = |height: f64| {
        let (segments, parents) = chain(n, height, [0.0, 0.0, 1.0]);
        let mut rods = rods(segments, &parents, density);
        rods.set_state(&vec![modulus; n], &vec![0.0; n]).unwrap();
        let mut pose = rods.rest_pose();
        let done = rods.relax(&mut pose, &RelaxOptions::default()).unwrap();
        assert!(done.residual <= 1e-8 && done.iterations <= 50, "{done:?}");
        let [x, y, _] = pose.tails[n - 1];
        x.hypot(y) / height
    };
    assert_eq!(tip(0.99 * critical), 0.0);
    assert!(tip(1.01 * critical) > 0.1 && tip(1.05 * critical) > 0.5);
    // A long one hangs down.
    assert!(tip(4.0 * critical) < 0.2);
}

#[test]
fn a_symmetric_plant_falls_to_one_side() {
    // A stem and two equal branches, which hold each other in balance.
    let (mut segments, mut parents) = chain(10, 0.1, [0.0, 0.0, 1.0]);
    for side in [1.0, -1.0] {
        for i in 1..=5 {
            let (out, up) = (0.01 * f64::from(i), 0.005 * f64::from(i));
            parents.push(Some(if i == 1 { 9 } else { segments.len() as u32 - 1 }));
            segments.push(Segment::stem([side * out, 0.0, 0.1 + up], RADIUS));
        }
    }
    let n = segments.len();
    let mut rods = rods(segments, &parents, 1100.0);
    for modulus in [5e6, 3e6] {
        rods.set_state(&vec![modulus; n], &vec![0.0; n]).unwrap();
        let mut pose = rods.rest_pose();
        let done = rods.relax(&mut pose, &RelaxOptions::default()).unwrap();
        assert!(done.residual <= 1e-8, "{done:?}");
        assert!(pose.tails[9][2] < 0.0 && pose.tails[9][1].abs() > 0.01, "{:?}", pose.tails[9]);
    }
}

#[test]
fn an_upright_stem_in_motion_falls_if_it_is_too_weak() {
    let n = 12;
    let (segments, parents) = chain(n, 0.3, [0.0, 0.0, 1.0]);
    let mut rods = rods(segments, &parents, 1000.0);
    let mut top = |modulus: f64| {
        rods.set_state(&vec![modulus; n], &vec![0.0; n]).unwrap();
        let mut motion = Motion::new(&rods, &rods.rest_pose(), &MotionOptions::new()).unwrap();
        (0..600).for_each(|_| motion.step().unwrap());
        motion.pose().tails[n - 1][2]
    };
    assert!((top(1e9) - 0.3).abs() < 1e-6);
    assert!(top(2e6) < 0.1);
}

#[test]
fn a_torque_twists_by_its_length_over_g_j() {
    // A stiff arm at the end of a chain along x, with a mass at the end of the arm.
    let (n, arm, mass) = (100, 0.1, 1e-5);
    let (mut segments, mut parents) = chain(n, 0.5, [1.0, 0.0, 0.0]);
    segments.push(Segment::stem([0.5, 2.0 * arm, 0.0], RADIUS));
    parents.push(Some(n as u32 - 1));
    let mut rods = rods(segments, &parents, 0.0);
    let mut moduli = vec![1e9; n];
    moduli.push(1e18);
    let mut water = vec![0.0; n];
    water.push(mass);
    rods.set_state(&moduli, &water).unwrap();
    let mut pose = rods.rest_pose();
    rods.relax(&mut pose, &RelaxOptions::default()).unwrap();
    let shear = 1e9 / 2.6;
    let exact = mass * GRAVITY * arm * (0.5 - 0.5 * 0.5 / n as f64) / (shear * 2.0 * INERTIA);
    let [w, x, _, _] = pose.rotations[n - 1];
    within(2.0 * (-x).atan2(w), exact, 0.01);
}

#[test]
fn a_soft_chain_between_two_pins_hangs_as_a_catenary() {
    // From an arc of a circle to the catenary of the same length and span.
    let n = 80;
    let angle = |i: usize| 1.2 * (2.0 * i as f64 / n as f64 - 1.0);
    let place = |i: usize| [angle(i).sin() + 1.2_f64.sin(), 0.0, 1.2_f64.cos() - angle(i).cos()];
    let mut segments: Vec<_> = (1..=n).map(|i| Segment::stem(place(i), RADIUS)).collect();
    let mut parents: Vec<_> = (0..n as u32).map(|v| v.checked_sub(1)).collect();
    // What holds the end.
    segments
        .push(Segment { pinned: true, ..Segment::stem([2.0 * 1.2_f64.sin(), 0.0, 0.1], RADIUS) });
    parents.push(Some(n as u32 - 1));
    let mut rods = rods(segments, &parents, 1000.0);
    rods.set_state(&vec![1e4; n + 1], &vec![0.0; n + 1]).unwrap();
    let mut pose = rods.rest_pose();
    let done = rods.relax(&mut pose, &RelaxOptions::default()).unwrap();
    assert!(done.iterations <= 50, "{done:?}");
    let end = pose.tails[n - 1];
    let gap = (0..3).map(|i| (end[i] - place(n)[i]).abs()).fold(0.0, f64::max);
    assert!(gap < 1e-9, "{gap:e}");
    // Length 2 a sinh(s / a) = 2 s_c, sag a (cosh(s / a) - 1).
    let half_span = 1.2_f64.sin();
    let half_length: f64 = n as f64 * (1.2 / n as f64).sin();
    let (mut low, mut high) = (0.1, 10.0);
    for _ in 0..60 {
        let a: f64 = 0.5 * (low + high);
        if a * (half_span / a).sinh() > half_length { low = a } else { high = a }
    }
    let sag = low * ((half_span / low).cosh() - 1.0);
    let lowest = pose.tails.iter().map(|t| t[2]).fold(0.0, f64::min);
    within(-lowest, sag, 0.01);
}

fn wilting(nodes: usize, hours: f64) -> (WaterModel, Rods) {
    let plant = grow(&GrowthOptions::new().nodes(nodes)).unwrap();
    let options = WaterOptions::new().loss(grams_per_hour(120.0));
    let model = WaterModel::new(&plant, &options).unwrap();
    let full = model.full();
    let water = model.water_after(&full, hours * 3600.0, Par::Seq).unwrap();
    let moduli = Elasticity::default().moduli(&water, &full).unwrap();
    let mut rods = Rods::new(&plant, &RodOptions::default()).unwrap();
    rods.set_state(&moduli, &water).unwrap();
    (model, rods)
}

#[test]
fn a_plant_of_2000_nodes_wilts_in_at_most_50_iterations() {
    let (_, healthy) = wilting(2000, 0.0);
    let mut pose = healthy.rest_pose();
    let first = healthy.relax(&mut pose, &RelaxOptions::default()).unwrap();
    let before = pose.clone();
    let (_, dry) = wilting(2000, 48.0);
    let second = dry.relax(&mut pose, &RelaxOptions::default()).unwrap();
    for done in [first, second] {
        assert!(done.iterations <= 50 && done.residual <= 1e-8, "{done:?}");
    }
    let height = |pose: &Pose| pose.tails.iter().map(|t| t[2]).sum::<f64>() / 2000.0;
    assert!(height(&pose) < 0.5 * height(&before), "{} {}", height(&pose), height(&before));
}

#[test]
fn motion_settles_in_the_pose_of_equilibrium_without_stretch() {
    let n = 12;
    let (segments, parents) = chain(n, 0.3, [0.8, 0.0, 0.6]);
    let mut rods = rods(segments, &parents, 1000.0);
    rods.set_state(&vec![2e7; n], &vec![0.0; n]).unwrap();
    let mut still = rods.rest_pose();
    rods.relax(&mut still, &RelaxOptions::default()).unwrap();
    let options = MotionOptions::new().damping(5.0);
    let mut motion = Motion::new(&rods, &rods.rest_pose(), &options).unwrap();
    for _ in 0..600 {
        motion.step().unwrap();
        assert!(motion.largest_gap() < 1e-6, "{}", motion.largest_gap());
    }
    let tip = motion.pose().tails[n - 1];
    for i in 0..3 {
        assert!((tip[i] - still.tails[n - 1][i]).abs() < 1e-4, "{tip:?} {:?}", still.tails[n - 1]);
    }
    assert!((tip[2] - 0.18).abs() > 0.01);
}

#[test]
fn pinned_segments_stay_also_side_by_side() {
    let (mut segments, parents) = chain(9, 0.3, [1.0, 0.0, 0.0]);
    // A zigzag, so that there is slack.
    segments.iter_mut().step_by(2).for_each(|s| s.tail[2] = 0.01);
    segments[4].pinned = true;
    segments[5].pinned = true;
    let mut rods = rods(segments.clone(), &parents, 1000.0);
    rods.set_state(&[3e6; 9], &[0.0; 9]).unwrap();
    let mut pose = rods.rest_pose();
    rods.relax(&mut pose, &RelaxOptions::default()).unwrap();
    let mut motion = Motion::new(&rods, &rods.rest_pose(), &MotionOptions::default()).unwrap();
    (0..100).for_each(|_| motion.step().unwrap());
    for pose in [pose, motion.pose()] {
        for v in [4, 5] {
            let gap = (0..3).map(|i| (pose.tails[v][i] - segments[v].tail[i]).abs());
            assert!(gap.fold(0.0, f64::max) < 1e-6, "{v}");
        }
        assert!(pose.tails[8][2] < -0.01, "{}", pose.tails[8][2]);
    }
}

#[test]
fn arguments_out_of_range_are_named() {
    let (segments, parents) = chain(3, 0.1, [0.0, 0.0, 1.0]);
    let plant = Plant::new(segments, &parents, Some([0.0; 3])).unwrap();
    let says = |error: Error, part: &str| assert!(error.to_string().contains(part), "{error}");
    let wrong = RodOptions::new().poisson(0.7);
    says(Rods::new(&plant, &wrong).unwrap_err(), "poisson");
    let mut rods = Rods::new(&plant, &RodOptions::default()).unwrap();
    says(rods.set_state(&[1.0; 2], &[0.0; 3]).unwrap_err(), "moduli");
    says(
        rods.set_state(&[1.0, 0.0, 1.0], &[0.0; 3]).unwrap_err(),
        "moduli: must be positive and finite, is 0",
    );
    says(rods.set_state(&[1.0; 3], &[f64::NAN; 3]).unwrap_err(), "water");
    let pose = rods.rest_pose();
    says(
        Motion::new(&rods, &pose, &MotionOptions::default()).unwrap_err(),
        "segment 0 must have a positive mass, has 0 kg",
    );
}

#[test]
fn wilting_is_its_steps_and_can_be_stopped() {
    let plant = grow(&GrowthOptions::new().nodes(60)).unwrap();
    let options = WaterOptions::new();
    let model = WaterModel::new(&plant, &options).unwrap();
    let mut rods = Rods::new(&plant, &RodOptions::new()).unwrap();
    let times = [0.0, 7e4, 1.5e5];
    let weather = WiltOptions::new().par(Par::Seq).cycle(Interval::day_and_night(options.loss));
    let found = wilt(&model, &rods, &times, &weather).unwrap();
    let curve = CurveOptions::new().cycle(weather.cycle.clone());
    assert_eq!(found.water, water_curve(&model, &model.full(), &times, &curve).unwrap());
    let mut pose = rods.rest_pose();
    for (i, water) in found.water.iter().enumerate() {
        let moduli = Elasticity::default().moduli(water, &model.full()).unwrap();
        rods.set_state(&moduli, water).unwrap();
        rods.relax(&mut pose, &RelaxOptions::new()).unwrap();
        assert_eq!((&found.moduli[i], &found.poses[i]), (&moduli, &pose));
    }
    let stop = |fraction: f64| match fraction {
        0.9.. => ControlFlow::Break(()),
        _ => ControlFlow::Continue(()),
    };
    let stopped = wilt(&model, &rods, &times, &weather.progress(Progress::new(&stop)));
    assert_eq!(stopped.unwrap_err(), Error::Cancelled);
}

#[test]
fn poses_follow_from_rotations() {
    let plant = grow(&GrowthOptions::new().nodes(30)).unwrap();
    let rods = Rods::new(&plant, &RodOptions::new()).unwrap();
    let half = 0.5_f64.sqrt();
    let mut rotations = vec![[3.0, 0.0, 0.0, 0.0]; 30];
    assert_eq!(rods.pose(&rotations).unwrap(), rods.rest_pose());
    // A quarter turn around z of all: x becomes y.
    rotations.fill([half, 0.0, 0.0, half]);
    let (turned, rest) = (rods.pose(&rotations).unwrap(), rods.rest_pose());
    for (a, b) in turned.tails.iter().zip(&rest.tails) {
        let base = plant.base();
        let d = [0, 1, 2].map(|i| b[i] - base[i]);
        let expected = [base[0] - d[1], base[1] + d[0], b[2]];
        assert!((0..3).all(|i| (a[i] - expected[i]).abs() < 1e-12));
    }
    rotations[7] = [0.0; 4];
    assert!(matches!(rods.pose(&rotations), Err(Error::Argument { what: "rotations", .. })));
    rotations[7][2] = f64::NAN;
    let index = (7, 2);
    assert_eq!(rods.pose(&rotations), Err(Error::NonFinite { what: "rotations", index }));
    assert!(matches!(rods.pose(&rotations[1..]), Err(Error::Shape { .. })));
}

#[test]
fn runs_are_steps_and_stop_where_they_are_told_to() {
    let plant = grow(&GrowthOptions::new().nodes(40)).unwrap();
    let model = WaterModel::new(&plant, &WaterOptions::new()).unwrap();
    let full = model.full();
    let start = || Bdf6::new(&model, &full, 60.0, Start::Radau, Par::Seq).unwrap();
    let stop = |fraction: f64| match fraction {
        0.5.. => ControlFlow::Break(()),
        _ => ControlFlow::Continue(()),
    };
    let (mut steps, mut run) = (start(), start());
    (0..8).for_each(|_| steps.step());
    assert_eq!(run.run(8, Progress::new(&stop)), Err(Error::Cancelled));
    run.run(4, Progress::none()).unwrap();
    assert_eq!(run.water(), steps.water());

    let mut rods = Rods::new(&plant, &RodOptions::new()).unwrap();
    rods.set_state(&Elasticity::default().moduli(&full, &full).unwrap(), &full).unwrap();
    let start = || Motion::new(&rods, &rods.rest_pose(), &MotionOptions::new()).unwrap();
    let (mut steps, mut run) = (start(), start());
    (0..8).for_each(|_| steps.step().unwrap());
    assert_eq!(run.run(8, Progress::new(&stop)), Err(Error::Cancelled));
    run.run(4, Progress::none()).unwrap();
    assert_eq!(run.pose(), steps.pose());
}

/// Relaxes a plant with full cells; its pinned segments must not move.
fn comes_to_rest(plant: &Plant, iterations: usize) {
    let full = WaterModel::new(plant, &WaterOptions::new()).unwrap().full();
    let mut rods = Rods::new(plant, &RodOptions::new()).unwrap();
    rods.set_state(&Elasticity::default().moduli(&full, &full).unwrap(), &full).unwrap();
    let mut pose = rods.rest_pose();
    let done = rods.relax(&mut pose, &RelaxOptions::new()).unwrap();
    assert!(done.residual <= 1e-8 && done.iterations <= iterations, "{done:?}");
    for v in 0..plant.len() {
        let gap = (0..3).map(|i| (pose.heads[v][i] - plant.head(v)[i]).abs()).fold(0.0, f64::max);
        let hangs = !plant.segments()[v].pinned;
        assert!(hangs || gap < 1e-9, "{v}: {gap:e}");
    }
}

#[test]
fn plants_that_are_tied_up_in_many_places_come_to_rest_in_few_iterations() {
    let grown = grow(&GrowthOptions::new().nodes(600)).unwrap();
    let segments: Vec<Segment> =
        (0..600).map(|v| Segment { pinned: v % 40 == 39, ..grown.segments()[v] }).collect();
    let parents: Vec<_> = (0..600).map(|v| grown.parent(v).map(|p| p as u32)).collect();
    comes_to_rest(&Plant::new(segments, &parents, Some(grown.base())).unwrap(), 40);
    // Tied up in 246 places, some paths almost straight between two of them.
    if let Some(path) = crate::common::data("plants/plant006.txt") {
        comes_to_rest(&read(&path).unwrap(), 40);
    }
}
