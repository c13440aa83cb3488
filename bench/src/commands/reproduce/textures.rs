//! Chapters 3 and 7: textures.

use catamaran_bench::Result;
use catamaran_bench::plant::Part;
use catamaran_bench::textures::{
    PICTURES, disagreements, evaporation, grid, long_walks, many_points, maze, newton_figures,
    newton_times, rescaling, substeps, table,
};
use clap::ValueEnum;

use super::{Arguments, Report};

/// The columns of the record.
pub const HEADER: &str = "figure,case,quantity,value";

/// A share that can be run separately; each has its own files in the record.
#[derive(Clone, Copy, PartialEq, ValueEnum)]
pub enum Share {
    /// Figures 3.4, 3.5, 3.8, 3.9 and 3.10, table 3.1; figures 7.1 and 7.2.
    Figures,
    /// Measurements that need a quiet machine: tables 3.2 to 3.4, and times of Newton's fractals.
    Tables,
    /// 10^9 steps of agents and 10^8 points of fractals, none of which may be lost; on request
    /// only.
    Long,
    /// The record of `scripts/gpu`: whether the chosen OpenCL device computes the same as the
    /// processor, and times; on request only.
    Gpu,
}

impl Share {
    /// Returns the name of the share in the names of files in the record.
    pub fn name(self) -> &'static str {
        match self {
            Self::Figures => "textures",
            Self::Tables => "texture-times",
            Self::Long => "texture-long",
            Self::Gpu => "gpu",
        }
    }

    fn title(self) -> &'static str {
        match self {
            Self::Figures => "# Chapters 3 and 7, measured again",
            Self::Tables => "# Times of chapters 3 and 7, measured again",
            Self::Long => "# Long runs of chapters 3 and 7",
            Self::Gpu => "# Chapters 3 and 7 on an OpenCL device",
        }
    }
}

/// Pixels along each side of the picture whose time is measured.
const SIZE: u32 = 4096;

pub fn run(report: &mut Report, share: Share, arguments: &Arguments) -> Result<()> {
    report.say(&format!("{}\n", share.title()));
    match share {
        Share::Figures => {
            keep(report, substeps()?);
            keep(report, rescaling()?);
            let table = table()?;
            let disagreements = disagreements(&table);
            keep(report, table);
            report.say(&disagreements);
            keep(report, grid()?);
            keep(report, maze()?);
            keep(report, evaporation()?);
            newton_figures()?.into_iter().for_each(|part| keep(report, part));
            report.say(PICTURES);
        }
        Share::Tables => {
            #[cfg(feature = "opencl")]
            {
                use catamaran_bench::textures::{ten_meshes, times};
                keep(report, times(arguments.rounds, arguments.largest_texture)?);
                keep(report, ten_meshes(arguments.rounds, arguments.largest_texture)?);
            }
            newton_times(SIZE, arguments.repeat)?.into_iter().for_each(|part| keep(report, part));
        }
        Share::Long => {
            keep(report, long_walks()?);
            keep(report, many_points()?);
        }
        #[cfg(feature = "opencl")]
        Share::Gpu => {
            catamaran_bench::textures::gpu()?.into_iter().for_each(|part| keep(report, part));
        }
        #[cfg(not(feature = "opencl"))]
        Share::Gpu => return Err("--only gpu: this build lacks the feature opencl".into()),
    }
    Ok(())
}

/// Reports a part.
fn keep(report: &mut Report, part: Part) {
    report.say(&part.markdown());
    report.lines.extend(part.lines());
    report.plots.extend(part.plots);
}
