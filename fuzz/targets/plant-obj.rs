//! Any bytes as a plant: a plant or an error.
#![no_main]

use catamaran_simulation::plant::{PlantFormat, read_bytes};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    std::hint::black_box(read_bytes(bytes, PlantFormat::Obj).ok());
});
