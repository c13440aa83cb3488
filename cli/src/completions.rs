//! `catamaran completions`.

use anyhow::Result;
use clap::CommandFactory as _;
use clap_complete::{Shell, generate};

use crate::Cli;
use crate::report::row;

/// Print the completion script of a shell.
#[derive(clap::Args)]
pub struct Args {
    /// Shell to print the script for.
    #[arg(value_name = "SHELL")]
    shell: Shell,
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    let mut script = Vec::new();
    generate(args.shell, &mut Cli::command(), "catamaran", &mut script);
    let script = String::from_utf8(script)?;
    let script = script.trim_end();
    row!("completions", shell = args.shell.to_string(), script = script; "{script}")
}
