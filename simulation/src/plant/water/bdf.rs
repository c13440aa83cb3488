use super::diffusion::WaterModel;
use super::elimination::Factor;
use super::exponential::{EXPONENTIAL, RADAU, Workspace};
use catamaran::base::{Error, Par, Progress, Result, positive, zeros};

/// The weights of the last six values, oldest first, and the weight of the right-hand side, as
/// multiples of 1 / 147.
const WEIGHTS: [f64; 6] = [-10.0, 72.0, -225.0, 400.0, -450.0, 360.0];
const RIGHT: f64 = 60.0;
const UNIT: f64 = 147.0;

/// The source of the first six values of [`Bdf6`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Start {
    /// Steps of Radau IIA of order 5 (Hairer and Wanner 1996, section IV.5). The default.
    Radau,
    /// The exponential itself, by the rational approximation of [`WaterModel::water_after`].
    Exact,
    /// Six times the initial value, as in the thesis: the error then grows with the step itself,
    /// not with its sixth power.
    Constant,
}

/// The backward differentiation formula of order 6 with a fixed step (thesis, equation 4.8): a
/// factorization for each change of the model or the step, and two passes over the tree for each
/// step.
///
/// ```
/// use catamaran::Par;
/// use catamaran_simulation::plant::{Bdf6, Start, WaterModel, WaterOptions, families};
///
/// let model = WaterModel::new(&families::chain(20, 0.3, 1e-3)?, &WaterOptions::new())?;
/// let mut solver = Bdf6::new(&model, &model.full(), 10.0, Start::Radau, Par::Seq)?;
/// for _ in 0..60 {
///     solver.step();
/// }
/// let exact = model.water_after(&model.full(), solver.time(), Par::Seq)?;
/// assert!(solver.water().iter().zip(&exact).all(|(x, y)| (x / y - 1.0).abs() < 1e-6));
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Bdf6 {
    model: WaterModel,
    factor: Factor<f64>,
    /// Relative water content, oldest first; the last entry is the current one.
    history: [Vec<f64>; 6],
    next: Vec<f64>,
    workspace: Option<Workspace>,
    step: f64,
    start: Start,
    /// Number of steps since the last restart.
    steps: usize,
    time: f64,
    par: Par,
}

impl Bdf6 {
    /// Starts at time 0 with `water`, in kg by nodes, and steps of `step` seconds.
    ///
    /// # Errors
    /// [`Error::Shape`], [`Error::NonFinite`] and [`Error::Argument`] name the argument at fault;
    /// [`Error::OutOfMemory`].
    pub fn new(
        model: &WaterModel,
        water: &[f64],
        step: f64,
        start: Start,
        par: Par,
    ) -> Result<Self> {
        let present = model.relative_by_positions(water)?;
        let n = model.len();
        let mut history = [zeros(n)?, zeros(n)?, zeros(n)?, zeros(n)?, zeros(n)?, zeros(n)?];
        history[5] = present;
        let mut solver = Self {
            model: model.clone(),
            factor: Factor::new(&model.order)?,
            history,
            next: zeros(n)?,
            workspace: None,
            step,
            start,
            steps: 0,
            time: 0.0,
            par,
        };
        solver.restart(model, step)?;
        Ok(solver)
    }

    /// Continues from the current water with another model of the same plant (another loss, damage)
    /// or another step. The history restarts, because derivatives jump.
    ///
    /// ```
    /// use catamaran::Par;
    /// use catamaran_simulation::plant::{Bdf6, Start, WaterModel, WaterOptions, families};
    ///
    /// let mut model = WaterModel::new(&families::chain(10, 0.3, 1e-3)?, &WaterOptions::new())?;
    /// let mut solver = Bdf6::new(&model, &model.full(), 10.0, Start::Radau, Par::Seq)?;
    /// solver.step();
    /// // From now on, leaves lose nothing.
    /// let before: f64 = solver.water().iter().sum();
    /// model.set_loss(0.0)?;
    /// solver.restart(&model, 60.0)?;
    /// solver.step();
    /// assert!((solver.water().iter().sum::<f64>() / before - 1.0).abs() < 1e-9);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Argument`] for a step that is not positive, [`Error::Shape`] for a model of another
    /// size, [`Error::OutOfMemory`].
    pub fn restart(&mut self, model: &WaterModel, step: f64) -> Result<()> {
        positive("step", step)?;
        Error::check_shape("model", (self.model.len(), 1), (model.len(), 1))?;
        self.model = model.clone();
        self.step = step;
        self.steps = 0;
        let tau = RIGHT / UNIT * step;
        let (full, losses) = (&self.model.full, &self.model.losses);
        let excess = |range: std::ops::Range<usize>, out: &mut [f64]| {
            for ((d, full), loss) in out.iter_mut().zip(&full[range.clone()]).zip(&losses[range]) {
                *d = full * (1.0 + tau * loss);
            }
        };
        self.factor.refactor(&self.model.order, excess, &self.model.exchange, tau, self.par);
        if self.start == Start::Constant {
            let (last, others) = self.history.split_last_mut().expect("six of them");
            others.iter_mut().for_each(|h| h.copy_from_slice(last));
        } else {
            self.workspace = Some(Workspace::new(&self.model.order)?);
        }
        Ok(())
    }

    /// Advances by one step.
    pub fn step(&mut self) {
        let starting = self.steps < 5;
        match self.workspace.as_mut().filter(|_| starting) {
            Some(workspace) => {
                let rational = if self.start == Start::Exact { &EXPONENTIAL } else { &RADAU };
                self.next.copy_from_slice(&self.history[5]);
                rational.apply(&self.model, &mut self.next, self.step, workspace, self.par);
            }
            None => {
                // The memory of the start is no longer needed.
                self.workspace = None;
                self.implicit_step();
            }
        }
        self.history.rotate_left(1);
        std::mem::swap(&mut self.history[5], &mut self.next);
        self.steps += 1;
        self.time += self.step;
    }

    /// Advances by `count` steps.
    ///
    /// # Errors
    /// [`Error::Cancelled`]: earlier steps are complete, and a later call can continue.
    pub fn run(&mut self, count: usize, progress: Progress<'_>) -> Result<()> {
        for done in 1..=count {
            self.step();
            progress.report(done as f64 / count as f64)?;
        }
        Ok(())
    }

    fn implicit_step(&mut self) {
        let Self { model, history, .. } = self;
        let order = &model.order;
        // Only the root takes in water.
        let intake = RIGHT / UNIT * self.step * model.intake;
        let root = model.root();
        let right = |range: std::ops::Range<usize>, out: &mut [f64]| {
            let [a, b, c, d, e, f] = history.each_ref().map(|h| &h[range.clone()]);
            let full = &model.full[range.clone()];
            for k in 0..out.len() {
                let sum = WEIGHTS[0] * a[k]
                    + WEIGHTS[1] * b[k]
                    + WEIGHTS[2] * c[k]
                    + WEIGHTS[3] * d[k]
                    + WEIGHTS[4] * e[k]
                    + WEIGHTS[5] * f[k];
                out[k] = full[k] * (sum / UNIT);
            }
            if range.contains(&root) {
                out[root - range.start] += intake;
            }
        };
        self.factor.solve(order, right, &mut self.next, self.par);
    }

    /// Returns the current water of every node, in kg.
    pub fn water(&self) -> Vec<f64> {
        self.model.water_by_nodes(&self.history[5])
    }

    /// Returns the seconds since time 0.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Returns the relative water content by positions.
    pub(super) fn present(&self) -> &[f64] {
        &self.history[5]
    }

    /// Returns the length of a step, in seconds.
    pub fn step_length(&self) -> f64 {
        self.step
    }

    /// Returns the model that the solver uses.
    pub fn model(&self) -> &WaterModel {
        &self.model
    }
}
