//! `catamaran lstsq`.

mod design;
mod names;
mod output;

use std::path::{Path, PathBuf};

use anyhow::{Context, Error, Result, anyhow, bail};
use catamaran::io::Output;
use catamaran::solve::{LeastSquares, LeastSquaresOptions};
use clap::ArgGroup;

use self::design::{Designed, Term};
use self::names::{Names, Place};
use self::output::Solution;
use crate::gram::{GramArgs, Pass, Table};
use crate::output as files;
use crate::parse;
use crate::ranks::Ranks;
use crate::report::note;
use crate::rows::open;
use crate::tables::MatrixFile;

/// Solve linear least squares, also weighted or with a ridge, for a tall matrix.
///
/// Solves min |W^(1/2) (A X - B)|^2 + L |X|^2 for A (m x n) and B (m x k).
///
/// Rows are read twice, block by block (.npy and HDF5 may be larger than memory): once for their
/// bounds, once for A^T A in extended precision, which gives more digits than a QR decomposition in
/// double precision. Where columns depend on others, X is the solution of least norm. Prints each
/// coefficient with its standard error, its t statistic and its p value. Under `mpirun` (where MPI
/// is built in) each rank takes a part of the rows, and the result is the same.
///
/// The output file has the arrays `x`, `standard_error`, `t` and `p` (n x k), `residual_norm`,
/// `residual_deviation`, `r_squared`, `adjusted_r_squared`, `f_statistic` and `f_p` (k), `x_low` (n
/// x k, what rounding removed from `x`), with --intercept `intercept`, `intercept_error`,
/// `intercept_t` and `intercept_p` (k), and `rank`, `dependent`, `observations`,
/// `degrees_of_freedom`, `condition` and `digits`.
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
    b: Option<MatrixFile>,
    /// Take the targets from these columns of A: names in the header of a text table, or numbers
    /// counted from 0.
    #[arg(long, value_name = "Y[,Z]", value_delimiter = ',')]
    by_column: Vec<String>,
    /// File of the m weights W, each at least 0.
    #[arg(long, value_name = "FILE")]
    weights: Option<PathBuf>,
    /// Factor L of |X|^2 in the minimized function, at least 0; the intercept is not part of X.
    #[arg(long, value_name = "L", default_value_t = LeastSquaresOptions::default().ridge)]
    ridge: f64,
    /// Also fit a constant for each target.
    #[arg(long)]
    intercept: bool,
    /// Take this column of A, a name or a number, for a factor: it becomes one column for each of
    /// its values but the base, with 1 in the rows of that value and 0 elsewhere, and each
    /// coefficient is a difference from the base. The base is the least value unless it is named
    /// after an equals sign. May be a list between commas, and be given several times.
    #[arg(long, value_name = "NAME[=BASE]")]
    factor: Vec<String>,
    /// Also print and write confidence intervals with this confidence, such as 0.95: `lower` and
    /// `upper`, and with --intercept `intercept_lower` and `intercept_upper`.
    #[arg(long, value_name = "SHARE", value_parser = parse::confidence)]
    confidence: Option<f64>,
    /// Also write the covariance of the coefficients of each target, the intercept first: the array
    /// `covariance` (the targets one below the other), and in .json what `predict` needs for
    /// standard errors.
    #[arg(long, requires = "output")]
    covariance: bool,
    /// Fail if columns depend linearly on others.
    #[arg(long)]
    refuse_dependent: bool,
    /// Output file: .npz, or .h5 where HDF5 is built in, with the arrays; or .json with the result
    /// and the names of columns. May be given several times.
    #[arg(short, long, value_name = "FILE")]
    output: Vec<PathBuf>,
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    let ranks = Ranks::join()?;
    let done = run_as(args, &ranks);
    ranks.end(done)
}

fn run_as(args: &Args, ranks: &Ranks) -> Result<()> {
    let begin = || -> Result<_> {
        if !(args.ridge >= 0.0 && args.ridge.is_finite()) {
            bail!("--ridge {}: a finite number of at least 0 is needed", args.ridge);
        }
        let outputs = if ranks.is_first() { start(args)? } else { Vec::new() };
        args.gram.check(ranks)?;
        let rows = rows(args)?;
        refuse_empty(args, &rows)?;
        Ok((outputs, rows))
    };
    let (outputs, rows) = ranks.meet(begin())?;
    let designed = design::apply(&args.gram, ranks, rows, &args.factor)?;
    // All rows may have been left out.
    ranks.meet(refuse_empty(args, &designed.rows))?;
    report_bases(args, &designed.terms);
    let Designed { rows: Rows { table, columns, targets, shared, .. }, terms, dropped } = designed;
    report_shared(args, shared.as_deref());
    let pass = Pass::new(&args.gram, ranks, &table, args.weights.as_deref(), args.intercept)?;
    let Some(gram) = pass.gram()? else { return pass.end() };
    let options =
        LeastSquaresOptions::new().ridge(args.ridge).intercept(args.intercept).par(args.gram.par());
    let name = || args.gram.input().display().to_string();
    let found = LeastSquares::from_gram(&gram, targets.len(), &options).with_context(name)?;
    report_dependent(args, &columns, &found)?;
    let solution = Solution {
        found,
        columns,
        terms,
        targets,
        intercept: args.intercept,
        rows: gram.rows(),
        dropped: dropped as u64,
        confidence: args.confidence,
        covariance: args.covariance,
    };
    solution.print()?;
    for output in outputs {
        match is_json(output.path()) {
            true => solution.write_json(output)?,
            false => solution.write_arrays(output)?,
        }
    }
    pass.end()
}

fn is_json(path: &Path) -> bool {
    path.extension().is_some_and(|end| end.eq_ignore_ascii_case("json"))
}

/// Returns whether the end of the name is that of a file of arrays, also where it is not built in.
fn is_arrays(path: &Path) -> bool {
    let ends = ["npz", "h5", "hdf5", "he5"];
    path.extension().is_some_and(|end| ends.iter().any(|known| end.eq_ignore_ascii_case(known)))
}

/// Begins the output files.
fn start(args: &Args) -> Result<Vec<Output>> {
    let force = args.gram.force;
    let begin = |path: &PathBuf| match is_json(path) {
        true => force.create(path),
        false if !is_arrays(path) => {
            bail!("{}: the name must end in .json, .npz, .h5, .hdf5 or .he5", path.display())
        }
        false => files::arrays(path, force),
    };
    args.output.iter().map(begin).collect()
}

/// The rows of `[A B]`, and the names of their columns.
struct Rows {
    table: Table,
    columns: Vec<String>,
    /// The numbers of those of A in its file.
    numbers: Vec<usize>,
    targets: Vec<String>,
    /// How each of those of A is found in another table.
    places: Vec<Place>,
    /// A name that two columns of A, or of A and its targets, have.
    shared: Option<String>,
    /// For each of the columns the levels that its entries are numbers of; none for numbers.
    levels: Vec<Vec<String>>,
}

/// Returns the error of a file B that can't be read, with the option for a target in A if that is
/// what was named.
fn with_column(error: Error, name: &str, columns: &[String]) -> Error {
    match columns.iter().any(|column| column == name) {
        true => anyhow!("{error}; A has a column of that name: give --by-column {name}"),
        false => error,
    }
}

fn rows(args: &Args) -> Result<Rows> {
    let a = args.gram.open_with_factors(design::possible_names(&args.factor))?;
    let (mut columns, mut numbers) = (a.column_names(), a.numbers());
    let mut places = names::places(&a);
    let shared = names::shared(&columns, &places);
    let mut levels: Vec<Vec<String>> = (0..columns.len()).map(|j| a.levels(j).to_vec()).collect();
    if let Some(path) = &args.b {
        let b = open("B", path, &args.gram.other_tables().read_all_rows());
        let b = b.map_err(|e| with_column(e, &path.display().to_string(), &columns))?;
        let targets = b.column_names();
        let table = Table::joined(a, b)?;
        return Ok(Rows { table, columns, numbers, targets, places, shared, levels });
    }
    let (path, are_selected) = (args.gram.input(), args.gram.selects_columns());
    let names = Names { path, names: &columns, numbers: &numbers, are_selected };
    let found = names.find(&args.by_column)?;
    if let Some(&column) = found.iter().find(|&&column| !levels[column].is_empty()) {
        let (a, name) = (path.display(), &columns[column]);
        bail!("{a}: column {name} has words: a factor is no target");
    }
    let targets = found.iter().map(|&column| columns[column].clone()).collect();
    let mut order: Vec<usize> =
        (0..columns.len()).filter(|column| !found.contains(column)).collect();
    columns = order.iter().map(|&column| columns[column].clone()).collect();
    numbers = order.iter().map(|&column| numbers[column]).collect();
    places = order.iter().map(|&column| places[column]).collect();
    levels = order.iter().map(|&column| levels[column].clone()).collect();
    order.extend(found);
    let table = Table::ordered(a, order);
    Ok(Rows { table, columns, numbers, targets, places, shared, levels })
}

/// Refuses a matrix A or B without columns, and one without rows.
fn refuse_empty(args: &Args, Rows { table, columns, targets, .. }: &Rows) -> Result<()> {
    let a = args.gram.input().display();
    match &args.b {
        _ if columns.is_empty() && !args.by_column.is_empty() => {
            bail!("{a}: no columns besides those of --by-column")
        }
        _ if columns.is_empty() => bail!("{a}: no columns"),
        Some(b) if targets.is_empty() => bail!("{}: no columns", b.display()),
        _ if table.nrows() == 0 => bail!("{a}: no rows"),
        _ => Ok(()),
    }
}

/// Reports that factors are compared with 0 where there is no intercept.
fn report_bases(args: &Args, terms: &[Term]) {
    let base = |term: &Term| Some(format!("{}[{}]", term.column, term.levels.first()?));
    let bases: Vec<String> = terms.iter().filter_map(base).collect();
    if !args.intercept && !bases.is_empty() {
        let (path, listed) = (args.gram.input(), names::list(bases.iter().map(String::as_str)));
        let why = "without --intercept the base of each factor has the coefficient 0";
        note(format_args!("{}: {why}: {listed}", path.display()));
    }
}

/// Notes that `predict` will refuse the model in a .json file, if two columns have one name.
fn report_shared(args: &Args, shared: Option<&str>) {
    let (Some(name), Some(model)) = (shared, args.output.iter().find(|path| is_json(path))) else {
        return;
    };
    let which = match name {
        "" => "have no name".into(),
        name => format!("are called {name}"),
    };
    let (path, model) = (args.gram.input().display(), model.display());
    note(format_args!("{path}: two columns {which}: `predict` will refuse {model}"));
}

/// Reports columns that depend on others: by a note, or with --refuse-dependent by an error.
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
    note(format_args!("{path}: {what}; X is the solution of least norm"));
    Ok(())
}
