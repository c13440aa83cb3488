//! `catamaran tune`.

use std::io::{self, Write};

use anyhow::Result;
use catamaran::kernel::packed::{Isa, Rates};
use clap::builder::PossibleValuesParser;
use clap::builder::TypedValueParser as _;

use crate::progress;

/// Measure how fast this machine is, for the planner of the other commands.
///
/// Takes about half a second for each instruction set, on one core. Best while nothing else runs.
#[derive(clap::Args)]
pub struct Args {
    /// Only this instruction set; all that the machine has unless given.
    #[arg(long, value_name = "NAME", value_parser = instance_parser())]
    isa: Option<Isa>,
    /// Keep nothing.
    #[arg(long)]
    dry_run: bool,
}

fn instance_parser() -> impl clap::builder::TypedValueParser<Value = Isa> {
    PossibleValuesParser::new(Isa::ALL.map(Isa::name)).map(|name| {
        let found = Isa::ALL.into_iter().find(|isa| isa.name() == name);
        found.unwrap_or(Isa::Portable)
    })
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    let isas = match args.isa {
        // Refused by the measurement, if at all, which says why.
        Some(isa) => vec![isa],
        None => Isa::ALL.into_iter().filter(|i| i.refusal().is_none()).collect(),
    };
    let mut measured = Vec::new();
    for isa in isas {
        progress::check()?;
        eprintln!("measuring {}", isa.name());
        measured.push((isa, Rates::measure(isa)?));
    }
    progress::check()?;
    let mut out = io::stdout().lock();
    writeln!(out, "One core, measured (built in):")?;
    writeln!(
        out,
        "{:10}{:>18}{:>18}{:>18}{:>18}",
        "", "GFLOP/s f64", "GB/s read", "GB/s pack", "GB/s update"
    )?;
    for (isa, rates) in &measured {
        write!(out, "{:10}", isa.name())?;
        for (rate, default) in values(rates).into_iter().zip(values(&Rates::of(*isa))) {
            write!(out, "{:>18}", format!("{:.1} ({:.1})", rate / 1e9, default / 1e9))?;
        }
        writeln!(out)?;
    }
    if !args.dry_run {
        for (isa, rates) in &measured {
            writeln!(out, "written   {}", rates.save(*isa)?.display())?;
        }
    }
    Ok(())
}

/// In the order of the columns.
fn values(rates: &Rates) -> [f64; 4] {
    [rates.flops, rates.read_bytes, rates.pack_bytes, rates.update_bytes]
}
