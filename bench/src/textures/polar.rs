//! Newton's fractal with powers in polar form, as the thesis describes it, one pixel after the
//! other.

use catamaran_simulation::texture::newton::{Fractal, Grid};
use rayon::prelude::*;

/// Computes z^n - 1 at the pixels of a plane, on the processor. With `stops`, iterations end when a
/// step is short, otherwise after all of them.
pub fn on_processor(grid: &Grid, n: i32, iterations: u32, theta: f32, stops: bool) -> Fractal {
    let [width, height, _] = grid.counts.map(|count| count as usize);
    let mut fractal = Fractal::default();
    fractal.roots.resize(width * height, 0);
    fractal.convergence.resize(width * height, 0.0);
    let rows = fractal.roots.par_chunks_mut(width).zip(fractal.convergence.par_chunks_mut(width));
    rows.enumerate().for_each(|(j, (roots, convergence))| {
        for (i, (root, t)) in roots.iter_mut().zip(convergence).enumerate() {
            let x = grid.origin[0] + i as f32 * grid.steps[0][0];
            let y = grid.origin[1] + j as f32 * grid.steps[1][1];
            (*root, *t) = pixel([x, y], n, iterations as i32 + 1, theta.exp(), stops);
        }
    });
    fractal
}

fn pixel(z: [f32; 2], n: i32, steps: i32, gain: f32, stops: bool) -> (u16, f32) {
    let (mut both, mut sum) = ([z, z], 0.0);
    for k in 0..steps {
        let next = both.map(|z| step(z, n));
        let delta2 = 0.5 * (distance2(next[0], both[0]) + distance2(next[1], both[1]));
        sum += 1.0 / (1.0 + gain * (delta2.sqrt().exp() - 1.0));
        both = next;
        if stops && delta2 < 1e-10 {
            sum += (steps - 1 - k) as f32;
            break;
        }
    }
    let root = |z: [f32; 2]| {
        let k = (z[1].atan2(z[0]) * n as f32 / std::f32::consts::TAU).round() as i32;
        k.rem_euclid(n)
    };
    ((root(both[0]) * n + root(both[1])) as u16, (steps - 1) as f32 - sum)
}

fn step([x, y]: [f32; 2], n: i32) -> [f32; 2] {
    let radius = (x * x + y * y).powf(0.5 * (1 - n) as f32);
    let (sin, cos) = ((1 - n) as f32 * y.atan2(x)).sin_cos();
    [((n - 1) as f32 * x + radius * cos) / n as f32, ((n - 1) as f32 * y + radius * sin) / n as f32]
}

fn distance2(a: [f32; 2], b: [f32; 2]) -> f32 {
    (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2)
}

#[cfg(feature = "opencl")]
pub use device::OnDevice;

#[cfg(feature = "opencl")]
mod device {
    use std::ptr;

    use opencl3::command_queue::CommandQueue;
    use opencl3::context::Context;
    use opencl3::device::{CL_DEVICE_TYPE_ALL, Device, get_all_devices};
    use opencl3::kernel::{ExecuteKernel, Kernel};
    use opencl3::memory::{Buffer, CL_MEM_READ_WRITE};
    use opencl3::program::Program;
    use opencl3::types::CL_BLOCKING;

    use super::{Fractal, Grid};
    use crate::Result;

    /// The same as a kernel.
    pub struct OnDevice {
        queue: CommandQueue,
        kernel: Kernel,
        roots: Buffer<u16>,
        convergence: Buffer<f32>,
        plane: Grid,
        _context: Context,
    }

    impl OnDevice {
        /// Prepares the device with this index for the pixels of this plane.
        ///
        /// # Errors
        /// When the device fails.
        pub fn new(index: usize, plane: &Grid) -> Result<Self> {
            let pixels = plane.counts[0] as usize * plane.counts[1] as usize;
            let id = get_all_devices(CL_DEVICE_TYPE_ALL)?[index];
            let context = Context::from_device(&Device::new(id))?;
            // SAFETY: the device belongs to the context; OpenCL 1.2 does not have the newer call.
            #[allow(deprecated)]
            let queue = unsafe { CommandQueue::create(&context, id, 0) }?;
            let program =
                Program::create_and_build_from_source(&context, include_str!("polar.cl"), "")?;
            // SAFETY: the memory belongs to the device alone.
            let (roots, convergence) = unsafe {
                (
                    Buffer::create(&context, CL_MEM_READ_WRITE, pixels, ptr::null_mut())?,
                    Buffer::create(&context, CL_MEM_READ_WRITE, pixels, ptr::null_mut())?,
                )
            };
            let kernel = Kernel::create(&program, "polar")?;
            Ok(Self { queue, kernel, roots, convergence, plane: *plane, _context: context })
        }

        /// Computes z^n - 1 at the pixels.
        ///
        /// # Errors
        /// When the device fails.
        pub fn run(&self, n: i32, iterations: u32, theta: f32, stops: bool) -> Result<Fractal> {
            let grid = &self.plane;
            let [width, height, _] = grid.counts.map(|count| count as usize);
            let mut fractal = Fractal::default();
            fractal.roots.resize(width * height, 0);
            fractal.convergence.resize(width * height, 0.0);
            // SAFETY: the arguments are those of the kernel; the buffers hold all pixels, and
            // reading waits for the kernel.
            unsafe {
                ExecuteKernel::new(&self.kernel)
                    .set_arg(&grid.origin[0])
                    .set_arg(&grid.origin[1])
                    .set_arg(&grid.steps[0][0])
                    .set_arg(&n)
                    .set_arg(&(iterations as i32 + 1))
                    .set_arg(&theta.exp())
                    .set_arg(&i32::from(stops))
                    .set_arg(&self.roots)
                    .set_arg(&self.convergence)
                    .set_global_work_sizes(&[width, height])
                    .enqueue_nd_range(&self.queue)?;
                self.queue.enqueue_read_buffer(
                    &self.roots,
                    CL_BLOCKING,
                    0,
                    &mut fractal.roots,
                    &[],
                )?;
                let values = &mut fractal.convergence;
                self.queue.enqueue_read_buffer(&self.convergence, CL_BLOCKING, 0, values, &[])?;
            }
            Ok(fractal)
        }
    }
}
