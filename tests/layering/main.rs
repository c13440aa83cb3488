//! The imports of the library run one way: from layer to layer (`layers.rs`), and from file to file
//! inside each room, which is a folder of `src` (`circles.rs`).

mod circles;
mod layers;
mod modules;
mod source;

use std::fs;
use std::path::{Path, PathBuf};

/// The folder of the library.
fn src() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("src")
}

fn rust_files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(rust_files(&path));
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
    found.sort();
    found
}
