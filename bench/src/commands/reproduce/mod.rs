//! `reproduce`: measures tables and figures of the thesis again, one chapter in each file.

mod ata;
mod curve_limits;
mod curves;
mod decimate;
mod decimated_spectra;
mod plant;
mod spectral;
mod textures;
mod unions;

use std::path::PathBuf;
use std::time::Instant;

use catamaran_bench::curves::{Plot, svg};
use catamaran_bench::{Result, host, record};
use clap::ValueEnum;

#[derive(clap::Args)]
pub struct Arguments {
    /// What is reproduced.
    what: What,
    /// Writes WHAT.md, WHAT.csv and host.txt under bench/record, and WHAT.svg into target/record; a
    /// WHAT.csv of more than 100 kB goes there, too.
    #[arg(long)]
    record: bool,
    /// Where scripts/rivals installed others.
    #[arg(long, default_value = "target/rivals")]
    libraries: PathBuf,
    /// Chapter 1: only one shape and one pair of each kind.
    #[arg(long)]
    quick: bool,
    /// Chapter 4: nodes of the largest plant of the race.
    #[arg(long, default_value_t = 1_000_000, value_name = "NODES")]
    largest: usize,
    /// Chapters 4, 7 and 8: repetitions of races.
    #[arg(long, default_value_t = 5, value_name = "N")]
    repeat: usize,
    /// Only a part: of chapter 1 thesis, tables 1.2 to 1.6 on the shapes of CATAMARAN_THESIS_DATA;
    /// of chapter 4 figures, leaves, water or rods; of chapters 3 and 7 figures, tables, long or
    /// gpu; of chapter 8 figures, or squares or threads: figures 8.3 and 8.5 at the thesis' sizes.
    #[arg(long, value_name = "PART")]
    only: Option<String>,
    /// Chapter 1, thesis: pairs of each table, at most.
    #[arg(long, default_value_t = 20, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pairs: u32,
    /// Chapter 8: the most columns of a matrix [default: 7500]; of squares and threads the number
    /// of columns, one of the thesis' [default: all of them].
    #[arg(long, value_name = "N")]
    side: Option<usize>,
    /// Chapter 8: the rivals, of those that scripts/rivals installed.
    #[arg(long, value_delimiter = ',', default_value = "mkl,openblas")]
    rivals: Vec<String>,
    /// Chapter 3: rounds of 16 frames that are timed.
    #[arg(long, default_value_t = 2, value_name = "N")]
    #[cfg_attr(not(feature = "opencl"), allow(dead_code))]
    rounds: usize,
    /// Chapter 3: texels of a side of the largest texture that is timed.
    #[arg(long, default_value_t = 8192, value_name = "TEXELS")]
    #[cfg_attr(not(feature = "opencl"), allow(dead_code))]
    largest_texture: usize,
    /// Chapter 6: curves on each mesh; 50 by default, 10 of `curve-limits`, 30 of `curve-orders`.
    #[arg(long, value_name = "N")]
    curves: Option<usize>,
    /// Chapter 6: only these meshes.
    #[arg(long, value_delimiter = ',')]
    meshes: Vec<String>,
    /// Chapter 2: the data set of `catamaran unions dataset` [default: target/unions.npz, made if
    /// it is not there].
    #[arg(long, value_name = "FILE")]
    data: Option<PathBuf>,
    /// Chapter 2: the thesis' own network, of `catamaran unions train --architecture thesis`, for a
    /// column in table 2.1.
    #[arg(long, value_name = "FILE")]
    transformer: Option<PathBuf>,
    /// Chapter 2: other weights than those of the library.
    #[arg(long, value_name = "FILE")]
    weights: Option<PathBuf>,
}

#[derive(Clone, Copy, ValueEnum)]
enum What {
    /// Chapter 1: eigenproducts.
    Spectral,
    /// Chapter 2: spectral unions.
    Unions,
    /// Chapter 2: bodies that no training has, as point clouds, and predicted spectra.
    Bodies,
    /// Chapter 4: plants that wilt.
    Plant,
    /// Chapter 5: decimation.
    Decimate,
    /// Chapter 5: spectra of decimations, and by way of them.
    DecimatedSpectra,
    /// Chapter 6: curves on surfaces.
    Curves,
    /// Chapter 6: what limits the distances of curves.
    CurveLimits,
    /// Chapter 6: what limits the orders of samples.
    CurveOrders,
    /// Chapters 3 and 7: textures.
    Textures,
    /// Chapter 8: A^T A in one process; `scripts/reproduce ata` adds that on ranks.
    Ata,
}

/// The report, which is printed as it grows.
#[derive(Default)]
struct Report {
    text: String,
    lines: Vec<String>,
    plots: Vec<Plot>,
}

impl Report {
    /// Adds a line of the text, which is Markdown.
    fn say(&mut self, text: &str) {
        println!("{text}");
        self.text += text;
        self.text.push('\n');
    }
}

/// A part of a chapter with its own files in the record.
#[derive(Clone, Copy)]
enum Share {
    Whole,
    Thesis,
    Plant(plant::Share),
    Textures(textures::Share),
    Ata(ata::Share),
}

impl Arguments {
    /// Returns the parts to run.
    fn shares(&self) -> Result<Vec<Share>> {
        use textures::Share::{Figures, Tables};
        let Some(only) = &self.only else {
            return Ok(match self.what {
                What::Plant => plant::Share::ALL.map(Share::Plant).into(),
                What::Textures => [Figures, Tables].map(Share::Textures).into(),
                What::Ata => vec![Share::Ata(ata::Share::Figures)],
                _ => vec![Share::Whole],
            });
        };
        let share = match self.what {
            What::Spectral if only == "thesis" => Share::Thesis,
            What::Spectral => return Err(format!("--only: must be thesis, is {only}").into()),
            What::Plant => Share::Plant(named(only)?),
            What::Textures => Share::Textures(named(only)?),
            What::Ata => Share::Ata(named(only)?),
            _ => return Err("--only: applies to spectral, plant, textures and ata only".into()),
        };
        Ok(vec![share])
    }
}

/// Returns the part of a name.
fn named<T: ValueEnum>(only: &str) -> Result<T> {
    T::from_str(only, true).map_err(|_| {
        let known: Vec<String> = T::value_variants()
            .iter()
            .filter_map(|part| Some(part.to_possible_value()?.get_name().into()))
            .collect();
        format!("--only: must be one of {}, is {only}", known.join(", ")).into()
    })
}

pub fn run(arguments: &Arguments) -> Result<()> {
    arguments.shares()?.into_iter().try_for_each(|share| run_share(arguments, share))
}

/// Runs a chapter without shares, or one share.
fn run_share(arguments: &Arguments, share: Share) -> Result<()> {
    let host = host::describe(&[]);
    let start = Instant::now();
    let mut report = Report::default();
    let (name, header) = match arguments.what {
        What::Plant => {
            let share = match share {
                Share::Plant(share) => share,
                _ => plant::Share::Figures,
            };
            plant::run(&mut report, share, arguments)?;
            (share.name(), plant::HEADER)
        }
        What::Spectral if matches!(share, Share::Thesis) => {
            spectral::thesis(&mut report, arguments.pairs as usize)?;
            ("spectral-thesis", spectral::HEADER)
        }
        What::Spectral => {
            spectral::run(&mut report, arguments.quick)?;
            ("spectral", spectral::HEADER)
        }
        What::Unions => {
            unions::run(&mut report, arguments)?;
            ("unions", unions::HEADER)
        }
        What::Bodies => {
            unions::bodies::run(&mut report, arguments)?;
            ("bodies", unions::bodies::HEADER)
        }
        What::Decimate => {
            decimate::run(&mut report, arguments)?;
            ("decimate", decimate::HEADER)
        }
        What::DecimatedSpectra => {
            decimated_spectra::run(&mut report, arguments)?;
            ("decimated-spectra", decimated_spectra::HEADER)
        }
        What::Curves => {
            curves::run(&mut report, arguments)?;
            ("curves", curves::HEADER)
        }
        What::CurveLimits => {
            curve_limits::limits(&mut report, arguments)?;
            ("curve-limits", curve_limits::LIMITS)
        }
        What::CurveOrders => {
            curve_limits::orders(&mut report, arguments)?;
            ("curve-orders", curve_limits::ORDERS)
        }
        What::Textures => {
            let share = match share {
                Share::Textures(share) => share,
                _ => textures::Share::Figures,
            };
            textures::run(&mut report, share, arguments)?;
            (share.name(), textures::HEADER)
        }
        What::Ata => {
            let share = match share {
                Share::Ata(share) => share,
                _ => ata::Share::Figures,
            };
            ata::run(&mut report, share, arguments)?;
            (share.name(), ata::HEADER)
        }
    };
    println!("\n{:.0} s", start.elapsed().as_secs_f64());
    if arguments.record {
        let mut files = vec![
            (format!("{name}.md"), report.text),
            (format!("{name}.csv"), record::csv(header, &report.lines)),
            ("host.txt".into(), host),
        ];
        if !report.plots.is_empty() {
            files.push((format!("{name}.svg"), svg(&report.plots)));
        }
        let files: Vec<_> = files.iter().map(|(name, text)| (&**name, text.clone())).collect();
        println!("recorded in {}", record::write(&files)?.display());
    }
    Ok(())
}
