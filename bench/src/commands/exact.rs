//! `exact`: the times of the stages of the exact path, and the rates of its kernels relative to the
//! hardware limit.

use std::time::Instant;

use catamaran::AtaOptions;
use catamaran::base::{Pin, ThreadPool};
use catamaran::blas::BlasReal;
use catamaran::kernel::int8::{IntegerIsa, Ladder, Rung, StepRates};
use catamaran::product::{Stages, exact_stages};
use catamaran_bench::input::{Distribution, Shape, matrix};
use catamaran_bench::{Result, host};
use faer::{MatMut, MatRef};

use super::Type;

#[derive(clap::Args)]
pub struct Arguments {
    /// Shapes of A: N or MxN.
    #[arg(long, value_delimiter = ',', default_value = "1024,2048,4096,30000x2500")]
    sizes: Vec<Shape>,
    /// Thread counts.
    #[arg(long, value_delimiter = ',', default_value = "1,2")]
    threads: Vec<usize>,
    /// Types of the entries.
    #[arg(long, value_enum, value_delimiter = ',', default_value = "f64,f32")]
    types: Vec<Type>,
    /// amx, vnni, avx2, portable; default the fastest that this machine has.
    #[arg(long, value_delimiter = ',')]
    isas: Vec<String>,
    /// The kernels alone: their rates with operands in registers, caches and memory.
    #[arg(long)]
    kernel: bool,
    /// Repetitions; the fastest is shown.
    #[arg(long, default_value_t = 5)]
    repeat: usize,
}

pub fn run(arguments: &Arguments) -> Result<()> {
    print!("{}", host::describe(&[]));
    if arguments.kernel {
        return isas(&arguments.isas)?.into_iter().try_for_each(show_ladder);
    }
    println!(
        "\n{:>8} {:>6} {:>4} {:>2}  {:<8} {:>9} {:>8} {:>6} {:>6} {:>6} {:>6} {:>9}",
        "m", "n", "type", "th", "isa", "s", "GFLOP/s", "norms", "conv", "prod", "recomb", "GOP/s"
    );
    for &shape in &arguments.sizes {
        for scalar in &arguments.types {
            match scalar {
                Type::F64 => one_shape::<f64>(arguments, shape, 14)?,
                Type::F32 => one_shape::<f32>(arguments, shape, 7)?,
            }
        }
    }
    Ok(())
}

/// Prints the rates of the kernel of an instruction set, with operands at every level of the
/// memory.
fn show_ladder(isa: IntegerIsa) -> Result<()> {
    let ladder = Ladder::measure(isa)?;
    // A multiplication and an addition are two operations.
    let rate = |rate: f64| format!("{:.1}", 2e-9 * rate);
    println!("\n{}: registers {} GOP/s", isa.name(), ladder.registers.map_or("-".into(), rate));
    println!(
        "{:<7} {:<7} {:<9} {:>14} {:>7} {:>14} {:>7}",
        "left", "right", "old", "2 MiB, GOP/s", "share", "4 KiB, GOP/s", "share"
    );
    let share =
        |r: f64| ladder.registers.map_or("-".into(), |peak| format!("{:.1} %", 100.0 * r / peak));
    for rung in ladder.rungs.iter().filter(|rung| rung.huge_pages) {
        let small = Rung { huge_pages: false, rate: 0.0, ..rung.clone() };
        let small = ladder.rungs.iter().find(|r| Rung { rate: 0.0, ..(*r).clone() } == small);
        let small = small.map_or(0.0, |rung| rung.rate);
        println!(
            "{:<7} {:<7} {:<9} {:>14} {:>7} {:>14} {:>7}",
            rung.left,
            rung.right,
            if rung.continued { "added" } else { "-" },
            rate(rung.rate),
            share(rung.rate),
            rate(small),
            share(small)
        );
    }
    let StepRates { norms, conversion, recombination } = ladder.steps;
    println!("other steps, in caches, f64, 14 moduli:");
    for (step, rate) in
        [("norms", norms), ("conversion", conversion), ("recombination", recombination)]
    {
        println!("{step:<15} {:>6.3} ns an entry", 1e9 / rate);
    }
    Ok(())
}

fn one_shape<T: BlasReal>(arguments: &Arguments, shape: Shape, moduli: usize) -> Result<()> {
    let Shape { m, n } = shape;
    let a = matrix::<T>(shape, Distribution::Uniform, 1);
    let a = MatRef::from_row_major_slice(&a, m, n);
    let mut c = vec![T::ZERO; n * n];
    for &threads in &arguments.threads {
        let team = ThreadPool::new(threads, Pin::Cores)?;
        for isa in isas(&arguments.isas)? {
            let options = AtaOptions::new().threads(threads);
            let mut best: Option<(f64, Stages)> = None;
            for _ in 0..arguments.repeat.max(1) {
                let c = MatMut::from_row_major_slice_mut(&mut c, n, n);
                let start = Instant::now();
                let stages = team.run(|| exact_stages(isa, a, c, &options))?;
                let seconds = start.elapsed().as_secs_f64();
                if best.is_none_or(|(fastest, _)| seconds < fastest) {
                    best = Some((seconds, stages));
                }
            }
            let Some((seconds, stages)) = best else { continue };
            let Stages { norms, conversion, products, recombination } = stages;
            let share = |s: f64| format!("{:.1}%", 100.0 * s / (seconds * threads as f64));
            let work = m as f64 * (n as f64).powi(2) / 1e9;
            println!(
                "{m:>8} {n:>6} {:>4} {threads:>2}  {:<8} {seconds:>9.5} {:>8.1} {:>6} {:>6} {:>6} {:>6} {:>9.1}",
                T::NAME,
                isa.name(),
                work / seconds,
                share(norms),
                share(conversion),
                share(products),
                share(recombination),
                moduli as f64 * work / products,
            );
        }
    }
    Ok(())
}

fn isas(names: &[String]) -> Result<Vec<IntegerIsa>> {
    if names.is_empty() {
        return Ok(vec![IntegerIsa::best()]);
    }
    let find = |name: &String| {
        let found = IntegerIsa::ALL.into_iter().find(|i| i.name() == name);
        found.ok_or_else(|| format!("{name}: no such instruction set").into())
    };
    names.iter().map(find).collect()
}
