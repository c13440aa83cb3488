//! `batched`: the race of many small A^T A at once.

use std::sync::Arc;

use catamaran_bench::batch::{Contender, race};
use catamaran_bench::contender::Scalar;
use catamaran_bench::input::{Distribution, Shape, matrix};
use catamaran_bench::library::Rival;
use catamaran_bench::product::Operation;
use catamaran_bench::race::Rules;
use catamaran_bench::table::{self, Row};
use catamaran_bench::{Result, host, peak, record};

use super::{Common, Pace, Type, load};

#[derive(clap::Args)]
pub struct Arguments {
    /// Rivals: mkl, openblas, or NAME=PATH for any CBLAS library; gemm_batch_strided of those that
    /// have it, and a loop of syrk.
    #[arg(long, value_delimiter = ',', default_value = "mkl,openblas")]
    rivals: Vec<String>,
    /// Shapes of the matrices: N or MxN.
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "4,8,16,32,64,128,20x3,100x6,300x12,1000x24"
    )]
    sizes: Vec<Shape>,
    /// MiB of all matrices together, which decides how many there are.
    #[arg(long, default_value_t = 16)]
    mebibytes: usize,
    #[command(flatten)]
    pace: Pace,
    #[command(flatten)]
    pub common: Common,
}

pub fn run(arguments: &Arguments) -> Result<()> {
    let libraries = &arguments.common.libraries;
    let named = arguments.rivals.iter().filter(|name| !name.is_empty());
    let rivals: Vec<_> =
        named.map(|name| load(name, libraries).map(Arc::new)).collect::<Result<_>>()?;
    let listed: Vec<&Rival> = rivals.iter().map(Arc::as_ref).collect();
    print!("{}", host::describe(&listed));
    let before = peak::measure();
    let rules = arguments.pace.rules(None);
    println!("\n{}", table::header());
    let mut rows = vec![];
    for &shape in &arguments.sizes {
        for scalar in &arguments.common.types {
            match scalar {
                Type::F64 => one_shape::<f64>(arguments, &rivals, shape, &rules, &mut rows)?,
                Type::F32 => one_shape::<f32>(arguments, &rivals, shape, &rules, &mut rows)?,
            }
        }
    }
    let peak = host::describe_peak(before, peak::measure());
    print!("\n{peak}");
    let csv = record::csv(table::CSV_HEADER, rows.iter().map(Row::csv));
    arguments.common.keep(csv, None, &listed, &peak)
}

fn one_shape<T: Scalar>(
    arguments: &Arguments,
    rivals: &[Arc<Rival>],
    shape: Shape,
    rules: &Rules,
    rows: &mut Vec<Row>,
) -> Result<()> {
    let bytes = shape.m * shape.n * size_of::<T>();
    let count = ((arguments.mebibytes << 20) / bytes).max(1);
    let all = Shape { m: shape.m * count, ..shape };
    let a = matrix::<T>(all, Distribution::Uniform, arguments.common.seed);
    let batch = rivals.iter().filter(|rival| T::gemm_batch(rival).is_some());
    let mut contenders: Vec<_> = batch.cloned().map(Contender::GemmBatch).collect();
    contenders.extend(rivals.iter().cloned().map(Contender::Loop));
    contenders.push(Contender::Ours);
    for &threads in &arguments.pace.threads {
        let team = arguments.pace.team(threads)?;
        let outcomes = race(&contenders, shape, &a, threads, &team, rules)?;
        let new = table::rows(&outcomes, Operation::Syrk, shape, T::NAME, threads, 0);
        for row in new.into_iter().filter(|row| row.repetitions > 0) {
            println!("{row}");
            rows.push(row);
        }
    }
    Ok(())
}
