//! Slime moulds on a device.

mod agents;

use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use opencl3::kernel::{ExecuteKernel, Kernel};
use opencl3::memory::Buffer;

use super::session::{Device, Launcher};
use crate::texture::slime::{
    AREA_UNIT, Coverage, EVERY, MOST_HOPS, PHEROMONE_UNIT, Parameters, Simulation, State, TILE,
    sum_of,
};
use agents::{Agents, Ordering};
use catamaran::base::{Error, Progress, Result, reserved};

const SOURCE: &str = include_str!("kernels/slime.cl");

/// Time of the steps between two waits of [`SlimeOnDevice::advance`]: what a caller needs to react
/// to a signal.
const PACE: Duration = Duration::from_millis(50);

/// Most steps between two waits, and most bytes of their sums on the device.
const MOST_STEPS: u32 = 64;
const MOST_BYTES: usize = 4 << 20;

/// A simulation whose agents and textures are on a device: it gives the same bits as
/// [`Simulation::step`] if the device rounds divisions and square roots correctly, as processors
/// do.
///
/// ```
/// use catamaran_simulation::opencl::{Device, SlimeOnDevice};
/// use catamaran_simulation::texture::slime::{Mask, Options, Simulation, Surface, atlas};
/// use catamaran::base::Progress;
/// use catamaran_geometry::mesh::families;
///
/// let Ok(device) = Device::open("") else { return Ok(()) };
/// let sphere = families::icosphere(2)?;
/// let surface = Surface::of_faces(&sphere, atlas(&sphere, 128)?)?;
/// let options = Options::new().agents(1000).size(128);
/// let mut simulation = Simulation::new(surface, &options, &Mask::default())?;
/// let mut on_device = SlimeOnDevice::new(&device, &simulation)?;
/// on_device.run(5, Progress::none())?;
/// on_device.give_back(&mut simulation)?;
/// assert_eq!(simulation.state().step, 5);
/// assert!(simulation.texture(0).iter().any(|&trail| trail > 0.0));
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug)]
pub struct SlimeOnDevice {
    parameters: Parameters,
    step: u32,
    border: usize,
    lanes: usize,
    kernels: Kernels,
    memory: Memory,
    agents: Agents,
    ordering: Ordering,
    launcher: Launcher,
    /// Locked during sums of coverages, whose kernel and memory are shared; the C ABI allows calls
    /// from several threads.
    covering: Mutex<()>,
    /// Number of steps whose sums have room on the device.
    slots: u32,
    /// Number of steps that take about [`PACE`].
    pace: u32,
}

#[derive(Debug)]
struct Kernels {
    agents: Kernel,
    deposit: Kernel,
    diffuse: Kernel,
    border: Kernel,
    cover: Kernel,
    bytes: Kernel,
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
    areas: Buffer<f32>,
    /// Sums of coverages, of [`SlimeOnDevice::slots`] steps.
    sums: Buffer<u64>,
    /// A texture as bytes; allocated for the first frame.
    bytes: Option<Buffer<u8>>,
    marks: Buffer<u32>,
    texture: Buffer<f32>,
    next: Buffer<f32>,
}

impl SlimeOnDevice {
    /// Copies the simulation in its current state to a device.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`], [`Error::Backend`] when the device fails.
    pub fn new(device: &Device, simulation: &Simulation) -> Result<Self> {
        Self::in_groups(device, simulation, None)
    }

    /// Copies a simulation as [`SlimeOnDevice::new`] does, with work-groups of this number of
    /// work-items, instead of the driver's choice; the result does not depend on the number.
    ///
    /// # Errors
    /// As [`SlimeOnDevice::new`]; [`Error::Argument`] for a group of 0.
    pub fn in_groups(
        device: &Device,
        simulation: &Simulation,
        group: Option<usize>,
    ) -> Result<Self> {
        if group == Some(0) {
            return Err(Error::Argument { what: "group", why: "must be at least 1, is 0".into() });
        }
        let lanes = device.lanes();
        let options = format!(
            "-DLANES={lanes} -DMOST_HOPS={MOST_HOPS} -DTILE={TILE} -DAREA_UNIT={AREA_UNIT:e}f \
             -DPHEROMONE_UNIT={PHEROMONE_UNIT:e}f"
        );
        let kernel = |name| device.kernel(SOURCE, &options, name);
        let kernels = Kernels {
            agents: kernel("slime_agents")?,
            deposit: kernel("slime_deposit")?,
            diffuse: kernel("slime_diffuse")?,
            border: kernel("slime_border")?,
            cover: kernel("slime_cover")?,
            bytes: kernel("slime_bytes")?,
        };
        let (surface, texels, state) =
            (simulation.surface(), simulation.texels(), simulation.state());
        let parameters = *simulation.parameters();
        let entries = state.texture.len();
        let mut no_marks: Vec<u32> = reserved(entries / 32)?;
        no_marks.resize(entries / 32, 0);
        let sums = 2 * lines_of(&parameters);
        let slots = (MOST_BYTES / (sums * size_of::<u64>())).clamp(1, MOST_STEPS as usize);
        let memory = Memory {
            turns: device.filled(parameters.turns.as_flattened())?,
            records: device.filled(surface.records().as_flattened())?,
            across: device.filled(surface.across().as_flattened())?,
            frames: device.filled(surface.frames().as_flattened())?,
            kinds: device.filled(texels.kinds())?,
            ground: device.filled(simulation.ground())?,
            has_ground: !simulation.ground().is_empty(),
            border: device.filled(texels.border())?,
            link_starts: device.filled(texels.link_starts())?,
            links: device.filled(texels.links())?,
            link_weights: device.filled(texels.link_weights())?,
            areas: device.filled(texels.areas())?,
            sums: device.buffer(slots * sums)?,
            bytes: None,
            marks: device.filled(&no_marks)?,
            texture: device.filled(&state.texture)?,
            next: device.buffer(entries)?,
        };
        Ok(Self {
            parameters,
            step: state.step,
            border: if parameters.seam_aware != 0 { texels.border().len() } else { 0 },
            lanes,
            kernels,
            memory,
            agents: Agents::of(device, state)?,
            ordering: Ordering::new(device, kernel, state.ids.len(), parameters.size)?,
            launcher: Launcher { device: device.clone(), group, what: "slime" },
            covering: Mutex::new(()),
            slots: slots as u32,
            pace: 1,
        })
    }

    /// Computes `steps` steps. `progress` is called after each; without a callback, the host waits
    /// only at the end.
    ///
    /// # Errors
    /// [`Error::Backend`] when the device fails; [`Error::Cancelled`]: earlier steps are complete,
    /// and a later call can continue.
    pub fn run(&mut self, steps: u32, progress: Progress<'_>) -> Result<()> {
        for done in 1..=steps {
            self.enqueue_step()?;
            if progress.is_watched() {
                self.wait()?;
                progress.report(f64::from(done) / f64::from(steps))?;
            }
        }
        self.wait()
    }

    /// Computes at least one and at most `most` steps, as many as take about a twentieth of a
    /// second, and returns the coverage of each species after each of them. The host waits once.
    ///
    /// ```
    /// use catamaran::Par;
    /// use catamaran_simulation::opencl::{Device, SlimeOnDevice};
    /// use catamaran_simulation::texture::slime::{Mask, Options, Simulation, Surface};
    ///
    /// let Ok(device) = Device::open("") else { return Ok(()) };
    /// let options = Options::new().agents(1000).size(128);
    /// let mut simulation = Simulation::new(Surface::tile()?, &options, &Mask::default())?;
    /// let mut on_device = SlimeOnDevice::new(&device, &simulation)?;
    /// let mut covered = Vec::new();
    /// while covered.len() < 5 {
    ///     covered.extend(on_device.advance(5 - covered.len() as u32)?);
    /// }
    /// assert_eq!(on_device.steps(), 5);
    /// assert_eq!(covered[4], on_device.coverage()?);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Argument`] when `most` is 0, [`Error::OutOfMemory`], [`Error::Backend`] when the
    /// device fails.
    pub fn advance(&mut self, most: u32) -> Result<Vec<Vec<Coverage>>> {
        if most == 0 {
            return Err(Error::Argument { what: "most", why: "must be at least 1, is 0".into() });
        }
        let (start, count) = (Instant::now(), self.pace.min(most));
        for slot in 0..count {
            self.enqueue_step()?;
            self.enqueue_cover(slot)?;
        }
        let covered = self.covered(count)?;
        match start.elapsed() {
            took if took > PACE => self.pace = (self.pace / 2).max(1),
            took if took < PACE / 2 && count == self.pace => {
                self.pace = (2 * self.pace).min(self.slots);
            }
            _ => {}
        }
        Ok(covered)
    }

    /// Returns the device of the simulation.
    pub fn device(&self) -> &Device {
        &self.launcher.device
    }

    /// Returns the number of steps done, including those of the original simulation.
    pub fn steps(&self) -> u32 {
        self.step
    }

    /// Copies the current texture of a species to `texture`, and nothing else from the device.
    ///
    /// ```no_run
    /// use catamaran_simulation::opencl::{Device, SlimeOnDevice};
    /// use catamaran_simulation::texture::slime::{Mask, Options, Simulation, Surface};
    ///
    /// let options = Options::new().agents(1000).size(128);
    /// let simulation = Simulation::new(Surface::tile()?, &options, &Mask::default())?;
    /// let on_device = SlimeOnDevice::new(&Device::open("")?, &simulation)?;
    /// let mut texture = vec![1.0; 128 * 128];
    /// on_device.read_texture(0, &mut texture)?;
    /// assert_eq!(texture[0], 0.0); // no pheromone before the first step
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Argument`] for a species that does not exist, [`Error::Shape`] for a texture of
    /// another size, [`Error::Backend`] when the device fails.
    pub fn read_texture(&self, species: usize, texture: &mut [f32]) -> Result<()> {
        let plane = self.plane_of(species, texture.len())?;
        self.device().read_from(&self.memory.texture, species * plane, texture)
    }

    /// Copies the current texture of a species as bytes, as [`Simulation::frame`] does: the device
    /// converts it, and a quarter of its memory is transferred.
    ///
    /// # Errors
    /// As [`SlimeOnDevice::read_texture`]; [`Error::OutOfMemory`].
    pub fn frame(&mut self, species: usize, frame: &mut [u8]) -> Result<()> {
        let plane = self.plane_of(species, frame.len())?;
        let bytes = match self.memory.bytes.take() {
            Some(bytes) => bytes,
            None => self.device().buffer(plane)?,
        };
        let bytes = self.memory.bytes.insert(bytes);
        let mut call = ExecuteKernel::new(&self.kernels.bytes);
        // SAFETY: numbers and types are those that the kernel declares; the species has `plane`
        // texels in the texture, and so many bytes have room. The buffers outlive the work in the
        // queue, because reading the bytes waits for it.
        unsafe {
            call.set_arg(&(plane as u32)).set_arg(&((species * plane) as u32));
            call.set_arg(&self.memory.texture).set_arg(&*bytes);
            self.launcher.enqueue(call, plane)?;
        }
        self.launcher.device.read(bytes, frame)
    }

    /// Returns the number of texels of a species, after a check that it exists and that a picture
    /// has so many.
    fn plane_of(&self, species: usize, texels: usize) -> Result<usize> {
        let (size, count) = (self.parameters.size as usize, self.parameters.species as usize);
        if species >= count {
            let why = format!("must be below {count}, is {species}");
            return Err(Error::Argument { what: "species", why });
        }
        Error::check_shape("texture", (size * size, 1), (texels, 1))?;
        Ok(size * size)
    }

    /// Returns the current agents, in the order of their numbers, and the current textures.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`], [`Error::Backend`] when the device fails.
    pub fn state(&self) -> Result<State> {
        let mut state = self.agents.read(self.device())?;
        let size = self.parameters.size as usize;
        let entries = self.parameters.species as usize * size * size;
        state.step = self.step;
        state.texture = self.device().values(&self.memory.texture, entries)?;
        Ok(state)
    }

    /// Computes [`Simulation::coverage`] on the device.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`], [`Error::Backend`] when the device fails.
    pub fn coverage(&self) -> Result<Vec<Coverage>> {
        let _one_at_a_time = self.covering.lock().unwrap_or_else(PoisonError::into_inner);
        self.enqueue_cover(0)?;
        Ok(self.covered(1)?.swap_remove(0))
    }

    /// Enqueues the sums of the coverage of the current textures.
    fn enqueue_cover(&self, slot: u32) -> Result<()> {
        let (p, m) = (&self.parameters, &self.memory);
        // Rows on processors, which read consecutive numbers; columns on graphics cards, whose
        // work-items read side by side.
        let (across, along) = if self.lanes > 1 { (p.size, 1) } else { (1, p.size) };
        let lines = lines_of(p);
        let mut call = ExecuteKernel::new(&self.kernels.cover);
        // SAFETY: numbers and types are those that the kernel declares, and `lines` work-items stay
        // within the buffers, where `slots` steps have room. They outlive the work in the queue,
        // because reading the sums waits for it.
        unsafe {
            call.set_arg(&p.size).set_arg(&p.species).set_arg(&across).set_arg(&along);
            call.set_arg(&(slot * lines as u32));
            call.set_arg(&m.areas).set_arg(&m.texture).set_arg(&m.sums);
            self.launcher.enqueue(call, lines)
        }
    }

    /// Returns the coverages of the first `count` slots.
    fn covered(&self, count: u32) -> Result<Vec<Vec<Coverage>>> {
        let lines = lines_of(&self.parameters);
        let sums: Vec<u64> = self.device().values(&self.memory.sums, 2 * lines * count as usize)?;
        let of = |sums: &[[u64; 2]]| sum_of(sums.iter().copied()).into();
        let steps = sums.as_chunks().0.chunks(lines);
        Ok(steps.map(|step| step.chunks(self.parameters.size as usize).map(of).collect()).collect())
    }

    /// Copies the current agents and textures to `simulation`, usually the one from which this one
    /// was created.
    ///
    /// # Errors
    /// As [`SlimeOnDevice::state`], and [`Error::Shape`] for a simulation with another number of
    /// agents or texels.
    pub fn give_back(&self, simulation: &mut Simulation) -> Result<()> {
        simulation.put_state(self.state()?)
    }

    fn wait(&self) -> Result<()> {
        self.device().finish("slime")
    }

    /// Enqueues all kernels of a step, one after the other; the queue keeps their order.
    fn enqueue_step(&mut self) -> Result<()> {
        if self.step.is_multiple_of(EVERY) {
            self.ordering.order(&self.launcher, &self.memory.records, &mut self.agents)?;
        }
        let (p, m, k, a) = (&self.parameters, &self.memory, &self.kernels, &self.agents);
        let plane = p.size * p.size;
        let words = plane / 32 * p.species;
        let lines = lines_of(p);
        let mut calls = [&k.agents, &k.deposit, &k.diffuse, &k.border].map(ExecuteKernel::new);
        let [moving, deposit, diffuse, border] = &mut calls;
        let items = [
            a.len(),
            words as usize,
            lines * (p.size as usize / self.lanes),
            self.border * p.species as usize,
        ];
        // SAFETY: numbers and types are those that the kernels declare, and the buffers have the
        // lengths given in simulation/src/texture/slime/mod.rs. They outlive the work in the queue,
        // because reading them, and `run`, wait for it.
        unsafe {
            moving.set_arg(&(a.len() as u32)).set_arg(&self.step).set_arg(&p.seed).set_arg(&p.size);
            moving.set_arg(&p.species).set_arg(&p.substeps).set_arg(&p.rescale);
            moving.set_arg(&p.sense).set_arg(&p.advance).set_arg(&p.vision).set_arg(&m.turns);
            moving.set_arg(&p.attraction).set_arg(&m.records).set_arg(&m.across);
            moving.set_arg(&m.frames).set_arg(&m.texture).set_arg(&m.ground);
            moving.set_arg(&i32::from(m.has_ground));
            a.set_args(moving);
            moving.set_arg(&m.marks);
            deposit.set_arg(&words).set_arg(&m.marks).set_arg(&m.texture);
            diffuse.set_arg(&p.size).set_arg(&(lines as u32)).set_arg(&p.blend);
            diffuse.set_arg(&p.evaporation).set_arg(&p.seam_aware).set_arg(&m.kinds);
            diffuse.set_arg(&m.texture).set_arg(&m.next);
            border.set_arg(&(self.border as u32)).set_arg(&plane).set_arg(&p.species);
            border.set_arg(&p.blend).set_arg(&p.evaporation).set_arg(&m.border);
            border.set_arg(&m.link_starts).set_arg(&m.links).set_arg(&m.link_weights);
            border.set_arg(&m.texture).set_arg(&m.next);
            for (call, items) in calls.into_iter().zip(items) {
                self.launcher.enqueue(call, items)?;
            }
        }
        std::mem::swap(&mut self.memory.texture, &mut self.memory.next);
        self.step = self.step.wrapping_add(1);
        Ok(())
    }
}

/// Returns the number of rows of the textures of all species.
fn lines_of(parameters: &Parameters) -> usize {
    parameters.size as usize * parameters.species as usize
}

/// The buffers are freed afterwards, so no work may be left in the queue.
impl Drop for SlimeOnDevice {
    fn drop(&mut self) {
        // An error of the device was reported by the previous call.
        let _ = self.wait();
    }
}

#[cfg(test)]
mod tests;
