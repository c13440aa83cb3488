//! What comes in: files, each within the memory it may take, and numbers of things that are made.

use std::path::Path;
use std::sync::OnceLock;

use catamaran::base::Progress;
use catamaran::io::SourceOptions;
use catamaran::mesh::io::{self as meshes, MeshFile};

use crate::progress::Bar;

/// What `--max-memory` says.
static MAX_MEMORY: OnceLock<u64> = OnceLock::new();

/// Keeps the value of `--max-memory`, in bytes.
pub fn limit_memory(bytes: Option<usize>) {
    if let Some(bytes) = bytes {
        MAX_MEMORY.get_or_init(|| bytes as u64);
    }
}

/// Bytes of memory that a file may take, unless the library decides.
pub fn max_memory() -> Option<u64> {
    MAX_MEMORY.get().copied()
}

/// How files are read that show no bar.
pub fn source<'a>() -> SourceOptions<'a> {
    SourceOptions::new().max_memory(max_memory())
}

/// Reads a mesh.
pub fn mesh(path: &Path) -> catamaran::Result<MeshFile> {
    let bar = Bar::new("reading");
    let update = |fraction| bar.update(fraction);
    meshes::read_with(path, &source().progress(Progress::new(&update)))
}

/// A number of frames: each is a file, of which a folder should not hold more.
pub fn frame_count(text: &str) -> Result<usize, String> {
    const MOST: usize = 100_000;
    match text.parse() {
        Ok(count) if count <= MOST => Ok(count),
        _ => Err(format!("expected a number of at most {MOST}")),
    }
}
