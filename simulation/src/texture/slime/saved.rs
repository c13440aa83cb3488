//! State files of simulations, little-endian:
//!
//! | part | content |
//! |---|---|
//! | name | `catamaran slime` and the version of the format, a digit |
//! | options | in the order of [`recorded`], f64 |
//! | rest of the head | checksum of the mask, step, u32; fingerprint of the surface, u64 |
//! | | length of the history, u64 |
//! | check | CRC-32 of everything before, u32 |
//! | body | the arrays of [`State`] in their order, u32 or f32; the history, f64 |
//! | check | CRC-32 of the body, u32 |

use std::cmp::Ordering;
use std::io::{self, Read, Write};
use std::path::Path;

use catamaran::base::{Error, Result};
use crc32fast::Hasher;

use super::options::{Blur, Options, TangentStep};
use super::simulation::{Mask, Simulation};
use super::state::State;

/// The first bytes of a state file.
const NAME: &[u8] = b"catamaran slime";

/// The version of the format; files of another version are refused.
const VERSION: u8 = b'3';

/// Number of 32-bit words that are read and written at a time.
const PIECE: usize = 1 << 14;

/// Number of options.
const OPTIONS: usize = 15;

/// An option of a state file: its name, its value as a number, and how messages show the number.
type Recorded = (&'static str, f64, fn(f64) -> String);

/// Returns the options with which a state file must agree.
fn recorded(options: &Options) -> [Recorded; OPTIONS] {
    let Options {
        agents,
        species,
        size,
        seed,
        time_step,
        movement_speed,
        turn_speed,
        vision_distance,
        vision_angle,
        evaporation_rate,
        diffusion_rate,
        turn_noise,
        tangent_step,
        blur,
        length_rescaling,
    } = *options;
    let number: fn(f64) -> String = |x| x.to_string();
    // The number of substeps, or 0.
    let step: fn(f64) -> String = |x| match x {
        0.0 => "unfold".into(),
        substeps => format!("project with {substeps} substeps"),
    };
    let spread: fn(f64) -> String = |x| if x == 0.0 { "gaussian" } else { "seam-aware" }.into();
    let truth: fn(f64) -> String = |x| (x != 0.0).to_string();
    let substeps = match tangent_step {
        TangentStep::Unfold => 0,
        TangentStep::Project { substeps } => substeps,
    };
    [
        ("agents", agents as f64, number),
        ("species", species as f64, number),
        ("size", size as f64, number),
        ("seed", seed.into(), number),
        ("time_step", time_step, number),
        ("movement_speed", movement_speed, number),
        ("turn_speed", turn_speed, number),
        ("vision_distance", vision_distance, number),
        ("vision_angle", vision_angle, number),
        ("evaporation_rate", evaporation_rate, number),
        ("diffusion_rate", diffusion_rate, number),
        ("turn_noise", turn_noise, number),
        ("tangent_step", substeps.into(), step),
        ("blur", u8::from(blur == Blur::SeamAware).into(), spread),
        ("length_rescaling", u8::from(length_rescaling).into(), truth),
    ]
}

impl Mask {
    /// Returns a checksum that tells masks apart.
    pub(super) fn checksum(&self) -> u32 {
        let mut sum = Hasher::new();
        sum.update(&(self.start.len() as u64).to_le_bytes());
        for starts in self.start.chunks(PIECE) {
            sum.update(&starts.iter().map(|&start| u8::from(start)).collect::<Vec<_>>());
        }
        sum.update(&self.ground);
        sum.finalize()
    }
}

impl Simulation {
    /// Writes the state. A simulation with the same surface, options and mask continues from it
    /// exactly as if it had not stopped. `history` are numbers of the caller about the steps so
    /// far, such as the coverage after each; [`Simulation::resume`] returns them.
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
    /// simulation.save(&mut bytes, &[0.5, 0.25]).unwrap();
    ///
    /// let mut resumed = begin()?;
    /// let history = resumed.resume(&mut &bytes[..], "state".as_ref())?;
    /// assert_eq!(history, [0.5, 0.25]);
    /// simulation.run(1, Par::Seq, Progress::none())?;
    /// resumed.run(1, Par::Seq, Progress::none())?;
    /// assert_eq!(resumed.texture(0), simulation.texture(0));
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// The errors of the sink.
    pub fn save(&self, sink: &mut dyn Write, history: &[f64]) -> io::Result<()> {
        let state = self.state();
        let mut sink = Checked::new(sink);
        sink.put_bytes(NAME)?;
        sink.put_bytes(&[VERSION])?;
        let options = recorded(self.options()).map(|(_, value, _)| halves(value.to_bits()));
        let surface = halves(self.surface().fingerprint());
        let others = [[self.mask_checksum(), state.step], surface, halves(history.len() as u64)];
        sink.put(options.into_iter().chain(others).flatten())?;
        sink.put_check()?;
        sink.put(state.ids.iter().copied())?;
        sink.put(state.triangles.iter().copied())?;
        sink.put(state.positions.as_flattened().iter().map(|x| x.to_bits()))?;
        sink.put(state.headings.as_flattened().iter().map(|x| x.to_bits()))?;
        sink.put(state.texture.iter().map(|x| x.to_bits()))?;
        sink.put(history.iter().flat_map(|x| halves(x.to_bits())))?;
        sink.put_check()
    }

    /// Reads a state that [`Simulation::save`] wrote, continues from it, and returns its history.
    /// Errors name `path`.
    ///
    /// # Errors
    /// [`Error::Io`] when the file can't be read, is no state file of this version, is damaged, has
    /// no valid state, or was saved with another surface, mask or option, which the error names
    /// with both values; [`Error::OutOfMemory`]. The state does not change then.
    pub fn resume(&mut self, source: &mut dyn Read, path: &Path) -> Result<Vec<f64>> {
        let failed = |what: String| Error::file(path, what);
        let read = |e: io::Error| match e.kind() {
            io::ErrorKind::UnexpectedEof => {
                failed("is not a state file of slime moulds, or ends early".into())
            }
            _ => Error::io(path, e),
        };
        let mut source = Checked::new(source);
        let (mut name, mut version) = ([0; NAME.len()], [0]);
        source.get_bytes(&mut name).map_err(read)?;
        source.get_bytes(&mut version).map_err(read)?;
        if name != *NAME {
            return Err(failed("is not a state file of slime moulds".into()));
        }
        match version[0].cmp(&VERSION) {
            Ordering::Less => {
                return Err(failed("was written by an earlier version of catamaran".into()));
            }
            Ordering::Greater => {
                return Err(failed("was written by a later version of catamaran".into()));
            }
            Ordering::Equal => {}
        }
        let mut given = [[0; 2]; OPTIONS + 3];
        source.get(given.as_flattened_mut(), |bits| bits).map_err(read)?;
        if !source.is_sound().map_err(read)? {
            return Err(failed("is damaged: the checksum of its head differs".into()));
        }
        let [.., [mask, step], surface, length] = given;
        for ((name, own, shown), given) in recorded(self.options()).into_iter().zip(given) {
            let given = f64::from_bits(whole(given));
            if own.to_bits() != given.to_bits() {
                let (given, own) = (shown(given), shown(own));
                return Err(failed(format!("was saved with {name} = {given}, not {own}")));
            }
        }
        if mask != self.mask_checksum() {
            return Err(failed("was saved with another mask".into()));
        }
        if whole(surface) != self.surface().fingerprint() {
            return Err(failed("was saved with another surface".into()));
        }
        let agents = self.state().triangles.len();
        let mut state = State::filled(agents, self.state().texture.len())?;
        state.step = step;
        source.get(&mut state.ids, |bits| bits).map_err(read)?;
        source.get(&mut state.triangles, |bits| bits).map_err(read)?;
        source.get(state.positions.as_flattened_mut(), f32::from_bits).map_err(read)?;
        source.get(state.headings.as_flattened_mut(), f32::from_bits).map_err(read)?;
        source.get(&mut state.texture, f32::from_bits).map_err(read)?;
        // Memory grows with the bytes that arrive, whatever the head announces.
        let (mut history, mut left) = (Vec::new(), whole(length));
        while left > 0 {
            let count = left.min(PIECE as u64 / 2) as usize;
            let mut pairs = [[0; 2]; PIECE / 2];
            source.get(pairs[..count].as_flattened_mut(), |bits| bits).map_err(read)?;
            let bytes = size_of::<f64>() * (history.len() + count);
            history.try_reserve(count).map_err(|_| Error::OutOfMemory { bytes })?;
            history.extend(pairs[..count].iter().map(|&pair| f64::from_bits(whole(pair))));
            left -= count as u64;
        }
        if !source.is_sound().map_err(read)? {
            return Err(failed("is damaged: its checksum differs".into()));
        }
        if source.stream.read(&mut [0]).map_err(read)? > 0 {
            return Err(failed("has data after its end".into()));
        }
        self.set_state(state).map_err(|e| match e {
            Error::Argument { .. } => failed(e.to_string()),
            e => e,
        })?;
        Ok(history)
    }
}

/// Returns the lower and the higher half of a number.
fn halves(number: u64) -> [u32; 2] {
    [number as u32, (number >> 32) as u32]
}

/// Returns the number with these halves.
fn whole([low, high]: [u32; 2]) -> u64 {
    u64::from(low) | (u64::from(high) << 32)
}

/// A stream, and the checksum of the bytes that went through it since the last check.
struct Checked<S> {
    stream: S,
    check: Hasher,
}

impl<S> Checked<S> {
    fn new(stream: S) -> Self {
        Self { stream, check: Hasher::new() }
    }
}

impl<S: Write> Checked<S> {
    fn put_bytes(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.check.update(bytes);
        self.stream.write_all(bytes)
    }

    fn put(&mut self, words: impl Iterator<Item = u32>) -> io::Result<()> {
        let mut bytes = Vec::with_capacity(4 * PIECE);
        for word in words {
            bytes.extend(word.to_le_bytes());
            if bytes.len() == 4 * PIECE {
                self.put_bytes(&bytes)?;
                bytes.clear();
            }
        }
        self.put_bytes(&bytes)
    }

    fn put_check(&mut self) -> io::Result<()> {
        let sum = self.check.clone().finalize();
        self.check.reset();
        self.stream.write_all(&sum.to_le_bytes())
    }
}

impl<S: Read> Checked<S> {
    fn get_bytes(&mut self, bytes: &mut [u8]) -> io::Result<()> {
        self.stream.read_exact(bytes)?;
        self.check.update(bytes);
        Ok(())
    }

    fn get<T>(&mut self, out: &mut [T], value: impl Fn(u32) -> T) -> io::Result<()> {
        let mut bytes = vec![0; 4 * PIECE.min(out.len())];
        for out in out.chunks_mut(PIECE) {
            let bytes = &mut bytes[..4 * out.len()];
            self.get_bytes(bytes)?;
            for (out, word) in out.iter_mut().zip(bytes.chunks_exact(4)) {
                *out = value(u32::from_le_bytes([word[0], word[1], word[2], word[3]]));
            }
        }
        Ok(())
    }

    /// Reads a checksum, and returns whether it is that of the bytes before.
    fn is_sound(&mut self) -> io::Result<bool> {
        let sum = self.check.clone().finalize();
        self.check.reset();
        let mut given = [0; 4];
        self.stream.read_exact(&mut given)?;
        Ok(u32::from_le_bytes(given) == sum)
    }
}
