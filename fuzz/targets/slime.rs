//! Any bytes as the state of slime moulds on one surface, between a head that fits and a checksum
//! that holds or, behind a zero, as they are: a state from which the simulation goes on, or an
//! error.
#![no_main]

use std::path::Path;
use std::sync::{LazyLock, Mutex};

use catamaran::Par;
use catamaran::base::Progress;
use catamaran_geometry::mesh::families;
use catamaran_simulation::texture::slime::{Mask, Options, Simulation, Surface, atlas};

/// Bytes of a state file before the arrays: name, head and its checksum.
const HEADER: usize = 16 + 9 * 4 + 4;

/// One for all inputs: a state that is resumed is the whole of it.
static SIMULATION: LazyLock<Mutex<Simulation>> = LazyLock::new(|| {
    let sphere = families::icosphere(0).expect("an icosahedron");
    let surface = Surface::of_faces(&sphere, atlas(&sphere, 32).expect("an atlas"));
    let options = Options::new().agents(20).size(32);
    let simulation = Simulation::new(surface.expect("a surface"), &options, &Mask::default());
    Mutex::new(simulation.expect("a simulation"))
});

/// What a state of it begins with.
static HEAD: LazyLock<Vec<u8>> = LazyLock::new(|| {
    let mut bytes = Vec::new();
    let simulation = SIMULATION.lock().expect("no panic before");
    simulation.save(&mut bytes, &[0.25; 3]).expect("memory for a state");
    bytes.truncate(HEADER);
    bytes
});

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let mut state = Vec::new();
    match bytes {
        [0, own @ ..] => state.extend(own),
        _ => {
            state.extend(&*HEAD);
            state.extend(bytes);
            state.extend(crc32fast::hash(bytes).to_le_bytes());
        }
    }
    let mut simulation = SIMULATION.lock().expect("no panic before");
    if simulation.resume(&mut &state[..], Path::new("state")).is_ok() {
        simulation.run(2, Par::Seq, Progress::none()).expect("steps of a state that is one");
        simulation.state().check(simulation.surface()).expect("a state after two steps");
    }
});
