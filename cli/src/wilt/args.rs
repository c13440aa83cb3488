//! The options of `catamaran wilt`, and what they ask for.

use std::path::PathBuf;

use anyhow::{Result, bail};
use catamaran::Par;
use catamaran::plant::families::{GrowthOptions, grow};
use catamaran::plant::{
    Elasticity, FitOptions, MotionOptions, Plant, Segment, Soil, Stomata, Tissue, Wind, read_with,
};
use clap::{ValueEnum, ValueHint};

use super::fit;
use super::simulation::{Film, Weather};
use super::stiffness::{ByRadius, Kappa, tissue};
use super::watering::{self, Pour};
use crate::common::{Force, Threads};
use crate::input::{self, TextFile};
use crate::parse;

/// Let a plant dry out, and bend as it does.
///
/// Computes the water of every node by the model of chapter 4 of the thesis, the stiffness that
/// follows from it, and the pose in which the plant then rests; with --motion, how it moves there.
/// The folder gets water.csv and stiffness.csv (a row for each frame: hours, total or mean, then a
/// column for each node; kg and Pa), the plant as a mesh of tubes for each frame, water.svg and
/// wilting.png; wilting.glb with --animation; balance.csv with --stomata or --soil.
#[derive(clap::Args)]
pub struct Args {
    /// The plant: .txt (`verts N`, ...), .swc, .mtg or .obj (polylines), each also as .gz or .xz.
    #[arg(value_name = "PLANT", required_unless_present = "grow")]
    plant: Option<PathBuf>,
    /// Grow a plant of so many nodes instead of reading one.
    #[arg(long, value_name = "NODES", conflicts_with = "plant")]
    grow: Option<usize>,
    /// Seed of the plant that grows, and of the gusts of --wind.
    #[arg(long, value_name = "NUMBER", default_value_t = 0)]
    seed: u64,
    /// How long.
    #[arg(long, value_name = "HOURS", default_value_t = 48.0)]
    hours: f64,
    /// What leaves lose, in grams per hour and square metre.
    #[arg(long, value_name = "LOSS", default_value_t = 60.0)]
    delta: f64,
    /// Steepness of the elasticity as a function of the relative water content; 10 unless given.
    /// Parts may have their own: `leaf=8,stem=20`, or `12,leaf=8` with that of the parts that are
    /// not named first; parts are leaf, petiole and stem. Petioles are those that the file labels
    /// (class P of .mtg), else stalks without a branch that bear a leaf. With --literal in 1/g.
    #[arg(long, value_name = "K|PART=K,...")]
    kappa: Option<Kappa>,
    /// Steepness by radius instead of by part: `0.5=12,2=30` is 12 from 0.5 mm on and 30 from 2 mm
    /// on; thinner segments have that of --kappa.
    #[arg(long, value_name = "MM=K,...")]
    kappa_by_radius: Option<ByRadius>,
    /// Relative water content at which the elasticity is steepest; 0.75 unless given. With
    /// --literal in g, 0 unless given.
    #[arg(long, value_name = "W")]
    shift: Option<f64>,
    /// Elasticity by equation 4.9 of the thesis, literally: a logistic of the grams in a node, and
    /// the first number of --elasticity times that. A segment that is cut in two changes its
    /// stiffness.
    #[arg(long, requires = "kappa")]
    literal: bool,
    /// Modulus of elasticity of full cells and of dry ones, in Pa.
    #[arg(long, value_name = "FULL,DRY", default_value = "5e7,3e5", value_parser = pair)]
    elasticity: [f64; 2],
    /// Conductance, as a part of that of a pipe as wide as the segment: calibrates how far a plant
    /// dries unevenly.
    #[arg(long, value_name = "CHI", default_value_t = 1e-9)]
    conductance: f64,
    /// By day (16 hours) leaves lose --delta, by night (8 hours) a twelfth of it.
    #[arg(long)]
    day_night: bool,
    /// Stomata that close as leaves dry: half closed at this relative water content, and so
    /// steeply; 0.8,25 is usual.
    #[arg(long, value_name = "W,STEEPNESS", value_parser = watering::stomata)]
    stomata: Option<Stomata>,
    /// Soil at the root that holds so many grams of water, and has as many at first unless given:
    /// the root takes it up.
    #[arg(long, value_name = "GRAMS[,AT_FIRST]", value_parser = watering::soil)]
    soil: Option<Soil>,
    /// Pour so many grams on the soil after so many hours, or as much as it holds; what it can't
    /// hold drains. May be given again.
    #[arg(long, value_name = "HOURS[:GRAMS]", requires = "soil")]
    rewater: Vec<Pour>,
    /// Cut the connection of this node to its parent, for water, not for the rod. May be given
    /// again.
    #[arg(long, value_name = "NODE")]
    cut: Vec<usize>,
    /// Multiply the conductance of the connection of a node to its parent. May be given again.
    #[arg(long, value_name = "NODE,FACTOR", value_parser = pair)]
    weaken: Vec<[f64; 2]>,
    /// Hold this node where it is, beside those that the file says. May be given again.
    #[arg(long, value_name = "NODE")]
    pin: Vec<usize>,
    /// Let the plant move, and show all --hours in a film of so many seconds: in every step water
    /// is lost, and the rods go ahead with the stiffness and the weight of that moment.
    #[arg(long, value_name = "SECONDS")]
    motion: Option<f64>,
    /// Steps of a second of --motion, at least.
    #[arg(long, value_name = "NUMBER", default_value_t = 60.0, requires = "motion")]
    fps: f64,
    /// The rate at which --motion wears off, in 1/s.
    #[arg(long, value_name = "RATE", default_value_t = 1.0, requires = "motion")]
    damping: f64,
    /// Wind in --motion, in m/s; z is upwards. 0,0,0 is still air, which drags at what moves.
    #[arg(long, value_name = "X,Y,Z", value_parser = triple, allow_hyphen_values = true, requires = "motion")]
    wind: Option<[f64; 3]>,
    /// Standard deviation of the --wind in each direction, as a part of its speed.
    #[arg(long, value_name = "PART", default_value_t = 0.2, requires = "wind")]
    turbulence: f64,
    /// Frames after the first one, at equal times.
    #[arg(long, value_name = "NUMBER", default_value_t = 24, value_parser = parse::frame_count)]
    frames: usize,
    /// Write wilting.glb: the plant as a skinned mesh that moves, for Blender; of 24 frames a
    /// second without --motion.
    #[arg(long)]
    pub animation: bool,
    /// Find delta, chi (--conductance) and kappa from a table of a plant that dries from full cells
    /// on: the columns `time_h,weight_g`, with or without the pot, then `height_m` (of its highest
    /// point) and `node_12_m` (of node 12), any number of them or none. Writes fit.csv, fitted.csv
    /// and fit.svg, and lets nothing wilt. kappa needs heights: weights do not depend on it. With
    /// --kappa by parts or radii, that of each is found. `-` is stdin.
    #[arg(
        long,
        value_name = "TABLE",
        value_hint = ValueHint::FilePath,
        conflicts_with_all = ["motion", "animation", "cut", "weaken", "literal", "stomata", "soil"]
    )]
    pub fit: Option<TextFile>,
    /// Kind of the meshes.
    #[arg(long, default_value = "ply")]
    mesh: Kind,
    /// The folder for all files.
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
    #[command(flatten)]
    threads: Threads,
    #[command(flatten)]
    pub force: Force,
}

/// Kinds of mesh files.
#[derive(Debug, Clone, Copy, ValueEnum)]
enum Kind {
    Obj,
    Ply,
    /// No meshes.
    None,
}

/// Three numbers.
fn triple(text: &str) -> Result<[f64; 3], String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|x| x.trim().parse().ok()).collect();
    let three = numbers.and_then(|numbers| <[f64; 3]>::try_from(numbers).ok());
    three.ok_or_else(|| "three numbers with commas between them".into())
}

/// Two numbers.
fn pair(text: &str) -> Result<[f64; 2], String> {
    let numbers = text.split_once(',').map(|(a, b)| (a.trim().parse(), b.trim().parse()));
    match numbers {
        Some((Ok(a), Ok(b))) => Ok([a, b]),
        _ => Err("two numbers with a comma between them".into()),
    }
}

impl Args {
    /// The plant that was read or has grown, with its pins.
    pub fn plant(&self) -> Result<Plant> {
        let plant = match (&self.plant, self.grow) {
            (Some(path), _) => read_with(path, &input::source())?,
            (None, nodes) => {
                grow(&GrowthOptions::new().nodes(nodes.unwrap_or_default()).seed(self.seed))?
            }
        };
        if self.pin.is_empty() {
            return Ok(plant);
        }
        let mut segments: Vec<Segment> = plant.segments().to_vec();
        for &node in &self.pin {
            match segments.get_mut(node) {
                Some(segment) => segment.pinned = true,
                None => bail!("--pin: node {node} of {} (numbered from 0)", plant.len()),
            }
        }
        let parents: Vec<Option<u32>> =
            (0..plant.len()).map(|v| plant.parent(v).map(|p| p as u32)).collect();
        Ok(Plant::new(segments, &parents, Some(plant.base()))?)
    }

    /// What it goes through.
    pub fn weather(&self, plant: &Plant) -> Result<Weather> {
        if !(self.hours > 0.0 && self.hours.is_finite()) {
            bail!("--hours: {}, where a positive number is needed", self.hours);
        }
        let mut damage: Vec<(usize, f64)> = self.cut.iter().map(|&node| (node, 0.0)).collect();
        for &[node, factor] in &self.weaken {
            if node.fract() != 0.0 || node < 0.0 || node >= plant.len() as f64 {
                bail!("--weaken: node {node} of {} (numbered from 0)", plant.len());
            }
            damage.push((node as usize, factor));
        }
        if self.motion.is_some() && self.frames == 0 {
            bail!("--frames: 0, where --motion needs at least 1");
        }
        Ok(Weather {
            hours: self.hours,
            frames: self.frames,
            loss: self.delta,
            nights: self.day_night,
            conductance: self.conductance,
            tissue: self.tissue(plant)?.0,
            stomata: self.stomata,
            soil: self.soil,
            rewatering: self.rewater.iter().map(|pour| pour.0).collect(),
            damage,
            film: self.film()?,
            par: self.par(),
        })
    }

    /// What the plant is made of, and a name for the steepness of each class.
    pub fn tissue(&self, plant: &Plant) -> Result<(Tissue, Vec<String>)> {
        const STEEPNESS: f64 = 10.0;
        let [full, dry] = self.elasticity;
        let of = |steepness| match self.literal {
            true => Elasticity::Literal { full, steepness, shift: self.shift.unwrap_or(0.0) },
            false => {
                Elasticity::Relative { dry, full, steepness, shift: self.shift.unwrap_or(0.75) }
            }
        };
        tissue(plant, self.kappa.as_ref(), self.kappa_by_radius.as_ref(), STEEPNESS, of)
    }

    fn film(&self) -> Result<Option<Film>> {
        let Some(seconds) = self.motion else { return Ok(None) };
        for (name, value) in [("--motion", seconds), ("--fps", self.fps)] {
            if !(value > 0.0 && value.is_finite()) {
                bail!("{name}: {value}, where a positive number is needed");
            }
        }
        let most = 1e7;
        if seconds * self.fps > most {
            bail!("--motion: more than {most} steps");
        }
        let wind =
            |velocity| Wind::new().velocity(velocity).turbulence(self.turbulence).seed(self.seed);
        let motion = MotionOptions::new().step(1.0 / self.fps).damping(self.damping);
        Ok(Some(Film { seconds, motion, wind: self.wind.map(wind) }))
    }

    /// How constants are fitted.
    pub fn fit_options(&self, tissue: Tissue) -> FitOptions<'static> {
        FitOptions::new().elasticity(tissue).nights(self.day_night).par(self.par())
    }

    fn par(&self) -> Par {
        self.threads.par()
    }

    /// When each frame is in a film, in seconds.
    pub fn seconds(&self) -> Vec<f64> {
        /// Of frames that are not of a film.
        const FRAMES_PER_SECOND: f64 = 24.0;
        let count = self.frames.max(1) as f64;
        let last = self.motion.unwrap_or(count / FRAMES_PER_SECOND);
        (0..=self.frames).map(|i| last * i as f64 / count).collect()
    }

    /// The files of a run.
    pub fn names(&self) -> Vec<String> {
        if self.fit.is_some() {
            return fit::NAMES.map(String::from).into();
        }
        let mut names: Vec<String> =
            ["water.csv", "stiffness.csv", "water.svg", "wilting.png"].map(String::from).into();
        if self.animation {
            names.push("wilting.glb".into());
        }
        if self.stomata.is_some() || self.soil.is_some() {
            names.push("balance.csv".into());
        }
        let ending = match self.mesh {
            Kind::Obj => "obj",
            Kind::Ply => "ply",
            Kind::None => return names,
        };
        let digits = self.frames.to_string().len().max(3);
        names.extend((0..=self.frames).map(|i| format!("plant-{i:0digits$}.{ending}")));
        names
    }
}
