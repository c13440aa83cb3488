use super::super::Plant;
use super::super::water::{Conductivity, CurveOptions, Interval, WaterModel, water_curve};
use super::levenberg::Minimum;
use super::minima::from_starts;
use super::options::{FitOptions, Measurements};
use catamaran::base::{Error, Progress, Result};

/// Weights as a function of ln delta, ln chi, and the weight at time 0.
pub(super) struct Weighing<'a> {
    plant: &'a Plant,
    measured: &'a Measurements,
    options: &'a FitOptions<'a>,
    /// The unit of weights: the difference between the largest and the smallest, in kg.
    pub span: f64,
}

impl<'a> Weighing<'a> {
    /// Creates the problem of fitting the weights. Constant weights, and plants that lose nothing,
    /// are errors.
    pub fn new(
        plant: &'a Plant,
        measured: &'a Measurements,
        options: &'a FitOptions<'a>,
    ) -> Result<Self> {
        let heaviest = measured.weights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let lightest = measured.weights.iter().copied().fold(f64::INFINITY, f64::min);
        let span = heaviest - lightest;
        if span <= 0.0 {
            let why = "must not all be equal: the plant lost no water".into();
            return Err(Error::Argument { what: "weights", why });
        }
        let area: f64 = (0..plant.len()).map(|v| plant.leaf_area(v)).sum();
        if area <= 0.0 {
            let why = "has no leaves, so that it loses no water".into();
            return Err(Error::Argument { what: "plant", why });
        }
        Ok(Self { plant, measured, options, span })
    }

    /// Returns the minima that descents from several values of chi reach.
    pub fn minima(&self, progress: Progress<'_>) -> Result<Vec<Minimum>> {
        /// Number of start values of chi; far from the right one, weights hardly depend on it.
        const STARTS: usize = 12;
        let Self { measured, options, span, .. } = *self;
        let area: f64 = (0..self.plant.len()).map(|v| self.plant.leaf_area(v)).sum();
        let seconds = measured.seconds[measured.seconds.len() - 1];
        let [low, high] = options.scale.map(f64::ln);
        let unbounded = [f64::NEG_INFINITY, f64::INFINITY];
        let bounds = [options.loss.map(f64::ln), [low, high], unbounded];
        // Estimated as if the loss were constant; it is larger in the beginning.
        let mean = span / (area * seconds.max(f64::MIN_POSITIVE));
        let mean = mean.clamp(options.loss[0], options.loss[1]);
        // There are several minima: a single reservoir with a small loss resembles leaves that dry
        // before the stem.
        let starts = (0..STARTS).map(|i| {
            let scale = low + (high - low) * (i as f64 + 0.5) / STARTS as f64;
            let mut start = (f64::INFINITY, [0.0; 3]);
            for factor in [1.0, 1.5, 2.5, 5.0, 10.0] {
                let x = [(factor * mean).ln(), scale, 0.0];
                let sum = self.residuals(&x)?.iter().map(|r| r * r).sum();
                if sum < start.0 {
                    start = (sum, x);
                }
            }
            Ok(start.1)
        });
        from_starts(starts, &|x| self.residuals(x), &bounds, progress)
    }

    /// Creates the model with this loss and scale of the conductance.
    pub fn model(&self, loss: f64, scale: f64) -> Result<WaterModel> {
        let conductivity = Conductivity::Pipe { scale };
        WaterModel::new(self.plant, &self.options.water.loss(loss).conductivity(conductivity))
    }

    /// Computes the water at the times of the measurements.
    pub fn curve(&self, model: &WaterModel, loss: f64) -> Result<Vec<Vec<f64>>> {
        let cycle = if self.options.nights { Interval::day_and_night(loss) } else { vec![] };
        let options = CurveOptions::new().cycle(cycle).par(self.options.par);
        water_curve(model, &model.full(), &self.measured.seconds, &options)
    }

    /// Returns the weight at time 0.
    pub fn weight(&self, x: &[f64]) -> f64 {
        self.measured.weights[0] + self.span * x[2]
    }

    /// Computes the weights at the times of the measurements.
    pub fn weights(&self, x: &[f64]) -> Result<Vec<f64>> {
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
