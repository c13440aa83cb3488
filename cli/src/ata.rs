//! `catamaran ata`.

use std::any::Any;
use std::io::{self, Write};
use std::num::NonZeroUsize;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};
use catamaran::ata::{Center, DenseRows, RowBlocks, RowOptions, ata_rows, verify_rows};
use catamaran::base::Workspace;
use catamaran::blas::{Backend, BlasReal};
use catamaran::faer::prelude::Reborrow;
use catamaran::faer::{Mat, MatMut, MatRef};
use catamaran::io::{
    self as files, CsMat, Dense, Matrix, Output, Overwrite, ReadOptions, SparseRows,
};
use catamaran::{Accuracy, AtaOptions, Par, Plan, SchemeChoice, Uplo};
use clap::builder::PossibleValuesParser;
use clap::builder::TypedValueParser as _;

use crate::progress::{self, Bar};
use crate::{backend, picture};

/// Compute C = A^T A of a matrix in a file.
///
/// Reads .npy, .mtx, .csv, .tsv and .txt, each also as .gz. Sparse .mtx files stay sparse.
#[derive(clap::Args)]
pub struct Args {
    /// The matrix A, m x n.
    #[arg(value_name = "A")]
    input: PathBuf,
    /// Where C goes, n x n: .npy, .mtx, .csv, .tsv or .txt, and .gz after it.
    #[arg(short, long, value_name = "C")]
    output: Option<PathBuf>,
    /// Use these columns of A only, counted from 0, the last one excluded.
    #[arg(long, value_name = "FIRST..END", value_parser = parse_columns)]
    columns: Option<Range<usize>>,
    /// Triangle of C to compute; the other one is zero in the output.
    #[arg(long, value_name = "TRIANGLE", default_value = "both", value_parser = uplo_parser())]
    uplo: Uplo,
    /// File of m weights W: compute A^T W A.
    #[arg(long, value_name = "FILE")]
    weights: Option<PathBuf>,
    /// Subtract the mean of each column (the weighted mean if there are weights).
    #[arg(long)]
    center: bool,
    /// Subtract the means, and divide by m - 1: the sample covariance.
    #[arg(long, conflicts_with = "weights")]
    covariance: bool,
    /// Threads; all cores of the affinity mask unless given. Does not change C.
    #[arg(long, value_name = "N")]
    threads: Option<NonZeroUsize>,
    /// Recursion.
    #[arg(long, value_name = "SCHEME", default_value = "auto", value_parser = scheme_parser())]
    scheme: SchemeChoice,
    /// Error allowed: max (the exact path), classical, default, fast, or a factor (>= 1) over the
    /// classical algorithm.
    #[arg(long, value_name = "ACCURACY", default_value = "default", value_parser = parse_accuracy)]
    accuracy: Accuracy,
    /// The same bytes on every machine: the exact path, which without AMX is slower than others.
    #[arg(long)]
    reproducible: bool,
    /// Scale columns by powers of two around fast levels: for columns of very different sizes.
    #[arg(long)]
    scale_columns: bool,
    /// BLAS: native (built in), openblas (if built in), or the path of a CBLAS library.
    #[arg(long, value_name = "NAME", default_value = "native")]
    backend: String,
    /// Compute in single precision.
    #[arg(long = "f32", conflicts_with = "double")]
    single: bool,
    /// Compute in double precision; the default unless A is single.
    #[arg(long = "f64")]
    double: bool,
    /// Check C with random vectors; a failure is an error, and nothing is written.
    #[arg(long)]
    verify: bool,
    /// Print the plan first.
    #[arg(long)]
    explain: bool,
    /// Write a heat map (PNG) of C, scaled to a unit diagonal.
    #[arg(long, value_name = "FILE")]
    picture: Option<PathBuf>,
    /// Refuse an A with NaN or infinite entries.
    #[arg(long)]
    strict: bool,
    /// Replace files that exist.
    #[arg(long)]
    force: bool,
}

fn uplo_parser() -> impl clap::builder::TypedValueParser<Value = Uplo> {
    PossibleValuesParser::new(["lower", "upper", "both"]).map(|name| match name.as_str() {
        "lower" => Uplo::Lower,
        "upper" => Uplo::Upper,
        _ => Uplo::Both,
    })
}

fn scheme_parser() -> impl clap::builder::TypedValueParser<Value = SchemeChoice> {
    PossibleValuesParser::new(SchemeChoice::NAMES.map(|(name, _)| name)).map(|name| {
        let found = SchemeChoice::NAMES.into_iter().find(|(known, _)| *known == name);
        found.map_or(SchemeChoice::Auto, |(_, scheme)| scheme)
    })
}

fn parse_accuracy(text: &str) -> Result<Accuracy, String> {
    match text {
        "max" => Ok(Accuracy::Max),
        "classical" => Ok(Accuracy::Classical),
        "default" => Ok(Accuracy::Default),
        "fast" => Ok(Accuracy::Fast),
        _ => match text.parse() {
            Ok(factor) if factor >= 1.0 && f64::is_finite(factor) => Ok(Accuracy::Bounded(factor)),
            _ => {
                Err("expected max, classical, default, fast, or a number that is at least 1".into())
            }
        },
    }
}

fn parse_columns(text: &str) -> Result<Range<usize>, String> {
    let bounds = text.split_once("..").map(|(first, end)| (first.parse(), end.parse()));
    match bounds {
        Some((Ok(first), Ok(end))) if first <= end => Ok(first..end),
        _ => Err("expected FIRST..END, such as 0..64".into()),
    }
}

/// Rounds of the check: a wrong C passes with a probability of 2^-20.
const ROUNDS: u32 = 20;
/// Any number does; a fixed one makes runs repeatable.
const SEED: u64 = 0xCA7A;

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    // What can be refused is refused before any work.
    if args.reproducible && !matches!(args.scheme, SchemeChoice::Auto | SchemeChoice::Exact) {
        let name = SchemeChoice::NAMES.into_iter().find(|(_, scheme)| *scheme == args.scheme);
        let name = name.map_or("another", |(name, _)| name);
        bail!("--reproducible is --scheme exact, and can't be combined with --scheme {name}");
    }
    let overwrite = if args.force { Overwrite::Replace } else { Overwrite::Never };
    if let Some(path) = &args.output {
        files::check_name(path)?;
    }
    for path in [&args.output, &args.picture].into_iter().flatten() {
        if !args.force && path.symlink_metadata().is_ok() {
            bail!("{}: exists already (--force replaces it)", path.display());
        }
    }
    let backend = backend::find(&args.backend)?;
    let create = |path: &PathBuf| Output::create(path, overwrite);
    let outputs = Outputs {
        c: args.output.as_ref().map(create).transpose()?,
        picture: args.picture.as_ref().map(create).transpose()?,
    };

    let start = Instant::now();
    let a = read(&args.input, "reading", args.columns.clone())?;
    let (kind, double) = match &a {
        Matrix::F32(_) => ("f32".into(), args.double),
        Matrix::Sparse(sparse) => (format!("f64, {} nonzeros", sparse.nnz()), !args.single),
        _ => ("f64".to_owned(), !args.single),
    };
    report(format_args!(
        "A         {}: {} x {}, {kind}, read in {}",
        args.input.display(),
        a.nrows(),
        a.ncols(),
        seconds(start.elapsed()),
    ))?;
    if args.strict {
        check_finite(&args.input, &mut *rows_of::<f64>(&a))?;
    }
    let weights = match &args.weights {
        Some(path) => Some(read_weights(path, &args.input, a.nrows())?),
        None => None,
    };
    if double {
        product::<f64>(args, &a, weights.as_deref(), backend, outputs)
    } else {
        product::<f32>(args, &a, weights.as_deref(), backend, outputs)
    }
}

/// The files to write, already begun.
struct Outputs {
    c: Option<Output>,
    picture: Option<Output>,
}

/// Computes C in the precision of T, and whatever else was asked for.
fn product<T: BlasReal>(
    args: &Args,
    a: &Matrix,
    weights: Option<&[f64]>,
    backend: Arc<dyn Backend>,
    outputs: Outputs,
) -> Result<()> {
    let (m, n) = (a.nrows(), a.ncols());
    let alpha = match (args.covariance, m) {
        (true, 0 | 1) => {
            bail!("{}: {m} rows have no covariance; at least 2 do", args.input.display())
        }
        (true, m) => 1.0 / (m - 1) as f64,
        (false, _) => 1.0,
    };
    let centered = args.center || args.covariance;
    let mut memory = Workspace::<T>::new(n.saturating_mul(n))
        .with_context(|| format!("C of {n} x {n} entries"))?;
    let mut c = MatMut::from_column_major_slice_mut(&mut memory.as_mut_slice()[..n * n], n, n);

    let bar = Bar::new("computing");
    let update = |fraction| bar.update(fraction);
    let options = AtaOptions {
        uplo: args.uplo,
        par: args.threads.map_or_else(Par::all, |n| Par::Threads(n.get())),
        scheme: args.scheme,
        accuracy: args.accuracy,
        reproducible: args.reproducible,
        scale_columns: args.scale_columns,
        backend,
        progress: Some(&update),
        ..AtaOptions::default()
    };
    let plan = Plan::ata::<T>(m, n, &options)?;
    let direct = if weights.is_none() && !centered { view_of::<T>(a) } else { None };
    // The sums of a sparse product are those of the classical algorithm.
    let exact = args.reproducible || args.accuracy == Accuracy::Max;
    let sparse = match a {
        Matrix::Sparse(a)
            if !centered && !exact && args.scheme == SchemeChoice::Auto && sparse_is_faster(a) =>
        {
            Some(a)
        }
        _ => None,
    };
    if args.explain {
        explain(&plan, &options, direct.is_some(), sparse)?;
    }

    let start = Instant::now();
    if let Some(a) = sparse {
        sparse_product(a, weights, c.as_mut(), &options)?;
    } else if let Some(view) = direct {
        catamaran::ata(T::from_f64(alpha), view, T::ZERO, c.as_mut(), &options)?;
    } else {
        let narrow: Option<Vec<T>> = weights.map(|w| w.iter().map(|&w| T::from_f64(w)).collect());
        let center = if centered { Center::Mean } else { Center::No };
        let row_options = RowOptions { weights: narrow.as_deref(), center };
        let rows = &mut *rows_of::<T>(a);
        ata_rows(T::from_f64(alpha), rows, &row_options, T::ZERO, c.as_mut(), &options)?;
    }
    let elapsed = start.elapsed();
    drop(bar);
    let triangle = match args.uplo {
        Uplo::Lower => "lower triangle",
        Uplo::Upper => "upper triangle",
        Uplo::Both => "both triangles",
    };
    report(format_args!("C         {n} x {n}, {}, {triangle}", T::NAME))?;
    let rate = m as f64 * (n as f64).powi(2) / elapsed.as_secs_f64().max(1e-9) / 1e9;
    report(format_args!(
        "time      {}, {rate:.2} effective GFLOP/s (m n^2 / time)",
        seconds(elapsed)
    ))?;

    if args.verify {
        let center = if centered { Center::Mean } else { Center::No };
        let row_options = RowOptions { weights, center };
        let rows = &mut *rows_of::<f64>(a);
        let found = verify_rows(alpha, rows, &row_options, c.rb(), args.uplo, ROUNDS, SEED)?;
        let numbers = format!("residual {:.2e}, tolerance {:.2e}", found.residual, found.tolerance);
        if !found.passed {
            bail!("the check failed, and nothing is written: {numbers}");
        }
        report(format_args!(
            "check     passed: {numbers}, false-accept probability {:.1e}",
            found.false_accept_probability
        ))?;
    }
    progress::check()?;
    if let Some(output) = outputs.c {
        let path = output.path().to_owned();
        files::write(output, c.rb())?;
        report(format_args!("written   {}", path.display()))?;
    }
    if let Some(output) = outputs.picture {
        let path = output.path().to_owned();
        picture::write(output, c.rb(), |i, j| match args.uplo {
            Uplo::Upper => (i.min(j), i.max(j)),
            Uplo::Lower | Uplo::Both => (i.max(j), i.min(j)),
        })?;
        report(format_args!("picture   {}", path.display()))?;
    }
    Ok(())
}

fn explain(
    plan: &Plan,
    options: &AtaOptions<'_>,
    direct: bool,
    sparse: Option<&CsMat<f64>>,
) -> Result<()> {
    if let Some(a) = sparse {
        return report(format_args!(
            "plan      sparse: the outer product of each row, {} multiplications",
            row_products(a)
        ));
    }
    for (i, line) in plan.to_string().lines().enumerate() {
        report(format_args!("{}{line}", if i == 0 { "plan      " } else { "          " }))?;
    }
    if !direct {
        report(format_args!(
            "          rows       block by block: converted, weighted or centred on the way"
        ))?;
    }
    let threads = options.par.threads();
    if plan.is_exact() {
        // No back end has a part in it.
        return report(format_args!("          threads    {threads}"));
    }
    report(format_args!("          back end   {}, {threads} threads", options.backend.name()))
}

/// Multiplications of [`sparse_product`]: the square of the nonzeros of each row.
fn row_products(a: &CsMat<f64>) -> usize {
    a.outer_iterator().map(|row| row.nnz() * row.nnz()).sum()
}

/// Whether [`sparse_product`] beats the dense one, whose multiplications are many times faster.
fn sparse_is_faster(a: &CsMat<f64>) -> bool {
    /// Scattered multiplications that take as long as a dense one.
    const RATIO: f64 = 32.0;
    RATIO * row_products(a) as f64 <= a.rows() as f64 * (a.cols() as f64).powi(2)
}

/// `C = A^T W A` as the sum over the rows of `w_i a_i a_i^T`, in f64 until the entries of C. C is zero.
fn sparse_product<T: BlasReal>(
    a: &CsMat<f64>,
    weights: Option<&[f64]>,
    mut c: MatMut<'_, T>,
    options: &AtaOptions<'_>,
) -> catamaran::Result<()> {
    for (i, row) in a.outer_iterator().enumerate() {
        if i % 4096 == 0 {
            if let Some(progress) = options.progress {
                progress(i as f64 / a.rows() as f64);
            }
            progress::check()?;
        }
        let weight = weights.map_or(1.0, |w| w[i]);
        for (j, &left) in row.iter() {
            for (k, &right) in row.iter().take_while(|&(k, _)| k <= j) {
                let at = if options.uplo == Uplo::Upper { (k, j) } else { (j, k) };
                c[at] += T::from_f64(weight * left * right);
            }
        }
    }
    if options.uplo == Uplo::Both {
        for j in 0..c.ncols() {
            for i in 0..j {
                c[(i, j)] = c[(j, i)];
            }
        }
    }
    Ok(())
}

/// The dense matrix itself, when it is of type T.
fn view_of<T: BlasReal>(a: &Matrix) -> Option<MatRef<'_, T>> {
    let any: &dyn Any = match a {
        Matrix::F32(dense) => dense,
        Matrix::F64(dense) => dense,
        _ => return None,
    };
    any.downcast_ref::<Dense<T>>().map(Dense::as_ref)
}

/// The rows, converted to T.
fn rows_of<T: BlasReal>(a: &Matrix) -> Box<dyn RowBlocks<T> + '_> {
    match a {
        Matrix::F32(dense) => Box::new(DenseRows(dense.as_ref())),
        Matrix::F64(dense) => Box::new(DenseRows(dense.as_ref())),
        Matrix::Sparse(sparse) => Box::new(SparseRows(sparse)),
        _ => unreachable!("no other kind of matrix comes out of a file"),
    }
}

fn read(path: &Path, label: &'static str, columns: Option<Range<usize>>) -> Result<Matrix> {
    let bar = Bar::new(label);
    let update = |fraction| bar.update(fraction);
    match files::read(path, &ReadOptions { columns, progress: Some(&update) }) {
        // These two know no file.
        Err(e @ (catamaran::Error::Argument { .. } | catamaran::Error::OutOfMemory { .. })) => {
            Err(e).with_context(|| path.display().to_string())
        }
        result => Ok(result?),
    }
}

/// The `m` weights in a file with one row or one column.
fn read_weights(path: &Path, input: &Path, m: usize) -> Result<Vec<f64>> {
    let matrix = read(path, "weights", None)?;
    let (nrows, ncols) = (matrix.nrows(), matrix.ncols());
    if (nrows, ncols) != (m, 1) && (nrows, ncols) != (1, m) {
        bail!(
            "{}: {nrows} x {ncols} where the {m} rows of {} need {m} weights",
            path.display(),
            input.display()
        );
    }
    let mut rows = rows_of::<f64>(&matrix);
    let mut values = Mat::zeros(nrows, ncols);
    rows.read(0, values.as_mut())?;
    let weights: Vec<f64> =
        (0..m).map(|i| if ncols == 1 { values[(i, 0)] } else { values[(0, i)] }).collect();
    match weights.iter().position(|w| !w.is_finite()) {
        Some(i) => bail!("{}: weight {i} (counted from 0) is not finite", path.display()),
        None => Ok(weights),
    }
}

fn check_finite(path: &Path, rows: &mut dyn RowBlocks<f64>) -> Result<()> {
    const BLOCK: usize = 256;
    let (m, n) = (rows.nrows(), rows.ncols());
    let mut block = Mat::zeros(BLOCK.min(m), n);
    for first in (0..m).step_by(BLOCK) {
        progress::check()?;
        let count = BLOCK.min(m - first);
        rows.read(first, block.as_mut().subrows_mut(0, count))?;
        for i in 0..count {
            if let Some(j) = (0..n).find(|&j| !block[(i, j)].is_finite()) {
                bail!(
                    "{}: {} at row {}, column {} (counted from 0)",
                    path.display(),
                    block[(i, j)],
                    first + i,
                    j
                );
            }
        }
    }
    Ok(())
}

/// One line on stdout; a closed pipe is an error, not a panic.
fn report(line: std::fmt::Arguments<'_>) -> Result<()> {
    Ok(writeln!(io::stdout(), "{line}")?)
}

fn seconds(time: Duration) -> String {
    match time.as_secs_f64() {
        s if s < 1e-3 => format!("{:.1} us", s * 1e6),
        s if s < 1.0 => format!("{:.1} ms", s * 1e3),
        s => format!("{s:.2} s"),
    }
}
