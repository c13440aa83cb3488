//! Figures of walks, of coverage, and of a maze.

use catamaran::Par;
use catamaran::base::{Progress, Rng};
use catamaran_simulation::texture::slime::{
    FREE, GOAL, Mask, OBSTACLE, Options, Simulation, Surface, Walker, project, unfold,
};

use super::surfaces::{sphere, square, torus};
use crate::Result;
use crate::curves::Plot;
use crate::plant::Part;

/// Number of walks in a mean.
const WALKS: usize = 2000;

/// Returns walkers in the middle of random triangles.
fn walkers(surface: &Surface) -> Vec<Walker> {
    let mut rng = Rng::new(34);
    let one = |_| {
        let triangle = (rng.uniform() * surface.len() as f64) as usize;
        let [_, b, c] = surface.corners()[triangle];
        let (sin, cos) = (std::f64::consts::TAU * rng.uniform()).sin_cos();
        Walker {
            triangle: triangle as u32,
            position: [((b[0] + c[0]) / 3.0) as f32, (c[1] / 3.0) as f32],
            heading: [cos as f32, sin as f32],
        }
    };
    (0..WALKS).map(one).collect()
}

/// Returns the position of a walker in space.
fn place(surface: &Surface, walker: &Walker) -> [f64; 3] {
    let frame = surface.frames()[walker.triangle as usize].map(f64::from);
    let [x, y] = walker.position.map(f64::from);
    [0, 1, 2].map(|i| frame[i] + x * frame[3 + i] + y * frame[6 + i])
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
}

/// Computes figure 3.4: the distance of the end of projected sub-steps from the geodesic, relative
/// to its length.
///
/// # Errors
/// The errors of the surface.
pub fn substeps() -> Result<Part> {
    let mut rows = Vec::new();
    for (name, surface) in
        [("torus, 2,304 triangles", torus(48, 24)?), ("torus, 36,864", torus(192, 96)?)]
    {
        let walkers = walkers(&surface);
        for length in [0.01, 0.05] {
            let off = |count: u32| {
                let one = |walker: &Walker| {
                    let exact = unfold(&surface, *walker, length, true);
                    let end = project(&surface, *walker, length / count as f32, count, true);
                    distance(place(&surface, &exact), place(&surface, &end)) / f64::from(length)
                };
                walkers.iter().map(one).sum::<f64>() / WALKS as f64
            };
            rows.push((format!("{name}, a way of {length}"), [1, 10, 100].map(off).to_vec()));
        }
    }
    Ok(Part {
        figure: "figure 3.4",
        title: "mean distance of the end of projected sub-steps from the geodesic, as a part of the way (1 is the square root \
                of the area)"
            .into(),
        columns: ["1 sub-step", "10", "100"].map(String::from).into(),
        rows,
        plots: vec![],
    })
}

/// Computes figure 3.5: the paths of agents on a torus, where its texture is stretched and where it
/// is compressed.
///
/// # Errors
/// The errors of the surface.
pub fn rescaling() -> Result<Part> {
    let surface = torus(96, 48)?;
    let walkers = walkers(&surface);
    let mut rows = Vec::new();
    for (name, rescale) in [("with length rescaling", true), ("without", false)] {
        let mut sums = [[0.0; 2]; 2];
        for walker in &walkers {
            let end = unfold(&surface, *walker, 1e-3, rescale);
            let (a, b) = (place(&surface, walker), place(&surface, &end));
            // Whether the walker is outside of the circle in the middle of the tube.
            let unit = 1.0 / torus_area().sqrt();
            let own = &mut sums[usize::from(a[0].hypot(a[1]) > unit)];
            own[0] += distance(a, b);
            own[1] += 1.0;
        }
        let [inner, outer] = sums.map(|[sum, count]: [f64; 2]| sum / count * 1e3);
        rows.push((name.to_owned(), vec![inner, outer, outer / inner]));
    }
    Ok(Part {
        figure: "figure 3.5",
        title: "mean length in space of steps of 0.001 on a torus, in thousandths".into(),
        columns: ["inner half", "outer half", "ratio"].map(String::from).into(),
        rows,
        plots: vec![],
    })
}

/// Returns the area of a torus of radii 1 and 0.5.
fn torus_area() -> f64 {
    4.0 * std::f64::consts::PI.powi(2) * 0.5
}

/// Computes figure 3.8: coverage and presence over 100 seconds, for evaporation rates of table 3.1.
///
/// # Errors
/// The errors of the simulation.
pub fn evaporation() -> Result<Part> {
    let rates = [0.2, 0.4, 0.6, 0.8, 1.0];
    // Turns from within the range of table 3.1. At its lower end, the default, strands merge for
    // longer than this: the coverage at 95 s is 4 to 10 % less than at 65 s.
    let base = Options::new().agents(60_000).size(512).turn_speed(3000.0);
    let steps = (100.0 / base.time_step) as u32;
    let (mut rows, mut coverages, mut presences) = (Vec::new(), Vec::new(), Vec::new());
    for rate in rates {
        let options = base.evaporation_rate(rate);
        let mut all = Simulation::new(torus(48, 24)?, &options, &Mask::default())?;
        let (mut coverage, mut presence) = (Vec::new(), Vec::new());
        for _ in 0..steps / 10 {
            all.run(10, Par::all(), Progress::none())?;
            let seconds = f64::from(all.state().step) * options.time_step;
            let now = all.coverage(Par::all())[0];
            coverage.push((seconds, now.coverage));
            presence.push((seconds, now.presence));
        }
        let peak = coverage.iter().fold(0.0, |most, p: &(f64, f64)| p.1.max(most));
        let mean = |from: f64, to: f64| {
            let within: Vec<f64> =
                coverage.iter().filter(|p| p.0 > from && p.0 <= to).map(|p| p.1).collect();
            within.iter().sum::<f64>() / within.len() as f64
        };
        let at = |all: &[(f64, f64)]| all.iter().find(|p| p.0 >= 70.0).map_or(f64::NAN, |p| p.1);
        let drift = mean(90.0, 100.0) / mean(60.0, 70.0) - 1.0;
        rows.push((
            format!("evaporation {rate}"),
            vec![peak, at(&coverage), at(&presence), 100.0 * drift],
        ));
        coverages.push((format!("{rate}"), coverage));
        presences.push((format!("{rate}"), presence));
    }
    let plot = |title: &str, series| Plot {
        title: title.into(),
        across: "s".into(),
        logarithmic: false,
        scattered: false,
        series,
    };
    Ok(Part {
        figure: "figure 3.8",
        title: "coverage and presence on a torus, 60,000 agents, 512 x 512 texels, turn speed 3000; drift of the coverage from 65 s to 95 s"
            .into(),
        columns: ["peak", "coverage at 70 s", "presence at 70 s", "drift, %"].map(String::from).into(),
        rows,
        plots: vec![
            plot("Figure 3.8a: coverage by evaporation rate", coverages),
            plot("Figure 3.8b: presence by evaporation rate", presences),
        ],
    })
}

/// Number of texels along a side of the maze.
const MAZE: usize = 128;

/// Returns walls along parallels of a sphere, each with one door, on opposite sides, with a start
/// at one pole and an attractor at the other.
fn walls() -> Mask {
    let (mut start, mut ground) = (Vec::new(), Vec::new());
    for t in 0..MAZE * MAZE {
        let (x, y) = (t % MAZE, t / MAZE);
        start.push(y < 20);
        let wall = (1..5).find(|w| (22 * w..22 * w + 3).contains(&y));
        ground.push(match wall {
            Some(w) if !(10..34).contains(&((x + 64 * w) % MAZE)) => OBSTACLE,
            _ if y > 112 => GOAL,
            _ => FREE,
        });
    }
    Mask { start, ground }
}

/// Computes figure 3.9: the share of agents that have reached the attractor.
///
/// # Errors
/// The errors of the simulation.
pub fn maze() -> Result<Part> {
    let mask = walls();
    let options = Options::new()
        .agents(10_000)
        .species(3)
        .size(MAZE)
        .movement_speed(15.0)
        .vision_distance(3.0)
        // Persistent trails keep agents where they are.
        .evaporation_rate(3.0);
    let mut all = Simulation::new(sphere(64, 48)?, &options, &mask)?;
    let (mut rows, mut points) = (Vec::new(), Vec::new());
    for tens in 1..=12 {
        all.run((10.0 / options.time_step) as u32, Par::all(), Progress::none())?;
        let mut counts = [0_usize; 3];
        for i in 0..all.state().ids.len() {
            let w = all.state().agent(i);
            let r = &all.surface().records()[w.triangle as usize];
            let at = |k: usize| r[k] + r[k + 1] * w.position[0] + r[k + 2] * w.position[1];
            let texel = |c: f32| ((c * MAZE as f32) as usize).min(MAZE - 1);
            counts[usize::from(mask.ground[texel(at(24)) * MAZE + texel(at(21))])] += 1;
        }
        let share = counts.map(|n| 100.0 * n as f64 / options.agents as f64);
        points.push((10.0 * f64::from(tens), share[usize::from(GOAL)]));
        if tens % 3 == 0 {
            rows.push((
                format!("{} s", 10 * tens),
                vec![share[usize::from(GOAL)], share[usize::from(OBSTACLE)]],
            ));
        }
    }
    Ok(Part {
        figure: "figure 3.9",
        title: "a maze of four walls on a sphere, three species, 10,000 agents: the share that has come to the attractor".into(),
        columns: ["in the attractor, %", "in walls, %"].map(String::from).into(),
        rows,
        plots: vec![Plot {
            title: "Figure 3.9: agents in the attractor, %".into(),
            across: "s".into(),
            logarithmic: false,
            scattered: false,
            series: vec![("all species".into(), points)],
        }],
    })
}

/// Returns a square with a pattern after this number of steps.
pub(super) fn grown(options: &Options, steps: u32) -> Result<Simulation> {
    let mut all = Simulation::new(square()?, options, &Mask::default())?;
    all.run(steps, Par::all(), Progress::none())?;
    Ok(all)
}
