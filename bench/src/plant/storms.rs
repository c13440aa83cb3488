//! Storms over plants of 2,000 nodes: the cost of motion, and its stability.

use std::time::Instant;

use catamaran::Par;
use catamaran_simulation::plant::families::{GrowthOptions, grow};
use catamaran_simulation::plant::{
    Bdf6, Gusts, Motion, MotionOptions, RodOptions, Rods, Start, Tissue, WaterModel, WaterOptions,
    Wind,
};

use super::Part;
use crate::Result;

/// Number of nodes of the plant.
const NODES: usize = 2000;

/// Number of frames of storm, and of still air after it; a frame lasts a sixtieth of a second.
const STORM: usize = 120;
const CALM: usize = 60;

/// Mean velocities in m / s.
const WINDS: [f64; 3] = [2.0, 8.0, 20.0];

/// Moduli of elasticity in Pa: of stiff rods, of plants, of soft rods.
const MODULI: [(&str, Option<f64>); 3] =
    [("5 GPa", Some(5e9)), ("of the water", None), ("0.1 MPa", Some(1e5))];

/// Computes motion in gusts of 30 % of the mean wind, then in still air: time of a frame, the share
/// of the water in it, and energies.
///
/// # Errors
/// The errors of the model and of the rods.
pub fn storms() -> Result<Part> {
    let mut rows = Vec::new();
    for speed in WINDS {
        for (name, modulus) in MODULI {
            let row = storm(NODES, speed, modulus)?;
            eprintln!("{speed} m / s, {name}: {row:?}");
            rows.push((format!("{speed} m / s, E {name}"), row));
        }
    }
    let columns = [
        "frame, ms",
        "slowest frame, ms",
        "water, %",
        "largest kinetic energy / that at the speed of the strongest gust",
        "largest rise of all energy in a calm frame, as a part of that",
        "largest gap, um",
    ];
    Ok(Part {
        figure: "storms",
        title: format!(
            "{NODES} nodes at 60 frames a second on one thread, {STORM} frames in gusts of 30 % turbulence and {CALM} in still \
             air after them"
        ),
        columns: columns.map(String::from).into(),
        rows,
        plots: vec![],
    })
}

fn storm(nodes: usize, speed: f64, modulus: Option<f64>) -> Result<Vec<f64>> {
    let plant = grow(&GrowthOptions::new().nodes(nodes))?;
    let model = WaterModel::new(&plant, &WaterOptions::new())?;
    let full = model.full();
    let mut bdf = Bdf6::new(&model, &full, 60.0, Start::Radau, Par::Seq)?;
    let mut rods = Rods::new(&plant, &RodOptions::new())?;
    let tissue = Tissue::default();
    let moduli_of = |water: &[f64]| match modulus {
        Some(modulus) => Ok(vec![modulus; nodes]),
        None => tissue.moduli(water, &full),
    };
    rods.set_state(&moduli_of(&full)?, &full)?;
    let mut motion = Motion::new(&rods, &rods.rest_pose(), &MotionOptions::new())?;
    let velocity = [0.8 * speed, 0.6 * speed, 0.0];
    let mut gusts = Gusts::new(&Wind::new().velocity(velocity).turbulence(0.3).seed(4))?;
    let mass: f64 = 1.1 * full.iter().sum::<f64>();
    let (mut water_time, mut rods_time, mut slowest) = (0.0, 0.0, 0.0_f64);
    let (mut strongest, mut kinetic, mut gap, mut rise) = (0.0_f64, 0.0_f64, 0.0_f64, 0.0_f64);
    for frame in 0..STORM + CALM {
        let start = Instant::now();
        bdf.step();
        let water = bdf.water();
        let moduli = moduli_of(&water)?;
        let water_seconds = start.elapsed().as_secs_f64();
        let start = Instant::now();
        if frame < STORM {
            // In still air, weights and stiffness do not change, because they would change the
            // energy.
            rods.set_state(&moduli, &water)?;
            motion.set_rods(&rods)?;
        }
        let wind = if frame < STORM { gusts.after(1.0 / 60.0) } else { [0.0; 3] };
        motion.set_wind(wind)?;
        strongest = strongest.max(wind.iter().map(|x| x * x).sum::<f64>().sqrt());
        let before = motion.energy().total();
        motion.step()?;
        let rods_seconds = start.elapsed().as_secs_f64();
        let energy = motion.energy();
        if !energy.total().is_finite() {
            return Err(format!("{speed} m / s: the energy is {energy:?} in frame {frame}").into());
        }
        kinetic = kinetic.max(energy.kinetic);
        gap = gap.max(motion.largest_gap());
        if frame >= STORM {
            rise = rise.max(energy.total() - before);
        }
        (water_time, rods_time) = (water_time + water_seconds, rods_time + rods_seconds);
        slowest = slowest.max(water_seconds + rods_seconds);
    }
    let unit = 0.5 * mass * strongest * strongest;
    let frames = (STORM + CALM) as f64;
    Ok(vec![
        1e3 * (water_time + rods_time) / frames,
        1e3 * slowest,
        100.0 * water_time / (water_time + rods_time),
        kinetic / unit,
        rise / unit,
        1e6 * gap,
    ])
}
