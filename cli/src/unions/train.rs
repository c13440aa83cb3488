//! `catamaran unions train`.

use std::fmt::{self, Display};
use std::io::Write as _;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::time::{Duration, Instant};

use anyhow::{Result, anyhow, bail};
use catamaran::Par;
use catamaran::io::{Output, Overwrite};
use catamaran_geometry::unions::network::Architecture;
use catamaran_training::dataset;
use catamaran_training::train::{Examples, TrainOptions, Trainer, read_state, write_state};
use catamaran_training::transformer::{Losses, Transformer, TransformerOptions};
use clap::ValueEnum;

use super::curve;
use crate::common::{Force, Threads, as_option};
use crate::defaults::stated;
use crate::output;
use crate::parse;
use crate::picture::write_chart;
use crate::progress;
use crate::report::{note, report, status};
use crate::signals;

/// Least time between two writes of the state: a stop within an epoch loses at most this time
/// besides the epoch.
const PAUSE: Duration = Duration::from_secs(10);

/// Train the network of `unions predict` on a data set of `unions dataset`.
///
/// After an epoch, at most every ten seconds, and at the end the command writes the state to
/// OUT.state.npz, the best weights so far to OUT, and the learning curve to OUT.svg. --resume
/// continues from the state, such as after Ctrl-C. The result is the same for any number of
/// threads.
#[derive(clap::Args)]
pub struct Args {
    /// Data set, a file of `unions dataset`.
    #[arg(value_name = "DATA")]
    data: PathBuf,
    /// Output file of the weights: .safetensors.
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    #[arg(
        long,
        value_name = "NUMBER",
        value_parser = parse::at_least_one,
        help = stated(
            "Number of passes over the data in all, over which the learning rate falls; --resume \
             may raise it",
            format_args!(
                "{}, or {} for --architecture thesis; with --resume that of the state",
                TrainOptions::default().epochs,
                TransformerOptions::default().epochs
            )
        )
    )]
    epochs: Option<usize>,
    /// Stop after the epoch in which this time, in minutes, is over; --resume continues.
    #[arg(long, value_name = "NUMBER", value_parser = parse::at_least_zero)]
    minutes: Option<f64>,
    /// Continue from OUT.state.npz, with the sizes and rates of the state.
    #[arg(long)]
    resume: bool,
    /// Network to train.
    #[arg(long, default_value = "sum")]
    architecture: Kind,
    /// Train on the first N known humanoids only, and on no other shapes (thesis, table 2.2: 1).
    #[arg(long, value_name = "N", value_parser = parse::at_least_one)]
    identities: Option<usize>,
    /// Number of layers before and after the sum over the parts.
    #[arg(
        long,
        value_name = "A,B",
        default_value_t = Layers::of(TrainOptions::default().sizes)
    )]
    layers: Layers,
    /// Length of the code of a spectrum.
    #[arg(long, value_name = "NUMBER", default_value_t = TrainOptions::default().sizes.width)]
    width: usize,
    /// Number of hidden neurons in a layer.
    #[arg(long, value_name = "NUMBER", default_value_t = TrainOptions::default().sizes.hidden)]
    hidden: usize,
    /// Number of pairs in a step, a multiple of 64.
    #[arg(long, value_name = "NUMBER", default_value_t = TrainOptions::default().batch)]
    batch: usize,
    /// Largest learning rate.
    #[arg(long, value_name = "NUMBER", default_value_t = TrainOptions::default().rate)]
    rate: f64,
    /// Weight decay: the share of each parameter that a step removes, times the learning rate.
    #[arg(long, value_name = "NUMBER", default_value_t = TrainOptions::default().decay)]
    decay: f64,
    /// Seed of all randomness.
    #[arg(long, value_name = "NUMBER", default_value_t = TrainOptions::default().seed)]
    seed: u64,
    #[command(flatten)]
    threads: Threads,
    #[command(flatten)]
    force: Force,
}

/// Numbers of layers before and after the sum.
#[derive(Debug, Clone, Copy)]
struct Layers([usize; 2]);

impl Layers {
    fn of(sizes: Architecture) -> Self {
        Self([sizes.first_layers, sizes.second_layers])
    }
}

impl Display for Layers {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{},{}", self.0[0], self.0[1])
    }
}

impl FromStr for Layers {
    type Err = &'static str;

    fn from_str(text: &str) -> std::result::Result<Self, Self::Err> {
        let numbers = text.split_once(',').map(|(first, second)| (first.parse(), second.parse()));
        match numbers {
            Some((Ok(first), Ok(second))) => Ok(Self([first, second])),
            _ => Err("expected two whole numbers, such as 2,2"),
        }
    }
}

/// Kinds of networks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Kind {
    /// The network of `unions predict`, which adds the codes of parts.
    Sum,
    /// The transformers of the thesis, for comparison: OUT is an .npz that `scripts/reproduce
    /// unions --transformer` reads, and only --identities, --epochs, --minutes, --seed, --threads
    /// and --force apply.
    Thesis,
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    if args.architecture == Kind::Thesis {
        return thesis(args);
    }
    let most_modes = TrainOptions::default().sizes.modes;
    options(args, most_modes).check().map_err(of_option)?;
    let [state_path, curve_path] = [".state.npz", ".svg"].map(|end| beside(&args.output, end));
    let files = [&args.output, &state_path, &curve_path];
    files.into_iter().try_for_each(|path| args.force.check_resumable(path, args.resume))?;
    files.into_iter().try_for_each(|path| output::probe(path))?;
    let par = args.threads.par();
    let resumed = args.resume.then(|| read_state(&state_path)).transpose()?;
    let examples = examples(args, par)?;
    let (options, state) = match resumed {
        Some((mut options, state)) => {
            options.epochs = args.epochs.unwrap_or(options.epochs);
            (options, Some(state))
        }
        None => (options(args, examples.regions.modes()), None),
    };
    let mut trainer = Trainer::new(examples, options, state, par)?;
    let parameters = trainer.state().parameters.len();
    status!("network", parameters = parameters; "{parameters} parameters")?;
    let save = |trainer: &Trainer| -> Result<()> {
        let _whole = signals::finish_first();
        let create = |path: &Path| Output::create(path, Overwrite::Replace);
        write_state(create(&state_path)?, &options, trainer.state())?;
        let mut weights = create(&args.output)?;
        let bytes = trainer.model()?.to_bytes()?;
        weights.write_all(&bytes).map_err(|e| weights.error(e))?;
        weights.commit()?;
        write_chart(create(&curve_path)?, &curve::chart(&trainer.state().history))
    };
    let start = Instant::now();
    let mut saved = start;
    let late =
        || args.minutes.is_some_and(|minutes| start.elapsed().as_secs_f64() > 60.0 * minutes);
    while trainer.state().history.len() < options.epochs {
        let cancelled = progress::check();
        if cancelled.is_err() || saved.elapsed() > PAUSE {
            save(&trainer)?;
            saved = Instant::now();
        }
        cancelled?;
        let epoch = trainer.epoch()?;
        let (number, time) = (trainer.state().history.len(), start.elapsed().as_secs_f64());
        let [training, validation] = [epoch.training, epoch.validation].map(|error| 100.0 * error);
        report!(
            "epoch",
            number = number,
            training_error_percent = training,
            validation_error_percent = validation,
            seconds = time;
            "{number}: training error {training:.3} %, validation error {validation:.3} %, \
             {time:.0} s"
        )?;
        if late() {
            break;
        }
    }
    save(&trainer)?;
    report_written(args)
}

fn report_written(args: &Args) -> Result<()> {
    let path = args.output.display().to_string();
    status!("written", path = path; "{path}")
}

fn examples(args: &Args, par: Par) -> Result<Examples> {
    let mut dataset = dataset::read(&args.data)?;
    if let Some(count) = args.identities {
        dataset.retain_identities(count);
    }
    let examples = Examples::new(&dataset, par)?;
    let (training, validation) = (examples.training.len(), examples.validation.len());
    let composites = examples.composites.len();
    status!(
        "data",
        training = training,
        composites = composites,
        validation = validation;
        "{training} training pairs ({composites} with a part that is a union), {validation} \
         validation pairs"
    )?;
    if examples.validates_on_training() {
        note(format_args!(
            "{}: too few samples to hold some out: the training pairs are the validation pairs \
             too, so that the validation error is too small",
            args.data.display()
        ));
    }
    Ok(examples)
}

/// Trains the network of the thesis.
fn thesis(args: &Args) -> Result<()> {
    if args.resume {
        bail!("--resume: training with --architecture thesis can't be resumed");
    }
    let output = output::arrays(&args.output, args.force)?;
    let par = args.threads.par();
    let examples = examples(args, par)?;
    let defaults = TransformerOptions::default();
    let options = TransformerOptions {
        epochs: args.epochs.unwrap_or(defaults.epochs),
        minutes: args.minutes.unwrap_or(defaults.minutes),
        seed: args.seed,
        par,
    };
    let mut reported = Ok(());
    let mut watch = |epoch: usize, Losses { training, validation }| {
        reported = progress::check().map_err(anyhow::Error::from).and_then(|()| {
            report!(
                "epoch",
                number = epoch + 1,
                training_loss = training,
                validation_loss = validation;
                "{}: training loss {training:.4}, validation loss {validation:.4}",
                epoch + 1
            )
        });
        if reported.is_err() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let found = Transformer::train(&examples.training, &examples.validation, &options, &mut watch)?;
    reported?;
    found.write(output)?;
    report_written(args)
}

/// Returns the name of the output with `end` behind it.
fn beside(output: &Path, end: &str) -> PathBuf {
    let mut name = output.as_os_str().to_owned();
    name.push(end);
    name.into()
}

/// Names the option of an error of the library.
fn of_option(error: catamaran::Error) -> anyhow::Error {
    match error {
        catamaran::Error::Argument { what: "first_layers" | "second_layers", why } => {
            anyhow!("--layers: {why}")
        }
        error => as_option(error),
    }
}

fn options(args: &Args, modes: usize) -> TrainOptions {
    let Args { width, hidden, batch, rate, decay, seed, .. } = *args;
    let epochs = args.epochs.unwrap_or(TrainOptions::default().epochs);
    let Layers([first_layers, second_layers]) = args.layers;
    let sizes = Architecture { width, hidden, first_layers, second_layers, modes };
    TrainOptions { sizes, batch, rate, decay, epochs, seed }
}
