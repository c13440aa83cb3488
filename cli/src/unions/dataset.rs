//! `catamaran unions dataset`.

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::Result;
use catamaran::io::check_arrays_name;
use catamaran_training::dataset::{
    Dataset, DatasetOptions, TEST_A, TEST_B, TRAIN, generate, remove_shapes, write,
};
use clap::ValueEnum;

use crate::common::{Force, Threads, as_option};
use crate::defaults::stated;
use crate::output;
use crate::progress::Bar;
use crate::report::{note, report, seconds, status};

/// Generate shapes and parts of them, and write the spectra of parts and unions.
///
/// The data set has humanoids and creatures of random bones to train on, and other humanoids and
/// three more families to test with; see docs/algorithms/unions.md. Finished shapes stay in the
/// folder FILE.parts until FILE is complete; the same command resumes an interrupted run from that
/// folder. The same options give the same file for any number of threads.
#[derive(clap::Args)]
pub struct Args {
    /// Output file of the data set: .npz, or .h5 where HDF5 is built in.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Seed of all randomness.
    #[arg(long, value_name = "NUMBER", default_value_t = DatasetOptions::default().seed)]
    seed: u64,
    /// Size of the data set; the options below override parts of it.
    #[arg(long, default_value = "full")]
    size: Size,
    #[arg(
        long,
        value_name = "NUMBER",
        help = stated("Approximate number of vertices of a shape", sizes(|size| size.vertices))
    )]
    vertices: Option<usize>,
    #[arg(
        long,
        value_name = "NUMBER",
        help = stated("Number of humanoids to train on", sizes(|size| size.known))
    )]
    known: Option<usize>,
    #[arg(
        long,
        value_name = "NUMBER",
        help = stated(
            "Number of humanoids to test with, of each of two body types",
            sizes(|size| size.unknown)
        )
    )]
    unknown: Option<usize>,
    #[arg(
        long,
        value_name = "NUMBER",
        help = stated(
            "Number of quadrupeds, of headphones and of sheets to test with",
            sizes(|size| size.others)
        )
    )]
    others: Option<usize>,
    #[arg(
        long,
        value_name = "NUMBER",
        help = stated("Number of poses of each of these shapes", sizes(|size| size.poses))
    )]
    poses: Option<usize>,
    #[arg(
        long,
        value_name = "NUMBER",
        help = stated("Number of pairs of parts of each family", sizes(|size| size.cuts.pairs))
    )]
    pairs: Option<usize>,
    #[arg(
        long,
        value_name = "NUMBER",
        help = stated(
            "Number of further humanoids to train on, each in another pose and with separate parts",
            sizes(|size| size.varied)
        )
    )]
    varied: Option<usize>,
    #[arg(
        long,
        value_name = "NUMBER",
        help = stated(
            "Number of creatures of random bones to train on",
            sizes(|size| size.creatures)
        )
    )]
    creatures: Option<usize>,
    #[command(flatten)]
    threads: Threads,
    #[command(flatten)]
    force: Force,
}

/// Returns a number of the full data set, and that of the small one where it is another.
fn sizes(number: impl Fn(DatasetOptions) -> usize) -> String {
    let [full, small] = [DatasetOptions::default(), DatasetOptions::small()].map(number);
    if full == small { full.to_string() } else { format!("{full}; small: {small}") }
}

/// A named size.
#[derive(Debug, Clone, Copy, ValueEnum)]
enum Size {
    /// The size that the pretrained weights were trained on.
    Full,
    /// A small data set of smaller meshes, to try things.
    Small,
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    check_arrays_name(&args.output)?;
    args.force.check(&args.output)?;
    output::probe(&args.output)?;
    let options = options(args);
    let folder = parts(&args.output);
    let par = args.threads.par();
    let start = Instant::now();
    let bar = Bar::new("shapes");
    let update = |fraction| bar.update(fraction);
    let dataset = generate(&options, &folder, par, (&update).into()).map_err(of_option)?;
    drop(bar);
    write(&dataset, args.force.create(&args.output)?)?;
    if !remove_shapes(&folder)? {
        note(format_args!("{}: stays, because it has other files", folder.display()));
    }
    summary(&dataset)?;
    let (path, time) = (args.output.display().to_string(), start.elapsed());
    status!(
        "written",
        path = path,
        seconds = time.as_secs_f64();
        "{path} in {}",
        seconds(time)
    )
}

/// Names the option of an error of the library.
fn of_option(error: catamaran::Error) -> anyhow::Error {
    const OPTIONS: [&str; 8] =
        ["vertices", "known", "unknown", "others", "poses", "pairs", "varied", "creatures"];
    match error {
        catamaran::Error::Argument { what, .. } if OPTIONS.contains(&what) => as_option(error),
        error => error.into(),
    }
}

fn options(args: &Args) -> DatasetOptions {
    let mut options = match args.size {
        Size::Full => DatasetOptions::default(),
        Size::Small => DatasetOptions::small(),
    };
    options.seed = args.seed;
    let changes = [
        (&mut options.vertices, args.vertices),
        (&mut options.known, args.known),
        (&mut options.unknown, args.unknown),
        (&mut options.others, args.others),
        (&mut options.poses, args.poses),
        (&mut options.cuts.pairs, args.pairs),
        (&mut options.varied, args.varied),
        (&mut options.creatures, args.creatures),
    ];
    for (option, given) in changes {
        *option = given.unwrap_or(*option);
    }
    options
}

/// Returns the folder of the finished shapes.
fn parts(output: &Path) -> PathBuf {
    let mut name = output.as_os_str().to_owned();
    name.push(".parts");
    name.into()
}

fn summary(dataset: &Dataset) -> Result<()> {
    let samples = &dataset.samples;
    let of = |wanted: usize| samples.split.iter().filter(|&&split| split == wanted).count();
    let (all, [train, test_a, test_b]) = (samples.split.len(), [TRAIN, TEST_A, TEST_B].map(of));
    report!(
        "samples",
        count = all,
        train = train,
        test_a = test_a,
        test_b = test_b;
        "{all}: {train} to train on, {test_a} of test A, {test_b} of test B"
    )?;
    let (shapes, triples) = (dataset.shapes.area.len(), dataset.triples.mask.len());
    report!("shapes", count = shapes; "{shapes}")?;
    report!("triples", count = triples; "{triples}")
}
