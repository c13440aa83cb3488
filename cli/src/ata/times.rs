//! `A^T B` and `A^H B`, where B has the rows of A.

use std::num::NonZeroUsize;
use std::time::Instant;

use anyhow::{Context, Result, bail};
use catamaran::base::{block_rows, reserved, zeros};
use catamaran::blas::BlasReal;
use catamaran::faer::prelude::ReborrowMut;
use catamaran::faer::{MatMut, MatRef, c64};
use catamaran::io::{self as files, Output};
use catamaran::product::{ahb_into, atb_into};
use catamaran::rows::RowBlocks;
use catamaran::{AtaOptions, Uplo};

use super::complex::{self, require_finite};
use super::{Args, Unbounded, shown, write_matrix};
use crate::progress::{self, Bar};
use crate::ranks::Ranks;
use crate::report::{seconds, status};
use crate::rows::Source;

/// Refuses options of symmetric products.
pub fn refuse(args: &Args, ranks: &Ranks) -> Result<()> {
    let given = [
        ("--uplo", args.uplo != Uplo::Both),
        ("--weights", args.weights.is_some()),
        ("--center", args.center),
        ("--covariance", args.covariance),
        ("--verify", args.verify),
        ("--explain", args.explain),
        ("--picture", args.picture.is_some()),
        ("--memory", args.memory.is_some()),
        ("--checkpoint", args.checkpoint.is_given()),
        ("--accumulator", args.accumulator.is_some()),
        ("several processes", ranks.size() > 1),
    ];
    match given.into_iter().find(|(_, given)| *given) {
        Some((name, _)) => bail!("--times can't be combined with {name}"),
        None => Ok(()),
    }
}

/// Computes C, and writes it.
pub fn run(
    args: &Args,
    (a, b): (&Source, &Source),
    options: &AtaOptions<'_>,
    output: Option<Output>,
) -> Result<()> {
    a.refuse_dropped(b.path())?;
    b.refuse_dropped(a.path())?;
    let (m, rows) = (a.shape().0, b.shape().0);
    let (of_a, of_b) = (a.path().display(), b.path().display());
    if rows != m {
        bail!("{of_b}: {rows} rows, where {of_a} has {m}");
    }
    let is_complex = a.complex().is_some();
    let printed = if is_complex { complex::PRINTED } else { shown::PRINTED };
    let (n, k) = (a.shape().1, b.shape().1);
    if output.is_none() && n.max(k) > printed {
        bail!("C is {n} x {k}: --times needs -o above {printed} rows or columns");
    }
    let are_single = a.is_single() && b.is_single();
    let is_double = args.double || !args.single && !are_single;
    match (a.complex(), b.complex()) {
        (Some(first), Some(second)) if args.require_finite => {
            require_finite(a, first)?;
            require_finite(b, second)?;
            complex_product([(a, first), (b, second)], options, output)
        }
        (Some(first), Some(second)) => complex_product([(a, first), (b, second)], options, output),
        (None, None) if is_double => real::<f64>(args, (a, b), options, output),
        (None, None) => real::<f32>(args, (a, b), options, output),
        _ => bail!("{of_b}: must be real or complex as {of_a} is"),
    }
}

fn complex_product(
    operands: [(&Source, MatRef<'_, c64>); 2],
    options: &AtaOptions<'_>,
    output: Option<Output>,
) -> Result<()> {
    let [(_, a), (_, b)] = operands;
    let (n, k) = (a.ncols(), b.ncols());
    let start = Instant::now();
    let len = n.saturating_mul(k);
    let mut entries: Vec<c64> = reserved(len).with_context(|| format!("C of {n} x {k} entries"))?;
    let zero = c64::new(0.0, 0.0);
    entries.resize(len, zero);
    let c = MatMut::from_row_major_slice_mut(&mut entries, n, k);
    ahb_into(c64::new(1.0, 0.0), a, b, zero, c, options)?;
    done((n, k), "c64", "A^H B", start)?;
    let c = MatRef::from_row_major_slice(&entries, n, k);
    complex::note_range(&operands, c)?;
    let Some(output) = output else { return complex::show(c) };
    let path = output.path().display().to_string();
    files::write_complex(output, c)?;
    status!("written", path = path; "{path}")
}

/// Adds up the products of blocks of rows.
fn real<T: BlasReal>(
    args: &Args,
    (a, b): (&Source, &Source),
    options: &AtaOptions<'_>,
    output: Option<Output>,
) -> Result<()> {
    let ((m, n), k) = (a.shape(), b.shape().1);
    let what = || format!("C of {n} x {k} entries");
    let mut entries = zeros::<T>(n.saturating_mul(k)).with_context(what)?;
    let mut c = MatMut::from_row_major_slice_mut(&mut entries, n, k);
    let given = args.block_rows.map(NonZeroUsize::get);
    let height = given.unwrap_or_else(|| block_rows::<T>(n.saturating_add(k), false));
    let height = height.clamp(1, m.max(1));
    let mut of_a = a.rows::<T>(args.require_finite)?;
    let mut of_b = b.rows::<T>(args.require_finite)?;
    let mut a_entries = zeros::<T>(height.saturating_mul(n))?;
    let mut b_entries = zeros::<T>(height.saturating_mul(k))?;
    let start = Instant::now();
    let bar = Bar::new("computing");
    for first in (0..m).step_by(height) {
        bar.step(first as f64 / m as f64)?;
        let count = height.min(m - first);
        let a = block(&mut *of_a, &mut a_entries, first, count)?;
        let b = block(&mut *of_b, &mut b_entries, first, count)?;
        atb_into(T::ONE, a, b, T::ONE, c.rb_mut(), options)?;
    }
    drop(bar);
    done((n, k), T::NAME, "A^T B", start)?;
    let unbounded = Unbounded::among(entries.iter().map(|entry| entry.is_finite()));
    let names = format!("{}, {}", a.path().display(), b.path().display());
    let culprit = |file: &Source| -> Result<Option<String>> {
        Ok(file.not_finite()?.map(|what| format!("{}: {what}", file.path().display())))
    };
    unbounded.note(&names, T::NAME, || match culprit(a)? {
        None => culprit(b),
        found => Ok(found),
    })?;
    let c = MatRef::from_row_major_slice(&entries, n, k);
    match output {
        Some(output) => write_matrix(output, c),
        None => shown::show(c, Uplo::Both),
    }
}

/// Reads `count` rows from `first` on.
fn block<'e, T: BlasReal>(
    rows: &mut dyn RowBlocks<T>,
    entries: &'e mut [T],
    first: usize,
    count: usize,
) -> Result<MatRef<'e, T>> {
    let ncols = rows.ncols();
    let entries = &mut entries[..count * ncols];
    rows.read(first, MatMut::from_row_major_slice_mut(&mut *entries, count, ncols))?;
    Ok(MatRef::from_row_major_slice(entries, count, ncols))
}

fn done((n, k): (usize, usize), scalar: &str, product: &str, start: Instant) -> Result<()> {
    let time = start.elapsed();
    status!(
        "product": "C",
        rows = n,
        columns = k,
        scalar = scalar;
        "{n} x {k}, {scalar}, {product}"
    )?;
    status!("time", seconds = time.as_secs_f64(); "{}", seconds(time))?;
    Ok(progress::check()?)
}
