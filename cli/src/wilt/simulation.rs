//! Computes water, stiffness and pose at equal times, at rest or in motion.

use anyhow::Result;
use catamaran::Par;
use catamaran::base::Progress;
use catamaran_simulation::plant::{
    Balance, Conductivity, Interval, MotionOptions, Plant, Pose, Rewatering, RodOptions, Rods,
    Soil, Stomata, SwayOptions, Tissue, WaterModel, WaterOptions, WiltOptions, Wind,
    grams_per_hour, sway, wilt,
};

/// The conditions of a simulation.
#[derive(Debug, Clone)]
pub struct Weather {
    /// The simulated time, in hours.
    pub hours: f64,
    /// The number of frames after the first.
    pub frames: usize,
    /// The water loss of leaves, in g/(h m^2).
    pub loss: f64,
    /// Whether there are nights.
    pub nights: bool,
    /// The scale of [`Conductivity::Pipe`].
    pub conductance: f64,
    /// The tissue, which determines stiffness from water.
    pub tissue: Tissue,
    /// The stomata, if they close.
    pub stomata: Option<Stomata>,
    /// The soil at the root.
    pub soil: Option<Soil>,
    /// The rewatering of the soil.
    pub rewatering: Vec<Rewatering>,
    /// Nodes, and the factors of the conductance to their parents.
    pub damage: Vec<(usize, f64)>,
    /// The film, in motion; without it the plant is at rest at each moment.
    pub film: Option<Film>,
    /// Threads.
    pub par: Par,
}

/// The hours of a plant as seconds of motion.
#[derive(Debug, Clone, Copy)]
pub struct Film {
    /// The length of the film, in seconds.
    pub seconds: f64,
    /// The options of the motion of rods.
    pub motion: MotionOptions,
    /// The wind.
    pub wind: Option<Wind>,
}

/// The effort of the motion.
pub struct Effort {
    /// The number of steps in all.
    pub steps: usize,
    /// The length of a step, in seconds.
    pub step: f64,
    /// The largest gap between segments, in metres.
    pub largest_gap: f64,
    /// The mean time of a step, in milliseconds.
    pub milliseconds: f64,
    /// The share of that time for the water, from 0 to 1.
    pub water_share: f64,
}

/// The result of a simulation, frame by frame.
pub struct Simulation {
    /// The times, in hours.
    pub hours: Vec<f64>,
    /// The water of each node when cells are full, in kg.
    pub full: Vec<f64>,
    /// The water of each node at each time, in kg.
    pub water: Vec<Vec<f64>>,
    /// The balance of plant and soil at each time.
    pub balance: Vec<Balance>,
    /// The capacity of the soil, in kg, if there is one.
    pub capacity: Option<f64>,
    /// The modulus of each node at each time, in Pa.
    pub moduli: Vec<Vec<f64>>,
    /// The pose at each time.
    pub poses: Vec<Pose>,
    /// The largest number of Newton iterations of a pose at rest; 0 in motion.
    pub iterations: usize,
    /// The effort of the motion, for a film.
    pub effort: Option<Effort>,
}

impl Weather {
    /// Returns the water loss of leaves, in the unit of the library.
    fn loss_rate(&self) -> f64 {
        grams_per_hour(self.loss)
    }

    /// Returns the cycle of days and nights, empty without nights.
    fn cycle(&self) -> Vec<Interval> {
        if self.nights { Interval::day_and_night(self.loss_rate()) } else { vec![] }
    }

    /// Returns the times of the frames, in hours.
    fn frame_hours(&self) -> Vec<f64> {
        (0..=self.frames).map(|i| self.hours * i as f64 / self.frames.max(1) as f64).collect()
    }

    /// Returns the water of a plant, with the damage.
    fn model(&self, plant: &Plant) -> Result<WaterModel> {
        let options = WaterOptions::new()
            .loss(self.loss_rate())
            .conductivity(Conductivity::Pipe { scale: self.conductance });
        let mut model = WaterModel::new(plant, &options)?;
        for &(node, factor) in &self.damage {
            model.weaken(node, factor)?;
        }
        Ok(model)
    }
}

/// Simulates a plant that wilts, in motion if there is a film.
pub fn simulate(plant: &Plant, weather: &Weather, progress: Progress<'_>) -> Result<Simulation> {
    let model = weather.model(plant)?;
    let rods = Rods::new(plant, &RodOptions::default())?;
    match &weather.film {
        Some(film) => in_motion(&model, &rods, weather, film, progress),
        None => at_rest(&model, &rods, weather, progress),
    }
}

fn in_motion(
    model: &WaterModel,
    rods: &Rods,
    weather: &Weather,
    film: &Film,
    progress: Progress<'_>,
) -> Result<Simulation> {
    let options = SwayOptions::new()
        .drought(3600.0 * weather.hours)
        .seconds(film.seconds)
        .frames(weather.frames.max(1))
        .elasticity(weather.tissue.clone())
        .cycle(weather.cycle())
        .stomata(weather.stomata)
        .soil(weather.soil)
        .rewatering(weather.rewatering.clone())
        .motion(film.motion)
        .wind(film.wind)
        .par(weather.par)
        .progress(progress);
    let found = sway(model, rods, &options)?;
    let steps = found.steps * weather.frames.max(1);
    let spent = (found.water_time + found.rods_time).as_secs_f64();
    let effort = Effort {
        steps,
        step: found.step,
        largest_gap: found.largest_gap,
        milliseconds: 1e3 * spent / steps as f64,
        water_share: found.water_share(),
    };
    Ok(Simulation {
        hours: weather.frame_hours(),
        full: model.full(),
        water: found.water,
        balance: found.balance,
        capacity: weather.soil.map(|soil| soil.capacity),
        moduli: found.moduli,
        poses: found.poses,
        iterations: 0,
        effort: Some(effort),
    })
}

fn at_rest(
    model: &WaterModel,
    rods: &Rods,
    weather: &Weather,
    progress: Progress<'_>,
) -> Result<Simulation> {
    let hours = weather.frame_hours();
    let times: Vec<f64> = hours.iter().map(|h| 3600.0 * h).collect();
    let options = WiltOptions::new()
        .elasticity(weather.tissue.clone())
        .cycle(weather.cycle())
        .stomata(weather.stomata)
        .soil(weather.soil)
        .rewatering(weather.rewatering.clone())
        .par(weather.par)
        .progress(progress);
    let found = wilt(model, rods, &times, &options)?;
    Ok(Simulation {
        hours,
        full: model.full(),
        water: found.water,
        balance: found.balance,
        capacity: weather.soil.map(|soil| soil.capacity),
        moduli: found.moduli,
        poses: found.poses,
        iterations: found.iterations,
        effort: None,
    })
}
