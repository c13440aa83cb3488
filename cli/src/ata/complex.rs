//! `A^H A` of a complex matrix, which is in memory.

use std::time::Instant;

use anyhow::{Context, Result, bail};
use catamaran::base::reserved;
use catamaran::faer::{MatMut, MatRef, c64};
use catamaran::io::{self as files, check_complex_name};
use catamaran::product::{ComplexPlan, aha_planned};
use catamaran::{AtaOptions, Real};

use super::faint::Lost;
use super::shown::digits;
use super::{Args, Outputs, Unbounded, pinned};
use crate::progress::{self, Bar};
use crate::ranks::Ranks;
use crate::report::{report, row, seconds, status};
use crate::rows::Source;

/// Most rows and columns of a matrix that is printed.
pub const PRINTED: usize = 6;

/// Refuses options of real matrices.
pub fn refuse(args: &Args, ranks: &Ranks) -> Result<()> {
    let given = [
        ("--weights", args.weights.is_some()),
        ("--center", args.center),
        ("--covariance", args.covariance),
        ("--f32", args.single),
        ("--verify", args.verify),
        ("--picture", args.picture.is_some()),
        ("--checkpoint", args.checkpoint.is_given()),
        ("--accumulator", args.accumulator.is_some()),
        ("--block-rows", args.block_rows.is_some()),
        ("several processes", ranks.size() > 1),
    ];
    if let Some((name, _)) = given.into_iter().find(|(_, given)| *given) {
        bail!("{}: {name}: for real numbers only, and A is complex", args.input.display());
    }
    args.output.as_deref().map_or(Ok(()), |path| Ok(check_complex_name(path)?))
}

/// Computes C, and writes or prints it.
pub fn run(
    args: &Args,
    (source, a): (&Source, MatRef<'_, c64>),
    options: &AtaOptions<'_>,
    outputs: Outputs,
) -> Result<()> {
    let (m, n) = a.shape();
    if args.require_finite {
        require_finite(source, a)?;
    }
    let bar = Bar::new("computing");
    let update = |fraction| bar.update(fraction);
    let options = options.clone().memory(args.memory).progress(&update);
    let plan = ComplexPlan::aha::<f64>(m, n, &options)?;
    if args.explain {
        explain(&plan, &options)?;
    }
    let start = Instant::now();
    let len = n.saturating_mul(n);
    let mut entries: Vec<c64> = reserved(len).with_context(|| format!("C of {n} x {n} entries"))?;
    entries.resize(len, c64::new(0.0, 0.0));
    let c = MatMut::from_row_major_slice_mut(&mut entries, n, n);
    aha_planned(&plan, 1.0, a, 0.0, c, &options)?;
    drop(bar);
    let time = start.elapsed();
    status!("product": "C", rows = n, columns = n, scalar = "c64"; "{n} x {n}, c64, A^H A")?;
    status!("time", seconds = time.as_secs_f64(); "{}", seconds(time))?;
    progress::check()?;
    let c = MatRef::from_row_major_slice(&entries, n, n);
    note_range(&[(source, a)], c)?;
    let squared = |j: usize| c[(j, j)].re;
    let is_faint = |j: &usize| squared(*j) < f64::MIN_POSITIVE && !is_zero(a, *j);
    let underflowed: Vec<usize> = (0..n).filter(is_faint).collect();
    Lost { underflowed, rounded: Vec::new() }.note::<f64>(source, false);
    let Some(output) = outputs.c else { return show(c) };
    let path = output.path().display().to_string();
    files::write_complex(output, c)?;
    status!("written", path = path; "{path}")
}

/// Refuses a matrix with an entry that is NaN or infinite.
pub fn require_finite(source: &Source, a: MatRef<'_, c64>) -> Result<()> {
    match not_finite(source, a) {
        Some(what) => bail!("{what}"),
        None => Ok(()),
    }
}

/// Returns the first entry of the matrix of a file that is NaN or infinite, with its place.
fn not_finite(source: &Source, a: MatRef<'_, c64>) -> Option<String> {
    let column = |i: usize| (0..a.ncols()).find(|&j| !a[(i, j)].is_finite());
    let (i, j) = (0..a.nrows()).find_map(|i| Some((i, column(i)?)))?;
    Some(format!("{}: {}", source.path().display(), source.places().at(text(a[(i, j)]), i, j)))
}

/// Notes entries of the product of these files that are not finite, and the cause.
pub fn note_range(operands: &[(&Source, MatRef<'_, c64>)], c: MatRef<'_, c64>) -> Result<()> {
    let places = (0..c.nrows()).flat_map(|i| (0..c.ncols()).map(move |j| (i, j)));
    let unbounded = Unbounded::among(places.map(|place| c[place].is_finite()));
    let names = operands.iter().map(|(source, _)| source.path().display().to_string());
    let names: Vec<String> = names.collect();
    let cause = || Ok(operands.iter().find_map(|(source, matrix)| not_finite(source, *matrix)));
    unbounded.note(&names.join(", "), f64::NAME, cause)
}

/// Returns whether a column is zero.
fn is_zero(a: MatRef<'_, c64>, column: usize) -> bool {
    (0..a.nrows()).all(|i| a[(i, column)] == c64::new(0.0, 0.0))
}

fn explain(plan: &ComplexPlan, options: &AtaOptions<'_>) -> Result<()> {
    let kernels = plan.isa().unwrap_or(options.backend.name());
    let (threads, pinned) = (options.par.threads(), pinned(options));
    report!(
        "plan",
        kernels = kernels,
        threads = threads,
        pinned = !pinned.is_empty();
        "products of real and imaginary parts, by {kernels}, {threads} threads{pinned}"
    )
}

/// Prints C if it is small.
pub fn show(c: MatRef<'_, c64>) -> Result<()> {
    let (rows, n) = (c.nrows(), c.ncols());
    let printed = if rows.max(n) <= PRINTED { rows } else { 0 };
    for i in 0..printed {
        let pairs: Vec<[f64; 2]> = (0..n).map(|j| [c[(i, j)].re, c[(i, j)].im]).collect();
        let cells: Vec<String> = (0..n).map(|j| format!("{:>22}", text(c[(i, j)]))).collect();
        row!("row", number = i, entries = pairs; "{}", cells.join(" "))?;
    }
    status!("hint", option = "-o"; "-o FILE writes all {rows} x {n} entries")
}

/// Formats a complex number in six digits for each part.
fn text(z: c64) -> String {
    let plus = if z.im.is_sign_negative() { "" } else { "+" };
    format!("{}{plus}{}i", digits(z.re), digits(z.im))
}
