use catamaran::base::{Error, Result, builder, within};

/// The method by which an agent moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum TangentStep {
    /// Exact, by unfolding triangles: [`unfold`](super::unfold).
    #[default]
    Unfold,
    /// Projected sub-steps (thesis, algorithm 3.1): [`project`](super::project).
    Project {
        /// Number of sub-steps, at least 1.
        substeps: u32,
    },
}

/// The method by which pheromone spreads: a binomial kernel of 3 x 3, a Gaussian of standard
/// deviation 0.71 texels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Blur {
    /// In the texture only (thesis, section 3.2.3): pheromone that leaves a chart is lost to the
    /// surface, and texels that are neighbours in the texture only receive it.
    Gaussian,
    /// Across seams to the neighbouring texels on the surface; keeps the sum of all texels.
    #[default]
    SeamAware,
}

/// Options of a simulation. Names and units are those of table 3.1 of the thesis, if it lists them.
/// Lengths are in hundredths of the square root of the area of the surface, angles are in degrees,
/// times in seconds of the simulation (docs/decisions/0015). Speeds, distances and rates are at
/// most 10^6.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Options {
    /// Number of agents, at most 2^32 - 1. Default 1,000,000.
    pub agents: usize,
    /// Number of species, from 1 to 15; agent i belongs to species i modulo this. Default 1.
    pub species: usize,
    /// Texels of a side of the texture: a multiple of 32, at most 16384. Default 2048.
    pub size: usize,
    /// Seed of all random numbers. Default 0.
    pub seed: u32,
    /// Duration of a step in seconds, above 0 and at most 10^6. Default 1 / 30.
    pub time_step: f64,
    /// Speed of agents, in hundredths a second, at least 0. Table 3.1: 1 to 2. Default 1.5.
    pub movement_speed: f64,
    /// Speed of turns, in degrees a second, at least 0. Default 1800.
    pub turn_speed: f64,
    /// Distance from an agent to its sensors, in hundredths, at least 0. Table 3.1: 0.4 to 2.
    /// Default 1.
    pub vision_distance: f64,
    /// Angle between sensors, in degrees, from 0 to 180. Table 3.1: 10 to 50. Default 30.
    pub vision_angle: f64,
    /// Pheromone that evaporates in a second, at least 0; an agent deposits 1. Table 3.1: 0.2 to 1.
    /// Default 0.4.
    pub evaporation_rate: f64,
    /// Number of blurs a second, at least 0; a step does at most one. Default 6.
    pub diffusion_rate: f64,
    /// Turns vary between 1 minus this and 1 times the turn speed, from 0 to 1. Default 1.
    pub turn_noise: f64,
    /// The method by which agents move; default [`TangentStep::Unfold`].
    pub tangent_step: TangentStep,
    /// The blur; default [`Blur::SeamAware`].
    pub blur: Blur,
    /// Whether lengths are measured on the surface, not in the texture (thesis, section 3.2.2).
    /// Default yes.
    pub length_rescaling: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            agents: 1_000_000,
            species: 1,
            size: 2048,
            seed: 0,
            time_step: 1.0 / 30.0,
            movement_speed: 1.5,
            turn_speed: 1800.0,
            vision_distance: 1.0,
            vision_angle: 30.0,
            evaporation_rate: 0.4,
            diffusion_rate: 6.0,
            turn_noise: 1.0,
            tangent_step: TangentStep::default(),
            blur: Blur::default(),
            length_rescaling: true,
        }
    }
}

builder! { Options {
    agents: usize,
    species: usize,
    size: usize,
    seed: u32,
    time_step: f64,
    movement_speed: f64,
    turn_speed: f64,
    vision_distance: f64,
    vision_angle: f64,
    evaporation_rate: f64,
    diffusion_rate: f64,
    turn_noise: f64,
    tangent_step: TangentStep,
    blur: Blur,
    length_rescaling: bool,
}}

/// Largest number of texels of a side.
const LARGEST: usize = 16384;
/// Largest duration, speed, distance and rate.
const MOST: f64 = 1e6;
/// Largest number of species: 32 bits number the entries of their textures.
const MOST_SPECIES: usize = 15;

impl Options {
    /// Returns an error unless every value is in its range.
    ///
    /// ```
    /// use catamaran_simulation::texture::slime::Options;
    ///
    /// assert!(Options::new().agents(1000).size(128).check().is_ok());
    /// assert!(Options::new().size(100).check().is_err()); // not a multiple of 32
    /// ```
    ///
    /// # Errors
    /// [`Error::Argument`] names the value.
    pub fn check(&self) -> Result<()> {
        let refused = |what: &'static str, got: String, range: &str| -> Result<()> {
            Err(Error::Argument { what, why: format!("must be {range}, is {got}") })
        };
        if u32::try_from(self.agents).is_err() {
            return refused("agents", self.agents.to_string(), "from 0 to 2^32 - 1");
        }
        if self.size == 0 || !self.size.is_multiple_of(32) || self.size > LARGEST {
            return refused("size", self.size.to_string(), "a multiple of 32 from 32 to 16384");
        }
        if !(1..=MOST_SPECIES).contains(&self.species) {
            return refused("species", self.species.to_string(), "from 1 to 15");
        }
        if !(self.time_step > 0.0 && self.time_step <= MOST) {
            let range = format!("above 0 and at most {MOST}");
            return refused("time_step", self.time_step.to_string(), &range);
        }
        within("movement_speed", self.movement_speed, 0.0, MOST)?;
        within("turn_speed", self.turn_speed, 0.0, MOST)?;
        within("vision_distance", self.vision_distance, 0.0, MOST)?;
        within("vision_angle", self.vision_angle, 0.0, 180.0)?;
        within("evaporation_rate", self.evaporation_rate, 0.0, MOST)?;
        within("diffusion_rate", self.diffusion_rate, 0.0, MOST)?;
        within("turn_noise", self.turn_noise, 0.0, 1.0)?;
        match self.tangent_step {
            TangentStep::Project { substeps: 0 } => refused("substeps", "0".into(), "at least 1"),
            _ => Ok(()),
        }
    }

    /// Returns the options in the form that the kernels read.
    ///
    /// # Errors
    /// As [`Options::check`].
    pub fn parameters(&self) -> Result<Parameters> {
        self.check()?;
        let rotation = |degrees: f64| {
            let (sin, cos) = degrees.to_radians().sin_cos();
            [cos as f32, sin as f32]
        };
        let turn = |i: usize| {
            let part = (i as f64 + 0.5) / TURNS as f64;
            rotation(self.turn_speed * self.time_step * (1.0 - self.turn_noise * part))
        };
        let (substeps, parts) = match self.tangent_step {
            TangentStep::Unfold => (0, 1.0),
            TangentStep::Project { substeps } => (substeps, f64::from(substeps)),
        };
        Ok(Parameters {
            seed: self.seed,
            size: self.size as u32,
            species: self.species as u32,
            substeps,
            rescale: u32::from(self.length_rescaling),
            seam_aware: u32::from(self.blur == Blur::SeamAware),
            sense: (self.vision_distance / 100.0 / parts) as f32,
            advance: (self.movement_speed * self.time_step / 100.0 / parts) as f32,
            vision: rotation(self.vision_angle),
            turns: std::array::from_fn(turn),
            attraction: (self.species + 1) as f32,
            blend: (self.diffusion_rate * self.time_step).min(1.0) as f32,
            evaporation: (self.evaporation_rate * self.time_step) as f32,
        })
    }
}

/// The number of rotations in [`Parameters::turns`], a power of two.
pub const TURNS: usize = 64;

/// The options in the form that the kernels read: lengths in the unit of the surface, rotations as
/// (cosine, sine), rates per step.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct Parameters {
    /// Seed of all random numbers.
    pub seed: u32,
    /// Texels of a side.
    pub size: u32,
    /// Number of species.
    pub species: u32,
    /// Number of sub-steps of a walk, each of length `sense` or `advance`; 0 for unfolding.
    pub substeps: u32,
    /// 1 if lengths are measured on the surface, 0 in the texture.
    pub rescale: u32,
    /// 1 if the blur crosses seams.
    pub seam_aware: u32,
    /// Distance from an agent to its sensors, or that of a sub-step if there are any.
    pub sense: f32,
    /// Distance that an agent moves, or that of a sub-step if there are any.
    pub advance: f32,
    /// The rotation to the sensor on the left.
    pub vision: [f32; 2],
    /// Rotations to the left, one of which an agent selects at random.
    pub turns: [[f32; 2]; TURNS],
    /// The value that an attractor adds to what agents sense.
    pub attraction: f32,
    /// The share of the pheromone that is blurred.
    pub blend: f32,
    /// The pheromone that evaporates.
    pub evaporation: f32,
}
