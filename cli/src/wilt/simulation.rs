//! Water, stiffness and pose at equal times.

use anyhow::Result;
use catamaran::base::Progress;
use catamaran::plant::{
    Conductivity, CurveOptions, Elasticity, Interval, Plant, Pose, RelaxOptions, RodOptions, Rods,
    WaterModel, WaterOptions, grams_per_hour, water_curve,
};
use catamaran::{Error, Par};

/// The hours of a day that are light, and those that are dark.
const DAY: [f64; 2] = [16.0, 8.0];

/// What leaves lose by night, as a part of what they lose by day.
const NIGHT_LOSS: f64 = 1.0 / 12.0;

/// A torque out of balance, as a part of the largest of a weight, that no picture shows.
const SEEN: f64 = 1e-4;

/// The share of the time that goes into water, not poses.
const WATER_SHARE: f64 = 0.2;

/// What a plant goes through.
#[derive(Debug, Clone)]
pub struct Weather {
    /// How long.
    pub hours: f64,
    /// Frames after the first.
    pub frames: usize,
    /// In g / (h m^2).
    pub loss: f64,
    /// Whether there are nights.
    pub nights: bool,
    /// The scale of [`Conductivity::Pipe`].
    pub conductance: f64,
    /// Stiffness from water.
    pub elasticity: Elasticity,
    /// Nodes, and what the conductance to their parents is multiplied by.
    pub damage: Vec<(usize, f64)>,
    /// Threads.
    pub par: Par,
}

/// What became of a plant, frame by frame.
pub struct Simulation {
    /// When.
    pub hours: Vec<f64>,
    /// In kg, when cells are full.
    pub full: Vec<f64>,
    /// In kg.
    pub water: Vec<Vec<f64>>,
    /// In Pa.
    pub moduli: Vec<Vec<f64>>,
    /// At rest in the weight of each moment.
    pub poses: Vec<Pose>,
    /// The most that a frame took.
    pub iterations: usize,
}

/// Lets a plant wilt.
pub fn simulate(plant: &Plant, weather: &Weather, progress: Progress<'_>) -> Result<Simulation> {
    let loss = grams_per_hour(weather.loss);
    let options = WaterOptions::new()
        .loss(loss)
        .conductivity(Conductivity::Pipe { scale: weather.conductance });
    let mut model = WaterModel::new(plant, &options)?;
    for &(node, factor) in &weather.damage {
        model.weaken(node, factor)?;
    }
    let full = model.full();
    let hours: Vec<f64> = (0..=weather.frames)
        .map(|i| weather.hours * i as f64 / weather.frames.max(1) as f64)
        .collect();
    let times: Vec<f64> = hours.iter().map(|h| 3600.0 * h).collect();
    let [light, dark] = DAY.map(|hours| 3600.0 * hours);
    let cycle = match weather.nights {
        true => vec![
            Interval { seconds: light, loss },
            Interval { seconds: dark, loss: loss * NIGHT_LOSS },
        ],
        false => vec![],
    };
    let options =
        CurveOptions::new().cycle(cycle).par(weather.par).progress(progress.part(0.0..WATER_SHARE));
    let water = water_curve(&model, &full, &times, &options)?;

    let mut rods = Rods::new(plant, &RodOptions::default())?;
    let mut pose = rods.rest_pose();
    let (mut moduli, mut poses, mut iterations) = (Vec::new(), Vec::new(), 0);
    for (i, water) in water.iter().enumerate() {
        let stiffness = weather.elasticity.moduli(water, &full)?;
        rods.set_state(&stiffness, water)?;
        let at = |i: usize| WATER_SHARE + (1.0 - WATER_SHARE) * i as f64 / hours.len() as f64;
        let progress = progress.part(at(i)..at(i + 1));
        let options = RelaxOptions::new().progress(progress);
        iterations = iterations.max(match rods.relax(&mut pose, &options) {
            Ok(done) => done.iterations,
            // What is pulled straight between pins comes near balance, slowly.
            Err(Error::NotConverged { iterations, residual }) if residual <= SEEN => iterations,
            Err(error) => return Err(error.into()),
        });
        moduli.push(stiffness);
        poses.push(pose.clone());
    }
    Ok(Simulation { hours, full, water, moduli, poses, iterations })
}
