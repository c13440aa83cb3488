//! What a race leaves behind: numbers, the host they are from, and a picture.

use std::fs;
use std::path::PathBuf;

use crate::library::Rival;
use crate::table::{CSV_HEADER, Row};
use crate::{Result, chart, host};

/// Writes `bench/record/<host kind>/{host.txt, name.csv, name.svg}`; the folder.
///
/// # Errors
/// When a file can't be written.
pub fn write(name: &str, rows: &[Row], rivals: &[&Rival], yardstick: &str) -> Result<PathBuf> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("record").join(host::kind());
    fs::create_dir_all(&folder)?;
    let mut csv = format!("{CSV_HEADER}\n");
    for row in rows {
        csv += &format!("{}\n", row.csv());
    }
    fs::write(folder.join(format!("{name}.csv")), csv)?;
    fs::write(folder.join("host.txt"), host::describe(rivals))?;
    fs::write(folder.join(format!("{name}.svg")), chart::svg(rows, yardstick))?;
    Ok(folder)
}
