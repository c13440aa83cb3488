use std::time::{Duration, Instant};

use super::rods::{Motion, MotionOptions, Pose, Rods};
use super::tissue::Tissue;
use super::water::{
    Balance, CurveOptions, Interval, Rewatering, Soil, Stomata, Times, Walk, WaterModel,
};
use super::wilt::{check_frames, settle};
use super::wind::{Gusts, Wind};
use catamaran::base::{Error, Par, Progress, Result, options};

options! {
    /// Options of [`sway`].
    #[derive(Debug, Clone)]
    pub struct SwayOptions<'a> {
        /// Duration of the drought.
        drought: f64 = 0.0, unit "s", check(at least 0);
        /// Duration of the motion.
        seconds: f64 = 10.0, unit "s", check(positive);
        /// Number of frames after the first, at equal times.
        frames: usize = 240, check(at least 1);
        /// The law from water to stiffness, one for all segments or by classes.
        elasticity: Tissue = Tissue::default(), setter into;
        /// As [`CurveOptions::cycle`], such as [`Interval::day_and_night`].
        cycle: Vec<Interval> = Vec::new();
        /// As [`CurveOptions::stomata`].
        stomata: Option<Stomata> = None;
        /// As [`CurveOptions::soil`].
        soil: Option<Soil> = None;
        /// As [`CurveOptions::rewatering`].
        rewatering: Vec<Rewatering> = Vec::new();
        /// The options of the motion. Steps are shortened, if needed, so that frames are at
        /// multiples of them.
        motion: MotionOptions = MotionOptions::new();
        /// The wind; `None`: there is no air.
        wind: Option<Wind> = None;
        /// Threads of the water. Their number does not change the result.
        par: Par = Par::all();
        /// Callback for progress, which may cancel.
        progress: Progress<'a> = Progress::none(), setter into;
    }
}

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

/// Returns the options of the water.
fn course(options: &SwayOptions<'_>) -> CurveOptions<'static> {
    CurveOptions::new()
        .cycle(options.cycle.clone())
        .stomata(options.stomata)
        .soil(options.soil)
        .rewatering(options.rewatering.clone())
        .par(options.par)
}

/// Simulates a plant that dries, wilts and moves, as in a time-lapse film: `options.drought`
/// seconds of water pass in `options.seconds` of motion. In every step, the method of
/// [`Method::Auto`](super::Method::Auto) advances the water, the stiffness and the weight are
/// computed from it (thesis, section 4.5.4), and [`Motion`] advances the rods in the current wind.
/// The plant begins with full cells and at rest, or, between pins, in the pose of [`Rods::relax`].
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
    options.check_ranges()?;
    options.motion.check_ranges()?;
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
    let course = course(options);
    let mut walk = Walk::new(model, &full, Times::equal(lapse, count), &course)?;
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
