//! Water after a time, by the exponential of a matrix (thesis, equation 4.5): rational
//! approximations of the exponential, as sums of partial fractions.

use faer::c64;

use super::diffusion::WaterModel;
use super::elimination::{Factor, Order};
use catamaran::base::{Error, Par, Progress, Result, at_least_zero, reserved};

/// A rational approximation of the exponential on the negative axis, as the real part of partial
/// fractions: `constant + sum of 2 Re(c / (x - z))`.
pub(crate) struct Rational {
    constant: f64,
    /// Re z, Im z, Re c, Im c. Of two conjugate poles one is listed; for a real pole, c is halved.
    terms: &'static [[f64; 4]],
}

/// The best approximation of the exponential on the negative axis of degree 16: its error is
/// 2.1e-16 everywhere, up to rounding (Cody, Meinardus and Varga 1969; computed in 60 digits by the
/// method of Caratheodory and Fejer, Trefethen 1981).
#[rustfmt::skip]
pub(crate) const EXPONENTIAL: Rational = Rational {
    constant: 2.1192629e-16,
    terms: &[
        [-10.84391707869698, 19.277446167181658, -5.090152186521197e-07, -2.422001765285245e-05],
        [-5.264971343442642, 16.220221473167932, 0.00021151742182464765, 0.004389296964738089],
        [-1.4139284624888824, 13.497725698892747, 0.04102313683541049, -0.1574346617345552],
        [1.4193758971856691, 10.925363484496724, -1.4793007113558072, 1.7686588323782972],
        [3.5091036084149207, 8.436198985884376, 15.059585270023515, -5.751405277642184],
        [4.9931747377179985, 5.996881713603943, -62.51839246320807, -11.190391094283296],
        [5.94815226895118, 3.5874573620183225, 113.39775178483954, 101.94721704215884],
        [6.416177699099436, 1.1941223933701388, -64.50087802553978, -224.5944076265215],
    ],
};

/// The stability function of Radau IIA of order 5,
/// `(1 + 2x/5 + x^2/20) / (1 - 3x/5 + 3x^2/20 - x^3/60)`.
#[rustfmt::skip]
pub(crate) const RADAU: Rational = Rational {
    constant: 0.0,
    terms: &[
        [3.637_834_252_744_496, 0.0, -9.148_749_087_422_921, 0.0],
        [2.681_082_873_627_752_3, 3.050_430_199_247_410_5, 7.648_749_087_422_922, 4.171_640_244_747_437],
    ],
};

/// The memory for a rational function of a matrix.
#[derive(Debug, Clone)]
pub(crate) struct Workspace {
    factor: Factor<c64>,
    solution: Vec<c64>,
}

impl Workspace {
    /// Allocates the memory of an approximation.
    pub fn new(order: &Order) -> Result<Self> {
        let mut solution = reserved(order.len())?;
        solution.resize(order.len(), c64::new(0.0, 0.0));
        Ok(Self { factor: Factor::new(order)?, solution })
    }
}

impl Rational {
    /// Computes `relative := r(t S) relative` and adds the intake of the root in this time,
    /// `t phi(t S) s` with `phi(x) = (r(x) - r(0)) / x`, whose partial fractions have c / z for c.
    pub fn apply(
        &self,
        model: &WaterModel,
        relative: &mut [f64],
        t: f64,
        workspace: &mut Workspace,
        par: Par,
    ) {
        let WaterModel { order, full, losses, exchange, .. } = model;
        let Workspace { factor, solution } = workspace;
        let mut sum: Vec<f64> = relative.iter().map(|w| self.constant * w).collect();
        for &[re, im, c_re, c_im] in self.terms {
            let (z, c) = (c64::new(re, im), c64::new(c_re, c_im));
            let excess = |range: std::ops::Range<usize>, out: &mut [c64]| {
                for ((d, full), loss) in
                    out.iter_mut().zip(&full[range.clone()]).zip(&losses[range])
                {
                    *d = c64::new(full * (re + t * loss), full * im);
                }
            };
            factor.refactor(order, excess, exchange, t, par);
            let present = &*relative;
            let right = |range: std::ops::Range<usize>, out: &mut [c64]| {
                let values = full[range.clone()].iter().zip(&present[range.clone()]);
                for (b, (full, w)) in out.iter_mut().zip(values) {
                    *b = c64::new(-full * w, 0.0);
                }
                if range.contains(&model.root()) {
                    let b = &mut out[model.root() - range.start];
                    *b -= c64::new(t * model.intake, 0.0) / z;
                }
            };
            factor.solve(order, right, solution, par);
            for (sum, x) in sum.iter_mut().zip(&*solution) {
                *sum += 2.0 * (c.re * x.re - c.im * x.im);
            }
        }
        relative.copy_from_slice(&sum);
    }
}

impl WaterModel {
    /// Computes the water of every node, in kg, `seconds` after it was `water` (kg, by nodes): the
    /// exponential of S by a rational approximation, with 8 factorizations with complex shifts, in
    /// O(n). There are no time steps, unless most of the water is lost: a step may lose a factor of
    /// about 20, so that the rest keeps its digits.
    ///
    /// ```
    /// use catamaran::Par;
    /// use catamaran_simulation::plant::{WaterModel, WaterOptions, families};
    ///
    /// let model = WaterModel::new(&families::chain(10, 0.3, 1e-3)?, &WaterOptions::new())?;
    /// let day = model.water_after(&model.full(), 86_400.0, Par::Seq)?;
    /// assert!(day.iter().zip(model.full()).all(|(after, full)| *after < full));
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// The error is about 1e-13 of the water at the beginning of a step; the result is the same for
    /// every `par`, bit for bit.
    ///
    /// # Errors
    /// [`Error::Shape`], [`Error::NonFinite`] and [`Error::Argument`] name the argument at fault;
    /// [`Error::OutOfMemory`].
    pub fn water_after(&self, water: &[f64], seconds: f64, par: Par) -> Result<Vec<f64>> {
        self.water_after_with(water, seconds, par, Progress::none())
    }

    /// Computes the same as [`WaterModel::water_after`], with a callback for progress.
    #[doc(hidden)]
    pub fn water_after_with(
        &self,
        water: &[f64],
        seconds: f64,
        par: Par,
        progress: Progress<'_>,
    ) -> Result<Vec<f64>> {
        at_least_zero("seconds", seconds)?;
        self.check_seconds(seconds)?;
        let mut relative = self.relative_by_positions(water)?;
        if seconds > 0.0 {
            let mut workspace = Workspace::new(&self.order)?;
            let steps = self.substeps(seconds);
            for done in 1..=steps {
                EXPONENTIAL.apply(self, &mut relative, seconds / steps as f64, &mut workspace, par);
                progress.report(done as f64 / steps as f64)?;
            }
        }
        Ok(self.water_by_nodes(&relative))
    }

    /// Checks that the arithmetic of [`Rational::apply`] does not overflow in this time.
    ///
    /// # Errors
    /// [`Error::Argument`] names the time.
    pub(super) fn check_seconds(&self, seconds: f64) -> Result<()> {
        /// The most water, in kg, that may pass in this time if all cells were empty: complex
        /// divisions square it.
        const MOST: f64 = 1e100;
        let lost = self.losses.iter().zip(&self.full).map(|(loss, full)| loss * full);
        let fastest = self.exchange.iter().copied().chain(lost).fold(self.intake, f64::max);
        if fastest * seconds <= MOST {
            return Ok(());
        }
        let why = format!(
            "must be at most {:e} with the fastest conductance or loss, {fastest:e} kg/s; is \
             {seconds:e}",
            MOST / fastest
        );
        Err(Error::Argument { what: "seconds", why })
    }

    /// Returns the number of steps of a time, none of which loses too much.
    pub(super) fn substeps(&self, seconds: f64) -> usize {
        /// Exponent of the loss in a step.
        const LOST: f64 = 3.0;
        /// Exponent of the loss in a step of a leaf that gets no water. For more there are two
        /// steps: the first dries the leaf, and the second rounds relative to the rest.
        const LOST_BY_A_LEAF: f64 = 4.0;
        /// After this many steps nothing is left.
        const MOST: f64 = 64.0;
        let fastest = self.losses.iter().copied().fold(0.0, f64::max);
        let least = if seconds * fastest > LOST_BY_A_LEAF { 2.0 } else { 1.0 };
        (seconds * self.mean_loss() / LOST).ceil().clamp(least, MOST) as usize
    }
}
