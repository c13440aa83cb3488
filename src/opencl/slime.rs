//! Slime moulds on a device.

use opencl3::kernel::{ExecuteKernel, Kernel};
use opencl3::memory::Buffer;

use super::session::{Device, Number};
use crate::base::{Error, Flow, Progress, Result, reserved};
use crate::texture::slime::{MOST_HOPS, Parameters, Simulation, State};

const SOURCE: &str = include_str!("kernels/slime.cl");

/// A simulation whose agents and textures are on a device: the same bits as [`Simulation::step`] where the device rounds
/// divisions and square roots correctly, as processors do.
#[derive(Debug)]
pub struct SlimeOnDevice<'a> {
    device: &'a Device,
    parameters: Parameters,
    step: u32,
    agents: usize,
    border: usize,
    group: Option<usize>,
    lanes: usize,
    kernels: Kernels,
    memory: Memory,
}

#[derive(Debug)]
struct Kernels {
    agents: Kernel,
    deposit: Kernel,
    diffuse: Kernel,
    border: Kernel,
}

#[derive(Debug)]
struct Memory {
    turns: Buffer<f32>,
    records: Buffer<f32>,
    across: Buffer<u32>,
    frames: Buffer<f32>,
    kinds: Buffer<u8>,
    ground: Buffer<u8>,
    has_ground: bool,
    border: Buffer<u32>,
    link_starts: Buffer<u32>,
    links: Buffer<u32>,
    link_weights: Buffer<f32>,
    ids: Buffer<u32>,
    triangles: Buffer<u32>,
    positions: Buffer<f32>,
    headings: Buffer<f32>,
    marks: Buffer<u32>,
    texture: Buffer<f32>,
    next: Buffer<f32>,
}

impl<'a> SlimeOnDevice<'a> {
    /// The simulation as it is now, on a device.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`], [`Error::Backend`] when the device refuses.
    pub fn new(device: &'a Device, simulation: &Simulation) -> Result<Self> {
        Self::in_groups(device, simulation, None)
    }

    /// [`SlimeOnDevice::new`] with work-groups of this many work-items, instead of as many as the driver likes; nothing
    /// depends on it.
    ///
    /// # Errors
    /// As [`SlimeOnDevice::new`]; [`Error::Argument`] for a group of 0.
    pub fn in_groups(
        device: &'a Device,
        simulation: &Simulation,
        group: Option<usize>,
    ) -> Result<Self> {
        if group == Some(0) {
            return Err(Error::Argument { what: "group", why: "must be at least 1, is 0".into() });
        }
        let lanes = device.lanes();
        let options = format!("-DLANES={lanes} -DMOST_HOPS={MOST_HOPS}");
        let kernel = |name| device.kernel(SOURCE, &options, name);
        let kernels = Kernels {
            agents: kernel("slime_agents")?,
            deposit: kernel("slime_deposit")?,
            diffuse: kernel("slime_diffuse")?,
            border: kernel("slime_border")?,
        };
        let (surface, texels, state) =
            (simulation.surface(), simulation.texels(), simulation.state());
        let parameters = *simulation.parameters();
        let entries = state.texture.len();
        let mut no_marks: Vec<u32> = reserved(entries / 32)?;
        no_marks.resize(entries / 32, 0);
        let memory = Memory {
            turns: filled(device, parameters.turns.as_flattened())?,
            records: filled(device, surface.records().as_flattened())?,
            across: filled(device, surface.across().as_flattened())?,
            frames: filled(device, surface.frames().as_flattened())?,
            kinds: filled(device, texels.kinds())?,
            ground: filled(device, simulation.ground())?,
            has_ground: !simulation.ground().is_empty(),
            border: filled(device, texels.border())?,
            link_starts: filled(device, texels.link_starts())?,
            links: filled(device, texels.links())?,
            link_weights: filled(device, texels.link_weights())?,
            ids: filled(device, &state.ids)?,
            triangles: filled(device, &state.triangles)?,
            positions: filled(device, state.positions.as_flattened())?,
            headings: filled(device, state.headings.as_flattened())?,
            marks: filled(device, &no_marks)?,
            texture: filled(device, &state.texture)?,
            next: device.buffer(entries)?,
        };
        Ok(Self {
            device,
            parameters,
            step: state.step,
            agents: state.ids.len(),
            border: if parameters.seam_aware != 0 { texels.border().len() } else { 0 },
            group,
            lanes,
            kernels,
            memory,
        })
    }

    /// Steps; `progress` is told after each, and without it the device is left alone until all are done.
    ///
    /// # Errors
    /// [`Error::Backend`] when the device refuses; [`Error::Cancelled`]: the steps before are done then, and it can go on.
    pub fn run(&mut self, steps: u32, progress: Option<Progress<'_>>) -> Result<()> {
        for done in 1..=steps {
            self.enqueue_step()?;
            if let Some(progress) = progress {
                self.wait()?;
                if progress(f64::from(done) / f64::from(steps)) == Flow::Cancel {
                    return Err(Error::Cancelled);
                }
            }
        }
        self.wait()
    }

    /// Agents and textures as they are now.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`], [`Error::Backend`] when the device refuses.
    pub fn state(&self) -> Result<State> {
        let (device, memory, agents) = (self.device, &self.memory, self.agents);
        let pairs = |buffer: &Buffer<f32>| -> Result<Vec<[f32; 2]>> {
            let mut pairs = reserved(agents)?;
            pairs.resize(agents, [0.0; 2]);
            device.read(buffer, pairs.as_flattened_mut())?;
            Ok(pairs)
        };
        let size = self.parameters.size as usize;
        Ok(State {
            step: self.step,
            ids: read(device, &memory.ids, agents)?,
            triangles: read(device, &memory.triangles, agents)?,
            positions: pairs(&memory.positions)?,
            headings: pairs(&memory.headings)?,
            texture: read(device, &memory.texture, self.parameters.species as usize * size * size)?,
        })
    }

    /// Gives agents and textures as they are now to the simulation that this began with.
    ///
    /// # Errors
    /// As [`SlimeOnDevice::state`], and [`Error::Shape`] for a simulation of other numbers of agents or texels.
    pub fn give_back(&self, simulation: &mut Simulation) -> Result<()> {
        simulation.put_state(self.state()?)
    }

    fn wait(&self) -> Result<()> {
        self.device.queue().finish().map_err(|e| self.device.failed("slime", e))
    }

    /// All kernels of a step, one after the other; the queue keeps their order.
    fn enqueue_step(&mut self) -> Result<()> {
        let (p, m, k) = (&self.parameters, &self.memory, &self.kernels);
        let plane = p.size * p.size;
        let words = plane / 32 * p.species;
        let lines = p.size * p.species;
        let agents = self.agents as u32;
        let mut calls = [
            ExecuteKernel::new(&k.agents),
            ExecuteKernel::new(&k.deposit),
            ExecuteKernel::new(&k.diffuse),
            ExecuteKernel::new(&k.border),
        ];
        let [moving, deposit, diffuse, border] = &mut calls;
        // SAFETY: numbers and types are those that the kernels declare, and the buffers have the lengths that
        // src/texture/slime/mod.rs says.
        unsafe {
            moving.set_arg(&agents).set_arg(&self.step).set_arg(&p.seed).set_arg(&p.size);
            moving.set_arg(&p.species).set_arg(&p.substeps).set_arg(&p.rescale);
            moving.set_arg(&p.sense).set_arg(&p.advance).set_arg(&p.vision).set_arg(&m.turns);
            moving.set_arg(&p.attraction).set_arg(&m.records).set_arg(&m.across);
            moving.set_arg(&m.frames).set_arg(&m.texture).set_arg(&m.ground);
            moving.set_arg(&i32::from(m.has_ground)).set_arg(&m.ids).set_arg(&m.triangles);
            moving.set_arg(&m.positions).set_arg(&m.headings).set_arg(&m.marks);
            deposit.set_arg(&words).set_arg(&m.marks).set_arg(&m.texture);
            diffuse.set_arg(&p.size).set_arg(&lines).set_arg(&p.blend).set_arg(&p.evaporation);
            diffuse.set_arg(&p.seam_aware).set_arg(&m.kinds).set_arg(&m.texture).set_arg(&m.next);
            border.set_arg(&(self.border as u32)).set_arg(&plane).set_arg(&p.species);
            border.set_arg(&p.blend).set_arg(&p.evaporation).set_arg(&m.border);
            border.set_arg(&m.link_starts).set_arg(&m.links).set_arg(&m.link_weights);
            border.set_arg(&m.texture).set_arg(&m.next);
        }
        let items = [
            self.agents,
            words as usize,
            lines as usize * (p.size as usize / self.lanes),
            self.border * p.species as usize,
        ];
        for (mut call, items) in calls.into_iter().zip(items).filter(|(_, items)| *items > 0) {
            match self.group {
                Some(group) => call
                    .set_global_work_size(items.next_multiple_of(group))
                    .set_local_work_size(group),
                None => call.set_global_work_size(items),
            };
            // SAFETY: as above; the buffers live as long as the queue's work, which reading them, and `run`, wait for.
            let queued = unsafe { call.enqueue_nd_range(self.device.queue()) };
            queued.map_err(|e| self.device.failed("slime", e))?;
        }
        std::mem::swap(&mut self.memory.texture, &mut self.memory.next);
        self.step = self.step.wrapping_add(1);
        Ok(())
    }
}

/// Buffers go away with this; no work may be left on them.
impl Drop for SlimeOnDevice<'_> {
    fn drop(&mut self) {
        // Whatever is wrong with the device, its user was told by the call before.
        let _ = self.wait();
    }
}

/// These numbers on the device.
fn filled<T: Number>(device: &Device, values: &[T]) -> Result<Buffer<T>> {
    let mut buffer = device.buffer(values.len())?;
    device.write(&mut buffer, values)?;
    Ok(buffer)
}

fn read<T: Number + Default>(device: &Device, buffer: &Buffer<T>, len: usize) -> Result<Vec<T>> {
    let mut values = reserved(len)?;
    values.resize(len, T::default());
    device.read(buffer, &mut values)?;
    Ok(values)
}

#[cfg(test)]
mod tests;
