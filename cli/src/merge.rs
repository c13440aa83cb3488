//! `catamaran ata-merge`.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use catamaran::Uplo;
use catamaran::blas::BlasReal;
use catamaran::io::{self as files};
use catamaran::rows::Accumulator;
use clap::ArgGroup;

use crate::ata::{Unbounded, write_matrix};
use crate::common::Force;
use crate::parse;
use crate::progress::Bar;
use crate::report::{note, status};
use crate::rows::{COLUMNS, ROWS, WEIGHTS, WITHOUT_WEIGHTS};

/// Compute C = A^T A from the sums of parts of the rows (`ata --accumulator`).
///
/// The parts may be files, or what several machines read.
///
/// Two files of sums are in memory at a time. The order of the files changes only the rounding of
/// C, and nothing for exact sums (`ata --reproducible`).
#[derive(clap::Args)]
#[command(group = ArgGroup::new("result").args(["output", "accumulator"]).required(true).multiple(true))]
pub struct Args {
    /// Files of sums, all with the same columns, precision and centring.
    #[arg(value_name = "ACC", required = true)]
    inputs: Vec<PathBuf>,
    /// Output file of C, n x n: .npy, .mtx, .csv, .tsv or .txt, and .gz after it.
    #[arg(short, long, value_name = "C")]
    output: Option<PathBuf>,
    /// Output file of the merged sums, for another merge.
    #[arg(long, value_name = "FILE")]
    accumulator: Option<PathBuf>,
    /// Triangle of C to compute; the other triangle is zero in the output.
    #[arg(long, value_name = "TRIANGLE", default_value = "both", value_parser = parse::uplo())]
    uplo: Uplo,
    /// Divide by the number of rows minus 1, for the sample covariance; needs centred sums without
    /// weights.
    #[arg(long)]
    covariance: bool,
    #[command(flatten)]
    force: Force,
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    if let Some(path) = &args.output {
        files::check_name(path)?;
    }
    for path in [&args.output, &args.accumulator].into_iter().flatten() {
        args.force.check(path)?;
    }
    let Some(first) = args.inputs.first() else { bail!("no sums to merge") };
    match files::accumulator_scalar(first)? {
        "f32" => merge::<f32>(args),
        _ => merge::<f64>(args),
    }
}

fn merge<T: BlasReal>(args: &Args) -> Result<()> {
    let create = |path: &Option<PathBuf>| path.as_deref().map(|p| args.force.create(p)).transpose();
    let (output, kept) = (create(&args.output)?, create(&args.accumulator)?);
    let bar = Bar::new("merging");
    let mut sum: Option<Accumulator<T>> = None;
    let mut seen: Vec<(&PathBuf, Vec<(String, String)>)> = Vec::new();
    // The first file that has names, and these.
    let mut columns: Option<(&Path, String)> = None;
    for (i, path) in args.inputs.iter().enumerate() {
        bar.step(i as f64 / args.inputs.len() as f64)?;
        let next = read(path)?;
        let labels = next.labels().to_vec();
        if let Some((_, names)) = labels.iter().find(|(name, _)| name == COLUMNS) {
            let (first, others) = columns.get_or_insert_with(|| (path, names.clone()));
            check_columns((path, names), (first, others))?;
        }
        // Merged sums keep only the labels that their parts share: those of A, if it is one file.
        let same = seen
            .iter()
            .find(|(other, seen)| *other == path || has_rows(&labels) && *seen == labels);
        if let Some((other, _)) = same {
            let (name, other) = (path.display(), other.display());
            note(format_args!("{name}: sums of the rows in {other}, which count twice"));
        }
        seen.push((path, labels));
        match &mut sum {
            None => sum = Some(next),
            Some(sum) => sum.merge(next).with_context(|| path.display().to_string())?,
        }
    }
    drop(bar);
    let Some(mut sum) = sum else { bail!("no sums to merge") };
    let is_weighted = seen.iter().any(|(_, labels)| has_weights(labels));
    if is_weighted && !has_weights(sum.labels()) {
        // Merged sums keep only the labels that their parts share, and another merge needs this.
        let mut labels = sum.labels().to_vec();
        labels.push((WEIGHTS.to_owned(), "several".to_owned()));
        sum.set_labels(labels);
    }
    let (rows, n) = (sum.rows(), sum.ncols());
    let centring = if sum.is_centered() { "about the mean" } else { "not centred" };
    let files = args.inputs.len();
    let kind = if sum.is_exact() { ", exact" } else { "" };
    status!(
        "sums",
        files = files,
        rows = rows,
        columns = n,
        scalar = T::NAME,
        centered = sum.is_centered(),
        exact = sum.is_exact();
        "{files} files: {rows} rows, {n} columns, {}, {centring}{kind}",
        T::NAME
    )?;
    let alpha = if args.covariance {
        // Sums of other programs have no labels.
        if !sum.is_centered() || is_weighted || sum.weight() != rows as f64 {
            bail!("--covariance needs centred sums without weights (ata --center)");
        }
        if rows < 2 {
            bail!("--covariance needs at least 2 rows, but the sums have {rows}");
        }
        1.0 / (rows - 1) as f64
    } else {
        1.0
    };
    if let Some(output) = kept {
        let path = output.path().display().to_string();
        files::write_accumulator(output, &sum)?;
        status!("kept", path = path; "{path}")?;
    }
    let Some(output) = output else { return Ok(()) };
    let c = sum.finish(alpha, args.uplo)?;
    let unbounded = Unbounded::of(c.as_ref(), args.uplo);
    if !unbounded.is_none() {
        note(format_args!("{}", unbounded.text()));
    }
    write_matrix(output, c.as_ref())
}

/// Checks that sums are of columns with the names, one in a line, of those of a file before.
fn check_columns((path, own): (&Path, &str), (other, others): (&Path, &str)) -> Result<()> {
    match own.lines().zip(others.lines()).enumerate().find(|(_, (name, other))| name != other) {
        None => Ok(()),
        Some((j, (name, others))) => bail!(
            "{}: sums of other columns than {}: column {j} (counted from 0) is {name:?}, and \
             {others:?} there",
            path.display(),
            other.display()
        ),
    }
}

/// Returns whether labels say which rows of a file the sums are of, as those of `ata` do but for
/// the standard input.
fn has_rows(labels: &[(String, String)]) -> bool {
    let has = |wanted: &str| {
        labels.iter().any(|(name, value)| name == wanted && !value.starts_with("/dev/stdin, "))
    };
    has("A") && has(ROWS)
}

/// Returns whether labels say that rows have weights.
fn has_weights(labels: &[(String, String)]) -> bool {
    labels.iter().any(|(name, value)| name == WEIGHTS && value != WITHOUT_WEIGHTS)
}

/// Reads the sums in a file, and refuses sums that are not complete.
fn read<T: BlasReal>(path: &Path) -> Result<Accumulator<T>> {
    let sum = files::read_accumulator::<T>(path)?;
    let (rows, all) = (sum.rows(), sum.expected_rows());
    if rows < all {
        bail!(
            "{}: a checkpoint at row {rows} of {all}: finish it with `catamaran ata --resume`",
            path.display()
        );
    }
    if sum.strip() != (0..sum.ncols()) {
        bail!("{}: has the sums of a strip of C, not of all of C", path.display());
    }
    Ok(sum)
}
