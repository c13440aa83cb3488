//! Chapter 8: A^T A in one process.

use std::num::NonZeroUsize;

use catamaran::base::{Pin, ThreadPool};
use catamaran_bench::Result;
use catamaran_bench::contender::{Contender, Scalar};
use catamaran_bench::curves::Plot;
use catamaran_bench::input::{Distribution, Shape, matrix};
use catamaran_bench::product::{Operation, Product};
use catamaran_bench::race::{Rules, race};
use catamaran_bench::reference::Reference;
use catamaran_bench::table::{self, Row};

use super::super::{SAMPLE, backend, installed, ours, rival};
use super::{Arguments, Report};

/// The columns of the record.
pub const HEADER: &str = "figure,m,n,type,threads,contender,repetitions,median_s,best_s,gflops,ratio,best_ratio,error,error_ratio";

/// Step of the sides of figures 8.3 and 8.4, as in the thesis.
const STEP: usize = 2500;
/// Tasks of AtA-S in figure 8.5: the thesis' 16 threads.
const TASKS: usize = 16;

/// Reproduces figures 8.3, 8.4 and 8.5.
pub fn run(report: &mut Report, arguments: &Arguments) -> Result<()> {
    report.say(
        "# Chapter 8, measured again\n\nEffective GFLOP/s by equation 8.9: `m n^2 / t` for A^T A, `2 m n^2 / t` for \
         A^T B. Each ratio is the speed over that of the BLAS that computes the leaves; `native` stands beside the \
         first BLAS. Errors are relative to the largest norms of columns.\n",
    );
    let sides: Vec<_> = (1..=arguments.side / STEP).map(|i| i * STEP).collect();
    let squares: Vec<_> = sides.iter().map(|&n| Shape { m: n, n }).collect();
    let figure = Figure { name: "8.3", operation: Operation::Syrk, scheme: "ata2".into() };
    let rows = figure.rows::<f64>(&squares, &[1], arguments)?;
    figure.report(report, "AtA and dsyrk, one thread", &rows, |row| row.shape.n);
    let figure = Figure { name: "8.4", operation: Operation::Gemm, scheme: "ata2".into() };
    let rows = figure.rows::<f64>(&squares, &[1], arguments)?;
    figure.report(report, "FastStrassen and dgemm, one thread", &rows, |row| row.shape.n);

    let cores = std::thread::available_parallelism().map_or(1, NonZeroUsize::get);
    let threads: Vec<_> = (1..=cores).collect();
    let scheme = format!("ata2:tasks={TASKS}");
    let figure = Figure { name: "8.5", operation: Operation::Syrk, scheme };
    let square = Shape { m: arguments.side, n: arguments.side };
    // The aspect of 60K x 5K.
    let tall = Shape { m: 12 * (arguments.side / 3), n: arguments.side / 3 };
    for shape in [square, tall] {
        let rows = figure.rows::<f32>(&[shape], &threads, arguments)?;
        let title = format!("AtA-S of {TASKS} tasks and ssyrk, A {shape}, over threads");
        figure.report(report, &title, &rows, |row| row.threads);
    }
    Ok(())
}

/// A figure: an operation, and our scheme for it.
struct Figure {
    name: &'static str,
    operation: Operation,
    scheme: String,
}

impl Figure {
    /// Races every installed BLAS, our scheme over it, and our scheme over our own kernels, for
    /// each shape and number of threads.
    fn rows<T: Scalar>(
        &self,
        shapes: &[Shape],
        threads: &[usize],
        arguments: &Arguments,
    ) -> Result<Vec<Row>> {
        let libraries = &arguments.libraries;
        let names = installed(&["mkl", "openblas"], libraries);
        if names.is_empty() {
            return Err("no BLAS to compare with: run scripts/rivals first".into());
        }
        // A contender, and the BLAS to which its ratio refers.
        let mut contenders: Vec<(Contender, usize)> = Vec::new();
        for (i, name) in names.iter().enumerate() {
            contenders.push((rival(name, libraries)?, 2 * i));
            contenders.push((ours(&self.scheme, &backend(name, libraries)?)?, 2 * i));
        }
        contenders.push((ours(&self.scheme, &backend("native", libraries)?)?, 0));
        let (contenders, yardsticks): (Vec<_>, Vec<_>) = contenders.into_iter().unzip();

        let rules = Rules { repeat: arguments.repeat, deadline: None, patience: None };
        let mut all = Vec::new();
        for &shape in shapes {
            let operand = |seed| matrix::<T>(shape, Distribution::Uniform, seed);
            let a = operand(1);
            let b = (self.operation == Operation::Gemm).then(|| operand(2));
            let product = match &b {
                Some(b) => Product::gemm(shape, &a, b),
                None => Product::syrk(shape, &a),
            };
            let reference = Reference::new(&product, SAMPLE, 1);
            for &threads in threads {
                let team = ThreadPool::new(threads, Pin::No)?;
                let outcomes = race(&contenders, product, threads, &team, &reference, &rules)?;
                for (i, &yardstick) in yardsticks.iter().enumerate() {
                    let mut rows =
                        table::rows(&outcomes, self.operation, shape, T::NAME, threads, yardstick);
                    all.push(rows.swap_remove(i));
                }
            }
        }
        Ok(all)
    }

    /// Reports the rows as a table and as a plot of speed over `across`.
    fn report(
        &self,
        report: &mut Report,
        title: &str,
        rows: &[Row],
        across: impl Fn(&Row) -> usize,
    ) {
        report.say(&format!("**Figure {}**: {title}\n", self.name));
        report.say("| m | n | type | threads | contender | median s | GFLOP/s | ratio | error |");
        report.say("|---|---|---|---|---|---|---|---|---|");
        let mut series: Vec<(String, Vec<(f64, f64)>)> = Vec::new();
        for row in rows {
            let Row { shape: Shape { m, n }, scalar, threads, contender, .. } = row;
            report.say(&format!(
                "| {m} | {n} | {scalar} | {threads} | {contender} | {:.4} | {:.1} | {:.3} | {:.1e} |",
                row.seconds, row.gflops, row.ratio, row.error
            ));
            report.lines.push(format!("{},{}", self.name, row.csv()));
            let point = (across(row) as f64, row.gflops);
            match series.iter_mut().find(|(name, _)| name == contender) {
                Some((_, points)) => points.push(point),
                None => series.push((contender.clone(), vec![point])),
            }
        }
        report.say("");
        report.plots.push(Plot {
            title: format!("Figure {}: {title}, effective GFLOP/s", self.name),
            across: if self.name == "8.5" { "threads" } else { "n" }.into(),
            logarithmic: false,
            scattered: false,
            series,
        });
    }
}
