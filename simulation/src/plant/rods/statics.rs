//! Computes the pose of least elastic and gravitational energy, by Newton's method on the rotations
//! of segments.
//!
//! Positions are sums of rotated segments along the path from the root, so zero stretch needs no
//! equation. The energy of weight is a sum over segments of the weight beyond them. With rotations
//! in space as unknowns, its Hessian has a 3 x 3 block for each segment and one for each joint: the
//! matrix of a tree, which is eliminated from the leaves in O(n).

use faer::Mat;

use super::pins::{Group, Pin, groups, pins, solve_forces, total_gap};
use super::small::{
    Matrix, add, cholesky, cross_matrix, descent, image, reciprocal, rotation_matrix, solve,
    solve_matrix, times, transposed, turned,
};
use super::{Pose, Rods, joint};
use catamaran::base::{Error, Progress, Result, options};
use catamaran::dense;
use catamaran_geometry::mesh::vector::{Vector, cross, dot, norm, scale, sub};

options! {
    /// Options of [`Rods::relax`].
    #[derive(Debug, Clone, Copy)]
    pub struct RelaxOptions<'a> {
        /// The largest torque out of balance, relative to the largest torque of a weight, and the
        /// largest rotation of the last step, in radians, that count as converged.
        tolerance: f64 = 1e-8, range "from 1e-12 to 1e-2";
        /// Number of iterations after which [`Error::NotConverged`] is returned.
        max_iterations: usize = 200;
        /// Callback for the fraction of the iterations, which may cancel.
        progress: Progress<'a> = Progress::none(), setter into;
    }
}

/// The report of [`Rods::relax`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Relaxation {
    /// Number of Newton iterations.
    pub iterations: usize,
    /// The largest torque out of balance, relative to the largest torque of a weight.
    pub residual: f64,
}

/// The largest rotation of a step, in radians.
const LARGEST_TURN: f64 = 0.7;

/// Largest number of halvings of a step.
const HALVINGS: usize = 12;

/// The quadratic model of the energy at a pose.
struct Quadratic {
    gradient: Vec<Vector>,
    diagonal: Vec<Matrix<3>>,
    /// The blocks with respect to the segment (rows) and its parent (columns).
    coupling: Vec<Matrix<3>>,
    /// The scale of the shift of each diagonal block.
    scales: Vec<f64>,
}

/// The factors of the matrix of the quadratic model.
struct Factors {
    /// L of every pivot; for a matrix that is not positive definite, the inverse of the pivot.
    pivots: Vec<Matrix<3>>,
    /// Pivot^-1 times coupling.
    couplings: Vec<Matrix<3>>,
    is_definite: bool,
}

impl Factors {
    /// Returns pivot^-1 b.
    fn divide(&self, v: usize, b: &Vector) -> Vector {
        if self.is_definite { solve(&self.pivots[v], b) } else { image(&self.pivots[v], b) }
    }
}

/// The largest torque out of balance, relative to the largest torque of a weight, and the largest
/// rotation of a step, in radians, at which a pose may be at rest where the energy is largest in
/// some direction, as an upright stem that is too weak.
const BALANCED: f64 = 1e-4;
const RESTING: f64 = 1e-3;

/// The largest rotation of the first move away from such a pose, in radians.
const TILT: f64 = 0.1;

/// Residual below which Newton's method between pins needs no shift.
const NEAR: f64 = 1e-3;

/// The equilibrium of forces of a pose.
struct Held<'a> {
    pins: &'a [Pin],
    groups: &'a [Group],
    /// The largest torque out of balance.
    residual: f64,
}

/// The result of a step without a shift.
struct Nearer {
    residual: f64,
    /// The sum of gaps at pins, in metres.
    gap: f64,
    /// The largest rotation, in radians.
    largest: f64,
}

impl Rods {
    /// Moves `pose` to an equilibrium near it; the energy decreases in every step. Unless pins hold
    /// the ends of paths, the equilibrium is stable: a weak stem that stands upright buckles.
    ///
    /// # Errors
    /// [`Error::Shape`] for a pose of another plant; [`Error::NotConverged`], in which case `pose`
    /// is the last iterate; [`Error::Cancelled`], [`Error::OutOfMemory`].
    pub fn relax(&self, pose: &mut Pose, options: &RelaxOptions<'_>) -> Result<Relaxation> {
        Error::check_shape("pose", (self.len(), 4), (pose.rotations.len(), 4))?;
        let pins = pins(self);
        let groups = groups(self, &pins);
        let mut forces = vec![[0.0; 3]; pins.len()];
        self.place(pose);
        let length = self.lengths.iter().copied().fold(0.0, f64::max);
        let mut shift = 0.0;
        let mut residual = f64::INFINITY;
        for iteration in 0..options.max_iterations {
            let fraction = iteration as f64 / options.max_iterations as f64;
            options.progress.report(fraction)?;
            let loads = self.loads(&pins, &forces);
            let quadratic = self.quadratic(pose, &loads);
            if !pins.is_empty() && residual <= NEAR {
                let at = Held { pins: &pins, groups: &groups, residual };
                if let Some(found) = self.unshifted(pose, &mut forces, &quadratic, &at)? {
                    residual = found.residual;
                    let tolerance = options.tolerance;
                    let is_small = residual <= tolerance && found.gap <= tolerance * length;
                    if is_small && found.largest <= tolerance.max(1e-6) {
                        return Ok(Relaxation { iterations: iteration + 1, residual });
                    }
                    continue;
                }
            }
            let (factors, used) = self.positive_factors(&quadratic, shift)?;
            let (step, change) = self.newton_step(pose, &quadratic, &factors, &pins, &groups)?;
            for (force, change) in forces.iter_mut().zip(&change) {
                *force = [0, 1, 2].map(|i| force[i] + change[i]);
            }
            residual = self.residual(pose, &self.loads(&pins, &forces));
            let largest = step.iter().map(|a| norm(*a)).fold(0.0, f64::max);
            let gap = total_gap(&pins, &pose.tails);
            let is_small = residual <= options.tolerance && gap <= options.tolerance * length;
            if is_small && largest <= options.tolerance.max(1e-6) && used == 0.0 {
                return Ok(Relaxation { iterations: iteration, residual });
            }
            let may_rest = residual <= BALANCED && largest <= RESTING;
            if pins.is_empty()
                && used > 0.0
                && may_rest
                && let Some(fall) = self.fall(&quadratic)
            {
                if self.tilt(pose, &fall) {
                    shift = used;
                    continue;
                }
                // All poses around a vertical axis have the same energy.
                if is_small && largest <= options.tolerance.max(1e-6) {
                    return Ok(Relaxation { iterations: iteration, residual });
                }
            }
            let taken = self.line_search(pose, &step, &quadratic.gradient, &pins, &forces);
            shift = match taken {
                Some(fraction) if fraction > 0.5 => used / 16.0,
                Some(_) => used,
                None if residual <= options.tolerance && largest <= 1e-6 => {
                    return Ok(Relaxation { iterations: iteration, residual });
                }
                None => (16.0 * used).max(1e-6),
            };
            if shift < 1e-9 {
                shift = 0.0;
            }
        }
        Err(Error::NotConverged { iterations: options.max_iterations, residual })
    }

    /// Takes a whole step of Newton's method without a shift. The forces of pins may compress the
    /// path between them. The matrix is then not positive definite, although it is so on the
    /// subspace where the ends stay, and a shift would make convergence linear. Returns `None`,
    /// without a change, unless the step comes much nearer to balance.
    fn unshifted(
        &self,
        pose: &mut Pose,
        forces: &mut [Vector],
        quadratic: &Quadratic,
        at: &Held<'_>,
    ) -> Result<Option<Nearer>> {
        const MUCH: f64 = 0.3;
        let Some(factors) = self.factors(quadratic, 0.0, false) else { return Ok(None) };
        let Held { pins, groups, residual } = *at;
        let found = self.newton_step(pose, quadratic, &factors, pins, groups);
        let (step, changes) = match found {
            Err(Error::NotConverged { .. }) => return Ok(None),
            found => found?,
        };
        let largest = step.iter().map(|a| norm(*a)).fold(0.0, f64::max);
        if largest.is_nan() || largest > LARGEST_TURN {
            return Ok(None);
        }
        let mut moved = pose.clone();
        for (v, a) in step.iter().enumerate() {
            moved.rotations[v] = turned(pose.rotations[v], *a);
        }
        self.place(&mut moved);
        let held: Vec<Vector> =
            forces.iter().zip(&changes).map(|(f, c)| [0, 1, 2].map(|i| f[i] + c[i])).collect();
        let after = self.residual(&moved, &self.loads(pins, &held));
        let gap = total_gap(pins, &moved.tails);
        if after.is_nan() || after > MUCH * residual {
            return Ok(None);
        }
        std::mem::swap(pose, &mut moved);
        forces.copy_from_slice(&held);
        Ok(Some(Nearer { residual: after, gap, largest }))
    }

    /// Returns the force at the tail of each free segment: the weight beyond it, half of its own,
    /// and the forces of pins.
    fn loads(&self, pins: &[Pin], forces: &[Vector]) -> Vec<Vector> {
        let gravity = self.options.gravity;
        let mut beyond = vec![0.0; self.len()];
        let mut loads = vec![[0.0; 3]; self.len()];
        for &v in self.order.iter().rev() {
            let v = v as usize;
            loads[v] = scale(gravity, beyond[v] + 0.5 * self.masses[v]);
            if let Some(p) = self.parent(v)
                && !self.pinned[v]
            {
                beyond[p] += beyond[v] + self.masses[v];
            }
        }
        for (pin, force) in pins.iter().zip(forces) {
            for &u in &pin.path {
                loads[u] = sub(loads[u], *force);
            }
        }
        loads
    }

    fn along(&self, pose: &Pose, v: usize) -> Vector {
        image(&rotation_matrix(pose.rotations[v]), &self.rest[v])
    }

    fn quadratic(&self, pose: &Pose, loads: &[Vector]) -> Quadratic {
        let n = self.len();
        let zero = [[0.0; 3]; 3];
        let mut gradient = vec![[0.0; 3]; n];
        let (mut diagonal, mut coupling) = (vec![zero; n], vec![zero; n]);
        let mut scales = vec![0.0; n];
        for v in 0..n {
            let parent = self.parent_rotation(&pose.rotations, v);
            let d = joint::derivatives(&self.stiffness[v], parent, pose.rotations[v]);
            let size = (0..3).map(|i| self.stiffness[v][i][i]).sum::<f64>() / 3.0;
            add(&mut diagonal[v], 1.0, &d.own);
            coupling[v] = d.mixed;
            scales[v] += size;
            gradient[v] = [0, 1, 2].map(|i| gradient[v][i] + d.gradient[i]);
            if let Some(p) = self.parent(v) {
                add(&mut diagonal[p], 1.0, &d.own);
                scales[p] += size;
                gradient[p] = sub(gradient[p], d.gradient);
            }
            // The energy of a weight is -F . y; rotated by a small a, y becomes y + a x y + a x (a
            // x y) / 2.
            let (y, f) = (self.along(pose, v), loads[v]);
            gradient[v] = sub(gradient[v], cross(y, f));
            for i in 0..3 {
                for j in 0..3 {
                    diagonal[v][i][j] -= 0.5 * (f[i] * y[j] + y[i] * f[j]);
                }
                diagonal[v][i][i] += dot(f, y);
            }
        }
        Quadratic { gradient, diagonal, coupling, scales }
    }

    /// Returns the largest torque out of balance, relative to the largest torque of a weight.
    fn residual(&self, pose: &Pose, loads: &[Vector]) -> f64 {
        let gradient = self.quadratic(pose, loads).gradient;
        let free = || (0..self.len()).filter(|&v| !self.pinned[v]);
        let torque = free().map(|v| self.lengths[v] * norm(loads[v])).fold(0.0, f64::max);
        let largest = free().map(|v| norm(gradient[v])).fold(0.0, f64::max);
        if torque > 0.0 { largest / torque } else { largest }
    }

    /// Returns the factors of the matrix, with the least of the tried shifts of the diagonal that
    /// makes it positive definite.
    fn positive_factors(&self, quadratic: &Quadratic, first: f64) -> Result<(Factors, f64)> {
        let mut shift: f64 = first;
        for _ in 0..40 {
            if let Some(factors) = self.factors(quadratic, shift, true) {
                return Ok((factors, shift));
            }
            shift = (4.0 * shift).max(1e-6);
        }
        Err(Error::NotConverged { iterations: 0, residual: shift })
    }

    /// Returns the factors of the matrix with a shift; `None` for a singular matrix, or, if
    /// `is_definite`, for one that is not positive definite.
    fn factors(&self, quadratic: &Quadratic, shift: f64, is_definite: bool) -> Option<Factors> {
        let mut pivots = quadratic.diagonal.clone();
        let mut couplings = quadratic.coupling.clone();
        for &v in self.order.iter().rev() {
            let v = v as usize;
            if self.pinned[v] {
                continue;
            }
            for i in 0..3 {
                pivots[v][i][i] += shift * quadratic.scales[v];
            }
            let pivot = if is_definite { cholesky(&pivots[v])? } else { reciprocal(&pivots[v])? };
            if let Some(p) = self.parent(v)
                && !self.pinned[p]
            {
                couplings[v] = match is_definite {
                    true => solve_matrix(&pivot, &quadratic.coupling[v]),
                    false => times(&pivot, &quadratic.coupling[v]),
                };
                let up = times(&transposed(&quadratic.coupling[v]), &couplings[v]);
                add(&mut pivots[p], -1.0, &up);
            }
            pivots[v] = pivot;
        }
        Some(Factors { pivots, couplings, is_definite })
    }

    /// Returns rotations along which the energy of a pose in balance decreases to second order, the
    /// largest of them by 1 radian; `None` if the matrix is positive definite. There are no pins.
    ///
    /// The pivot of a segment is the stiffness of the segment and of all that it bears while its
    /// parent does not turn. The segments whose pivots are the first not to be positive definite,
    /// from the leaves on, fall independently of each other.
    fn fall(&self, quadratic: &Quadratic) -> Option<Vec<Vector>> {
        let mut pivots = quadratic.diagonal.clone();
        let mut couplings = vec![[[0.0; 3]; 3]; self.len()];
        let mut falls: Vec<Option<Vector>> = vec![None; self.len()];
        let mut bears_fall = vec![false; self.len()];
        for &v in self.order.iter().rev() {
            let v = v as usize;
            let parent = self.parent(v);
            if self.pinned[v] {
                continue;
            }
            let factor = if bears_fall[v] { None } else { cholesky(&pivots[v]) };
            match (factor, parent.filter(|&p| !self.pinned[p])) {
                (Some(factor), Some(p)) => {
                    couplings[v] = solve_matrix(&factor, &quadratic.coupling[v]);
                    let up = times(&transposed(&quadratic.coupling[v]), &couplings[v]);
                    add(&mut pivots[p], -1.0, &up);
                }
                (Some(_), None) => {}
                (None, parent) => {
                    falls[v] = (!bears_fall[v]).then(|| descent(&pivots[v]));
                    if let Some(p) = parent {
                        bears_fall[p] = true;
                    }
                }
            }
        }
        falls.iter().any(Option::is_some).then(|| self.carried(&falls, &couplings))
    }

    /// Returns the rotations of all segments when some fall: those that they bear follow with the
    /// least energy, and the others stay. The largest rotation is 1.
    fn carried(&self, falls: &[Option<Vector>], couplings: &[Matrix<3>]) -> Vec<Vector> {
        let mut turns = vec![[0.0; 3]; self.len()];
        for &v in &self.order {
            let v = v as usize;
            turns[v] = match (falls[v], self.parent(v)) {
                (Some(fall), _) => fall,
                (None, Some(p)) => scale(image(&couplings[v], &turns[p]), -1.0),
                (None, None) => [0.0; 3],
            };
        }
        let largest = turns.iter().map(|a| norm(*a)).fold(0.0, f64::max);
        turns.iter().map(|a| scale(*a, 1.0 / largest)).collect()
    }

    /// Returns rotations along which the energy of a pose decreases although its torques are in
    /// balance, the largest of them by 1 radian; `None` for a pose that is stable to within
    /// rounding or out of balance, and for rods with pins.
    pub(super) fn unstable(&self, pose: &Pose) -> Option<Vec<Vector>> {
        if !pins(self).is_empty() {
            return None;
        }
        let loads = self.loads(&[], &[]);
        if self.residual(pose, &loads) > BALANCED {
            return None;
        }
        let fall = self.fall(&self.quadratic(pose, &loads))?;
        self.tilt(&mut pose.clone(), &fall).then_some(fall)
    }

    /// Turns the segments of `pose` by a part of these rotations that reduces the energy by more
    /// than rounding. Returns whether there is such a part.
    fn tilt(&self, pose: &mut Pose, rotations: &[Vector]) -> bool {
        const ROUNDING: f64 = 1e-12;
        let weights = self.loads(&[], &[]);
        let (before, size) = self.energy(pose, &weights);
        let mut moved = pose.clone();
        let mut angle = TILT;
        for _ in 0..HALVINGS {
            for (v, a) in rotations.iter().enumerate() {
                moved.rotations[v] = turned(pose.rotations[v], scale(*a, angle));
            }
            self.place(&mut moved);
            if self.energy(&moved, &weights).0 < before - ROUNDING * size {
                std::mem::swap(pose, &mut moved);
                return true;
            }
            angle *= 0.5;
        }
        false
    }

    /// Computes `H^-1 b` in place, for connected free segments, parents first.
    fn solve(&self, factors: &Factors, b: &mut [Vector], nodes: &[u32]) {
        for &v in nodes.iter().rev() {
            let v = v as usize;
            if self.pinned[v] {
                b[v] = [0.0; 3];
            } else if let Some(p) = self.parent(v).filter(|&p| !self.pinned[p]) {
                let up = image(&transposed(&factors.couplings[v]), &b[v]);
                b[p] = sub(b[p], up);
            }
        }
        for &v in nodes {
            let v = v as usize;
            if self.pinned[v] {
                continue;
            }
            b[v] = factors.divide(v, &b[v]);
            if let Some(p) = self.parent(v).filter(|&p| !self.pinned[p]) {
                b[v] = sub(b[v], image(&factors.couplings[v], &b[p]));
            }
        }
    }

    /// Returns the step of rotations, and that of the forces of pins: `H a + C^T f = -g`,
    /// `C a = -gaps`.
    fn newton_step(
        &self,
        pose: &Pose,
        quadratic: &Quadratic,
        factors: &Factors,
        pins: &[Pin],
        groups: &[Group],
    ) -> Result<(Vec<Vector>, Vec<Vector>)> {
        let mut step: Vec<Vector> = quadratic.gradient.iter().map(|g| scale(*g, -1.0)).collect();
        self.solve(factors, &mut step, &self.order);
        let mut changes = vec![[0.0; 3]; pins.len()];
        let mut column = vec![[0.0; 3]; if pins.is_empty() { 0 } else { self.len() }];
        for group in groups {
            let rows = 3 * group.pins.len();
            let mut matrix = dense::zeros(rows, rows)?;
            let mut right: Mat<f64> = dense::zeros(rows, 1)?;
            let mut columns = Vec::with_capacity(rows);
            for (j, &number) in group.pins.iter().enumerate() {
                let pin = &pins[number];
                let gap = pin.gap(&pose.tails);
                let free = self.moved(pose, pin, &step);
                for axis in 0..3 {
                    right[(3 * j + axis, 0)] = gap[axis] + free[axis];
                    group.nodes.iter().for_each(|&v| column[v as usize] = [0.0; 3]);
                    // The end moves by the sum of a x y = -[y] a.
                    for &u in &pin.path {
                        column[u] = cross_matrix(scale(self.along(pose, u), -1.0))[axis];
                    }
                    self.solve(factors, &mut column, &group.nodes);
                    for (i, &other) in group.pins.iter().enumerate() {
                        let image = self.moved(pose, &pins[other], &column);
                        (0..3).for_each(|k| matrix[(3 * i + k, 3 * j + axis)] = image[k]);
                    }
                    let values = group.nodes.iter().map(|&v| column[v as usize]);
                    columns.push(values.collect::<Vec<Vector>>());
                }
            }
            if !solve_forces(matrix, &mut right, factors.is_definite)? {
                return Err(Error::NotConverged { iterations: 0, residual: f64::NAN });
            }
            for (j, column) in columns.iter().enumerate() {
                let force = right[(j, 0)];
                for (&v, c) in group.nodes.iter().zip(column) {
                    step[v as usize] = sub(step[v as usize], scale(*c, force));
                }
            }
            for (j, &number) in group.pins.iter().enumerate() {
                changes[number] = [0, 1, 2].map(|axis| right[(3 * j + axis, 0)]);
            }
        }
        Ok((step, changes))
    }

    /// Returns the displacement of the end of a path by a step.
    fn moved(&self, pose: &Pose, pin: &Pin, step: &[Vector]) -> Vector {
        let mut sum = [0.0; 3];
        for &u in &pin.path {
            let part = cross(step[u], self.along(pose, u));
            sum = [0, 1, 2].map(|i| sum[i] + part[i]);
        }
        sum
    }

    /// Moves along the step as far as the energy plus a penalty on gaps at pins decreases; returns
    /// the fraction of the step, or `None`.
    fn line_search(
        &self,
        pose: &mut Pose,
        step: &[Vector],
        gradient: &[Vector],
        pins: &[Pin],
        forces: &[Vector],
    ) -> Option<f64> {
        let largest = step.iter().map(|a| norm(*a)).fold(0.0, f64::max);
        if largest == 0.0 {
            return None;
        }
        let price = 2.0 * forces.iter().map(|f| norm(*f)).fold(0.0, f64::max);
        let weights = self.loads(&[], &[]);
        let merit = |pose: &Pose| {
            let (energy, size) = self.energy(pose, &weights);
            (energy + price * total_gap(pins, &pose.tails), size)
        };
        let (before, size) = merit(pose);
        let slope: f64 = if pins.is_empty() {
            step.iter().zip(gradient).map(|(a, g)| dot(*a, *g)).sum()
        } else {
            // The derivative of the Lagrangian and the penalty; any decrease is accepted.
            0.0
        };
        let mut fraction = (LARGEST_TURN / largest).min(1.0);
        let mut moved = pose.clone();
        for _ in 0..HALVINGS {
            for (v, a) in step.iter().enumerate() {
                moved.rotations[v] = turned(pose.rotations[v], scale(*a, fraction));
            }
            self.place(&mut moved);
            let (after, _) = merit(&moved);
            // An increase within rounding does not count.
            if after <= before + 1e-4 * fraction * slope + 1e-13 * size {
                std::mem::swap(pose, &mut moved);
                return Some(fraction);
            }
            fraction *= 0.5;
        }
        None
    }

    /// Returns the elastic and gravitational energy, in J, and the sum of the sizes of their terms.
    fn energy(&self, pose: &Pose, weights: &[Vector]) -> (f64, f64) {
        let (mut sum, mut size) = (0.0, 0.0);
        for v in 0..self.len() {
            let parent = self.parent_rotation(&pose.rotations, v);
            let bent = joint::energy(&self.stiffness[v], parent, pose.rotations[v]);
            // Relative to the rest pose, so that small displacements lose few digits.
            let fallen = match self.pinned[v] {
                true => 0.0,
                false => -dot(weights[v], sub(self.along(pose, v), self.rest[v])),
            };
            sum += bent + fallen;
            size += bent + fallen.abs();
        }
        (sum, size)
    }
}
