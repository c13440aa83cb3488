//! `ortho`: Gram-Schmidt in the inner product of masses beside column-wise numpy and LAPACK's
//! pivoted QR, each run in a separate process.

use std::path::{Path, PathBuf};
use std::time::Instant;

use catamaran::base::Rng;
use catamaran::faer::{Mat, MatRef};
use catamaran::io::{Matrix, Output, Overwrite, ReadOptions, read, write};
use catamaran::ortho::{GramSchmidtOptions, cholesky_qr, gram_schmidt_in_place};
use catamaran::sparse::Mass;
use catamaran::{AtaOptions, Par, Uplo, ata_into};
use catamaran_bench::child::{self, Report};
use catamaran_bench::race::median;
use catamaran_bench::{Result, host, record};
use clap::ValueEnum;

#[derive(clap::Args)]
pub struct Arguments {
    /// Rows.
    #[arg(long, default_value_t = 50_000)]
    rows: usize,
    /// Column counts.
    #[arg(long, value_delimiter = ',', default_value = "310,992,4960")]
    columns: Vec<usize>,
    /// Thread counts.
    #[arg(long, value_delimiter = ',', default_value = "1,2")]
    threads: Vec<usize>,
    /// Repetitions.
    #[arg(long, default_value_t = 5)]
    repeat: usize,
    /// Repetitions of column-wise numpy, which reads the whole basis for every column; default:
    /// those of the others.
    #[arg(long)]
    numpy_repeat: Option<usize>,
    /// Where scripts/rivals installed scipy.
    #[arg(long, default_value = "target/rivals")]
    libraries: PathBuf,
    /// Writes NAME.csv and host.txt under bench/record.
    #[arg(long, value_name = "NAME")]
    record: Option<String>,
    /// Solves the problem in this folder once, and prints seconds, bytes, rank and error.
    #[arg(long, hide = true, requires = "method")]
    solve: Option<PathBuf>,
    /// By this method.
    #[arg(long, hide = true)]
    method: Option<Method>,
}

/// Our methods.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Method {
    /// Threshold 1e-9, re-orthogonalized.
    Reorthogonalized,
    /// Threshold 1e-2, one pass.
    SinglePass,
    /// For columns that are independent.
    CholeskyQr,
}

/// A method of this library or of bench/rivals/gram_schmidt.py, and its name in tables.
#[derive(Clone, Copy)]
enum Contender {
    Ours(&'static str, &'static str),
    Python(&'static str, &'static str),
}

/// The contenders; the others are compared with the first one.
const CONTENDERS: [Contender; 5] = [
    Contender::Ours("ours*", "reorthogonalized"),
    Contender::Ours("ours", "single-pass"),
    Contender::Ours("Cholesky QR", "cholesky-qr"),
    Contender::Python("numpy", "columns"),
    Contender::Python("dgeqp3", "dgeqp3"),
];

pub fn run(arguments: &Arguments) -> Result<()> {
    if let (Some(folder), Some(method)) = (&arguments.solve, arguments.method) {
        return solve(folder, method, arguments.threads[0]);
    }
    let python = child::python(&arguments.libraries).ok_or("no scipy: run scripts/rivals first")?;
    let host = host::describe(&[]);
    println!("{host}");
    println!(
        "{:>7} {:>7} {:>2}  {:<11} {:>9} {:>7} {:>7} {:>6} {:>9}",
        "rows", "columns", "th", "method", "seconds", "ratio", "memory", "rank", "error"
    );
    let mut lines = Vec::new();
    for &columns in &arguments.columns {
        let folder = tempfile::tempdir()?;
        prepare(folder.path(), arguments.rows, columns)?;
        let basis = (8 * arguments.rows * columns) as f64;
        for &threads in &arguments.threads {
            let reports = race(arguments, folder.path(), &python, threads)?;
            for (contender, own) in CONTENDERS.iter().zip(&reports) {
                let (Contender::Ours(name, _) | Contender::Python(name, _)) = contender;
                let seconds = median(own.iter().map(|report| report.seconds).collect());
                // Ratios of the same repetition, as far as there are.
                let pairs = own.iter().zip(&reports[0]);
                let ratio = median(pairs.map(|(own, first)| own.seconds / first.seconds).collect());
                // The memory includes A itself.
                let memory = median(own.iter().map(|report| 1.0 + report.bytes / basis).collect());
                let [rank, error] = [0, 1].map(|i| own[0].rest.get(i).copied().unwrap_or(f64::NAN));
                let (n, repeat) = (arguments.rows, own.len());
                println!(
                    "{n:>7} {columns:>7} {threads:>2}  {name:<11} {seconds:>9.3} {ratio:>7.2} {memory:>7.2} {rank:>6} \
                     {error:>9.1e}"
                );
                lines.push(format!(
                    "{n},{columns},{threads},{name},{repeat},{seconds:.4},{ratio:.3},{memory:.2},{rank},{error:.2e}"
                ));
            }
        }
    }
    if let Some(name) = &arguments.record {
        let header =
            "rows,columns,threads,method,repetitions,seconds,ratio,memory_in_bases,rank,error";
        let (name, csv) = (format!("{name}.csv"), record::csv(header, lines));
        println!("\nrecorded in {}", record::write(&[(&name, csv), ("host.txt", host)])?.display());
    }
    Ok(())
}

/// Writes A and the masses for all contenders. Each column overlaps, positively or negatively, with
/// the previous one, and none depends on others, so that all contenders have the full work. A is
/// written by columns.
fn prepare(folder: &Path, n: usize, c: usize) -> Result<()> {
    let mut rng = Rng::new(1);
    let mut transposed = Mat::<f64>::zeros(c, n);
    for j in 0..c {
        let overlap = if rng.uniform() < 0.5 { -0.9 } else { 0.9 };
        for i in 0..n {
            let before = if j == 0 { 0.0 } else { transposed[(j - 1, i)] };
            transposed[(j, i)] = overlap * before + rng.uniform() - 0.5;
        }
    }
    let masses = Mat::from_fn(n, 1, |i, _| 1.0 + 0.9 * (i as f64).sin());
    for (name, matrix) in [("a.npy", &transposed), ("mass.npy", &masses)] {
        write(Output::create(&folder.join(name), Overwrite::Replace)?, matrix.as_ref())?;
    }
    Ok(())
}

fn get(folder: &Path, name: &str) -> Result<Mat<f64>> {
    match read(&folder.join(name), &ReadOptions::default())? {
        Matrix::F64(dense) => Ok(dense.as_ref().transpose().to_owned()),
        _ => Err(format!("{name}: the numbers must be doubles").into()),
    }
}

/// Solves the problem with this library, in a separate process.
fn solve(folder: &Path, method: Method, threads: usize) -> Result<()> {
    let mut a = get(folder, "a.npy")?;
    let masses: Vec<f64> = get(folder, "mass.npy")?.row(0).iter().copied().collect();
    let mass = Mass::Lumped(masses.clone());
    let par = Par::Threads(threads);
    child::forget_peak();
    let [before, _] = child::memory();
    let start = Instant::now();
    let gram_schmidt = |a: &mut Mat<f64>, options: GramSchmidtOptions<'_>| -> Result<usize> {
        let options = options.par(par);
        Ok(gram_schmidt_in_place(a.as_mut(), &mass, &options)?.kept.len())
    };
    let rank = match method {
        Method::Reorthogonalized => gram_schmidt(&mut a, GramSchmidtOptions::reorthogonalized())?,
        Method::SinglePass => gram_schmidt(&mut a, GramSchmidtOptions::single_pass())?,
        Method::CholeskyQr => cholesky_qr(a.as_mut(), &mass, par)?.ncols(),
    };
    let seconds = start.elapsed().as_secs_f64();
    let [_, peak] = child::memory();
    a.truncate(a.nrows(), rank);
    let error = defect(&mut a, &masses)?;
    println!("{}", Report::line(seconds, peak.saturating_sub(before), &[rank as f64, error]));
    Ok(())
}

/// Returns the largest entry of `|Q^T M Q - I|`; Q is scaled for this.
fn defect(q: &mut Mat<f64>, masses: &[f64]) -> Result<f64> {
    for column in q.as_mut().col_iter_mut() {
        column.iter_mut().zip(masses).for_each(|(x, mass)| *x *= mass.sqrt());
    }
    let c = q.ncols();
    let mut gram = Mat::zeros(c, c);
    let options = AtaOptions::new().uplo(Uplo::Both);
    ata_into(1.0, q.as_ref(), 0.0, gram.as_mut(), &options)?;
    let far = |gram: MatRef<'_, f64>| {
        let places = (0..c).flat_map(|j| (0..c).map(move |i| (i, j)));
        places.map(|p| (gram[p] - f64::from(p.0 == p.1)).abs()).fold(0.0, f64::max)
    };
    Ok(far(gram.as_ref()))
}

/// Returns the reports of each contender on its runs, which take turns.
fn race(
    arguments: &Arguments,
    folder: &Path,
    python: &Path,
    threads: usize,
) -> Result<[Vec<Report>; CONTENDERS.len()]> {
    let this = std::env::current_exe()?;
    let (t, place) = (threads.to_string(), folder.display().to_string());
    let script = child::script("gram_schmidt.py");
    let mut reports = [const { Vec::new() }; CONTENDERS.len()];
    for repetition in 0..arguments.repeat.max(1) {
        for (contender, reports) in CONTENDERS.iter().zip(&mut reports) {
            match contender {
                Contender::Ours(_, method) => {
                    let ours = ["ortho", "--solve", &place, "--method", method, "--threads", &t];
                    reports.push(child::run(&this, &ours, threads)?);
                }
                Contender::Python(_, "columns")
                    if repetition >= arguments.numpy_repeat.unwrap_or(usize::MAX).max(1) => {}
                Contender::Python(_, method) => {
                    reports.push(child::run(python, &[&script, &place, method], threads)?);
                }
            }
        }
    }
    Ok(reports)
}
