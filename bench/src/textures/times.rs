//! Tables 3.2 to 3.4: the time of a frame.

use std::time::Instant;

use catamaran::Par;
use catamaran::texture::slime::{Mask, Options, Simulation, TangentStep};

use super::surfaces::torus;
use crate::Result;
use crate::curves::Plot;
use crate::plant::Part;
use crate::race::median;

/// Frames before the first that is timed: agents are in order then, and have found each other.
const WARM: u32 = 4;

/// What the tables vary, one at a time.
struct Case {
    table: &'static str,
    agents: usize,
    size: usize,
    tangent_step: TangentStep,
}

const TEN: TangentStep = TangentStep::Project { substeps: 10 };

fn cases(largest: usize) -> Vec<Case> {
    let million = 1_000_000;
    let case = |table, agents, size, tangent_step| Case { table, agents, size, tangent_step };
    let mut all = Vec::new();
    for size in [2048, 4096, 8192, 16384] {
        all.push(case("table 3.2", million, size, TEN));
    }
    for step in [1, 10, 100].map(|substeps| TangentStep::Project { substeps }) {
        all.push(case("table 3.3", million, 2048, step));
    }
    all.push(case("table 3.3", million, 2048, TangentStep::Unfold));
    for agents in [1, 2, 3, 4] {
        all.push(case("table 3.4", agents * million, 2048, TEN));
    }
    all.retain(|case| case.size <= largest);
    all
}

/// Seconds of a frame on the CPU: median, most and least of `frames`, for textures up to `largest`; with the fit of the time
/// by the number of agents.
///
/// # Errors
/// Those of the simulation.
pub fn times(frames: usize, largest: usize) -> Result<Part> {
    let par = Par::all();
    let device = format!("CPU, {} threads", par.threads());
    let (mut rows, mut by_agents) = (Vec::new(), Vec::new());
    for case in cases(largest) {
        let options = Options {
            agents: case.agents,
            size: case.size,
            tangent_step: case.tangent_step,
            ..Options::default()
        };
        let mut all = Simulation::new(torus(96, 48)?, &options, &Mask::default())?;
        all.run(WARM, par, None)?;
        let mut seconds = Vec::new();
        for _ in 0..frames {
            let start = Instant::now();
            all.step(par);
            seconds.push(1e3 * start.elapsed().as_secs_f64());
        }
        let most = seconds.iter().copied().fold(0.0, f64::max);
        let least = seconds.iter().copied().fold(f64::INFINITY, f64::min);
        let step = match case.tangent_step {
            TangentStep::Unfold => "unfolded".to_owned(),
            TangentStep::Project { substeps } => format!("{substeps} sub-steps"),
        };
        if case.table == "table 3.4" {
            by_agents.push((case.agents as f64 / 1e6, least));
        }
        let (millions, size) = (case.agents / 1_000_000, case.size);
        let name = format!("{}, {device}: {millions} M agents, {size}, {step}", case.table);
        let bytes = all.bytes() as f64 / f64::from(1 << 20);
        rows.push((name, vec![median(seconds), most, least, bytes]));
    }
    rows.push(("table 3.4: R^2 of a line through the least".into(), vec![fit(&by_agents)]));
    for row in &mut rows {
        row.1.resize(4, f64::NAN);
    }
    let columns = ["median, ms", "most, ms", "least, ms", "memory, MiB"];
    Ok(Part {
        figure: "tables 3.2 to 3.4",
        title: format!("time of a frame on a torus of 9,216 triangles, {frames} frames"),
        columns: columns.map(String::from).into(),
        rows,
        plots: vec![Plot {
            title: "Table 3.4: milliseconds of a frame by millions of agents".into(),
            across: "M".into(),
            logarithmic: false,
            scattered: false,
            series: vec![(device, by_agents)],
        }],
    })
}

/// The part of the variance that a line explains.
fn fit(points: &[(f64, f64)]) -> f64 {
    let n = points.len() as f64;
    let mean = |f: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(f).sum::<f64>() / n;
    let (x, y) = (mean(&|p| p.0), mean(&|p| p.1));
    let (xy, xx) = (mean(&|p| (p.0 - x) * (p.1 - y)), mean(&|p| (p.0 - x).powi(2)));
    let yy = mean(&|p| (p.1 - y).powi(2));
    xy * xy / (xx * yy)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_fit_and_scatter_does_not() {
        let line: Vec<(f64, f64)> = (0..5).map(|i| (f64::from(i), 3.0 - f64::from(i))).collect();
        assert!((fit(&line) - 1.0).abs() < 1e-12);
        assert!(fit(&[(0.0, 0.0), (1.0, 1.0), (2.0, 0.0)]) < 1e-12);
    }
}
