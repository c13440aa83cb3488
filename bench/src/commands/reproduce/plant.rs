//! Chapter 4: plants that wilt.

use catamaran_bench::Result;
use catamaran_bench::plant::{
    Part, accuracy, beam, cut, errors_by_conductance, errors_over_time, grid, hanging, held,
    leaves, naive, race, rods, sections, shares, storms, subjects, total_water, weights,
};
use clap::ValueEnum;

use super::{Arguments, Report};

/// The columns of the record.
pub const HEADER: &str = "figure,case,quantity,value";

/// A share that can be run separately; each has its own files in the record.
#[derive(Clone, Copy, PartialEq, ValueEnum)]
pub enum Share {
    /// Figures 4.3 to 4.11, accuracy, and storms.
    Figures,
    /// Figure 4.6 by the drying leaves of CATAMARAN_DATA, and by weights of the model.
    Leaves,
    /// The race of the water solver, which needs a quiet machine.
    Water,
    /// The race of rods in motion, which needs a quiet machine.
    Rods,
}

impl Share {
    /// All of them, in the order in which they run.
    pub const ALL: [Self; 4] = [Self::Figures, Self::Leaves, Self::Water, Self::Rods];

    /// Returns the name of the share in the names of files in the record.
    pub fn name(self) -> &'static str {
        match self {
            Self::Figures => "plant",
            Self::Leaves => "plant-leaves",
            Self::Water => "plant-water",
            Self::Rods => "plant-rods",
        }
    }

    fn title(self) -> &'static str {
        match self {
            Self::Figures => "# Chapter 4, measured again",
            Self::Leaves => "# Drying leaves, fitted",
            Self::Water => "# The water of plants beside other solvers",
            Self::Rods => "# Rods in motion beside other solvers",
        }
    }
}

pub fn run(report: &mut Report, share: Share, arguments: &Arguments) -> Result<()> {
    report.say(&format!("{}\n", share.title()));
    let mut keep = |part: Part| {
        report.say(&part.markdown());
        report.lines.extend(part.lines());
        report.plots.extend(part.plots);
    };
    let (repeat, libraries) = (arguments.repeat, &arguments.libraries);
    match share {
        Share::Figures => {
            let subjects = subjects()?;
            keep(sections(&subjects)?);
            errors_over_time(&subjects)?.into_iter().for_each(&mut keep);
            keep(errors_by_conductance(&subjects)?);
            keep(accuracy(&subjects)?);
            keep(naive(&subjects)?);
            keep(total_water(&subjects)?);
            keep(weights(&subjects)?);
            keep(grid(&subjects)?);
            keep(hanging(&subjects)?);
            keep(held(&subjects)?);
            keep(cut(&subjects)?);
            keep(shares(&subjects)?);
            keep(storms()?);
        }
        Share::Leaves => match leaves()? {
            Some(parts) => {
                parts.into_iter().for_each(&mut keep);
                keep(weights(&subjects()?)?);
            }
            None => eprintln!("figure 4.6: no real leaves in CATAMARAN_DATA/plants/leaves"),
        },
        Share::Water => keep(race(arguments.largest, repeat, libraries)?),
        Share::Rods => {
            keep(rods(&subjects()?, repeat, libraries)?);
            keep(beam(repeat, libraries)?);
        }
    }
    Ok(())
}
