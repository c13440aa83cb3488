//! Bytes of the files that a mesh file names: they lie beside it, or in folders there.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Component, Path};

use super::draft::{Checked, Fault};

/// Returns up to `length` bytes, from byte `start` on, of the file `name` beside `path`. A name
/// that leads elsewhere is an error.
pub(super) fn beside(name: &str, path: &Path, start: u64, length: usize) -> Checked<Vec<u8>> {
    let relative = Path::new(name);
    let inside = |part: Component<'_>| matches!(part, Component::Normal(_) | Component::CurDir);
    if name.is_empty() || name.contains(':') || !relative.components().all(inside) {
        return Err(format!("{name:?} is not the name of a file beside this one").into());
    }
    let full = path.parent().unwrap_or(Path::new("")).join(relative);
    let failed = |e: std::io::Error| Fault::from(format!("{}: {e}", full.display()));
    let mut file = File::open(&full).map_err(failed)?;
    if !file.metadata().map_err(failed)?.is_file() {
        return Err(format!("{}: not a file", full.display()).into());
    }
    file.seek(SeekFrom::Start(start)).map_err(failed)?;
    let mut bytes = Vec::new();
    file.take(length as u64).read_to_end(&mut bytes).map_err(failed)?;
    Ok(bytes)
}
