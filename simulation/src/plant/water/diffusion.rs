use std::f64::consts::PI;
use std::sync::Arc;

use super::super::Plant;
use super::elimination::{Factor, Order};
use catamaran::base::{Error, Par, Result, at_least_zero, options, positive, zeros};

/// The law of the conductance of segments along their axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Conductivity {
    /// The conductance of a pipe as wide as the segment (Hagen and Poiseuille), times the
    /// calibrated factor `scale`: vessels are much thinner than the stem, and with a factor of 1
    /// every plant behaves like a single reservoir.
    Pipe {
        /// Factor of the conductance of the full lumen.
        scale: f64,
    },
    /// `a D^b` in kg m / (s Pa), where D is the diameter in metres: a measured law of hydraulic
    /// conductivity.
    Power {
        /// The factor, above 0.
        a: f64,
        /// The exponent.
        b: f64,
    },
}

options! {
    /// The constants of the water of a plant, in SI units.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct WaterOptions {
        /// Loss of a square metre of leaf with full cells. Typical losses are 15 to 250 g / (h m^2)
        /// by day and 1 to 20 by night (thesis, section 4.3.1; [`grams_per_hour`]).
        loss: f64 = grams_per_hour(60.0), unit "kg / (s m^2)", check(at least 0);
        /// The conductance of segments.
        conductivity: Conductivity = Conductivity::Pipe { scale: 1e-9 };
        /// The pressure in full cells: `P = modulus * theta / theta_full`.
        modulus: f64 = 1e6, unit "Pa", check(positive);
        /// The viscosity of the sap.
        viscosity: f64 = 1e-3, unit "Pa s", check(positive);
        /// Water in a cubic metre of full tissue.
        density: f64 = 1000.0, unit "kg / m^3", check(positive);
        /// Intake of the root from the soil; 0 in a drought.
        intake: f64 = 0.0, unit "kg / s", check(at least 0);
    }
}

/// Converts a loss from g / (h m^2) to kg / (s m^2).
///
/// ```
/// assert_eq!(catamaran_simulation::plant::grams_per_hour(3600.0), 1e-3);
/// ```
pub fn grams_per_hour(loss: f64) -> f64 {
    loss / 3.6e6
}

/// The water in a plant: `d theta / dt = S theta + s` with `S = -(L D^-1 + D_l)` (thesis, equation
/// 4.3; corrections in docs/algorithms/plant.md).
///
/// theta is the water of every node in kg; D is the diagonal matrix of `theta_full / modulus` in kg
/// / Pa; L is the Laplacian of the tree with the conductances of its edges, in kg / (s Pa); D_l are
/// the losses in 1 / s; s is the intake of the root. S is similar to a symmetric negative
/// semi-definite matrix. Models share no mutable state.
///
/// ```
/// use catamaran::Par;
/// use catamaran_simulation::plant::{WaterModel, WaterOptions, families, grams_per_hour};
///
/// let plant = families::chain(20, 0.3, 1e-3)?;
/// let model = WaterModel::new(&plant, &WaterOptions::new().loss(grams_per_hour(100.0)))?;
/// let after = model.water_after(&model.full(), 3600.0, Par::Seq)?;
/// assert!(after.iter().sum::<f64>() < model.full().iter().sum()); // the plant dries
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct WaterModel {
    pub(super) order: Arc<Order>,
    /// theta_full, in kg.
    pub(super) full: Vec<f64>,
    /// modulus times conductance to the parent, in kg / s.
    pub(super) exchange: Vec<f64>,
    /// Area of leaf, in m^2.
    areas: Arc<[f64]>,
    /// Losses, in 1 / s.
    pub(super) losses: Vec<f64>,
    /// Intake of the root, in kg / s.
    pub(super) intake: f64,
    /// modulus times conductance of half of the root segment, in kg / s.
    pub(super) into_root: f64,
    root: usize,
}

impl WaterModel {
    /// Creates the model of a plant.
    ///
    /// # Errors
    /// [`Error::Argument`] names an option out of its range; [`Error::Mesh`] a node whose
    /// conductance or volume is 0 or infinite in `f64`; [`Error::OutOfMemory`].
    pub fn new(plant: &Plant, options: &WaterOptions) -> Result<Self> {
        let WaterOptions { conductivity, modulus, viscosity, density, .. } = *options;
        options.check_ranges()?;
        match conductivity {
            Conductivity::Pipe { scale } => positive("conductivity scale", scale)?,
            Conductivity::Power { a, .. } => positive("conductivity a", a)?,
        }
        let order = Order::new(plant);
        let resistance = |v: usize| {
            let (r, h) = (plant.segments()[v].radius, plant.lengths()[v]);
            match conductivity {
                Conductivity::Pipe { scale } => {
                    8.0 * viscosity * h / (PI * r.powi(4) * density * scale)
                }
                Conductivity::Power { a, b } => h / (a * (2.0 * r).powf(b)),
            }
        };
        let mut full = Vec::with_capacity(plant.len());
        let mut exchange = Vec::with_capacity(plant.len());
        for v in 0..plant.len() {
            full.push(density * plant.volume(v));
            // Two half segments in series.
            exchange.push(
                plant.parent(v).map_or(0.0, |p| modulus * 2.0 / (resistance(p) + resistance(v))),
            );
            let conducts =
                plant.parent(v).is_none() || (exchange[v] > 0.0 && exchange[v].is_finite());
            if !(full[v] > 0.0 && full[v].is_finite() && conducts) {
                let what = format!(
                    "water ({} kg) and exchange ({} kg / s) must be positive and finite",
                    full[v], exchange[v]
                );
                return Err(Error::Mesh { what, element: format!("node {v}") });
            }
        }
        let areas: Vec<f64> = (0..plant.len()).map(|v| plant.leaf_area(v)).collect();
        let mut model = Self {
            full: order.by_positions(&full),
            exchange: order.by_positions(&exchange),
            areas: order.by_positions(&areas).into(),
            losses: zeros(plant.len())?,
            intake: 0.0,
            into_root: modulus * 2.0 / resistance(plant.root()),
            root: order.position(plant.root()),
            order: Arc::new(order),
        };
        model.set_loss(options.loss)?;
        model.set_intake(options.intake)?;
        Ok(model)
    }

    /// Returns the number of nodes.
    #[allow(clippy::len_without_is_empty)] // there is no empty plant
    pub fn len(&self) -> usize {
        self.full.len()
    }

    /// Returns the water of every node when its cells are full, in kg: the initial state of a
    /// healthy plant (thesis, section 4.3.3).
    pub fn full(&self) -> Vec<f64> {
        self.order.by_nodes(&self.full)
    }

    /// Returns the water of every node relative to its water when full, from water in kg.
    ///
    /// ```
    /// use catamaran_simulation::plant::{WaterModel, WaterOptions, families};
    ///
    /// let model = WaterModel::new(&families::chain(10, 0.3, 1e-3)?, &WaterOptions::new())?;
    /// let half: Vec<f64> = model.full().iter().map(|water| 0.5 * water).collect();
    /// assert!(model.relative(&half)?.iter().all(|w| (w - 0.5).abs() < 1e-12));
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Shape`] and [`Error::NonFinite`] name `water`.
    pub fn relative(&self, water: &[f64]) -> Result<Vec<f64>> {
        Ok(self.order.by_nodes(&self.relative_by_positions(water)?))
    }

    /// Returns the loss of every node, in 1 / s.
    pub fn losses(&self) -> Vec<f64> {
        self.order.by_nodes(&self.losses)
    }

    /// Returns the flow between each node and its parent at a difference of 1 of their relative
    /// water contents, in kg / s: modulus times conductance; 0 for the root.
    pub fn exchanges(&self) -> Vec<f64> {
        self.order.by_nodes(&self.exchange)
    }

    /// Sets the loss of all leaves, in kg / (s m^2), as for a change of weather.
    ///
    /// ```
    /// use catamaran::Par;
    /// use catamaran_simulation::plant::{WaterModel, WaterOptions, families};
    ///
    /// let mut model = WaterModel::new(&families::chain(10, 0.3, 1e-3)?, &WaterOptions::new())?;
    /// model.set_loss(0.0)?;
    /// assert_eq!(model.slowest_rate(Par::Seq)?, 0.0);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Argument`] if the loss is negative or not finite.
    pub fn set_loss(&mut self, loss: f64) -> Result<()> {
        at_least_zero("loss", loss)?;
        for k in 0..self.len() {
            self.losses[k] = loss * self.areas[k] / self.full[k];
        }
        Ok(())
    }

    /// Sets the loss of one node, in 1 / s, until the next [`WaterModel::set_loss`].
    ///
    /// # Errors
    /// [`Error::Argument`] for a node that does not exist, or a loss that is negative or not
    /// finite.
    pub fn set_loss_of(&mut self, node: usize, loss: f64) -> Result<()> {
        at_least_zero("loss", loss)?;
        let k = self.position(node)?;
        self.losses[k] = loss;
        Ok(())
    }

    /// Sets the intake of the root from the soil, in kg / s.
    ///
    /// # Errors
    /// [`Error::Argument`] if the intake is negative or not finite.
    pub fn set_intake(&mut self, intake: f64) -> Result<()> {
        at_least_zero("intake", intake)?;
        self.intake = intake;
        Ok(())
    }

    /// Damages the connection of a node to its parent: multiplies its conductance by `factor`,
    /// where 0 cuts it.
    ///
    /// # Errors
    /// [`Error::Argument`] for a node that does not exist or is the root, or a factor that is
    /// negative or not finite.
    pub fn weaken(&mut self, node: usize, factor: f64) -> Result<()> {
        at_least_zero("factor", factor)?;
        let k = self.position(node)?;
        if k == self.root {
            let why = format!("node {node} is the root, which has no connection to a parent");
            return Err(Error::Argument { what: "node", why });
        }
        self.exchange[k] *= factor;
        Ok(())
    }

    /// Cuts the connection between a node and its parent, so that no water passes:
    /// [`WaterModel::weaken`] with factor 0.
    ///
    /// ```
    /// use catamaran::Par;
    /// use catamaran_simulation::plant::{WaterModel, WaterOptions, families};
    ///
    /// let mut model = WaterModel::new(&families::chain(10, 0.3, 1e-3)?, &WaterOptions::new())?;
    /// let whole = model.water_after(&model.full(), 86_400.0, Par::Seq)?;
    /// model.cut(9)?; // the leaf
    /// let after = model.water_after(&model.full(), 86_400.0, Par::Seq)?;
    /// assert!(after[9] < whole[9] && after[0] > whole[0]);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`WaterModel::weaken`].
    pub fn cut(&mut self, node: usize) -> Result<()> {
        self.weaken(node, 0.0)
    }

    /// Computes the slowest rate at which water is lost, in 1 / s: the smallest eigenvalue of -S,
    /// by inverse iteration. All of its digits are correct, because elimination does not subtract.
    /// The rate is 0 if a part of the plant loses nothing.
    ///
    /// ```
    /// use catamaran::Par;
    /// use catamaran_simulation::plant::{SpectralSolution, WaterModel, WaterOptions, families};
    ///
    /// let model = WaterModel::new(&families::chain(10, 0.3, 1e-3)?, &WaterOptions::new())?;
    /// let rate = model.slowest_rate(Par::Seq)?;
    /// assert!((rate / SpectralSolution::new(&model)?.rates()[0] - 1.0).abs() < 1e-6);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::NotConverged`] when the two slowest rates are nearly equal; [`Error::OutOfMemory`].
    pub fn slowest_rate(&self, par: Par) -> Result<f64> {
        const ITERATIONS: usize = 500;
        let mut factor = Factor::new(&self.order)?;
        let excess = |range: std::ops::Range<usize>, out: &mut [f64]| {
            for (k, d) in range.zip(out) {
                *d = self.losses[k] * self.full[k];
            }
        };
        factor.refactor(&self.order, excess, &self.exchange, 1.0, par);
        if factor.is_singular() {
            return Ok(0.0);
        }
        let (mut mode, mut next) = (vec![1.0; self.len()], vec![0.0; self.len()]);
        let (mut rate, mut change) = (f64::NAN, f64::NAN);
        for _ in 0..ITERATIONS {
            let weighted = |range: std::ops::Range<usize>, out: &mut [f64]| {
                for (k, b) in range.zip(out) {
                    *b = self.full[k] * mode[k];
                }
            };
            factor.solve(&self.order, weighted, &mut next, par);
            let sum = |f: &dyn Fn(usize) -> f64| (0..self.len()).map(f).sum::<f64>();
            let quotient = sum(&|k| self.full[k] * mode[k] * next[k])
                / sum(&|k| self.full[k] * next[k] * next[k]);
            change = (quotient - rate).abs() / quotient;
            rate = quotient;
            let largest = next.iter().copied().fold(0.0, f64::max);
            mode.iter_mut().zip(&next).for_each(|(m, x)| *m = x / largest);
            if change <= 4.0 * f64::EPSILON {
                return Ok(rate);
            }
        }
        Err(Error::NotConverged { iterations: ITERATIONS, residual: change })
    }

    /// Returns an upper bound of the rates of the plant, in 1 / s (Gershgorin).
    pub(super) fn fastest_rate_bound(&self) -> f64 {
        let mut sums = self.exchange.clone();
        for k in 0..self.len() {
            if let Some(p) = self.order.parent(k) {
                sums[p] += self.exchange[k];
            }
        }
        let rate = |k: usize| 2.0 * sums[k] / self.full[k] + self.losses[k];
        (0..self.len()).map(rate).fold(0.0, f64::max)
    }

    /// Returns the loss of a full plant relative to its water, in 1 / s.
    pub(super) fn mean_loss(&self) -> f64 {
        let lost: f64 = (0..self.len()).map(|k| self.losses[k] * self.full[k]).sum();
        lost / self.full.iter().sum::<f64>()
    }

    /// Returns the relative water content by positions.
    pub(super) fn relative_by_positions(&self, water: &[f64]) -> Result<Vec<f64>> {
        Error::check_shape("water", (self.len(), 1), (water.len(), 1))?;
        if let Some(v) = water.iter().position(|x| !x.is_finite()) {
            return Err(Error::NonFinite { what: "water", index: (v, 0) });
        }
        let mut relative = self.order.by_positions(water);
        relative.iter_mut().zip(&self.full).for_each(|(x, full)| *x /= full);
        Ok(relative)
    }

    /// Converts relative water content by positions to the water of nodes, in kg.
    pub(super) fn water_by_nodes(&self, relative: &[f64]) -> Vec<f64> {
        let water: Vec<f64> = relative.iter().zip(&self.full).map(|(x, full)| x * full).collect();
        self.order.by_nodes(&water)
    }

    /// Returns the position of the root.
    pub(super) fn root(&self) -> usize {
        self.root
    }

    fn position(&self, node: usize) -> Result<usize> {
        if node < self.len() {
            return Ok(self.order.position(node));
        }
        let why = format!("node {node} is out of range: {} nodes, numbered from 0", self.len());
        Err(Error::Argument { what: "node", why })
    }
}
