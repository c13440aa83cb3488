//! Charts as SVG, drawn by `plotters`: the one plotting layer of the command line, of its demo page
//! and of the races.

mod axis;
mod bars;
mod chart;

pub use axis::{Axis, Scale};
pub use bars::{Bar, bars};
pub use chart::{Chart, Line, Rgb, Rule, Series, svg};
