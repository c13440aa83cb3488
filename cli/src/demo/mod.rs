//! `catamaran demo`: a page with one station per system. A station is a function that computes
//! something, writes its pictures into the folder and fills its numbers into its part of the page,
//! a template in `stations/`; a new one is a new file here, one there and a line in [`STATIONS`].

mod ata;
mod curves;
mod decimate;
mod exact;
mod gram;
mod newton;
mod page;
mod plant;
mod slime;
mod spectral;
mod task_tree;
mod unions;

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, Result, bail};
use catamaran::io::{Output, Overwrite};
use catamaran_charts::Rgb;
use page::Station;

use crate::folder::Folder;
use crate::progress::Bar;
use crate::report::status;

/// Write a page with pictures and numbers of everything Catamaran does.
#[derive(clap::Args)]
pub struct Args {
    /// Folder for index.html and its pictures.
    #[arg(short, long, value_name = "DIR", default_value = "catamaran-demo")]
    output: PathBuf,
    /// Smaller inputs: about a second a station, and numbers that say less about speed.
    #[arg(long)]
    small: bool,
    /// Write into a folder that holds other things.
    #[arg(long)]
    force: bool,
}

/// The page.
const INDEX: &str = "index.html";

/// Colours of bars: of what a station is about, and of what it is compared with.
const OWN: Rgb = [0xb2, 0x40, 0x2b];
const OTHERS: Rgb = [0x8a, 0xa0, 0xb8];

/// In the order of the page.
const STATIONS: &[fn(&Site<'_>) -> Result<Station>] = &[
    ata::station,
    exact::station,
    gram::station,
    spectral::station,
    slime::station,
    plant::station,
    decimate::station,
    curves::station,
    unions::station,
    newton::station,
];

/// Where stations put their files, and how much they may do.
pub struct Site<'a> {
    folder: &'a Path,
    /// Smaller inputs are wanted.
    pub small: bool,
}

impl Site<'_> {
    /// Returns a file called `name` in the folder of the page.
    pub fn file(&self, name: &str) -> Result<Output> {
        Ok(Output::create(&self.folder.join(name), Overwrite::Replace)?)
    }
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    let folder = args.output.as_path();
    let named = || folder.display().to_string();
    if !args.force && !may_write(folder).with_context(named)? {
        bail!(
            "{}: holds files that are not of a demo (--force writes there all the same)",
            named()
        );
    }
    let _folder = Folder::create(folder, INDEX)?;
    let start = Instant::now();
    let site = Site { folder, small: args.small };
    let mut stations = Vec::new();
    let bar = Bar::new("demo");
    for (i, build) in STATIONS.iter().enumerate() {
        stations.push(build(&site)?);
        bar.step((i + 1) as f64 / STATIONS.len() as f64)?;
    }
    drop(bar);
    let mut index = site.file(INDEX)?;
    let html = page::render(&stations, start.elapsed())?;
    index.write_all(html.as_bytes()).map_err(|e| index.error(e))?;
    index.commit()?;
    let path = folder.join(INDEX).display().to_string();
    status!("written", path = path; "{path}")
}

/// Returns whether the folder is new, empty, or holds a page that this command has written.
fn may_write(folder: &Path) -> io::Result<bool> {
    let mut entries = match fs::read_dir(folder) {
        Ok(entries) => entries,
        Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(true),
        Err(e) => return Err(e),
    };
    if entries.next().is_none() {
        return Ok(true);
    }
    match fs::read(folder.join(INDEX)) {
        Ok(html) => Ok(String::from_utf8_lossy(&html).contains(page::MARKER)),
        Err(e) if e.kind() == io::ErrorKind::NotFound => Ok(false),
        Err(e) => Err(e),
    }
}
