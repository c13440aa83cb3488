//! `catamaran pca`.

use std::path::PathBuf;

use anyhow::{Context, Result, bail};
use catamaran::faer::MatRef;
use catamaran::io::{Array, ArraysWriter, Output, check_name};
use catamaran::solve::{Components, PrincipalComponents, PrincipalComponentsOptions, correlation};
use catamaran_charts::{Axis, Chart, Line, Series};

use crate::ata::write_matrix;
use crate::gram::{GramArgs, Pass, SHOWN, Table, second_pass};
use crate::output;
use crate::parse::{self, at_least_one};
use crate::picture::{self, write_chart};
use crate::ranks::Ranks;
use crate::report::{head, report, row, shown, status};

/// Compute the principal components of the rows of a matrix in a file.
///
/// Rows are read twice, block by block (.npy and HDF5 may be larger than memory): once for their
/// bounds, once for the sums in extended precision. The output file has the arrays `components` (k
/// x n), `explained_variance`, `explained_variance_ratio` and `singular_values` (k each), `mean`
/// and `scale` (n each). Under `mpirun` (where MPI is built in) each rank takes a part of the rows.
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    gram: GramArgs,
    /// Number of components [default: all].
    #[arg(short, value_name = "NUMBER", value_parser = at_least_one)]
    k: Option<usize>,
    /// Keep as few components as explain this share of the variance, from 0 to 1, such as 0.95.
    #[arg(long, value_name = "SHARE", value_parser = variance, conflicts_with = "k")]
    variance: Option<f64>,
    /// Divide each column by its standard deviation.
    #[arg(long)]
    standardize: bool,
    /// Divide the scores of each component by the square root of its variance.
    #[arg(long, requires = "scores")]
    whiten: bool,
    /// File of m weights, each at least 0, which count as repetitions of rows.
    #[arg(long, value_name = "FILE")]
    weights: Option<PathBuf>,
    /// Write the arrays to this .npz file, or .h5 where HDF5 is built in.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Also write `scores` (m x k), the coordinates of the rows along the components, by one more
    /// pass over the rows.
    #[arg(long, requires = "output")]
    scores: bool,
    /// Write the correlations of the columns, n x n, NaN for a column without variance: .npy, .mtx,
    /// .csv, .tsv or .txt, and .gz after it.
    #[arg(long, value_name = "FILE")]
    correlations: Option<PathBuf>,
    /// Draw the share of the variance that each component explains to this .svg or .png file.
    #[arg(long, value_name = "FILE")]
    picture: Option<PathBuf>,
}

/// Parses a share of the variance.
fn variance(text: &str) -> Result<f64, String> {
    let share = parse::positive(text).ok().filter(|share| *share <= 1.0);
    share.ok_or_else(|| "expected a number above 0 and at most 1".into())
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
        let path = args.picture.as_deref().filter(|_| ranks.is_first());
        let picture = path.map(|path| picture::create(path, args.gram.force)).transpose()?;
        let path = args.correlations.as_deref().filter(|_| ranks.is_first());
        let correlations = path.map(|path| {
            check_name(path)?;
            args.gram.force.create(path)
        });
        args.gram.check(ranks)?;
        Ok((output, picture, correlations.transpose()?, Table::of(args.gram.open()?)))
    };
    let (output, picture, correlations, table) = ranks.meet(begin())?;
    let name = || args.gram.input().display().to_string();
    let enough = || -> Result<()> {
        if let Some(k) = args.k.filter(|&k| k > table.ncols() && table.ncols() > 0) {
            bail!("{}: -k {k}, where there are {} columns", name(), table.ncols());
        }
        Ok(())
    };
    ranks.meet(enough())?;
    let table = args.gram.complete(ranks, table)?;
    let pass = Pass::new(&args.gram, ranks, &table, args.weights.as_deref(), true)?;
    let Some(gram) = pass.gram()? else { return pass.end() };
    let weight = gram.weight();
    if weight <= 1.0 {
        // Without hundreds of zeros.
        let sum = if weight < 1e-3 { format!("{weight:e}") } else { weight.to_string() };
        match &args.weights {
            Some(weights) => bail!(
                "{}: the --weights add up to {sum}, but a variance needs more than 1",
                weights.display()
            ),
            None => bail!("{}: one row, but a variance needs two", name()),
        }
    }
    let components = match (args.k, args.variance) {
        (Some(count), _) => Components::Count(count),
        (None, Some(share)) => Components::Share(share),
        (None, None) => Components::All,
    };
    let options = PrincipalComponentsOptions::new()
        .components(components)
        .standardize(args.standardize)
        .whiten(args.whiten)
        .par(args.gram.par());
    let found = PrincipalComponents::from_gram(&gram, &options).with_context(name)?;
    report_components(&found)?;
    if let Some(output) = correlations {
        write_matrix(output, correlation(&gram).with_context(name)?.as_ref())?;
    }
    match output {
        Some(output) => write(args, output, &table, &found)?,
        None => status!("hint", option = "-o"; "-o FILE.npz writes the components")?,
    }
    if let Some(picture) = picture {
        let path = picture.path().display().to_string();
        write_chart(picture, &scree(&found))?;
        status!("picture", path = path; "{path}")?;
    }
    pass.end()
}

fn report_components(found: &PrincipalComponents) -> Result<()> {
    let count = found.explained_variance.len();
    let columns = found.mean.len();
    report!("kept", components = count, columns = columns; "{count} components of {columns} columns")?;
    head(format_args!("component       variance     share  cumulative"))?;
    let mut cumulative = 0.0;
    let values = found.explained_variance.iter().zip(&found.explained_variance_ratio);
    for (i, (variance, ratio)) in values.take(shown(SHOWN)).enumerate() {
        cumulative += ratio;
        row!(
            "component",
            number = i,
            variance = variance,
            share = ratio,
            cumulative = cumulative;
            "{i:>9}  {variance:>13.6e}  {ratio:>8.6}  {cumulative:>10.6}"
        )?;
    }
    if count > SHOWN {
        head(format_args!("          ... and {} more", count - SHOWN))?;
    }
    Ok(())
}

fn write(args: &Args, output: Output, table: &Table, found: &PrincipalComponents) -> Result<()> {
    let path = output.path().display().to_string();
    let mut writer = ArraysWriter::new(output)?;
    writer.array("components", Array::Matrix(found.components.as_ref()))?;
    for (name, values) in [
        ("explained_variance", &found.explained_variance),
        ("explained_variance_ratio", &found.explained_variance_ratio),
        ("singular_values", &found.singular_values),
        ("mean", &found.mean),
        ("scale", &found.scale),
    ] {
        writer.array(name, Array::Vector(values))?;
    }
    if args.scores {
        let scores = |rows: MatRef<'_, f64>| found.scores(rows);
        second_pass(table, &mut writer, "scores", found.components.nrows(), scores)?;
    }
    writer.finish()?;
    status!("written", path = path; "{path}")
}

/// Draws the share of the variance of each component, and of all components up to it.
fn scree(found: &PrincipalComponents) -> Chart {
    let ratio = &found.explained_variance_ratio;
    let points = |values: &[f64]| (1..).map(f64::from).zip(values.iter().copied()).collect();
    let mut sum = 0.0;
    let sums: Vec<f64> = ratio
        .iter()
        .map(|ratio| {
            sum += ratio;
            sum
        })
        .collect();
    let cumulative = Series::curve("cumulative", [0x88; 3], points(&sums));
    Chart::new(
        Axis::whole("component").range(0.5, ratio.len() as f64 + 0.5),
        Axis::linear("share of the variance").range(0.0, 1.05),
        vec![
            Series { line: Line::Dashed, dots: true, ..cumulative },
            Series { dots: true, ..Series::curve("each", [0x1f, 0x6f, 0xeb], points(ratio)) },
        ],
    )
}
