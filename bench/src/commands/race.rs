//! `ata` and `atb`: races.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use catamaran::base::{Pin, Team};
use catamaran::{AtaOptions, SchemeChoice};
use catamaran_bench::contender::{Contender, Scalar};
use catamaran_bench::input::{Distribution, Shape, matrix};
use catamaran_bench::product::{Operation, Product};
use catamaran_bench::race::{Rules, race};
use catamaran_bench::reference::Reference;
use catamaran_bench::table::{self, Row};
use catamaran_bench::{Result, chart, host, peak, record};

use super::{backend, libraries_of, rival, yardstick};

#[derive(clap::Args)]
pub struct Arguments {
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
    /// Entries of A and B.
    #[arg(long, value_enum, default_value_t = Distribution::Uniform)]
    distribution: Distribution,
    /// Seed of A; B has the next one.
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
    pub libraries: PathBuf,
}

/// Entries of C that each run is checked against, where all would be too many.
const SAMPLE: usize = 2000;

pub fn run(operation: Operation, arguments: &Arguments) -> Result<()> {
    let contenders = contenders(arguments)?;
    let rivals = libraries_of(&contenders);
    print!("{}", host::describe(&rivals));
    let before = peak::measure();
    let deadline = arguments.max_seconds.map(|s| Instant::now() + Duration::from_secs_f64(s));
    let rules = Rules { repeat: arguments.repeat, deadline, patience: None };
    println!("\n{}", table::header());

    let mut rows = Vec::new();
    for &shape in &arguments.sizes {
        for scalar in &arguments.types {
            let one_shape = match scalar.as_str() {
                "f64" => one_shape::<f64>,
                "f32" => one_shape::<f32>,
                other => return Err(format!("{other}: the types are f64 and f32").into()),
            };
            one_shape(operation, arguments, &contenders, shape, &rules, &mut rows)?;
        }
    }
    let peak = host::describe_peak(before, peak::measure());
    print!("\n{peak}");
    if let Some(name) = &arguments.record {
        let yardstick = contenders[yardstick(&contenders)].to_string();
        let folder = record::write(&[
            (&format!("{name}.csv"), record::csv(table::CSV_HEADER, rows.iter().map(Row::csv))),
            (&format!("{name}.svg"), chart::svg(&rows, operation.formula(), &yardstick)),
            ("host.txt", host::describe(&rivals) + &peak),
        ])?;
        println!("\nrecorded in {}", folder.display());
    }
    Ok(())
}

fn one_shape<T: Scalar>(
    operation: Operation,
    arguments: &Arguments,
    contenders: &[Contender],
    shape: Shape,
    rules: &Rules,
    rows: &mut Vec<Row>,
) -> Result<()> {
    if rules.time_is_up() {
        eprintln!("{shape} {}: left out, time is up", T::NAME);
        return Ok(());
    }
    let operand = |seed| matrix::<T>(shape, arguments.distribution, seed);
    let a = operand(arguments.seed);
    let b = (operation == Operation::Gemm).then(|| operand(arguments.seed + 1));
    let product = match &b {
        Some(b) => Product::gemm(shape, &a, b),
        None => Product::syrk(shape, &a),
    };
    let reference = Reference::new(&product, SAMPLE, arguments.seed);
    if arguments.explain {
        for contender in contenders {
            if let Some(plan) = contender.plan::<T>(operation, shape) {
                println!("\n{contender}\n{plan}\n");
            }
        }
    }
    for &threads in &arguments.threads {
        let team = Team::new(threads, if arguments.pin { Pin::Cores } else { Pin::No })?;
        let outcomes = race(contenders, product, threads, &team, &reference, rules)?;
        if outcomes.iter().any(|o| o.seconds.len() < rules.repeat) {
            eprintln!("{shape} {} {threads} threads: cut short, time is up", T::NAME);
        }
        let yardstick = yardstick(contenders);
        let new = table::rows(&outcomes, operation, shape, T::NAME, threads, yardstick);
        for row in new.into_iter().filter(|r| r.repetitions > 0) {
            println!("{row}");
            rows.push(row);
        }
    }
    Ok(())
}

fn contenders(arguments: &Arguments) -> Result<Vec<Contender>> {
    let mut contenders = Vec::new();
    for name in &arguments.rivals {
        contenders.push(rival(name, &arguments.libraries)?);
    }
    for name in &arguments.backend {
        let (backend_name, backend) = backend(name, &arguments.libraries)?;
        for scheme in &arguments.schemes {
            let (_, choice) = *SchemeChoice::NAMES
                .iter()
                .find(|(name, _)| name == scheme)
                .ok_or_else(|| format!("{scheme}: no such scheme"))?;
            let options =
                AtaOptions { scheme: choice, backend: backend.clone(), ..AtaOptions::default() };
            contenders.push(Contender::Ours {
                name: format!("{scheme}/{backend_name}"),
                options: Box::new(options),
            });
        }
    }
    if contenders.is_empty() { Err("nobody to race".into()) } else { Ok(contenders) }
}
