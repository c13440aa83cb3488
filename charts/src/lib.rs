//! Charts as SVG, or on another back end of `plotters`, which draws them: the one plotting layer of
//! the command line, of its demo page and of the races.

mod axis;
mod bars;
mod chart;

pub use axis::{Axis, Scale};
pub use bars::{Bar, bars};
pub use chart::{Chart, DrawError, Line, Rgb, Rule, Series, draw, size, svg};
