//! `catamaran svd`.

use std::path::PathBuf;

use anyhow::{Context, Result};
use catamaran::faer::linalg::matmul::matmul;
use catamaran::faer::{Accum, Mat, MatRef, Par};
use catamaran::io::{Array, ArraysWriter};
use catamaran::solve::{Orthogonality, SingularValues, orthogonality};

use crate::gram::{GramArgs, Pass, SHOWN, Table, second_pass};
use crate::output;
use crate::ranks::Ranks;
use crate::report::{head, note, report, row, shown, status};

/// Compute the singular values and vectors of a tall matrix in a file.
///
/// Rows are read twice, block by block (.npy and HDF5 may be larger than memory): once for their
/// bounds, once for A^T A in extended precision, which keeps small singular values accurate. The
/// output file has the arrays `values` (n, descending; zeros where columns depend on others) and
/// `v` (n x rank). Under `mpirun` (where MPI is built in) each rank takes a part of the rows.
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    gram: GramArgs,
    /// Write the arrays to this .npz file, or .h5 where HDF5 is built in.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Also write `u` (m x rank), A v / sigma, by one more pass over the rows. Columns of small
    /// singular values are less accurate: the error of a column is about 2^-53 times the largest
    /// singular value over that of the column, and a note says how many have fewer than three
    /// digits.
    #[arg(long, requires = "output")]
    left: bool,
    /// Print how far the columns are from orthonormal: the largest entry of A^T A - I by size, and
    /// its Frobenius norm.
    #[arg(long)]
    orthogonality: bool,
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    let ranks = Ranks::join()?;
    let done = run_as(args, &ranks);
    ranks.end(done)
}

fn run_as(args: &Args, ranks: &Ranks) -> Result<()> {
    let begin = || -> Result<_> {
        let path = args.output.as_deref().filter(|_| ranks.is_first());
        let output = path.map(|path| output::arrays(path, args.gram.force)).transpose()?;
        args.gram.check(ranks)?;
        Ok((output, Table::of(args.gram.open()?)))
    };
    let (output, table) = ranks.meet(begin())?;
    let name = || args.gram.input().display().to_string();
    let table = args.gram.complete(ranks, table)?;
    let pass = Pass::new(&args.gram, ranks, &table, None, false)?;
    let Some(gram) = pass.gram()? else { return pass.end() };
    let found = SingularValues::from_gram(&gram, args.gram.par()).with_context(name)?;
    report_values(&found)?;
    if args.orthogonality {
        let Orthogonality { max, frobenius, .. } = orthogonality(&gram).with_context(name)?;
        report!(
            "orthogonality": "A^T A - I",
            max = max,
            frobenius = frobenius;
            "largest entry {max:.6e}, Frobenius norm {frobenius:.6e}"
        )?;
    }
    if let Some(output) = output {
        let path = output.path().display().to_string();
        let mut writer = ArraysWriter::new(output)?;
        writer.array("values", Array::Vector(&found.values))?;
        writer.array("v", Array::Matrix(found.v.as_ref()))?;
        if args.left {
            let left = |rows: MatRef<'_, f64>| left_vectors(rows, &found);
            second_pass(&table, &mut writer, "u", found.rank(), left)?;
            note_inaccurate(&name(), &found);
        }
        writer.finish()?;
        status!("written", path = path; "{path}")?;
    } else {
        status!("hint", option = "-o"; "-o FILE.npz writes the singular vectors")?;
    }
    pass.end()
}

fn report_values(found: &SingularValues) -> Result<()> {
    let (rank, n) = (found.rank(), found.values.len());
    report!("rank", rank = rank, columns = n; "{rank} of {n} columns")?;
    if let (Some(first), Some(last)) = (found.values.first(), found.values[..rank].last()) {
        let condition = first / last;
        report!("condition", condition = condition; "{condition:.6e}")?;
    }
    for (i, value) in found.values.iter().take(shown(SHOWN)).enumerate() {
        row!("singular_value", number = i, value = value; "{i:>8}  {value:.15e}")?;
    }
    if n > SHOWN {
        head(format_args!("          ... and {} more", n - SHOWN))?;
    }
    Ok(())
}

/// Notes columns of U whose error, as `--left` describes it, leaves fewer than three digits.
fn note_inaccurate(file: &str, found: &SingularValues) {
    const LARGEST: f64 = 1e-3;
    let (rank, first) = (found.rank(), found.values.first().copied().unwrap_or(0.0));
    let least = f64::EPSILON / 2.0 * first / LARGEST;
    let count = found.values[..rank].iter().filter(|value| **value < least).count();
    if count > 0 {
        note(format_args!(
            "{file}: the last {count} of {rank} columns of u have fewer than three correct digits: \
             their singular values are below {least:.1e}"
        ));
    }
}

/// Returns rows of U.
fn left_vectors(rows: MatRef<'_, f64>, found: &SingularValues) -> catamaran::Result<Mat<f64>> {
    let (count, rank) = (rows.nrows(), found.rank());
    let mut left = Mat::new();
    let bytes = count.saturating_mul(rank).saturating_mul(size_of::<f64>());
    left.try_reserve(count, rank).map_err(|_| catamaran::Error::OutOfMemory { bytes })?;
    left.resize_with(count, rank, |_, _| 0.0);
    matmul(left.as_mut(), Accum::Replace, rows, found.v.as_ref(), 1.0, Par::Seq);
    for (j, sigma) in found.values[..rank].iter().enumerate() {
        left.col_mut(j).iter_mut().for_each(|entry| *entry /= sigma);
    }
    Ok(left)
}
