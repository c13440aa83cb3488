//! Chapters 3 and 7: textures.

use catamaran_bench::Result;
use catamaran_bench::plant::Part;
use catamaran_bench::textures::{
    evaporation, grid, maze, newton_figures, newton_times, rescaling, substeps, table, times,
};

use super::{Arguments, Report};

/// The columns of the record.
pub const HEADER: &str = "figure,case,quantity,value";

/// Pixels along each side of the picture whose time is measured.
const SIZE: u32 = 4096;

/// Figures 3.4, 3.5, 3.8, 3.9 and 3.10, tables 3.1 to 3.4; figures 7.1 and 7.2, and times of Newton's fractals.
pub fn run(report: &mut Report, arguments: &Arguments) -> Result<()> {
    report.say("# Chapters 3 and 7, measured again\n");
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
    newton_figures()?.into_iter().for_each(&mut keep);
    newton_times(SIZE, arguments.repeat)?.into_iter().for_each(&mut keep);
    #[cfg(feature = "opencl")]
    keep(catamaran_bench::textures::slime_times(arguments.repeat)?);
    Ok(())
}
