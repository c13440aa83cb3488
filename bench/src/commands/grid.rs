//! `grid`: this library against the best rival at many shapes.

use catamaran::AtaOptions;
use catamaran_bench::contender::{Contender, Scalar};
use catamaran_bench::grid::{CSV_HEADER, Row, header, row, shapes, summarize};
use catamaran_bench::input::{Distribution, Shape, matrix};
use catamaran_bench::product::{Operation, Product};
use catamaran_bench::race::{Rules, race};
use catamaran_bench::reference::Reference;
use catamaran_bench::{Result, host, peak, record, scatter};

use super::{Common, Pace, SAMPLE, Type, backend, installed, libraries_of, ours, rival};

#[derive(clap::Args)]
pub struct Arguments {
    /// Rivals, as in the races; default mkl, openblas and blis, where they are installed. Libraries
    /// take part with syrk and with gemm.
    #[arg(long, value_delimiter = ',')]
    rivals: Option<Vec<String>>,
    /// Shapes of A: N or MxN; default the grid.
    #[arg(long, value_delimiter = ',')]
    sizes: Option<Vec<Shape>>,
    /// What computes our leaves, as in the races; default what the library takes by itself.
    #[arg(long)]
    backend: Option<String>,
    /// Our scheme.
    #[arg(long, default_value = "auto")]
    scheme: String,
    #[command(flatten)]
    pace: Pace,
    #[command(flatten)]
    pub common: Common,
}

/// Factor above the fastest rival at which a rival is dropped.
const PATIENCE: f64 = 1.25;

pub fn run(arguments: &Arguments) -> Result<()> {
    let contenders = contenders(arguments)?;
    let libraries = libraries_of(&contenders);
    print!("{}", host::describe(&libraries));
    let before = peak::measure();
    let rules = arguments.pace.rules(Some(PATIENCE));
    let shapes = arguments.sizes.clone().unwrap_or_else(shapes);
    println!("\n{}", header());

    let mut rows = Vec::new();
    for shape in shapes {
        for scalar in &arguments.common.types {
            let one_shape = match scalar {
                Type::F64 => one_shape::<f64>,
                Type::F32 => one_shape::<f32>,
            };
            one_shape(arguments, &contenders, shape, &rules, &mut rows)?;
        }
    }
    summaries(&rows);
    let peak = host::describe_peak(before, peak::measure());
    print!("\n{peak}");
    let csv = record::csv(CSV_HEADER, rows.iter().map(Row::csv));
    arguments.common.keep(csv, Some(scatter::svg(&rows)), &libraries, &peak)
}

fn one_shape<T: Scalar>(
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
    let seed = arguments.common.seed;
    let a = matrix::<T>(shape, Distribution::Uniform, seed);
    let product = Product::syrk(shape, &a);
    let reference = Reference::new(&product, SAMPLE, seed);
    let plan = contenders.iter().find_map(|c| c.plan::<T>(Operation::Syrk, shape));
    for &threads in &arguments.pace.threads {
        let team = arguments.pace.team(threads)?;
        let outcomes = race(contenders, product, threads, &team, &reference, rules)?;
        let row = row(&outcomes, plan.as_ref(), shape, T::NAME, threads);
        if row.as_ref().is_none_or(|r| r.repetitions < rules.repeat) {
            eprintln!("{shape} {} {threads} threads: cut short, time is up", T::NAME);
        }
        if let Some(row) = row {
            println!("{row}");
            rows.push(row);
        }
    }
    Ok(())
}

/// Returns every library twice, with its two routines, then ours.
fn contenders(arguments: &Arguments) -> Result<Vec<Contender>> {
    let libraries = &arguments.common.libraries;
    let names = arguments.rivals.clone();
    let names = names.unwrap_or_else(|| installed(&["mkl", "openblas", "blis"], libraries));
    let mut contenders = Vec::new();
    for name in &names {
        match rival(name, libraries)? {
            Contender::Cblas { rival, .. } => {
                let by =
                    |routine| Contender::Cblas { rival: rival.clone(), routine: Some(routine) };
                contenders.extend([Operation::Syrk, Operation::Gemm].map(by));
            }
            other => contenders.push(other),
        }
    }
    if contenders.is_empty() {
        return Err("no rival is installed: run scripts/rivals".into());
    }
    let backend = match &arguments.backend {
        Some(name) => backend(name, libraries)?,
        None => {
            let backend = AtaOptions::default().backend;
            (backend.name().to_owned(), backend)
        }
    };
    contenders.push(ours(&arguments.scheme, &backend)?);
    Ok(contenders)
}

fn summaries(rows: &[Row]) {
    let mut panels: Vec<_> = rows.iter().map(|r| (r.scalar, r.threads)).collect();
    panels.sort();
    panels.dedup();
    println!();
    for (scalar, threads) in panels {
        let of_panel = rows.iter().filter(|r| (r.scalar, r.threads) == (scalar, threads));
        if let Some(summary) = summarize(of_panel) {
            println!("{scalar}, threads {threads}: {summary}");
        }
    }
    if let Some(summary) = summarize(rows) {
        println!("all: {summary}");
    }
}
