use super::bdf::{Bdf6, Start};
use super::rational::{EXPONENTIAL, Workspace};
use super::spectral::SpectralSolution;
use super::water::{WaterModel, at_least_zero, positive};
use crate::base::{Error, Par, Progress, Result, builder};

/// How water is computed at many times.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Method {
    /// The fastest of the others that is accurate to about 1e-12 of the water of a full plant, as rates of the model and
    /// times tell beforehand.
    Auto,
    /// From one time to the next by the rational approximation of the exponential: any times, any stiffness.
    Rational,
    /// By eigenvalues ([`SpectralSolution`]): small plants that are not stiff, many times.
    Spectral,
    /// By [`Bdf6`] with steps of at most so many seconds, shortened so that they end at the times asked for.
    Bdf6 {
        /// In seconds.
        step: f64,
    },
}

/// A part of a cycle of weather.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    /// Its length in seconds, above 0.
    pub seconds: f64,
    /// What leaves lose then, in kg / (s m^2).
    pub loss: f64,
}

impl Interval {
    /// 16 hours of light, in which leaves lose `loss`, and 8 of dark, in which they lose a twelfth of it.
    ///
    /// ```
    /// use catamaran::plant::Interval;
    ///
    /// let day = Interval::day_and_night(1.2e-5);
    /// assert_eq!(day.iter().map(|part| part.seconds).sum::<f64>(), 24.0 * 3600.0);
    /// ```
    pub fn day_and_night(loss: f64) -> Vec<Self> {
        const NIGHT_LOSS: f64 = 1.0 / 12.0;
        let [light, dark] = [16.0, 8.0].map(|hours| 3600.0 * hours);
        vec![Self { seconds: light, loss }, Self { seconds: dark, loss: loss * NIGHT_LOSS }]
    }
}

/// Options of [`water_curve`].
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct CurveOptions<'a> {
    /// Default [`Method::Auto`].
    pub method: Method,
    /// Losses that follow each other again and again, such as a day and a night, from time 0; none (default): the loss of the
    /// model.
    pub cycle: Vec<Interval>,
    /// Threads; default all cores of the affinity mask. Does not change the result.
    pub par: Par,
    /// Told of progress; may cancel.
    pub progress: Progress<'a>,
}

impl Default for CurveOptions<'_> {
    fn default() -> Self {
        Self { method: Method::Auto, cycle: vec![], par: Par::all(), progress: Progress::none() }
    }
}

builder! { CurveOptions<'a> {
    method: Method,
    cycle: Vec<Interval>,
    par: Par,
    #[into] progress: Progress<'a>,
}}

/// The water of every node, in kg, at each of `times` (seconds from 0, ascending), from `water` at time 0. Where the loss
/// changes, one solution ends and the next begins: nothing is interpolated.
///
/// ```
/// use catamaran::plant::{CurveOptions, WaterModel, WaterOptions, families, water_curve};
///
/// let model = WaterModel::new(&families::chain(20, 0.3, 1e-3)?, &WaterOptions::new())?;
/// let hours = [0.0, 3600.0, 7200.0];
/// let curve = water_curve(&model, &model.full(), &hours, &CurveOptions::new())?;
/// let total = curve.iter().map(|water| water.iter().sum()).collect::<Vec<f64>>();
/// assert!(total[0] > total[1] && total[1] > total[2]);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Argument`], [`Error::Shape`] and [`Error::NonFinite`] name the argument at fault; [`Error::OutOfMemory`];
/// [`Error::Cancelled`].
pub fn water_curve(
    model: &WaterModel,
    water: &[f64],
    times: &[f64],
    options: &CurveOptions<'_>,
) -> Result<Vec<Vec<f64>>> {
    for (i, &time) in times.iter().enumerate() {
        at_least_zero("times", time)?;
        if i > 0 && time < times[i - 1] {
            let why = format!("{time} s after {} s: they must ascend", times[i - 1]);
            return Err(Error::Argument { what: "times", why });
        }
    }
    let mut walk = Walk::new(model, water, times, options)?;
    let mut curve = Vec::with_capacity(times.len());
    for (i, &time) in times.iter().enumerate() {
        curve.push(walk.to(time)?);
        let fraction = (i + 1) as f64 / times.len() as f64;
        options.progress.report(fraction)?;
    }
    Ok(curve)
}

/// What [`Method::Auto`] stands for.
fn choose(model: &WaterModel, times: &[f64], cycle: &[Interval]) -> Method {
    /// Steps that resolve the fastest rate this often are accurate to 0.14 / 64^6 = 2e-12.
    const RESOLUTION: f64 = 64.0;
    /// Eigenvalues are off by rounding of the largest one; so is, times the time, the result.
    const LARGEST_EXPONENT: f64 = 1e3;
    /// A decomposition costs about n^3 / 10^9 s, an evaluation of the rational approximation n / 10^6 s.
    const LARGEST_MATRIX: usize = 256;
    let (Some(&first), Some(&last)) = (times.first(), times.last()) else {
        return Method::Rational;
    };
    let rate = model.fastest_rate_bound();
    if !cycle.is_empty() {
        return Method::Rational;
    }
    if model.len() <= LARGEST_MATRIX
        && times.len() >= model.len()
        && rate * last <= LARGEST_EXPONENT
    {
        return Method::Spectral;
    }
    let step = times.get(1).map_or(last, |second| second - first);
    let equal = times.windows(2).all(|t| ((t[1] - t[0]) - step).abs() <= 1e-9 * step);
    if equal && times.len() >= 32 && rate * step * RESOLUTION <= 1.0 {
        return Method::Bdf6 { step };
    }
    Method::Rational
}

enum Solver {
    Rational(Box<Workspace>),
    Spectral(Box<SpectralSolution>),
    Bdf6(Box<Bdf6>),
}

/// A solution that has come to some time.
pub(super) struct Walk<'a> {
    model: WaterModel,
    cycle: &'a [Interval],
    /// The interval at hand, and when it ends.
    interval: usize,
    end: f64,
    solver: Option<Solver>,
    method: Method,
    /// Relative water content by positions.
    present: Vec<f64>,
    time: f64,
    par: Par,
}

impl<'a> Walk<'a> {
    /// From `water` at time 0; [`Method::Auto`] is chosen for these times.
    pub fn new(
        model: &WaterModel,
        water: &[f64],
        times: &[f64],
        options: &'a CurveOptions<'_>,
    ) -> Result<Self> {
        for interval in &options.cycle {
            positive("seconds of an interval", interval.seconds)?;
            at_least_zero("loss of an interval", interval.loss)?;
        }
        let mut model = model.clone();
        let present = model.relative_by_positions(water)?;
        let method = match options.method {
            Method::Auto => choose(&model, times, &options.cycle),
            method => method,
        };
        let mut end = f64::INFINITY;
        if let Some(first) = options.cycle.first() {
            model.set_loss(first.loss)?;
            end = first.seconds;
        }
        Ok(Self {
            model,
            cycle: &options.cycle,
            interval: 0,
            end,
            solver: None,
            method,
            present,
            time: 0.0,
            par: options.par,
        })
    }

    /// The water at a later time.
    pub fn to(&mut self, time: f64) -> Result<Vec<f64>> {
        while self.end < time {
            self.advance(self.end)?;
            self.interval = (self.interval + 1) % self.cycle.len();
            self.end += self.cycle[self.interval].seconds;
            self.model.set_loss(self.cycle[self.interval].loss)?;
            self.solver = None;
        }
        self.advance(time)?;
        Ok(self.model.water_by_nodes(&self.present))
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

/// The fewest equal steps of at most `longest`, and their length.
fn equal_steps(seconds: f64, longest: f64) -> (usize, f64) {
    // A step that fits but for rounding fits.
    let count = (seconds / longest - 1e-9).ceil().max(1.0);
    (count as usize, seconds / count)
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
        let small = WaterModel::new(&chain(50, 0.5, 1e-3).unwrap(), &slow).unwrap();
        assert_eq!(choose(&small, &times, &[]), Method::Spectral);
        let plant = grow(&GrowthOptions { nodes: 300, ..Default::default() }).unwrap();
        let slow = WaterModel::new(&plant, &slow).unwrap();
        assert_eq!(choose(&slow, &times, &[]), Method::Bdf6 { step: 1.0 });
        assert_eq!(choose(&slow, &times[..20], &[]), Method::Rational);
        let stiff = WaterModel::new(&plant, &WaterOptions::default()).unwrap();
        assert_eq!(choose(&stiff, &times, &[]), Method::Rational);
        let day = Interval { seconds: 10.0, loss: 0.0 };
        assert_eq!(choose(&small, &times, &[day]), Method::Rational);
    }
}
