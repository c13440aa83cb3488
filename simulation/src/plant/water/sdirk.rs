//! The water of a plant whose stomata close, or whose soil empties: a nonlinear problem.
//!
//! SDIRK of order 4 with 5 stages (Hairer and Wanner 1996, section IV.6), L-stable and stiffly
//! accurate, with an error estimate of order 3. In every Newton iteration of a stage, the
//! linearized equations are solved for the new value, not for a change. The matrix is that of a
//! tree with a positive excess, so that the elimination needs no subtraction, and each solution
//! conserves the water.

use std::ops::Range;

use super::diffusion::WaterModel;
use super::elimination::Factor;
use super::soil::Soil;
use super::stomata::Stomata;
use catamaran::base::{Error, Par, Result, zeros};

const STAGES: usize = 5;

/// The diagonal of the method.
const GAMMA: f64 = 0.25;

/// The coefficients below the diagonal; the last row holds the weights of the solution, too.
#[rustfmt::skip]
const WEIGHTS: [[f64; STAGES - 1]; STAGES] = [
    [0.0; 4],
    [0.5, 0.0, 0.0, 0.0],
    [17.0 / 50.0, -1.0 / 25.0, 0.0, 0.0],
    [371.0 / 1360.0, -137.0 / 2720.0, 15.0 / 544.0, 0.0],
    [25.0 / 24.0, -49.0 / 48.0, 125.0 / 16.0, -85.0 / 12.0],
];

/// The difference between the solution and the embedded one of order 3.
const ERROR: [f64; STAGES] = [-3.0 / 16.0, -27.0 / 32.0, 25.0 / 32.0, 0.0, 0.25];

/// Tolerance of a step for the relative water content of any node.
const TOLERANCE: f64 = 1e-9;

/// The part of the water of a full plant below which the capacity of the soil does not tighten the
/// tolerance of a step: soil that holds next to nothing would take steps without end.
const NEGLIGIBLE: f64 = 1e-6;

/// A change of an iteration after which the next, quadratically smaller change is below rounding.
const SMALL: f64 = 1e-9;

/// Number of Newton iterations of a stage after which the step is shortened.
const ITERATIONS: usize = 12;

/// Smallest step relative to the time, below which a step is not shortened.
const SHORTEST: f64 = 1e-14;

/// The responses that make the model nonlinear.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Responses {
    pub stomata: Option<Stomata>,
    pub soil: Option<Soil>,
}

impl Responses {
    /// Returns whether there is neither soil nor stomata.
    pub fn are_none(&self) -> bool {
        self.stomata.is_none() && self.soil.is_none()
    }

    /// Returns an error that names a constant out of its range.
    pub fn check(&self) -> Result<()> {
        self.stomata.map_or(Ok(()), |stomata| stomata.check())?;
        self.soil.map_or(Ok(()), |soil| soil.check())
    }
}

/// The state of a plant and its soil.
#[derive(Debug, Clone)]
pub(super) struct Sdirk {
    model: WaterModel,
    responses: Responses,
    /// Conductance into the root, in kg / s; 0 without soil.
    conductance: f64,
    /// The content that an error of the soil is relative to, in kg.
    scale: f64,
    /// Relative water content by positions.
    present: Vec<f64>,
    /// Water of the soil, in kg.
    content: f64,
    /// Transpired water in kg, and the rounding error of its sum.
    transpired: [f64; 2],
    factor: Factor<f64>,
    /// Derivatives of the stages, by positions in 1 / s, of the soil in kg / s.
    rates: [Vec<f64>; STAGES],
    soil_rates: [f64; STAGES],
    /// The start value of a stage, its last iterate, and the next one.
    base: Vec<f64>,
    guess: Vec<f64>,
    next: Vec<f64>,
    /// Seconds of the next step; 0 before the first step.
    step: f64,
    par: Par,
}

/// The result of a step.
struct Attempt {
    /// Error relative to the tolerance.
    error: f64,
    content: f64,
    transpired: f64,
}

impl Sdirk {
    /// Creates a solver from a relative water content by positions.
    pub fn new(
        model: &WaterModel,
        responses: Responses,
        present: Vec<f64>,
        par: Par,
    ) -> Result<Self> {
        let n = model.len();
        let soil = responses.soil;
        Ok(Self {
            model: model.clone(),
            responses,
            conductance: soil.map_or(0.0, |s| s.conductance.unwrap_or(model.into_root)),
            scale: soil
                .map_or(0.0, |s| s.capacity)
                .max(NEGLIGIBLE * model.full.iter().sum::<f64>()),
            present,
            content: soil.map_or(0.0, |s| s.content),
            transpired: [0.0; 2],
            factor: Factor::new(&model.order)?,
            rates: [zeros(n)?, zeros(n)?, zeros(n)?, zeros(n)?, zeros(n)?],
            soil_rates: [0.0; STAGES],
            base: zeros(n)?,
            guess: zeros(n)?,
            next: zeros(n)?,
            step: 0.0,
            par,
        })
    }

    /// Continues with another loss.
    pub fn set_model(&mut self, model: &WaterModel) {
        self.model = model.clone();
        self.step = 0.0;
    }

    /// Returns the relative water content by positions.
    pub fn present(&self) -> &[f64] {
        &self.present
    }

    /// Returns the water of the soil, in kg.
    pub fn content(&self) -> f64 {
        self.content
    }

    /// Pours water on the soil, in kg.
    pub fn pour(&mut self, amount: f64) {
        self.content += amount;
        self.step = 0.0;
    }

    /// Returns the water that leaves have lost, in kg.
    pub fn transpired(&self) -> f64 {
        self.transpired[0] + self.transpired[1]
    }

    /// Advances by `seconds`.
    pub fn advance(&mut self, seconds: f64) -> Result<()> {
        let mut left = seconds;
        if self.step == 0.0 {
            let loss = self.model.losses.iter().copied().fold(0.0, f64::max);
            self.step = (0.01 / loss).min(seconds);
        }
        while left > 0.0 {
            // Two steps of half the length instead of a whole and a tiny one.
            let h = match left / self.step {
                parts if parts <= 1.0 => left,
                parts if parts < 2.0 => 0.5 * left,
                _ => self.step,
            };
            let Some(attempt) = self.attempt(h)?.filter(|a| a.error <= 1.0) else {
                if h <= SHORTEST * seconds {
                    return Err(Error::NotConverged { iterations: ITERATIONS, residual: h });
                }
                continue;
            };
            self.content = attempt.content;
            self.lose(attempt.transpired);
            std::mem::swap(&mut self.present, &mut self.next);
            left = if h == left { 0.0 } else { left - h };
        }
        Ok(())
    }

    /// Adds to the transpired water by Neumaier's sum, so that many steps lose no digits.
    fn lose(&mut self, amount: f64) {
        let [sum, rest] = self.transpired;
        let total = sum + amount;
        let lost =
            if sum.abs() >= amount.abs() { sum - total + amount } else { amount - total + sum };
        self.transpired = [total, rest + lost];
    }

    /// Tries a step of h seconds into `next`; returns `None` when Newton's method does not
    /// converge. Chooses the length of the next step.
    fn attempt(&mut self, h: f64) -> Result<Option<Attempt>> {
        let tau = GAMMA * h;
        let mut transpired = 0.0;
        let mut content = self.content;
        self.next.copy_from_slice(&self.present);
        for i in 0..STAGES {
            let weights = WEIGHTS[i].map(|a| a * h);
            for (k, base) in self.base.iter_mut().enumerate() {
                let change: f64 = (0..i).map(|j| weights[j] * self.rates[j][k]).sum();
                *base = self.present[k] + change;
            }
            let soil_base: f64 =
                self.content + (0..i).map(|j| weights[j] * self.soil_rates[j]).sum::<f64>();
            let Some(found) = self.stage(tau, soil_base, content) else {
                self.step = 0.25 * h;
                return Ok(None);
            };
            content = found;
            for ((rate, w), base) in self.rates[i].iter_mut().zip(&self.next).zip(&self.base) {
                *rate = (w - base) / tau;
            }
            self.soil_rates[i] = (content - soil_base) / tau;
            let weight = if i + 1 < STAGES { WEIGHTS[STAGES - 1][i] } else { GAMMA };
            transpired += h * weight * self.loss();
        }
        let error = self.error(h) / TOLERANCE;
        let factor = if error.is_nan() { 0.2 } else { (0.9 * error.powf(-0.25)).clamp(0.2, 5.0) };
        // A step that the end of the time cuts short says little about the longest possible one.
        let cut_short = error <= 1.0 && h < self.step;
        self.step = if cut_short { self.step.max(h * factor) } else { h * factor };
        Ok(Some(Attempt { error, content, transpired }))
    }

    /// Returns the loss of leaves at the stage in `next`, in kg / s.
    fn loss(&self) -> f64 {
        let WaterModel { full, losses, .. } = &self.model;
        let open = |w: f64| self.responses.stomata.map_or(1.0, |s| s.openness(w));
        let of = |k: usize| {
            if losses[k] > 0.0 {
                full[k] * losses[k] * (open(self.next[k]) * self.next[k])
            } else {
                0.0
            }
        };
        (0..full.len()).map(of).sum()
    }

    /// Solves `M w + tau (eps L w + M l f(w) w - uptake) = M base` from `next` on, into `next`.
    /// Returns the content of the soil; `None` if it does not converge.
    fn stage(&mut self, tau: f64, soil_base: f64, mut content: f64) -> Option<f64> {
        for _ in 0..ITERATIONS {
            std::mem::swap(&mut self.guess, &mut self.next);
            let root = self.model.root();
            // The uptake, linearized, after elimination of the equation of the soil:
            let (mut share, mut pushed) = (0.0, 0.0);
            if let Some(soil) = self.responses.soil {
                let dryness = 1.0 - self.guess[root];
                let kept = tau * self.conductance * soil.supply_slope(content) * dryness;
                share = tau * self.conductance * soil.supply(content) / (1.0 + kept);
                pushed = kept * (soil_base - content) / (1.0 + kept);
            }
            self.solve(tau, share, share + pushed + tau * self.model.intake);
            content = soil_base - (share * (1.0 - self.next[root]) + pushed);
            let mut change = 0.0_f64;
            for (a, b) in self.guess.iter().zip(&self.next) {
                if !b.is_finite() {
                    return None;
                }
                change = change.max((a - b).abs());
            }
            if change <= SMALL || self.is_linear() {
                return Some(content);
            }
        }
        None
    }

    fn is_linear(&self) -> bool {
        self.responses.stomata.is_none() && self.conductance == 0.0
    }

    /// Solves the linearized equations; `share` is added to the excess of the root, `supply` to its
    /// right-hand side.
    fn solve(&mut self, tau: f64, share: f64, supply: f64) {
        let Self { model, responses, factor, base, guess, next, par, .. } = self;
        let WaterModel { order, full, losses, exchange, .. } = &*model;
        let root = model.root();
        let stomata = responses.stomata;
        let excess = |range: Range<usize>, out: &mut [f64]| {
            for (k, d) in range.clone().zip(out.iter_mut()) {
                // The derivative of f(w) w.
                let slope = match stomata {
                    Some(s) if losses[k] > 0.0 => {
                        s.openness(guess[k]) + guess[k] * s.slope(guess[k])
                    }
                    _ => 1.0,
                };
                *d = full[k] * (1.0 + tau * losses[k] * slope);
            }
            if range.contains(&root) {
                out[root - range.start] += share;
            }
        };
        factor.refactor(order, excess, exchange, tau, *par);
        let right = |range: Range<usize>, out: &mut [f64]| {
            for (k, b) in range.clone().zip(out.iter_mut()) {
                let curved = match stomata {
                    Some(s) if losses[k] > 0.0 => {
                        tau * losses[k] * (guess[k] * guess[k] * s.slope(guess[k]))
                    }
                    _ => 0.0,
                };
                *b = full[k] * (base[k] + curved);
            }
            if range.contains(&root) {
                out[root - range.start] += supply;
            }
        };
        factor.solve(order, right, next, *par);
    }

    /// Returns the largest error of the step in a relative water content, of plant or soil; the
    /// matrix of the last stage damps the stiff part of the plant's.
    fn error(&mut self, h: f64) -> f64 {
        for (k, base) in self.base.iter_mut().enumerate() {
            *base = h * (0..STAGES).map(|i| ERROR[i] * self.rates[i][k]).sum::<f64>();
        }
        let Self { model, factor, base, guess, par, .. } = self;
        let right = |range: Range<usize>, out: &mut [f64]| {
            for (k, b) in range.zip(out) {
                *b = model.full[k] * base[k];
            }
        };
        factor.solve(&model.order, right, guess, *par);
        let largest = guess.iter().map(|e| e.abs()).fold(0.0, f64::max);
        let sum: f64 = (0..STAGES).map(|i| ERROR[i] * self.soil_rates[i]).sum();
        largest.max((h * sum / self.scale).abs())
    }
}
