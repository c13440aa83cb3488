use super::rods::{Pose, RelaxOptions, Rods};
use super::tissue::Tissue;
use super::water::{
    Balance, CurveOptions, Interval, Rewatering, Soil, Stomata, WaterCourse, WaterModel,
    water_course,
};
use catamaran::base::{Error, Par, Progress, Result, check_request, options};

/// Torque out of balance, relative to the largest torque of a weight, below which the error of a
/// pose is invisible.
const SEEN: f64 = 1e-4;

/// Share of the progress that the water takes; the rest is for poses.
const WATER_SHARE: f64 = 0.2;

options! {
    /// Options of [`wilt`].
    #[derive(Debug, Clone)]
    pub struct WiltOptions<'a> {
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
        /// Threads. Their number does not change the result.
        par: Par = Par::all();
        /// Callback for progress, which may cancel.
        progress: Progress<'a> = Progress::none(), setter into;
    }
}

/// The result of [`wilt`], with an entry for each time.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Wilting {
    /// Water of every node, in kg.
    pub water: Vec<Vec<f64>>,
    /// Balance of the water of plant and soil.
    pub balance: Vec<Balance>,
    /// The modulus of elasticity of every segment, in Pa.
    pub moduli: Vec<Vec<f64>>,
    /// The pose at rest, with the weight and the stiffness at each time.
    pub poses: Vec<Pose>,
    /// The largest number of Newton iterations of a pose.
    pub iterations: usize,
}

/// Simulates how a plant wilts, from full cells at time 0: computes its water at each of `times`
/// (seconds, ascending), the resulting stiffness, and the pose at rest, which is found from the
/// previous pose.
///
/// ```
/// use catamaran_simulation::plant::families::{GrowthOptions, grow};
/// use catamaran_simulation::plant::{Interval, RodOptions, Rods, WaterModel, WaterOptions, WiltOptions};
/// use catamaran_simulation::plant::{grams_per_hour, wilt};
///
/// let plant = grow(&GrowthOptions::new().nodes(600).seed(1))?;
/// let options = WaterOptions::new().loss(grams_per_hour(100.0));
/// let model = WaterModel::new(&plant, &options)?;
/// let rods = Rods::new(&plant, &RodOptions::new())?;
/// let days: Vec<f64> = (0..=4).map(|day| 86_400.0 * f64::from(day)).collect();
/// let weather = WiltOptions::new().cycle(Interval::day_and_night(options.loss));
/// let found = wilt(&model, &rods, &days, &weather)?;
/// let height = |i: usize| found.poses[i].tails.iter().map(|tail| tail[2]).sum::<f64>();
/// assert!(height(4) < 0.8 * height(0)); // the top hangs down
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// As [`water_course`], [`Tissue::moduli`] and [`Rods::relax`], except that a pose whose error is
/// invisible is accepted: a plant that pins stretch converges slowly to balance.
pub fn wilt(
    model: &WaterModel,
    rods: &Rods,
    times: &[f64],
    options: &WiltOptions<'_>,
) -> Result<Wilting> {
    let full = model.full();
    check_frames("times", times.len(), full.len())?;
    let curve = CurveOptions::new()
        .cycle(options.cycle.clone())
        .stomata(options.stomata)
        .soil(options.soil)
        .rewatering(options.rewatering.clone())
        .par(options.par)
        .progress(options.progress.part(0.0..WATER_SHARE));
    let WaterCourse { water, balance } = water_course(model, &full, times, &curve)?;
    let mut rods = rods.clone();
    let mut pose = rods.rest_pose();
    let (mut moduli, mut poses, mut iterations) = (Vec::new(), Vec::new(), 0);
    let at = |i: usize| WATER_SHARE + (1.0 - WATER_SHARE) * i as f64 / water.len() as f64;
    for (i, water) in water.iter().enumerate() {
        let stiffness = options.elasticity.moduli(water, &full)?;
        rods.set_state(&stiffness, water)?;
        let progress = options.progress.part(at(i)..at(i + 1));
        let taken = settle(&rods, &mut pose, progress)?;
        options.progress.report(at(i + 1))?;
        iterations = iterations.max(taken);
        moduli.push(stiffness);
        poses.push(pose.clone());
    }
    Ok(Wilting { water, balance, moduli, poses, iterations })
}

/// Returns an error when so many frames of a plant need more memory than there is: water, modulus
/// and pose of each node.
pub(super) fn check_frames(what: &'static str, frames: usize, nodes: usize) -> Result<()> {
    const NODE: usize = 2 * size_of::<f64>() + size_of::<[f64; 10]>();
    let request = format_args!("{frames} frames of {nodes} nodes");
    check_request(what, request, frames as f64 * (nodes * NODE) as f64)
}

/// Applies [`Rods::relax`] until the error is invisible. Returns the number of Newton iterations.
pub(super) fn settle(rods: &Rods, pose: &mut Pose, progress: Progress<'_>) -> Result<usize> {
    match rods.relax(pose, &RelaxOptions::new().progress(progress)) {
        Ok(done) => Ok(done.iterations),
        Err(Error::NotConverged { iterations, residual }) if residual <= SEEN => Ok(iterations),
        Err(error) => Err(error),
    }
}
