//! Water, stiffness and pose at equal times.

use anyhow::Result;
use catamaran::Par;
use catamaran::base::Progress;
use catamaran::plant::{
    Conductivity, Elasticity, Interval, Plant, Pose, RodOptions, Rods, WaterModel, WaterOptions,
    WiltOptions, grams_per_hour, wilt,
};

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
    let rods = Rods::new(plant, &RodOptions::default())?;
    let mut options =
        WiltOptions::new().elasticity(weather.elasticity).par(weather.par).progress(progress);
    if weather.nights {
        options = options.cycle(Interval::day_and_night(loss));
    }
    let found = wilt(&model, &rods, &times, &options)?;
    Ok(Simulation {
        hours,
        full,
        water: found.water,
        moduli: found.moduli,
        poses: found.poses,
        iterations: found.iterations,
    })
}
