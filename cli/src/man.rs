//! `catamaran man`.

use std::io::Write as _;
use std::path::PathBuf;

use anyhow::Result;
use clap::Command;
use clap_mangen::Man;

use crate::common::Force;
use crate::folder::Folder;
use crate::program::program;
use crate::report::status;

/// Write man pages, one for each command.
///
/// In a folder that man knows, such as ~/.local/share/man/man1, `man catamaran-ata` finds a page.
#[derive(clap::Args)]
pub struct Args {
    /// Folder for the pages.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    #[command(flatten)]
    force: Force,
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    let mut command = program();
    command.build();
    let mut pages = Vec::new();
    collect(command, &mut pages);
    let path = |page: &Man| args.output.join(page.get_filename());
    pages.iter().try_for_each(|page| args.force.check(&path(page)))?;
    let _folder = Folder::create(&args.output, "catamaran.1")?;
    for page in &pages {
        let mut text = Vec::new();
        page.render(&mut text)?;
        let mut output = args.force.create(&path(page))?;
        output.write_all(&text).map_err(|e| output.error(e))?;
        output.commit()?;
    }
    let (folder, count) = (args.output.display().to_string(), pages.len());
    status!("written", path = folder, files = count; "{folder}: {count} files")
}

/// Collects the pages of a command and of its subcommands.
fn collect(command: Command, pages: &mut Vec<Man>) {
    for below in command.get_subcommands().filter(|below| !below.is_hide_set()) {
        collect(below.clone(), pages);
    }
    pages.push(Man::new(command));
}
