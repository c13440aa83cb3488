//! `catamaran ata`.

mod complex;
mod faint;
mod memory;
mod shown;
mod times;
mod unbounded;

use std::num::NonZeroUsize;
use std::ops::Range;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};
use catamaran::base::{Pin, Workspace};
use catamaran::blas::{Backend, BlasReal};
use catamaran::faer::{MatMut, MatRef};
use catamaran::io::{self as files, CsMat, Output, StripOutput};
use catamaran::product::{Plan, ata_sparse, sparse_is_faster, sparse_multiplications};
use catamaran::rows::{Accumulator, Center, RowBounds, RowOptions, StreamPlan, Strip, verify_rows};
use catamaran::{Accuracy, AtaOptions, Par, SchemeChoice, Uplo};

use crate::common::{Force, Threads};
use crate::parse;
use crate::progress::{self, Bar};
use crate::ranks::{Ranks, Scalar};
use crate::report::{report, seconds, status};
use crate::rows::{
    Begun, COLUMNS, CheckpointArgs, NUMBERS, Part, RowList, Shown, Source, WEIGHTS,
    WITHOUT_WEIGHTS, Watched, add_rows, check_options, check_same_weights, check_size_of_weights,
    fingerprint, labels_with_rows, open, option_labels, read_weights,
};
use crate::tables::{MatrixArgs, MatrixFile};
use crate::{backend, picture};
use faint::Faint;
pub use unbounded::Unbounded;

/// Compute C = A^T A of a matrix in a file, A^H A, or A^T B of two matrices.
///
/// Complex matrices have A^H A. --times computes A^T B.
///
/// Reads .npy, .mtx and text tables, each also packed (.gz, .xz, .bz2, .zst, .zip), from a file or
/// stdin (-), and HDF5 where it is built in (FILE.h5:/dataset). Sparse .mtx files stay sparse. A
/// .npy or HDF5 file and a large table are read block by block, while the block before is
/// multiplied: they may be larger than memory. Under `mpirun` (where MPI is built in) each rank
/// takes a part of the rows.
#[derive(clap::Args)]
pub struct Args {
    /// The matrix A, m x n.
    #[arg(value_name = "A")]
    input: MatrixFile,
    /// Output file of C, n x n: .npy, .mtx, .csv, .tsv or .txt, and .gz after it. Without it, a C
    /// of at most 10 columns is printed, and of a larger one the range of its entries.
    #[arg(short, long, value_name = "C")]
    output: Option<PathBuf>,
    #[command(flatten)]
    matrix: MatrixArgs,
    /// The matrix B, m x k: compute A^T B, n x k, or A^H B of complex matrices. B is read as A is,
    /// but with all columns. The products of blocks of rows are rounded before they are added,
    /// whatever the scheme. Without -o, a C of at most 10 rows and columns (complex: 6) is printed.
    #[arg(long, value_name = "B")]
    times: Option<MatrixFile>,
    /// Triangle of C to compute; the other triangle is zero in the output.
    #[arg(long, value_name = "TRIANGLE", default_value = "both", value_parser = parse::uplo())]
    uplo: Uplo,
    /// File of the m weights W: compute A^T W A.
    #[arg(long, value_name = "FILE")]
    weights: Option<PathBuf>,
    /// Subtract the mean of each column (the weighted mean if there are weights).
    #[arg(long)]
    center: bool,
    /// Subtract the means, and divide by m - 1: the sample covariance.
    #[arg(long, conflicts_with = "weights")]
    covariance: bool,
    #[command(flatten)]
    threads: Threads,
    /// Pin each thread to one core: thread i to the i-th core of the affinity mask, as taskset or
    /// the binding of mpirun sets it. Processes of mpirun with the same mask divide its cores. Does
    /// not change C.
    #[arg(long)]
    pin: bool,
    /// Scheme of the recursion.
    #[arg(
        long,
        value_name = "SCHEME",
        default_value = parse::scheme_name(AtaOptions::default().scheme),
        value_parser = parse::scheme()
    )]
    scheme: SchemeChoice,
    /// Accuracy: max (the exact path), classical, default, fast, or a bound on the error as a
    /// factor (at least 1) of the error of the classical algorithm.
    #[arg(
        long,
        value_name = "ACCURACY",
        default_value = parse::accuracy_name(AtaOptions::default().accuracy),
        value_parser = parse::accuracy
    )]
    accuracy: Accuracy,
    /// Compute the same bytes on every machine, by the exact path, which is slower than others
    /// without AMX.
    #[arg(long)]
    reproducible: bool,
    /// BLAS back end: native (built in), openblas (if built in), or the path of a CBLAS library.
    #[arg(
        long,
        value_name = "NAME",
        default_value_t = AtaOptions::default().backend.name().to_owned()
    )]
    backend: String,
    /// Compute in single precision.
    #[arg(long = "f32", conflicts_with = "double")]
    single: bool,
    /// Compute in double precision, the default unless A is in single precision.
    #[arg(long = "f64")]
    double: bool,
    /// Check C with random vectors; if the check fails, the command fails and writes nothing.
    #[arg(long)]
    verify: bool,
    /// Print the plan before the computation.
    #[arg(long)]
    explain: bool,
    /// Draw a heat map of C, scaled to a unit diagonal, to this .png or .svg file.
    #[arg(long, value_name = "FILE")]
    picture: Option<PathBuf>,
    /// Most memory to use, in GiB; if C does not fit, A is read several times, each time for some
    /// rows of C. Under mpirun this is the memory of each process, and those of a machine share
    /// what is available [default: four fifths of the available memory].
    #[arg(long, value_name = "GIB", value_parser = parse::gibibytes)]
    memory: Option<usize>,
    /// Number of rows in a block, two of which are in memory. Changes the rounding of C unless sums
    /// are exact [default: rows of about 64 MiB].
    #[arg(long, value_name = "ROWS")]
    block_rows: Option<NonZeroUsize>,
    #[command(flatten)]
    checkpoint: CheckpointArgs,
    /// Write the sums to this file, for `ata-merge` to add to those of other rows.
    #[arg(long, value_name = "FILE")]
    accumulator: Option<PathBuf>,
    /// Fail if A has NaN or infinite entries.
    #[arg(long)]
    require_finite: bool,
    #[command(flatten)]
    force: Force,
}

/// Rounds of the check: a wrong C passes with a probability of 2^-20.
const ROUNDS: u32 = 20;
/// Any number works; a fixed one makes runs repeatable.
const SEED: u64 = 0xCA7A;

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    let ranks = Ranks::join()?;
    let done = run_as(args, &ranks);
    ranks.end(done)
}

fn run_as(args: &Args, ranks: &Ranks) -> Result<()> {
    let (backend, outputs, a) = ranks.meet(begin(args, ranks))?;
    a.check_same(ranks)?;
    let read = |path: &PathBuf| read_weights(path, &a, &args.matrix.table);
    let weights = ranks.meet(args.weights.as_ref().map(read).transpose())?;
    check_same_weights(ranks, weights.as_deref())?;
    let par = threads(args, ranks);
    ranks.report(par.threads())?;
    if let Some(path) = &args.times {
        let b = open("B", path, &args.matrix.table.read())?;
        check_options(&a, Some(&b), None, &args.matrix.read())?;
        return times::run(args, (&a, &b), &options(args, par, backend), outputs.c);
    }
    if let Some(matrix) = a.complex() {
        return complex::run(args, (&a, matrix), &options(args, par, backend), outputs);
    }
    let work = Work { args, ranks, a: &a, weights: weights.as_deref(), backend, par };
    let done = if args.double || !args.single && !a.is_single() {
        work.run::<f64>(outputs)
    } else {
        work.run::<f32>(outputs)
    };
    done.map_err(|error| of_weights(args, error))
}

/// Begins the outputs and opens A. Wrong arguments are refused before any work.
fn begin(args: &Args, ranks: &Ranks) -> Result<(Arc<dyn Backend>, Outputs, Source)> {
    refuse(args, ranks)?;
    let backend = backend::find(&args.backend)?;
    let create = |path: &Option<PathBuf>| {
        let path = path.as_deref().filter(|_| ranks.is_first());
        path.map(|p| args.force.create(p)).transpose()
    };
    let picture = args.picture.as_deref().filter(|_| ranks.is_first());
    let outputs = Outputs {
        c: create(&args.output)?,
        picture: picture.map(|path| picture::create(path, args.force)).transpose()?,
        accumulator: create(&args.accumulator)?,
    };
    let a = open("A", &args.input, &args.matrix.read())?;
    if args.times.is_none() {
        check_options(&a, None, args.weights.as_deref(), &args.matrix.read())?;
    }
    if a.complex().is_some() {
        complex::refuse(args, ranks)?;
    }
    Ok((backend, outputs, a))
}

/// Returns the options of products of matrices.
fn options<'a>(args: &Args, par: Par, backend: Arc<dyn Backend>) -> AtaOptions<'a> {
    AtaOptions::new()
        .uplo(args.uplo)
        .par(par)
        .pin(if args.pin { Pin::Cores } else { Pin::No })
        .scheme(args.scheme)
        .accuracy(args.accuracy)
        .reproducible(args.reproducible)
        .backend(backend)
}

/// Adds the file to an error about the weights.
fn of_weights(args: &Args, error: anyhow::Error) -> anyhow::Error {
    let is_theirs =
        matches!(error.downcast_ref(), Some(catamaran::Error::Argument { what: "weights", .. }));
    match args.weights.as_ref().filter(|_| is_theirs) {
        Some(path) => error.context(path.display().to_string()),
        None => error,
    }
}

/// Returns the threads of this process. Processes that share cores pin their threads to parts of
/// them, and have no more threads by default.
fn threads(args: &Args, ranks: &Ranks) -> Par {
    let par = args.threads.par();
    let cores = if args.pin { ranks.share_cores() } else { None };
    match cores {
        Some(cores) if args.threads.asked().is_none() => Par::Threads(par.threads().min(cores)),
        _ => par,
    }
}

/// Refuses arguments that do not fit each other, and outputs that exist.
fn refuse(args: &Args, ranks: &Ranks) -> Result<()> {
    let exact =
        [("--reproducible", args.reproducible), ("--accuracy max", args.accuracy == Accuracy::Max)];
    if let Some((option, _)) = exact.into_iter().find(|(_, given)| *given)
        && !matches!(args.scheme, SchemeChoice::Auto | SchemeChoice::Exact)
    {
        let name = parse::scheme_name(args.scheme);
        bail!("{option} uses --scheme exact, and can't be combined with --scheme {name}");
    }
    if args.times.is_some() {
        times::refuse(args, ranks)?;
    }
    if args.checkpoint.is_given() && args.output.is_none() && args.accumulator.is_none() {
        bail!("--checkpoint needs -o or --accumulator: the checkpoint is removed at the end");
    }
    if let Some(path) = &args.output {
        files::check_name(path)?;
    }
    for path in [&args.output, &args.picture, &args.accumulator].into_iter().flatten() {
        args.force.check(path)?;
    }
    args.checkpoint.check(ranks, args.force)
}

/// The output files, already begun.
struct Outputs {
    c: Option<Output>,
    picture: Option<Output>,
    accumulator: Option<Output>,
}

/// A product to compute.
struct Work<'w> {
    args: &'w Args,
    ranks: &'w Ranks,
    a: &'w Source,
    weights: Option<&'w [f64]>,
    backend: Arc<dyn Backend>,
    /// The threads of this process.
    par: Par,
}

impl Work<'_> {
    /// Computes C in the precision of T, and the other outputs.
    fn run<T: Scalar>(&self, outputs: Outputs) -> Result<()> {
        let Self { args, a, ranks, .. } = self;
        let (m, n) = a.shape();
        let enough = || -> Result<()> {
            if args.covariance && m < 2 {
                bail!("{}: {m} rows, where --covariance needs at least 2", args.input.display());
            }
            Ok(())
        };
        ranks.meet(enough())?;
        let options = options(args, self.par, self.backend.clone());
        ranks.meet(self.check_weights::<T>(&options))?;
        self.report_cap(options.par)?;
        if let Some(sparse) = self.sparse() {
            return self.sparse_product::<T>(sparse, &options, outputs);
        }
        let plan = self.plan::<T>((m, n), &options)?;
        if args.explain {
            self.explain(&plan, &options)?;
        } else {
            self.outline(&plan, &options)?;
        }
        match plan.reads() {
            1 => self.whole::<T>(&plan, &options, outputs),
            _ => self.strips::<T>(&plan, &options, outputs),
        }
    }

    /// Refuses weights that exact sums would round to fewer digits, or to 0.
    fn check_weights<T: Scalar>(&self, options: &AtaOptions<'_>) -> Result<()> {
        match (&self.args.weights, self.weights) {
            (Some(path), Some(weights)) if options.asks_for_exact() => {
                check_size_of_weights::<T>(path, weights)
            }
            _ => Ok(()),
        }
    }

    /// Returns the bytes that this process may take.
    fn memory(&self) -> usize {
        self.args.memory.unwrap_or_else(|| memory::allowed(self.ranks))
    }

    /// Returns the file, its shape and the memory of a process, for the error of a shortage.
    fn limits(&self, memory: usize) -> String {
        let (name, (m, n)) = (self.args.input.display(), self.a.shape());
        let memory = memory as f64 / f64::from(1 << 30);
        format!("{name}: {m} x {n}, with {memory:.3} GiB of memory (--memory)")
    }

    /// Returns the plan, which is the same for all processes: for the least memory and the most
    /// threads that one of them has.
    fn plan<T: Scalar>(
        &self,
        (m, n): (usize, usize),
        options: &AtaOptions<'_>,
    ) -> Result<StreamPlan> {
        let Self { args, ranks, .. } = self;
        let least = ranks.least(self.memory());
        // A process holds the sums of another one, too, when it merges them.
        let memory = if ranks.size() > 1 { least / 2 } else { least };
        let most = usize::MAX - ranks.least(usize::MAX - options.par.threads());
        let options = options.clone().par(Par::Threads(most));
        let height = args.block_rows.map(NonZeroUsize::get);
        let plan = StreamPlan::new::<T>(m, n, self.weights.is_some(), height, memory, &options);
        let plan =
            plan.with_context(|| format!("{}, in blocks of --block-rows", self.limits(least)));
        let plan = ranks.meet(plan)?;
        let strips = plan.strips().iter();
        let hash = strips.fold(0, |hash: usize, strip| hash.wrapping_mul(31) ^ strip.end);
        ranks.same_numbers(&[
            ("the number of rows of a block", plan.block_rows()),
            ("the number of reads of A", plan.reads()),
            ("the hash of the strips of C", hash),
        ])?;
        Ok(plan)
    }

    /// Reports when fewer threads are used than `--threads` asks for.
    fn report_cap(&self, par: Par) -> Result<()> {
        let (used, most) = (par.threads(), Par::MOST_PER_CORE);
        match self.args.threads.asked() {
            Some(asked) if used < asked => status!(
                "threads",
                used = used,
                asked = asked;
                "{used} instead of {asked}: at most {most} for each core"
            ),
            _ => Ok(()),
        }
    }

    /// Computes all of C by one read of A.
    fn whole<T: Scalar>(
        &self,
        plan: &StreamPlan,
        options: &AtaOptions<'_>,
        mut outputs: Outputs,
    ) -> Result<()> {
        let (args, ranks) = (self.args, self.ranks);
        let (m, n) = self.a.shape();
        let (labels, exact) = (self.labels(options), options.asks_for_exact());
        let together = self.a.chunk_rows();
        let begun = args.checkpoint.resume::<T>(ranks, (m, n), together, &labels, exact)?;
        let Begun { sum, rows, done } = begun;
        // Processes without sums need the grid of those of the others.
        let bounds = match ranks.total(usize::from(sum.is_none())) {
            0 => None,
            _ => self.bounds::<T>(&rows, plan, options)?,
        };
        let sum = match sum {
            Some(sum) => Ok(sum),
            None => {
                let what = || format!("{}: C of {n} x {n} entries", self.limits(self.memory()));
                self.empty(bounds.as_ref(), 0..n).with_context(what)
            }
        };
        let mut sum = ranks.meet(sum)?;
        sum.set_labels(labels_with_rows(labels, &rows));
        let start = Instant::now();
        let bar = Bar::new("computing");
        let sum = self.add(sum, &rows, plan, options, 0, &bar)?;
        drop(bar);
        let sum = ranks.merge(sum)?;
        let Some(sum) = sum else { return args.checkpoint.remove(ranks) };
        if let Some(output) = &mut outputs.accumulator {
            sum.write(output).map_err(|e| output.error(e))?;
        }
        let mean = sum.mean();
        let c = sum.finish(self.alpha(), args.uplo)?;
        self.report_time::<T>(m - done, start.elapsed())?;
        self.check(&mean, c.as_ref())?;
        let (unbounded, faint) = (Unbounded::of(c.as_ref(), args.uplo), Faint::of(c.as_ref()));
        self.note_range::<T>(&unbounded, &faint)?;
        progress::check()?;
        if let Some(output) = outputs.accumulator {
            let path = output.path().display().to_string();
            output.commit()?;
            status!("kept", path = path; "{path}")?;
        }
        self.write(c.as_ref(), outputs.c, outputs.picture)?;
        args.checkpoint.remove(ranks)
    }

    /// Returns the factor of C.
    fn alpha(&self) -> f64 {
        if self.args.covariance { 1.0 / (self.a.shape().0 - 1) as f64 } else { 1.0 }
    }

    fn centered(&self) -> bool {
        self.args.center || self.args.covariance
    }

    /// Returns the matrix if it is sparse, the sparse product is faster, and the options allow the
    /// sums of the classical algorithm.
    fn sparse(&self) -> Option<&CsMat<f64>> {
        let args = self.args;
        let exact = args.reproducible || args.accuracy == Accuracy::Max;
        let streams = args.checkpoint.is_given() || args.accumulator.is_some();
        self.a.sparse().filter(|a| {
            !self.centered()
                && !exact
                && !streams
                && self.ranks.size() == 1
                && args.scheme == SchemeChoice::Auto
                && sparse_is_faster(a.view())
        })
    }

    fn sparse_product<T: BlasReal>(
        &self,
        a: &CsMat<f64>,
        options: &AtaOptions<'_>,
        outputs: Outputs,
    ) -> Result<()> {
        let n = a.cols();
        if self.args.require_finite
            && let Some(what) = self.a.not_finite()?
        {
            bail!("{}: {what}", self.args.input.display());
        }
        let mut memory = Workspace::<T>::new(n.saturating_mul(n))
            .with_context(|| format!("C of {n} x {n} entries"))?;
        if self.args.explain {
            let count = sparse_multiplications(a.view());
            let (threads, pinned) = (options.par.threads(), pinned(options));
            report!(
                "plan",
                scheme = "sparse",
                multiplications = count,
                threads = threads,
                pinned = !pinned.is_empty();
                "sparse: the outer product of each row, {count} multiplications, \
                 {threads} threads{pinned}"
            )?;
        }
        let start = Instant::now();
        let c = MatMut::from_row_major_slice_mut(&mut memory.as_mut_slice()[..n * n], n, n);
        {
            let bar = Bar::new("computing");
            let update = |fraction| bar.update(fraction);
            let options = options.clone().progress(&update);
            ata_sparse(T::ONE, a.view(), self.weights, T::ZERO, c, &options)?;
        }
        self.report_time::<T>(a.rows(), start.elapsed())?;
        let c = MatRef::from_row_major_slice(&memory.as_slice()[..n * n], n, n);
        self.check(&[], c)?;
        self.note_range::<T>(&Unbounded::of(c, self.args.uplo), &Faint::of(c))?;
        progress::check()?;
        self.write(c, outputs.c, outputs.picture)
    }

    /// Computes the bounds of all rows, by a pass over those of this process, if sums must be
    /// exact.
    fn bounds<T: Scalar>(
        &self,
        list: &RowList,
        plan: &StreamPlan,
        options: &AtaOptions<'_>,
    ) -> Result<Option<RowBounds<T>>> {
        if !options.asks_for_exact() {
            return Ok(None);
        }
        let bar = Bar::new("bounds");
        let update = |fraction| bar.update(fraction);
        let options = options.clone().progress(&update);
        let found = || -> Result<_> {
            let (mut rows, weights) = self.rows::<T>(list)?;
            Ok(RowBounds::of(&mut rows, weights.as_deref(), plan.block_rows(), &options)?)
        };
        let bounds = self.ranks.meet(found())?;
        Ok(Some(self.ranks.common_bounds(bounds)?))
    }

    /// Returns sums of no rows, for some rows of C.
    fn empty<T: BlasReal>(
        &self,
        bounds: Option<&RowBounds<T>>,
        strip: Range<usize>,
    ) -> catamaran::Result<Accumulator<T>> {
        match bounds {
            Some(bounds) => Accumulator::exact_strip(bounds, strip, self.centered()),
            None => Accumulator::of_strip(self.a.shape().1, strip, self.centered()),
        }
    }

    /// Returns the rows of a list, and their weights.
    fn rows<'r, T: BlasReal>(&'r self, list: &'r RowList) -> Result<(Part<'r, T>, Option<Vec<T>>)> {
        let weights = self.weights.map(|weights| list.pick(weights));
        let weights = weights.map(|w| w.into_iter().map(T::from_f64).collect());
        Ok((Part { rows: self.a.rows::<T>(self.args.require_finite)?, list }, weights))
    }

    /// Adds the rows of the list that `sum` lacks, with checkpoints. `read` is the number of this
    /// read of A, from 0.
    fn add<T: BlasReal>(
        &self,
        mut sum: Accumulator<T>,
        list: &RowList,
        plan: &StreamPlan,
        options: &AtaOptions<'_>,
        read: usize,
        bar: &Bar,
    ) -> Result<Accumulator<T>> {
        let share = |read: usize| read as f64 / plan.reads() as f64;
        let shown = Shown { bar, part: share(read)..share(read + 1) };
        let (mut rows, weights) = self.rows::<T>(list)?;
        let checkpoint = self.args.checkpoint.begin(self.ranks);
        let (weights, height) = (weights.as_deref(), plan.block_rows());
        let ranks = self.ranks;
        add_rows(ranks, checkpoint, &mut rows, weights, height, &mut sum, options, shown)?;
        Ok(sum)
    }

    /// Computes C strip by strip: each strip needs a read of A, and is written to the disk by the
    /// first process.
    fn strips<T: Scalar>(
        &self,
        plan: &StreamPlan,
        options: &AtaOptions<'_>,
        outputs: Outputs,
    ) -> Result<()> {
        let (args, ranks) = (self.args, self.ranks);
        let (m, n) = self.a.shape();
        let begun = || -> Result<Option<StripOutput>> {
            let given = [
                ("--verify", args.verify),
                ("--picture", args.picture.is_some()),
                ("--checkpoint", args.checkpoint.is_given()),
                ("--accumulator", args.accumulator.is_some()),
            ];
            if let Some((name, _)) = given.into_iter().find(|(_, given)| *given) {
                bail!(
                    "{name} needs all of C in memory, and C of {n} x {n} entries does not fit: see \
                     --memory"
                );
            }
            if args.output.is_none() {
                bail!(
                    "C of {n} x {n} entries does not fit in memory (--memory): name a file with -o"
                );
            }
            Ok(outputs.c.map(|output| StripOutput::new::<T>(output, n, args.uplo)).transpose()?)
        };
        let mut output = ranks.meet(begun())?;
        let start = Instant::now();
        let list = RowList::from(ranks.share(m, self.a.chunk_rows()));
        let bounds = self.bounds::<T>(&list, plan, options)?;
        let bar = Bar::new("computing");
        let (mut unbounded, mut faint) = (Unbounded::default(), Faint::default());
        for (read, strip) in plan.strips().iter().enumerate() {
            let sum = ranks.meet(self.empty(bounds.as_ref(), strip.clone()).map_err(Into::into))?;
            let sum = self.add(sum, &list, plan, options, read, &bar)?;
            // Only the first process has the output, and the merged sums.
            let (Some(sum), Some(output)) = (ranks.merge(sum)?, &mut output) else { continue };
            let c: Strip<T> = sum.finish(self.alpha(), Uplo::Lower)?;
            unbounded.add(c.as_ref(), strip.start, args.uplo);
            faint.add(c.as_ref(), strip.start);
            output.write(&c)?;
        }
        drop(bar);
        let Some(output) = output else { return args.checkpoint.remove(ranks) };
        self.report_time::<T>(m, start.elapsed())?;
        self.note_range::<T>(&unbounded, &faint)?;
        progress::check()?;
        output.commit()?;
        let path = args.output.as_deref().map(|path| path.display().to_string());
        let path = path.unwrap_or_default();
        status!("written", path = path; "{path}")?;
        args.checkpoint.remove(ranks)
    }

    /// Returns what a checkpoint must have been made with. All processes call this function: A has
    /// the name and the time of the first one's copy.
    fn labels(&self, options: &AtaOptions<'_>) -> Vec<(String, String)> {
        let args = self.args;
        let fingerprint = |weights| format!("{:016x}", fingerprint(weights));
        let weights = self.weights.map_or(WITHOUT_WEIGHTS.into(), fingerprint);
        let columns = match self.a.is_named() {
            true => (COLUMNS, self.a.column_names().join("\n")),
            false => (NUMBERS, RowList::from_iter(self.a.numbers()).to_string()),
        };
        let labels = [
            ("A", self.ranks.text_of_first(self.a.identity())),
            (WEIGHTS, weights),
            ("centring", if self.centered() { "mean" } else { "none" }.into()),
            ("scheme", parse::scheme_name(args.scheme).into()),
            ("accuracy", format!("{:?}", args.accuracy).to_lowercase()),
            ("reproducible", args.reproducible.to_string()),
            ("back end", options.backend.name().into()),
            (columns.0, self.ranks.text_of_first(columns.1)),
        ];
        // Those of options first: they say more than what else differs.
        let mut all = option_labels(&args.matrix.read());
        all.extend(labels.map(|(name, value)| (name.to_owned(), value)));
        all
    }

    /// Reports the product of `m` rows, and the time.
    fn report_time<T: BlasReal>(&self, m: usize, elapsed: Duration) -> Result<()> {
        let n = self.a.shape().1;
        let triangle = match self.args.uplo {
            Uplo::Lower => "lower triangle",
            Uplo::Upper => "upper triangle",
            Uplo::Both => "both triangles",
        };
        status!(
            "product": "C",
            rows = n,
            columns = n,
            scalar = T::NAME,
            triangle = triangle;
            "{n} x {n}, {}, {triangle}",
            T::NAME
        )?;
        let rate = m as f64 * (n as f64).powi(2) / elapsed.as_secs_f64().max(1e-9) / 1e9;
        status!(
            "time",
            seconds = elapsed.as_secs_f64(),
            gflops = rate;
            "{}, {rate:.2} effective GFLOP/s (m n^2 / time)",
            seconds(elapsed)
        )
    }

    /// Checks C, with --verify, by one more read of A.
    fn check<T: BlasReal>(&self, mean: &[f64], c: MatRef<'_, T>) -> Result<()> {
        if !self.args.verify {
            return Ok(());
        }
        let bar = Bar::new("checking");
        let center = match mean {
            // Without rows there is no mean.
            mean if self.centered() && self.a.shape().0 > 0 => Center::Given(mean),
            _ => Center::No,
        };
        let row_options = RowOptions::new().weights(self.weights).center(center);
        let mut rows = Watched { rows: self.a.rows::<f64>(false)?, bar: &bar };
        let uplo = self.args.uplo;
        let found = match verify_rows(self.alpha(), &mut rows, &row_options, c, uplo, ROUNDS, SEED)
        {
            // A mean that is not finite can't be subtracted; nor can a product of such entries be
            // checked.
            Err(catamaran::Error::NonFinite { what: "center" | "A", .. }) => None,
            found => Some(found?),
        };
        drop(rows);
        drop(bar);
        const UNKNOWN: &str = "the check can't tell, and nothing is written";
        if found.is_none_or(|found| !found.passed)
            && let Some(what) = self.a.not_finite()?
        {
            bail!("{UNKNOWN}: {}: {what}", self.args.input.display());
        }
        let Some(found) = found else { bail!("{UNKNOWN}: the mean is not finite") };
        let numbers = format!("residual {:.2e}, tolerance {:.2e}", found.residual, found.tolerance);
        if !found.tolerance.is_finite() {
            bail!("{UNKNOWN}: in f64 the squares of a column add up to infinity");
        }
        if !found.passed {
            bail!("the check failed, and nothing is written: {numbers}");
        }
        report!(
            "check",
            passed = true,
            residual = found.residual,
            tolerance = found.tolerance,
            false_accept_probability = found.false_accept_probability;
            "passed: {numbers}, false-accept probability {:.1e}",
            found.false_accept_probability
        )
    }

    /// Notes entries of C that are out of range: those that are not finite, and whether A is the
    /// cause, and columns whose squared lengths are lost. For each, A is read once more.
    fn note_range<T: BlasReal>(&self, unbounded: &Unbounded, faint: &Faint) -> Result<()> {
        let name = self.args.input.display().to_string();
        let cause = || Ok(self.a.not_finite()?.map(|what| format!("{name}: {what}")));
        unbounded.note(&name, T::NAME, cause)?;
        if faint.is_none() {
            return Ok(());
        }
        let mut rows = self.a.rows::<f64>(false)?;
        let lost = faint.lost_in::<T>(&mut *rows, self.weights, self.centered())?;
        lost.note::<T>(self.a, self.centered());
        Ok(())
    }

    fn write<T: BlasReal>(
        &self,
        c: MatRef<'_, T>,
        output: Option<Output>,
        picture: Option<Output>,
    ) -> Result<()> {
        match output {
            Some(output) => write_matrix(output, c)?,
            None => shown::show(c, self.args.uplo)?,
        }
        if let Some(output) = picture {
            let path = output.path().display().to_string();
            picture::write(output, c, |i, j| match self.args.uplo {
                Uplo::Upper => (i.min(j), i.max(j)),
                Uplo::Lower | Uplo::Both => (i.max(j), i.min(j)),
            })?;
            status!("picture", path = path; "{path}")?;
        }
        Ok(())
    }

    /// Prints the plan in a line.
    fn outline(&self, plan: &StreamPlan, options: &AtaOptions<'_>) -> Result<()> {
        let scheme = plan.product().map_or_else(|| "strips of C".into(), Plan::scheme);
        let kernels = plan.product().and_then(Plan::isa).unwrap_or(options.backend.name());
        let (threads, said) = used_threads(plan, options);
        status!(
            "plan",
            scheme = scheme,
            kernels = kernels,
            threads = threads;
            "{scheme}, by {kernels}, {said}; --explain prints all of it"
        )
    }

    fn explain(&self, plan: &StreamPlan, options: &AtaOptions<'_>) -> Result<()> {
        let mut text = plan.product().map_or_else(String::new, |plan| format!("{plan}\n"));
        text += &format!("{plan}\n");
        if self.args.verify {
            text += "check      one more read of A\n";
        }
        let (threads, said) = used_threads(plan, options);
        let is_exact = plan.product().is_some_and(|plan| plan.is_exact());
        // The exact path uses no back end.
        let backend = (!is_exact).then(|| options.backend.name());
        text += &match backend {
            None => format!("threads    {threads}{}", pinned(options)),
            Some(name) => format!("back end   {name}, {said}"),
        };
        report!(
            "plan",
            scheme = plan.product().map(Plan::scheme),
            kernels = plan.product().and_then(Plan::isa),
            expected_ratio = plan.product().map(Plan::expected_ratio),
            block_rows = plan.block_rows(),
            reads = plan.reads(),
            bytes = plan.bytes(),
            backend = backend,
            threads = threads,
            pinned = said.ends_with("pinned");
            "{}",
            text.replace('\n', "\n            ")
        )
    }
}

/// Returns the threads that products take, and what a report says of them.
fn used_threads(plan: &StreamPlan, options: &AtaOptions<'_>) -> (usize, String) {
    let (threads, pinned) = match plan.product().is_some_and(Plan::is_direct) {
        true => (1, ""),
        false => (options.par.threads(), pinned(options)),
    };
    let s = if threads == 1 { "" } else { "s" };
    (threads, format!("{threads} thread{s}{pinned}"))
}

/// Returns what `--explain` prints after the number of threads.
fn pinned(options: &AtaOptions<'_>) -> &'static str {
    if options.pin == Pin::Cores { ", pinned" } else { "" }
}

/// Writes C into a file.
pub fn write_matrix<T: BlasReal>(output: Output, c: MatRef<'_, T>) -> Result<()> {
    let path = output.path().display().to_string();
    files::write(output, c)?;
    status!("written", path = path; "{path}")
}
