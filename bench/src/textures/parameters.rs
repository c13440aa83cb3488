//! What the parameters do to the pattern: table 3.1 and figure 3.10.

use catamaran::Par;
use catamaran::base::Progress;
use catamaran::texture::slime::{Options, Pattern};

use super::figures::grown;
use crate::Result;
use crate::plant::Part;

/// As dense as a million agents at 2048 x 2048.
const SIZE: usize = 512;
const AGENTS: usize = 100_000;
/// Steps until a pattern is there.
const STEPS: u32 = 300;
/// Pheromone above this is part of the pattern.
const THRESHOLD: f32 = 0.3;

fn options() -> Options {
    Options::new().agents(AGENTS).size(SIZE)
}

fn pattern(options: &Options) -> Result<Pattern> {
    Ok(Pattern::of(grown(options, STEPS)?.texture(0), SIZE, THRESHOLD)?)
}

/// How much of the pheromone changes in ten steps, as a part of it.
fn unrest(options: &Options) -> Result<f64> {
    let mut all = grown(options, STEPS)?;
    let before = all.texture(0).to_vec();
    all.run(10, Par::all(), Progress::none())?;
    let changes = before.iter().zip(all.texture(0)).map(|(a, b)| f64::from((a - b).abs()));
    Ok(changes.sum::<f64>() / before.iter().map(|&p| f64::from(p)).sum::<f64>())
}

/// Table 3.1: the property that each parameter is said to change, at two values, and whether it goes where the thesis says.
///
/// # Errors
/// Those of the simulation.
pub fn table() -> Result<Part> {
    let base = options();
    let mut rows = Vec::new();
    let mut row = |name: &str, values: [f64; 2], up: bool| {
        let agrees = (values[1] > values[0]) == up;
        let sign = if up { 1.0 } else { -1.0 };
        let ratio = values[1] / values[0];
        rows.push((name.to_owned(), vec![values[0], values[1], ratio, sign, f64::from(agrees)]));
    };
    let speed = |movement_speed| pattern(&base.movement_speed(movement_speed));
    row("movement speed 1 to 2: scale (width of gaps)", [speed(1.0)?.gap, speed(2.0)?.gap], true);
    let turn = |turn_speed| unrest(&base.turn_speed(turn_speed));
    let settled = [1.0 / turn(1800.0)?, 1.0 / turn(3000.0)?];
    row("turn speed 1800 to 3000: stabilisation (1 / change in 10 steps)", settled, false);
    let far = |vision_distance| pattern(&base.vision_distance(vision_distance));
    row("vision distance 0.4 to 2: cells (mean area)", [far(0.4)?.cell, far(2.0)?.cell], true);
    // Of a sparse network that has settled, with turns of a frame as in the thesis, some 20 degrees: in crowds the sign is that of
    // the thesis from 30 degrees on only (docs/algorithms/slime.md).
    let wide = |vision_angle| -> Result<f64> {
        let options = base.vision_angle(vision_angle).agents(AGENTS / 5).turn_speed(600.0);
        Ok(Pattern::of(grown(&options, 3 * STEPS)?.texture(0), SIZE, THRESHOLD)?.thickness)
    };
    let thickness = [wide(10.0)?, wide(30.0)?, wide(50.0)?];
    row("vision angle 10 to 30: thickness", [thickness[0], thickness[1]], true);
    row("vision angle 30 to 50: thickness", [thickness[1], thickness[2]], true);
    let dry = |evaporation_rate| pattern(&base.evaporation_rate(evaporation_rate));
    row(
        "evaporation 0.2 to 1: clusters (mean area)",
        [dry(0.2)?.cluster, dry(1.0)?.cluster],
        false,
    );
    Ok(Part {
        figure: "table 3.1",
        title: format!(
            "what each parameter does, in texels of {SIZE} x {SIZE}; {AGENTS} agents, {STEPS} steps on a square, vision angle: a fifth of \
             them, {} steps, turn speed 600 (agrees: 1 where the sign is that of the thesis)",
            3 * STEPS
        ),
        columns: ["low", "high", "ratio", "sign in the thesis", "agrees"].map(String::from).into(),
        rows,
        plots: vec![],
    })
}

/// Figure 3.10: movement speed against evaporation.
///
/// # Errors
/// Those of the simulation.
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
