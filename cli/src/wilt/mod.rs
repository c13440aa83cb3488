//! `catamaran wilt`.

mod animation;
mod args;
mod curves;
mod fit;
mod leaves;
mod simulation;
mod stiffness;
mod strip;
mod tables;
mod watering;

use anyhow::Result;
use catamaran::base::Progress;
use catamaran_geometry::mesh::io::MeshFile;
use catamaran_simulation::plant::{Balance, tubes};

use self::animation::write_animation;
use self::watering::write_balance;
use crate::folder::{Folder, note_older};
use crate::output;
use crate::picture::write_chart;
use crate::progress::Bar;
use crate::report::{note, report, status};
pub use args::Args;
pub use curves::chart;
use simulation::Effort;
pub use simulation::{Simulation, Weather, simulate};
pub use strip::draw_strip;

/// Number of sides of a tube.
const SIDES: usize = 6;

/// The beginning of the names of meshes, before the number of the frame.
const FRAME: &str = "plant-";

/// The files that a simulation writes on request only.
const ANIMATION: &str = "wilting.glb";
const BALANCE: &str = "balance.csv";

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    let names = args.names();
    names.iter().try_for_each(|name| args.force.check(&args.output.join(name)))?;
    let _folder = Folder::create(&args.output, &names[0])?;
    let file = |name: &str| args.force.create(&args.output.join(name));
    if let Some(request) = args.leaves() {
        let groups = leaves::read(&request)?;
        leaves::run(&groups, &request)?.write(file)?;
        return report_written(args, names.len());
    }
    let plant = args.plant()?;
    let leaves = plant.segments().iter().filter(|s| s.leaf).count();
    let nodes = plant.len();
    status!(
        "plant",
        nodes = nodes,
        leaves = leaves;
        "{nodes} nodes, {leaves} of them on leaves"
    )?;
    if leaves == 0 {
        note(format_args!("{}: no leaves, which alone lose water: nothing wilts", args.name()));
    }
    if let Some(table) = &args.fit {
        let measured = fit::read(table)?;
        let (tissue, classes) = args.tissue(&plant)?;
        let what = format!("{}, fitted to {}", args.name(), table.name());
        let fitted = fit::run(&plant, &measured, args.fit_options(tissue), classes, &what)?;
        fitted.write(file)?;
        return report_written(args, names.len());
    }
    let weather = args.weather(&plant)?;
    if args.animation {
        animation::check(&plant, weather.frames)?;
    }
    let is_mesh = |end: &str| [".obj", ".ply"].contains(&end);
    note_older(&args.output, "frames", FRAME, is_mesh, &names);
    note_other_results(args, &names);
    let bar = Bar::new("wilting");
    let simulation = simulate(&plant, &weather, Progress::new(&|done| bar.update(done)))
        .map_err(|error| args.refused(error))?;
    drop(bar);
    let poses = &simulation.poses;
    report_frames(&simulation)?;
    report_water(&simulation)?;

    // All results are computed before the first file appears.
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
    if args.animation {
        write_animation(&plant, poses, &args.seconds(), SIDES, file(ANIMATION)?)?;
    }
    if names.iter().any(|name| name == BALANCE) {
        write_balance(file(BALANCE)?, &simulation.hours, &simulation.balance)?;
    }
    for (name, pose) in names.iter().filter(|name| name.starts_with(FRAME)).zip(poses) {
        output::mesh(file(name)?, &MeshFile::from(tubes(&plant, pose, SIDES, 0.0)?))?;
    }
    report_written(args, names.len())
}

/// Notes the results of an earlier run that stay beside those of this one.
fn note_other_results(args: &Args, names: &[String]) {
    let is_older = |name: &&str| {
        names.iter().all(|written| written != name) && args.output.join(name).exists()
    };
    let older: Vec<&str> = [ANIMATION, BALANCE].into_iter().filter(is_older).collect();
    if !older.is_empty() {
        let (folder, names) = (args.output.display(), older.join(", "));
        note(format_args!("{folder}: files that this run does not write stay: {names}"));
    }
}

fn report_written(args: &Args, files: usize) -> Result<()> {
    let folder = args.output.display().to_string();
    status!("written", path = folder, files = files; "{folder}: {files} files")
}

/// Reports how the frames were computed.
fn report_frames(simulation: &Simulation) -> Result<()> {
    let (frames, iterations) = (simulation.poses.len(), simulation.iterations);
    let Some(effort) = &simulation.effort else {
        return status!(
            "frames",
            count = frames,
            largest_iterations = iterations;
            "{frames}, with at most {iterations} Newton iterations each"
        );
    };
    let Effort { steps, step, largest_gap, milliseconds, water_share } = *effort;
    status!(
        "frames",
        count = frames,
        steps = steps,
        step_seconds = step,
        largest_gap_meters = largest_gap;
        "{frames}, of {steps} steps of {step:.4} s; segments at most {largest_gap:.0e} m apart"
    )?;
    let percent = 100.0 * water_share;
    status!(
        "step",
        milliseconds = milliseconds,
        water_percent = percent;
        "{milliseconds:.3} ms, of which {percent:.2} % are for the water"
    )
}

/// Reports the water at the end, and where it went.
fn report_water(simulation: &Simulation) -> Result<()> {
    let end = simulation.poses.len() - 1;
    let grams = |i: usize| 1e3 * simulation.water[i].iter().sum::<f64>();
    let (first, last) = (grams(0), grams(end));
    report!(
        "water",
        first_grams = first,
        last_grams = last;
        "{} at first, {} at the end",
        shown(first),
        shown(last)
    )?;
    let Balance { soil, transpired, supplied, drained, .. } = simulation.balance[end];
    let [soil, transpired, supplied, drained] =
        [soil, transpired, supplied, drained].map(|kilograms| 1e3 * kilograms);
    if let Some(capacity) = simulation.capacity {
        let capacity = 1e3 * capacity;
        report!(
            "soil",
            last_grams = soil,
            capacity_grams = capacity,
            poured_grams = supplied,
            drained_grams = drained;
            "{} at the end, of at most {}; {} supplied, another {} drained",
            shown(soil),
            shown(capacity),
            shown(supplied),
            shown(drained)
        )?;
    }
    report!("leaves", lost_grams = transpired; "lost {}", shown(transpired))
}

/// Formats grams with four decimals, or with four digits where these are too few.
fn shown(grams: f64) -> String {
    const FEW: f64 = 1e-3;
    if grams != 0.0 && grams.abs() < FEW {
        format!("{grams:.3e} g")
    } else {
        format!("{grams:.4} g")
    }
}
