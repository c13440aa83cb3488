//! Who decimates: this library and others, each call in a process of its own.

use std::path::{Path, PathBuf};
use std::time::Instant;

use catamaran::Par;
use catamaran::decimate::{DecimateOptions, Method, decimate};
use catamaran::io::Overwrite;

use super::inputs;
use crate::Result;
use crate::child::{self, Report};

/// Who decimates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Contender {
    /// This library.
    Ours,
    /// The thesis literally.
    Thesis,
    /// Clusters of faces (Valette and Chassery): PyPI `pyacvd`.
    Pyacvd,
    /// Quadric edge collapse: PyPI `fast-simplification`.
    FastSimplification,
    /// Regularised edge collapse: PyPI `meshoptimizer`.
    Meshoptimizer,
    /// Quadric edge collapse: PyPI `libigl`.
    Qslim,
    /// Collapse of the shortest edge: PyPI `libigl`.
    IglDecimate,
    /// Quadric edge collapse that keeps the topology: PyPI `pymeshlab`.
    Pymeshlab,
    /// Edge collapse by Lindstrom and Turk: Debian `libcgal-dev`.
    Cgal,
}

impl Contender {
    /// All, ours first.
    pub const ALL: [Self; 9] = [
        Self::Ours,
        Self::Thesis,
        Self::Pyacvd,
        Self::FastSimplification,
        Self::Meshoptimizer,
        Self::Qslim,
        Self::IglDecimate,
        Self::Pymeshlab,
        Self::Cgal,
    ];

    /// What tables and arguments call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ours => "ours",
            Self::Thesis => "thesis",
            Self::Pyacvd => "pyacvd",
            Self::FastSimplification => "fast-simplification",
            Self::Meshoptimizer => "meshoptimizer",
            Self::Qslim => "qslim",
            Self::IglDecimate => "igl-decimate",
            Self::Pymeshlab => "pymeshlab",
            Self::Cgal => "cgal",
        }
    }

    /// Whether it is this library.
    pub fn is_ours(self) -> bool {
        matches!(self, Self::Ours | Self::Thesis)
    }

    /// Does the job once; seconds and bytes of the call alone.
    ///
    /// # Errors
    /// When the process can't be started or fails.
    pub fn run(self, rivals: &Rivals, job: &Job<'_>) -> Result<Report> {
        let [input, output] = [job.input, job.output].map(|path| path.display().to_string());
        let [n, faces, threads] = [job.n, job.faces, job.threads].map(|count| count.to_string());
        if self.is_ours() {
            let arguments = [
                "decimate",
                "--solve",
                self.name(),
                &input,
                "-n",
                &n,
                "--threads",
                &threads,
                "-o",
                &output,
            ];
            return child::run(&std::env::current_exe()?, &arguments, job.threads);
        }
        if self == Self::Cgal {
            let program = rivals.cgal.as_ref().ok_or("no CGAL: run scripts/rivals first")?;
            return child::run(program, &[&input, &faces, &output], job.threads);
        }
        let python = rivals.python.as_ref().ok_or("no Python: run scripts/rivals first")?;
        let script = child::script("decimate.py");
        let wanted = if self == Self::Pyacvd { &n } else { &faces };
        child::run(python, &[&script, self.name(), &input, wanted, &output], job.threads)
    }
}

/// What one call reads and writes.
pub struct Job<'a> {
    /// A PLY file.
    pub input: &'a Path,
    /// Vertices wanted.
    pub n: usize,
    /// Faces wanted of those that count faces.
    pub faces: usize,
    /// Threads of those that have threads.
    pub threads: usize,
    /// A PLY file.
    pub output: &'a Path,
}

/// Where scripts/rivals put the others, as far as it could.
pub struct Rivals {
    python: Option<PathBuf>,
    cgal: Option<PathBuf>,
}

impl Rivals {
    /// Those in this folder.
    pub fn find(folder: &Path) -> Self {
        let cgal = folder.join("bin/cgal_collapse");
        Self { python: child::python(folder), cgal: cgal.exists().then_some(cgal) }
    }

    /// Whether this contender can run.
    pub fn have(&self, contender: Contender) -> bool {
        match contender {
            _ if contender.is_ours() => true,
            Contender::Cgal => self.cgal.is_some(),
            _ => self.python.is_some(),
        }
    }

    /// The faces of each mesh that intersect others, counted by CGAL in libigl; `None` where that
    /// is not installed or fails.
    pub fn intersecting_faces(&self, meshes: &[&Path]) -> Vec<Option<usize>> {
        let nothing = vec![None; meshes.len()];
        let Some(python) = &self.python else { return nothing };
        let paths = meshes.iter().map(|path| path.display().to_string());
        let arguments: Vec<_> =
            std::iter::once(child::script("intersections.py")).chain(paths).collect();
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        match child::numbers(python, &arguments, 1) {
            Ok(counts) if counts.len() == meshes.len() => {
                counts.into_iter().map(|count| Some(count as usize)).collect()
            }
            Ok(_) => nothing,
            Err(error) => {
                eprintln!("intersecting faces: {error}");
                nothing
            }
        }
    }
}

/// Our side, in its own process: prints seconds and bytes.
///
/// # Errors
/// Those of the library.
pub fn solve(
    contender: Contender,
    input: &Path,
    n: usize,
    threads: usize,
    output: &Path,
) -> Result<()> {
    let mesh = catamaran::mesh::io::read(input)?.mesh;
    let options = DecimateOptions::new()
        .method(if contender == Contender::Thesis { Method::Thesis } else { Method::Uniform })
        .par(Par::Threads(threads));
    let [before, _] = child::memory();
    let start = Instant::now();
    let made = decimate(&mesh, n, &options)?;
    let seconds = start.elapsed().as_secs_f64();
    let [_, peak] = child::memory();
    inputs::write(output, &made.mesh, Overwrite::Replace)?;
    println!("{}", Report::line(seconds, peak.saturating_sub(before), &[]));
    Ok(())
}
