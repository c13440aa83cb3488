//! `catamaran wilt`.

mod curves;
mod simulation;
mod strip;
mod tables;

use std::num::NonZeroUsize;
use std::path::PathBuf;

use anyhow::{Context, Result, bail};
use catamaran::Par;
use catamaran::base::Progress;
use catamaran::io::{Output, Overwrite};
use catamaran::mesh::io::{self as meshes, MeshFile};
use catamaran::plant::families::{GrowthOptions, grow};
use catamaran::plant::{Plant, Segment, read_with, tubes};
use clap::ValueEnum;

use crate::input;
use crate::parse;
use crate::picture::write_chart;
use crate::progress::Bar;
use crate::report::report;
pub use curves::chart;
pub use simulation::{Simulation, Weather, simulate};
pub use strip::draw_strip;

/// Let a plant dry out, and bend as it does.
///
/// Computes the water of every node by the model of chapter 4 of the thesis, the stiffness that follows from it, and the pose
/// in which the plant then rests. The folder gets water.csv and stiffness.csv (a row for each frame: hours, total or mean,
/// then a column for each node; kg and Pa), the plant as a mesh of tubes for each frame, water.svg and wilting.png.
#[derive(clap::Args)]
pub struct Args {
    /// The plant: .txt (`verts N`, ...), .swc, .mtg or .obj (polylines), each also as .gz or .xz.
    #[arg(value_name = "PLANT", required_unless_present = "grow")]
    plant: Option<PathBuf>,
    /// Grow a plant of so many nodes instead of reading one.
    #[arg(long, value_name = "NODES", conflicts_with = "plant")]
    grow: Option<usize>,
    /// Seed of the plant that grows.
    #[arg(long, value_name = "NUMBER", default_value_t = 0, requires = "grow")]
    seed: u64,
    /// How long.
    #[arg(long, value_name = "HOURS", default_value_t = 48.0)]
    hours: f64,
    /// What leaves lose, in grams per hour and square metre.
    #[arg(long, value_name = "LOSS", default_value_t = 60.0)]
    delta: f64,
    /// Steepness of the elasticity as a function of the relative water content.
    #[arg(long, value_name = "NUMBER", default_value_t = 10.0)]
    kappa: f64,
    /// Relative water content at which the elasticity is steepest.
    #[arg(long, value_name = "W", default_value_t = 0.75)]
    shift: f64,
    /// Modulus of elasticity of full cells and of dry ones, in Pa.
    #[arg(long, value_name = "FULL,DRY", default_value = "5e7,3e5", value_parser = pair)]
    elasticity: [f64; 2],
    /// Conductance, as a part of that of a pipe as wide as the segment: calibrates how far a plant dries unevenly.
    #[arg(long, value_name = "CHI", default_value_t = 1e-9)]
    conductance: f64,
    /// By day (16 hours) leaves lose --delta, by night (8 hours) a twelfth of it.
    #[arg(long)]
    day_night: bool,
    /// Cut the connection of this node to its parent, for water, not for the rod. May be given again.
    #[arg(long, value_name = "NODE")]
    cut: Vec<usize>,
    /// Multiply the conductance of the connection of a node to its parent. May be given again.
    #[arg(long, value_name = "NODE,FACTOR", value_parser = pair)]
    weaken: Vec<[f64; 2]>,
    /// Hold this node where it is, beside those that the file says. May be given again.
    #[arg(long, value_name = "NODE")]
    pin: Vec<usize>,
    /// Frames after the first one, at equal times.
    #[arg(long, value_name = "NUMBER", default_value_t = 24, value_parser = parse::frame_count)]
    frames: usize,
    /// Kind of the meshes.
    #[arg(long, default_value = "ply")]
    mesh: Kind,
    /// The folder for all files.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Threads; all cores unless given. The result does not depend on it.
    #[arg(long, value_name = "NUMBER")]
    threads: Option<NonZeroUsize>,
    /// Replace files that exist.
    #[arg(long)]
    force: bool,
}

/// Kinds of mesh files.
#[derive(Debug, Clone, Copy, ValueEnum)]
enum Kind {
    Obj,
    Ply,
    /// No meshes.
    None,
}

/// Two numbers.
fn pair(text: &str) -> Result<[f64; 2], String> {
    let numbers = text.split_once(',').map(|(a, b)| (a.trim().parse(), b.trim().parse()));
    match numbers {
        Some((Ok(a), Ok(b))) => Ok([a, b]),
        _ => Err("two numbers with a comma between them".into()),
    }
}

/// Sides of a tube.
const SIDES: usize = 6;

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    let overwrite = if args.force { Overwrite::Replace } else { Overwrite::Never };
    let plant = args.plant()?;
    let names = args.names();
    if !args.force
        && let Some(name) =
            names.iter().find(|name| args.output.join(name).symlink_metadata().is_ok())
    {
        bail!("{}: exists already (--force replaces it)", args.output.join(name).display());
    }
    let leaves = plant.segments().iter().filter(|s| s.leaf).count();
    report(format_args!("plant     {} nodes, {leaves} of them on leaves", plant.len()))?;
    let bar = Bar::new("wilting");
    let simulation =
        simulate(&plant, &args.weather(&plant)?, Progress::new(&|done| bar.update(done)))?;
    drop(bar);
    let poses = &simulation.poses;
    report(format_args!(
        "frames    {}, of at most {} Newton iterations",
        poses.len(),
        simulation.iterations
    ))?;
    let [first, last] = [0, poses.len() - 1].map(|i| simulation.water[i].iter().sum::<f64>());
    report(format_args!("water     {:.4} g, in the end {:.4} g", 1e3 * first, 1e3 * last))?;

    // Everything is there before the first file appears.
    std::fs::create_dir_all(&args.output).with_context(|| args.output.display().to_string())?;
    let file = |name: &str| Output::create(&args.output.join(name), overwrite);
    tables::write(file("water.csv")?, &simulation.hours, "total_kg", &simulation.water, |row| {
        row.iter().sum()
    })?;
    tables::write(
        file("stiffness.csv")?,
        &simulation.hours,
        "mean_pa",
        &simulation.moduli,
        |row| row.iter().sum::<f64>() / row.len() as f64,
    )?;
    write_chart(file("water.svg")?, &chart(&plant, &simulation))?;
    draw_strip(&plant, &simulation, file("wilting.png")?)?;
    for (name, pose) in names.iter().filter(|name| name.starts_with("plant-")).zip(poses) {
        meshes::write(file(name)?, &MeshFile::from(tubes(&plant, pose, SIDES, 0.0)?))?;
    }
    report(format_args!("written   {}: {} files", args.output.display(), names.len()))
}

impl Args {
    fn plant(&self) -> Result<Plant> {
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

    fn weather(&self, plant: &Plant) -> Result<Weather> {
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
        let [full, dry] = self.elasticity;
        Ok(Weather {
            hours: self.hours,
            frames: self.frames,
            loss: self.delta,
            nights: self.day_night,
            conductance: self.conductance,
            elasticity: catamaran::plant::Elasticity::Relative {
                dry,
                full,
                steepness: self.kappa,
                shift: self.shift,
            },
            damage,
            par: self.threads.map_or_else(Par::all, |n| Par::Threads(n.get())),
        })
    }

    /// The files of a run.
    fn names(&self) -> Vec<String> {
        let mut names: Vec<String> =
            ["water.csv", "stiffness.csv", "water.svg", "wilting.png"].map(String::from).into();
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
