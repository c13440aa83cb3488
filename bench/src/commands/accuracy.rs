//! `accuracy`: a table of errors.

use catamaran::base::{Pin, ThreadPool, available_cores};
use catamaran::{Accuracy, AtaOptions, SchemeChoice};
use catamaran_bench::accuracy::{CSV_HEADER, Row, header, summarize};
use catamaran_bench::contender::{Contender, Scalar};
use catamaran_bench::input::{Distribution, Shape, matrix};
use catamaran_bench::product::Product;
use catamaran_bench::reference::Reference;
use catamaran_bench::{Result, host, peak, record};
use clap::ValueEnum;
use faer::MatMut;

use super::{Common, Type, backend, installed, libraries_of, rival, yardstick};

#[derive(clap::Args)]
pub struct Arguments {
    /// Rivals, as in the races; default mkl and openblas, where they are installed.
    #[arg(long, value_delimiter = ',')]
    rivals: Option<Vec<String>>,
    /// Shapes of A: N or MxN.
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "1500x400,4096x1024,8192,30000x150,1000000x100"
    )]
    sizes: Vec<Shape>,
    /// Entries of A; default all.
    #[arg(long, value_enum, value_delimiter = ',')]
    distributions: Option<Vec<Distribution>>,
    /// Threads; default all cores.
    #[arg(long, default_value_t = available_cores())]
    threads: usize,
    /// What computes our classical path: native, or what a rival may be.
    #[arg(long, default_value = "mkl")]
    backend: String,
    #[command(flatten)]
    pub common: Common,
}

/// Number of entries of C that are tested, where all would be too many.
const SAMPLE: usize = 100_000;

pub fn run(arguments: &Arguments) -> Result<()> {
    let contenders = contenders(arguments)?;
    let rivals = libraries_of(&contenders);
    print!("{}", host::describe(&rivals));
    let before = peak::measure();
    let team = ThreadPool::new(arguments.threads, Pin::No)?;
    let distributions = match &arguments.distributions {
        Some(distributions) => distributions,
        None => Distribution::value_variants(),
    };
    println!("\n{}", header());

    let mut rows = Vec::new();
    for &shape in &arguments.sizes {
        for scalar in &arguments.common.types {
            let one_input = match scalar {
                Type::F64 => one_input::<f64>,
                Type::F32 => one_input::<f32>,
            };
            for &distribution in distributions {
                let new = one_input(arguments, &contenders, shape, distribution, &team)?;
                new.iter().for_each(|row| println!("{row}"));
                rows.extend(new);
            }
        }
    }
    let peak = host::describe_peak(before, peak::measure());
    let csv = record::csv(CSV_HEADER, rows.iter().map(Row::csv));
    arguments.common.keep(csv, None, &rivals, &peak)
}

fn one_input<T: Scalar>(
    arguments: &Arguments,
    contenders: &[Contender],
    shape: Shape,
    distribution: Distribution,
    team: &ThreadPool,
) -> Result<Vec<Row>> {
    let a = matrix::<T>(shape, distribution, arguments.common.seed);
    let product = Product::syrk(shape, &a);
    let reference = Reference::new(&product, SAMPLE, arguments.common.seed);
    let n = shape.n;
    let mut c = vec![T::ZERO; n * n];
    let mut rows = Vec::with_capacity(contenders.len());
    for contender in contenders {
        reference.poison(&mut c);
        let view = MatMut::from_row_major_slice_mut(&mut c, n, n);
        contender.run(product.operation(), product.views(), view, 1, arguments.threads, team)?;
        let errors = reference
            .entry_errors(&c)
            .map_err(|e| format!("{contender}, {shape}, {}, {distribution}: {e}", T::NAME))?;
        rows.push(Row {
            shape,
            scalar: T::NAME,
            distribution,
            contender: contender.to_string(),
            errors: summarize(&errors, n),
            ratio: f64::NAN,
        });
    }
    let unit = rows[yardstick(contenders)].errors.largest;
    for row in &mut rows {
        row.ratio = row.errors.largest / unit;
    }
    Ok(rows)
}

/// Returns the rivals, our classical path, and the exact path with 13, 14 and 15 moduli (in f32 6,
/// 7, 8).
fn contenders(arguments: &Arguments) -> Result<Vec<Contender>> {
    let libraries = &arguments.common.libraries;
    let rivals = arguments.rivals.clone();
    let rivals = rivals.unwrap_or_else(|| installed(&["mkl", "openblas"], libraries));
    let mut contenders = Vec::new();
    for name in &rivals {
        contenders.push(rival(name, libraries)?);
    }
    let (backend_name, backend) = backend(&arguments.backend, libraries)?;
    contenders.push(Contender::Ours {
        name: format!("classical/{backend_name}"),
        options: Box::new(AtaOptions::new().scheme(SchemeChoice::Classical).backend(backend)),
    });
    let accuracies =
        [("fast", Accuracy::Fast), ("default", Accuracy::Default), ("max", Accuracy::Max)];
    for (name, accuracy) in accuracies {
        let scheme = SchemeChoice::Exact;
        let options = AtaOptions::new().scheme(scheme).accuracy(accuracy);
        contenders
            .push(Contender::Ours { name: format!("exact-{name}"), options: Box::new(options) });
    }
    Ok(contenders)
}
