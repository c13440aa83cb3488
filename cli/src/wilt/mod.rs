//! `catamaran wilt`.

mod animation;
mod args;
mod curves;
mod fit;
mod simulation;
mod stiffness;
mod strip;
mod tables;
mod watering;

use anyhow::{Context, Result, bail};
use catamaran::base::Progress;
use catamaran::io::{Output, Overwrite};
use catamaran::mesh::io::{self as meshes, MeshFile};
use catamaran::plant::tubes;

use self::animation::write_animation;
use self::watering::write_balance;
use crate::output;
use crate::progress::Bar;
use crate::report::report;
pub use args::Args;
pub use curves::chart;
pub use simulation::{Simulation, Weather, simulate};
pub use strip::draw_strip;

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
    let file = |name: &str| Output::create(&args.output.join(name), overwrite);
    let create_folder =
        || std::fs::create_dir_all(&args.output).with_context(|| args.output.display().to_string());
    if let Some(table) = &args.fit {
        let measured = fit::read(table)?;
        let (tissue, classes) = args.tissue(&plant)?;
        let fitted = fit::run(&plant, &measured, args.fit_options(tissue), classes)?;
        create_folder()?;
        fitted.write(file)?;
        return report(format_args!("written   {}: {} files", args.output.display(), names.len()));
    }
    let bar = Bar::new("wilting");
    let simulation =
        simulate(&plant, &args.weather(&plant)?, Progress::new(&|done| bar.update(done)))?;
    drop(bar);
    let poses = &simulation.poses;
    match &simulation.effort {
        None => report(format_args!(
            "frames    {}, of at most {} Newton iterations",
            poses.len(),
            simulation.iterations
        ))?,
        Some(effort) => {
            report(format_args!(
                "frames    {}, of {} steps of {:.4} s; segments at most {:.0e} m apart",
                poses.len(),
                effort.steps,
                effort.step,
                effort.largest_gap
            ))?;
            report(format_args!(
                "step      {:.3} ms, of which {:.2} % are for the water",
                effort.milliseconds,
                100.0 * effort.water_share
            ))?;
        }
    }
    let [first, last] = [0, poses.len() - 1].map(|i| simulation.water[i].iter().sum::<f64>());
    report(format_args!("water     {:.4} g, in the end {:.4} g", 1e3 * first, 1e3 * last))?;

    let last = simulation.balance[poses.len() - 1];
    if let Some(capacity) = simulation.capacity {
        report(format_args!(
            "soil      {:.4} g in the end, of {:.4} g; {:.4} g poured, {:.4} g more drained",
            1e3 * last.soil,
            1e3 * capacity,
            1e3 * last.supplied,
            1e3 * last.drained
        ))?;
    }
    report(format_args!("leaves    lost {:.4} g", 1e3 * last.transpired))?;

    // Everything is there before the first file appears.
    create_folder()?;
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
    output::chart(file("water.svg")?, &chart(&plant, &simulation))?;
    draw_strip(&plant, &simulation, file("wilting.png")?)?;
    if args.animation {
        write_animation(&plant, poses, &args.seconds(), SIDES, file("wilting.glb")?)?;
    }
    if names.iter().any(|name| name == "balance.csv") {
        write_balance(file("balance.csv")?, &simulation.hours, &simulation.balance)?;
    }
    for (name, pose) in names.iter().filter(|name| name.starts_with("plant-")).zip(poses) {
        meshes::write(file(name)?, &MeshFile::from(tubes(&plant, pose, SIDES, 0.0)?))?;
    }
    report(format_args!("written   {}: {} files", args.output.display(), names.len()))
}
