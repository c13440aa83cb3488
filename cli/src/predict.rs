//! `catamaran predict`.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, anyhow, bail};
use catamaran::Par;
use catamaran::base::block_rows;
use catamaran::faer::{Mat, MatRef};
use catamaran::io::{Columns, FileFormat, Missing, Output, ReadOptions, TableReading};
use catamaran::rows::{Design, DesignColumn, Factor, RowBlocks as _};
use catamaran::solve::{Interval, LinearModel, Uncertainty};
use clap::ValueEnum;
use serde::Deserialize;

use crate::claims::{Purpose, claim};
use crate::common::Force;
use crate::gram::{SHOWN, Table, survey};
use crate::progress::Bar;
use crate::report::{head, note, row, shown, status};
use crate::rows::{Source, open};
use crate::tables::{MatrixFile, TableArgs};
use crate::{output, parse};

/// Most rows that are predicted at a time.
const ROWS: usize = 4096;

/// Predict targets from a table with the coefficients of `lstsq -o FIT.json`.
///
/// The columns of the table are found by the names that those of the fit had, such as those in the
/// header of a text table. The columns of a fit without names have numbers, counted from 0: the
/// table must have no names either, or these numbers for names. Other columns are not used. A level
/// of a factor that the model does not have is an error. If columns of the model depended on
/// others, a note names them. With `--missing nan` a row with a missing value has no prediction
/// (NaN); with `--missing drop` the others have one, with the number of their row.
#[derive(clap::Args)]
pub struct Args {
    /// The .json file of the model.
    #[arg(value_name = "FIT.json")]
    model: PathBuf,
    /// The table, in any format of the matrices of `lstsq`.
    #[arg(value_name = "TABLE")]
    table: MatrixFile,
    /// Also return the ends of an interval for each prediction. The model must have been written
    /// with `lstsq --covariance`.
    #[arg(long, value_enum, value_name = "OF")]
    interval: Option<Of>,
    /// The confidence of the interval, above 0 and below 1.
    #[arg(
        long,
        value_name = "SHARE",
        default_value = "0.95",
        value_parser = parse::confidence,
        requires = "interval"
    )]
    confidence: f64,
    /// Output file, .csv: a line for each row, with a column for each target, and two more for the
    /// ends of its interval. With --missing drop, the first column is the row of the table, from 0.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    force: Force,
    #[command(flatten)]
    reading: TableArgs,
}

/// What an interval contains.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Of {
    /// The mean of all observations with the values of the row.
    Mean,
    /// One new observation.
    Observation,
}

/// A model as `lstsq` writes it. Other fields are not used.
#[derive(Debug, Deserialize)]
struct Model {
    terms: Vec<Term>,
    /// The names of the columns of all terms.
    #[serde(default)]
    columns: Vec<String>,
    /// Those that depended on others when the model was fitted.
    #[serde(default)]
    dependent: Vec<usize>,
    targets: Vec<Target>,
    degrees_of_freedom: u64,
    root: Option<Vec<Vec<f64>>>,
    mean: Option<Vec<f64>>,
    weight: Option<f64>,
}

#[derive(Debug, Deserialize)]
struct Term {
    column: String,
    /// The name in the header where that is not `column`: it was empty.
    name: Option<String>,
    /// The number of a column without a name, or whose name was its number.
    number: Option<usize>,
    #[serde(default)]
    levels: Vec<String>,
}

impl Term {
    /// Returns the name that the column must have in a table with names.
    fn name(&self) -> &str {
        self.name.as_deref().unwrap_or(&self.column)
    }

    /// Says that a table with names lacks the column.
    fn not_in(&self, reading: &TableReading) -> String {
        if self.number.is_none() {
            return format!("has no column called {}", self.name());
        }
        let mut known = reading.columns.iter().map(|column| column.name.as_str());
        let example = known.find(|name| !name.is_empty());
        let example = example.map_or(String::new(), |name| format!(", such as {name}"));
        let how = match reading.format {
            FileFormat::Table => "; --no-header, with --skip for the line of names, takes numbers",
            _ => "",
        };
        let number = &self.column;
        format!(
            "the columns of the fit have numbers, such as {number}, and those of the table have \
             names{example}{how}"
        )
    }
}

#[derive(Debug, Deserialize)]
struct Target {
    name: String,
    x: Vec<f64>,
    x_low: Vec<f64>,
    intercept: Option<f64>,
    residual_norm: f64,
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    let output = match &args.output {
        Some(path) => Some(output::csv(path, args.force)?),
        None => None,
    };
    let model = Model::read(&args.model)?;
    model.note_dependent(&args.model);
    let missing = args.reading.missing();
    let needed = model.needs(args.reading.read_all_rows());
    let table = open("table", &args.table, &needed);
    let table = Table::of(table.map_err(|error| model.without_column(error, &args.table))?);
    table.check_options(None, &args.reading.read())?;
    let name = || args.table.display().to_string();
    model.check_columns(table.a()).with_context(name)?;
    let mut design = model.design(table.a()).with_context(name)?;
    if missing == Missing::Drop {
        design = design.without_rows(survey(&table, &[], missing, Par::all())?.missing);
    }
    let (x, low) = model.coefficients(&args.model, design.ncols())?;
    let root = model.root();
    let intercepts: Vec<f64> =
        model.targets.iter().map(|target| target.intercept.unwrap_or(0.0)).collect();
    let norms: Vec<f64> = model.targets.iter().map(|target| target.residual_norm).collect();
    let uncertainty = match (&root, &model.mean) {
        (Some(root), Some(mean)) => Some(Uncertainty {
            root: root.as_ref(),
            mean,
            weight: model.weight.unwrap_or(f64::INFINITY),
            residual_norms: &norms,
            degrees_of_freedom: model.degrees_of_freedom,
        }),
        _ => None,
    };
    if args.interval.is_some() && uncertainty.is_none() {
        bail!(
            "{}: has no covariance for --interval: write it with `lstsq --covariance`",
            args.model.display()
        );
    }
    let linear = LinearModel {
        coefficients: x.as_ref(),
        coefficients_low: low.as_ref(),
        intercepts: &intercepts,
        uncertainty,
    };
    let mut sink =
        Sink { output, model: &model, rows: (missing == Missing::Drop).then_some(&design) };
    sink.begin(args.interval.is_some())?;
    let mut all = match missing {
        Missing::Error => table.a().rows::<f64>(true)?,
        _ => table.a().rows_with_missing()?,
    };
    let mut rows = design.rows(&mut *all).with_context(name)?;
    let (count, n) = (rows.nrows(), rows.ncols());
    let m = count.min(sink.most());
    let height = block_rows::<f64>(n, false).min(ROWS).min(m).max(1);
    let bar = Bar::new("rows");
    for first in (0..m).step_by(height) {
        bar.step(first as f64 / m as f64)?;
        let mut block = Mat::zeros(height.min(m - first), n);
        let read = rows.read(first, block.as_mut());
        read.map_err(|error| model.about_rows(error, &args.table))?;
        let found = Predictions::of(&linear, block.as_ref(), args)?;
        if let Some(i) = found.out_of_range(block.as_ref(), model.degrees_of_freedom > 0) {
            bail!(
                "{}: the prediction of row {} (counted from 0) is out of the range of f64",
                args.table.display(),
                design.row_of_table(first + i)
            );
        }
        sink.add(first, &found)?;
    }
    drop(bar);
    sink.end(count)
}

impl Model {
    fn read(path: &Path) -> Result<Self> {
        claim(path, Purpose::Input)?;
        let bytes = fs::read(path).map_err(|error| catamaran::Error::io(path, error))?;
        let name = path.display();
        let Ok(text) = std::str::from_utf8(&bytes) else {
            bail!("{name}: not a model, which `lstsq -o` writes where the name ends in .json")
        };
        let model: Self = serde_json::from_str(text)
            .with_context(|| format!("{name}: not a model that `lstsq -o FIT.json` wrote"))?;
        match model.shared_name() {
            Some("") => bail!("{name}: two columns of the fit have no name"),
            Some(shared) => bail!("{name}: two columns of the fit are called {shared}"),
            None => Ok(model),
        }
    }

    /// Returns a name that two columns have.
    fn shared_name(&self) -> Option<&str> {
        let mut known = BTreeSet::new();
        self.terms.iter().map(Term::name).find(|name| !known.insert(*name))
    }

    /// Notes columns that depended on others: of all coefficients that fit the data equally well,
    /// the model has those of least norm, and in other rows they predict something else.
    fn note_dependent(&self, path: &Path) {
        let names: Vec<&str> = self
            .dependent
            .iter()
            .map(|&column| self.columns.get(column).map_or("?", String::as_str))
            .collect();
        let (s, verb) = if names.len() == 1 { ("", "s") } else { ("s", "") };
        if !names.is_empty() {
            note(format_args!(
                "{}: column{s} {} depend{verb} on others in the rows of the fit: predictions of \
                 rows where this is not so are arbitrary",
                path.display(),
                names.join(", ")
            ));
        }
    }

    /// Returns the options that read the columns of the model, in its order.
    fn needs<'a>(&self, options: ReadOptions<'a>) -> ReadOptions<'a> {
        let factors = self.terms.iter().filter(|term| !term.levels.is_empty());
        let table =
            options.table.clone().factors(factors.map(|term| term.name().to_owned()).collect());
        let columns = self.terms.iter().map(|term| term.name().to_owned()).collect();
        options.columns(Columns::list(columns)).table(table)
    }

    /// Refuses a table of which columns were taken by their numbers in place of their names, or the
    /// other way round, and words where the fit had numbers.
    fn check_columns(&self, table: &Source) -> Result<()> {
        let reading = table.reading().filter(|reading| reading.header);
        let numbers = table.numbers();
        for (j, term) in self.terms.iter().enumerate() {
            let name = term.name();
            if let Some(reading) = reading {
                let own = reading.columns.get(j);
                if own.is_none_or(|column| column.name != name) {
                    bail!("{}", term.not_in(reading));
                }
            } else if numbers.get(j) != term.number.as_ref() {
                bail!("has no column called {name}: its columns have no names");
            }
            if term.levels.is_empty() && !table.levels(j).is_empty() {
                bail!("column {name} has words, and had numbers in the fit");
            }
        }
        Ok(())
    }

    /// Returns the design of a table with the columns of the model.
    fn design(&self, table: &Source) -> Result<Design> {
        let column = |(j, term): (usize, &Term)| -> Result<DesignColumn> {
            if term.levels.is_empty() {
                return Ok(DesignColumn::Numbers(j));
            }
            let factor = Factor::in_order(&term.column, term.levels.clone())?;
            let factor = match table.levels(j) {
                [] => factor.for_numbers()?,
                words => factor.for_codes(words).map_err(|error| self.without_level(error))?,
            };
            Ok(DesignColumn::Indicators(j, factor))
        };
        Ok(Design::new(self.terms.iter().enumerate().map(column).collect::<Result<_>>()?))
    }

    /// Says of an error about the columns of the fit what the table lacks.
    fn without_column(&self, error: anyhow::Error, path: &Path) -> anyhow::Error {
        let said = match error.downcast_ref() {
            Some(catamaran::Error::Argument { what: "columns", why }) => self.lacking(why),
            _ => None,
        };
        match said {
            Some(said) => anyhow!("{}: {said}", path.display()),
            None => error,
        }
    }

    /// Returns what a table lacks of which the columns of the fit were not found for this reason.
    fn lacking(&self, why: &str) -> Option<String> {
        if let Some(rest) = why.strip_prefix("no column ") {
            let unnamed = if rest.starts_with("; ") { "with an empty name" } else { "" };
            return Some(format!("has no column {unnamed}{rest}"));
        }
        let name = why.strip_prefix("two columns are called ");
        if let Some(name) = name.and_then(|rest| rest.strip_suffix("; give a number instead")) {
            let which = match name {
                "" => "have no name".into(),
                name => format!("are called {name}"),
            };
            return Some(format!("two columns {which}, of which the fit had one"));
        }
        // The number that is the name of a column in the fit was taken for that of another one.
        let is_number = |name: &&str| name.starts_with(|c: char| c.is_ascii_digit());
        let numbers: Vec<&str> = self.terms.iter().map(Term::name).filter(is_number).collect();
        why.ends_with(" is named twice")
            .then(|| format!("has not all of the columns called {}", numbers.join(", ")))
    }

    /// Returns the error of reading rows, with the file.
    fn about_rows(&self, error: catamaran::Error, path: &Path) -> anyhow::Error {
        match error {
            error @ catamaran::Error::Io { .. } => error.into(),
            error => self.without_level(error).context(path.display().to_string()),
        }
    }

    /// Says of an error about a level of a factor that the fit lacks it, and not the table.
    fn without_level(&self, error: catamaran::Error) -> anyhow::Error {
        let said = match &error {
            catamaran::Error::Argument { what: "factor", why } => {
                self.terms.iter().find_map(|Term { column, .. }| {
                    let rest = why.strip_prefix(column.as_str())?;
                    let is_level = rest.starts_with(" has no level ");
                    is_level.then(|| anyhow!("column {column}: the fit{rest}"))
                })
            }
            _ => None,
        };
        said.unwrap_or_else(|| error.into())
    }

    /// Returns the two parts of the coefficients, n x k.
    fn coefficients(&self, path: &Path, n: usize) -> Result<(Mat<f64>, Mat<f64>)> {
        let root = self.root.iter().flatten();
        let fits = self.targets.iter().all(|target| target.x.len() == n && target.x_low.len() == n)
            && self.mean.as_ref().is_none_or(|mean| mean.len() == n)
            && root.into_iter().all(|row| row.len() == n);
        if !fits {
            bail!("{}: damaged: its terms have {n} columns", path.display());
        }
        let k = self.targets.len();
        let x = Mat::from_fn(n, k, |j, q| self.targets[q].x[j]);
        Ok((x, Mat::from_fn(n, k, |j, q| self.targets[q].x_low[j])))
    }

    /// Returns the root of the covariance, if there is one.
    fn root(&self) -> Option<Mat<f64>> {
        let rows = self.root.as_ref()?;
        let n = self.mean.as_ref()?.len();
        Some(Mat::from_fn(rows.len(), n, |i, j| rows[i][j]))
    }
}

/// Predictions of some rows, and the ends of their intervals.
struct Predictions {
    values: Mat<f64>,
    ends: Option<[Mat<f64>; 2]>,
}

impl Predictions {
    fn of(model: &LinearModel<'_>, rows: MatRef<'_, f64>, args: &Args) -> Result<Self> {
        let interval = args.interval.map(|of| match of {
            Of::Mean => Interval::Confidence,
            Of::Observation => Interval::Prediction,
        });
        let ends = interval.map(|interval| model.intervals(rows, interval, args.confidence));
        Ok(Self { values: model.predict(rows)?, ends: ends.transpose()? })
    }

    /// Returns the first of these rows without a missing value of which a prediction is out of
    /// range, or an end of its interval. Without degrees of freedom these ends are NaN.
    fn out_of_range(&self, rows: MatRef<'_, f64>, has_freedom: bool) -> Option<usize> {
        let checked = if has_freedom { usize::MAX } else { 1 };
        let is_finite = |i: usize| {
            let mut targets = 0..self.values.ncols();
            targets.all(|q| self.of_entry(i, q).take(checked).all(f64::is_finite))
        };
        let is_complete = |i: usize| (0..rows.ncols()).all(|j| !rows[(i, j)].is_nan());
        (0..rows.nrows()).find(|&i| !is_finite(i) && is_complete(i))
    }

    /// Returns the prediction, and the ends of its interval.
    fn of_entry(&self, i: usize, q: usize) -> impl Iterator<Item = f64> + '_ {
        let ends = self.ends.iter().flatten().map(move |ends| ends[(i, q)]);
        std::iter::once(self.values[(i, q)]).chain(ends)
    }
}

/// Where predictions go: a file, or the screen.
struct Sink<'a> {
    output: Option<Output>,
    model: &'a Model,
    /// Which rows of the table are predicted, if not all.
    rows: Option<&'a Design>,
}

impl Sink<'_> {
    /// Writes the titles.
    fn begin(&mut self, intervals: bool) -> Result<()> {
        let mut titles = Vec::new();
        for Target { name, .. } in &self.model.targets {
            titles.push(name.clone());
            if intervals {
                titles.extend([format!("{name}_lower"), format!("{name}_upper")]);
            }
        }
        match &mut self.output {
            Some(output) => {
                // Without quotes, numbers in the first row would be read as data.
                let has_number = titles.iter().any(|title| title.parse::<f64>().is_ok());
                let row = self.rows.map(|_| "row".to_owned());
                let titles = row.into_iter().chain(titles);
                let titles: Vec<String> = titles.map(|title| quoted(&title, has_number)).collect();
                writeln!(output, "{}", titles.join(",")).map_err(|e| output.error(e))?;
            }
            None => {
                let titles = titles.iter().fold(String::new(), |mut line, title| {
                    let _ = write!(line, "  {title:>23}");
                    line
                });
                head(format_args!("{:>8}{titles}", "row"))?;
            }
        }
        Ok(())
    }

    /// Returns the number of rows that there is room for.
    fn most(&self) -> usize {
        if self.output.is_some() { usize::MAX } else { shown(SHOWN) }
    }

    /// Adds the predictions of rows.
    fn add(&mut self, first: usize, found: &Predictions) -> Result<()> {
        for i in 0..found.values.nrows() {
            let entries = |q| found.of_entry(i, q);
            let number = first + i;
            let of_table = self.rows.map(|rows| rows.row_of_table(number));
            if let Some(output) = &mut self.output {
                let fields = (0..self.model.targets.len()).flat_map(entries);
                let fields = fields.map(|x| format!("{x:?}"));
                let row = of_table.map(|row| row.to_string());
                let fields: Vec<String> = row.into_iter().chain(fields).collect();
                writeln!(output, "{}", fields.join(",")).map_err(|e| output.error(e))?;
                continue;
            }
            let mut line = String::new();
            let (mut values, mut ends) = (Vec::new(), Vec::new());
            for q in 0..self.model.targets.len() {
                entries(q).for_each(|x| {
                    let _ = write!(line, "  {x:>23.15e}");
                });
                values.push(found.values[(i, q)]);
                ends.extend(entries(q).skip(1));
            }
            let number = of_table.unwrap_or(number);
            row!(
                "prediction",
                row = number,
                values = values,
                interval_ends = ends;
                "{number:>8}{line}"
            )?;
        }
        Ok(())
    }

    /// Completes the output for a table with this number of rows.
    fn end(self, rows: usize) -> Result<()> {
        let most = self.most();
        match self.output {
            Some(output) => {
                let path = output.path().display().to_string();
                output.commit()?;
                status!("written", path = path; "{path}")
            }
            None if rows > most => {
                head(format_args!("... and {} more (-o FILE.csv writes all)", rows - most))
            }
            None => Ok(()),
        }
    }
}

/// Returns a field of a table, in quotes where it or the caller needs them.
fn quoted(field: &str, always: bool) -> String {
    match always || field.contains([',', '"', '\n', '\r']) {
        true => format!("\"{}\"", field.replace('"', "\"\"")),
        false => field.to_owned(),
    }
}
