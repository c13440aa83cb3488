//! Any bytes as a file: a mesh or an error, and a mesh that can be looked at.
#![no_main]

use catamaran_geometry::mesh::io::{MeshFormat, PlyEncoding};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    if let Ok(file) =
        catamaran_geometry::mesh::io::read_bytes(bytes, MeshFormat::Ply(PlyEncoding::Ascii))
    {
        std::hint::black_box(file.mesh.validate());
    }
});
