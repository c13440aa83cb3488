use std::time::{Duration, Instant};

use super::curve::{CurveOptions, Interval, Method};
use super::rods::{Motion, MotionOptions, Pose, Rods};
use super::soil::{Balance, Rewatering, Soil};
use super::stomata::Stomata;
use super::tissue::Tissue;
use super::walk::Walk;
use super::water::WaterModel;
use super::wilt::{check_frames, settle};
use super::wind::{Gusts, Wind};
use catamaran::base::{Error, Par, Progress, Result, at_least, at_least_zero, builder, positive};

/// Options of [`sway`].
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct SwayOptions<'a> {
    /// Duration of the drought, in seconds. Default 0.
    pub drought: f64,
    /// Duration of the motion, in seconds. Default 10.
    pub seconds: f64,
    /// Number of frames after the first, at equal times, at least 1. Default 240.
    pub frames: usize,
    /// The law from water to stiffness, one for all segments or by classes; default that of
    /// [`Elasticity`](super::Elasticity).
    pub elasticity: Tissue,
    /// As [`CurveOptions::cycle`], such as [`Interval::day_and_night`].
    pub cycle: Vec<Interval>,
    /// As [`CurveOptions::stomata`].
    pub stomata: Option<Stomata>,
    /// As [`CurveOptions::soil`].
    pub soil: Option<Soil>,
    /// As [`CurveOptions::rewatering`].
    pub rewatering: Vec<Rewatering>,
    /// The options of the motion. Steps are shortened, if needed, so that frames are at multiples
    /// of them.
    pub motion: MotionOptions,
    /// The wind; by default there is no air.
    pub wind: Option<Wind>,
    /// Threads of the water; default [`Par::all`]. Does not change the result.
    pub par: Par,
    /// Callback for progress, which may cancel.
    pub progress: Progress<'a>,
}

impl Default for SwayOptions<'_> {
    fn default() -> Self {
        Self {
            drought: 0.0,
            seconds: 10.0,
            frames: 240,
            elasticity: Tissue::default(),
            cycle: vec![],
            stomata: None,
            soil: None,
            rewatering: vec![],
            motion: MotionOptions::default(),
            wind: None,
            par: Par::all(),
            progress: Progress::none(),
        }
    }
}

builder! { SwayOptions<'a> {
    drought: f64,
    seconds: f64,
    frames: usize,
    #[into] elasticity: Tissue,
    cycle: Vec<Interval>,
    stomata: Option<Stomata>,
    soil: Option<Soil>,
    rewatering: Vec<Rewatering>,
    motion: MotionOptions,
    wind: Option<Wind>,
    par: Par,
    #[into] progress: Progress<'a>,
}}

/// The result of [`sway`]: a plant in motion, frame by frame. In the first frame it is at rest.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Sway {
    /// Water of every node, in kg.
    pub water: Vec<Vec<f64>>,
    /// Balance of the water of plant and soil.
    pub balance: Vec<Balance>,
    /// The modulus of elasticity of every segment, in Pa.
    pub moduli: Vec<Vec<f64>>,
    /// The poses in motion.
    pub poses: Vec<Pose>,
    /// Number of steps between frames.
    pub steps: usize,
    /// Length of a step in seconds.
    pub step: f64,
    /// The largest gap between a segment and its parent, in metres.
    pub largest_gap: f64,
    /// Time for the computation of water and stiffness, in all steps.
    pub water_time: Duration,
    /// Time for the computation of the rods.
    pub rods_time: Duration,
}

impl Sway {
    /// Returns the share of the water in the computing time of a step (thesis, figure 4.11: about
    /// 0.01).
    pub fn water_share(&self) -> f64 {
        let water = self.water_time.as_secs_f64();
        water / (water + self.rods_time.as_secs_f64()).max(f64::MIN_POSITIVE)
    }
}

/// Returns the options of the water, in steps of `lapse` seconds.
fn course(options: &SwayOptions<'_>, lapse: f64) -> CurveOptions<'static> {
    let is_linear = options.stomata.is_none() && options.soil.is_none();
    let method = match is_linear {
        false => Method::Auto,
        true if lapse > 0.0 => Method::Bdf6 { step: lapse },
        true => Method::Rational,
    };
    CurveOptions::new()
        .method(method)
        .cycle(options.cycle.clone())
        .stomata(options.stomata)
        .soil(options.soil)
        .rewatering(options.rewatering.clone())
        .par(options.par)
}

/// Simulates a plant that dries, wilts and moves, as in a time-lapse film: `options.drought`
/// seconds of water pass in `options.seconds` of motion. In every step, [`Bdf6`](super::Bdf6) (with
/// stomata or soil, the method of [`Method::Auto`]) advances the water, the stiffness and the
/// weight are computed from it (thesis, section 4.5.4), and [`Motion`] advances the rods in the
/// current wind. The plant begins with full cells and at rest, or, between pins, in the pose of
/// [`Rods::relax`].
///
/// ```
/// use catamaran_simulation::plant::families::{GrowthOptions, grow};
/// use catamaran_simulation::plant::{RodOptions, Rods, SwayOptions, WaterModel, WaterOptions, Wind, sway};
///
/// let plant = grow(&GrowthOptions::new().nodes(60))?;
/// let model = WaterModel::new(&plant, &WaterOptions::new())?;
/// let rods = Rods::new(&plant, &RodOptions::new())?;
/// let wind = Wind::new().velocity([2.0, 0.0, 0.0]);
/// let options = SwayOptions::new().drought(86_400.0).seconds(1.0).frames(10).wind(Some(wind));
/// let film = sway(&model, &rods, &options)?;
/// assert_eq!(film.poses.len(), 11);
/// let across = |i: usize| film.poses[i].tails.iter().map(|tail| tail[0]).sum::<f64>();
/// assert!(across(10) > across(0)); // it leans with the wind
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Argument`] names an option out of its range; those of [`WaterModel`],
/// [`Tissue::moduli`], [`Rods::relax`] and [`Motion::step`]; [`Error::Cancelled`],
/// [`Error::OutOfMemory`].
pub fn sway(model: &WaterModel, rods: &Rods, options: &SwayOptions<'_>) -> Result<Sway> {
    at_least_zero("drought", options.drought)?;
    positive("seconds", options.seconds)?;
    positive("step", options.motion.step)?;
    at_least("frames", options.frames, 1)?;
    let frame = options.seconds / options.frames as f64;
    // A step that exceeds the interval by rounding only counts as fitting.
    let steps = (frame / options.motion.step - 1e-9).ceil().max(1.0);
    let step = frame / steps;
    let steps = steps as usize;
    let count = steps.saturating_mul(options.frames);
    let lapse = options.drought / count as f64;
    let mut gusts = options.wind.as_ref().map(Gusts::new).transpose()?;

    let full = model.full();
    check_frames("frames", options.frames, full.len())?;
    let course = course(options, lapse);
    let mut walk = Walk::new(model, &full, &[], &course)?;
    let mut rods = rods.clone();
    let mut water = full.clone();
    let mut moduli = options.elasticity.moduli(&water, &full)?;
    rods.set_state(&moduli, &water)?;
    let mut pose = rods.rest_pose();
    match settle(&rods, &mut pose, Progress::none()) {
        // A plant that pins stretch comes to rest slowly; the motion continues from there.
        Ok(_) | Err(Error::NotConverged { .. }) => {}
        Err(error) => return Err(error),
    }
    let mut motion = Motion::new(&rods, &pose, &options.motion.step(step))?;

    let mut film = Sway {
        water: vec![water.clone()],
        balance: vec![walk.balance()],
        moduli: vec![moduli.clone()],
        poses: vec![pose],
        steps,
        step,
        largest_gap: 0.0,
        water_time: Duration::ZERO,
        rods_time: Duration::ZERO,
    };
    for done in 1..=count {
        let start = Instant::now();
        water = walk.to(lapse * done as f64)?;
        moduli = options.elasticity.moduli(&water, &full)?;
        film.water_time += start.elapsed();
        let start = Instant::now();
        rods.set_state(&moduli, &water)?;
        motion.set_rods(&rods)?;
        if let Some(gusts) = &mut gusts {
            motion.set_wind(gusts.after(step))?;
        }
        motion.step()?;
        film.rods_time += start.elapsed();
        film.largest_gap = film.largest_gap.max(motion.largest_gap());
        if done % steps == 0 {
            film.water.push(water);
            film.balance.push(walk.balance());
            film.moduli.push(moduli);
            film.poses.push(motion.pose());
        }
        options.progress.report(done as f64 / count as f64)?;
    }
    Ok(film)
}
