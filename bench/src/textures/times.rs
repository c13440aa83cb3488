//! Tables 3.2 to 3.4: the time of a frame, on the processor and on an OpenCL device.

use std::time::Instant;

use catamaran::Par;
use catamaran::base::Progress;
use catamaran_simulation::opencl::{Device, SlimeOnDevice};
use catamaran_simulation::texture::slime::{Mask, Simulation, Surface};

use super::surfaces::{ten, torus};
use super::thesis::{Case, FRAMES as THESIS_FRAMES, SIZE, cases};
use crate::Result;
use crate::curves::Plot;
use crate::plant::Part;

/// Number of frames that are timed together: those from one ordering of the agents to the next, so
/// that each round includes one ordering.
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

/// Returns mean, most and least, as in the tables of the thesis.
fn summary(times: &[f64]) -> [f64; 3] {
    let mean = times.iter().sum::<f64>() / times.len() as f64;
    let most = times.iter().copied().fold(0.0, f64::max);
    let least = times.iter().copied().fold(f64::INFINITY, f64::min);
    [mean, most, least]
}

/// Returns the device that `CATAMARAN_OPENCL_DEVICE` names (as for tests), otherwise the first one.
pub(super) fn chosen_device() -> Result<Device> {
    Ok(Device::open_timed(&std::env::var("CATAMARAN_OPENCL_DEVICE").unwrap_or_default())?)
}

/// The result of one case: milliseconds of frames on the processor and on the device, as from
/// [`summary`].
struct Timed {
    processor: [f64; 3],
    device: [f64; 3],
    memory: f64,
    same: bool,
}

fn timed(case: &Case, surface: Surface, device: &Device, rounds: usize) -> Result<Timed> {
    let mut twin = Simulation::new(surface, &case.options(), &Mask::default())?;
    let mut kernels = SlimeOnDevice::new(device, &twin)?;
    let mut found = [Vec::new(), Vec::new()];
    for round in 0..=rounds {
        time(&mut found[0], || Ok(twin.run(1, Par::all(), Progress::none())?))?;
        time(&mut found[1], || Ok(kernels.run(1, Progress::none())?))?;
        if round == 0 {
            // By now, kernels are compiled, memory is touched, and agents have found each other.
            found = [Vec::new(), Vec::new()];
        }
    }
    let [processor, on_device] = found.map(|times| summary(&times));
    let memory = twin.bytes() as f64 / f64::from(1 << 20);
    let same = kernels.state()?.texture == twin.state().texture;
    Ok(Timed { processor, device: on_device, memory, same })
}

/// The columns of both tables.
const COLUMNS: [&str; 11] = [
    "thesis (RTX 2080 Ti): mean, ms",
    "thesis: most",
    "thesis: least",
    "processor: mean, ms",
    "processor: most",
    "processor: least",
    "device: mean, ms",
    "device: most",
    "device: least",
    "memory, MiB",
    "textures equal (1: yes)",
];

impl Timed {
    fn row(&self, thesis: [f64; 3]) -> Vec<f64> {
        let rest = [self.memory, f64::from(u8::from(self.same))];
        [&thesis[..], &self.processor, &self.device, &rest].concat()
    }
}

/// Returns times of frames on the processor and on an OpenCL device, in turns, for textures up to
/// `largest`, with those of the thesis, and the fit of the time by the number of agents. A round is
/// 16 frames; the first one is not timed. Larger textures are listed with the option that runs
/// them.
///
/// # Errors
/// The errors of the simulation, and when there is no device.
pub fn times(rounds: usize, largest: usize) -> Result<Part> {
    let device = chosen_device()?;
    let (mut rows, mut by_agents) = (Vec::new(), [Vec::new(), Vec::new()]);
    for case in cases() {
        if case.size > largest {
            let name = format!("{} (not run: --largest-texture {})", case.name(), case.size);
            let nothing = [f64::NAN; COLUMNS.len() - 3];
            rows.push((name, [&case.thesis()[..], &nothing].concat()));
            continue;
        }
        let found = timed(&case, torus(96, 48)?, &device, rounds)?;
        if case.table == "table 3.4" {
            let both = [found.processor, found.device];
            for (points, summary) in by_agents.iter_mut().zip(both) {
                points.push((case.millions as f64, summary[2]));
            }
        }
        rows.push((case.name(), found.row(case.thesis())));
    }
    if !by_agents[0].is_empty() {
        let mut fits = vec![f64::NAN; COLUMNS.len()];
        (fits[5], fits[8]) = (fit(&by_agents[0]), fit(&by_agents[1]));
        rows.push(("table 3.4: R^2 of a line through the least".into(), fits));
    }
    let frames = rounds * FRAMES;
    let more = THESIS_FRAMES.div_ceil(FRAMES);
    Ok(Part {
        figure: "tables 3.2 to 3.4",
        title: format!(
            "time of a frame on a torus of 9,216 triangles, {frames} frames (the thesis: {THESIS_FRAMES} on each of ten meshes, which \
             --rounds {more} does here); processor: {} threads; device: {}",
            Par::all().threads(),
            device.info().name
        ),
        columns: COLUMNS.map(String::from).into(),
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

/// Returns the same for a million agents and ten sub-steps on ten meshes, with textures of 8192 x
/// 8192 or `largest`: the time depends on the mesh.
///
/// # Errors
/// As [`times`].
pub fn ten_meshes(rounds: usize, largest: usize) -> Result<Part> {
    let device = chosen_device()?;
    let size = SIZE.min(largest);
    let mut rows = Vec::new();
    for (name, surface) in ten(size)? {
        let case = Case { table: "ten meshes", millions: 1, size, substeps: 10, thesis: None };
        let triangles = surface.len();
        let found = timed(&case, surface, &device, rounds)?;
        rows.push((format!("{name}, {triangles} triangles"), found.row(case.thesis())));
    }
    let means = (0..COLUMNS.len()).map(|k| {
        let mean = rows.iter().map(|(_, row): &(String, Vec<f64>)| row[k]).sum::<f64>();
        if k < COLUMNS.len() - 2 { mean / rows.len() as f64 } else { f64::NAN }
    });
    let mut means: Vec<f64> = means.collect();
    if size == SIZE {
        means[..3].copy_from_slice(&[12.120, 39.039, 10.263]);
    }
    rows.push(("mean".into(), means));
    Ok(Part {
        figure: "table 3.2, ten meshes",
        title: format!(
            "time of a frame of a million agents, {size} x {size} texels, ten sub-steps, {} frames",
            rounds * FRAMES
        ),
        columns: COLUMNS.map(String::from).into(),
        rows,
        plots: vec![],
    })
}

/// Returns the share of the variance that a line explains.
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
