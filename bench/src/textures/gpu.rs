//! Tests an OpenCL device within minutes: whether it computes the same as the processor, and how
//! fast it is.

use std::time::Instant;

use catamaran::Par;
use catamaran::base::Progress;
use catamaran_simulation::opencl::{Device, DeviceKind, SlimeOnDevice, evaluate_newton};
use catamaran_simulation::texture::newton::{Grid, Newton, NewtonOptions, Points, Polynomial};
use catamaran_simulation::texture::slime::{Blur, Mask, Options, Simulation, TangentStep};

use super::surfaces::torus;
use super::thesis::{Case, FRAMES as THESIS_FRAMES, cases};
use super::times::chosen_device;
use crate::Result;
use crate::plant::Part;
use crate::race::median;

/// Number of steps that are compared: agents are ordered twice.
const STEPS: u32 = 20;
/// Number of frames that the device gets at a time: those from one ordering of the agents to the
/// next.
const FRAMES: u32 = 16;
/// Seconds after which a case ends, if it has not reached 900 frames.
const SECONDS: f64 = 12.0;
/// Number of points along a side of the pictures of fractals.
const POINTS: u32 = 4096;

/// Returns the device, whether it computes the same as the processor, and times of both chapters.
///
/// # Errors
/// When there is no device, or it fails; and when more results differ than rounding explains.
pub fn gpu() -> Result<Vec<Part>> {
    let device = chosen_device()?;
    Ok(vec![
        about(&device),
        slime_agreement(&device)?,
        newton_agreement(&device)?,
        slime_times(&device)?,
        delivery(&device)?,
        newton_times(&device)?,
    ])
}

fn about(device: &Device) -> Part {
    let info = device.info();
    let kind = match info.kind {
        DeviceKind::Cpu => "a processor",
        DeviceKind::Gpu => "a graphics card",
        DeviceKind::Other => "another device",
    };
    let values = vec![f64::from(info.compute_units), info.memory as f64 / f64::from(1 << 20)];
    Part {
        figure: "device",
        title: format!("{kind}; {}, {}", info.platform, info.version),
        columns: ["compute units", "memory, MiB"].map(String::from).into(),
        rows: vec![(info.name.clone(), values)],
        plots: vec![],
    }
}

/// Largest share of results that may differ: devices round divisions in other ways, and both
/// chapters are chaotic.
const BUDGET: f64 = 1.0 / 4000.0;

fn check(what: &str, differ: usize, of: usize) -> Result<()> {
    if differ as f64 <= BUDGET * of as f64 {
        return Ok(());
    }
    Err(format!("{what}: {differ} of {of} differ between device and processor").into())
}

/// Reports how many agents and texels differ after some steps.
fn slime_agreement(device: &Device) -> Result<Part> {
    let base = Options::new().agents(200_000).size(1024);
    let mut rows = Vec::new();
    for (name, options) in [
        ("unfolded", base),
        ("10 sub-steps", base.tangent_step(TangentStep::Project { substeps: 10 })),
        ("three species", base.species(3).seed(5)),
        (
            "Gaussian blur, lengths of the texture",
            base.blur(Blur::Gaussian).length_rescaling(false),
        ),
    ] {
        let mut twin = Simulation::new(torus(96, 48)?, &options, &Mask::default())?;
        let mut kernels = SlimeOnDevice::new(device, &twin)?;
        kernels.run(STEPS, Progress::none())?;
        twin.run(STEPS, Par::all(), Progress::none())?;
        let (ours, theirs) = (twin.state(), kernels.state()?);
        let mut places = vec![None; ours.ids.len()];
        for (i, &id) in theirs.ids.iter().enumerate() {
            places[id as usize] = Some(theirs.agent(i));
        }
        let moved = ours
            .ids
            .iter()
            .enumerate()
            .filter(|(i, id)| places[**id as usize] != Some(ours.agent(*i)));
        let moved = moved.count();
        let pairs = || ours.texture.iter().zip(&theirs.texture);
        let texels = pairs().filter(|(a, b)| a.to_bits() != b.to_bits()).count();
        let most = pairs().map(|(a, b)| f64::from((a - b).abs())).fold(0.0, f64::max);
        check(&format!("{name}, agents"), moved, ours.ids.len())?;
        check(&format!("{name}, texels"), texels, ours.texture.len())?;
        let equal = f64::from(u8::from(moved == 0 && texels == 0));
        rows.push((name.to_owned(), vec![equal, moved as f64, texels as f64, most]));
    }
    Ok(Part {
        figure: "slime: device and processor",
        title: format!(
            "200,000 agents, 1024 x 1024 texels, {STEPS} steps; at most one of 4,000 may differ"
        ),
        columns: ["bytes equal (1: yes)", "agents that differ", "texels that differ", "by at most"]
            .map(String::from)
            .into(),
        rows,
        plots: vec![],
    })
}

fn fractals() -> Result<Vec<(&'static str, Newton)>> {
    let of = |polynomial| Newton::new(&NewtonOptions::new().polynomial(polynomial));
    let roots = vec![[1.0, 0.0], [-0.5, 0.8], [-1.5, 0.1], [0.2, -1.0]];
    Ok(vec![
        ("z^3 - 1", of(Polynomial::Power(3))?),
        ("z^7 - 1", of(Polynomial::Power(7))?),
        ("four given roots", of(Polynomial::Roots(roots))?),
    ])
}

/// Reports how many points differ.
fn newton_agreement(device: &Device) -> Result<Part> {
    let points = Points::Grid(Grid::plane(1024, 1024, [0.1, -0.2], 3.0));
    let mut rows = Vec::new();
    for (name, newton) in fractals()? {
        let ours = newton.evaluate(points, Par::all(), Progress::none())?;
        let theirs = evaluate_newton(device, &newton, points, Progress::none())?;
        let roots = ours.roots.iter().zip(&theirs.roots).filter(|(a, b)| a != b).count();
        let pairs = || ours.convergence.iter().zip(&theirs.convergence);
        let gradients = pairs().filter(|(a, b)| a.to_bits() != b.to_bits()).count();
        let most = pairs().map(|(a, b)| f64::from((a - b).abs())).fold(0.0, f64::max);
        check(&format!("{name}, roots"), roots, ours.roots.len())?;
        let equal = f64::from(u8::from(roots == 0 && gradients == 0));
        rows.push((name.to_owned(), vec![equal, roots as f64, gradients as f64, most]));
    }
    Ok(Part {
        figure: "Newton: device and processor",
        title: "1024 x 1024 points; of roots, at most one of 4,000 may differ".into(),
        columns: [
            "bytes equal (1: yes)",
            "roots that differ",
            "convergences that differ",
            "by at most",
        ]
        .map(String::from)
        .into(),
        rows,
        plots: vec![],
    })
}

/// Returns whether a case is for this device: processors run only those that the thesis measures.
fn fits(case: &Case, device: &Device) -> bool {
    if device.info().kind != DeviceKind::Gpu {
        return case.millions == 1
            && case.size == 8192
            && matches!(case.substeps, 0 | 10)
            && case.table == "table 3.3";
    }
    // Device memory (docs/algorithms/slime.md): 14.2 bytes for each texel, 48 for each agent; a
    // quarter is left to the driver.
    let needed = 15 * (case.size * case.size) as u64 + 48_000_000 * case.millions as u64;
    needed < device.info().memory / 4 * 3
}

/// Measures tables 3.2 to 3.4 on the device alone, with frames that follow each other without
/// waits.
fn slime_times(device: &Device) -> Result<Part> {
    let mut rows = Vec::new();
    for case in cases() {
        let [mean, ..] = case.thesis();
        if !fits(&case, device) {
            let name = format!(
                "{} (not run here: scripts/reproduce textures --only tables --largest-texture {})",
                case.name(),
                case.size
            );
            rows.push((name, [&[mean][..], &[f64::NAN; 6]].concat()));
            continue;
        }
        let twin = Simulation::new(torus(96, 48)?, &case.options(), &Mask::default())?;
        let mut kernels = SlimeOnDevice::new(device, &twin)?;
        drop(twin);
        // These frames compile the kernels and touch memory, and agents find each other.
        kernels.run(FRAMES, Progress::none())?;
        let (mut times, begin) = (Vec::new(), Instant::now());
        device.times()?;
        while times.is_empty()
            || (times.len() * (FRAMES as usize) < THESIS_FRAMES
                && begin.elapsed().as_secs_f64() < SECONDS)
        {
            let start = Instant::now();
            kernels.run(FRAMES, Progress::none())?;
            times.push(1e3 * start.elapsed().as_secs_f64() / f64::from(FRAMES));
        }
        let ours = times.iter().sum::<f64>() / times.len() as f64;
        let most = times.iter().copied().fold(0.0, f64::max);
        let least = times.iter().copied().fold(f64::INFINITY, f64::min);
        let frames = f64::from(FRAMES) * times.len() as f64;
        let kernels = 1e3 * device.times()?.unwrap_or_default().kernels.as_secs_f64() / frames;
        rows.push((case.name(), vec![mean, ours, kernels, most, least, mean / ours, frames]));
    }
    Ok(Part {
        figure: "tables 3.2 to 3.4",
        title: format!(
            "milliseconds of a frame on a torus of 9,216 triangles, in rounds of {FRAMES} frames; at most {THESIS_FRAMES} frames or \
             {SECONDS} s a case"
        ),
        columns: [
            "thesis (RTX 2080 Ti): mean, ms",
            "this device: mean, ms",
            "of that kernels, ms",
            "slowest round",
            "fastest round",
            "times as fast as the thesis",
            "frames",
        ]
        .map(String::from)
        .into(),
        rows,
        plots: vec![],
    })
}

/// Measures how many frames a second arrive on the host, a step and a picture of 8 bits each, for
/// textures of several sizes, and the times of kernels and of transfers.
fn delivery(device: &Device) -> Result<Part> {
    /// Seconds of a case, and most frames of it.
    const SECONDS: f64 = 4.0;
    const MOST: usize = 240;
    let largest = if device.info().kind == DeviceKind::Gpu { 8192 } else { 2048 };
    let mut rows = Vec::new();
    for (size, agents) in [(512, 60_000), (1024, 250_000), (2048, 1_000_000), (8192, 1_000_000)] {
        if size > largest {
            continue;
        }
        let options = Options::new().agents(agents).size(size);
        let twin = Simulation::new(torus(96, 48)?, &options, &Mask::default())?;
        let mut kernels = SlimeOnDevice::new(device, &twin)?;
        let mut picture = vec![0; size * size];
        let mut frames = |least: usize, most: usize| -> Result<(f64, f64)> {
            let (begin, mut count) = (Instant::now(), 0);
            while count < least || (count < most && begin.elapsed().as_secs_f64() < SECONDS) {
                kernels.run(1, Progress::none())?;
                kernels.frame(0, &mut picture)?;
                count += 1;
            }
            Ok((begin.elapsed().as_secs_f64(), count as f64))
        };
        // These frames compile the kernels, and agents find each other.
        frames(FRAMES as usize, FRAMES as usize)?;
        device.times()?;
        let (seconds, count) = frames(FRAMES as usize, MOST)?;
        let times = device.times()?.unwrap_or_default();
        let of = |time: std::time::Duration| 1e3 * time.as_secs_f64() / count;
        let row = vec![count / seconds, of(times.kernels), of(times.transfers), count];
        rows.push((format!("{agents} agents, {size} x {size}"), row));
    }
    Ok(Part {
        figure: "delivered frames",
        title: format!(
            "a step and its picture of 8 bits on the host, one after the other; {}, torus of 9,216 \
             triangles",
            device.info().name
        ),
        columns: ["frames a second", "kernels, ms a frame", "transfers, ms a frame", "frames"]
            .map(String::from)
            .into(),
        rows,
        plots: vec![],
    })
}

/// Measures times of fractals on the processor and on the device, including the transfer of
/// results.
fn newton_times(device: &Device) -> Result<Part> {
    let points = Points::Grid(Grid::plane(POINTS, POINTS, [0.0; 2], 3.0));
    let count = f64::from(POINTS) * f64::from(POINTS);
    let mut rows = Vec::new();
    for (name, newton) in fractals()? {
        let time = |run: &dyn Fn() -> Result<()>| -> Result<f64> {
            run()?;
            let mut times = Vec::new();
            for _ in 0..3 {
                let start = Instant::now();
                run()?;
                times.push(1e9 * start.elapsed().as_secs_f64() / count);
            }
            Ok(median(times))
        };
        let ours =
            time(&|| Ok(newton.evaluate(points, Par::all(), Progress::none()).map(drop)?))?;
        device.times()?;
        let theirs =
            time(&|| Ok(evaluate_newton(device, &newton, points, Progress::none()).map(drop)?))?;
        let times = device.times()?.unwrap_or_default();
        // A run without a time, and three with one.
        let of = |time: std::time::Duration| 1e9 * time.as_secs_f64() / (4.0 * count);
        let (kernels, transfers) = (of(times.kernels), of(times.transfers));
        rows.push((name.to_owned(), vec![ours, theirs, kernels, transfers, ours / theirs]));
    }
    Ok(Part {
        figure: "Newton: times",
        title: format!(
            "nanoseconds a point, {POINTS} x {POINTS} points, 32 iterations, median of 3"
        ),
        columns: [
            "processor",
            "device",
            "of that kernels",
            "of that transfers",
            "times as fast as the processor",
        ]
        .map(String::from)
        .into(),
        rows,
        plots: vec![],
    })
}
