//! Chapter 3: slime moulds. Figures 7.1 and 7.2, Newton fractals, belong here too.

use catamaran_bench::Result;
use catamaran_bench::plant::Part;
use catamaran_bench::textures::{evaporation, grid, maze, rescaling, substeps, table, times};

use super::{Arguments, Report};

/// The columns of the record.
pub const HEADER: &str = "figure,case,quantity,value";

/// Figures 3.4, 3.5, 3.8, 3.9 and 3.10, tables 3.1 to 3.4.
pub fn run(report: &mut Report, arguments: &Arguments) -> Result<()> {
    report.say("# Chapter 3, measured again\n");
    let mut keep = |part: Part| {
        report.say(&part.markdown());
        report.lines.extend(part.lines());
        report.plots.extend(part.plots);
    };
    keep(substeps()?);
    keep(rescaling()?);
    keep(table()?);
    keep(grid()?);
    keep(maze()?);
    keep(times(arguments.frames, arguments.largest_texture)?);
    keep(evaporation()?);
    Ok(())
}
