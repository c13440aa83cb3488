//! `catamaran tune`.

use std::io::{self, Write};

use anyhow::Result;
use catamaran::kernel::packed::{Instance, Rates};
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
    instance: Option<Instance>,
    /// Keep nothing.
    #[arg(long)]
    dry_run: bool,
}

fn instance_parser() -> impl clap::builder::TypedValueParser<Value = Instance> {
    PossibleValuesParser::new(Instance::ALL.map(Instance::name)).map(|name| {
        let found = Instance::ALL.into_iter().find(|instance| instance.name() == name);
        found.unwrap_or(Instance::Portable)
    })
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    let instances = match args.instance {
        // Refused by the measurement, if at all, which says why.
        Some(instance) => vec![instance],
        None => Instance::ALL.into_iter().filter(|i| i.refusal().is_none()).collect(),
    };
    let mut measured = Vec::new();
    for instance in instances {
        progress::check()?;
        eprintln!("measuring {}", instance.name());
        measured.push((instance, Rates::measure(instance)?));
    }
    progress::check()?;
    let mut out = io::stdout().lock();
    writeln!(out, "One core, measured (built in):")?;
    writeln!(
        out,
        "{:10}{:>18}{:>18}{:>18}{:>18}",
        "", "GFLOP/s f64", "GB/s read", "GB/s pack", "GB/s update"
    )?;
    for (instance, rates) in &measured {
        write!(out, "{:10}", instance.name())?;
        for (rate, default) in values(rates).into_iter().zip(values(&Rates::of(*instance))) {
            write!(out, "{:>18}", format!("{:.1} ({:.1})", rate / 1e9, default / 1e9))?;
        }
        writeln!(out)?;
    }
    if !args.dry_run {
        for (instance, rates) in &measured {
            writeln!(out, "written   {}", rates.save(*instance)?.display())?;
        }
    }
    Ok(())
}

/// In the order of the columns.
fn values(rates: &Rates) -> [f64; 4] {
    [rates.flops, rates.read_bytes, rates.pack_bytes, rates.update_bytes]
}
