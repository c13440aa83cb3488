//! State files of simulations.

use std::io::{self, Read, Write};
use std::path::Path;

use super::simulation::Simulation;
use super::state::State;
use catamaran::base::{Error, Result};

/// The first bytes of a state file; the digit is the version of the format.
const MAGIC: &[u8; 16] = b"catamaran slime1";

/// Number of values that are read and written at a time.
const PIECE: usize = 1 << 14;

impl Simulation {
    /// Returns the numbers with which a state file must agree.
    fn header(&self) -> [u32; 6] {
        let surface = self.surface().fingerprint();
        let p = self.parameters();
        let agents = self.state().triangles.len() as u32;
        [surface as u32, (surface >> 32) as u32, p.seed, p.size, p.species, agents]
    }

    /// Writes the state. A simulation with the same surface and options continues from it exactly
    /// as if it had not stopped. The file is little-endian: 16 bytes that identify the format,
    /// 32-bit numbers for surface, seed, size, species and agents, the step, then the arrays of
    /// [`State`] in their order.
    ///
    /// ```
    /// use catamaran::{Par, base::Progress};
    /// use catamaran_geometry::mesh::families;
    /// use catamaran_simulation::texture::slime::{Mask, Options, Simulation, Surface, atlas};
    ///
    /// let sphere = families::icosphere(1)?;
    /// let begin = || {
    ///     let surface = Surface::of_faces(&sphere, atlas(&sphere, 64)?)?;
    ///     Simulation::new(surface, &Options::new().agents(100).size(64), &Mask::default())
    /// };
    /// let (mut simulation, mut bytes) = (begin()?, Vec::new());
    /// simulation.run(2, Par::Seq, Progress::none())?;
    /// simulation.save(&mut bytes).unwrap();
    ///
    /// let mut resumed = begin()?;
    /// resumed.resume(&mut &bytes[..], "state".as_ref())?;
    /// simulation.run(1, Par::Seq, Progress::none())?;
    /// resumed.run(1, Par::Seq, Progress::none())?;
    /// assert_eq!(resumed.texture(0), simulation.texture(0));
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// The errors of the sink.
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

    /// Reads a state that [`Simulation::save`] wrote, and continues from it. Errors name `path`.
    ///
    /// # Errors
    /// [`Error::Io`] when the file can't be read, is no state file, has no valid state, or belongs
    /// to another surface, seed, size, or number of species or agents; [`Error::OutOfMemory`]. The
    /// state does not change then.
    pub fn resume(&mut self, source: &mut dyn Read, path: &Path) -> Result<()> {
        let failed = |what: String| Error::file(path, what);
        let read = |e: io::Error| match e.kind() {
            io::ErrorKind::UnexpectedEof => {
                failed("is not a state file of slime moulds, or ends early".into())
            }
            _ => Error::io(path, e),
        };
        let mut magic = [0; MAGIC.len()];
        source.read_exact(&mut magic).map_err(read)?;
        if &magic != MAGIC {
            return Err(failed("is not a state file of slime moulds in this version".into()));
        }
        let names = ["surface", "surface", "seed", "size", "number of species", "number of agents"];
        let mut given = [0; 7];
        take(source, &mut given, |bits| bits).map_err(read)?;
        for ((name, own), given) in names.into_iter().zip(self.header()).zip(given) {
            if own != given {
                let numbers =
                    if name == "surface" { String::new() } else { format!(": {given}, not {own}") };
                return Err(failed(format!("was saved with another {name}{numbers}")));
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
            return Err(failed("has data after its end".into()));
        }
        self.set_state(state).map_err(|e| match e {
            Error::Argument { .. } => failed(e.to_string()),
            e => e,
        })
    }
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
