//! Races rods in motion against other solvers, each in a separate process, in turns.

use std::f64::consts::PI;
use std::path::Path;
use std::time::Instant;

use catamaran::faer::Mat;
use catamaran::io::{Matrix, Output, Overwrite, ReadOptions, read, write};
use catamaran_simulation::plant::families::{GrowthOptions, grow};
use catamaran_simulation::plant::{
    Elasticity, Motion, MotionOptions, Plant, RelaxOptions, RodOptions, Rods, Segment, WaterModel,
    WaterOptions,
};

use super::{Part, Subject};
use crate::race::median;
use crate::{Result, child};

/// The length of a step, in seconds.
const STEP: f64 = 1.0 / 60.0;

/// Steps of a plant, which falls into its pose from the one in which it was given.
const PLANT_STEPS: usize = 60;

/// Newton's iterations after which the equations of a step are solved to rounding.
const SOLVED: usize = 20;

/// A plant of `CATAMARAN_DATA` that is raced: that of 1,964 nodes, as in the thesis.
const PLANT: &str = "plant000";

/// The beam: segments, length, radius and density in SI units, its modulus, the rate of decay of
/// velocities and the seconds in which it comes to rest.
const SEGMENTS: usize = 50;
const LENGTH: f64 = 0.5;
const RADIUS: f64 = 5e-3;
const DENSITY: f64 = 1000.0;
const MODULUS: f64 = 1e9;
const DECAY: f64 = 40.0;
const SECONDS: f64 = 0.5;

/// Rods, and what a rival needs to build the same ones.
struct Problem {
    plant: Plant,
    rods: Rods,
    moduli: Vec<f64>,
    masses: Vec<f64>,
    damping: f64,
    steps: usize,
}

/// A solver: its name, and the arguments of bench/rivals/rods.py; none for ours, which has a number
/// of iterations.
struct Solver {
    name: String,
    iterations: usize,
    rival: Option<&'static str>,
}

/// What a solver did: seconds of a step (a median), the largest gap between segments, in metres,
/// and the tails after all steps.
struct Run {
    seconds: f64,
    gap: f64,
    tails: Vec<[f64; 3]>,
}

fn ours(iterations: usize) -> Solver {
    Solver { name: format!("ours, iterations: {iterations}"), iterations, rival: None }
}

fn pypbd(iterations: usize) -> Solver {
    Solver { name: format!("pypbd, iterations: {iterations}"), iterations, rival: Some("pypbd") }
}

/// Races steps of plants that fall into their pose, on one thread: seconds of a step, how far its
/// equations are from being solved, the gaps between segments, and the distance from ours.
///
/// # Errors
/// The errors of the model; a rival that is not installed or fails is left out.
pub fn rods(subjects: &[Subject], repeat: usize, libraries: &Path) -> Result<Part> {
    let python = child::python(libraries);
    let grown = Subject::new("grown".into(), grow(&GrowthOptions::new().nodes(2_000))?)?;
    let mut rows = Vec::new();
    for subject in subjects.iter().filter(|s| s.name == PLANT).chain([&grown]) {
        let problem = Problem::of_plant(&subject.plant)?;
        let folder = tempfile::tempdir()?;
        problem.write(folder.path())?;
        let solvers = [ours(1), ours(2), ours(3), pypbd(1), pypbd(2), pypbd(3), pypbd(5)];
        let solved = problem.run(&ours(SOLVED), folder.path(), None)?;
        let theirs = problem.attempt(&pypbd(SOLVED), folder.path(), python.as_deref());
        let mut runs: Vec<Vec<Run>> = solvers.iter().map(|_| vec![]).collect();
        for _ in 0..repeat {
            for (solver, runs) in solvers.iter().zip(&mut runs) {
                runs.extend(problem.attempt(solver, folder.path(), python.as_deref()));
            }
        }
        for (solver, runs) in solvers.iter().zip(&runs).filter(|(_, runs)| !runs.is_empty()) {
            let converged = if solver.rival.is_some() { theirs.as_ref() } else { Some(&solved) };
            let last = &runs[runs.len() - 1];
            rows.push((
                format!("{} ({} nodes), {}", subject.name, subject.plant.len(), solver.name),
                vec![
                    1e3 * median(runs.iter().map(|run| run.seconds).collect()),
                    converged.map_or(f64::NAN, |run| distance(&last.tails, &run.tails).0),
                    last.gap,
                    distance(&last.tails, &solved.tails).1,
                ],
            ));
        }
    }
    Ok(Part {
        figure: "rods",
        title: format!(
            "plants that fall into their pose, {PLANT_STEPS} steps of 1/60 s on one thread; \
             medians of {repeat} interleaved runs"
        ),
        columns: [
            "step, ms",
            "largest distance from the solved equations, m",
            "largest gap, m",
            "mean distance from ours, m",
        ]
        .map(String::from)
        .into(),
        rows,
        plots: vec![],
    })
}

/// Races a beam that is fixed at one end and comes to rest under its weight, on one thread: seconds
/// for half a second of motion, and the error of its end.
///
/// # Errors
/// As [`rods`].
pub fn beam(repeat: usize, libraries: &Path) -> Result<Part> {
    let python = child::python(libraries);
    let problem = Problem::beam(SEGMENTS)?;
    let folder = tempfile::tempdir()?;
    problem.write(folder.path())?;
    let exact = sag_at_rest()?;
    let elastica = Solver { name: "PyElastica".into(), iterations: 1, rival: Some("elastica") };
    let solvers = [ours(3), pypbd(3), elastica];
    let mut runs: Vec<Vec<Run>> = solvers.iter().map(|_| vec![]).collect();
    for _ in 0..repeat {
        for (solver, runs) in solvers.iter().zip(&mut runs) {
            runs.extend(problem.attempt(solver, folder.path(), python.as_deref()));
        }
    }
    let mut rows = Vec::new();
    for (solver, runs) in solvers.iter().zip(&runs).filter(|(_, runs)| !runs.is_empty()) {
        let last = &runs[runs.len() - 1];
        let seconds = median(runs.iter().map(|run| run.seconds).collect());
        let sag = -last.tails[SEGMENTS - 1][2];
        rows.push((
            solver.name.clone(),
            vec![problem.steps as f64 * seconds, sag / exact - 1.0, last.gap],
        ));
    }
    Ok(Part {
        figure: "beam",
        title: format!(
            "a beam of {SEGMENTS} segments ({LENGTH} m, radius {RADIUS} m, {MODULUS:.0e} Pa) \
             comes to rest within {SECONDS} s, \
             velocities decay at {DECAY} / s; one thread, medians of {repeat} interleaved runs"
        ),
        columns: ["all steps, s", "error of the sag, as a part of it", "largest gap, m"]
            .map(String::from)
            .into(),
        rows,
        plots: vec![],
    })
}

impl Problem {
    /// Returns the plant with full cells, and the usual damping.
    fn of_plant(plant: &Plant) -> Result<Self> {
        let full = WaterModel::new(plant, &WaterOptions::default())?.full();
        let moduli = Elasticity::default().moduli(&full, &full)?;
        let mut rods = Rods::new(plant, &RodOptions::default())?;
        rods.set_state(&moduli, &full)?;
        let dry = RodOptions::default().dry_density;
        let masses = full.iter().enumerate().map(|(v, water)| dry * plant.volume(v) + water);
        Ok(Self {
            masses: masses.collect(),
            plant: plant.clone(),
            rods,
            moduli,
            damping: MotionOptions::default().damping,
            steps: PLANT_STEPS,
        })
    }

    /// Returns a horizontal beam of n segments.
    fn beam(n: usize) -> Result<Self> {
        let at = |i: usize| [LENGTH * i as f64 / n as f64, 0.0, 0.0];
        let segments = (1..=n).map(|i| Segment::stem(at(i), RADIUS)).collect();
        let parents: Vec<Option<u32>> = (0..n as u32).map(|v| v.checked_sub(1)).collect();
        let plant = Plant::new(segments, &parents, Some([0.0; 3]))?;
        let mut rods = Rods::new(&plant, &RodOptions::new().dry_density(DENSITY))?;
        let moduli = vec![MODULUS; n];
        rods.set_state(&moduli, &vec![0.0; n])?;
        let masses = vec![DENSITY * PI * RADIUS * RADIUS * LENGTH / n as f64; n];
        let steps = (SECONDS / STEP).round() as usize;
        Ok(Self { plant, rods, moduli, masses, damping: DECAY, steps })
    }

    /// Runs a solver; a rival that can't be run is reported and left out.
    fn attempt(&self, solver: &Solver, folder: &Path, python: Option<&Path>) -> Option<Run> {
        if solver.rival.is_some() && python.is_none() {
            return None;
        }
        let run = self.run(solver, folder, python);
        run.inspect_err(|error| eprintln!("left out: {error}")).ok()
    }

    fn run(&self, solver: &Solver, folder: &Path, python: Option<&Path>) -> Result<Run> {
        let (Some(rival), Some(python)) = (solver.rival, python) else {
            return self.run_ours(solver.iterations);
        };
        let script = child::script("rods.py");
        let (place, iterations) = (folder.display().to_string(), solver.iterations.to_string());
        let report = child::run(python, &[&script, &place, rival, &iterations], 1)?;
        let tails = match read(&folder.join("theirs.npy"), &ReadOptions::default())? {
            Matrix::F64(dense) if dense.as_ref().ncols() == 3 => {
                let tails = dense.as_ref();
                (0..tails.nrows()).map(|v| [0, 1, 2].map(|i| tails[(v, i)])).collect()
            }
            _ => return Err("theirs.npy: the tails must be doubles in three columns".into()),
        };
        let gap = report.rest.get(1).copied().unwrap_or(f64::NAN);
        Ok(Run { seconds: report.seconds, gap, tails })
    }

    fn run_ours(&self, iterations: usize) -> Result<Run> {
        let options = MotionOptions::new().step(STEP).iterations(iterations).damping(self.damping);
        let mut motion = Motion::new(&self.rods, &self.rods.rest_pose(), &options)?;
        let mut times = Vec::new();
        for _ in 0..self.steps {
            let start = Instant::now();
            motion.step()?;
            times.push(start.elapsed().as_secs_f64());
        }
        let (gap, tails) = (motion.largest_gap(), motion.pose().tails);
        Ok(Run { seconds: median(times), gap, tails })
    }

    /// Writes what bench/rivals/rods.py reads.
    fn write(&self, folder: &Path) -> Result<()> {
        let plant = &self.plant;
        let n = plant.len();
        let put = |name: &str, columns: usize, entry: &dyn Fn(usize, usize) -> f64| -> Result<()> {
            let rows = if matches!(name, "step" | "frames" | "damping") { 1 } else { n };
            let matrix = Mat::from_fn(rows, columns, entry);
            let output = Output::create(&folder.join(format!("{name}.npy")), Overwrite::Replace)?;
            Ok(write(output, matrix.as_ref())?)
        };
        let shear = 2.0 * (1.0 + RodOptions::default().poisson);
        put("parents", 1, &|v, _| plant.parent(v).map_or(-1.0, |p| p as f64))?;
        put("heads", 3, &|v, i| plant.head(v)[i])?;
        put("tails", 3, &|v, i| plant.segments()[v].tail[i])?;
        put("radii", 1, &|v, _| plant.segments()[v].radius)?;
        put("moduli", 1, &|v, _| self.moduli[v])?;
        put("shears", 1, &|v, _| self.moduli[v] / shear)?;
        put("masses", 1, &|v, _| self.masses[v])?;
        put("step", 1, &|_, _| STEP)?;
        put("frames", 1, &|_, _| self.steps as f64)?;
        put("damping", 1, &|_, _| self.damping)
    }
}

/// Returns how far the end of the beam is below its beginning at rest, in metres, by 40 times as
/// many segments.
fn sag_at_rest() -> Result<f64> {
    let n = 40 * SEGMENTS;
    let fine = Problem::beam(n)?;
    let mut pose = fine.rods.rest_pose();
    fine.rods.relax(&mut pose, &RelaxOptions::default())?;
    Ok(-pose.tails[n - 1][2])
}

/// Returns the largest and the mean distance of points.
fn distance(a: &[[f64; 3]], b: &[[f64; 3]]) -> (f64, f64) {
    let apart =
        |(p, q): (&[f64; 3], &[f64; 3])| (0..3).map(|i| (p[i] - q[i]).powi(2)).sum::<f64>().sqrt();
    let all: Vec<f64> = a.iter().zip(b).map(apart).collect();
    (all.iter().copied().fold(0.0, f64::max), all.iter().sum::<f64>() / all.len() as f64)
}
