//! The passes over rows that `lstsq`, `pca` and `svd` share: one pass to the Gram matrix in
//! extended precision, and a second one to what is computed from each row.

mod complete;
mod second;
mod table;

use std::num::NonZeroUsize;
use std::ops::Range;
use std::path::Path;
use std::time::Instant;

use anyhow::{Context, Result, bail};
use catamaran::base::block_rows;
use catamaran::rows::{Accumulator, ExtendedGram, RowBounds, stream};
use catamaran::solve::check_weights;
use catamaran::{AtaOptions, Par};

pub use self::complete::survey;
pub use self::second::second_pass;
pub use self::table::Table;
use crate::common::{Force, Threads};
use crate::progress::{self, Bar};
use crate::ranks::Ranks;
use crate::report::{seconds, status};
use crate::rows::{CheckpointArgs, Source, fingerprint, open, read_weights};
use crate::tables::{MatrixArgs, MatrixFile, TableArgs};

/// Most lines of a table on the screen.
pub const SHOWN: usize = 50;

/// The rows, and how they are added.
#[derive(clap::Args)]
pub struct GramArgs {
    /// The matrix A, m x n: .npy, .mtx and text tables, each also as .gz or .xz, from a file or
    /// stdin (-), and HDF5 where it is built in (FILE.h5:/dataset).
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

    /// Returns the threads of the library that do the work.
    pub fn par(&self) -> Par {
        self.threads.par()
    }

    /// Refuses wrong arguments before any work.
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
        if table.ncols() == 0 {
            bail!("{}: no columns", args.input.display());
        }
        if centered && table.nrows() == 0 {
            bail!("{}: no rows, so that there is no mean", args.input.display());
        }
        let weights = match weights {
            Some(path) => {
                let weights = read_weights(path, table.a(), args.other_tables())?;
                check_weights(Some(&weights)).with_context(|| path.display().to_string())?;
                let weights = table.kept(weights)?;
                if !weights.is_empty() && weights.iter().all(|&weight| weight == 0.0) {
                    bail!("{}: all weights are zero", path.display());
                }
                Some(weights)
            }
            None => None,
        };
        if ranks.size() > 1 {
            ranks.report()?;
        }
        Ok(Self { args, ranks, table, weights, centered })
    }

    /// Computes the Gram matrix of all rows, on the first rank.
    ///
    /// # Errors
    /// Besides those of reading and adding up, a column whose squared length is out of range.
    pub fn gram(&self) -> Result<Option<ExtendedGram>> {
        let (checkpoint, n) = (&self.args.checkpoint, self.table.ncols());
        let labels = self.labels();
        let mut sum = match checkpoint.resume::<f64>(self.ranks, n, &labels)? {
            Some(sum) => {
                if self.ranks.size() > 1 {
                    // A rank that starts from the first row waits for the bounds of all ranks.
                    self.bounds()?;
                }
                sum
            }
            None => Accumulator::extended(&self.bounds()?, self.centered)
                .with_context(|| format!("{}: A^T A of {n} columns", self.args.input.display()))?,
        };
        sum.set_labels(labels);
        let start = Instant::now();
        let bar = Bar::new("computing");
        let update = |fraction| bar.update(fraction);
        let options = AtaOptions::new().par(self.args.par()).progress(&update);
        let mut checkpoint = checkpoint.begin(self.ranks);
        let mut after_block = |sum: &Accumulator<f64>| {
            if let Some(checkpoint) = &mut checkpoint {
                checkpoint.after_block(sum);
            }
            progress::check()
        };
        let (weights, height) = (self.own_weights(), self.height());
        self.table.read(self.own_rows(), false, |rows| {
            stream(rows, weights, height, &mut sum, &options, &mut after_block)
        })?;
        drop(bar);
        let Some(sum) = self.ranks.merge(sum)? else { return Ok(None) };
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

    /// Computes the bounds of the rows of all ranks by a pass that refuses NaN and infinities.
    fn bounds(&self) -> Result<RowBounds<f64>> {
        let bar = Bar::new("bounds");
        let update = |fraction| bar.update(fraction);
        let options = AtaOptions::new().par(self.args.par()).progress(&update);
        let (weights, height) = (self.own_weights(), self.height());
        let bounds = self
            .table
            .read(self.own_rows(), true, |rows| RowBounds::of(rows, weights, height, &options))?;
        self.ranks.common_bounds(bounds)
    }

    fn own_rows(&self) -> Range<usize> {
        self.ranks.share(self.table.nrows())
    }

    fn own_weights(&self) -> Option<&[f64]> {
        self.weights.as_ref().map(|weights| &weights[self.own_rows()])
    }

    fn height(&self) -> usize {
        let height = self.args.block_rows.map(NonZeroUsize::get);
        height.unwrap_or_else(|| block_rows::<f64>(self.table.ncols(), self.weights.is_some()))
    }

    /// Returns what a checkpoint must have been made with.
    fn labels(&self) -> Vec<(String, String)> {
        let weights = self.weights.as_ref();
        let weights = weights.map_or("none".into(), |w| format!("{:016x}", fingerprint(w)));
        let [a, b] = self.table.identity();
        [
            ("sums", "extended".into()),
            ("A", a),
            ("B", b),
            ("weights", weights),
            ("centring", if self.centered { "mean" } else { "none" }.into()),
            ("rank", self.ranks.label().unwrap_or_else(|| "alone".into())),
        ]
        .map(|(name, value): (&str, String)| (name.to_owned(), value))
        .into()
    }
}
