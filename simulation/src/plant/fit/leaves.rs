//! Leaves that dry on a scale: conductances, and the closing of stomata.

use std::f64::consts::PI;

use super::super::water::{CurveOptions, Stomata, WaterModel, WaterOptions, water_curve};
use super::super::{Plant, Segment};
use super::found::{Estimate, logarithmic};
use super::levenberg::{Minimum, minimize};
use super::minima::from_starts;
use catamaran::base::{Error, Par, Progress, Result, options, positive};

/// The mass of a mole of water, in kg.
const MOLE: f64 = 18.015_28e-3;

/// The unit of closing points, so that parameters are of order 1, and the least one.
const CLOSING: f64 = 0.1;
const LEAST_CLOSING: f64 = 1e-3;

/// The unit of the weight at first, as a part of the water of full cells.
const START: f64 = 0.01;

/// Parameters that all leaves share, and those of each leaf.
const SHARED: usize = 2;
const OWN: usize = 3;

/// A model is a misfit if weights differ from it by more than this multiple of the error of the
/// scale.
const MISFIT: f64 = 3.0;

/// A leaf that was cut and dries on a scale.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct DryingLeaf {
    /// Its name, for messages.
    pub name: String,
    /// The demand of the air up to each weighing, in seconds, ascending from 0
    /// ([`air_demand`](super::air_demand)).
    pub demand: Vec<f64>,
    /// Its weights, in kg.
    pub weights: Vec<f64>,
    /// Its weight without water, in kg.
    pub dry: f64,
    /// Its weight with full cells, in kg.
    pub saturated: f64,
    /// The area of one of its sides, in m^2, which conductances refer to.
    pub area: f64,
}

impl DryingLeaf {
    /// Returns the water of full cells, in kg.
    fn full(&self) -> f64 {
        self.saturated - self.dry
    }

    fn check(&self) -> Result<()> {
        let refused = |why: String| {
            Err(Error::Argument { what: "leaf", why: format!("{}: {why}", self.name) })
        };
        let Self { demand, weights, dry, saturated, area, .. } = self;
        Error::check_shape("demand", (weights.len(), 1), (demand.len(), 1))?;
        if weights.len() < 2 {
            return refused(format!("must have at least 2 weights, has {}", weights.len()));
        }
        if !(*area > 0.0 && area.is_finite()) {
            return refused(format!("its area must be positive and finite, is {area} m^2"));
        }
        if !(*dry >= 0.0 && dry < saturated && saturated.is_finite()) {
            let range = "must be at least 0 and below its saturated weight";
            return refused(format!("its dry weight {range}, {saturated} kg; is {dry} kg"));
        }
        for (i, weight) in weights.iter().enumerate() {
            if !(weight > dry && weight.is_finite()) {
                let range = format!("must be above its dry weight, {dry} kg");
                return refused(format!("weight {i} {range}; is {weight} kg"));
            }
        }
        for (i, now) in demand.iter().enumerate() {
            let before = if i == 0 { 0.0 } else { demand[i - 1] };
            let ascends = *now >= before && now.is_finite() && (i > 0 || *now == 0.0);
            if !ascends {
                return refused(format!("the demand must ascend from 0; number {i} is {now} s"));
            }
        }
        Ok(())
    }
}

options! {
    /// Options of [`fit_leaves`]. Conductances are in mol / (m^2 s), for a difference of vapour as
    /// a mole fraction, of one side of a leaf.
    #[derive(Debug, Clone)]
    pub struct LeafOptions<'a> {
        /// Bounds of the conductance of full leaves with open stomata.
        open: [f64; 2] = [1e-4, 10.0], unit "mol / (m^2 s)", range "positive and ascend";
        /// Bounds of the conductance of the cuticle.
        cuticular: [f64; 2] = [1e-6, 0.1], unit "mol / (m^2 s)", range "positive and ascend";
        /// Bounds of the steepness of [`Stomata`].
        steepness: [f64; 2] = [1.0, 300.0], range "positive and ascend";
        /// Bounds of the relative water content at which stomata are half closed.
        closing: [f64; 2] = [0.3, 1.2], range "positive and ascend";
        /// What other measurements say about closing points, such as the mean and the standard
        /// deviation of turgor loss points ([`turgor_loss_point`](super::turgor_loss_point)).
        prior: Option<Estimate> = None;
        /// The error of a weight.
        instrument: f64 = 1e-7, unit "kg", check(positive);
        /// Callback for progress, which may cancel.
        progress: Progress<'a> = Progress::none(), setter into;
    }
}

impl LeafOptions<'_> {
    fn check(&self) -> Result<()> {
        self.check_ranges()?;
        let bounds = [
            ("open", self.open),
            ("cuticular", self.cuticular),
            ("steepness", self.steepness),
            ("closing", self.closing),
        ];
        for (what, [low, high]) in bounds {
            if !(low > 0.0 && low < high && high.is_finite()) {
                let why = format!("bounds must be positive and ascend, are {low} and {high}");
                return Err(Error::Argument { what, why });
            }
        }
        if let Some(Estimate { value, error }) = self.prior {
            positive("prior of closing points", value)?;
            positive("standard deviation of the prior of closing points", error)?;
        }
        Ok(())
    }

    /// Returns the bounds of the parameters of `leaves` leaves.
    fn bounds(&self, leaves: usize) -> Vec<[f64; 2]> {
        let unbounded = [f64::NEG_INFINITY, f64::INFINITY];
        let own = [self.open.map(f64::ln), self.closing.map(|w| w / CLOSING), unbounded];
        let shared = [self.cuticular, self.steepness].map(|bounds| bounds.map(f64::ln));
        shared.into_iter().chain((0..leaves).flat_map(|_| own)).collect()
    }
}

/// The constants of a leaf.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct FittedLeaf {
    /// The conductance of the full leaf with open stomata, in mol / (m^2 s).
    pub open: Estimate,
    /// The relative water content at which its stomata are half closed.
    pub closing: Estimate,
    /// The weights of the model, in kg.
    pub weights: Vec<f64>,
    /// The root of the mean square of the differences from the weights, in kg.
    pub rms: f64,
}

/// The result of [`fit_leaves`].
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct LeavesFit {
    /// The conductance of the cuticle of full leaves, in mol / (m^2 s).
    pub cuticular: Estimate,
    /// The steepness of the closing.
    pub steepness: Estimate,
    /// The constants of each leaf.
    pub leaves: Vec<FittedLeaf>,
    /// The root of the mean square of the differences of all weights, in kg.
    pub rms: f64,
    /// What speaks against the fit, a sentence each: differences that exceed the error of the
    /// scale, and constants at a bound or not determined.
    pub warnings: Vec<String>,
}

/// Parameters in the order of descents: ln cuticular, ln steepness, and for each leaf ln open, the
/// closing point and the change of the weight at first.
struct Drying<'a> {
    leaves: &'a [DryingLeaf],
    /// The scale of weights, in kg.
    unit: f64,
    /// What is known about ln open and the closing point of each leaf.
    priors: [Option<Estimate>; 2],
}

impl Drying<'_> {
    /// Computes the weights of a leaf; `x` has the shared parameters and its own.
    fn weights(leaf: &DryingLeaf, shared: &[f64], own: &[f64]) -> Result<Vec<f64>> {
        /// The length of the segment that holds the water of the leaf, in metres; only its volume
        /// matters.
        const LENGTH: f64 = 0.1;
        let [cuticular, steepness, open] = [shared[0], shared[1], own[0]].map(f64::exp);
        let options = WaterOptions::new().loss(open * MOLE);
        let radius = (leaf.full() / (options.density * PI * LENGTH)).sqrt();
        let vein = Segment::vein([0.0, 0.0, LENGTH], radius);
        let vein = Segment { leaf_area: Some(leaf.area), ..vein };
        let model = WaterModel::new(&Plant::new(vec![vein], &[None], Some([0.0; 3]))?, &options)?;
        let stomata = Stomata::new()
            // A step of the fit may leave the range.
            .half((CLOSING * own[1]).clamp(LEAST_CLOSING, 1.0))
            .steepness(steepness)
            .cuticular((cuticular / open).min(1.0));
        let start = leaf.weights[0] - leaf.dry + START * leaf.full() * own[2];
        let options = CurveOptions::new().stomata(Some(stomata)).par(Par::Seq);
        let curve = water_curve(&model, &[start], &leaf.demand, &options)?;
        Ok(curve.iter().map(|water| leaf.dry + water[0]).collect())
    }

    fn residuals(&self, shared: &[f64], x: &[f64]) -> Result<Vec<f64>> {
        let mut residuals = Vec::new();
        for (leaf, own) in self.leaves.iter().zip(x.chunks(OWN)) {
            let weights = Self::weights(leaf, shared, own)?;
            residuals.extend(weights.iter().zip(&leaf.weights).map(|(a, b)| (a - b) / self.unit));
            for (prior, value) in self.priors.iter().zip([own[0], CLOSING * own[1]]) {
                residuals.extend(prior.map(|prior| (value - prior.value) / prior.error));
            }
        }
        Ok(residuals)
    }

    /// Returns the constants of a leaf from the minimum, whose parameters of the leaf begin at
    /// `at`.
    fn found(
        leaf: &DryingLeaf,
        shared: &[f64],
        minimum: &Minimum,
        at: usize,
    ) -> Result<FittedLeaf> {
        let weights = Self::weights(leaf, shared, &minimum.parameters[at..at + OWN])?;
        let closing = Estimate {
            value: CLOSING * minimum.parameters[at + 1],
            error: CLOSING * minimum.errors[at + 1],
        };
        let rms = rms(&[(leaf, &weights[..])]);
        Ok(FittedLeaf { open: logarithmic(minimum, at), closing, weights, rms })
    }
}

/// Returns the root of the mean square of the differences of all weights.
fn rms(leaves: &[(&DryingLeaf, &[f64])]) -> f64 {
    let (mut sum, mut count) = (0.0, 0);
    for (leaf, weights) in leaves {
        sum += leaf.weights.iter().zip(*weights).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
        count += weights.len();
    }
    (sum / count as f64).sqrt()
}

/// Returns start values of the parameters of a leaf: the largest conductance between two weighings,
/// and the relative water content at which it has halved.
fn start(leaf: &DryingLeaf, options: &LeafOptions<'_>) -> [f64; OWN] {
    let mut rates = Vec::new();
    for i in 1..leaf.weights.len() {
        let demand = leaf.demand[i] - leaf.demand[i - 1];
        let water = 0.5 * (leaf.weights[i] + leaf.weights[i - 1]) - leaf.dry;
        if demand > 0.0 {
            let lost = leaf.weights[i - 1] - leaf.weights[i];
            rates.push((lost / (MOLE * leaf.area * demand), water / leaf.full()));
        }
    }
    let (mut open, mut closing) = (options.open[0], 1.0);
    for &(rate, water) in &rates {
        if rate > open {
            (open, closing) = (rate, water);
        } else if rate > 0.5 * open {
            closing = water;
        }
    }
    [open.ln(), closing / CLOSING, 0.0]
}

/// Fits conductances and the closing of stomata ([`Stomata`]) to leaves of one kind that dry on a
/// scale, by nonlinear least squares with bounds. A leaf of relative water content w loses
///
/// `A D ((g - c) f(w) + c) w`
///
/// moles of water per second, with its area A and the deficit D of the air ([`Air`](super::Air)).
/// All leaves share the conductance c of the cuticle and the steepness of f. Each leaf has its own
/// conductance g of open stomata, closing point and weight at first, because leaves of one plant
/// differ in these by factors that their area and weight do not tell. A prior keeps closing points
/// near what other measurements say; its weight follows from the deviation of a first fit without
/// it. Standard errors are those of the linearized model.
///
/// ```
/// use catamaran_simulation::plant::{Air, DryingLeaf, LeafOptions, air_demand, fit_leaves};
///
/// let seconds = [0.0, 1.0, 2.0, 3.0, 5.0, 9.0].map(|hour| 3600.0 * hour);
/// let air = [0.0, 1e5].map(|seconds| Air { seconds, celsius: 25.0, humidity: 0.45 });
/// let leaf = DryingLeaf {
///     name: "1".into(),
///     demand: air_demand(&air, &seconds)?,
///     weights: [6.336e-3, 5.7e-3, 5.4e-3, 5.305e-3, 5.22e-3, 5.12e-3].into(),
///     dry: 0.529e-3,
///     saturated: 6.336e-3,
///     area: 1.23e-2,
/// };
/// let found = fit_leaves(&[leaf], &LeafOptions::new().instrument(1e-5))?;
/// assert!(found.leaves[0].open.value > found.cuticular.value);
/// assert!(found.rms < 5e-5);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Argument`] names the leaf and what is wrong with it: a dry weight that is not below
/// every other weight, an area that is not positive, too few weights; or an option out of its
/// range. [`Error::Shape`], [`Error::NotConverged`], [`Error::Cancelled`].
pub fn fit_leaves(leaves: &[DryingLeaf], options: &LeafOptions<'_>) -> Result<LeavesFit> {
    /// Start values of the steepness, from which the descents begin.
    const STEEPNESSES: [f64; 3] = [10.0, 25.0, 60.0];
    /// The share of the progress that the fit without a prior takes.
    const FIRST: f64 = 0.8;
    /// The conductance of the cuticle at first, as a part of that of open stomata.
    const CUTICLE: f64 = 0.05;
    options.check()?;
    if leaves.is_empty() {
        let why = "must be at least one".into();
        return Err(Error::Argument { what: "leaves", why });
    }
    leaves.iter().try_for_each(DryingLeaf::check)?;
    let bounds = options.bounds(leaves.len());
    let own: Vec<f64> = leaves.iter().flat_map(|leaf| start(leaf, options)).collect();
    let least = leaves.iter().map(|leaf| start(leaf, options)[0]).fold(f64::INFINITY, f64::min);
    let starts = STEEPNESSES.iter().map(|steepness| {
        let mut x = vec![least + CUTICLE.ln(), steepness.ln()];
        x.extend(&own);
        Ok(x)
    });
    let mut drying = Drying { leaves, unit: options.instrument, priors: [None; 2] };
    let residuals = |x: &[f64]| drying.residuals(&x[..SHARED], &x[SHARED..]);
    let minima = from_starts(starts, &residuals, &bounds, options.progress.part(0.0..FIRST))?;
    let mut best = minima
        .into_iter()
        .min_by(|a, b| a.sum.total_cmp(&b.sum))
        .ok_or(Error::NotConverged { iterations: 0, residual: f64::NAN })?;
    if options.prior.is_some() {
        drying.unit *= best.deviation.max(1.0);
        drying.priors[1] = options.prior;
        let residuals = |x: &[f64]| drying.residuals(&x[..SHARED], &x[SHARED..]);
        let progress = options.progress.part(FIRST..1.0);
        best = minimize(&residuals, &best.parameters, &bounds, progress)?;
    }
    let (shared, _) = best.parameters.split_at(SHARED);
    let found = leaves.iter().enumerate().map(|(i, leaf)| {
        let at = SHARED + OWN * i;
        Drying::found(leaf, shared, &best, at)
    });
    let found = found.collect::<Result<Vec<FittedLeaf>>>()?;
    let pairs: Vec<(&DryingLeaf, &[f64])> =
        leaves.iter().zip(&found).map(|(leaf, found)| (leaf, &found.weights[..])).collect();
    let mut fit = LeavesFit {
        cuticular: logarithmic(&best, 0),
        steepness: logarithmic(&best, 1),
        rms: rms(&pairs),
        leaves: found,
        warnings: vec![],
    };
    fit.warnings = warnings(&fit, leaves, options);
    options.progress.report(1.0)?;
    Ok(fit)
}

fn warnings(fit: &LeavesFit, leaves: &[DryingLeaf], options: &LeafOptions<'_>) -> Vec<String> {
    let mut warnings = Vec::new();
    let times = fit.rms / options.instrument;
    if times > MISFIT {
        warnings.push(format!(
            "weights differ from the model by {:.2e} g, {times:.1} times the error of the scale: \
             the model is not all that happened, and standard errors are too small",
            1e3 * fit.rms
        ));
    }
    let shared = [
        ("cuticular conductance".to_string(), fit.cuticular),
        ("steepness".to_string(), fit.steepness),
    ];
    let own = leaves.iter().zip(&fit.leaves).flat_map(|(leaf, found)| {
        [
            (format!("open conductance of leaf {}", leaf.name), found.open),
            (format!("closing point of leaf {}", leaf.name), found.closing),
        ]
    });
    for (name, Estimate { value, error }) in shared.into_iter().chain(own) {
        if error.is_nan() {
            warnings.push(format!("the {name} is at its bound, {value:.3e}"));
        } else if error.is_infinite() {
            warnings.push(format!("the weights do not determine the {name}"));
        }
    }
    warnings
}

impl LeavesFit {
    /// Returns what the fitted leaves say about the open conductance (its logarithm) and the
    /// closing point of another leaf: the mean and the standard deviation.
    fn population(&self) -> Result<[Estimate; 2]> {
        /// The smallest standard deviation.
        const LEAST: f64 = 1e-3;
        if self.leaves.len() < 2 {
            let why = "another leaf needs at least 2 fitted ones".into();
            return Err(Error::Argument { what: "leaves", why });
        }
        let of = |value: &dyn Fn(&FittedLeaf) -> f64| {
            let count = self.leaves.len() as f64;
            let mean = self.leaves.iter().map(value).sum::<f64>() / count;
            let squares = self.leaves.iter().map(|leaf| (value(leaf) - mean).powi(2)).sum::<f64>();
            Estimate { value: mean, error: (squares / (count - 1.0)).sqrt().max(LEAST) }
        };
        Ok([
            of(&|leaf: &FittedLeaf| leaf.open.value.ln()),
            of(&|leaf: &FittedLeaf| leaf.closing.value),
        ])
    }

    /// Computes the drying of a leaf that was not fitted, with the shared constants, and its own
    /// constants from its first `used` weights and the scatter of those of the fitted leaves. With
    /// fewer than 2 weights its constants are the means of those.
    ///
    /// # Errors
    /// As those of [`fit_leaves`]; [`Error::Argument`] if fewer than two leaves were fitted.
    pub fn unseen(
        &self,
        leaf: &DryingLeaf,
        used: usize,
        options: &LeafOptions<'_>,
    ) -> Result<FittedLeaf> {
        options.check()?;
        leaf.check()?;
        let [open, closing] = self.population()?;
        let shared = [self.cuticular.value.ln(), self.steepness.value.ln()];
        let mean = [open.value, closing.value / CLOSING, 0.0];
        if used < 2 {
            let weights = Drying::weights(leaf, &shared, &mean)?;
            let rms = rms(&[(leaf, &weights[..])]);
            let value = open.value.exp();
            let open = Estimate { value, error: value * open.error };
            return Ok(FittedLeaf { open, closing, weights, rms });
        }
        let used = used.min(leaf.weights.len());
        let first = DryingLeaf {
            demand: leaf.demand[..used].to_vec(),
            weights: leaf.weights[..used].to_vec(),
            ..leaf.clone()
        };
        let drying = Drying {
            leaves: &[first],
            unit: self.rms.max(options.instrument),
            priors: [Some(open), Some(closing)],
        };
        let bounds = options.bounds(1);
        let residuals = |x: &[f64]| drying.residuals(&shared, x);
        let found = minimize(&residuals, &mean, &bounds[SHARED..], options.progress)?;
        Drying::found(leaf, &shared, &found, 0)
    }
}
