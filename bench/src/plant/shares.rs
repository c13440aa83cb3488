//! Figure 4.11: the share of the water in the time of a frame.

use std::time::Instant;

use catamaran::Par;
use catamaran_simulation::plant::{
    Bdf6, Elasticity, Motion, MotionOptions, RodOptions, Rods, Start,
};

use super::{Part, Subject};
use crate::Result;
use crate::race::median;

/// Number of timed frames.
const FRAMES: usize = 40;

/// Returns the seconds of a frame: a step of the water with the resulting stiffness, and a step of
/// the rods in motion.
///
/// # Errors
/// The errors of the model and of the rods.
pub fn shares(subjects: &[Subject]) -> Result<Part> {
    let mut rows = Vec::new();
    for subject in subjects {
        let full = subject.model.full();
        let mut bdf = Bdf6::new(&subject.model, &full, 60.0, Start::Radau, Par::Seq)?;
        let mut rods = Rods::new(&subject.plant, &RodOptions::default())?;
        rods.set_state(&Elasticity::default().moduli(&full, &full)?, &full)?;
        let mut motion = Motion::new(&rods, &rods.rest_pose(), &MotionOptions::default())?;
        // The first frame includes the start of the formula, so it is not timed.
        (0..6).for_each(|_| bdf.step());
        let (mut water_times, mut rod_times) = (Vec::new(), Vec::new());
        for _ in 0..FRAMES {
            let start = Instant::now();
            bdf.step();
            let water = bdf.water();
            let moduli = Elasticity::default().moduli(&water, &full)?;
            water_times.push(start.elapsed().as_secs_f64());
            let start = Instant::now();
            rods.set_state(&moduli, &water)?;
            motion.set_rods(&rods)?;
            motion.step()?;
            rod_times.push(start.elapsed().as_secs_f64());
        }
        let [water, rods] = [water_times, rod_times].map(median);
        let name = format!("{} ({} nodes)", subject.name, subject.plant.len());
        rows.push((name, vec![1e6 * water, 1e6 * rods, 100.0 * water / (water + rods)]));
    }
    Ok(Part {
        figure: "figure 4.11",
        title: "time of a frame on one thread; the thesis: about 1 % for the water".into(),
        columns: ["water, us", "rods in motion, us", "water, %"].map(String::from).into(),
        rows,
        plots: vec![],
    })
}
