//! Plots of numbers over numbers: panels of curves or points.

use catamaran_charts::{Axis, Chart, Line, Series};

/// A panel.
#[derive(Debug, Clone)]
pub struct Plot {
    /// The title.
    pub title: String,
    /// The label of the horizontal axis.
    pub across: String,
    /// Whether the vertical axis is logarithmic.
    pub logarithmic: bool,
    /// Whether points have no lines between them.
    pub scattered: bool,
    /// A name, and points (x, y).
    pub series: Vec<(String, Vec<(f64, f64)>)>,
}

/// Draws the plots below one another, as an SVG document. Points that can't be shown are left out.
pub fn svg(plots: &[Plot]) -> String {
    catamaran_charts::svg(&plots.iter().map(Plot::chart).collect::<Vec<_>>())
}

impl Plot {
    fn chart(&self) -> Chart {
        let line = if self.scattered { Line::None } else { Line::Solid };
        let series = self.series.iter().enumerate().map(|(k, (name, points))| Series {
            line,
            dots: self.scattered,
            ..Series::curve(name, Series::color(k), points.clone())
        });
        Chart {
            title: self.title.clone(),
            x: Axis::linear(&self.across),
            y: if self.logarithmic { Axis::log10("") } else { Axis::linear("") },
            series: series.collect(),
            rules: vec![],
        }
    }
}
