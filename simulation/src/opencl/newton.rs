//! Newton's fractals on a device.

use opencl3::kernel::{ExecuteKernel, Kernel};
use opencl3::memory::Buffer;

use super::session::{Device, Launcher};
use crate::texture::newton::{Fractal, Newton, Points};
use catamaran::base::{Error, Progress, Result, reserved};

const SOURCE: &str = include_str!("kernels/newton.cl");

/// Number of points that go to the device at a time, a multiple of all numbers of lanes; each takes
/// 18 bytes of device memory.
const PART: usize = 1 << 22;

/// Computes the same as [`Newton::evaluate`] on a device, with the same bits if the device rounds
/// divisions and square roots correctly, as processors do. Otherwise roots and convergence differ
/// at a few points, about 1 of 4,000, where fractals are chaotic.
///
/// ```
/// use catamaran_simulation::opencl::{Device, evaluate_newton};
/// use catamaran_simulation::texture::newton::{Grid, Newton, NewtonOptions, Points};
/// use catamaran::{Par, base::Progress};
///
/// let Ok(device) = Device::open("") else { return Ok(()) };
/// let newton = Newton::new(&NewtonOptions::new())?;
/// let points = Points::Grid(Grid::plane(32, 32, [0.0, 0.0], 2.0));
/// let found = evaluate_newton(&device, &newton, points, Progress::none())?;
/// let twin = newton.evaluate(points, Par::Seq, Progress::none())?;
/// let differ = found.roots.iter().zip(&twin.roots).filter(|(x, y)| x != y).count();
/// assert!(differ <= 1); // 0 on processors
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// As [`Newton::evaluate`]; [`Error::Backend`] when the device fails.
pub fn evaluate_newton(
    device: &Device,
    newton: &Newton,
    points: Points<'_>,
    progress: Progress<'_>,
) -> Result<Fractal> {
    evaluate_newton_in_groups(device, newton, points, None, progress)
}

/// Computes [`evaluate_newton`] in work-groups of this number of work-items, instead of the
/// driver's choice; the result does not depend on the number.
///
/// ```
/// use catamaran::base::Progress;
/// use catamaran_simulation::opencl::{Device, evaluate_newton_in_groups};
/// use catamaran_simulation::texture::newton::{Grid, Newton, NewtonOptions, Points};
///
/// let Ok(device) = Device::open("") else { return Ok(()) };
/// let newton = Newton::new(&NewtonOptions::new())?;
/// let points = Points::Grid(Grid::plane(32, 32, [0.0, 0.0], 2.0));
/// let run = |group| evaluate_newton_in_groups(&device, &newton, points, group, Progress::none());
/// assert_eq!(run(Some(1))?, run(None)?);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// As [`evaluate_newton`]; [`Error::Backend`] also for groups that the device does not support.
pub fn evaluate_newton_in_groups(
    device: &Device,
    newton: &Newton,
    points: Points<'_>,
    group: Option<usize>,
    progress: Progress<'_>,
) -> Result<Fractal> {
    let parameters = &newton.parameters;
    let count = points.check(parameters)?;
    if group == Some(0) {
        return Err(Error::Argument { what: "group", why: "must be at least 1, is 0".into() });
    }
    let mut fractal = Fractal::with_len(count)?;
    let lanes = device.lanes();
    let name = match points {
        Points::Grid(_) => "newton_grid",
        Points::List(_) => "newton_list",
    };
    let kernel = device.kernel(SOURCE, &format!("-DLANES={lanes}"), name)?;
    let mut run = Run {
        launcher: Launcher { device: device.clone(), group, what: "newton" },
        newton,
        kernel,
        lanes,
        memory: Memory::new(device, newton, count)?,
    };
    let outputs = fractal.roots.chunks_mut(PART).zip(fractal.convergence.chunks_mut(PART));
    for (i, (roots, convergence)) in outputs.enumerate() {
        let first = i * PART;
        run.part(points, first, roots.len())?;
        device.read(&run.memory.numbers, roots)?;
        device.read(&run.memory.convergence, convergence)?;
        let fraction = (first + roots.len()) as f64 / count as f64;
        progress.report(fraction)?;
    }
    fractal.marked()
}

/// The buffers on the device.
struct Memory {
    /// Real and imaginary parts, alternating.
    roots: Buffer<f32>,
    numbers: Buffer<u16>,
    convergence: Buffer<f32>,
    /// Coordinates of the points of a list; allocated for a list only.
    coordinates: Option<[Buffer<f32>; 3]>,
    len: usize,
}

impl Memory {
    fn new(device: &Device, newton: &Newton, count: usize) -> Result<Self> {
        let roots = newton.parameters.roots.as_flattened();
        let len = count.min(PART).next_multiple_of(16);
        let mut memory = Self {
            // At least one root, because kernels take no empty buffer.
            roots: device.buffer(roots.len().max(2))?,
            numbers: device.buffer(len)?,
            convergence: device.buffer(len)?,
            coordinates: None,
            len,
        };
        device.write(&mut memory.roots, roots)?;
        Ok(memory)
    }
}

struct Run<'a> {
    launcher: Launcher,
    newton: &'a Newton,
    kernel: Kernel,
    lanes: usize,
    memory: Memory,
}

impl Run<'_> {
    /// Computes `len` points from point number `first` on.
    fn part(&mut self, points: Points<'_>, first: usize, len: usize) -> Result<()> {
        let items = len.div_ceil(self.lanes);
        if let Points::List(list) = points {
            self.send(&list[first..first + len])?;
        }
        let mut call = ExecuteKernel::new(&self.kernel);
        let wide = |p: [f32; 3]| [p[0], p[1], p[2], 0.0];
        // SAFETY: numbers and types are those that the kernel declares, and `items` groups of lanes
        // lie within the buffers.
        unsafe {
            call.set_arg(&(items as u32));
            match (points, &self.memory.coordinates) {
                (Points::Grid(grid), _) => {
                    call.set_arg(&(first as u32))
                        .set_arg(&grid.counts[0])
                        .set_arg(&grid.counts[1])
                        .set_arg(&wide(grid.origin))
                        .set_arg(&wide(grid.steps[0]))
                        .set_arg(&wide(grid.steps[1]))
                        .set_arg(&wide(grid.steps[2]));
                }
                (Points::List(_), Some(coordinates)) => {
                    for coordinate in coordinates {
                        call.set_arg(coordinate);
                    }
                }
                (Points::List(_), None) => return Ok(()),
            }
            let p = &self.newton.parameters;
            call.set_arg(&self.memory.numbers)
                .set_arg(&self.memory.convergence)
                .set_arg(&self.memory.roots)
                .set_arg(&i32::from(!p.roots.is_empty()))
                .set_arg(&p.degree)
                .set_arg(&p.steps)
                .set_arg(&i32::from(p.squared))
                .set_arg(&p.gain)
                .set_arg(&p.factor)
                .set_arg(&p.shift)
                .set_arg(&p.scale)
                .set_arg(&p.offset)
                .set_arg(&p.nearest)
                .set_arg(&p.arrived);
        }
        // SAFETY: the arguments are those set above, and `items` groups of lanes lie within the
        // buffers, which outlive the work in the queue, because reading them waits for it.
        unsafe { self.launcher.enqueue(call, items) }
    }

    /// Sends the points of a list, each coordinate separately; zeros fill the last lanes.
    fn send(&mut self, points: &[[f32; 3]]) -> Result<()> {
        let len = self.memory.len;
        let coordinates = match &mut self.memory.coordinates {
            Some(coordinates) => coordinates,
            none => {
                let new = || self.launcher.device.buffer(len);
                none.insert([new()?, new()?, new()?])
            }
        };
        let padded = points.len().next_multiple_of(self.lanes);
        let mut values: Vec<f32> = reserved(padded)?;
        for (c, buffer) in coordinates.iter_mut().enumerate() {
            values.clear();
            values.extend(points.iter().map(|p| p[c]));
            values.resize(padded, 0.0);
            self.launcher.device.write(buffer, &values)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
