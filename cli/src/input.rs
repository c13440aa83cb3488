//! Reads the files of commands, within the memory that each may take, and repairs meshes where the
//! repair is unambiguous.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use anyhow::{Context, Result, anyhow, bail};
use catamaran::base::Progress;
use catamaran::io::SourceOptions;
use catamaran_geometry::mesh::io::{self as meshes, MeshFile, MeshFormat};
use catamaran_geometry::mesh::{
    Normalization, RepairOptions, RepairReport, RepairStep, Weld, needs_repair, repair,
};

use crate::common::as_option;
use crate::parse;
use crate::progress::Bar;
use crate::report::note;

/// Returns the help of an argument that names a mesh to be read.
pub fn mesh_help(what: &str) -> String {
    format!("{what}: {}, and .gz, .xz, .bz2, .zst or .zip after it", MeshFormat::readable())
}

/// How a command repairs the mesh that it reads.
///
/// Without these options a command makes the repairs that have one sensible outcome, and prints a
/// note about each: it welds split surfaces, and removes repeated faces and faces without area.
#[derive(Debug, Clone, clap::Args)]
pub struct MeshArgs {
    /// Join vertices of the mesh that are at most TOLERANCE apart, in units of the mesh; without
    /// TOLERANCE, vertices with equal positions. `seams`, the default without this option, joins
    /// vertices with equal positions only where exactly two boundary edges coincide.
    #[arg(long, value_name = "TOLERANCE", num_args = 0..=1, default_missing_value = "0",
          value_parser = parse::weld, conflicts_with = "strict")]
    weld: Option<Weld>,
    /// Drop components of the mesh with less than this share of its area, from 0 to 1, such as
    /// specks around a scan.
    #[arg(long, value_name = "SHARE", value_parser = parse::share, conflicts_with = "strict")]
    drop_specks: Option<f64>,
    /// Fail if the mesh needs repair, instead of repairing it with a note.
    #[arg(long)]
    strict: bool,
}

/// A text file, or stdin if the name is `-`.
#[derive(Debug, Clone)]
pub struct TextFile(PathBuf);

impl From<OsString> for TextFile {
    fn from(name: OsString) -> Self {
        Self(name.into())
    }
}

impl TextFile {
    fn is_stdin(&self) -> bool {
        self.0.as_os_str() == "-"
    }

    /// Returns the name of the file for messages.
    pub fn name(&self) -> String {
        if self.is_stdin() { "stdin".into() } else { self.0.display().to_string() }
    }

    /// Reads the whole file, without a byte order mark at its beginning.
    ///
    /// # Errors
    /// The file can't be read, or is not UTF-8 text.
    pub fn read(&self) -> Result<String> {
        let text = match self.is_stdin() {
            true => std::io::read_to_string(std::io::stdin()),
            false => std::fs::read_to_string(&self.0),
        };
        let text = text.map_err(|e| catamaran::Error::io(self.name(), e))?;
        // Spreadsheets begin text with a byte order mark.
        Ok(text.strip_prefix('\u{feff}').map(str::to_owned).unwrap_or(text))
    }
}

/// The value of `--input-limit`, in bytes.
static LIMIT: OnceLock<u64> = OnceLock::new();

/// Stores the value of `--input-limit`, in bytes.
pub fn set_limit(bytes: Option<usize>) {
    if let Some(bytes) = bytes {
        LIMIT.get_or_init(|| bytes as u64);
        catamaran::base::limit_memory(bytes as u64);
    }
}

/// Returns the memory that an input file may take, in bytes; `None` leaves the limit to the
/// library.
pub fn limit() -> Option<u64> {
    LIMIT.get().copied()
}

/// Returns the options for reading a file without a progress bar.
pub fn source<'a>() -> SourceOptions<'a> {
    SourceOptions::new().max_memory(limit())
}

/// Reads a mesh with a progress bar, and accepts it.
///
/// # Errors
/// The file can't be read; those of [`accept`].
pub fn mesh(path: &Path) -> Result<MeshFile> {
    let file = read_mesh(path)?;
    accept(&file, path)?;
    Ok(file)
}

/// Reads a mesh as [`mesh`] does; one whose size is out of range is scaled to a bounding box whose
/// longest side is 1, with a note. Returns the factor of the lengths, too.
///
/// # Errors
/// The file can't be read; the vertices are in one place.
pub fn mesh_of_any_size(path: &Path) -> Result<(MeshFile, f64)> {
    let mut file = read_mesh(path)?;
    let mut factor = 1.0;
    notes_of(&file, path);
    if let Err(why) = file.mesh.check_size() {
        let name = path.display();
        // Of half the side, which does not overflow.
        let [low, high] = file.mesh.bounding_box().unwrap_or_default();
        factor = 0.5 / (0..3).map(|k| high[k] / 2.0 - low[k] / 2.0).fold(0.0, f64::max);
        file.mesh =
            file.mesh.normalized(Normalization::UnitBox).with_context(|| name.to_string())?;
        note(format_args!("{name}: {why}; scaled to a box whose longest side is 1 first"));
    }
    Ok((file, factor))
}

fn read_mesh(path: &Path) -> Result<MeshFile> {
    let bar = Bar::new("reading");
    let update = |fraction| bar.update(fraction);
    let file = meshes::read_with(path, &source().progress(Progress::new(&update)))?;
    Ok(file)
}

/// Prints the notes of the reader of a file from `path`, and checks the size of its mesh.
///
/// # Errors
/// Areas of the mesh would overflow or vanish.
pub fn accept(file: &MeshFile, path: &Path) -> Result<()> {
    notes_of(file, path);
    file.mesh.check_size().map_err(|why| {
        let word = shell_word(path);
        anyhow!(
            "{}: {why}; `catamaran mesh {word} --normalize box -o FILE` scales it",
            path.display()
        )
    })
}

/// Prints the notes of the reader of a file from `path`.
fn notes_of(file: &MeshFile, path: &Path) {
    for line in &file.notes {
        note(format_args!("{}: {line}", path.display()));
    }
}

impl MeshArgs {
    /// Reads a mesh and makes the unambiguous repairs; notes on stderr say which.
    ///
    /// # Errors
    /// Those of [`mesh`]; with `--strict` the first culprit of a mesh that needs repair.
    pub fn read(&self, path: &Path) -> Result<MeshFile> {
        self.apply(mesh(path)?, path)
    }

    /// Returns whether a mesh that needs repair is an error.
    pub fn is_strict(&self) -> bool {
        self.strict
    }

    /// Returns the command, for a note, that takes these steps of `catamaran mesh` after it has
    /// joined the vertices of the file at `path` that these options join.
    pub fn mesh_command(&self, path: &Path, steps: &str) -> String {
        let (path, weld) = (shell_word(path), self.weld_flag());
        format!("`catamaran mesh {path}{weld} {steps} -o FILE`")
    }

    /// Returns the option of `catamaran mesh` that joins the vertices that these options join.
    fn weld_flag(&self) -> String {
        match self.weld {
            Some(Weld::Within(tolerance)) if tolerance > 0.0 => format!(" --weld={tolerance:?}"),
            Some(Weld::Within(_) | Weld::Exact) => " --weld".into(),
            _ if self.strict => String::new(),
            _ => " --weld seams".into(),
        }
    }

    /// Repairs a mesh that was read from `path`, as [`MeshArgs::read`] does.
    ///
    /// # Errors
    /// As [`MeshArgs::read`].
    pub fn apply(&self, file: MeshFile, path: &Path) -> Result<MeshFile> {
        let name = path.display();
        if self.strict {
            if file.collapsed_faces > 0 {
                bail!("{name}: facets with two equal corners: {} (--strict)", file.collapsed_faces);
            }
            if let Some(line) = file.notes.first() {
                bail!("{name}: {line} (--strict)");
            }
            return match needs_repair(&file.mesh) {
                None => Ok(file),
                Some(why) => bail!("{name}: {why} (--strict)"),
            };
        }
        let weld = self.weld.unwrap_or(Weld::Seams);
        let options = RepairOptions::unambiguous().weld(weld).drop_specks(self.drop_specks);
        let found = repair(file, &options).map_err(refused).with_context(|| name.to_string())?;
        for line in notes(&found.report) {
            note(format_args!("{name}: {line}"));
        }
        if found.vertices.is_some() {
            let count = found.file.mesh.vertices().len();
            let (word, flags) = (shell_word(path), flags(&found.report));
            note(format_args!(
                "{name}: vertex numbers refer to the repaired mesh, which has {count} vertices; \
                 `catamaran mesh {word}{flags} -o FILE` writes it"
            ));
        }
        Ok(found.file)
    }
}

/// Names the option of a repair that the library refuses; no option selects the removal of faces
/// without area.
fn refused(error: catamaran::Error) -> anyhow::Error {
    match error {
        catamaran::Error::Argument { what: "drop_degenerate", why } => {
            anyhow!("the removal of faces without area {why}")
        }
        error => as_option(error),
    }
}

/// Returns a path as a word of a shell command.
fn shell_word(path: &Path) -> String {
    let name = path.display().to_string();
    let is_plain = |c: char| c.is_alphanumeric() || "/._-+,:@%".contains(c);
    if name.chars().all(is_plain) { name } else { format!("'{}'", name.replace('\'', r"'\''")) }
}

/// Returns a line for each repair that changed something or was ambiguous.
fn notes(report: &RepairReport) -> Vec<String> {
    let line = |step: &RepairStep| match step {
        RepairStep::ClosedSeams { vertices: 0, ambiguous, .. } if *ambiguous > 0 => Some(format!(
            "{ambiguous} boundary edges stay apart, as three or more of them coincide (--weld \
             joins them)"
        )),
        step if step.changed() => {
            // Without the name of the step, which is in a separate column.
            let line = step.to_string();
            Some(line.split_once("  ").map_or(line.as_str(), |(_, what)| what.trim()).to_owned())
        }
        _ => None,
    };
    report.steps.iter().filter_map(line).collect()
}

/// Returns the options of `catamaran mesh` that repeat these repairs.
fn flags(report: &RepairReport) -> String {
    let flag = |step: &RepairStep| match step {
        RepairStep::Welded { tolerance, .. } if *tolerance > 0.0 => {
            format!(" --weld={tolerance:?}")
        }
        RepairStep::Welded { .. } => " --weld".into(),
        RepairStep::ClosedSeams { .. } => " --weld seams".into(),
        RepairStep::DroppedDuplicates { .. } => " --drop-duplicates".into(),
        RepairStep::DroppedDegenerate { .. } => " --drop-degenerate".into(),
        RepairStep::DroppedSpecks { share, .. } => format!(" --drop-specks {share}"),
        _ => String::new(),
    };
    report.steps.iter().filter(|step| step.changed()).map(flag).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_a_shell_would_split_or_expand_are_quoted() {
        for (name, word) in [
            ("scans/a-1.ply.gz", "scans/a-1.ply.gz"),
            ("my scan.ply", "'my scan.ply'"),
            ("a$b*.ply", "'a$b*.ply'"),
            ("it's.ply", r"'it'\''s.ply'"),
        ] {
            assert_eq!(shell_word(Path::new(name)), word);
        }
    }
}
