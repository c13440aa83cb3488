//! What the targets share.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use catamaran::io::{ReadOptions, SourceOptions};

/// Bytes that a file may take: far below what the fuzzer counts as a finding.
const MEMORY: u64 = 64 << 20;

/// Returns the options with which matrices are read.
pub fn matrix_options<'a>() -> ReadOptions<'a> {
    ReadOptions::new().max_memory(MEMORY)
}

/// Returns the options with which all other files are read.
pub fn source_options<'a>() -> SourceOptions<'a> {
    SourceOptions::new().max_memory(MEMORY)
}

/// Writes a file of these bytes in memory, which lasts until the next of its name.
///
/// # Panics
/// When it can't be written.
pub fn file(name: &str, bytes: &[u8]) -> PathBuf {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    let folder = FOLDER.get_or_init(|| {
        let memory = Path::new("/dev/shm");
        let parent = if memory.is_dir() { memory.into() } else { std::env::temp_dir() };
        let folder = parent.join(format!("catamaran-fuzz-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder for the inputs");
        folder
    });
    let path = folder.join(name);
    std::fs::write(&path, bytes).expect("an input is written");
    path
}
