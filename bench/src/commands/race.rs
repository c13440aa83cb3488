//! `ata` and `atb`: races.

use catamaran_bench::contender::{Contender, Scalar};
use catamaran_bench::input::{Distribution, Shape, matrix};
use catamaran_bench::product::{Operation, Product};
use catamaran_bench::race::{Rules, race};
use catamaran_bench::reference::Reference;
use catamaran_bench::table::{self, Row};
use catamaran_bench::{Result, chart, host, peak, record};

use super::{Common, Pace, SAMPLE, Type, backend, libraries_of, ours, rival, yardstick};

#[derive(clap::Args)]
pub struct Arguments {
    /// Rivals: mkl, openblas, blis, faer, or NAME=PATH for any CBLAS library; '' for none.
    #[arg(long, value_delimiter = ',', default_value = "mkl,openblas,faer")]
    rivals: Vec<String>,
    /// Shapes of A: N or MxN.
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "512,1024,2048,4096,8192,1000000x100,30000x2500"
    )]
    sizes: Vec<Shape>,
    /// What computes our leaves: native, or what a rival may be.
    #[arg(long, value_delimiter = ',', default_value = "native")]
    backend: Vec<String>,
    /// Our schemes.
    #[arg(long, value_delimiter = ',', default_value = "auto")]
    schemes: Vec<String>,
    /// Entries of A and B.
    #[arg(long, value_enum, default_value_t = Distribution::Uniform)]
    distribution: Distribution,
    /// Prints our plans.
    #[arg(long)]
    explain: bool,
    #[command(flatten)]
    pace: Pace,
    #[command(flatten)]
    pub common: Common,
}

pub fn run(operation: Operation, arguments: &Arguments) -> Result<()> {
    let contenders = contenders(arguments)?;
    let rivals = libraries_of(&contenders);
    print!("{}", host::describe(&rivals));
    let before = peak::measure();
    let rules = arguments.pace.rules(None);
    println!("\n{}", table::header());

    let mut rows = Vec::new();
    for &shape in &arguments.sizes {
        for scalar in &arguments.common.types {
            let one_shape = match scalar {
                Type::F64 => one_shape::<f64>,
                Type::F32 => one_shape::<f32>,
            };
            one_shape(operation, arguments, &contenders, shape, &rules, &mut rows)?;
        }
    }
    let peak = host::describe_peak(before, peak::measure());
    print!("\n{peak}");
    let yardstick = contenders[yardstick(&contenders)].to_string();
    let csv = record::csv(table::CSV_HEADER, rows.iter().map(Row::csv));
    let svg = chart::svg(&rows, operation.formula(), &yardstick);
    arguments.common.keep(csv, Some(svg), &rivals, &peak)
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
    let seed = arguments.common.seed;
    let operand = |seed| matrix::<T>(shape, arguments.distribution, seed);
    let a = operand(seed);
    let b = (operation == Operation::Gemm).then(|| operand(seed + 1));
    let product = match &b {
        Some(b) => Product::gemm(shape, &a, b),
        None => Product::syrk(shape, &a),
    };
    let reference = Reference::new(&product, SAMPLE, seed);
    if arguments.explain {
        for contender in contenders {
            if let Some(plan) = contender.plan::<T>(operation, shape) {
                println!("\n{contender}\n{plan}\n");
            }
        }
    }
    for &threads in &arguments.pace.threads {
        let team = arguments.pace.team(threads)?;
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
    let libraries = &arguments.common.libraries;
    let mut contenders = Vec::new();
    for name in arguments.rivals.iter().filter(|name| !name.is_empty()) {
        contenders.push(rival(name, libraries)?);
    }
    for name in &arguments.backend {
        let backend = backend(name, libraries)?;
        for scheme in &arguments.schemes {
            contenders.push(ours(scheme, &backend)?);
        }
    }
    if contenders.is_empty() { Err("no contender is left".into()) } else { Ok(contenders) }
}
