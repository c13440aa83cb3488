//! Fits the constants of a plant to measurements (thesis, sections 4.5.1 and 4.5.2).

mod air;
mod bending;
mod found;
mod leaves;
mod levenberg;
mod minima;
mod options;
mod pressure;
mod weighing;

pub use self::air::{Air, air_demand};
use self::bending::Bending;
use self::found::logarithmic;
pub use self::found::{Estimate, Fit, OtherSteepness, OtherWater};
pub use self::leaves::{DryingLeaf, FittedLeaf, LeafOptions, LeavesFit, fit_leaves};
use self::levenberg::Minimum;
use self::minima::told_apart;
pub use self::options::{FitOptions, Mark, Measurements};
pub use self::pressure::turgor_loss_point;
use self::weighing::Weighing;
use super::Plant;
#[cfg(doc)]
use super::{Conductivity, Tissue};
use catamaran::base::{Error, Result};

/// Share of the progress that the water takes if there are heights, too.
const WATER_SHARE: f64 = 0.3;

/// Finds the constants of a plant from measurements, by nonlinear least squares with bounds. From
/// weights: the loss delta, the scale chi of the conductance and the weight at time 0. Weights do
/// not depend on the stiffness. Its steepness kappa, one for each class of the [`Tissue`], is
/// fitted to the heights, if there are any, with delta and chi fixed. Standard errors are those of
/// the linearized model, `s^2 (J^T J)^-1`.
///
/// Standard errors apply to one minimum. Descents begin at several points; other minima that the
/// measurements do not distinguish from the best one (by a likelihood ratio at 95 %) are in
/// [`Fit::other_water`] and [`Fit::other_steepness`].
///
/// The initial rate of the loss of weight determines delta, and the time after which it slows down
/// determines chi; delta, chi and kappa are fitted by their logarithms.
///
/// ```
/// use catamaran_simulation::plant::families::{GrowthOptions, grow};
/// use catamaran_simulation::plant::{CurveOptions, FitOptions, Measurements, WaterModel, WaterOptions};
/// use catamaran_simulation::plant::{fit, grams_per_hour, water_curve};
///
/// // A plant in a pot of 200 g, which loses 90 g / (h m^2).
/// let plant = grow(&GrowthOptions::new().nodes(60))?;
/// let model = WaterModel::new(&plant, &WaterOptions::new().loss(grams_per_hour(90.0)))?;
/// let seconds: Vec<f64> = (0..20).map(|i| 7200.0 * f64::from(i)).collect();
/// let curve = water_curve(&model, &model.full(), &seconds, &CurveOptions::new())?;
/// let weights = curve.iter().map(|water| 0.2 + water.iter().sum::<f64>()).collect();
/// let measured = Measurements { seconds, weights, ..Measurements::default() };
///
/// let found = fit(&plant, &measured, &FitOptions::new())?;
/// assert!((found.loss.value / grams_per_hour(90.0) - 1.0).abs() < 1e-6);
/// assert!((found.scale.value / 1e-9 - 1.0).abs() < 1e-5);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Argument`], [`Error::Shape`] and [`Error::NonFinite`] name the argument at fault, such
/// as fewer than four measurements; [`Error::NotConverged`], [`Error::OutOfMemory`],
/// [`Error::Cancelled`].
pub fn fit(plant: &Plant, measured: &Measurements, options: &FitOptions<'_>) -> Result<Fit> {
    options::check(plant, measured, options)?;
    let whole = if measured.has_heights() { WATER_SHARE } else { 1.0 };
    let weighing = Weighing::new(plant, measured, options)?;
    let minima = weighing.minima(options.progress.part(0.0..whole))?;
    // The weight at time 0 does not distinguish minima.
    let (water, others) = told_apart(minima, measured.seconds.len(), 2).ok_or_else(no_minimum)?;
    let [loss, scale] = [0, 1].map(|i| logarithmic(&water, i));
    let other = |minimum: &Minimum| OtherWater {
        loss: minimum.parameters[0].exp(),
        scale: minimum.parameters[1].exp(),
        weight: weighing.weight(&minimum.parameters),
        deviation: weighing.span * minimum.deviation,
    };
    let mut found = Fit {
        loss,
        scale,
        weight: Estimate {
            value: weighing.weight(&water.parameters),
            error: weighing.span * water.errors[2],
        },
        steepness: vec![],
        other_water: others.iter().map(other).collect(),
        other_steepness: vec![],
        weights: weighing.weights(&water.parameters)?,
        heights: vec![],
        marks: vec![],
        weight_deviation: weighing.span * water.deviation,
        height_deviation: 0.0,
    };
    if measured.has_heights() {
        let model = weighing.model(loss.value, scale.value)?;
        let curve = weighing.curve(&model, loss.value)?;
        let bending = Bending { plant, measured, curve: &curve, full: model.full(), options };
        let minima = bending.minima(options.progress.part(whole..1.0))?;
        let classes = options.elasticity.classes().len();
        let (best, others) = told_apart(minima, bending.count(), classes).ok_or_else(no_minimum)?;
        found.steepness = (0..classes).map(|i| logarithmic(&best, i)).collect();
        let values: Vec<f64> = found.steepness.iter().map(|kappa| kappa.value).collect();
        (found.heights, found.marks) = bending.heights(&values)?;
        found.height_deviation = best.deviation;
        let other = |minimum: &Minimum| OtherSteepness {
            steepness: minimum.parameters.iter().map(|x| x.exp()).collect(),
            deviation: minimum.deviation,
        };
        found.other_steepness = others.iter().map(other).collect();
    }
    options.progress.report(1.0)?;
    Ok(found)
}

fn no_minimum() -> Error {
    Error::NotConverged { iterations: 0, residual: f64::NAN }
}
