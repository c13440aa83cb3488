//! Tables 3.2 to 3.4: the time of a frame, on the processor and on an OpenCL device.

use std::time::Instant;

use catamaran::Par;
use catamaran::base::Progress;
use catamaran::opencl::{Device, SlimeOnDevice};
use catamaran::texture::slime::{Mask, Options, Simulation, TangentStep};

use super::surfaces::torus;
use crate::Result;
use crate::curves::Plot;
use crate::plant::Part;

/// What the tables vary, one at a time.
struct Case {
    table: &'static str,
    millions: usize,
    size: usize,
    tangent_step: TangentStep,
}

fn cases(largest: usize) -> Vec<Case> {
    let project = |substeps| TangentStep::Project { substeps };
    let case = |table, millions, size, tangent_step| Case { table, millions, size, tangent_step };
    let mut all = Vec::new();
    for size in [2048, 4096, 8192, 16384] {
        all.push(case("table 3.2", 1, size, project(10)));
    }
    for substeps in [1, 10, 100] {
        all.push(case("table 3.3", 1, 2048, project(substeps)));
    }
    all.push(case("table 3.3", 1, 2048, TangentStep::Unfold));
    for millions in [1, 2, 3, 4] {
        all.push(case("table 3.4", millions, 2048, project(10)));
    }
    all.retain(|case| case.size <= largest);
    all
}

/// Frames that are timed together: as many as from one ordering of the agents to the next, so that each round has one.
const FRAMES: usize = 16;

/// Appends milliseconds of frames, one by one.
fn time(times: &mut Vec<f64>, mut frame: impl FnMut() -> Result<()>) -> Result<()> {
    for _ in 0..FRAMES {
        let start = Instant::now();
        frame()?;
        times.push(1e3 * start.elapsed().as_secs_f64());
    }
    Ok(())
}

/// As the tables of the thesis have them: mean, most, least.
fn summary(times: &[f64]) -> [f64; 3] {
    let mean = times.iter().sum::<f64>() / times.len() as f64;
    let most = times.iter().copied().fold(0.0, f64::max);
    let least = times.iter().copied().fold(f64::INFINITY, f64::min);
    [mean, most, least]
}

/// Times of frames on the processor and on the first OpenCL device, in turns, for textures up to `largest`; with the fit of the
/// time by the number of agents. A round is 16 frames; the first is not timed.
///
/// # Errors
/// Those of the simulation, where there is no device, and where it comes to other textures.
pub fn times(rounds: usize, largest: usize) -> Result<Part> {
    let (device, par) = (Device::open("")?, Par::all());
    let (mut rows, mut by_agents) = (Vec::new(), [Vec::new(), Vec::new()]);
    for case in cases(largest) {
        let options = Options::new()
            .agents(case.millions * 1_000_000)
            .size(case.size)
            .tangent_step(case.tangent_step);
        let mut twin = Simulation::new(torus(96, 48)?, &options, &Mask::default())?;
        let mut kernels = SlimeOnDevice::new(&device, &twin)?;
        let mut found = [Vec::new(), Vec::new()];
        for round in 0..=rounds {
            time(&mut found[0], || Ok(twin.run(1, par, Progress::none())?))?;
            time(&mut found[1], || Ok(kernels.run(1, Progress::none())?))?;
            if round == 0 {
                // It compiled, touched memory, and agents have found each other.
                found = [Vec::new(), Vec::new()];
            }
        }
        let same = kernels.state()?.texture == twin.state().texture;
        let walk = match case.tangent_step {
            TangentStep::Unfold => "unfolded".to_owned(),
            TangentStep::Project { substeps } => format!("{substeps} sub-steps"),
        };
        let name = format!("{}: {} M agents, {}, {walk}", case.table, case.millions, case.size);
        let [ours, theirs] = found.map(|times| summary(&times));
        if case.table == "table 3.4" {
            for (points, summary) in by_agents.iter_mut().zip([ours, theirs]) {
                points.push((case.millions as f64, summary[2]));
            }
        }
        let memory = twin.bytes() as f64 / f64::from(1 << 20);
        let rest = [memory, f64::from(u8::from(same))];
        rows.push((name, [&ours[..], &theirs, &rest].concat()));
    }
    let mut fits = vec![f64::NAN; 8];
    (fits[2], fits[5]) = (fit(&by_agents[0]), fit(&by_agents[1]));
    rows.push(("table 3.4: R^2 of a line through the least".into(), fits));
    let columns = [
        "processor: mean, ms",
        "processor: most",
        "processor: least",
        "device: mean, ms",
        "device: most",
        "device: least",
        "memory, MiB",
        "textures equal (1: yes)",
    ];
    Ok(Part {
        figure: "tables 3.2 to 3.4",
        title: format!(
            "time of a frame on a torus of 9,216 triangles, {} frames; processor: {} threads; device: {}",
            rounds * FRAMES,
            par.threads(),
            device.info().name
        ),
        columns: columns.map(String::from).into(),
        rows,
        plots: vec![Plot {
            title: "Table 3.4: milliseconds of a frame by millions of agents".into(),
            across: "M".into(),
            logarithmic: false,
            scattered: false,
            series: ["processor", "device"].map(String::from).into_iter().zip(by_agents).collect(),
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
