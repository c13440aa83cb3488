//! Pictures of numbers over numbers: panels of curves or points.

use std::fmt::Write;

use crate::chart::{COLOURS, END, LEFT, Panel, open, point};

/// A panel.
#[derive(Debug, Clone)]
pub struct Plot {
    /// What is shown.
    pub title: String,
    /// What is across.
    pub across: String,
    /// A logarithmic axis upwards.
    pub logarithmic: bool,
    /// Points without lines between them.
    pub scattered: bool,
    /// A name, and points (x, y).
    pub series: Vec<(String, Vec<(f64, f64)>)>,
}

/// Height of a panel, in those of a race.
const HEIGHT: f64 = 1.3;
/// Ticks of an axis, about.
const TICKS: f64 = 6.0;

/// The plots below one another, as an SVG document. Points that can't be shown are left out.
pub fn svg(plots: &[Plot]) -> String {
    let mut out = open(plots.len(), HEIGHT);
    for (p, plot) in plots.iter().enumerate() {
        draw(&mut out, p, plot);
    }
    out.push_str("</svg>\n");
    out
}

fn draw(out: &mut String, p: usize, plot: &Plot) {
    let panel = Panel::new(out, p, HEIGHT, &plot.title);
    let height = |y: f64| if plot.logarithmic { y.log10() } else { y };
    let shown = |&(x, y): &(f64, f64)| x.is_finite() && height(y).is_finite();
    let points = || plot.series.iter().flat_map(|(_, points)| points).copied().filter(shown);
    let range = |values: &mut dyn Iterator<Item = f64>| {
        let (low, high) = values
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
        if low < high { (low, high) } else { (low.min(0.0), high.max(1.0)) }
    };
    let (left, right) = range(&mut points().map(|(x, _)| x));
    let (bottom, top) = range(&mut points().map(|(_, y)| height(y)));
    let (bottom, top) =
        if plot.logarithmic { (bottom.floor(), top.ceil()) } else { (bottom.min(0.0), top) };
    let x = |value: f64| LEFT + 8.0 + (END - LEFT - 16.0) * (value - left) / (right - left);
    let y = |value: f64| panel.low - (panel.low - panel.high) * (value - bottom) / (top - bottom);

    for value in ticks(bottom, top) {
        let text = if plot.logarithmic { format!("1e{value}") } else { format!("{value}") };
        panel.tick(out, y(value), &text);
    }
    for value in ticks(left, right) {
        panel.below(out, x(value), &format!("{value}"));
    }
    let _ = writeln!(
        out,
        "<text x=\"{:.0}\" y=\"{:.0}\">{}</text>",
        END + 8.0,
        panel.low + 18.0,
        plot.across
    );
    for (k, (name, points)) in plot.series.iter().enumerate() {
        let colour = COLOURS[k % COLOURS.len()];
        let mut path = String::new();
        for (px, py) in points.iter().copied().filter(shown) {
            let place = [x(px), y(height(py))];
            // A line of one point would not be seen.
            if plot.scattered || points.len() == 1 {
                point(out, place, colour, &format!("{name}: {px:.4}, {py:.4e}"));
            }
            let [px, py] = place;
            let _ = write!(path, "{}{px:.1} {py:.1}", if path.is_empty() { "M" } else { "L" });
        }
        if !plot.scattered {
            let _ = writeln!(
                out,
                "<path d=\"{path}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"2\"/>"
            );
        }
        panel.legend(out, k, colour, name);
    }
}

/// Round numbers between two, one, two or five times a power of ten apart.
fn ticks(from: f64, to: f64) -> Vec<f64> {
    let rough = (to - from) / TICKS;
    let power = 10_f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].into_iter().map(|k| k * power).find(|s| *s >= rough);
    let step = step.unwrap_or(10.0 * power);
    let first = (from / step).ceil() as i64;
    // Products of whole numbers and a power of ten, rounded to what is printed.
    let tick = |k: i64| format!("{:.12e}", k as f64 * step).parse().unwrap_or(0.0);
    (first..).map(tick).take_while(|value| *value <= to + 1e-9 * step).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_cover_the_range() {
        assert_eq!(ticks(0.0, 1.0), [0.0, 0.2, 0.4, 0.6, 0.8, 1.0]);
        assert_eq!(ticks(-3.0, 2.0), [-3.0, -2.0, -1.0, 0.0, 1.0, 2.0]);
        assert_eq!(ticks(7.0, 93.0), [20.0, 40.0, 60.0, 80.0]);
    }

    #[test]
    fn every_series_is_drawn_and_what_has_no_logarithm_is_not() {
        let plot = Plot {
            title: "errors".into(),
            across: "K".into(),
            logarithmic: true,
            scattered: true,
            series: vec![("a".into(), vec![(1.0, 0.1), (2.0, 0.0), (3.0, 0.001)])],
        };
        let picture = svg(&[plot.clone(), Plot { series: vec![], ..plot }]);
        assert_eq!(picture.matches("<title>").count(), 2);
        assert!(picture.contains(">1e-3<") && picture.contains(">a<") && picture.contains(">K<"));
        assert!(!picture.contains("NaN") && !picture.contains("inf"));
    }
}
