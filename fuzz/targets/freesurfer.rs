//! Any bytes as a surface of FreeSurfer, or as another mesh if they begin like one: a mesh or an
//! error, and a mesh that can be looked at; and as values and labels of vertices.
#![no_main]

use catamaran_fuzz::{file, source_options};
use catamaran_geometry::mesh::io::{read_scalars, read_with};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    if let Ok(file) = read_with(&file("a.white", bytes), &source_options()) {
        std::hint::black_box(file.mesh.validate());
    }
    std::hint::black_box(read_scalars(&file("a.curv", bytes), &source_options()).ok());
    std::hint::black_box(read_scalars(&file("a.annot", bytes), &source_options()).ok());
});
