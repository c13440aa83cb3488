//! Chapter 8: A^T A in one process.

use std::num::NonZeroUsize;

use catamaran_bench::Result;
use catamaran_bench::child::Report as Process;
use catamaran_bench::curves::Plot;
use catamaran_bench::input::Shape;
use catamaran_bench::product::Operation;
use catamaran_bench::race::{Outcome, median};
use catamaran_bench::table::{self, Row};
use clap::ValueEnum;

use super::super::{Type, installed, once};
use super::{Arguments, Report};

/// The columns of the record.
pub const HEADER: &str = "figure,m,n,type,threads,contender,repetitions,median_s,best_s,gflops,ratio,best_ratio,error,error_ratio,memory_mb";

/// A part of the chapter.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Share {
    /// Figures 8.3 to 8.5 up to a side of `--side`.
    Figures,
    /// Figure 8.3 at the thesis' sizes, up to 25,000 (hours).
    Squares,
    /// Figure 8.5 at the thesis' sizes: 30,000, 40,000 and 60,000 x 5,000 (hours).
    Threads,
}

impl Share {
    /// Returns the name of its record.
    pub fn name(self) -> &'static str {
        match self {
            Self::Figures => "chapter-8",
            Self::Squares => "chapter-8-squares",
            Self::Threads => "chapter-8-threads",
        }
    }
}

/// Step of the sides of figures 8.3 and 8.4, as in the thesis.
const STEP: usize = 2500;
/// Tasks of AtA-S in figure 8.5: the thesis' 16 threads.
const TASKS: usize = 16;

/// Sides of figure 8.3 beyond those of [`Share::Figures`], up to the thesis' largest.
const SQUARES: [usize; 4] = [10_000, 15_000, 20_000, 25_000];
/// The largest side of the figures that are not at the thesis' sizes.
const SIDE: usize = 7500;
/// Shapes of figure 8.5 in the thesis.
const THREADED: [Shape; 3] =
    [Shape { m: 30_000, n: 30_000 }, Shape { m: 40_000, n: 40_000 }, Shape { m: 60_000, n: 5000 }];

/// Reproduces figures 8.3, 8.4 and 8.5, or some of them.
pub fn run(report: &mut Report, share: Share, arguments: &Arguments) -> Result<()> {
    report.say(
        "# Chapter 8, measured again\n\nEffective GFLOP/s by equation 8.9: `m n^2 / t` for A^T A, `2 m n^2 / t` for \
         A^T B. Each ratio is the speed over that of the BLAS that computes the leaves; `native` stands beside the \
         first BLAS. Each call is made in a process of its own, after calls on small blocks. Errors are relative to \
         the largest norms of columns; memory is that of C and of what the contender needs besides, in MB.\n",
    );
    let square = |n| Shape { m: n, n };
    let side = arguments.side.unwrap_or(SIDE);
    let is_wanted = |shape: &Shape| arguments.side.is_none_or(|side| shape.n == side);
    if share != Share::Threads {
        let shapes: Vec<_> = match share {
            Share::Squares => SQUARES.into_iter().map(square).filter(is_wanted).collect(),
            _ => (1..=side / STEP).map(|i| square(i * STEP)).collect(),
        };
        let figure = Figure { name: "8.3", operation: Operation::Syrk, scheme: "ata2".into() };
        let rows = figure.rows(&shapes, Type::F64, &[1], arguments)?;
        figure.report(report, "AtA and dsyrk, one thread", &rows, |row| row.shape.n);
        if share == Share::Figures {
            let figure = Figure { name: "8.4", operation: Operation::Gemm, scheme: "ata2".into() };
            let rows = figure.rows(&shapes, Type::F64, &[1], arguments)?;
            figure.report(report, "FastStrassen and dgemm, one thread", &rows, |row| row.shape.n);
        }
    }
    if share != Share::Squares {
        let cores = std::thread::available_parallelism().map_or(1, NonZeroUsize::get);
        // On few cores each number, on many the powers of two.
        let threads: Vec<_> = (1..=cores).filter(|&t| cores < 4 || t.is_power_of_two()).collect();
        let figure = Figure {
            name: "8.5",
            operation: Operation::Syrk,
            scheme: format!("ata2:tasks={TASKS}"),
        };
        let third = side / 3;
        let shapes = match share {
            Share::Threads => THREADED.into_iter().filter(is_wanted).collect(),
            // The aspect of 60K x 5K.
            _ => vec![square(side), Shape { m: 12 * third, n: third }],
        };
        for shape in shapes {
            let rows = figure.rows(&[shape], Type::F32, &threads, arguments)?;
            let title = format!("AtA-S of {TASKS} tasks and ssyrk, A {shape}, over threads");
            figure.report(report, &title, &rows, |row| row.threads);
        }
    }
    Ok(())
}

/// A figure: an operation, and our scheme for it.
struct Figure {
    name: &'static str,
    operation: Operation,
    scheme: String,
}

/// A row of a figure, and the MB of C and of what the contender needs besides.
struct Line {
    row: Row,
    memory: f64,
}

impl Figure {
    /// Races every installed BLAS, our scheme over it, and our scheme over our own kernels, for
    /// each shape and number of threads.
    fn rows(
        &self,
        shapes: &[Shape],
        scalar: Type,
        threads: &[usize],
        arguments: &Arguments,
    ) -> Result<Vec<Line>> {
        let wanted: Vec<&str> = arguments.rivals.iter().map(String::as_str).collect();
        let names = installed(&wanted, &arguments.libraries);
        if names.is_empty() {
            return Err("no BLAS to compare with: run scripts/rivals first".into());
        }
        // A contender, and the BLAS to which its ratio refers.
        let mut contenders: Vec<(String, usize)> = Vec::new();
        for (i, name) in names.into_iter().enumerate() {
            contenders.push((name.clone(), 2 * i));
            contenders.push((format!("{}/{name}", self.scheme), 2 * i));
        }
        contenders.push((format!("{}/native", self.scheme), 0));

        let mut all = Vec::new();
        for &shape in shapes {
            for &threads in threads {
                let reports = self.race(&contenders, shape, scalar, threads, arguments)?;
                let outcomes: Vec<Outcome> = contenders
                    .iter()
                    .zip(&reports)
                    .map(|((name, _), reports)| outcome(name, reports))
                    .collect();
                for (i, (_, yardstick)) in contenders.iter().enumerate() {
                    let mut rows = table::rows(
                        &outcomes,
                        self.operation,
                        shape,
                        scalar.name(),
                        threads,
                        *yardstick,
                    );
                    let bytes = median(reports[i].iter().map(|report| report.bytes).collect());
                    all.push(Line { row: rows.swap_remove(i), memory: bytes / 1e6 });
                }
            }
        }
        Ok(all)
    }

    /// Runs all contenders in turns, in an order that rotates.
    fn race(
        &self,
        contenders: &[(String, usize)],
        shape: Shape,
        scalar: Type,
        threads: usize,
        arguments: &Arguments,
    ) -> Result<Vec<Vec<Process>>> {
        let mut reports = vec![Vec::new(); contenders.len()];
        for round in 0..arguments.repeat.max(1) {
            for turn in 0..contenders.len() {
                let i = (round + turn) % contenders.len();
                let name = &contenders[i].0;
                let libraries = &arguments.libraries;
                let report = once::run(name, self.operation, shape, scalar, threads, libraries)?;
                eprintln!("{shape}, {threads} threads, {name}: {:.3} s", report.seconds);
                reports[i].push(report);
            }
        }
        Ok(reports)
    }

    /// Reports the rows as a table and as a plot of speed over `across`.
    fn report(
        &self,
        report: &mut Report,
        title: &str,
        rows: &[Line],
        across: impl Fn(&Row) -> usize,
    ) {
        report.say(&format!("**Figure {}**: {title}\n", self.name));
        report.say(
            "| m | n | type | threads | contender | median s | GFLOP/s | ratio | error | memory |",
        );
        report.say("|---|---|---|---|---|---|---|---|---|---|");
        let mut series: Vec<(String, Vec<(f64, f64)>)> = Vec::new();
        for Line { row, memory } in rows {
            let Row { shape: Shape { m, n }, scalar, threads, contender, .. } = row;
            report.say(&format!(
                "| {m} | {n} | {scalar} | {threads} | {contender} | {:.4} | {:.1} | {:.3} | {:.1e} | {memory:.0} |",
                row.seconds, row.gflops, row.ratio, row.error
            ));
            report.lines.push(format!("{},{},{memory:.0}", self.name, row.csv()));
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

fn outcome(contender: &str, reports: &[Process]) -> Outcome {
    let is_rival = !contender.contains('/');
    Outcome {
        contender: if is_rival { contender.to_owned() } else { format!("cata:{contender}") },
        is_rival,
        seconds: reports.iter().map(|report| report.seconds).collect(),
        error: reports.iter().filter_map(|report| report.rest.first().copied()).fold(0.0, f64::max),
    }
}
