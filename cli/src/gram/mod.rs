//! The passes over rows that `lstsq`, `pca` and `svd` share: one pass to the Gram matrix in
//! extended precision, and a second one to what is computed from each row.

mod complete;
mod second;
mod table;

use std::num::NonZeroUsize;
use std::path::Path;
use std::time::Instant;

use anyhow::{Context, Result, bail};
use catamaran::base::block_rows;
use catamaran::rows::{Accumulator, ExtendedGram, RowBounds};
use catamaran::solve::check_weights;
use catamaran::{AtaOptions, Par};

pub use self::complete::survey;
pub use self::second::second_pass;
pub use self::table::Table;
use crate::common::{Force, Threads};
use crate::progress::Bar;
use crate::ranks::Ranks;
use crate::report::{seconds, status};
use crate::rows::{
    Begun, CheckpointArgs, RowList, Shown, Source, add_rows, check_same_weights,
    check_size_of_weights, fingerprint, labels_with_rows, open, option_labels, read_weights,
};
use crate::tables::{MatrixArgs, MatrixFile, TableArgs};

/// Most lines of a table on the screen.
pub const SHOWN: usize = 50;

/// The rows, and how they are added.
#[derive(clap::Args)]
pub struct GramArgs {
    /// The matrix A, m x n: .npy, .mtx and text tables, each also packed (.gz, .xz, .bz2,
    /// .zst, .zip), from a file or stdin (-), and HDF5 where it is built in (FILE.h5:/dataset).
    #[arg(value_name = "A")]
    input: MatrixFile,
    #[command(flatten)]
    matrix: MatrixArgs,
    #[command(flatten)]
    threads: Threads,
    /// Number of rows in a block, two of which are in memory. Does not change the result [default:
    /// rows of about 64 MiB].
    #[arg(long, value_name = "ROWS")]
    block_rows: Option<NonZeroUsize>,
    #[command(flatten)]
    checkpoint: CheckpointArgs,
    #[command(flatten)]
    pub force: Force,
}

impl GramArgs {
    /// Returns the file of A.
    pub fn input(&self) -> &Path {
        &self.input
    }

    /// Returns how other tables than A are read.
    pub fn other_tables(&self) -> &TableArgs {
        &self.matrix.table
    }

    /// Returns whether only some columns of A are used.
    pub fn selects_columns(&self) -> bool {
        self.matrix.columns.is_some()
    }

    /// Returns the threads of the library that do the work.
    pub fn par(&self) -> Par {
        self.threads.par()
    }

    /// Refuses wrong arguments before any work.
    ///
    /// # Errors
    /// As [`CheckpointArgs::check`].
    pub fn check(&self, ranks: &Ranks) -> Result<()> {
        self.checkpoint.check(ranks, self.force)
    }

    /// Opens A.
    pub fn open(&self) -> Result<Source> {
        self.open_with_factors(Vec::new())
    }

    /// Opens A, in which columns of words with these names are factors. Rows with a missing value
    /// are still there with `--missing drop`.
    pub fn open_with_factors(&self, factors: Vec<String>) -> Result<Source> {
        let mut options = self.matrix.read_all_rows();
        options.table = options.table.factors(factors);
        open("A", &self.input, &options)
    }
}

/// One pass over the rows of a table.
pub struct Pass<'a> {
    args: &'a GramArgs,
    ranks: &'a Ranks,
    table: &'a Table,
    weights: Option<Vec<f64>>,
    centered: bool,
}

impl<'a> Pass<'a> {
    /// Returns a pass over rows with the weights in a file, if there is one; about their mean when
    /// `centered`.
    pub fn new(
        args: &'a GramArgs,
        ranks: &'a Ranks,
        table: &'a Table,
        weights: Option<&Path>,
        centered: bool,
    ) -> Result<Self> {
        let named = || args.input.display();
        let enough = || -> Result<()> {
            table.check_options(weights, &args.matrix.read())?;
            if table.ncols() == 0 {
                bail!("{}: no columns", named());
            }
            if centered && table.nrows() == 0 {
                bail!("{}: no rows, so that there is no mean", named());
            }
            Ok(())
        };
        table.check_same(ranks)?;
        ranks.meet(enough())?;
        let read = |path: &Path| -> Result<Vec<f64>> {
            let weights = read_weights(path, table.a(), args.other_tables())?;
            check_weights(Some(&weights)).with_context(|| path.display().to_string())?;
            check_size_of_weights::<f64>(path, &weights)?;
            let weights = table.kept(weights)?;
            if !weights.is_empty() && weights.iter().all(|&weight| weight == 0.0) {
                bail!("{}: all weights are zero", path.display());
            }
            Ok(weights)
        };
        let weights = ranks.meet(weights.map(read).transpose())?;
        check_same_weights(ranks, weights.as_deref())?;
        ranks.report(args.par().threads())?;
        Ok(Self { args, ranks, table, weights, centered })
    }

    /// Computes the Gram matrix of all rows, on the first rank.
    ///
    /// # Errors
    /// Besides those of reading and adding up, a column whose squared length is out of range.
    pub fn gram(&self) -> Result<Option<ExtendedGram>> {
        let (args, ranks) = (self.args, self.ranks);
        let (m, n) = (self.table.nrows(), self.table.ncols());
        let labels = self.labels();
        let Begun { sum, rows, .. } =
            args.checkpoint.resume::<f64>(ranks, (m, n), self.table.chunk_rows(), &labels, true)?;
        let weights = self.weights.as_ref().map(|weights| rows.pick(weights));
        let weights = weights.as_deref();
        // Processes without sums need the grid of those of the others.
        let bounds = match ranks.total(usize::from(sum.is_none())) {
            0 => None,
            _ => Some(self.bounds(&rows, weights)?),
        };
        let sum = match (sum, bounds) {
            (None, Some(bounds)) => Accumulator::extended(&bounds, self.centered)
                .with_context(|| format!("{}: A^T A of {n} columns", args.input.display()))
                .map(Some),
            (sum, _) => Ok(sum),
        };
        let sum = ranks.meet(sum)?;
        let mut sum = sum.context("there are sums, or bounds for them")?;
        sum.set_labels(labels_with_rows(labels, &rows));
        let start = Instant::now();
        let bar = Bar::new("computing");
        let options = AtaOptions::new().par(args.par());
        let (checkpoint, height) = (args.checkpoint.begin(ranks), self.height());
        self.table.read(&rows, false, |rows| {
            let shown = Shown { bar: &bar, part: 0.0..1.0 };
            add_rows(ranks, checkpoint, rows, weights, height, &mut sum, &options, shown)
        })?;
        drop(bar);
        let Some(sum) = ranks.merge(sum)? else { return Ok(None) };
        let gram = sum
            .finish_extended(self.args.par())
            .with_context(|| self.args.input.display().to_string())?;
        let time = start.elapsed();
        status!("time", seconds = time.as_secs_f64(); "{} for A^T A", seconds(time))?;
        if let Some(&j) = gram.out_of_range().first() {
            let (path, name) = self.table.column(j);
            bail!(
                "{}: the squared length of column {name} is out of the range of f64: multiply the \
                 column by a power of ten",
                path.display()
            );
        }
        Ok(Some(gram))
    }

    /// Removes the checkpoint, when all ranks have done their work and results are written.
    pub fn end(&self) -> Result<()> {
        self.args.checkpoint.remove(self.ranks)
    }

    /// Returns the bounds of the rows of all ranks: those of a survey, or by a pass over those of
    /// this rank that refuses NaN and infinities.
    fn bounds(&self, rows: &RowList, weights: Option<&[f64]>) -> Result<RowBounds<f64>> {
        if let Some(known) = self.table.bounds() {
            let largest = |w: &[f64]| w.iter().fold(0.0_f64, |most, w| most.max(w.abs()));
            let bounds = match weights {
                Some(weights) => known.clone().with_weights(largest(weights)),
                None => Ok(known.clone()),
            };
            return self.ranks.common_bounds(self.ranks.meet(bounds.map_err(Into::into))?);
        }
        let bar = Bar::new("bounds");
        let update = |fraction| bar.update(fraction);
        let options = AtaOptions::new().par(self.args.par()).progress(&update);
        let height = self.height();
        let bounds =
            self.table.read(rows, true, |rows| RowBounds::of(rows, weights, height, &options));
        self.ranks.common_bounds(self.ranks.meet(bounds)?)
    }

    fn height(&self) -> usize {
        let height = self.args.block_rows.map(NonZeroUsize::get);
        height.unwrap_or_else(|| block_rows::<f64>(self.table.width(), self.weights.is_some()))
    }

    /// Returns what a checkpoint must have been made with. All processes call this function: files
    /// have the names and the times of the first one's copies.
    fn labels(&self) -> Vec<(String, String)> {
        let weights = self.weights.as_ref();
        let weights = weights.map_or("none".into(), |w| format!("{:016x}", fingerprint(w)));
        let [a, b] = self.table.identity().map(|text| self.ranks.text_of_first(text));
        // Those of options first: they say more than what else differs.
        let mut all = option_labels(&self.args.matrix.read());
        let labels = [
            ("sums", "extended".into()),
            ("A", a),
            ("B", b),
            ("weights", weights),
            ("centring", if self.centered { "mean" } else { "none" }.into()),
        ];
        all.extend(labels.map(|(name, value): (&str, String)| (name.to_owned(), value)));
        all
    }
}
