use std::io::{self, Read, Write};
use std::path::Path;

use super::simulation::Simulation;
use super::surface::Surface;
use super::walk::Walker;
use crate::base::{Error, Result, reserved};

/// All that changes in a simulation.
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    /// Steps done.
    pub step: u32,
    /// The number of each agent; every number below their count once, in an order that changes.
    pub ids: Vec<u32>,
    /// The triangle of each agent.
    pub triangles: Vec<u32>,
    /// Positions of agents in the frames of their triangles.
    pub positions: Vec<[f32; 2]>,
    /// Their headings there, of length 1.
    pub headings: Vec<[f32; 2]>,
    /// The texture of each species, one after the other.
    pub texture: Vec<f32>,
}

/// Agents may be this far beyond the edges of their triangle, in the unit of the surface: so much is rounding.
const SLACK: f32 = 1e-4;

impl State {
    pub(super) fn new(walkers: &[Walker], texture: Vec<f32>) -> Result<Self> {
        let mut state = Self { texture, ..Self::filled(walkers.len(), 0)? };
        for (i, walker) in walkers.iter().enumerate() {
            state.put(i, i as u32, *walker);
        }
        Ok(state)
    }

    /// That many agents and entries of the texture, all zero.
    pub(crate) fn filled(agents: usize, entries: usize) -> Result<Self> {
        Ok(Self {
            step: 0,
            ids: filled(agents, 0)?,
            triangles: filled(agents, 0)?,
            positions: filled(agents, [0.0; 2])?,
            headings: filled(agents, [0.0; 2])?,
            texture: filled(entries, 0.0)?,
        })
    }

    /// Keeps an agent in place i.
    pub(crate) fn put(&mut self, i: usize, id: u32, walker: Walker) {
        self.ids[i] = id;
        self.triangles[i] = walker.triangle;
        self.positions[i] = walker.position;
        self.headings[i] = walker.heading;
    }

    /// The agent in place i.
    pub fn agent(&self, i: usize) -> Walker {
        Walker {
            triangle: self.triangles[i],
            position: self.positions[i],
            heading: self.headings[i],
        }
    }

    /// `Ok` when all agents are on their triangles, with a heading of length 1, and all pheromone is from 0 to 1.
    ///
    /// # Errors
    /// [`Error::Argument`] names the first agent or entry of the texture that is not so, [`Error::Shape`] arrays of different
    /// lengths.
    pub fn check(&self, surface: &Surface) -> Result<()> {
        let agents = self.triangles.len();
        Error::check_shape("ids", (agents, 1), (self.ids.len(), 1))?;
        Error::check_shape("positions", (agents, 2), (self.positions.len(), 2))?;
        Error::check_shape("headings", (agents, 2), (self.headings.len(), 2))?;
        let mut seen = filled(agents, false)?;
        for &id in &self.ids {
            match seen.get_mut(id as usize) {
                Some(seen) if !*seen => *seen = true,
                _ => {
                    let why = format!("number {id} of {agents} is twice there, or too large");
                    return Err(Error::Argument { what: "ids", why });
                }
            }
        }
        if let Some(i) = (0..agents).find(|&i| !is_on(surface, self.agent(i))) {
            let why = format!("agent {i} is not on the surface: {:?}", self.agent(i));
            return Err(Error::Argument { what: "agents", why });
        }
        match self.texture.iter().position(|p| !(0.0..=1.0).contains(p)) {
            None => Ok(()),
            Some(at) => Err(Error::Argument {
                what: "texture",
                why: format!("{} at {at}, where 0 to 1 is needed", self.texture[at]),
            }),
        }
    }
}

fn is_on(surface: &Surface, walker: Walker) -> bool {
    let Some(record) = surface.records().get(walker.triangle as usize) else { return false };
    let [x, y] = walker.position;
    let [dx, dy] = walker.heading;
    let inside = |k: usize| record[3 * k] * x + record[3 * k + 1] * y + record[3 * k + 2] >= -SLACK;
    (0..3).all(inside) && (dx * dx + dy * dy - 1.0).abs() < 1e-3
}

/// The first bytes of a state file; the digit is the version of the format.
const MAGIC: &[u8; 16] = b"catamaran slime1";

/// Numbers that are read and written at a time.
const PIECE: usize = 1 << 14;

impl Simulation {
    /// What a state file has to agree with.
    fn header(&self) -> [u32; 6] {
        let surface = self.surface().fingerprint();
        let p = self.parameters();
        let agents = self.state().triangles.len() as u32;
        [surface as u32, (surface >> 32) as u32, p.seed, p.size, p.species, agents]
    }

    /// Writes the state: with it, and the same surface and options, a simulation goes on as if it had never stopped. Little
    /// endian: 16 bytes that name the format, 32-bit numbers that name surface, seed, size, species and agents, the step, then
    /// the arrays of [`State`] in its order.
    ///
    /// # Errors
    /// Those of the sink.
    pub fn save(&self, sink: &mut dyn Write) -> io::Result<()> {
        let state = self.state();
        sink.write_all(MAGIC)?;
        put(sink, self.header().into_iter().chain([state.step]))?;
        put(sink, state.ids.iter().copied())?;
        put(sink, state.triangles.iter().copied())?;
        put(sink, state.positions.as_flattened().iter().map(|x| x.to_bits()))?;
        put(sink, state.headings.as_flattened().iter().map(|x| x.to_bits()))?;
        put(sink, state.texture.iter().map(|x| x.to_bits()))
    }

    /// Goes on from a state that was saved. `path` is what errors name.
    ///
    /// # Errors
    /// [`Error::Io`] when it can't be read, is no state file, or one of another surface, seed, size, or number of species or
    /// agents; [`Error::Argument`] when its contents are no state; [`Error::OutOfMemory`]. The state is as before then.
    pub fn resume(&mut self, source: &mut dyn Read, path: &Path) -> Result<()> {
        let failed = |what: String| Error::Io { path: path.into(), line: 0, what };
        let read = |e: io::Error| failed(e.to_string());
        let mut magic = [0; MAGIC.len()];
        source.read_exact(&mut magic).map_err(read)?;
        if &magic != MAGIC {
            return Err(failed("is not a state of slime moulds of this version".into()));
        }
        let names = ["surface", "surface", "seed", "size", "number of species", "number of agents"];
        let mut given = [0; 7];
        take(source, &mut given, |bits| bits).map_err(read)?;
        for ((name, own), given) in names.into_iter().zip(self.header()).zip(given) {
            if own != given {
                let numbers =
                    if name == "surface" { String::new() } else { format!(": {given}, not {own}") };
                return Err(failed(format!("is of another {name}{numbers}")));
            }
        }
        let agents = self.state().triangles.len();
        let mut state = State::filled(agents, self.state().texture.len())?;
        state.step = given[6];
        take(source, &mut state.ids, |bits| bits).map_err(read)?;
        take(source, &mut state.triangles, |bits| bits).map_err(read)?;
        take(source, state.positions.as_flattened_mut(), f32::from_bits).map_err(read)?;
        take(source, state.headings.as_flattened_mut(), f32::from_bits).map_err(read)?;
        take(source, &mut state.texture, f32::from_bits).map_err(read)?;
        if source.read(&mut [0]).map_err(read)? > 0 {
            return Err(failed("goes on after its end".into()));
        }
        self.set_state(state)
    }
}

fn filled<T: Clone>(len: usize, value: T) -> Result<Vec<T>> {
    let mut all = reserved(len)?;
    all.resize(len, value);
    Ok(all)
}

fn put(sink: &mut dyn Write, words: impl Iterator<Item = u32>) -> io::Result<()> {
    let mut bytes = Vec::with_capacity(4 * PIECE);
    for word in words {
        bytes.extend(word.to_le_bytes());
        if bytes.len() == 4 * PIECE {
            sink.write_all(&bytes)?;
            bytes.clear();
        }
    }
    sink.write_all(&bytes)
}

fn take<T>(source: &mut dyn Read, out: &mut [T], value: impl Fn(u32) -> T) -> io::Result<()> {
    let mut bytes = vec![0; 4 * PIECE];
    for out in out.chunks_mut(PIECE) {
        let bytes = &mut bytes[..4 * out.len()];
        source.read_exact(bytes)?;
        for (out, word) in out.iter_mut().zip(bytes.chunks_exact(4)) {
            *out = value(u32::from_le_bytes([word[0], word[1], word[2], word[3]]));
        }
    }
    Ok(())
}
