//! The commands, and their common options and contenders.

pub mod accuracy;
pub mod batched;
pub mod cholesky;
pub mod decimate;
pub mod functional_map;
pub mod gram;
pub mod grid;
pub mod laplacian;
pub mod once;
pub mod ortho;
pub mod race;
pub mod reproduce;
pub mod scale;
pub mod spectrum;
pub mod stream;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use catamaran::AtaOptions;
use catamaran::base::{Pin, ThreadPool};
use catamaran::blas::{self, Backend};
use catamaran_bench::contender::{Contender, scheme_named};
use catamaran_bench::library::{Rival, find};
use catamaran_bench::race::Rules;
use catamaran_bench::{Result, host, record};
use clap::ValueEnum;

/// The options of a contest between processes of this library and of a rival.
#[derive(clap::Args)]
pub struct Contest {
    /// Thread counts, of those that have threads.
    #[arg(long, value_delimiter = ',', default_value = "1,2")]
    pub threads: Vec<usize>,
    /// Repetitions.
    #[arg(long, default_value_t = 5)]
    pub repeat: usize,
    /// Where scripts/rivals installed the rival.
    #[arg(long, default_value = "target/rivals")]
    pub libraries: PathBuf,
    /// Writes NAME.csv and host.txt under bench/record.
    #[arg(long, value_name = "NAME")]
    pub record: Option<String>,
    /// Solves the problem in this folder once, and prints what the rival's script does.
    #[arg(long, hide = true)]
    pub solve: Option<PathBuf>,
}

/// A scalar type.
#[derive(Clone, Copy, ValueEnum)]
pub enum Type {
    F64,
    F32,
}

impl Type {
    /// Returns its name, as an argument and in records.
    fn name(self) -> &'static str {
        match self {
            Self::F64 => "f64",
            Self::F32 => "f32",
        }
    }
}

/// The common options of commands with contenders.
#[derive(clap::Args)]
pub struct Common {
    /// Types of the entries.
    #[arg(long, value_enum, value_delimiter = ',', default_value = "f64,f32")]
    types: Vec<Type>,
    /// Seed of A; that of B, where there is one, is the next.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Writes NAME.csv and host.txt under bench/record, and a picture NAME.svg, where there is one,
    /// into target/record.
    #[arg(long, value_name = "NAME")]
    record: Option<String>,
    /// Where scripts/rivals installed the libraries.
    #[arg(long, default_value = "target/rivals")]
    pub libraries: PathBuf,
}

/// Number of entries of C against which each run of a race is checked, where all would be too many.
const SAMPLE: usize = 2000;

impl Common {
    /// Writes the record, if one is requested: numbers, possibly a picture, and the host.
    fn keep(&self, csv: String, svg: Option<String>, rivals: &[&Rival], peak: &str) -> Result<()> {
        let Some(name) = &self.record else { return Ok(()) };
        let [csv_name, svg_name] = ["csv", "svg"].map(|ending| format!("{name}.{ending}"));
        let mut files = vec![(csv_name.as_str(), csv), ("host.txt", host::describe(rivals) + peak)];
        files.extend(svg.map(|svg| (svg_name.as_str(), svg)));
        println!("\nrecorded in {}", record::write(&files)?.display());
        Ok(())
    }
}

/// Options of races: how long, and with how many threads.
#[derive(clap::Args)]
pub struct Pace {
    /// Thread counts.
    #[arg(long, value_delimiter = ',', default_value = "1,2")]
    threads: Vec<usize>,
    /// Repetitions.
    #[arg(long, default_value_t = 5)]
    repeat: usize,
    /// Starts no repetition that would end later than this after the start.
    #[arg(long)]
    max_seconds: Option<f64>,
    /// Keeps each of our threads on one core.
    #[arg(long)]
    pin: bool,
}

impl Pace {
    /// Returns the rules of a command that starts now.
    fn rules(&self, patience: Option<f64>) -> Rules {
        let deadline = self.max_seconds.map(|s| Instant::now() + Duration::from_secs_f64(s));
        Rules { repeat: self.repeat, deadline, patience }
    }

    /// Returns the thread pool of our contenders.
    fn team(&self, threads: usize) -> Result<ThreadPool> {
        Ok(ThreadPool::new(threads, if self.pin { Pin::Cores } else { Pin::No })?)
    }
}

/// Returns those of the named rivals that are installed.
fn installed(names: &[&str], libraries: &Path) -> Vec<String> {
    let found = names.iter().filter(|name| find(name, libraries).is_some());
    found.map(|name| (*name).to_owned()).collect()
}

/// Returns the rival called `name`: faer, a library that is found by its name, or NAME=PATH.
fn rival(name: &str, libraries: &Path) -> Result<Contender> {
    Ok(match name {
        "faer" => Contender::Faer,
        name => Contender::Cblas { rival: Arc::new(load(name, libraries)?), routine: None },
    })
}

/// Returns the back end called `name`, and its name without a path: native, or a library as in
/// [`rival`].
fn backend(name: &str, libraries: &Path) -> Result<(String, Arc<dyn Backend>)> {
    if name == "native" {
        return Ok((name.to_owned(), blas::native()));
    }
    // Loaded as a rival first, because the first load of a library determines how it is bound.
    let rival = load(name, libraries)?;
    Ok((rival.name, blas::load(&rival.path)?))
}

fn load(name: &str, libraries: &Path) -> Result<Rival> {
    let (name, path) = match name.split_once('=') {
        Some((name, path)) => (name, Some(PathBuf::from(path))),
        None => (name, find(name, libraries)),
    };
    let path =
        path.ok_or_else(|| format!("{name}: not found; run scripts/rivals, or give NAME=PATH"))?;
    Rival::load(name, &path)
}

/// Returns our contender for `SCHEME[:leaf=SIDE][:tasks=COUNT][:pin]`.
fn ours(scheme: &str, (backend_name, backend): &(String, Arc<dyn Backend>)) -> Result<Contender> {
    let mut words = scheme.split(':');
    let choice = scheme_named(words.next().unwrap_or_default())?;
    let backend = backend.clone();
    let mut options = AtaOptions::new().scheme(choice).backend(backend);
    for word in words {
        options = match word.split_once('=') {
            Some(("leaf", side)) => options.leaf(side.parse::<usize>()?),
            Some(("tasks", count)) => options.tasks(count.parse::<usize>()?),
            None if word == "pin" => options.pin(Pin::Cores),
            _ => {
                let why = format!("{scheme}: {word} must be leaf=SIDE, tasks=COUNT or pin");
                return Err(why.into());
            }
        };
    }
    let name = format!("{scheme}/{backend_name}");
    Ok(Contender::Ours { name, options: Box::new(options) })
}

/// Returns the libraries among the contenders.
fn libraries_of(contenders: &[Contender]) -> Vec<&Rival> {
    let mut libraries: Vec<_> = contenders
        .iter()
        .filter_map(|c| match c {
            Contender::Cblas { rival, .. } => Some(rival.as_ref()),
            _ => None,
        })
        .collect();
    // A library that takes part with both its routines is listed once.
    libraries.dedup_by(|a, b| std::ptr::eq(*a, *b));
    libraries
}

/// Returns the contender to which ratios refer: MKL, otherwise the first rival, otherwise the first
/// contender.
fn yardstick(contenders: &[Contender]) -> usize {
    let place = |wanted: &dyn Fn(&Contender) -> bool| contenders.iter().position(wanted);
    place(&|c| c.to_string() == "mkl").or_else(|| place(&Contender::is_rival)).unwrap_or(0)
}
