//! The effects of the parameters on the pattern: table 3.1 and figure 3.10.

use catamaran::Par;
use catamaran::base::Progress;
use catamaran_simulation::texture::slime::{Options, Pattern};

use super::figures::grown;
use crate::Result;
use crate::plant::Part;

/// Texels along a side, with the density of a million agents at 2048 x 2048.
const SIZE: usize = 512;
const AGENTS: usize = 100_000;
/// Number of steps until there is a pattern.
const STEPS: u32 = 300;
/// Pheromone above which a texel is part of the pattern.
const THRESHOLD: f32 = 0.3;

fn options() -> Options {
    Options::new().agents(AGENTS).size(SIZE)
}

fn pattern(options: &Options) -> Result<Pattern> {
    Ok(Pattern::of(grown(options, STEPS)?.texture(0), SIZE, THRESHOLD)?)
}

/// Turn speeds in half-turns a second: the range of table 3.1.
const TURNS: [f64; 5] = [10.0, 20.0, 30.0, 40.0, 50.0];
/// Duration of a frame in the thesis, approximately: with it, the range is turns of up to 22 to 108
/// degrees a step.
const FRAME: f64 = 0.012;
/// Texels along a side: a quarter of a larger square, so that lengths are twice those of the table;
/// as sparse as a million agents at 4096 x 4096.
const TABLE_SIZE: usize = 256;
const TABLE_AGENTS: usize = 5000;
/// Seconds until a network has settled, and until the measurement of its changes.
const SETTLED: f64 = 30.0;
const EARLY: f64 = 10.0;
/// Seconds over which changes are measured.
const WINDOW: f64 = 0.33;
/// Seeds over which measures are averaged: with one seed, the number of cells varies by a fifth.
const SEEDS: [u32; 5] = [7, 1, 2, 3, 4];

/// Returns the options of table 3.1 at these half-turns a second.
fn of_table(turns: f64) -> Options {
    Options::new()
        .agents(TABLE_AGENTS)
        .size(TABLE_SIZE)
        .time_step(FRAME)
        .movement_speed(3.0)
        .vision_distance(2.0)
        .turn_speed(180.0 * turns)
}

/// A measure by each of the seeds.
type BySeed = [f64; SEEDS.len()];

fn by_seed(options: &Options, measure: impl Fn(&Options) -> Result<f64>) -> Result<BySeed> {
    let mut values = [0.0; SEEDS.len()];
    for (value, seed) in values.iter_mut().zip(SEEDS) {
        *value = measure(&options.seed(seed))?;
    }
    Ok(values)
}

/// Returns a measure of settled patterns.
fn settled(options: &Options, measure: impl Fn(&Pattern) -> f64) -> Result<BySeed> {
    by_seed(options, |options| {
        let all = grown(options, (SETTLED / FRAME) as u32)?;
        Ok(measure(&Pattern::of(all.texture(0), TABLE_SIZE, THRESHOLD)?))
    })
}

/// Returns the inverse of the relative change of the pheromone.
fn stability(options: &Options) -> Result<f64> {
    let mut all = grown(options, (EARLY / FRAME) as u32)?;
    let before = all.texture(0).to_vec();
    all.run((WINDOW / FRAME) as u32, Par::all(), Progress::none())?;
    let changes = before.iter().zip(all.texture(0)).map(|(a, b)| f64::from((a - b).abs()));
    Ok(before.iter().map(|&p| f64::from(p)).sum::<f64>() / changes.sum::<f64>())
}

/// Computes table 3.1: the property that each parameter is said to change, at the ends of its range
/// and for turn speeds over their whole range, and whether the sign is that of the thesis. The
/// properties are measures of [`Pattern`], as in the tests of the library: scale is `gap`, cell
/// formation `cell`, thickness `thickness`, clustering `cluster`. Stabilization is the inverse of
/// the relative change of the pheromone.
///
/// # Errors
/// The errors of the simulation.
pub fn table() -> Result<Part> {
    let mut rows = Vec::new();
    let mut row = |name: String, values: [BySeed; 2], up: bool| {
        let [low, high] = values.map(|all| all.iter().sum::<f64>() / SEEDS.len() as f64);
        let agrees = |low: f64, high: f64| (high > low) == up;
        let seeds = values[0].iter().zip(&values[1]).filter(|(low, high)| agrees(**low, **high));
        let sign = if up { 1.0 } else { -1.0 };
        let (agrees, seeds) = (f64::from(agrees(low, high)), seeds.count() as f64);
        rows.push((name, vec![low, high, high / low, sign, agrees, seeds]));
    };
    for turns in TURNS {
        let (base, at) = (of_table(turns), format!("turn speed {turns}"));
        let speed = |speed| settled(&base.movement_speed(2.0 * speed), |p| p.gap);
        row(format!("{at}: movement speed 1 to 2: scale (gap)"), both([1.0, 2.0], speed)?, true);
        let far = |distance| settled(&base.vision_distance(2.0 * distance), |p| p.cell);
        row(format!("{at}: vision distance 0.4 to 2: cells (area)"), both([0.4, 2.0], far)?, true);
        let wide = |angle| settled(&base.vision_angle(angle), |p| p.thickness);
        let ([narrow, middle], broad) = (both([10.0, 30.0], wide)?, wide(50.0)?);
        row(format!("{at}: vision angle 10 to 30 degrees: thickness"), [narrow, middle], true);
        row(format!("{at}: vision angle 30 to 50 degrees: thickness"), [middle, broad], true);
        row(format!("{at}: vision angle 10 to 50 degrees: thickness"), [narrow, broad], true);
        let dry = |rate| settled(&base.evaporation_rate(rate), |p| p.cluster);
        row(
            format!("{at}: evaporation 0.2 to 1: clusters (mean area)"),
            both([0.2, 1.0], dry)?,
            false,
        );
    }
    let stable = TURNS.map(|turns| by_seed(&of_table(turns), stability));
    let [a, b, c, d, e] = stable;
    let stable = [a?, b?, c?, d?, e?];
    let ends = [(0, 1), (1, 2), (2, 3), (3, 4), (0, 4)];
    for (low, high) in ends {
        let name =
            format!("turn speed {} to {}: stabilization (1 / change)", TURNS[low], TURNS[high]);
        row(name, [stable[low], stable[high]], false);
    }
    Ok(Part {
        figure: "table 3.1",
        title: format!(
            "what each parameter does (docs/algorithms/slime.md defines the properties; means of \
             {} seeds), for turn speeds (half-turns a second) over the range of the table: \
             {TABLE_AGENTS} agents on a square of {TABLE_SIZE} x {TABLE_SIZE} texels, steps of \
             {FRAME} s, after {SETTLED} s; changes in {WINDOW} s after {EARLY} s (agrees: 1 where \
             the sign of the means is that of the thesis)",
            SEEDS.len()
        ),
        columns: ["low", "high", "ratio", "sign in the thesis", "agrees", "seeds that agree"]
            .map(String::from)
            .into(),
        rows,
        plots: vec![],
    })
}

/// Returns a list of the rows of table 3.1 whose sign is not that of the thesis.
pub fn disagreements(table: &Part) -> String {
    let named = table.rows.iter().filter_map(|(name, values)| match values[..] {
        [low, high, _, _, agrees, seeds] if agrees < 1.0 => Some(format!(
            "- {name}: {low:.4} to {high:.4}; with the sign of the thesis by {seeds} of {} seeds\n",
            SEEDS.len()
        )),
        _ => None,
    });
    let named: Vec<String> = named.collect();
    format!(
        "Disagreements with the thesis: {} of {} rows.\n\n{}",
        named.len(),
        table.rows.len(),
        named.concat()
    )
}

/// Returns a measure at both ends of a range.
fn both(ends: [f64; 2], measure: impl Fn(f64) -> Result<BySeed>) -> Result<[BySeed; 2]> {
    Ok([measure(ends[0])?, measure(ends[1])?])
}

/// Computes figure 3.10: movement speed against evaporation.
///
/// # Errors
/// The errors of the simulation.
pub fn grid() -> Result<Part> {
    let mut rows = Vec::new();
    for evaporation_rate in [0.2, 0.6, 1.0] {
        for movement_speed in [1.0, 1.5, 2.0] {
            let p = pattern(
                &options().evaporation_rate(evaporation_rate).movement_speed(movement_speed),
            )?;
            rows.push((
                format!("evaporation {evaporation_rate}, movement speed {movement_speed}"),
                vec![p.gap, p.thickness, p.cell, p.cluster, p.covered],
            ));
        }
    }
    let columns = ["gap", "thickness", "cell", "cluster", "covered"];
    Ok(Part {
        figure: "figure 3.10",
        title: format!("patterns over two parameters, in texels of {SIZE} x {SIZE}"),
        columns: columns.map(String::from).into(),
        rows,
        plots: vec![],
    })
}
