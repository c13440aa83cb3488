use super::levenberg::Minimum;

/// The estimate of a constant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// Its value.
    pub value: f64,
    /// Its standard error; infinite where the measurements do not determine the value, NaN at a
    /// bound.
    pub error: f64,
}

/// The result of [`fit`](super::fit()).
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Fit {
    /// The loss delta, in kg / (s m^2).
    pub loss: Estimate,
    /// The scale chi of [`Conductivity::Pipe`](super::super::Conductivity::Pipe).
    pub scale: Estimate,
    /// The weight at time 0, in kg.
    pub weight: Estimate,
    /// The steepness kappa of each class of the [`Tissue`](super::super::Tissue), if heights were
    /// measured.
    pub steepness: Vec<Estimate>,
    /// Other minima that fit the weights equally well, the best one first.
    pub other_water: Vec<OtherWater>,
    /// Other minima that fit the heights equally well, the best one first.
    pub other_steepness: Vec<OtherSteepness>,
    /// The weights of the model, in kg.
    pub weights: Vec<f64>,
    /// The heights of the model, in metres, if they were measured.
    pub heights: Vec<f64>,
    /// The heights of each mark in the model, in metres.
    pub marks: Vec<Vec<f64>>,
    /// The standard deviation of a weight from the model, in kg.
    pub weight_deviation: f64,
    /// The standard deviation of a height from the model, in metres; 0 without heights.
    pub height_deviation: f64,
}

/// Constants of the water that fit the weights as well as those of a [`Fit`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct OtherWater {
    /// The loss delta, in kg / (s m^2).
    pub loss: f64,
    /// The scale chi.
    pub scale: f64,
    /// The weight at time 0, in kg.
    pub weight: f64,
    /// The standard deviation of a weight from the model, in kg.
    pub deviation: f64,
}

/// Steepnesses that fit the heights as well as those of a [`Fit`].
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct OtherSteepness {
    /// The steepness kappa of each class.
    pub steepness: Vec<f64>,
    /// The standard deviation of a height from the model, in metres.
    pub deviation: f64,
}

/// Returns the estimate of a constant that was fitted by its logarithm.
pub(super) fn logarithmic(minimum: &Minimum, i: usize) -> Estimate {
    let value = minimum.parameters[i].exp();
    Estimate { value, error: value * minimum.errors[i] }
}
