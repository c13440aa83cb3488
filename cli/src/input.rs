//! Files that commands read: each within the memory it may take.

use std::path::Path;
use std::sync::OnceLock;

use catamaran::base::Progress;
use catamaran::io::SourceOptions;
use catamaran::mesh::io::{self as meshes, MeshFile};

use crate::progress::Bar;
use crate::report;

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

/// How files are read, without a progress bar.
pub fn source<'a>() -> SourceOptions<'a> {
    SourceOptions::new().max_memory(max_memory())
}

/// Reads a mesh, shows a progress bar meanwhile, and passes the notes of the reader on.
pub fn mesh(path: &Path) -> catamaran::Result<MeshFile> {
    let bar = Bar::new("reading");
    let update = |fraction| bar.update(fraction);
    let file = meshes::read_with(path, &source().progress(Progress::new(&update)))?;
    drop(bar);
    for note in &file.notes {
        report::note(format_args!("{}: {note}", path.display()));
    }
    Ok(file)
}
