//! `catamaran lstsq`.

mod names;
mod output;

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use catamaran::gram::{LeastSquares, LeastSquaresOptions};
use catamaran::io::Output;
use clap::ArgGroup;

use self::output::Solution;
use crate::common::HEADING;
use crate::gram::{GramArgs, Pass, Table};
use crate::output as files;
use crate::ranks::Ranks;
use crate::report::{note, use_json};
use crate::rows::open;

/// Solve min |W^(1/2) (A X - B)|^2 + L |X|^2 for tall A (m x n) and B (m x k) in files.
///
/// Rows are read twice, block by block (.npy and HDF5 may be larger than memory): once for their
/// bounds, once for A^T A in extended precision, from which more digits follow than from a QR
/// decomposition in double precision. Where columns depend on others, X is the solution of least
/// norm. Prints each coefficient with its standard error and t. Under `mpirun` (where MPI is built
/// in) each rank takes a part of the rows, and the result is the same.
///
/// The file has the arrays `x` and `standard_error` (n x k), `residual_norm` and `r_squared` (k),
/// `intercept` and `intercept_error` (k), `x_low` (what rounding took from x), and `rank`,
/// `dependent`, `degrees_of_freedom`, `condition` and `digits`.
#[derive(clap::Args)]
#[command(
    group = ArgGroup::new("target").args(["b", "by_column"]).required(true),
    override_usage = "catamaran lstsq [OPTIONS] <A> <B>\n       \
                      catamaran lstsq [OPTIONS] <A> --by-column <Y[,Z]>"
)]
pub struct Args {
    #[command(flatten)]
    gram: GramArgs,
    /// The targets B, m x k, in any format of A.
    #[arg(value_name = "B")]
    b: Option<PathBuf>,
    /// Take the targets from these columns of A: names in the header of a text table, or numbers
    /// counted from 0.
    #[arg(long, value_name = "Y[,Z]", value_delimiter = ',')]
    by_column: Vec<String>,
    /// File of m weights W, none of them negative.
    #[arg(long, value_name = "FILE")]
    weights: Option<PathBuf>,
    /// Multiple L of |X|^2 that is added to what is minimised; the intercept is not part of X.
    #[arg(long, value_name = "L", default_value = "0", allow_negative_numbers = true)]
    ridge: f64,
    /// Fit a constant too.
    #[arg(long)]
    intercept: bool,
    /// Fail when columns depend on others.
    #[arg(long)]
    refuse_dependent: bool,
    /// Write the arrays to this .npz file, .h5 where HDF5 is built in, or as text to .json.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Without FILE: print a JSON object a line on stdout (JSON Lines) instead of text. With FILE:
    /// write the result, with the names of columns, to this .json file.
    #[arg(long, value_name = "FILE", num_args = 0..=1, help_heading = HEADING)]
    json: Option<Option<PathBuf>>,
    /// `--json` without FILE, whatever follows.
    // Stands in for the option of all commands, which has the name of the one above.
    #[arg(long, hide = true)]
    json_lines: bool,
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    if matches!(args.json, Some(None)) {
        use_json();
    }
    let ranks = Ranks::join()?;
    let done = run_as(args, &ranks);
    ranks.end(done)
}

fn run_as(args: &Args, ranks: &Ranks) -> Result<()> {
    if !(args.ridge >= 0.0 && args.ridge.is_finite()) {
        bail!("--ridge must be finite and at least 0, and not {}", args.ridge);
    }
    let outputs = if ranks.is_first() { start(args)? } else { Outputs::default() };
    args.gram.check(ranks)?;
    let Rows { table, columns, targets } = rows(args)?;
    let pass = Pass::new(&args.gram, ranks, &table, args.weights.as_deref(), args.intercept)?;
    let Some(gram) = pass.gram()? else { return pass.end() };
    let options =
        LeastSquaresOptions::new().ridge(args.ridge).intercept(args.intercept).par(args.gram.par());
    let name = || args.gram.input().display().to_string();
    let found = LeastSquares::from_gram(&gram, targets.len(), &options).with_context(name)?;
    report_dependent(args, &columns, &found)?;
    let rows = gram.rows();
    let solution = Solution { found, columns, targets, intercept: args.intercept, rows };
    solution.print()?;
    if let Some(output) = outputs.arrays {
        solution.write_arrays(output)?;
    }
    for output in outputs.json.into_iter().flatten() {
        solution.write_json(output)?;
    }
    pass.end()
}

/// The files to write, already begun.
#[derive(Default)]
struct Outputs {
    arrays: Option<Output>,
    json: [Option<Output>; 2],
}

fn start(args: &Args) -> Result<Outputs> {
    let force = args.gram.force;
    let is_json =
        |path: &Path| path.extension().is_some_and(|end| end.eq_ignore_ascii_case("json"));
    let mut outputs = Outputs::default();
    if let Some(path) = &args.output {
        match is_json(path) {
            true => outputs.json[0] = Some(force.create(path)?),
            false => outputs.arrays = Some(files::arrays(path, force)?),
        }
    }
    if let Some(Some(path)) = &args.json {
        if !is_json(path) {
            bail!(
                "{}: must be called .json (to print JSON Lines, give --json last)",
                path.display()
            );
        }
        outputs.json[1] = Some(force.create(path)?);
    }
    Ok(outputs)
}

/// The rows of `[A B]`, and what their columns are called.
struct Rows {
    table: Table,
    columns: Vec<String>,
    targets: Vec<String>,
}

fn rows(args: &Args) -> Result<Rows> {
    let a = args.gram.open()?;
    let first = args.gram.first_column();
    let mut columns = names::names(&a, first);
    if let Some(path) = &args.b {
        let b = open("B", path, None)?;
        let targets = names::names(&b, 0);
        return Ok(Rows { table: Table::joined(a, b)?, columns, targets });
    }
    let found = names::find(args.gram.input(), &columns, first, &args.by_column)?;
    let targets = found.iter().map(|&column| columns[column].clone()).collect();
    let mut order: Vec<usize> =
        (0..columns.len()).filter(|column| !found.contains(column)).collect();
    columns = order.iter().map(|&column| columns[column].clone()).collect();
    order.extend(found);
    Ok(Rows { table: Table::ordered(a, order), columns, targets })
}

/// Refuses columns that depend on others, if asked to, or notes them.
fn report_dependent(args: &Args, columns: &[String], found: &LeastSquares) -> Result<()> {
    if found.dependent.is_empty() {
        return Ok(());
    }
    let (path, count) = (args.gram.input().display(), found.dependent.len());
    let listed = names::list(found.dependent.iter().map(|&column| columns[column].as_str()));
    let what = match count {
        1 => format!("column {listed} depends on others"),
        _ => format!("columns {listed} depend on others"),
    };
    if args.refuse_dependent {
        bail!("{path}: {what}");
    }
    note(format_args!("{path}: {what}; of all solutions this is the one of least norm"));
    Ok(())
}
