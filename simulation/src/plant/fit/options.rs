use super::super::Plant;
use super::super::elasticity::Elasticity;
use super::super::rods::RodOptions;
use super::super::tissue::Tissue;
use super::super::water::{WaterOptions, grams_per_hour};
use catamaran::base::{Error, Par, Progress, Result, builder};

/// The measurements of a plant that dries, beginning with full cells.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Measurements {
    /// Times, in seconds, ascending from 0.
    pub seconds: Vec<f64>,
    /// Weights of the plant, in kg; with its pot, if the pot does not lose weight.
    pub weights: Vec<f64>,
    /// Heights of the highest point above the base, in metres; empty if not measured.
    pub heights: Vec<f64>,
    /// Heights of some nodes: marks on leaves and stem, which distinguish classes of segments.
    pub marks: Vec<Mark>,
}

/// A node whose height was measured.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Mark {
    /// The node.
    pub node: usize,
    /// Heights of its tail above the base at each of the times, in metres.
    pub heights: Vec<f64>,
}

impl Measurements {
    /// Returns whether there are heights, which depend on the stiffness.
    pub(super) fn has_heights(&self) -> bool {
        !self.heights.is_empty() || !self.marks.is_empty()
    }
}

/// Options of [`fit`](super::fit()).
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct FitOptions<'a> {
    /// Bounds of the loss delta, in kg / (s m^2). Default 0.1 to 5000 g / (h m^2).
    pub loss: [f64; 2],
    /// Bounds of the scale chi of the conductance. Default 1e-13 to 1e-4.
    pub scale: [f64; 2],
    /// Bounds of the steepness kappa. Default 0.5 to 100.
    pub steepness: [f64; 2],
    /// The other constants of the water.
    pub water: WaterOptions,
    /// The other constants of the stiffness, [`Elasticity::Relative`], and the start value of the
    /// steepness. Each class has its own steepness.
    pub elasticity: Tissue,
    /// The options of the rods that the heights are computed with.
    pub rods: RodOptions,
    /// Whether there were nights ([`Interval::day_and_night`](super::super::Interval)). Default no.
    pub nights: bool,
    /// Threads; default [`Par::all`]. Does not change the result.
    pub par: Par,
    /// Callback for progress, which may cancel.
    pub progress: Progress<'a>,
}

impl Default for FitOptions<'_> {
    fn default() -> Self {
        Self {
            loss: [grams_per_hour(0.1), grams_per_hour(5000.0)],
            scale: [1e-13, 1e-4],
            steepness: [0.5, 100.0],
            water: WaterOptions::default(),
            elasticity: Tissue::default(),
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
    #[into] elasticity: Tissue,
    rods: RodOptions,
    nights: bool,
    par: Par,
    #[into] progress: Progress<'a>,
}}

/// Returns an error that names a value out of its range.
pub(super) fn check(
    plant: &Plant,
    measured: &Measurements,
    options: &FitOptions<'_>,
) -> Result<()> {
    let count = measured.seconds.len();
    Error::check_shape("weights", (count, 1), (measured.weights.len(), 1))?;
    if !measured.heights.is_empty() {
        Error::check_shape("heights", (count, 1), (measured.heights.len(), 1))?;
    }
    for Mark { node, heights } in &measured.marks {
        Error::check_shape("heights of a mark", (count, 1), (heights.len(), 1))?;
        if *node >= plant.len() {
            let why =
                format!("node {node} is out of range: {} nodes, numbered from 0", plant.len());
            return Err(Error::Argument { what: "mark", why });
        }
    }
    let marks = measured.marks.iter().map(|mark| ("heights of a mark", &mark.heights));
    let others = [("weights", &measured.weights), ("heights", &measured.heights)];
    for (what, values) in others.into_iter().chain(marks) {
        if let Some(i) = values.iter().position(|x| !x.is_finite()) {
            return Err(Error::NonFinite { what, index: (i, 0) });
        }
    }
    if count < 4 {
        let why = format!("must be at least 4, are {count}");
        return Err(Error::Argument { what: "measurements", why });
    }
    let is_literal = |e: &Elasticity| matches!(e, Elasticity::Literal { .. });
    if options.elasticity.classes().iter().any(is_literal) {
        let why = "must be Elasticity::Relative in every class".into();
        return Err(Error::Argument { what: "elasticity", why });
    }
    let bounds = [
        ("loss", options.loss),
        ("conductivity scale", options.scale),
        ("steepness", options.steepness),
    ];
    for (what, [low, high]) in bounds {
        if !(low > 0.0 && low < high && high.is_finite()) {
            let why = format!("bounds must be positive and ascend, are {low} and {high}");
            return Err(Error::Argument { what, why });
        }
    }
    Ok(())
}
