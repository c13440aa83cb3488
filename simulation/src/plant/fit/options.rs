use super::super::Plant;
use super::super::elasticity::Elasticity;
use super::super::rods::RodOptions;
use super::super::tissue::Tissue;
use super::super::water::{WaterOptions, grams_per_hour};
use catamaran::base::{Error, Par, Progress, Result, options};

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

options! {
    /// Options of [`fit`](super::fit()).
    #[derive(Debug, Clone)]
    pub struct FitOptions<'a> {
        /// Bounds of the loss delta.
        loss: [f64; 2] = [grams_per_hour(0.1), grams_per_hour(5000.0)],
            unit "kg / (s m^2)", range "positive and ascend";
        /// Bounds of the scale chi of the conductance.
        scale: [f64; 2] = [1e-13, 1e-4], range "positive and ascend";
        /// Bounds of the steepness kappa.
        steepness: [f64; 2] = [0.5, 100.0], range "positive and ascend";
        /// The other constants of the water.
        water: WaterOptions = WaterOptions::new();
        /// The other constants of the stiffness, [`Elasticity::Relative`], and the start value of
        /// the steepness. Each class has its own steepness.
        elasticity: Tissue = Tissue::default(), setter into;
        /// The options of the rods that the heights are computed with.
        rods: RodOptions = RodOptions::new();
        /// Whether there were nights ([`Interval::day_and_night`](super::super::Interval)).
        nights: bool = false;
        /// Threads. Their number does not change the result.
        par: Par = Par::all();
        /// Callback for progress, which may cancel.
        progress: Progress<'a> = Progress::none(), setter into;
    }
}

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
