//! The plant as rods: rigid segments, with joints that bend and twist but do not stretch.

mod joint;
mod motion;
mod pins;
mod small;
mod statics;

use std::f64::consts::PI;

pub use motion::{Energy, Motion, MotionOptions};
pub use statics::{RelaxOptions, Relaxation};

use self::small::{Matrix, NO_ROTATION, Quaternion, image, rotation_matrix};
use super::Plant;
use super::graph::NONE;
use catamaran::base::{Error, Result, options, positive};
use catamaran_geometry::mesh::vector::{Vector, scale, sub};

options! {
    /// The constants of rods, in SI units.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct RodOptions {
        /// Acceleration of gravity.
        gravity: [f64; 3] = [0.0, 0.0, -9.81], unit "m / s^2", range "finite";
        /// Poisson's ratio nu: the shear modulus is `E / (2 (1 + nu))`.
        poisson: f64 = 0.3, check(above -1.0, at most 0.5);
        /// Mass of a cubic metre of tissue without its water.
        dry_density: f64 = 100.0, unit "kg / m^3", check(at least 0);
    }
}

/// The positions and rotations of the segments.
#[derive(Debug, Clone, PartialEq)]
pub struct Pose {
    /// The start of each segment, in metres.
    pub heads: Vec<[f64; 3]>,
    /// The end of each segment, in metres.
    pub tails: Vec<[f64; 3]>,
    /// The rotation of each segment from the rest pose: unit quaternions (w, x, y, z).
    pub rotations: Vec<[f64; 4]>,
}

/// A plant whose segments have weight and joints stiffness. The joint of the root segment holds it
/// to the ground; pinned segments do not move, and carry the segments that hang on them.
///
/// ```
/// use catamaran_simulation::plant::{Elasticity, RelaxOptions, RodOptions, Rods};
/// use catamaran_simulation::plant::{WaterModel, WaterOptions, families};
///
/// let plant = families::grow(&families::GrowthOptions::new().nodes(50))?;
/// let full = WaterModel::new(&plant, &WaterOptions::new())?.full();
/// let mut rods = Rods::new(&plant, &RodOptions::new())?;
/// rods.set_state(&Elasticity::default().moduli(&full, &full)?, &full)?;
/// let mut pose = rods.rest_pose();
/// let found = rods.relax(&mut pose, &RelaxOptions::new())?;
/// assert!(found.residual <= 1e-8);
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Rods {
    /// The segments, every parent before its children.
    order: Vec<u32>,
    parents: Vec<u32>,
    pinned: Vec<bool>,
    base: Vector,
    /// The start of each segment in the rest pose.
    rest_heads: Vec<Vector>,
    /// The vector from head to tail in the rest pose.
    rest: Vec<Vector>,
    lengths: Vec<f64>,
    radii: Vec<f64>,
    volumes: Vec<f64>,
    leaf_areas: Vec<f64>,
    options: RodOptions,
    /// Mass of each segment, in kg.
    masses: Vec<f64>,
    /// The stiffness K of the joint to the parent, in N m.
    stiffness: Vec<Matrix<3>>,
}

impl Rods {
    /// Creates the rods of a plant. They have no weight and the stiffness of E = 1 Pa until
    /// [`Rods::set_state`].
    ///
    /// # Errors
    /// [`Error::Argument`] names an option out of its range.
    pub fn new(plant: &Plant, options: &RodOptions) -> Result<Self> {
        options.check_ranges()?;
        if options.gravity.iter().any(|x| !x.is_finite()) {
            let why = format!("must be finite, is {:?}", options.gravity);
            return Err(Error::Argument { what: "gravity", why });
        }
        let n = plant.len();
        let mut rods = Self {
            order: plant.preorder(),
            parents: plant.parents().to_vec(),
            pinned: plant.segments().iter().map(|s| s.pinned).collect(),
            base: plant.base(),
            rest_heads: (0..n).map(|v| plant.head(v)).collect(),
            rest: (0..n).map(|v| sub(plant.segments()[v].tail, plant.head(v))).collect(),
            lengths: plant.lengths().to_vec(),
            radii: plant.segments().iter().map(|s| s.radius).collect(),
            volumes: (0..n).map(|v| plant.volume(v)).collect(),
            leaf_areas: (0..n).map(|v| plant.leaf_area(v)).collect(),
            options: *options,
            masses: vec![0.0; n],
            stiffness: vec![[[0.0; 3]; 3]; n],
        };
        rods.set_moduli(&vec![1.0; n])?;
        Ok(rods)
    }

    /// Returns the number of segments.
    #[allow(clippy::len_without_is_empty)] // there is no empty plant
    pub fn len(&self) -> usize {
        self.parents.len()
    }

    /// Sets the modulus of elasticity of every segment, in Pa, and its water, in kg.
    ///
    /// # Errors
    /// [`Error::Shape`] and [`Error::Argument`] name the argument at fault; water that is negative
    /// by rounding counts as 0.
    pub fn set_state(&mut self, moduli: &[f64], water: &[f64]) -> Result<()> {
        Error::check_shape("water", (self.len(), 1), (water.len(), 1))?;
        if let Some(v) = water.iter().position(|x| !x.is_finite()) {
            return Err(Error::NonFinite { what: "water", index: (v, 0) });
        }
        self.set_moduli(moduli)?;
        for v in 0..self.len() {
            self.masses[v] = self.options.dry_density * self.volumes[v] + water[v].max(0.0);
        }
        Ok(())
    }

    /// Sets the stiffness of joints. Half of the compliance of a joint is that of half the parent,
    /// the rest that of half the child.
    fn set_moduli(&mut self, moduli: &[f64]) -> Result<()> {
        Error::check_shape("moduli", (self.len(), 1), (moduli.len(), 1))?;
        if let Some(&e) = moduli.iter().find(|e| positive("moduli", **e).is_err()) {
            return positive("moduli", e);
        }
        let shear = 2.0 * (1.0 + self.options.poisson);
        // 1 / (E I) and 1 / (G J), times half of the length, with J = 2 I.
        let half = |v: usize| {
            let bend = 0.5 * self.lengths[v] / (moduli[v] * PI * self.radii[v].powi(4) / 4.0);
            [bend, 0.5 * bend * shear]
        };
        for v in 0..self.len() {
            let [mut bend, mut twist] = half(v);
            if let Some(p) = self.parent(v) {
                let above = half(p);
                bend += above[0];
                twist += above[1];
            }
            let direction = scale(self.rest[v], 1.0 / self.lengths[v]);
            self.stiffness[v] = joint::stiffness(1.0 / bend, 1.0 / twist, direction);
        }
        Ok(())
    }

    /// Returns the rest pose, in which the plant was given.
    pub fn rest_pose(&self) -> Pose {
        let mut pose = Pose {
            heads: vec![[0.0; 3]; self.len()],
            tails: vec![[0.0; 3]; self.len()],
            rotations: vec![NO_ROTATION; self.len()],
        };
        self.place(&mut pose);
        pose
    }

    /// Returns the pose in which each segment has its rotation, a quaternion (w, x, y, z) of any
    /// length but 0.
    ///
    /// ```
    /// use catamaran_simulation::plant::{RodOptions, Rods, families};
    ///
    /// let rods = Rods::new(&families::chain(2, 0.2, 1e-3)?, &RodOptions::new())?;
    /// let half = 0.5_f64.sqrt(); // by 90 degrees around the y axis
    /// let pose = rods.pose(&[[half, 0.0, half, 0.0]; 2])?;
    /// assert!((pose.tails[1][0] - 0.2).abs() < 1e-12);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Shape`] for rotations of another plant, [`Error::NonFinite`], [`Error::Argument`]
    /// for a rotation of length 0.
    pub fn pose(&self, rotations: &[[f64; 4]]) -> Result<Pose> {
        Error::check_shape("rotations", (self.len(), 4), (rotations.len(), 4))?;
        let mut pose = self.rest_pose();
        for (v, (unit, q)) in pose.rotations.iter_mut().zip(rotations).enumerate() {
            if let Some(j) = q.iter().position(|x| !x.is_finite()) {
                return Err(Error::NonFinite { what: "rotations", index: (v, j) });
            }
            let length = q.iter().map(|x| x * x).sum::<f64>().sqrt();
            if !(length > 0.0 && length.is_finite()) {
                let why = format!("that of segment {v} must have a length above 0, has {length}");
                return Err(Error::Argument { what: "rotations", why });
            }
            *unit = q.map(|x| x / length);
        }
        self.place(&mut pose);
        Ok(pose)
    }

    fn parent(&self, v: usize) -> Option<usize> {
        Some(self.parents[v]).filter(|&p| p != NONE).map(|p| p as usize)
    }

    /// Returns the rotation of the parent of v; that of the ground is the identity.
    fn parent_rotation(&self, rotations: &[Quaternion], v: usize) -> Quaternion {
        self.parent(v).map_or(NO_ROTATION, |p| rotations[p])
    }

    /// Computes heads and tails from rotations, from the ground upwards; pinned segments are at
    /// rest.
    fn place(&self, pose: &mut Pose) {
        for &v in &self.order {
            let v = v as usize;
            let head = self.parent(v).map_or(self.base, |p| pose.tails[p]);
            let along = image(&rotation_matrix(pose.rotations[v]), &self.rest[v]);
            pose.heads[v] = head;
            pose.tails[v] = [0, 1, 2].map(|i| head[i] + along[i]);
            if self.pinned[v] {
                let rest = self.rest_heads[v];
                pose.heads[v] = rest;
                pose.tails[v] = [0, 1, 2].map(|i| rest[i] + self.rest[v][i]);
            }
        }
    }
}
