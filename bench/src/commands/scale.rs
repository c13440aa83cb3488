//! `scale`: what the plans predict for many ranks.

use std::io::Write;
use std::path::PathBuf;

use catamaran::io::{Output, Overwrite};
use catamaran::ranks::plan::{Explanation, Machine};
use catamaran_bench::input::Shape;
use catamaran_bench::scale::{CSV_HEADER, rows, svg};
use catamaran_bench::{Result, record};

#[derive(clap::Args)]
pub struct Arguments {
    /// Shapes of A: N or MxN.
    #[arg(long, value_delimiter = ',', default_value = "100000,100000000x1000")]
    sizes: Vec<Shape>,
    /// Seconds of a message, however short.
    #[arg(long, default_value_t = Machine::default().latency)]
    latency: f64,
    /// Seconds more for each entry in it.
    #[arg(long, default_value_t = Machine::default().seconds_per_word)]
    seconds_per_word: f64,
    /// Floating-point operations of a rank per second.
    #[arg(long, default_value_t = Machine::default().flops)]
    flops: f64,
    /// Explains one number of ranks, and draws nothing.
    #[arg(long, value_name = "RANKS")]
    explain: Option<usize>,
    /// Where the picture goes.
    #[arg(long, default_value = "docs/algorithms/ata-scale.svg")]
    output: PathBuf,
    /// Overwrites it.
    #[arg(long)]
    force: bool,
}

pub fn run(arguments: &Arguments) -> Result<()> {
    let Arguments { latency, seconds_per_word, flops, .. } = *arguments;
    let machine = Machine { latency, seconds_per_word, flops };
    if let Some(ranks) = arguments.explain {
        for shape in &arguments.sizes {
            println!("{}\n", Explanation::new(ranks, shape.m, shape.n, &machine));
        }
        return Ok(());
    }
    let overwrite = if arguments.force { Overwrite::Replace } else { Overwrite::Never };
    let mut output = Output::create(&arguments.output, overwrite)?;
    let rows = rows(&arguments.sizes, &machine);
    print!("{}", record::csv(CSV_HEADER, rows.iter().map(|row| row.csv())));
    output.write_all(svg(&rows, &machine).as_bytes()).map_err(|e| output.error(e))?;
    Ok(output.commit()?)
}
