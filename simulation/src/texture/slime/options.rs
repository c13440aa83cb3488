use catamaran::base::{Error, Result, options};

/// The method by which an agent moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TangentStep {
    /// Exact, by unfolding triangles: [`unfold`](super::unfold).
    Unfold,
    /// Projected sub-steps (thesis, algorithm 3.1): [`project`](super::project).
    Project {
        /// Number of sub-steps, at least 1.
        substeps: u32,
    },
}

/// The method by which pheromone spreads: a binomial kernel of 3 x 3, a Gaussian of standard
/// deviation 0.71 texels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Blur {
    /// In the texture only (thesis, section 3.2.3): pheromone that leaves a chart is lost to the
    /// surface, and texels that are neighbours in the texture only receive it.
    Gaussian,
    /// Across seams to the neighbouring texels on the surface; keeps the sum of all texels.
    SeamAware,
}

options! {
    /// Options of a simulation. Names and units are those of table 3.1 of the thesis, if it lists
    /// them. Lengths are in hundredths of the square root of the area of the surface, angles are in
    /// degrees, times in seconds of the simulation (docs/decisions/0013).
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Options {
        /// Number of agents.
        agents: usize = 1_000_000, range "from 0 to 2^32 - 1";
        /// Number of species; agent i belongs to species i modulo this.
        // 32 bits number the entries of their textures, of at most 16384^2 texels each.
        species: usize = 1, check(from 1 to 15);
        /// Texels of a side of the texture.
        size: usize = 2048, range "a multiple of 32 from 32 to 16384";
        /// Seed of all random numbers.
        seed: u32 = 0;
        /// Duration of a step.
        time_step: f64 = 1.0 / 30.0, unit "s", check(above 0.0, at most 1e6);
        /// Speed of agents. Table 3.1: 1 to 2.
        movement_speed: f64 = 1.5, unit "hundredths / s", check(from 0.0 to 1e6);
        /// Speed of turns.
        turn_speed: f64 = 1800.0, unit "degrees / s", check(from 0.0 to 1e6);
        /// Distance from an agent to its sensors. Table 3.1: 0.4 to 2.
        vision_distance: f64 = 1.0, unit "hundredths", check(from 0.0 to 1e6);
        /// Angle between sensors. Table 3.1: 10 to 50.
        vision_angle: f64 = 30.0, unit "degrees", check(from 0.0 to 180.0);
        /// Pheromone that evaporates; an agent deposits 1. Table 3.1: 0.2 to 1.
        evaporation_rate: f64 = 0.4, unit "1 / s", check(from 0.0 to 1e6);
        /// Number of blurs; a step does at most one.
        diffusion_rate: f64 = 6.0, unit "1 / s", check(from 0.0 to 1e6);
        /// Turns vary between 1 minus this and 1 times the turn speed.
        turn_noise: f64 = 1.0, check(from 0.0 to 1.0);
        /// The method by which agents move.
        tangent_step: TangentStep = TangentStep::Unfold;
        /// The blur.
        blur: Blur = Blur::SeamAware;
        /// Whether lengths are measured on the surface, not in the texture (thesis, section 3.2.2).
        length_rescaling: bool = true;
    }
}

/// Largest number of texels of a side.
const LARGEST: usize = 16384;

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
        self.check_ranges()?;
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
