//! Chapter 4: plants that wilt.

use catamaran_bench::Result;
use catamaran_bench::plant::{
    Part, cut, errors_over_time, grid, race, sections, shares, subjects, total_water,
};

use super::{Arguments, Report};

/// The columns of the record.
pub const HEADER: &str = "figure,case,quantity,value";

/// Figures 4.3, 4.4, 4.6, 4.7, 4.10 and 4.11, and the race of the water solver.
pub fn run(report: &mut Report, arguments: &Arguments) -> Result<()> {
    report.say("# Chapter 4, measured again\n");
    let mut keep = |part: Part| {
        report.say(&part.markdown());
        report.lines.extend(part.lines());
        report.plots.extend(part.plots);
    };
    let subjects = subjects()?;
    keep(sections(&subjects)?);
    for part in errors_over_time(&subjects)? {
        keep(part);
    }
    keep(total_water(&subjects)?);
    keep(grid(&subjects)?);
    keep(cut(&subjects)?);
    keep(shares(&subjects)?);
    keep(race(arguments.largest, arguments.repeat, &arguments.libraries)?);
    Ok(())
}
