//! Any bytes as GIFTI, or as another mesh if they begin like one: a mesh or an error,
//! and a mesh that can be looked at.
#![no_main]

use catamaran_fuzz::{file, source_options};
use catamaran_geometry::mesh::io::read_with;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    if let Ok(file) = read_with(&file("a.gii", bytes), &source_options()) {
        std::hint::black_box(file.mesh.validate());
    }
});
