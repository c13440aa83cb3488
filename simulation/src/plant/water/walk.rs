//! A solution that advances through times, changes of the loss, and rewatering.

use super::bdf::{Bdf6, Start};
use super::diffusion::WaterModel;
use super::eigenvalues::SpectralSolution;
use super::exponential::{EXPONENTIAL, Workspace};
use super::options::{CurveOptions, Interval, Method};
use super::sdirk::{Responses, Sdirk};
use super::soil::{Balance, Rewatering};
use catamaran::base::{Error, Par, Result, at_least_zero, positive};

/// Largest number of intervals of a cycle that a solution walks through: days and nights of 1,369
/// years.
const INTERVALS: f64 = 1e6;

/// The times of a solution, from which its method follows.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Times {
    count: usize,
    last: f64,
    /// The difference of all successive times; `None` if they differ.
    step: Option<f64>,
}

impl Times {
    /// Returns the times `step`, 2 `step`, ...
    pub fn equal(step: f64, count: usize) -> Self {
        Self { count, last: step * count as f64, step: Some(step) }
    }

    /// Returns these ascending times.
    pub fn of(times: &[f64]) -> Self {
        let last = times.last().copied().unwrap_or(0.0);
        let step = times.get(1).map_or(last, |second| second - times[0]);
        let equal = times.windows(2).all(|t| ((t[1] - t[0]) - step).abs() <= 1e-9 * step);
        Self { count: times.len(), last, step: Some(step).filter(|_| equal) }
    }
}

/// Returns the method that [`Method::Auto`] stands for.
fn choose(model: &WaterModel, times: Times, cycle: &[Interval]) -> Method {
    /// Least number of steps per time constant of the fastest rate; their error is 0.14 / 64^6 =
    /// 2e-12.
    const RESOLUTION: f64 = 64.0;
    /// Least number of steps of BDF6 that are worth their start.
    const STEPS: usize = 32;
    /// Largest time relative to the fastest rate: the error of eigenvalues is the rounding error of
    /// the largest one, and the result multiplies it by the time.
    const LARGEST_EXPONENT: f64 = 1e3;
    /// Largest plant for a decomposition, which costs about n^3 / 10^9 s; an evaluation of the
    /// rational approximation costs n / 10^6 s.
    const LARGEST_MATRIX: usize = 256;
    let rate = model.fastest_rate_bound();
    if times.count == 0 || !cycle.is_empty() {
        return Method::Rational;
    }
    if model.len() <= LARGEST_MATRIX
        && times.count >= model.len()
        && rate * times.last <= LARGEST_EXPONENT
    {
        return Method::Spectral;
    }
    match times.step {
        Some(step) if times.count >= STEPS && rate * step * RESOLUTION <= 1.0 => {
            Method::Bdf6 { step }
        }
        _ => Method::Rational,
    }
}

/// Returns an error if a solution up to `last` would walk through too many intervals of a cycle.
fn check_intervals(cycle: &[Interval], last: f64) -> Result<()> {
    let period: f64 = cycle.iter().map(|interval| interval.seconds).sum();
    let intervals = (last / period * cycle.len() as f64).ceil();
    if intervals <= INTERVALS || cycle.is_empty() {
        return Ok(());
    }
    let why = format!(
        "has {intervals:.3e} intervals in {last:.3e} s, and each is a step; must have at most \
         {INTERVALS:e}"
    );
    Err(Error::Argument { what: "cycle", why })
}

enum Solver {
    Rational(Box<Workspace>),
    Spectral(Box<SpectralSolution>),
    Bdf6(Box<Bdf6>),
    Sdirk(Box<Sdirk>),
}

/// A solution that has reached some time.
pub(crate) struct Walk<'a> {
    model: WaterModel,
    cycle: &'a [Interval],
    /// The current interval, and its end.
    interval: usize,
    end: f64,
    solver: Option<Solver>,
    method: Method,
    /// Relative water content by positions.
    present: Vec<f64>,
    /// Water in plant and soil at time 0, in kg.
    initial: f64,
    /// The capacity of the soil, in kg.
    capacity: f64,
    /// Rewaterings that are still to come, the next one last.
    rewatering: Vec<Rewatering>,
    /// Water poured on the soil: the part that it held, and the part that drained, in kg.
    held: f64,
    drained: f64,
    time: f64,
    par: Par,
}

impl<'a> Walk<'a> {
    /// Starts from `water` at time 0; [`Method::Auto`] is resolved for these times.
    pub fn new(
        model: &WaterModel,
        water: &[f64],
        times: Times,
        options: &'a CurveOptions<'_>,
    ) -> Result<Self> {
        for interval in &options.cycle {
            positive("seconds of an interval", interval.seconds)?;
            at_least_zero("loss of an interval", interval.loss)?;
        }
        check_intervals(&options.cycle, times.last)?;
        let rewatering = rewatering(options)?;
        let mut model = model.clone();
        let present = model.relative_by_positions(water)?;
        let mut end = f64::INFINITY;
        if let Some(first) = options.cycle.first() {
            model.set_loss(first.loss)?;
            end = first.seconds;
        }
        let responses = Responses { stomata: options.stomata, soil: options.soil };
        responses.check()?;
        let (mut solver, mut method) = (None, options.method);
        if responses.are_none() {
            if method == Method::Auto {
                method = choose(&model, times, &options.cycle);
            }
        } else if method == Method::Auto {
            let sdirk = Sdirk::new(&model, responses, present.clone(), options.par)?;
            solver = Some(Solver::Sdirk(Box::new(sdirk)));
        } else {
            let why = format!("{method:?} is for linear problems, not for stomata or soil");
            return Err(Error::Argument { what: "method", why });
        }
        let soil = options.soil;
        Ok(Self {
            model,
            cycle: &options.cycle,
            interval: 0,
            end,
            solver,
            method,
            present,
            initial: water.iter().sum::<f64>() + soil.map_or(0.0, |s| s.content),
            capacity: soil.map_or(0.0, |s| s.capacity),
            rewatering,
            held: 0.0,
            drained: 0.0,
            time: 0.0,
            par: options.par,
        })
    }

    /// Computes the water at a later time, after the rewatering at that time.
    pub fn to(&mut self, time: f64) -> Result<Vec<f64>> {
        loop {
            match self.rewatering.last().copied() {
                Some(next) if next.seconds <= time && next.seconds <= self.end => {
                    self.advance(next.seconds)?;
                    self.rewatering.pop();
                    self.pour(next.amount);
                }
                _ if self.end < time => {
                    self.advance(self.end)?;
                    self.next_interval()?;
                }
                _ => break,
            }
        }
        self.advance(time)?;
        Ok(self.model.water_by_nodes(&self.present))
    }

    /// Returns the balance of the water.
    pub fn balance(&self) -> Balance {
        let plant: f64 = self.present.iter().zip(&self.model.full).map(|(w, m)| w * m).sum();
        let supplied = self.held + self.model.intake * self.time;
        let (soil, transpired) = match &self.solver {
            Some(Solver::Sdirk(sdirk)) => (sdirk.content(), sdirk.transpired()),
            // A plant without leaves loses nothing, and no less by rounding.
            _ => (0.0, (self.initial + supplied - plant).max(0.0)),
        };
        Balance { plant, soil, transpired, supplied, drained: self.drained }
    }

    fn next_interval(&mut self) -> Result<()> {
        self.interval = (self.interval + 1) % self.cycle.len();
        self.end += self.cycle[self.interval].seconds;
        self.model.set_loss(self.cycle[self.interval].loss)?;
        match &mut self.solver {
            Some(Solver::Sdirk(sdirk)) => sdirk.set_model(&self.model),
            solver => *solver = None,
        }
        Ok(())
    }

    fn pour(&mut self, amount: Option<f64>) {
        let Some(Solver::Sdirk(sdirk)) = &mut self.solver else { return };
        let room = (self.capacity - sdirk.content()).max(0.0);
        let held = amount.map_or(room, |amount| amount.min(room));
        sdirk.pour(held);
        self.held += held;
        self.drained += amount.map_or(0.0, |amount| amount - held);
    }

    fn advance(&mut self, time: f64) -> Result<()> {
        let seconds = time - self.time;
        self.time = time;
        if seconds <= 0.0 {
            return Ok(());
        }
        let solver = match self.solver.take() {
            Some(solver) => solver,
            None => self.start(seconds)?,
        };
        let mut solver = solver;
        match &mut solver {
            Solver::Rational(workspace) => {
                self.model.check_seconds(seconds)?;
                let steps = self.model.substeps(seconds);
                for _ in 0..steps {
                    let step = seconds / steps as f64;
                    EXPONENTIAL.apply(&self.model, &mut self.present, step, workspace, self.par);
                }
            }
            Solver::Spectral(solution) => {
                let water = self.model.water_by_nodes(&self.present);
                let water = solution.water_after(&water, seconds)?;
                self.present = self.model.relative_by_positions(&water)?;
            }
            Solver::Sdirk(sdirk) => {
                sdirk.advance(seconds)?;
                self.present.copy_from_slice(sdirk.present());
            }
            Solver::Bdf6(bdf) => {
                let Method::Bdf6 { step } = self.method else { return Ok(()) };
                let (count, step) = equal_steps(seconds, step);
                if (step - bdf.step_length()).abs() > 1e-9 * step {
                    bdf.restart(&self.model, step)?;
                }
                for _ in 0..count {
                    bdf.step();
                }
                self.present.copy_from_slice(bdf.present());
            }
        }
        self.solver = Some(solver);
        Ok(())
    }

    fn start(&self, seconds: f64) -> Result<Solver> {
        Ok(match self.method {
            Method::Auto | Method::Rational => {
                Solver::Rational(Box::new(Workspace::new(&self.model.order)?))
            }
            Method::Spectral => Solver::Spectral(Box::new(SpectralSolution::new(&self.model)?)),
            Method::Bdf6 { step } => {
                positive("step", step)?;
                let water = self.model.water_by_nodes(&self.present);
                let (_, step) = equal_steps(seconds, step);
                Solver::Bdf6(Box::new(Bdf6::new(
                    &self.model,
                    &water,
                    step,
                    Start::Radau,
                    self.par,
                )?))
            }
        })
    }
}

/// Returns the least number of equal steps of at most `longest`, and their length.
fn equal_steps(seconds: f64, longest: f64) -> (usize, f64) {
    // A step that exceeds the limit by rounding only counts as fitting.
    let count = (seconds / longest - 1e-9).ceil().max(1.0);
    (count as usize, seconds / count)
}

/// Returns the rewaterings, the last one first.
fn rewatering(options: &CurveOptions<'_>) -> Result<Vec<Rewatering>> {
    for pour in &options.rewatering {
        at_least_zero("time of rewatering", pour.seconds)?;
        at_least_zero("amount of rewatering", pour.amount.unwrap_or(0.0))?;
    }
    if options.soil.is_none() && !options.rewatering.is_empty() {
        let why = "requires a soil".into();
        return Err(Error::Argument { what: "rewatering", why });
    }
    let mut rewatering = options.rewatering.clone();
    // Rewaterings at the same time keep their order.
    rewatering.sort_by(|a, b| a.seconds.total_cmp(&b.seconds));
    rewatering.reverse();
    Ok(rewatering)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plant::families::{GrowthOptions, chain, grow};
    use crate::plant::{Conductivity, WaterOptions};

    #[test]
    fn the_method_follows_from_rates_and_times() {
        let slow = WaterOptions {
            conductivity: Conductivity::Pipe { scale: 1e-12 },
            ..Default::default()
        };
        let times: Vec<f64> = (1..=100).map(f64::from).collect();
        let few = Times::of(&times[..20]);
        let uneven = Times::of(&[&times[..], &[100.5]].concat());
        let times = Times::of(&times);
        let small = WaterModel::new(&chain(50, 0.5, 1e-3).unwrap(), &slow).unwrap();
        assert_eq!(choose(&small, times, &[]), Method::Spectral);
        let plant = grow(&GrowthOptions { nodes: 300, ..Default::default() }).unwrap();
        let slow = WaterModel::new(&plant, &slow).unwrap();
        assert_eq!(choose(&slow, times, &[]), Method::Bdf6 { step: 1.0 });
        assert_eq!(choose(&slow, Times::equal(1.0, 100), &[]), Method::Bdf6 { step: 1.0 });
        assert_eq!(choose(&slow, uneven, &[]), Method::Rational);
        assert_eq!(choose(&slow, few, &[]), Method::Rational);
        let stiff = WaterModel::new(&plant, &WaterOptions::default()).unwrap();
        assert_eq!(choose(&stiff, times, &[]), Method::Rational);
        let day = Interval { seconds: 10.0, loss: 0.0 };
        assert_eq!(choose(&small, times, &[day]), Method::Rational);
    }
}
