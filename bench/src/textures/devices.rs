//! Steps of slime moulds: kernels on a device beside their twins on the processor.

use std::time::Instant;

use catamaran::Par;
use catamaran::mesh::families;
use catamaran::opencl::{Device, SlimeOnDevice};
use catamaran::texture::slime::{Mask, Options, Simulation, Surface, TangentStep, atlas};

use crate::Result;
use crate::plant::Part;
use crate::race::median;

/// Steps that are timed together: one ordering of the twin's agents.
const STEPS: u32 = 16;

/// Seconds a step with a million agents on a sphere of 5,120 triangles and a texture of 2048 x 2048, in turns: unfolded, and with the
/// thesis' 10 sub-steps.
///
/// # Errors
/// Where there is no device.
pub fn slime_times(repeat: usize) -> Result<Part> {
    let device = Device::open("")?;
    let mesh = families::icosphere(4)?;
    let mut rows = Vec::new();
    for (name, tangent_step) in
        [("unfolded", TangentStep::Unfold), ("10 sub-steps", TangentStep::Project { substeps: 10 })]
    {
        let options = Options { tangent_step, ..Options::default() };
        let surface = Surface::of_faces(&mesh, atlas(&mesh, options.size)?)?;
        let mut twin = Simulation::new(surface, &options, &Mask::default())?;
        // A pattern, not the noise of the start.
        twin.run(2 * STEPS, Par::all(), None)?;
        let mut kernels = SlimeOnDevice::new(&device, &twin)?;
        let mut times = [Vec::new(), Vec::new()];
        for _ in 0..repeat {
            let start = Instant::now();
            twin.run(STEPS, Par::all(), None)?;
            times[0].push(start.elapsed().as_secs_f64() / f64::from(STEPS));
            let start = Instant::now();
            kernels.run(STEPS, None)?;
            times[1].push(start.elapsed().as_secs_f64() / f64::from(STEPS));
        }
        let same = kernels.state()?.texture == twin.state().texture;
        let [ours, device] = times.map(median);
        rows.push((name.into(), vec![ours, device, ours / device, f64::from(u8::from(same))]));
    }
    let columns = ["processor, s", "device, s", "processor over device", "textures equal (1: yes)"];
    Ok(Part {
        figure: "slime on devices",
        title: format!(
            "a step, 1,000,000 agents, 2048 x 2048 texels, on {}: median of {repeat} times {STEPS} steps, in turns",
            device.info().name
        ),
        columns: columns.map(String::from).into(),
        rows,
        plots: vec![],
    })
}
