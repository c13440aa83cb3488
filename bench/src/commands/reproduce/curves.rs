//! Chapter 6: curves on surfaces.

use catamaran_bench::Result;
use catamaran_bench::surface_curves::{
    Cell, Run, bars, cells, distance_tables, failures, measure, order_table, plots, surfaces,
};

use super::{Arguments, Report};

/// Seed of the generator.
const SEED: u64 = 6;
/// Number of curves on each mesh.
const CURVES: usize = 50;

/// Columns of the record.
pub const HEADER: &str = Cell::HEAD;

/// Reproduces figures 6.5, 6.6 and 6.9 to 6.11, tables 6.1 and 6.2.
pub fn run(report: &mut Report, arguments: &Arguments) -> Result<()> {
    let count = arguments.curves.unwrap_or(CURVES);
    let mut runs: Vec<Run> = Vec::new();
    for surface in surfaces(&arguments.meshes)? {
        let surface = surface?;
        let start = std::time::Instant::now();
        let own = measure(&surface, count, SEED)?;
        println!(
            "{}: {} vertices, {} runs, {:.0} s",
            surface.name,
            surface.mesh.vertices().len(),
            own.len(),
            start.elapsed().as_secs_f64()
        );
        runs.extend(own);
    }
    report.say(&format!(
        "# Chapter 6, measured again\n\n{} runs: up to {count} curves a mesh, 7 numbers of samples, 2 kinds of sampling, 4 \
         methods. Shares are of all runs, failures included; the thesis' numbers, on other meshes, in brackets.\n",
        runs.len()
    ));
    let plots = plots(&runs);
    for text in [bars(&runs), order_table(&runs), failures(&runs), distance_tables(&plots)] {
        report.say(&text);
    }
    report.lines.extend(cells(&runs).iter().map(Cell::line));
    report.plots.extend(plots);
    Ok(())
}
