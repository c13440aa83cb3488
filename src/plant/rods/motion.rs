//! Rods that move: implicit Euler, with the direct solver for stiff rods of Deul, Kugelstadt, Weiler and Bender (2018).
//!
//! A body per segment, of six unknowns, and a joint per segment, of six equations: three for zero stretch, three for bending
//! and twisting with the compliance K^-1. In the tree of bodies and joints the matrix of a Newton step is eliminated from the
//! leaves by blocks, `L D L^T` without fill-in.

use super::joint::{difference, strain, strain_derivative};
use super::small::{
    Matrix, NO_ROTATION, Quaternion, add, cholesky, cross_matrix, identity, image, inverse,
    logarithm, product, rotation_matrix, solve, solve_matrix, times, transposed, turned,
};
use super::{Pose, Rods};
use crate::base::{Error, Progress, Result, builder};
use crate::mesh::vector::{Vector, norm, scale, sub};
use crate::plant::water::{at_least_zero, positive};

/// Options of [`Motion`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct MotionOptions {
    /// Seconds of a step. Default 1 / 60.
    pub step: f64,
    /// Newton iterations of a step, at most. Default 3.
    pub iterations: usize,
    /// The rate at which velocities wear off, in 1 / s. Default 1.
    pub damping: f64,
}

impl Default for MotionOptions {
    fn default() -> Self {
        Self { step: 1.0 / 60.0, iterations: 3, damping: 1.0 }
    }
}

builder! { MotionOptions {
    step: f64,
    iterations: usize,
    damping: f64,
}}

/// Rods in motion.
///
/// ```
/// use catamaran::plant::{Elasticity, Motion, MotionOptions, RodOptions, Rods};
/// use catamaran::plant::{WaterModel, WaterOptions, families};
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
/// // It sinks, and its segments stay together.
/// let height = |tails: &[[f64; 3]]| tails.iter().map(|p| p[2]).sum::<f64>();
/// assert!(height(&motion.pose().tails) < height(&start.tails));
/// assert!(motion.largest_gap() < 1e-4);
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Motion {
    rods: Rods,
    options: MotionOptions,
    /// The middle of every segment.
    centres: Vec<Vector>,
    rotations: Vec<Quaternion>,
    velocities: Vec<Vector>,
    /// Angular.
    spins: Vec<Vector>,
    /// Forces and torques of joints.
    multipliers: Vec<[f64; 6]>,
}

/// The equations of the joint of a segment.
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
    /// [`Error::Shape`] for a pose of another plant; [`Error::Argument`] names an option out of its range, or a segment
    /// without weight.
    pub fn new(rods: &Rods, pose: &Pose, options: &MotionOptions) -> Result<Self> {
        Error::check_shape("pose", (rods.len(), 4), (pose.rotations.len(), 4))?;
        positive("step", options.step)?;
        at_least_zero("damping", options.damping)?;
        let mut placed = pose.clone();
        rods.place(&mut placed);
        let middle = |v: usize| [0, 1, 2].map(|i| 0.5 * (placed.heads[v][i] + placed.tails[v][i]));
        let n = rods.len();
        let mut motion = Self {
            rods: rods.clone(),
            options: *options,
            centres: (0..n).map(middle).collect(),
            rotations: placed.rotations,
            velocities: vec![[0.0; 3]; n],
            spins: vec![[0.0; 3]; n],
            multipliers: vec![[0.0; 6]; n],
        };
        motion.set_rods(rods)?;
        Ok(motion)
    }

    /// Goes on with other weights and stiffnesses of the same plant.
    ///
    /// # Errors
    /// [`Error::Shape`] for rods of another plant; [`Error::Argument`] names a segment without weight.
    pub fn set_rods(&mut self, rods: &Rods) -> Result<()> {
        Error::check_shape("rods", (self.rods.len(), 1), (rods.len(), 1))?;
        if let Some(v) = rods.masses.iter().position(|&m| m <= 0.0) {
            let why =
                format!("segment {v} weighs {} kg: what moves must have weight", rods.masses[v]);
            return Err(Error::Argument { what: "masses", why });
        }
        self.rods = rods.clone();
        Ok(())
    }

    /// The present pose.
    pub fn pose(&self) -> Pose {
        let half = |v: usize| scale(self.along(v), 0.5);
        let n = self.rods.len();
        Pose {
            heads: (0..n).map(|v| sub(self.centres[v], half(v))).collect(),
            tails: (0..n).map(|v| plus(self.centres[v], half(v))).collect(),
            rotations: self.rotations.clone(),
        }
    }

    /// The largest gap between a segment and what it grows on, in metres: what is left of zero stretch.
    pub fn largest_gap(&self) -> f64 {
        (0..self.rods.len()).map(|v| norm(self.gap(v))).fold(0.0, f64::max)
    }

    /// Goes one step ahead.
    ///
    /// # Errors
    /// [`Error::NotConverged`] when the equations are singular to rounding.
    pub fn step(&mut self) -> Result<()> {
        let h = self.options.step;
        let n = self.rods.len();
        let (centres, rotations) = (self.centres.clone(), self.rotations.clone());
        let gravity = self.rods.options.gravity;
        for v in 0..n {
            if self.rods.pinned[v] {
                continue;
            }
            self.velocities[v] = plus(self.velocities[v], scale(gravity, h));
            self.centres[v] = plus(centres[v], scale(self.velocities[v], h));
            self.rotations[v] = turned(rotations[v], scale(self.spins[v], h));
        }
        let aims = (self.centres.clone(), self.rotations.clone());
        for _ in 0..self.options.iterations.max(1) {
            self.newton(&aims)?;
        }
        let worn = (-self.options.damping * h).exp();
        for v in 0..n {
            let moved = sub(self.centres[v], centres[v]);
            let turn = product(self.rotations[v], inverse(rotations[v]));
            self.velocities[v] = scale(moved, worn / h);
            self.spins[v] = scale(logarithm(turn), worn / h);
        }
        Ok(())
    }

    /// Goes `count` steps ahead.
    ///
    /// # Errors
    /// As those of [`Motion::step`]; [`Error::Cancelled`]: the steps before are done then, and it can go on.
    pub fn run(&mut self, count: usize, progress: Progress<'_>) -> Result<()> {
        for done in 1..=count {
            self.step()?;
            progress.report(done as f64 / count as f64)?;
        }
        Ok(())
    }

    /// One Newton iteration: `M/h^2 (X - aim) = J^T l`, `C(X) + A l = 0`.
    fn newton(&mut self, aims: &(Vec<Vector>, Vec<Quaternion>)) -> Result<()> {
        let n = self.rods.len();
        let singular = |_| Error::NotConverged { iterations: 0, residual: f64::NAN };
        let mut bodies: Vec<Matrix<6>> = (0..n).map(|v| self.inertia(v)).collect();
        let mut right: Vec<[f64; 6]> = (0..n).map(|v| self.pull(v, &bodies[v], aims)).collect();
        let joints: Vec<Joint> = (0..n).map(|v| self.joint(v)).collect();
        for v in 0..n {
            let l = self.multipliers[v];
            accumulate(&mut right[v], &image(&transposed(&joints[v].by_child), &l));
            if let Some(p) = self.rods.parent(v) {
                accumulate(&mut right[p], &image(&transposed(&joints[v].by_parent), &l));
            }
        }
        // Of every joint: the factor of its block, its right-hand side, and those of bodies.
        let mut joint_factors = vec![[[0.0; 6]; 6]; n];
        let mut joint_right = vec![[0.0; 6]; n];
        for &v in self.rods.order.iter().rev() {
            let v = v as usize;
            let joint = &joints[v];
            let free = !self.rods.pinned[v];
            let parent = self.rods.parent(v).filter(|&p| !self.rods.pinned[p]);
            if !free && parent.is_none() {
                continue;
            }
            let l = self.multipliers[v];
            let yielded = image(&joint.compliance, &l);
            let mut b = [0, 1, 2, 3, 4, 5].map(|i| -joint.error[i] - yielded[i]);
            let mut block = joint.compliance;
            if free {
                let body = cholesky(&bodies[v]).ok_or(()).map_err(singular)?;
                let response = solve_matrix(&body, &transposed(&joint.by_child));
                add(&mut block, 1.0, &times(&joint.by_child, &response));
                let moved = image(&joint.by_child, &solve(&body, &right[v]));
                (0..6).for_each(|i| b[i] -= moved[i]);
                bodies[v] = body;
            } else {
                // A body that nothing moves: a trace of compliance instead of its own.
                let trace = 1e-9 * self.options.step.powi(2) / self.rods.masses[v];
                (0..3).for_each(|i| block[i][i] += trace);
            }
            let factor = cholesky(&block).ok_or(()).map_err(singular)?;
            if let Some(p) = parent {
                let response = solve_matrix(&factor, &joint.by_parent);
                add(&mut bodies[p], 1.0, &times(&transposed(&joint.by_parent), &response));
                let up = image(&transposed(&joint.by_parent), &solve(&factor, &b));
                accumulate(&mut right[p], &up);
            }
            joint_factors[v] = factor;
            joint_right[v] = b;
        }
        let mut steps = vec![[0.0; 6]; n];
        for &v in &self.rods.order {
            let v = v as usize;
            let free = !self.rods.pinned[v];
            let parent = self.rods.parent(v).filter(|&p| !self.rods.pinned[p]);
            if !free && parent.is_none() {
                continue;
            }
            let mut b = joint_right[v];
            if let Some(p) = parent {
                let moved = image(&joints[v].by_parent, &steps[p]);
                (0..6).for_each(|i| b[i] -= moved[i]);
            }
            let change = solve(&joint_factors[v], &b);
            accumulate(&mut self.multipliers[v], &change);
            if free {
                let mut force = right[v];
                accumulate(&mut force, &image(&transposed(&joints[v].by_child), &change));
                steps[v] = solve(&bodies[v], &force);
            }
        }
        for v in 0..n {
            let [x, y, z, a, b, c] = steps[v];
            self.centres[v] = plus(self.centres[v], [x, y, z]);
            self.rotations[v] = turned(self.rotations[v], [a, b, c]);
        }
        Ok(())
    }

    /// `M / h^2` of a cylinder.
    fn inertia(&self, v: usize) -> Matrix<6> {
        let rods = &self.rods;
        let unit = rods.masses[v] / self.options.step.powi(2);
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

    /// `-M/h^2 (X - aim)`.
    fn pull(
        &self,
        v: usize,
        inertia: &Matrix<6>,
        (centres, rotations): &(Vec<Vector>, Vec<Quaternion>),
    ) -> [f64; 6] {
        let d = sub(centres[v], self.centres[v]);
        let turn = product(rotations[v], inverse(self.rotations[v]));
        let a = logarithm(turn);
        image(inertia, &[d[0], d[1], d[2], a[0], a[1], a[2]])
    }

    fn along(&self, v: usize) -> Vector {
        image(&rotation_matrix(self.rotations[v]), &self.rods.rest[v])
    }

    /// From the end of the parent to the beginning of v.
    fn gap(&self, v: usize) -> Vector {
        let head = sub(self.centres[v], scale(self.along(v), 0.5));
        match self.rods.parent(v) {
            Some(p) => sub(head, plus(self.centres[p], scale(self.along(p), 0.5))),
            None => sub(head, self.rods.base),
        }
    }

    fn joint(&self, v: usize) -> Joint {
        let rods = &self.rods;
        let parent = rods.parent(v);
        let parent_rotation = parent.map_or(NO_ROTATION, |p| self.rotations[p]);
        let d = difference(parent_rotation, self.rotations[v]);
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

fn plus(a: Vector, b: Vector) -> Vector {
    [0, 1, 2].map(|i| a[i] + b[i])
}

fn accumulate(sum: &mut [f64; 6], x: &[f64; 6]) {
    (0..6).for_each(|i| sum[i] += x[i]);
}
