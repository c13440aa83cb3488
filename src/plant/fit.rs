//! The constants of a plant from what was weighed (thesis, sections 4.5.1 and 4.5.2).

use super::Plant;
use super::curve::{CurveOptions, Interval, water_curve};
use super::elasticity::Elasticity;
use super::levenberg::{Minimum, minimize};
use super::rods::{RodOptions, Rods};
use super::water::{Conductivity, WaterModel, WaterOptions, grams_per_hour};
use super::wilt::settle;
use crate::base::{Error, Par, Progress, Result, builder};

/// A plant that dries, as it was measured from full cells on.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Measurements {
    /// When, in seconds, ascending from 0 on.
    pub seconds: Vec<f64>,
    /// What the plant weighs, in kg; with its pot, if that does not lose weight.
    pub weights: Vec<f64>,
    /// How high its highest point is above the base, in metres; empty if not measured.
    pub heights: Vec<f64>,
}

/// Options of [`fit`].
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct FitOptions<'a> {
    /// Between what the loss delta is sought, in kg / (s m^2). Default 0.1 to 5000 g / (h m^2).
    pub loss: [f64; 2],
    /// Between what the scale chi of the conductance is sought. Default 1e-13 to 1e-4.
    pub scale: [f64; 2],
    /// Between what the steepness kappa is sought. Default 0.5 to 100.
    pub steepness: [f64; 2],
    /// The other constants of the water.
    pub water: WaterOptions,
    /// The other constants of stiffness, [`Elasticity::Relative`], and the steepness to begin with.
    pub elasticity: Elasticity,
    /// Of the rods that heights follow from.
    pub rods: RodOptions,
    /// Whether there were nights ([`Interval::day_and_night`]). Default no.
    pub nights: bool,
    /// Threads; default all cores of the affinity mask. Does not change the result.
    pub par: Par,
    /// Told of progress; may cancel.
    pub progress: Progress<'a>,
}

impl Default for FitOptions<'_> {
    fn default() -> Self {
        Self {
            loss: [grams_per_hour(0.1), grams_per_hour(5000.0)],
            scale: [1e-13, 1e-4],
            steepness: [0.5, 100.0],
            water: WaterOptions::default(),
            elasticity: Elasticity::default(),
            rods: RodOptions::default(),
            nights: false,
            par: Par::all(),
            progress: Progress::none(),
        }
    }
}

builder! { FitOptions<'a> {
    loss: [f64; 2],
    scale: [f64; 2],
    steepness: [f64; 2],
    water: WaterOptions,
    elasticity: Elasticity,
    rods: RodOptions,
    nights: bool,
    par: Par,
    #[into] progress: Progress<'a>,
}}

/// A constant that was found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// Its value.
    pub value: f64,
    /// Its standard error; infinite where the measurements don't tell it, NaN where it is at a bound.
    pub error: f64,
}

/// What [`fit`] found.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Fit {
    /// delta, in kg / (s m^2).
    pub loss: Estimate,
    /// chi, of [`Conductivity::Pipe`].
    pub scale: Estimate,
    /// The weight at time 0, in kg.
    pub weight: Estimate,
    /// kappa, if heights were measured.
    pub steepness: Option<Estimate>,
    /// The weights of the model, in kg.
    pub weights: Vec<f64>,
    /// The heights of the model, in metres, if they were measured.
    pub heights: Vec<f64>,
    /// The standard deviation of a weight from the model, in kg.
    pub weight_deviation: f64,
    /// That of a height, in metres; 0 without.
    pub height_deviation: f64,
}

/// The share of the time that goes into water where there are heights too.
const WATER_SHARE: f64 = 0.3;

/// Finds the constants of a plant from measurements, by nonlinear least squares with bounds. From weights: the loss delta, the
/// scale chi of the conductance and the weight at time 0. Weights do not depend on the stiffness; its steepness kappa follows
/// from heights, if there are any, with delta and chi held where the weights have them. Standard errors are those of
/// the linearised model: `s^2 (J^T J)^-1`.
///
/// delta shows in how fast the plant first loses weight, chi in how soon that slows down; delta, chi and kappa are fitted by
/// their logarithms.
///
/// ```
/// use catamaran::plant::families::{GrowthOptions, grow};
/// use catamaran::plant::{CurveOptions, FitOptions, Measurements, WaterModel, WaterOptions};
/// use catamaran::plant::{fit, grams_per_hour, water_curve};
///
/// // A plant in a pot of 200 g that loses 90 g / (h m^2).
/// let plant = grow(&GrowthOptions::new().nodes(60))?;
/// let model = WaterModel::new(&plant, &WaterOptions::new().loss(grams_per_hour(90.0)))?;
/// let seconds: Vec<f64> = (0..20).map(|i| 7200.0 * f64::from(i)).collect();
/// let curve = water_curve(&model, &model.full(), &seconds, &CurveOptions::new())?;
/// let weights = curve.iter().map(|water| 0.2 + water.iter().sum::<f64>()).collect();
/// let measured = Measurements { seconds, weights, heights: vec![] };
///
/// let found = fit(&plant, &measured, &FitOptions::new())?;
/// assert!((found.loss.value / grams_per_hour(90.0) - 1.0).abs() < 1e-6);
/// assert!((found.scale.value / 1e-9 - 1.0).abs() < 1e-5);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Argument`], [`Error::Shape`] and [`Error::NonFinite`] name the argument at fault, also fewer than four
/// measurements; [`Error::NotConverged`], [`Error::OutOfMemory`], [`Error::Cancelled`].
pub fn fit(plant: &Plant, measured: &Measurements, options: &FitOptions<'_>) -> Result<Fit> {
    check(measured, options)?;
    let whole = if measured.heights.is_empty() { 1.0 } else { WATER_SHARE };
    let water = fit_water(plant, measured, options, options.progress.part(0.0..whole))?;
    let [loss, scale] = [0, 1].map(|i| logarithmic(&water.minimum, i));
    let model = water.problem.model(loss.value, scale.value)?;
    let curve = water.problem.curve(&model, loss.value)?;
    let mut found = Fit {
        loss,
        scale,
        weight: Estimate {
            value: water.problem.weight(&water.minimum.parameters),
            error: water.problem.span * water.minimum.errors[2],
        },
        steepness: None,
        weights: water.problem.weights(&water.minimum.parameters)?,
        heights: vec![],
        weight_deviation: water.problem.span * water.minimum.deviation,
        height_deviation: 0.0,
    };
    if !measured.heights.is_empty() {
        let progress = options.progress.part(whole..1.0);
        let stems = Stems { plant, curve: &curve, full: model.full(), options };
        let start = match options.elasticity {
            Elasticity::Relative { steepness, .. } => steepness.ln(),
            Elasticity::Literal { .. } => return Err(literal()),
        };
        let residuals = |x: &[f64]| -> Result<Vec<f64>> {
            let heights = stems.heights(x[0].exp())?;
            Ok(heights.iter().zip(&measured.heights).map(|(a, b)| a - b).collect())
        };
        let bounds = [options.steepness.map(f64::ln)];
        let minimum = minimize(&residuals, &[start], &bounds, progress)?;
        let steepness = logarithmic(&minimum, 0);
        found.heights = stems.heights(steepness.value)?;
        found.steepness = Some(steepness);
        found.height_deviation = minimum.deviation;
    }
    options.progress.report(1.0)?;
    Ok(found)
}

fn literal() -> Error {
    let why = "literal, where a function of the relative water content is fitted".into();
    Error::Argument { what: "elasticity", why }
}

/// A constant that was fitted by its logarithm.
fn logarithmic(minimum: &Minimum, i: usize) -> Estimate {
    let value = minimum.parameters[i].exp();
    Estimate { value, error: value * minimum.errors[i] }
}

fn check(measured: &Measurements, options: &FitOptions<'_>) -> Result<()> {
    let count = measured.seconds.len();
    Error::check_shape("weights", (count, 1), (measured.weights.len(), 1))?;
    if !measured.heights.is_empty() {
        Error::check_shape("heights", (count, 1), (measured.heights.len(), 1))?;
    }
    for (what, values) in [("weights", &measured.weights), ("heights", &measured.heights)] {
        if let Some(i) = values.iter().position(|x| !x.is_finite()) {
            return Err(Error::NonFinite { what, index: (i, 0) });
        }
    }
    if count < 4 {
        let why = format!("{count} of them, where at least 4 are needed");
        return Err(Error::Argument { what: "measurements", why });
    }
    let bounds = [
        ("loss", options.loss),
        ("conductivity scale", options.scale),
        ("steepness", options.steepness),
    ];
    for (what, [low, high]) in bounds {
        if !(low > 0.0 && low < high && high.is_finite()) {
            let why = format!("from {low} to {high}, where two ascending positive numbers bound");
            return Err(Error::Argument { what, why });
        }
    }
    Ok(())
}

/// Weights as a function of ln delta, ln chi, and of the weight at time 0.
struct Weighing<'a> {
    plant: &'a Plant,
    measured: &'a Measurements,
    options: &'a FitOptions<'a>,
    /// The unit of weights: the difference of the largest and the smallest, in kg.
    span: f64,
}

struct WaterFit<'a> {
    problem: Weighing<'a>,
    minimum: Minimum,
}

impl Weighing<'_> {
    fn model(&self, loss: f64, scale: f64) -> Result<WaterModel> {
        let conductivity = Conductivity::Pipe { scale };
        WaterModel::new(self.plant, &self.options.water.loss(loss).conductivity(conductivity))
    }

    fn curve(&self, model: &WaterModel, loss: f64) -> Result<Vec<Vec<f64>>> {
        let cycle = if self.options.nights { Interval::day_and_night(loss) } else { vec![] };
        let options = CurveOptions::new().cycle(cycle).par(self.options.par);
        water_curve(model, &model.full(), &self.measured.seconds, &options)
    }

    /// The weight at time 0.
    fn weight(&self, x: &[f64]) -> f64 {
        self.measured.weights[0] + self.span * x[2]
    }

    fn weights(&self, x: &[f64]) -> Result<Vec<f64>> {
        let loss = x[0].exp();
        let model = self.model(loss, x[1].exp())?;
        let full: f64 = model.full().iter().sum();
        let curve = self.curve(&model, loss)?;
        let start = self.weight(x);
        Ok(curve.iter().map(|water| start - (full - water.iter().sum::<f64>())).collect())
    }

    fn residuals(&self, x: &[f64]) -> Result<Vec<f64>> {
        let weights = self.weights(x)?;
        Ok(weights.iter().zip(&self.measured.weights).map(|(a, b)| (a - b) / self.span).collect())
    }
}

fn fit_water<'a>(
    plant: &'a Plant,
    measured: &'a Measurements,
    options: &'a FitOptions<'a>,
    progress: Progress<'_>,
) -> Result<WaterFit<'a>> {
    /// Values of chi to begin with; far from the right one, weights hardly depend on it.
    const STARTS: usize = 12;
    let heaviest = measured.weights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let lightest = measured.weights.iter().copied().fold(f64::INFINITY, f64::min);
    let span = heaviest - lightest;
    if span <= 0.0 {
        let why = "all the same: nothing was lost".into();
        return Err(Error::Argument { what: "weights", why });
    }
    let area: f64 = (0..plant.len()).map(|v| plant.leaf_area(v)).sum();
    if area <= 0.0 {
        let why = "no leaves, so that nothing is lost".into();
        return Err(Error::Argument { what: "plant", why });
    }
    let problem = Weighing { plant, measured, options, span };
    let seconds = measured.seconds[measured.seconds.len() - 1];
    let [low, high] = options.scale.map(f64::ln);
    let unbounded = [f64::NEG_INFINITY, f64::INFINITY];
    let bounds = [options.loss.map(f64::ln), [low, high], unbounded];
    // As if leaves lost as much all the time; they lose more in the beginning.
    let mean =
        (span / (area * seconds.max(f64::MIN_POSITIVE))).clamp(options.loss[0], options.loss[1]);
    // There are several minima: one bucket that loses little is like leaves that dry before the stem.
    let residuals = |x: &[f64]| problem.residuals(x);
    let (mut minimum, mut failure): (Option<Minimum>, _) = (None, None);
    for i in 0..STARTS {
        let scale = low + (high - low) * (i as f64 + 0.5) / STARTS as f64;
        let mut start = (f64::INFINITY, [0.0; 3]);
        for factor in [1.0, 1.5, 2.5, 5.0, 10.0] {
            let x = [(factor * mean).ln(), scale, 0.0];
            let sum = problem.residuals(&x)?.iter().map(|r| r * r).sum();
            if sum < start.0 {
                start = (sum, x);
            }
        }
        let part = |i: usize| i as f64 / STARTS as f64;
        let found = minimize(&residuals, &start.1, &bounds, progress.part(part(i)..part(i + 1)));
        let found = match found {
            Err(error @ Error::NotConverged { .. }) => {
                failure = Some(error);
                continue;
            }
            found => found?,
        };
        if minimum.as_ref().is_none_or(|best| found.deviation < best.deviation) {
            minimum = Some(found);
        }
    }
    let failed = Error::NotConverged { iterations: 0, residual: f64::NAN };
    let minimum = minimum.ok_or(failure.unwrap_or(failed))?;
    Ok(WaterFit { problem, minimum })
}

/// Heights as a function of kappa.
struct Stems<'a> {
    plant: &'a Plant,
    curve: &'a [Vec<f64>],
    full: Vec<f64>,
    options: &'a FitOptions<'a>,
}

impl Stems<'_> {
    fn heights(&self, kappa: f64) -> Result<Vec<f64>> {
        let Elasticity::Relative { dry, full, shift, .. } = self.options.elasticity else {
            return Err(literal());
        };
        let elasticity = Elasticity::Relative { dry, full, shift, steepness: kappa };
        let mut rods = Rods::new(self.plant, &self.options.rods)?;
        let mut pose = rods.rest_pose();
        let base = self.plant.base()[2];
        let mut heights = Vec::with_capacity(self.curve.len());
        for water in self.curve {
            rods.set_state(&elasticity.moduli(water, &self.full)?, water)?;
            settle(&rods, &mut pose, Progress::none())?;
            let highest = pose.tails.iter().map(|tail| tail[2]).fold(f64::NEG_INFINITY, f64::max);
            heights.push(highest - base);
        }
        Ok(heights)
    }
}
