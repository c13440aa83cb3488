//! The contenders of decimation: this library and others, each call in a separate process.

use std::path::{Path, PathBuf};
use std::time::Instant;

use catamaran::Par;
use catamaran::io::Overwrite;
use catamaran_geometry::decimate::{DecimateOptions, Method, decimate};

use super::inputs;
use crate::Result;
use crate::child::{self, Report};

/// A contender of decimation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Contender {
    /// This library.
    Ours,
    /// The algorithm of the thesis, as printed.
    Thesis,
    /// Clusters of faces (Valette and Chassery): PyPI `pyacvd`.
    Pyacvd,
    /// Quadric edge collapse: PyPI `fast-simplification`.
    FastSimplification,
    /// Regularized edge collapse: PyPI `meshoptimizer`.
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
    /// All contenders, ours first.
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

    /// Returns the name in tables and arguments.
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

    /// Returns whether the contender is this library.
    pub fn is_ours(self) -> bool {
        matches!(self, Self::Ours | Self::Thesis)
    }

    /// Runs the job once; returns seconds and bytes of the call itself.
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

/// The input and output of one call.
pub struct Job<'a> {
    /// The input, a PLY file.
    pub input: &'a Path,
    /// Number of vertices of the result.
    pub n: usize,
    /// Number of faces of the result, for contenders that count faces.
    pub faces: usize,
    /// Number of threads, for contenders that have threads.
    pub threads: usize,
    /// The output, a PLY file.
    pub output: &'a Path,
}

/// The rivals that scripts/rivals installed.
pub struct Rivals {
    python: Option<PathBuf>,
    cgal: Option<PathBuf>,
}

impl Rivals {
    /// Finds the rivals in this folder.
    pub fn find(folder: &Path) -> Self {
        let cgal = folder.join("bin/cgal_collapse");
        Self { python: child::python(folder), cgal: cgal.exists().then_some(cgal) }
    }

    /// Returns whether this contender can run.
    pub fn have(&self, contender: Contender) -> bool {
        match contender {
            _ if contender.is_ours() => true,
            Contender::Cgal => self.cgal.is_some(),
            _ => self.python.is_some(),
        }
    }

    /// Returns the number of faces of each mesh that intersect others, counted by CGAL in libigl;
    /// `None` where that is not installed or fails.
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

/// Runs this library, in a separate process; prints seconds and bytes.
///
/// # Errors
/// The errors of the library.
pub fn solve(
    contender: Contender,
    input: &Path,
    n: usize,
    threads: usize,
    output: &Path,
) -> Result<()> {
    let mesh = catamaran_geometry::mesh::io::read(input)?.mesh;
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
