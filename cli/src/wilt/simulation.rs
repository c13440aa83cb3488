//! Water, stiffness and pose at equal times, at rest or in motion.

use anyhow::Result;
use catamaran::Par;
use catamaran::base::Progress;
use catamaran::plant::{
    Balance, Conductivity, Interval, MotionOptions, Plant, Pose, Rewatering, RodOptions, Rods,
    Soil, Stomata, SwayOptions, Tissue, WaterModel, WaterOptions, WiltOptions, Wind,
    grams_per_hour, sway, wilt,
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
    pub tissue: Tissue,
    /// Whether and how stomata close.
    pub stomata: Option<Stomata>,
    /// At the root.
    pub soil: Option<Soil>,
    /// Of the soil.
    pub rewatering: Vec<Rewatering>,
    /// Nodes, and what the conductance to their parents is multiplied by.
    pub damage: Vec<(usize, f64)>,
    /// A film of it, in motion; without, the plant is at rest at each moment.
    pub film: Option<Film>,
    /// Threads.
    pub par: Par,
}

/// The hours of a plant as seconds of motion.
#[derive(Debug, Clone, Copy)]
pub struct Film {
    /// How long it is.
    pub seconds: f64,
    /// Of rods.
    pub motion: MotionOptions,
    /// The air.
    pub wind: Option<Wind>,
}

/// What moving took.
pub struct Effort {
    /// Steps in all, and their length in seconds.
    pub steps: usize,
    /// In seconds.
    pub step: f64,
    /// In metres.
    pub largest_gap: f64,
    /// Milliseconds of a step, in the mean.
    pub milliseconds: f64,
    /// Of the water, as a part of it.
    pub water_share: f64,
}

/// What became of a plant, frame by frame.
pub struct Simulation {
    /// When.
    pub hours: Vec<f64>,
    /// In kg, when cells are full.
    pub full: Vec<f64>,
    /// In kg.
    pub water: Vec<Vec<f64>>,
    /// Of plant and soil.
    pub balance: Vec<Balance>,
    /// What the soil holds at most, in kg, if there is one.
    pub capacity: Option<f64>,
    /// In Pa.
    pub moduli: Vec<Vec<f64>>,
    /// At each moment.
    pub poses: Vec<Pose>,
    /// The most Newton iterations that a pose at rest took; 0 in motion.
    pub iterations: usize,
    /// Of a film.
    pub effort: Option<Effort>,
}

/// Lets a plant wilt, and move where there is to be a film.
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
    let capacity = weather.soil.map(|soil| soil.capacity);
    let cycle = if weather.nights { Interval::day_and_night(loss) } else { vec![] };
    if let Some(film) = &weather.film {
        let options = SwayOptions::new()
            .drought(3600.0 * weather.hours)
            .seconds(film.seconds)
            .frames(weather.frames.max(1))
            .elasticity(weather.tissue.clone())
            .cycle(cycle)
            .stomata(weather.stomata)
            .soil(weather.soil)
            .rewatering(weather.rewatering.clone())
            .motion(film.motion)
            .wind(film.wind)
            .par(weather.par)
            .progress(progress);
        let found = sway(&model, &rods, &options)?;
        let steps = found.steps * weather.frames.max(1);
        let spent = (found.water_time + found.rods_time).as_secs_f64();
        let effort = Effort {
            steps,
            step: found.step,
            largest_gap: found.largest_gap,
            milliseconds: 1e3 * spent / steps as f64,
            water_share: found.water_share(),
        };
        return Ok(Simulation {
            hours,
            full,
            water: found.water,
            balance: found.balance,
            capacity,
            moduli: found.moduli,
            poses: found.poses,
            iterations: 0,
            effort: Some(effort),
        });
    }
    let options = WiltOptions::new()
        .elasticity(weather.tissue.clone())
        .cycle(cycle)
        .stomata(weather.stomata)
        .soil(weather.soil)
        .rewatering(weather.rewatering.clone())
        .par(weather.par)
        .progress(progress);
    let found = wilt(&model, &rods, &times, &options)?;
    Ok(Simulation {
        hours,
        full,
        water: found.water,
        balance: found.balance,
        capacity,
        moduli: found.moduli,
        poses: found.poses,
        iterations: found.iterations,
        effort: None,
    })
}
