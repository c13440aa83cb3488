//! Tables 3.2 to 3.4 of the thesis: milliseconds of a frame on an NVIDIA RTX 2080 Ti.

use catamaran_simulation::texture::slime::{Options, TangentStep};

/// Number of texels along a side in tables 3.3 and 3.4.
pub const SIZE: usize = 8192;
/// Number of frames over which the thesis takes means.
pub const FRAMES: usize = 900;

/// A row of a table.
pub struct Case {
    /// The table.
    pub table: &'static str,
    /// Millions of agents.
    pub millions: usize,
    /// Texels of a side.
    pub size: usize,
    /// Number of sub-steps; 0 for unfolding, which the thesis does not have.
    pub substeps: u32,
    /// Mean, largest and least time in the thesis, in milliseconds.
    pub thesis: Option<[f64; 3]>,
}

impl Case {
    /// Returns the name of the case in reports.
    pub fn name(&self) -> String {
        let walk = match self.substeps {
            0 => "unfolded".to_owned(),
            1 => "1 sub-step".to_owned(),
            n => format!("{n} sub-steps"),
        };
        format!("{}: {} M agents, {}, {walk}", self.table, self.millions, self.size)
    }

    /// Returns the options of the simulation.
    pub fn options(&self) -> Options {
        Options::new().agents(self.millions * 1_000_000).size(self.size).tangent_step(
            match self.substeps {
                0 => TangentStep::Unfold,
                substeps => TangentStep::Project { substeps },
            },
        )
    }

    /// Returns the numbers of the thesis, or NaN.
    pub fn thesis(&self) -> [f64; 3] {
        self.thesis.unwrap_or([f64::NAN; 3])
    }
}

/// Returns all rows, and unfolded steps for comparison.
pub fn cases() -> Vec<Case> {
    let case =
        |table, millions, size, substeps, thesis| Case { table, millions, size, substeps, thesis };
    let mut all = Vec::new();
    for (size, thesis) in [
        (2048, [8.473, 37.277, 7.362]),
        (4096, [9.503, 37.693, 8.268]),
        (8192, [12.120, 39.039, 10.263]),
        (16384, [23.715, 43.552, 16.220]),
    ] {
        all.push(case("table 3.2", 1, size, 10, Some(thesis)));
    }
    all.push(case("table 3.3", 1, SIZE, 0, None));
    for (substeps, thesis) in [
        (1, [12.070, 37.204, 10.020]),
        (10, [13.428, 38.632, 11.087]),
        (100, [47.828, 61.519, 44.756]),
        (1000, [423.136, 488.078, 411.836]),
    ] {
        all.push(case("table 3.3", 1, SIZE, substeps, Some(thesis)));
    }
    for (millions, thesis) in [
        (1, [12.053, 39.522, 10.214]),
        (2, [19.112, 37.205, 17.306]),
        (3, [26.303, 41.857, 24.006]),
        (4, [33.510, 53.710, 31.114]),
    ] {
        all.push(case("table 3.4", millions, SIZE, 10, Some(thesis)));
    }
    all
}
