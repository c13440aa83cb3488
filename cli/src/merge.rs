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
use crate::rows::{
    COLUMNS, NUMBERS, PARTS, ROWS, RowList, WEIGHTS, WITHOUT_WEIGHTS, fingerprint_of_text,
};

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
    let mut seen: Vec<Labelled> = Vec::new();
    for (i, path) in args.inputs.iter().enumerate() {
        bar.step(i as f64 / args.inputs.len() as f64)?;
        let next = read(path)?;
        let own = Labelled::of(path, next.labels());
        // The first file that says which columns it has.
        if let Some(first) = seen.iter().find(|other| other.columns.is_some()) {
            own.check_columns(first)?;
        }
        if let Some(line) = seen.iter().find_map(|other| own.rows_of(other)) {
            note(format_args!("{line}"));
        }
        seen.push(own);
        match &mut sum {
            None => sum = Some(next),
            Some(sum) => sum.merge(next).with_context(|| path.display().to_string())?,
        }
    }
    drop(bar);
    let Some(mut sum) = sum else { bail!("no sums to merge") };
    let is_weighted = seen.iter().any(|file| file.is_weighted);
    let labels = labels_of_all(&seen, sum.labels());
    sum.set_labels(labels);
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

/// A file of sums, and what its labels say.
struct Labelled<'a> {
    path: &'a Path,
    /// `None` for sums of other programs.
    columns: Option<KnownColumns>,
    /// What the sums are made of, each a fingerprint of rows and of their weights; none where no
    /// label says which rows they are of.
    parts: Vec<String>,
    is_weighted: bool,
}

/// What the columns of sums are.
#[derive(Debug, Clone, PartialEq, Eq)]
enum KnownColumns {
    /// Their names, one in a line.
    Named(String),
    /// The numbers that they have in a file without names.
    Numbered(RowList),
}

impl KnownColumns {
    fn of(labels: &[(String, String)]) -> Option<Self> {
        labels.iter().find_map(|(name, value)| match name.as_str() {
            COLUMNS => Some(Self::Named(value.clone())),
            NUMBERS => value.parse().ok().map(Self::Numbered),
            _ => None,
        })
    }

    fn to_label(&self) -> (String, String) {
        match self {
            Self::Named(names) => (COLUMNS.to_owned(), names.clone()),
            Self::Numbered(numbers) => (NUMBERS.to_owned(), numbers.to_string()),
        }
    }

    /// Returns how these columns differ from those `there`, for a message.
    fn difference(&self, there: &Self) -> Option<String> {
        let at = |j: usize, own: String, others: String| {
            format!("column {j} (counted from 0) is {own}, and {others} there")
        };
        match (self, there) {
            (Self::Named(names), Self::Named(others)) => {
                let mut pairs = names.lines().zip(others.lines()).enumerate();
                let (j, (name, other)) = pairs.find(|(_, (name, other))| name != other)?;
                Some(at(j, format!("{name:?}"), format!("{other:?}")))
            }
            (Self::Numbered(numbers), Self::Numbered(others)) => {
                let mut pairs = numbers.iter().zip(others.iter()).enumerate();
                let (j, (number, other)) = pairs.find(|(_, (number, other))| number != other)?;
                Some(at(j, format!("number {number} of its file"), format!("number {other}")))
            }
            (Self::Named(_), Self::Numbered(_)) => Some("they have names, and none there".into()),
            (Self::Numbered(_), Self::Named(_)) => Some("they have no names, but there".into()),
        }
    }
}

impl<'a> Labelled<'a> {
    fn of(path: &'a Path, labels: &[(String, String)]) -> Self {
        let (columns, parts) = (KnownColumns::of(labels), parts(labels));
        Self { path, columns, parts, is_weighted: has_weights(labels) }
    }

    /// Checks that the sums are of the columns of those of a file before.
    fn check_columns(&self, other: &Self) -> Result<()> {
        let (Some(own), Some(others)) = (&self.columns, &other.columns) else { return Ok(()) };
        let Some(how) = own.difference(others) else { return Ok(()) };
        let (path, other) = (self.path.display(), other.path.display());
        bail!("{path}: sums of other columns than {other}: {how}")
    }

    /// Returns a note if the sums are of rows that those of a file before are of, too.
    fn rows_of(&self, other: &Self) -> Option<String> {
        let count = self.parts.iter().filter(|part| other.parts.contains(part)).count();
        let is_same = self.path == other.path;
        let some = if is_same || count == other.parts.len() { "the" } else { "some of the" };
        let (path, other) = (self.path.display(), other.path.display());
        let line = || format!("{path}: sums of {some} rows in {other}, which count twice");
        (is_same || count > 0).then(line)
    }
}

/// Returns the labels of merged sums: those that all files share, and what another merge needs to
/// know of each.
fn labels_of_all(files: &[Labelled<'_>], shared: &[(String, String)]) -> Vec<(String, String)> {
    /// Most parts that a label lists: with the names of columns it must fit the head of a file.
    const MOST: usize = 1000;
    let mut labels: Vec<_> = shared.iter().filter(|(name, _)| name != PARTS).cloned().collect();
    let columns = files.iter().find_map(|file| file.columns.as_ref()).map(KnownColumns::to_label);
    labels.extend(columns.filter(|(name, _)| shared.iter().all(|(known, _)| known != name)));
    if files.iter().any(|file| file.is_weighted) && !has_weights(shared) {
        labels.push((WEIGHTS.to_owned(), "several".to_owned()));
    }
    let parts: Vec<&str> =
        files.iter().flat_map(|file| &file.parts).map(String::as_str).take(MOST).collect();
    if !parts.is_empty() && !has_rows(&labels) {
        labels.push((PARTS.to_owned(), parts.join(",")));
    }
    labels
}

/// Returns what sums are made of: the parts of merged ones, or the rows of a file.
fn parts(labels: &[(String, String)]) -> Vec<String> {
    let value = |wanted: &str| {
        let found = labels.iter().find(|(name, _)| name == wanted);
        found.map_or("", |(_, value)| value.as_str())
    };
    if has_rows(labels) {
        let rows = ["A", ROWS, WEIGHTS].map(value).join("\n");
        return vec![format!("{:016x}", fingerprint_of_text(&rows))];
    }
    value(PARTS).split(',').filter(|part| !part.is_empty()).map(str::to_owned).collect()
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
