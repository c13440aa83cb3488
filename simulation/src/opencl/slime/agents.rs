//! Agents on a device, and their ordering.

use std::mem::swap;

use opencl3::kernel::{ExecuteKernel, Kernel};
use opencl3::memory::Buffer;

use crate::opencl::session::{Device, Launcher};
use crate::texture::slime::{State, TILE, Walker};
use catamaran::base::{Error, Result, reserved};

/// The agents of a [`State`].
#[derive(Debug)]
pub(super) struct Agents {
    len: usize,
    ids: Buffer<u32>,
    triangles: Buffer<u32>,
    positions: Buffer<f32>,
    headings: Buffer<f32>,
}

impl Agents {
    /// Copies the agents of a state.
    pub(super) fn of(device: &Device, state: &State) -> Result<Self> {
        Ok(Self {
            len: state.ids.len(),
            ids: device.filled(&state.ids)?,
            triangles: device.filled(&state.triangles)?,
            positions: device.filled(state.positions.as_flattened())?,
            headings: device.filled(state.headings.as_flattened())?,
        })
    }

    /// Allocates memory for `len` agents.
    fn room(device: &Device, len: usize) -> Result<Self> {
        Ok(Self {
            len,
            ids: device.buffer(len)?,
            triangles: device.buffer(len)?,
            positions: device.buffer(2 * len)?,
            headings: device.buffer(2 * len)?,
        })
    }

    /// Returns the number of agents.
    pub(super) fn len(&self) -> usize {
        self.len
    }

    /// Sets the next four arguments of a call.
    ///
    /// # Safety
    /// The kernel declares them: numbers and triangles of 32 bits, pairs of positions and headings.
    pub(super) unsafe fn set_args(&self, call: &mut ExecuteKernel<'_>) {
        // SAFETY: by the contract the kernel declares these four, in this order; the buffers have
        // the lengths that `room` gave them.
        unsafe {
            call.set_arg(&self.ids).set_arg(&self.triangles);
            call.set_arg(&self.positions).set_arg(&self.headings);
        }
    }

    /// Returns a state of the agents, each at the index of its number, without a texture.
    pub(super) fn read(&self, device: &Device) -> Result<State> {
        let ids = device.values(&self.ids, self.len)?;
        let triangles = device.values(&self.triangles, self.len)?;
        let positions: Vec<f32> = device.values(&self.positions, 2 * self.len)?;
        let headings: Vec<f32> = device.values(&self.headings, 2 * self.len)?;
        let pairs = positions.as_chunks().0.iter().zip(headings.as_chunks().0);
        let mut state = State::filled(self.len, 0)?;
        for ((&id, &triangle), (&position, &heading)) in ids.iter().zip(&triangles).zip(pairs) {
            if id as usize >= self.len {
                let name = device.info().name.clone();
                let why = format!("agent {id} is out of range");
                return Err(Error::Backend { name, why, cause: None });
            }
            state.put(id as usize, id, Walker { triangle, position, heading });
        }
        Ok(state)
    }
}

/// Orders agents by tiles of the texture, like its counterpart on the CPU, except that the order
/// within a tile is arbitrary. The host waits for nothing.
#[derive(Debug)]
pub(super) struct Ordering {
    count: Kernel,
    sums: Kernel,
    before: Kernel,
    firsts: Kernel,
    place: Kernel,
    size: u32,
    tiles: u32,
    /// Number of tiles that a work-item sums.
    run: u32,
    memory: Memory,
    spare: Agents,
}

/// Numbers of tiles, and of runs of tiles.
#[derive(Debug)]
struct Memory {
    /// The agents in each tile; zero between orderings.
    counts: Buffer<u32>,
    sums: Buffer<u32>,
    firsts: Buffer<u32>,
}

impl Ordering {
    /// Creates the ordering with kernels by name, for a texture of `size` x `size` texels.
    pub(super) fn new(
        device: &Device,
        kernel: impl Fn(&'static str) -> Result<Kernel>,
        agents: usize,
        size: u32,
    ) -> Result<Self> {
        let tiles = (size as usize / TILE).pow(2);
        let mut counts = reserved(tiles)?;
        counts.resize(tiles, 0);
        // As many runs as tiles in a run: all sums are short, also the one over all runs.
        let run = tiles.isqrt().max(1);
        Ok(Self {
            count: kernel("slime_count")?,
            sums: kernel("slime_sums")?,
            before: kernel("slime_before")?,
            firsts: kernel("slime_firsts")?,
            place: kernel("slime_place")?,
            size,
            tiles: tiles as u32,
            run: run as u32,
            memory: Memory {
                counts: device.filled(&counts)?,
                sums: device.buffer(tiles.div_ceil(run))?,
                firsts: device.buffer(tiles)?,
            },
            spare: Agents::room(device, agents)?,
        })
    }

    /// Enqueues the kernels that order the agents.
    pub(super) fn order(
        &mut self,
        launcher: &Launcher,
        records: &Buffer<f32>,
        agents: &mut Agents,
    ) -> Result<()> {
        let (count, tiles, run, m) = (agents.len as u32, self.tiles, self.run, &self.memory);
        let runs = tiles.div_ceil(run);
        let mut call = ExecuteKernel::new(&self.count);
        // SAFETY: numbers and types are those that the kernel declares; texels are in tiles, whose
        // number is that of the buffer.
        unsafe {
            call.set_arg(&count).set_arg(&self.size).set_arg(records);
            call.set_arg(&agents.triangles).set_arg(&agents.positions).set_arg(&m.counts);
            launcher.enqueue(call, agents.len)?;
        }
        let [mut sums, mut before, mut firsts] =
            [&self.sums, &self.before, &self.firsts].map(ExecuteKernel::new);
        // SAFETY: as above; runs cover the tiles, and each has an entry in the sums.
        unsafe {
            sums.set_arg(&tiles).set_arg(&run).set_arg(&m.counts).set_arg(&m.sums);
            launcher.enqueue(sums, runs as usize)?;
            before.set_arg(&runs).set_arg(&m.sums);
            launcher.enqueue(before, 1)?;
            firsts.set_arg(&tiles).set_arg(&run).set_arg(&m.counts).set_arg(&m.sums);
            firsts.set_arg(&m.firsts);
            launcher.enqueue(firsts, runs as usize)?;
        }
        let mut call = ExecuteKernel::new(&self.place);
        // SAFETY: as above, and positions are below the number of agents, because the counts of the
        // same tiles sum to it.
        unsafe {
            call.set_arg(&count).set_arg(&self.size).set_arg(records);
            agents.set_args(&mut call);
            call.set_arg(&m.firsts);
            self.spare.set_args(&mut call);
            launcher.enqueue(call, agents.len)?;
        }
        swap(agents, &mut self.spare);
        Ok(())
    }
}
