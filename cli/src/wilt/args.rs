//! The options of `catamaran wilt`, and the settings of the library that follow from them.

use std::path::PathBuf;

use anyhow::{Context, Result, anyhow, bail};
use catamaran::{Error, Par};
use catamaran_simulation::plant::families::{GrowthOptions, grow};
use catamaran_simulation::plant::{
    Conductivity, Elasticity, FitOptions, LeafOptions, MotionOptions, Plant, ReadOptions, Segment,
    Soil, Stomata, Tissue, WaterOptions, Wind, read_with,
};
use clap::{ArgGroup, ValueEnum, ValueHint};

use super::leaves::Request;
use super::simulation::{Film, Weather};
use super::stiffness::{ByRadius, Kappa, tissue, used};
use super::watering::{self, Pour};
use super::{ANIMATION, BALANCE, FRAME, fit};
use crate::common::{Force, Threads};
use crate::defaults::{Numbers, stated};
use crate::input::{self, TextFile};
use crate::parse;
use crate::report::note;

/// Grams in a kilogram.
const GRAMS: f64 = 1e3;

/// The grams of water at which the elasticity of --literal is steepest, by default.
const LITERAL_SHIFT: f64 = 0.0;

/// The options that --fit has no use for.
const NOT_FITTED: [&str; 17] = [
    "hours",
    "delta",
    "conductance",
    "literal",
    "stomata",
    "soil",
    "rewater",
    "block_flow",
    "weaken",
    "motion",
    "steps_per_second",
    "damping",
    "wind",
    "turbulence",
    "frames",
    "animation",
    "mesh",
];

/// The options that a fit to leaves, which has no plant, has no use for.
const NOT_OF_LEAVES: [&str; 11] = [
    "plant",
    "individual",
    "unit",
    "grow",
    "kappa",
    "kappa_by_radius",
    "steepest_at",
    "elasticity",
    "day_night",
    "hold",
    "seed",
];

/// Simulate a plant that dries and bends.
///
/// Computes the water of every node by the model of chapter 4 of the thesis, the stiffness that
/// follows from it, and the pose at rest; with --motion, how the plant moves. The folder gets
/// water.csv and stiffness.csv (a row for each frame: hours, total or mean, then a column for each
/// node; kg and Pa), the plant as a mesh of tubes for each frame, water.svg and wilting.png;
/// wilting.glb with --animation; balance.csv with --stomata or --soil.
#[derive(clap::Args)]
#[command(group = ArgGroup::new("random").args(["grow", "wind"]).multiple(true))]
pub struct Args {
    /// The plant: .txt (`verts N`, ...), .swc, .mtg or .obj (polylines), each also packed (.gz,
    /// .xz, .bz2, .zst, .zip).
    #[arg(value_name = "PLANT", required_unless_present_any = ["grow", "weather"])]
    plant: Option<PathBuf>,
    /// The name of one of several plants in an .mtg file, such as P3.
    #[arg(long, value_name = "NAME", conflicts_with = "grow")]
    individual: Option<String>,
    /// Metres in a unit of the file's lengths and, after a comma, of its radii and diameters, if
    /// they have another unit: 0.01,0.001 for centimetres and millimetres.
    #[arg(long, value_name = "METRES[,METRES]", value_parser = unit, conflicts_with = "grow")]
    unit: Option<[f64; 2]>,
    /// Generate a plant with this number of nodes instead of reading one.
    #[arg(
        long,
        value_name = "NODES",
        conflicts_with = "plant",
        value_parser = parse::at_least_one
    )]
    grow: Option<usize>,
    /// Seed of the generated plant, and of the gusts of --wind.
    #[arg(
        long,
        value_name = "NUMBER",
        default_value_t = GrowthOptions::default().seed,
        requires = "random"
    )]
    seed: u64,
    /// Simulated time, in hours.
    #[arg(long, value_name = "HOURS", default_value_t = 48.0, value_parser = parse::positive)]
    hours: f64,
    /// Water loss of leaves, in g/(h m^2).
    #[arg(
        long,
        value_name = "LOSS",
        default_value_t = per_hour(WaterOptions::default().loss),
        value_parser = parse::at_least_zero
    )]
    delta: f64,
    #[arg(
        long,
        value_name = "K|PART=K,...",
        help = stated(
            "Steepness of the elasticity as a function of the relative water content. Parts \
             (leaf, petiole and stem) may have separate values: `leaf=8,stem=20`, or `12,leaf=8` \
             with a first value for all other parts. Petioles are those that the file labels \
             (class P of .mtg), else stalks without a branch that bear a leaf. With --literal in \
             1/g",
            Constants::usual().steepness
        )
    )]
    kappa: Option<Kappa>,
    /// Steepness by radius instead of by part: `0.5=12,2=30` is 12 from a radius of 0.5 mm on and
    /// 30 from 2 mm on; thinner segments have that of --kappa.
    #[arg(long, value_name = "MM=K,...")]
    kappa_by_radius: Option<ByRadius>,
    #[arg(
        long,
        value_name = "W",
        value_parser = parse::finite,
        help = stated(
            "Relative water content at which the elasticity is steepest; with --literal the grams \
             of water",
            format_args!("{}; with --literal {LITERAL_SHIFT}", Constants::usual().shift)
        )
    )]
    steepest_at: Option<f64>,
    /// Use equation 4.9 of the thesis as printed: the elasticity is the first number of
    /// --elasticity times a logistic function of the grams of water in a node. Cutting a segment in
    /// two then changes its stiffness.
    #[arg(long, requires = "kappa")]
    literal: bool,
    /// Modulus of elasticity of full cells and of dry ones, in Pa.
    #[arg(
        long,
        value_name = "FULL,DRY",
        default_value_t = Constants::usual().moduli,
        value_parser = |text: &str| parse::finite_numbers::<2>(text).map(Numbers)
    )]
    elasticity: Numbers<2>,
    /// Conductance, as a fraction of that of a pipe as wide as the segment: determines how unevenly
    /// a plant dries.
    #[arg(
        long,
        value_name = "CHI",
        default_value_t = conductance(),
        value_parser = |text: &str| parse::positive(text).map(|scale| Numbers([scale]))
    )]
    conductance: Numbers<1>,
    /// Alternate days (16 hours), in which leaves lose --delta, and nights (8 hours), in which they
    /// lose a twelfth of it.
    #[arg(long)]
    day_night: bool,
    #[arg(
        long,
        value_name = "W,STEEPNESS[,CUTICULAR]",
        value_parser = watering::stomata,
        help = format!(
            "Close stomata as leaves dry: they are half closed at the relative water content W, \
             and close more abruptly with a larger STEEPNESS; {},{} is usual. Through the cuticle \
             full leaves lose the part CUTICULAR of --delta, 0 by default",
            Stomata::default().half,
            Stomata::default().steepness
        )
    )]
    stomata: Option<Stomata>,
    /// Give the root soil that holds at most GRAMS of water, and AT_FIRST in the beginning (GRAMS
    /// by default); the root takes the water up.
    #[arg(long, value_name = "GRAMS[,AT_FIRST]", value_parser = watering::soil)]
    soil: Option<Soil>,
    /// Water the soil after HOURS with GRAMS (by default with as much as it holds); the excess
    /// drains. May be given several times.
    #[arg(long, value_name = "HOURS[:GRAMS]", requires = "soil")]
    rewater: Vec<Pour>,
    /// Block the flow of water between this node and its parent; the rod stays whole. May be given
    /// several times.
    #[arg(long, value_name = "NODE")]
    block_flow: Vec<usize>,
    /// Multiply the conductance between a node and its parent. May be given several times.
    #[arg(long, value_name = "NODE,FACTOR", value_parser = weakening)]
    weaken: Vec<(usize, f64)>,
    /// Hold this node in place, as well as those that the file pins. May be given several times.
    #[arg(long, value_name = "NODE")]
    hold: Vec<usize>,
    /// Simulate the motion of the plant, and show all --hours in a film of this length, in seconds.
    /// In every step the water advances, and then the rods with the stiffness and the weight of
    /// that moment.
    #[arg(long, value_name = "SECONDS", value_parser = parse::positive)]
    motion: Option<f64>,
    /// Least number of steps per second of --motion.
    #[arg(
        long,
        value_name = "NUMBER",
        default_value_t = MotionOptions::default().step.recip(),
        requires = "motion",
        value_parser = parse::positive
    )]
    steps_per_second: f64,
    /// Decay rate of velocities in --motion, in 1/s.
    #[arg(
        long,
        value_name = "RATE",
        default_value_t = MotionOptions::default().damping,
        requires = "motion",
        value_parser = parse::at_least_zero
    )]
    damping: f64,
    /// Wind in --motion, in m/s, with z upwards; 0,0,0 is still air, which slows down moving parts
    /// [default: no air].
    #[arg(
        long,
        value_name = "X,Y,Z",
        value_parser = parse::finite_numbers::<3>,
        allow_hyphen_values = true,
        requires = "motion"
    )]
    wind: Option<[f64; 3]>,
    /// Standard deviation of the --wind in each direction, as a fraction of its speed.
    #[arg(
        long,
        value_name = "PART",
        default_value_t = Wind::default().turbulence,
        requires = "wind",
        value_parser = parse::at_least_zero
    )]
    turbulence: f64,
    /// Number of frames after the first one, at equal times.
    #[arg(long, value_name = "NUMBER", default_value_t = 24, value_parser = parse::frame_count)]
    frames: usize,
    /// Write wilting.glb: the plant as a skinned mesh that moves, for Blender; without --motion it
    /// has 24 frames per second.
    #[arg(long)]
    pub animation: bool,
    /// Fit delta, chi (--conductance) and kappa to a table of a plant that dries, starting from
    /// full cells, instead of a simulation. Columns are `time_h,weight_g`, with or without the pot,
    /// then optionally `height_m` (of the highest point) and any number of columns such as
    /// `node_12_m` (of node 12). Writes fit.csv, fitted.csv and fit.svg. Only heights determine
    /// kappa: weights do not depend on it. With --kappa by parts, or --kappa-by-radius, each kappa
    /// is fitted. `-` reads stdin.
    #[arg(
        long,
        value_name = "TABLE",
        value_hint = ValueHint::FilePath,
        conflicts_with_all = NOT_FITTED
    )]
    pub fit: Option<TextFile>,
    /// Fit leaves that were cut and dry on a scale, instead of a plant: --fit is then a table of
    /// weights, and this one of the air around them. Columns are those of the R package pvldcurve:
    /// sample, dry.weight, fresh.weight.saturated and fresh.weight in g, leaf.area of one side in
    /// cm^2, date.and.time, and optionally treatment and fw.plateau; here date.and.time,
    /// temperature in degrees Celsius and humidity in %. Leaves of a treatment share the
    /// conductance of the cuticle and the steepness of the closing of stomata.
    #[arg(
        long,
        value_name = "TABLE",
        value_hint = ValueHint::FilePath,
        requires = "fit",
        conflicts_with_all = NOT_FITTED,
        conflicts_with_all = NOT_OF_LEAVES
    )]
    weather: Option<TextFile>,
    /// Pressure-volume curves of leaves of the same treatments: stomata close near the points where
    /// their turgor is lost. Columns are sample, fresh.weight, dry.weight, fresh.weight.saturated,
    /// water.potential and optionally treatment.
    #[arg(
        long,
        value_name = "TABLE",
        value_hint = ValueHint::FilePath,
        requires = "weather",
        conflicts_with_all = NOT_FITTED,
        conflicts_with_all = NOT_OF_LEAVES
    )]
    pressure_volume: Option<TextFile>,
    /// Leaves of --fit that are not fitted: the model of the others predicts them.
    #[arg(
        long,
        value_name = "SAMPLE,...",
        value_delimiter = ',',
        requires = "weather",
        conflicts_with_all = NOT_FITTED,
        conflicts_with_all = NOT_OF_LEAVES
    )]
    unseen: Vec<String>,
    /// The error of a weight of leaves, in g. A warning names larger differences from the model.
    #[arg(
        long,
        value_name = "GRAMS",
        default_value_t = rounded_grams(LeafOptions::default().instrument),
        requires = "weather",
        conflicts_with_all = NOT_FITTED,
        conflicts_with_all = NOT_OF_LEAVES,
        value_parser = parse::positive
    )]
    instrument: f64,
    /// Format of the meshes.
    #[arg(long, default_value = "ply")]
    mesh: Kind,
    /// Output folder.
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
    #[command(flatten)]
    threads: Threads,
    #[command(flatten)]
    pub force: Force,
}

/// The constants of the default elasticity.
struct Constants {
    /// With full cells, and dry.
    moduli: Numbers<2>,
    steepness: f64,
    shift: f64,
}

impl Constants {
    fn usual() -> Self {
        match Elasticity::default() {
            Elasticity::Relative { dry, full, steepness, shift } => {
                Self { moduli: Numbers([full, dry]), steepness, shift }
            }
            other => unreachable!("{other:?} is no default for --elasticity"),
        }
    }
}

/// Returns the conductance that is used by default.
fn conductance() -> Numbers<1> {
    match WaterOptions::default().conductivity {
        Conductivity::Pipe { scale } => Numbers([scale]),
        other => unreachable!("{other:?} is no default for --conductance"),
    }
}

/// Converts a loss from kg / (s m^2) to g / (h m^2).
fn per_hour(loss: f64) -> f64 {
    3.6e6 * loss
}

/// Converts kg to g, rounded to a microgram.
fn rounded_grams(kilograms: f64) -> f64 {
    (1e9 * kilograms).round() / 1e6
}

/// Formats of meshes.
#[derive(Debug, Clone, Copy, ValueEnum)]
enum Kind {
    Obj,
    Ply,
    /// No meshes.
    None,
}

/// Parses a node and a factor.
fn weakening(text: &str) -> Result<(usize, f64), String> {
    let parts = text.split_once(',').map(|(a, b)| (a.trim().parse(), parse::at_least_zero(b)));
    match parts {
        Some((Ok(node), Ok(factor))) => Ok((node, factor)),
        _ => Err("expected a node and a factor of at least 0, such as 12,0.1".into()),
    }
}

/// Parses `METRES` or `METRES,METRES`: the units of lengths and of radii.
fn unit(text: &str) -> Result<[f64; 2], String> {
    let (length, radius) = text.split_once(',').unwrap_or((text, text));
    Ok([parse::positive(length)?, parse::positive(radius)?])
}

impl Args {
    /// Returns what errors call the plant: its file, or the option that generates it.
    pub fn name(&self) -> String {
        match &self.plant {
            Some(path) => path.display().to_string(),
            None => format!("--grow {}", self.grow.unwrap_or_default()),
        }
    }

    /// Names the plant, and the options that an error of the library is about.
    pub fn refused(&self, error: anyhow::Error) -> anyhow::Error {
        let values = [self.hours, self.delta, self.conductance.0[0]];
        let [hours, delta, chi] = values.map(|x| Numbers([x]));
        let error = match error.downcast() {
            Ok(Error::Argument { what: "seconds", why }) => {
                anyhow!("--hours {hours}, --delta {delta}, --conductance {chi}: seconds {why}")
            }
            Ok(error) => error.into(),
            Err(error) => error,
        };
        error.context(self.name())
    }

    /// Reads or generates the plant, and pins the nodes of --hold.
    pub fn plant(&self) -> Result<Plant> {
        let plant = match &self.plant {
            Some(path) => {
                let mut options = ReadOptions::new().source(input::source());
                options.individual = self.individual.as_deref();
                options.unit = self.unit.unwrap_or(options.unit);
                let plant = read_with(path, &options)?;
                for line in plant.notes() {
                    note(format_args!("{}: {line}", path.display()));
                }
                plant
            }
            None => {
                let options = GrowthOptions::new().nodes(self.grow.unwrap_or_default());
                grow(&options.seed(self.seed)).with_context(|| self.name())?
            }
        };
        if self.hold.is_empty() {
            return Ok(plant);
        }
        let mut segments: Vec<Segment> = plant.segments().to_vec();
        for &node in &self.hold {
            self.check_node("--hold", node, &plant)?;
            segments[node].pinned = true;
        }
        let parents: Vec<Option<u32>> =
            (0..plant.len()).map(|v| plant.parent(v).map(|p| p as u32)).collect();
        Ok(Plant::new(segments, &parents, Some(plant.base()))?)
    }

    /// Refuses a node of an option that the plant does not have.
    fn check_node(&self, option: &str, node: usize, plant: &Plant) -> Result<()> {
        if node >= plant.len() {
            let (name, count) = (self.name(), plant.len());
            bail!("{option} {node}: {name} has {count} nodes, numbered from 0");
        }
        Ok(())
    }

    /// Returns the nodes of --block-flow and --weaken, and the factors of the conductance to their
    /// parents.
    fn damage(&self, plant: &Plant) -> Result<Vec<(usize, f64)>> {
        let blocked = self.block_flow.iter().map(|&node| ("--block-flow", node, 0.0));
        let weakened = self.weaken.iter().map(|&(node, factor)| ("--weaken", node, factor));
        let mut damage = Vec::new();
        for (option, node, factor) in blocked.chain(weakened) {
            self.check_node(option, node, plant)?;
            if plant.parent(node).is_none() {
                bail!("{option} {node}: the root of {} has no parent", self.name());
            }
            damage.push((node, factor));
        }
        Ok(damage)
    }

    /// Returns the conditions of the simulation.
    pub fn weather(&self, plant: &Plant) -> Result<Weather> {
        /// Days at most: the library walks through 10^6 changes of the loss, one after the other.
        const DAYS: f64 = 5e5;
        let days = self.hours / 24.0;
        if self.day_night && days > DAYS {
            let hours = self.hours;
            bail!("--hours {hours}, --day-night: {days:.1e} days and nights; at most {DAYS:.0e}");
        }
        let seconds = 3600.0 * self.hours;
        if let Some(Pour(late)) = self.rewater.iter().find(|pour| pour.0.seconds > seconds) {
            let (hour, hours) = (late.seconds / 3600.0, self.hours);
            bail!("--rewater {hour}: is after the end (--hours {hours})");
        }
        Ok(Weather {
            hours: self.hours,
            frames: self.frames,
            loss: self.delta,
            nights: self.day_night,
            conductance: self.conductance.0[0],
            tissue: self.tissue(plant)?.0,
            stomata: self.stomata,
            soil: self.soil,
            rewatering: self.rewater.iter().map(|pour| pour.0).collect(),
            damage: self.damage(plant)?,
            film: self.film()?,
            par: self.par(),
        })
    }

    /// Returns the tissue of the plant, and a name for the steepness of each class.
    pub fn tissue(&self, plant: &Plant) -> Result<(Tissue, Vec<String>)> {
        let Constants { steepness: usual, shift, .. } = Constants::usual();
        let Numbers([full, dry]) = self.elasticity;
        let (is_right, needed) = match self.literal {
            true => (full > 0.0, "FULL must be above 0"),
            false => (dry > 0.0 && full > dry, "DRY must be above 0, and FULL above DRY"),
        };
        if !is_right {
            bail!("--elasticity {full},{dry}: {needed}");
        }
        let shift = self.steepest_at.unwrap_or(if self.literal { LITERAL_SHIFT } else { shift });
        let of = |steepness| match self.literal {
            true => Elasticity::Literal { full, steepness, shift },
            false => Elasticity::Relative { dry, full, steepness, shift },
        };
        let (kappa, by_radius) = (self.kappa.as_ref(), self.kappa_by_radius.as_ref());
        let (tissue, classes) = tissue(plant, kappa, by_radius, usual, of)?;
        for elasticity in tissue.classes() {
            // Of no segment: the constants are checked.
            elasticity.moduli(&[], &[]).context("--kappa, --steepest-at")?;
        }
        used(plant, &tissue, classes).with_context(|| self.name())
    }

    fn film(&self) -> Result<Option<Film>> {
        let Some(seconds) = self.motion else { return Ok(None) };
        let most = 1e7;
        if seconds * self.steps_per_second > most {
            bail!("--motion, --steps-per-second: more than {most} steps");
        }
        let wind =
            |velocity| Wind::new().velocity(velocity).turbulence(self.turbulence).seed(self.seed);
        let motion = MotionOptions::new().step(1.0 / self.steps_per_second).damping(self.damping);
        Ok(Some(Film { seconds, motion, wind: self.wind.map(wind) }))
    }

    /// Returns what is fitted to leaves, if leaves are to be fitted instead of a plant.
    pub fn leaves(&self) -> Option<Request<'_>> {
        Some(Request {
            drying: self.fit.as_ref()?,
            weather: self.weather.as_ref()?,
            curves: self.pressure_volume.as_ref(),
            unseen: &self.unseen,
            instrument: self.instrument / GRAMS,
        })
    }

    /// Returns the options of the fit.
    pub fn fit_options(&self, tissue: Tissue) -> FitOptions<'static> {
        FitOptions::new().elasticity(tissue).nights(self.day_night).par(self.par())
    }

    fn par(&self) -> Par {
        self.threads.par()
    }

    /// Returns the time of each frame in the film, in seconds.
    pub fn seconds(&self) -> Vec<f64> {
        /// Frames per second without --motion.
        const FRAMES_PER_SECOND: f64 = 24.0;
        let count = self.frames as f64;
        let last = self.motion.unwrap_or(count / FRAMES_PER_SECOND);
        (0..=self.frames).map(|i| last * i as f64 / count).collect()
    }

    /// Returns the names of the files of a run.
    pub fn names(&self) -> Vec<String> {
        if self.fit.is_some() {
            return fit::NAMES.map(String::from).into();
        }
        let mut names: Vec<String> =
            ["water.csv", "stiffness.csv", "water.svg", "wilting.png"].map(String::from).into();
        if self.animation {
            names.push(ANIMATION.into());
        }
        if self.stomata.is_some() || self.soil.is_some() {
            names.push(BALANCE.into());
        }
        let ending = match self.mesh {
            Kind::Obj => "obj",
            Kind::Ply => "ply",
            Kind::None => return names,
        };
        let digits = self.frames.to_string().len().max(3);
        names.extend((0..=self.frames).map(|i| format!("{FRAME}{i:0digits$}.{ending}")));
        names
    }
}
