//! Chapter 4: plants that wilt.

use catamaran_bench::Result;
use catamaran_bench::plant::{
    Part, accuracy, cut, errors_by_conductance, errors_over_time, grid, hanging, held, leaves,
    naive, race, sections, shares, storms, subjects, total_water, weights,
};

use super::{Arguments, Report};

/// The columns of the record.
pub const HEADER: &str = "figure,case,quantity,value";

/// Reproduces figures 4.3 to 4.11, and runs the race of the water solver.
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
    keep(errors_by_conductance(&subjects)?);
    keep(accuracy(&subjects)?);
    keep(naive(&subjects)?);
    keep(total_water(&subjects)?);
    keep(weights(&subjects)?);
    match leaves()? {
        Some(part) => keep(part),
        None => eprintln!("figure 4.6: no real leaves in CATAMARAN_DATA/plants/leaves"),
    }
    keep(grid(&subjects)?);
    keep(hanging(&subjects)?);
    keep(held(&subjects)?);
    keep(cut(&subjects)?);
    keep(shares(&subjects)?);
    keep(storms()?);
    keep(race(arguments.largest, arguments.repeat, &arguments.libraries)?);
    Ok(())
}
