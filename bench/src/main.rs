//! `catamaran-bench`: races against other libraries.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use catamaran::base::{Pin, Team};
use catamaran::{SchemeChoice, blas};
use catamaran_bench::contender::{Contender, Scalar};
use catamaran_bench::input::{Distribution, Shape, matrix};
use catamaran_bench::library::{Rival, find};
use catamaran_bench::race::{Rules, race};
use catamaran_bench::reference::Reference;
use catamaran_bench::table::{self, Row};
use catamaran_bench::{Result, host, record};
use clap::Parser;

/// Races against other libraries.
#[derive(Parser)]
enum Command {
    /// A^T A against the syrk of BLAS libraries.
    Ata(Arguments),
}

#[derive(clap::Args)]
struct Arguments {
    /// Rivals: mkl, openblas, blis, faer, or NAME=PATH for any CBLAS library.
    #[arg(long, value_delimiter = ',', default_value = "mkl,openblas,faer")]
    rivals: Vec<String>,
    /// Shapes of A: N or MxN.
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "512,1024,2048,4096,8192,1000000x100,30000x2500"
    )]
    sizes: Vec<Shape>,
    /// Thread counts.
    #[arg(long, value_delimiter = ',', default_value = "1,2")]
    threads: Vec<usize>,
    /// f64, f32.
    #[arg(long, value_delimiter = ',', default_value = "f64,f32")]
    types: Vec<String>,
    /// Repetitions.
    #[arg(long, default_value_t = 5)]
    repeat: usize,
    /// What computes our leaves: gemm, or what a rival may be.
    #[arg(long, value_delimiter = ',', default_value = "mkl")]
    backend: Vec<String>,
    /// Our schemes.
    #[arg(long, value_delimiter = ',', default_value = "auto")]
    schemes: Vec<String>,
    /// Entries of A.
    #[arg(long, value_enum, default_value_t = Distribution::Uniform)]
    distribution: Distribution,
    /// Seed of A.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Starts no repetition that would end later than this after the start.
    #[arg(long)]
    max_seconds: Option<f64>,
    /// Keeps each of our threads on one core.
    #[arg(long)]
    pin: bool,
    /// Prints our plans.
    #[arg(long)]
    explain: bool,
    /// Writes NAME.csv, NAME.svg and host.txt under bench/record.
    #[arg(long, value_name = "NAME")]
    record: Option<String>,
    /// Where scripts/rivals installed the libraries.
    #[arg(long, default_value = "target/rivals")]
    libraries: PathBuf,
}

fn main() {
    let Command::Ata(arguments) = Command::parse();
    let done =
        host::with_environment_for_rivals(&arguments.libraries).and_then(|()| run(&arguments));
    if let Err(error) = done {
        eprintln!("catamaran-bench: {error}");
        std::process::exit(1);
    }
}

fn run(arguments: &Arguments) -> Result<()> {
    let contenders = contenders(arguments)?;
    let rivals: Vec<&Rival> = contenders
        .iter()
        .filter_map(|c| match c {
            Contender::Cblas(rival) => Some(rival.as_ref()),
            _ => None,
        })
        .collect();
    print!("{}", host::describe(&rivals));
    let deadline = arguments.max_seconds.map(|s| Instant::now() + Duration::from_secs_f64(s));
    let rules = Rules { repeat: arguments.repeat, deadline };
    println!("\n{}", table::header());

    let mut rows = Vec::new();
    for &shape in &arguments.sizes {
        for scalar in &arguments.types {
            match scalar.as_str() {
                "f64" => one_shape::<f64>(arguments, &contenders, shape, &rules, &mut rows)?,
                "f32" => one_shape::<f32>(arguments, &contenders, shape, &rules, &mut rows)?,
                other => return Err(format!("{other}: the types are f64 and f32").into()),
            }
        }
    }
    if let Some(name) = &arguments.record {
        let yardstick = contenders[yardstick(&contenders)].to_string();
        let folder = record::write(name, &rows, &rivals, &yardstick)?;
        println!("\nrecorded in {}", folder.display());
    }
    Ok(())
}

fn one_shape<T: Scalar>(
    arguments: &Arguments,
    contenders: &[Contender],
    shape: Shape,
    rules: &Rules,
    rows: &mut Vec<Row>,
) -> Result<()> {
    if rules.deadline.is_some_and(|d| Instant::now() > d) {
        eprintln!("{shape} {}: left out, time is up", T::NAME);
        return Ok(());
    }
    let a = matrix::<T>(shape, arguments.distribution, arguments.seed);
    let reference = Reference::new(&a, shape, arguments.seed);
    if arguments.explain {
        for contender in contenders {
            if let Some(plan) = contender.plan::<T>(shape) {
                println!("\n{contender}\n{plan}\n");
            }
        }
    }
    for &threads in &arguments.threads {
        let team = Team::new(threads, if arguments.pin { Pin::Cores } else { Pin::No })?;
        let outcomes = race(contenders, &a, shape, threads, &team, &reference, rules)?;
        if outcomes.iter().any(|o| o.seconds.len() < rules.repeat) {
            eprintln!("{shape} {} {threads} threads: cut short, time is up", T::NAME);
        }
        let new = table::rows(&outcomes, shape, T::NAME, threads, yardstick(contenders));
        for row in new.into_iter().filter(|r| r.repetitions > 0) {
            println!("{row}");
            rows.push(row);
        }
    }
    Ok(())
}

/// Whom ratios refer to: MKL, else the first rival, else the first.
fn yardstick(contenders: &[Contender]) -> usize {
    let place = |wanted: &dyn Fn(&Contender) -> bool| contenders.iter().position(wanted);
    place(&|c| c.to_string() == "mkl").or_else(|| place(&Contender::is_rival)).unwrap_or(0)
}

fn contenders(arguments: &Arguments) -> Result<Vec<Contender>> {
    let mut contenders = Vec::new();
    for name in &arguments.rivals {
        contenders.push(match name.as_str() {
            "faer" => Contender::Faer,
            name => Contender::Cblas(Arc::new(rival(name, &arguments.libraries)?)),
        });
    }
    for backend in &arguments.backend {
        let (backend_name, backend) = match backend.as_str() {
            "gemm" => ("gemm".to_owned(), blas::native()),
            name => {
                // Loaded as a rival first: who loads a library first decides how it is bound.
                let rival = rival(name, &arguments.libraries)?;
                (rival.name, blas::load(&rival.path)?)
            }
        };
        for scheme in &arguments.schemes {
            let (scheme, choice) = *SchemeChoice::NAMES
                .iter()
                .find(|(name, _)| name == scheme)
                .ok_or_else(|| format!("{scheme}: no such scheme"))?;
            let (backend_name, backend) = (backend_name.clone(), backend.clone());
            contenders.push(Contender::Ours { scheme, choice, backend_name, backend });
        }
    }
    if contenders.is_empty() { Err("nobody to race".into()) } else { Ok(contenders) }
}

fn rival(name: &str, libraries: &Path) -> Result<Rival> {
    let (name, path) = match name.split_once('=') {
        Some((name, path)) => (name, Some(PathBuf::from(path))),
        None => (name, find(name, libraries)),
    };
    let path = path.ok_or_else(|| {
        format!("{name}: not found; run scripts/rivals, or give NAME=PATH of the library")
    })?;
    Rival::load(name, &path)
}
