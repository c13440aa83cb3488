//! Rods in motion: implicit Euler, with the direct solver for stiff rods of Deul, Kugelstadt,
//! Weiler and Bender (2018).
//!
//! There is a body with six unknowns for each segment, and a joint with six equations for each
//! segment: three for zero stretch, three for bending and twisting with the compliance K^-1. In the
//! tree of bodies and joints, the matrix of a Newton step is eliminated from the leaves by blocks,
//! `L D L^T` without fill-in.

use super::joint::{difference, strain, strain_derivative};
use super::small::{
    Factor, Matrix, NO_ROTATION, Quaternion, add, cholesky, cross_matrix, identity, image, inverse,
    logarithm, product, rotation_matrix, solve, solve_matrix, times, transposed, turned,
};
use super::{Pose, Rods, joint};
use catamaran::base::{Error, Progress, Result, options};
use catamaran_geometry::mesh::vector::{Vector, dot, norm, scale, sub};

options! {
    /// Options of [`Motion`].
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct MotionOptions {
        /// Duration of a step.
        step: f64 = 1.0 / 60.0, unit "s", check(positive);
        /// Largest number of Newton iterations of a step.
        iterations: usize = 3;
        /// The rate of decay of velocities.
        damping: f64 = 1.0, unit "1 / s", check(at least 0);
        /// The drag coefficient of segments and leaves in the air of [`Motion::set_wind`]; 1.2 is
        /// that of a cylinder across the wind at Reynolds numbers of 10^2 to 10^5.
        drag: f64 = 1.2, check(at least 0);
    }
}

/// The density of air, in kg / m^3.
const AIR: f64 = 1.2;

/// Largest rotation of a Newton step at which the iteration stops: the next step would be
/// invisible, in radians.
const CONVERGED: f64 = 0.03;

/// Bound of the rotation of a Newton step, in radians.
const LARGEST_TURN: f64 = 0.7;

/// Number of Newton iterations beyond [`MotionOptions::iterations`] before a step is halved.
const MORE_ITERATIONS: usize = 4;

/// Largest number of halvings of a step: at most 256 parts.
const MOST_HALVINGS: usize = 8;

/// Rods in motion.
///
/// ```
/// use catamaran_simulation::plant::{Elasticity, Motion, MotionOptions, RodOptions, Rods};
/// use catamaran_simulation::plant::{WaterModel, WaterOptions, families};
///
/// let plant = families::grow(&families::GrowthOptions::new().nodes(50))?;
/// let full = WaterModel::new(&plant, &WaterOptions::new())?.full();
/// let mut rods = Rods::new(&plant, &RodOptions::new())?;
/// rods.set_state(&Elasticity::default().moduli(&full, &full)?, &full)?;
/// let start = rods.rest_pose();
/// let mut motion = Motion::new(&rods, &start, &MotionOptions::new().step(0.01))?;
/// for _ in 0..10 {
///     motion.step()?;
/// }
/// // The tip sinks, and the segments stay together.
/// let height = |tails: &[[f64; 3]]| tails.iter().map(|p| p[2]).sum::<f64>();
/// assert!(height(&motion.pose().tails) < height(&start.tails));
/// assert!(motion.largest_gap() < 1e-4);
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Motion {
    rods: Rods,
    options: MotionOptions,
    moving: Moving,
    /// The velocity of the air, in m / s; `None` without air.
    wind: Option<Vector>,
    workspace: Workspace,
}

/// The mechanical energy of rods, in J.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Energy {
    /// Energy of velocities and spins.
    pub kinetic: f64,
    /// Energy of bent and twisted joints; 0 in the rest pose.
    pub elastic: f64,
    /// Energy of weight, in the coordinates of the plant.
    pub weight: f64,
}

impl Energy {
    /// Returns the sum of all parts of the energy, in J.
    pub fn total(&self) -> f64 {
        self.kinetic + self.elastic + self.weight
    }
}

/// The state that a step changes.
#[derive(Debug, Clone)]
struct Moving {
    /// The middle of every segment.
    centres: Vec<Vector>,
    rotations: Vec<Quaternion>,
    velocities: Vec<Vector>,
    /// Angular velocities.
    spins: Vec<Vector>,
    /// Forces and torques of the joints.
    multipliers: Vec<[f64; 6]>,
}

/// The start of a step, and the positions of its bodies without joints.
struct Step {
    seconds: f64,
    start: Vec<Vector>,
    centres: Vec<Vector>,
    rotations: Vec<Quaternion>,
    /// For each body, the derivative of the drag with respect to its velocity, in N s / m; empty
    /// without air.
    drag: Vec<Matrix<3>>,
}

/// The memory of a Newton step, kept from one to the next: fresh memory of this size costs a
/// quarter of the time.
#[derive(Debug, Clone, Default)]
struct Workspace {
    joints: Vec<Joint>,
    /// The equations of the bodies: the blocks on the diagonal, in the end their factors, and the
    /// right-hand sides.
    blocks: Vec<Matrix<6>>,
    right: Vec<[f64; 6]>,
    /// For every joint, the factor of its block, and its right-hand side.
    joint_factors: Vec<Factor<6>>,
    joint_right: Vec<[f64; 6]>,
    /// The steps of bodies and the changes of multipliers.
    steps: Vec<[f64; 6]>,
    changes: Vec<[f64; 6]>,
}

/// The equations of the joint of a segment.
#[derive(Debug, Clone)]
struct Joint {
    error: [f64; 6],
    compliance: Matrix<6>,
    by_child: Matrix<6>,
    by_parent: Matrix<6>,
}

impl Motion {
    /// Starts at rest in a pose.
    ///
    /// # Errors
    /// [`Error::Shape`] for a pose of another plant; [`Error::Argument`] names an option out of its
    /// range, or a segment without mass.
    pub fn new(rods: &Rods, pose: &Pose, options: &MotionOptions) -> Result<Self> {
        Error::check_shape("pose", (rods.len(), 4), (pose.rotations.len(), 4))?;
        options.check_ranges()?;
        let mut placed = pose.clone();
        rods.place(&mut placed);
        let middle = |v: usize| [0, 1, 2].map(|i| 0.5 * (placed.heads[v][i] + placed.tails[v][i]));
        let n = rods.len();
        let mut motion = Self {
            rods: rods.clone(),
            options: *options,
            moving: Moving {
                centres: (0..n).map(middle).collect(),
                rotations: placed.rotations,
                velocities: vec![[0.0; 3]; n],
                spins: vec![[0.0; 3]; n],
                multipliers: vec![[0.0; 6]; n],
            },
            wind: None,
            workspace: Workspace::default(),
        };
        motion.set_rods(rods)?;
        Ok(motion)
    }

    /// Continues with other masses and stiffnesses of the same plant.
    ///
    /// # Errors
    /// [`Error::Shape`] for rods of another plant; [`Error::Argument`] names a segment without
    /// mass.
    pub fn set_rods(&mut self, rods: &Rods) -> Result<()> {
        Error::check_shape("rods", (self.rods.len(), 1), (rods.len(), 1))?;
        if let Some(v) = rods.masses.iter().position(|&m| m <= 0.0) {
            let why = format!("segment {v} must have a positive mass, has {} kg", rods.masses[v]);
            return Err(Error::Argument { what: "masses", why });
        }
        self.rods = rods.clone();
        Ok(())
    }

    /// Sets the velocity of the air, in m / s. The air drags a segment of radius r, length l and
    /// leaf area A by `rho C / 2 (2 r l |u_n| u_n + A |u| u)`: u is the velocity of the air
    /// relative to the segment, u_n its component across the segment (cross-flow principle, Hoerner
    /// 1965), C is [`MotionOptions::drag`]. The factors |u| are those at the beginning of a step,
    /// and the rest is implicit, so that still air only removes energy.
    ///
    /// ```
    /// use catamaran_simulation::plant::{Elasticity, Motion, MotionOptions, RodOptions, Rods};
    /// use catamaran_simulation::plant::{WaterModel, WaterOptions, families};
    ///
    /// let plant = families::chain(5, 0.3, 2e-3)?;
    /// let full = WaterModel::new(&plant, &WaterOptions::new())?.full();
    /// let mut rods = Rods::new(&plant, &RodOptions::new())?;
    /// rods.set_state(&Elasticity::default().moduli(&full, &full)?, &full)?;
    /// let mut motion = Motion::new(&rods, &rods.rest_pose(), &MotionOptions::new())?;
    /// motion.set_wind([3.0, 0.0, 0.0])?;
    /// motion.step()?;
    /// assert!(motion.pose().tails[4][0] > 0.0); // it leans with the wind
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Argument`] for a velocity that is not finite.
    pub fn set_wind(&mut self, velocity: [f64; 3]) -> Result<()> {
        if velocity.iter().any(|x| !x.is_finite()) {
            let why = format!("the velocity must be finite, is {velocity:?}");
            return Err(Error::Argument { what: "wind", why });
        }
        self.wind = Some(velocity);
        Ok(())
    }

    /// Returns the current pose.
    pub fn pose(&self) -> Pose {
        let half = |v: usize| scale(self.along(v), 0.5);
        let n = self.rods.len();
        Pose {
            heads: (0..n).map(|v| sub(self.moving.centres[v], half(v))).collect(),
            tails: (0..n).map(|v| plus(self.moving.centres[v], half(v))).collect(),
            rotations: self.moving.rotations.clone(),
        }
    }

    /// Returns the largest gap between a segment and its parent, in metres, which is 0 for an exact
    /// solution.
    pub fn largest_gap(&self) -> f64 {
        (0..self.rods.len()).map(|v| norm(self.gap(v))).fold(0.0, f64::max)
    }

    /// Returns the energy of the current pose and velocities.
    pub fn energy(&self) -> Energy {
        let mut energy = Energy::default();
        for v in 0..self.rods.len() {
            let rotations = &self.moving.rotations;
            let parent = self.rods.parent_rotation(rotations, v);
            energy.elastic += joint::energy(&self.rods.stiffness[v], parent, rotations[v]);
            energy.weight -=
                self.rods.masses[v] * dot(self.rods.options.gravity, self.moving.centres[v]);
            if !self.rods.pinned[v] {
                let ([x, y, z], [a, b, c]) = (self.moving.velocities[v], self.moving.spins[v]);
                let velocity = [x, y, z, a, b, c];
                let momentum = image(&self.inertia(v, 1.0), &velocity);
                energy.kinetic += 0.5 * (0..6).map(|i| velocity[i] * momentum[i]).sum::<f64>();
            }
        }
        energy
    }

    /// Advances by one step. If Newton's method does not converge, as when a gust rotates twigs by
    /// more than a radian, the step is divided into two half steps, recursively: steps of any
    /// length are stable. A plant that stands still in an unstable equilibrium, as a weak stem that
    /// is upright, gets a push, always to the same side, under which it falls.
    ///
    /// # Errors
    /// [`Error::NotConverged`] when the equations are singular to rounding.
    pub fn step(&mut self) -> Result<()> {
        self.push();
        self.advance(self.options.step, MOST_HALVINGS)
    }

    /// Starts the fall of a plant that stands still in an unstable equilibrium.
    fn push(&mut self) {
        /// Spins that count as none, and those of the push, in radians per second.
        const STILL: f64 = 1e-9;
        const PUSH: f64 = 1e-3;
        if self.moving.spins.iter().all(|spin| norm(*spin) <= STILL)
            && let Some(fall) = self.rods.unstable(&self.pose())
        {
            self.moving.spins = fall.iter().map(|a| scale(*a, PUSH)).collect();
        }
    }

    fn advance(&mut self, seconds: f64, halvings: usize) -> Result<()> {
        let before = self.moving.clone();
        match self.implicit_step(seconds) {
            Ok(turn) if turn <= CONVERGED => return Ok(()),
            Ok(_) if halvings == 0 => return Ok(()),
            Err(error) if halvings == 0 || error == Error::Cancelled => {
                self.moving = before;
                return Err(error);
            }
            Ok(_) | Err(_) => {}
        }
        self.moving = before;
        self.advance(0.5 * seconds, halvings - 1)?;
        self.advance(0.5 * seconds, halvings - 1)
    }

    /// Computes a step of implicit Euler. Returns the largest rotation of its last Newton step, in
    /// radians.
    fn implicit_step(&mut self, h: f64) -> Result<f64> {
        let n = self.rods.len();
        let (centres, rotations) = (self.moving.centres.clone(), self.moving.rotations.clone());
        let gravity = self.rods.options.gravity;
        let drag = self.drag();
        for v in 0..n {
            if self.rods.pinned[v] {
                continue;
            }
            self.moving.velocities[v] = plus(self.moving.velocities[v], scale(gravity, h));
            self.moving.centres[v] = plus(centres[v], scale(self.moving.velocities[v], h));
            self.moving.rotations[v] = turned(rotations[v], scale(self.moving.spins[v], h));
        }
        let step = Step {
            seconds: h,
            start: centres,
            centres: self.moving.centres.clone(),
            rotations: self.moving.rotations.clone(),
            drag,
        };
        let mut turn = 0.0;
        for i in 0..self.options.iterations.max(1) + MORE_ITERATIONS {
            if i >= self.options.iterations.max(1) && turn <= CONVERGED {
                break;
            }
            turn = self.newton(&step)?;
        }
        let worn = (-self.options.damping * h).exp();
        for v in 0..n {
            let moved = sub(self.moving.centres[v], step.start[v]);
            let turn = product(self.moving.rotations[v], inverse(rotations[v]));
            self.moving.velocities[v] = scale(moved, worn / h);
            self.moving.spins[v] = scale(logarithm(turn), worn / h);
        }
        Ok(turn)
    }

    /// Advances by `count` steps.
    ///
    /// # Errors
    /// As [`Motion::step`]; [`Error::Cancelled`]: earlier steps are complete, and a later call can
    /// continue.
    pub fn run(&mut self, count: usize, progress: Progress<'_>) -> Result<()> {
        for done in 1..=count {
            self.step()?;
            progress.report(done as f64 / count as f64)?;
        }
        Ok(())
    }

    /// Computes one Newton iteration: `M/h^2 (X - aim) = J^T l`, `C(X) + A l = 0`. Returns the
    /// largest rotation, in radians.
    fn newton(&mut self, step: &Step) -> Result<f64> {
        let mut workspace = std::mem::take(&mut self.workspace);
        let turn = self.newton_in(step, &mut workspace);
        self.workspace = workspace;
        turn
    }

    fn newton_in(&mut self, step: &Step, workspace: &mut Workspace) -> Result<f64> {
        self.set_system(step, workspace);
        self.solve_tree(step.seconds, workspace).ok_or_else(singular)?;
        let Workspace { steps, changes, .. } = workspace;
        let turn = steps.iter().map(|s| norm([s[3], s[4], s[5]])).fold(0.0, f64::max);
        if !turn.is_finite() {
            return Err(singular());
        }
        let part = (LARGEST_TURN / turn).min(1.0);
        for (v, (step, change)) in steps.iter().zip(changes).enumerate() {
            accumulate(&mut self.moving.multipliers[v], &change.map(|x| part * x));
            let [x, y, z, a, b, c] = step.map(|x| part * x);
            self.moving.centres[v] = plus(self.moving.centres[v], [x, y, z]);
            self.moving.rotations[v] = turned(self.moving.rotations[v], [a, b, c]);
        }
        Ok(turn)
    }

    /// Sets the equations of joints and bodies.
    fn set_system(&self, step: &Step, workspace: &mut Workspace) {
        let n = self.rods.len();
        let Workspace { joints, blocks, right, .. } = workspace;
        refill(joints, (0..n).map(|v| self.joint(v)));
        refill(blocks, (0..n).map(|v| self.inertia(v, step.seconds)));
        refill(right, (0..n).map(|v| self.pull(v, &blocks[v], step)));
        for (v, drag) in step.drag.iter().enumerate() {
            let force = self.drag_force(v, drag, step);
            for i in 0..3 {
                right[v][i] += force[i];
                for j in 0..3 {
                    blocks[v][i][j] += drag[i][j] / step.seconds;
                }
            }
        }
        for v in 0..n {
            let [x, y, z, ..] = self.moving.multipliers[v];
            let force = [x, y, z];
            add_tension(&mut blocks[v], force, scale(self.along(v), -0.5));
            if let Some(p) = self.rods.parent(v) {
                add_tension(&mut blocks[p], scale(force, -1.0), scale(self.along(p), 0.5));
            }
        }
        for v in 0..n {
            let l = self.moving.multipliers[v];
            accumulate(&mut right[v], &image(&transposed(&joints[v].by_child), &l));
            if let Some(p) = self.rods.parent(v) {
                accumulate(&mut right[p], &image(&transposed(&joints[v].by_parent), &l));
            }
        }
    }

    /// Solves the equations of bodies and joints by elimination, from the tips of the tree to its
    /// root and back: computes the steps of bodies and the changes of multipliers. Returns `None`
    /// if a block is not positive definite.
    fn solve_tree(&self, seconds: f64, workspace: &mut Workspace) -> Option<()> {
        let n = self.rods.len();
        let Workspace { joints, blocks, right, joint_factors, joint_right, steps, changes } =
            workspace;
        let free = |v: usize| !self.rods.pinned[v];
        let parent = |v: usize| self.rods.parent(v).filter(|&p| free(p));
        let order = || self.rods.order.iter().map(|&v| v as usize);
        let moves = |&v: &usize| free(v) || parent(v).is_some();
        joint_factors.resize(n, [[0.0; 6]; 6]);
        joint_right.resize(n, [0.0; 6]);
        // Pinned segments have no step, whatever was here before.
        refill(steps, (0..n).map(|_| [0.0; 6]));
        refill(changes, (0..n).map(|_| [0.0; 6]));
        for v in order().rev().filter(moves) {
            let joint = &joints[v];
            let yielded = image(&joint.compliance, &self.moving.multipliers[v]);
            let mut b = [0, 1, 2, 3, 4, 5].map(|i| -joint.error[i] - yielded[i]);
            let mut block = joint.compliance;
            if free(v) {
                let body = cholesky(&blocks[v])?;
                let response = solve_matrix(&body, &transposed(&joint.by_child));
                add(&mut block, 1.0, &times(&joint.by_child, &response));
                let moved = image(&joint.by_child, &solve(&body, &right[v]));
                (0..6).for_each(|i| b[i] -= moved[i]);
                blocks[v] = body;
            } else {
                // A body that nothing moves has no compliance of its own; a trace of compliance
                // replaces it.
                let trace = 1e-9 * seconds.powi(2) / self.rods.masses[v];
                (0..3).for_each(|i| block[i][i] += trace);
            }
            let factor = cholesky(&block)?;
            if let Some(p) = parent(v) {
                let response = solve_matrix(&factor, &joint.by_parent);
                add(&mut blocks[p], 1.0, &times(&transposed(&joint.by_parent), &response));
                let up = image(&transposed(&joint.by_parent), &solve(&factor, &b));
                accumulate(&mut right[p], &up);
            }
            joint_factors[v] = factor;
            joint_right[v] = b;
        }
        for v in order().filter(moves) {
            let mut b = joint_right[v];
            if let Some(p) = parent(v) {
                let moved = image(&joints[v].by_parent, &steps[p]);
                (0..6).for_each(|i| b[i] -= moved[i]);
            }
            changes[v] = solve(&joint_factors[v], &b);
            if free(v) {
                let mut force = right[v];
                accumulate(&mut force, &image(&transposed(&joints[v].by_child), &changes[v]));
                steps[v] = solve(&blocks[v], &force);
            }
        }
        Some(())
    }

    /// Returns `M / h^2` of a cylinder.
    fn inertia(&self, v: usize, seconds: f64) -> Matrix<6> {
        let rods = &self.rods;
        let unit = rods.masses[v] / seconds.powi(2);
        let (l, r) = (rods.lengths[v], rods.radii[v]);
        let (across, along) = (l * l / 12.0 + r * r / 4.0, r * r / 2.0);
        let t = scale(self.along(v), 1.0 / l);
        let mut m = identity();
        for i in 0..3 {
            m[i][i] = unit;
            for j in 0..3 {
                let delta = if i == j { 1.0 } else { 0.0 };
                m[3 + i][3 + j] = unit * (across * (delta - t[i] * t[j]) + along * t[i] * t[j]);
            }
        }
        m
    }

    /// Returns `-M/h^2 (X - aim)`.
    fn pull(&self, v: usize, inertia: &Matrix<6>, step: &Step) -> [f64; 6] {
        let d = sub(step.centres[v], self.moving.centres[v]);
        let turn = product(step.rotations[v], inverse(self.moving.rotations[v]));
        let a = logarithm(turn);
        image(inertia, &[d[0], d[1], d[2], a[0], a[1], a[2]])
    }

    /// Returns the drag of all bodies at their current velocities.
    fn drag(&self) -> Vec<Matrix<3>> {
        let Some(wind) = self.wind else { return vec![] };
        let of = |v: usize| {
            let rods = &self.rods;
            let u = sub(wind, self.moving.velocities[v]);
            let t = scale(self.along(v), 1.0 / rods.lengths[v]);
            let across = sub(u, scale(t, dot(t, u)));
            let unit = 0.5 * AIR * self.options.drag;
            let stem = unit * 2.0 * rods.radii[v] * rods.lengths[v] * norm(across);
            let leaf = unit * rods.leaf_areas[v] * norm(u);
            let mut drag = identity();
            for i in 0..3 {
                for j in 0..3 {
                    drag[i][j] = (stem + leaf) * drag[i][j] - stem * t[i] * t[j];
                }
            }
            drag
        };
        (0..self.rods.len()).map(of).collect()
    }

    /// Returns the force of the air at the end of the step.
    fn drag_force(&self, v: usize, drag: &Matrix<3>, step: &Step) -> Vector {
        let wind = self.wind.unwrap_or_default();
        let moved = sub(self.moving.centres[v], step.start[v]);
        image(drag, &sub(wind, scale(moved, 1.0 / step.seconds)))
    }

    fn along(&self, v: usize) -> Vector {
        image(&rotation_matrix(self.moving.rotations[v]), &self.rods.rest[v])
    }

    /// Returns the vector from the end of the parent to the beginning of v.
    fn gap(&self, v: usize) -> Vector {
        let head = sub(self.moving.centres[v], scale(self.along(v), 0.5));
        match self.rods.parent(v) {
            Some(p) => sub(head, plus(self.moving.centres[p], scale(self.along(p), 0.5))),
            None => sub(head, self.rods.base),
        }
    }

    fn joint(&self, v: usize) -> Joint {
        let rods = &self.rods;
        let parent = rods.parent(v);
        let parent_rotation = parent.map_or(NO_ROTATION, |p| self.moving.rotations[p]);
        let d = difference(parent_rotation, self.moving.rotations[v]);
        let (gap, strain) = (self.gap(v), strain(d));
        let to_parent = transposed(&rotation_matrix(parent_rotation));
        let bend = times(&strain_derivative(d), &to_parent);
        let arm = |along: Vector| cross_matrix(scale(along, 0.5));
        let mut by_child = identity();
        let mut by_parent = identity();
        let above = parent.map_or([[0.0; 3]; 3], |p| arm(self.along(p)));
        let child = arm(self.along(v));
        let mut compliance = [[0.0; 6]; 6];
        let yielding =
            solve_matrix(&cholesky(&rods.stiffness[v]).unwrap_or(identity()), &identity());
        for i in 0..3 {
            by_parent[i][i] = -1.0;
            for j in 0..3 {
                by_child[i][3 + j] = child[i][j];
                by_parent[i][3 + j] = above[i][j];
                by_child[3 + i][3 + j] = bend[i][j];
                by_parent[3 + i][3 + j] = -bend[i][j];
                compliance[3 + i][3 + j] = yielding[i][j];
            }
        }
        let error = [gap[0], gap[1], gap[2], strain[0], strain[1], strain[2]];
        Joint { error, compliance, by_child, by_parent }
    }
}

/// Returns the error of equations without a solution.
fn singular() -> Error {
    Error::NotConverged { iterations: 0, residual: f64::NAN }
}

/// Adds the rotational stiffness of a force at an arm where it is positive: tension stabilizes the
/// orientation of a body (Tournier, Nesme, Gilles and Faure 2015). The term changes no equation,
/// but the convergence of Newton's method: in a storm, the tension of twigs exceeds `M/h^2`. At
/// 20 m/s the drag of a segment is 576 r l (`wind.rs`) and its mass 1100 pi r^2 l, so that at 60
/// steps a second this stiffness is 1 / (3600 r l) times that of the inertia: 55 times for a twig
/// with a radius of 0.5 mm and a length of 10 mm.
fn add_tension(body: &mut Matrix<6>, force: Vector, arm: Vector) {
    let length = norm(arm);
    let held = 0.5 * (norm(force) * length + dot(force, arm));
    let t = scale(arm, 1.0 / length);
    for i in 0..3 {
        body[3 + i][3 + i] += held;
        for j in 0..3 {
            body[3 + i][3 + j] -= held * t[i] * t[j];
        }
    }
}

/// Replaces the elements of a vector, in its memory.
fn refill<T>(vector: &mut Vec<T>, elements: impl Iterator<Item = T>) {
    vector.clear();
    vector.extend(elements);
}

fn plus(a: Vector, b: Vector) -> Vector {
    [0, 1, 2].map(|i| a[i] + b[i])
}

fn accumulate(sum: &mut [f64; 6], x: &[f64; 6]) {
    (0..6).for_each(|i| sum[i] += x[i]);
}
