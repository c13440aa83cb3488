//! Storms: motion stays stable whatever the gusts and the stiffness.

use catamaran_simulation::plant::families::{GrowthOptions, grow};
use catamaran_simulation::plant::*;

/// Frames of storm, and of still air after it.
const STORM: usize = 45;
const CALM: usize = 15;

/// Sways a plant of this modulus of elasticity (in Pa) in gusts around this speed, in steps of
/// `step` seconds, and then in still air.
fn storm(nodes: usize, modulus: f64, speed: f64, step: f64) {
    let name = format!("{nodes} nodes, {modulus:e} Pa, {speed} m / s, {step} s");
    let plant = grow(&GrowthOptions::new().nodes(nodes)).unwrap();
    let full = WaterModel::new(&plant, &WaterOptions::new()).unwrap().full();
    let mut rods = Rods::new(&plant, &RodOptions::new()).unwrap();
    rods.set_state(&vec![modulus; nodes], &full).unwrap();
    let options = MotionOptions::new().step(step);
    let mut motion = Motion::new(&rods, &rods.rest_pose(), &options).unwrap();
    let velocity = [0.8 * speed, 0.6 * speed, 0.0];
    let mut gusts = Gusts::new(&Wind::new().velocity(velocity).turbulence(0.3).seed(4)).unwrap();
    // Dry matter of 100 kg / m^3 beside water of 1000.
    let mass = 1.1 * full.iter().sum::<f64>();
    let height = plant.segments().iter().map(|s| s.tail[2]).fold(0.0, f64::max);
    let start = motion.energy().total();
    let mut strongest = 0.0_f64;
    for frame in 0..STORM + CALM {
        let wind = if frame < STORM { gusts.after(step) } else { [0.0; 3] };
        strongest = strongest.max(wind.iter().map(|x| x * x).sum::<f64>());
        motion.set_wind(wind).unwrap();
        let before = motion.energy().total();
        motion.step().unwrap();
        let energy = motion.energy();
        assert!(energy.total().is_finite(), "{name}: {energy:?}");
        // No faster than the air, and what falls as far as the plant is high.
        let bound = 0.5 * mass * strongest + mass * 9.81 * height;
        assert!(energy.kinetic <= bound, "{name}: {energy:?}, {bound:e} in frame {frame}");
        // The air can bend it no farther than at its own pace.
        assert!(energy.total() - start <= bound, "{name}: {energy:?}");
        assert!(motion.largest_gap() < 1e-4, "{name}: {:e}", motion.largest_gap());
        if frame >= STORM {
            // Still air, damping and implicit steps only ever take energy.
            let rise = energy.total() - before;
            assert!(rise <= 1e-9 * bound, "{name}: {rise:e} of {bound:e} in frame {frame}");
        }
    }
    let pose = motion.pose();
    assert!(pose.tails.iter().flatten().all(|x| x.is_finite()), "{name}");
}

#[test]
fn energy_stays_bounded_in_gusts_whether_rods_are_stiff_or_soft() {
    for modulus in [5e9, 2e7, 1e5] {
        storm(300, modulus, 20.0, 1.0 / 60.0);
    }
}

#[test]
fn energy_stays_bounded_in_long_steps() {
    for modulus in [5e9, 1e5] {
        storm(60, modulus, 30.0, 0.25);
    }
}
