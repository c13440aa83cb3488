//! Rods in the wind, and with the water that they lose.

use catamaran::{Error, Par};
use catamaran_simulation::plant::families::{GrowthOptions, grow};
use catamaran_simulation::plant::*;

/// In g / (h m^2): a plant dries within a day.
const LOSS: f64 = 1500.0;

fn grown(nodes: usize) -> (WaterModel, Rods) {
    let plant = grow(&GrowthOptions::new().nodes(nodes)).unwrap();
    let model = WaterModel::new(&plant, &WaterOptions::new().loss(grams_per_hour(LOSS))).unwrap();
    (model, Rods::new(&plant, &RodOptions::new()).unwrap())
}

#[test]
fn a_hanging_segment_leans_as_drag_and_weight_balance() {
    let (length, radius, speed) = (0.2, 2e-3, 5.0);
    for leaf_area in [None, Some(3e-4)] {
        let mut segment = Segment::stem([0.0, 0.0, -length], radius);
        (segment.leaf, segment.leaf_area) = (leaf_area.is_some(), leaf_area);
        let plant = Plant::new(vec![segment], &[None], Some([0.0; 3])).unwrap();
        let mut rods = Rods::new(&plant, &RodOptions::new().dry_density(1000.0)).unwrap();
        rods.set_state(&[1.0], &[0.0]).unwrap();
        let options = MotionOptions::new().damping(4.0);
        let mut motion = Motion::new(&rods, &rods.rest_pose(), &options).unwrap();
        motion.set_wind([speed, 0.0, 0.0]).unwrap();
        (0..1500).for_each(|_| motion.step().unwrap());
        let tip = motion.pose().tails[0];
        let (sine, cosine) = (tip[0] / length, -tip[2] / length);
        // Torques about the hinge, both with half of the length as their arm.
        let pressure = 0.5 * 1.2 * 1.2 * speed * speed;
        let weight = 1000.0 * plant.volume(0) * 9.81;
        let stem = pressure * 2.0 * radius * length * cosine * cosine;
        let leaf = pressure * leaf_area.unwrap_or(0.0) * cosine;
        let balance = (stem + leaf) / (weight * sine);
        assert!(sine > 0.1 && (balance - 1.0).abs() < 1e-3, "{balance} at {tip:?}");
    }
}

#[test]
fn a_film_ends_at_rest_where_a_pose_at_rest_is() {
    let (model, rods) = grown(120);
    // Half of the time it dries, then it comes to rest.
    let (drought, loss) = (2e5, grams_per_hour(LOSS));
    let cycle =
        vec![Interval { seconds: 0.5 * drought, loss }, Interval { seconds: drought, loss: 0.0 }];
    let motion = MotionOptions::new().damping(6.0);
    let options = SwayOptions::new().drought(drought).seconds(40.0).frames(20);
    let film = sway(&model, &rods, &options.motion(motion).cycle(cycle.clone())).unwrap();
    assert_eq!((film.water.len(), film.moduli.len(), film.steps), (21, 21, 120));
    let times: Vec<f64> = (0..=20).map(|i| drought * f64::from(i) / 20.0).collect();
    let still = wilt(&model, &rods, &times, &WiltOptions::new().cycle(cycle)).unwrap();
    assert!(largest_difference(&model, &film.water, &still.water) < 1e-11);
    assert_eq!(film.poses[0], still.poses[0]);
    let furthest = |i: usize, j: usize| {
        let gaps = film.poses[i].tails.iter().zip(&still.poses[j].tails);
        let gaps = gaps.map(|(a, b)| (0..3).map(|k| (a[k] - b[k]).abs()).fold(0.0, f64::max));
        gaps.fold(0.0, f64::max)
    };
    assert!(furthest(20, 0) > 0.01, "{}", furthest(20, 0));
    assert!(furthest(20, 20) < 1e-3, "{}", furthest(20, 20));
    assert!(film.largest_gap < 1e-4, "{}", film.largest_gap);
    assert!((0.0..1.0).contains(&film.water_share()));
}

/// The largest difference of the water of a node, as a part of that of its full cells.
fn largest_difference(model: &WaterModel, a: &[Vec<f64>], b: &[Vec<f64>]) -> f64 {
    let of_frame = |(a, b): (&Vec<f64>, &Vec<f64>)| {
        let gaps = a.iter().zip(b).zip(model.full()).map(|((a, b), full)| (a - b).abs() / full);
        gaps.fold(0.0, f64::max)
    };
    a.iter().zip(b).map(of_frame).fold(0.0, f64::max)
}

#[test]
fn the_water_of_a_film_is_as_exact_in_few_steps_as_in_many() {
    // At the usual conductance leaves exchange water within hours, as long as a step.
    let (model, rods) = grown(300);
    let times: Vec<f64> = (0..=2).map(|i| 1e5 * f64::from(i)).collect();
    let still = wilt(&model, &rods, &times, &WiltOptions::new()).unwrap();
    for steps in [2, 12, 40] {
        let options = SwayOptions::new().drought(2e5).frames(2).seconds(f64::from(steps) / 60.0);
        let film = sway(&model, &rods, &options).unwrap();
        assert_eq!(film.steps, steps as usize / 2);
        let gap = largest_difference(&model, &film.water, &still.water);
        assert!(gap < 1e-11, "{steps} steps: {gap}");
    }
}

/// The largest way of a segment between two frames, in metres; and segments hang together.
fn largest_way(film: &Sway) -> f64 {
    assert!(film.largest_gap < 1e-3, "{}", film.largest_gap);
    let mut largest = 0.0;
    for (pose, next) in film.poses.iter().zip(&film.poses[1..]) {
        for (a, b) in pose.tails.iter().zip(&next.tails) {
            largest = (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt().max(largest);
        }
    }
    largest
}

#[test]
fn a_plant_of_2000_nodes_stays_stable_at_60_frames_a_second_as_it_collapses() {
    let (model, rods) = grown(2000);
    // Two days in half a second: what held it gives way at once.
    let options = SwayOptions::new().drought(2e5).seconds(0.5).frames(6);
    let way = largest_way(&sway(&model, &rods, &options).unwrap());
    // No faster than what falls freely.
    assert!((1e-3..9.81 * 0.5 / 12.0 * 2.0).contains(&way), "{way}");
}

#[test]
fn steps_of_any_length_stay_stable_in_a_storm() {
    let (model, rods) = grown(60);
    let storm = Wind::new().velocity([12.0, 5.0, 0.0]).turbulence(0.3).seed(1);
    for step in [1.0 / 60.0, 0.25] {
        let motion = MotionOptions::new().step(step);
        let options = SwayOptions::new().drought(2e5).seconds(8.0 * step).frames(4);
        let way =
            largest_way(&sway(&model, &rods, &options.motion(motion).wind(Some(storm))).unwrap());
        // No faster than a gust, nor farther than the plant is wide.
        assert!(way < (2.0 * step * 30.0).min(0.6), "{step}: {way}");
    }
}

#[test]
fn a_film_is_the_same_again_and_on_any_number_of_threads() {
    let (model, rods) = grown(80);
    let wind = Some(Wind::new().velocity([1.0, 2.0, 0.0]));
    let film = |par: Par| {
        let options = SwayOptions::new().drought(1e5).seconds(0.5).frames(3).wind(wind).par(par);
        sway(&model, &rods, &options).unwrap()
    };
    let (one, two) = (film(Par::Seq), film(Par::Threads(2)));
    assert_eq!((&one.poses, &one.water), (&two.poses, &two.water));
    assert_eq!(one.poses.len(), 4);
    assert!(one.poses[3] != one.poses[0]);
}

#[test]
fn options_of_a_film_out_of_range_are_named() {
    let (model, rods) = grown(3);
    let says = |options: SwayOptions<'_>, part: &str| {
        let error: Error = sway(&model, &rods, &options).unwrap_err();
        assert!(error.to_string().contains(part), "{error}");
    };
    says(SwayOptions::new().drought(-1.0), "drought");
    says(SwayOptions::new().seconds(0.0), "seconds");
    says(SwayOptions::new().frames(0), "frames");
    says(SwayOptions::new().motion(MotionOptions::new().step(0.0)), "step");
    says(SwayOptions::new().motion(MotionOptions::new().drag(-1.0)), "drag");
    says(SwayOptions::new().wind(Some(Wind::new().memory(-1.0))), "memory");
    let mut motion = Motion::new(&rods, &rods.rest_pose(), &MotionOptions::new());
    assert!(matches!(motion, Err(Error::Argument { what: "masses", .. })));
    let mut heavy = rods.clone();
    heavy.set_state(&[1e6; 3], &[1e-3; 3]).unwrap();
    motion = Motion::new(&heavy, &heavy.rest_pose(), &MotionOptions::new());
    let refused = motion.unwrap().set_wind([f64::NAN; 3]);
    assert!(matches!(refused, Err(Error::Argument { what: "wind", .. })), "{refused:?}");
}
