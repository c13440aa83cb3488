//! `catamaran tune`.

use anyhow::Result;
use catamaran::kernel::packed::{FloatIsa, Rates};
use clap::builder::PossibleValuesParser;
use clap::builder::TypedValueParser as _;

use crate::progress::Bar;
use crate::report::{head, row, status};

/// Measure the speed of this machine, for the planner of the other commands.
///
/// Takes about half a second for each instruction set, on one core. Nothing else should run
/// meanwhile.
#[derive(clap::Args)]
pub struct Args {
    /// Instruction set to measure [default: all that the machine has].
    #[arg(long, value_name = "NAME", value_parser = isa_parser())]
    isa: Option<FloatIsa>,
    /// Print the rates without saving them.
    #[arg(long)]
    dry_run: bool,
}

fn isa_parser() -> impl clap::builder::TypedValueParser<Value = FloatIsa> {
    PossibleValuesParser::new(FloatIsa::ALL.map(FloatIsa::name)).map(|name| {
        let found = FloatIsa::ALL.into_iter().find(|isa| isa.name() == name);
        found.unwrap_or(FloatIsa::Portable)
    })
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    let isas = match args.isa {
        // The measurement refuses what the machine lacks, and says why.
        Some(isa) => vec![isa],
        None => FloatIsa::ALL.into_iter().filter(|i| i.refusal().is_none()).collect(),
    };
    head(format_args!("Rates of one core: measured (built in)"))?;
    head(format_args!(
        "{:10}{:>18}{:>18}{:>18}{:>18}",
        "", "GFLOP/s f64", "GB/s read", "GB/s pack", "GB/s update"
    ))?;
    let mut measured = Vec::new();
    let bar = Bar::new("measuring");
    for (i, &isa) in isas.iter().enumerate() {
        bar.step(i as f64 / isas.len() as f64)?;
        let rates = Rates::measure(isa)?;
        let [found, default] = [values(&rates), values(&Rates::of(isa))];
        let cell = |i: usize| format!("{:.1} ({:.1})", found[i], default[i]);
        row!(
            "rates",
            isa = isa.name(),
            gflops = found[0],
            read_gb_per_second = found[1],
            pack_gb_per_second = found[2],
            update_gb_per_second = found[3],
            built_in = default;
            "{:10}{:>18}{:>18}{:>18}{:>18}",
            isa.name(),
            cell(0),
            cell(1),
            cell(2),
            cell(3)
        )?;
        measured.push((isa, rates));
    }
    bar.step(1.0)?;
    drop(bar);
    if !args.dry_run {
        for (isa, rates) in &measured {
            let path = rates.save(*isa)?.display().to_string();
            status!("written", path = path; "{path}")?;
        }
    }
    Ok(())
}

/// Returns rates in the order of the columns, in billions per second.
fn values(rates: &Rates) -> [f64; 4] {
    [rates.flops, rates.read_bytes, rates.pack_bytes, rates.update_bytes].map(|rate| rate / 1e9)
}
