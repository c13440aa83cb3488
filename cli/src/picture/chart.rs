//! Curves over an axis that starts at 0, as SVG.

use std::fmt::Write as _;
use std::io::Write as _;

use anyhow::Result;
use catamaran::io::Output;

const WIDTH: f64 = 760.0;
const HEIGHT: f64 = 420.0;
/// Left, right, top and bottom of the axes.
const FRAME: [f64; 4] = [74.0, 740.0, 20.0, 370.0];

/// What is drawn.
pub struct Chart<'a> {
    /// What is across.
    pub across: &'a str,
    /// Where that ends.
    pub last: f64,
    /// What is upwards.
    pub upwards: &'a str,
    /// How.
    pub scale: Upwards,
    /// The later ones above the earlier.
    pub curves: Vec<Curve<'a>>,
}

/// The axis upwards.
pub enum Upwards {
    /// From 0, with marks at quarters of 1, to this.
    To(f64),
    /// Powers of ten around all that is there.
    Logarithmic,
}

/// A curve.
pub struct Curve<'a> {
    /// Its name in the legend; empty: none.
    pub name: &'a str,
    /// Its colour.
    pub color: &'a str,
    /// Its width.
    pub width: f64,
    /// Whether it is dashed.
    pub dashed: bool,
    /// Across and upwards.
    pub points: Vec<(f64, f64)>,
}

/// Writes the picture.
pub fn write_chart(mut output: Output, chart: &Chart<'_>) -> Result<()> {
    output.write_all(chart.svg().as_bytes()).map_err(|e| output.error(e))?;
    Ok(output.commit()?)
}

impl Chart<'_> {
    /// The picture; also for a page.
    pub fn svg(&self) -> String {
        let [left, right, top, bottom] = FRAME;
        let last = self.last.max(f64::MIN_POSITIVE);
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" font-family=\"sans-serif\" \
             font-size=\"13\" fill=\"#444\">\n<rect width=\"{WIDTH}\" height=\"{HEIGHT}\" fill=\"white\"/>\n"
        );
        let x = |value: f64| left + (right - left) * value / last;
        let (low, high) = self.range();
        let y =
            |height: f64| bottom - (bottom - top) * (height.clamp(low, high) - low) / (high - low);
        for (height, text) in self.marks() {
            let _ = writeln!(
                svg,
                "<path d=\"M{left} {:.1}H{right}\" stroke=\"#ddd\"/><text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{text}</text>",
                y(height),
                left - 8.0,
                y(height) + 4.0
            );
        }
        for i in 0..=4 {
            let value = last * f64::from(i) / 4.0;
            let _ = writeln!(
                svg,
                "<path d=\"M{:.1} {bottom}v5\" stroke=\"#ddd\"/><text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>",
                x(value),
                x(value),
                bottom + 20.0,
                (10.0 * value).round() / 10.0
            );
        }
        let mut names = 0.0;
        for curve in &self.curves {
            let mut points = String::new();
            for &(across, value) in curve.points.iter().filter(|point| self.shows(point)) {
                let _ = write!(points, "{:.1},{:.1} ", x(across), y(self.height(value)));
            }
            let dashes = if curve.dashed { " stroke-dasharray=\"6 4\"" } else { "" };
            let _ = writeln!(
                svg,
                "<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{}\"{dashes}/>",
                points.trim_end(),
                curve.color,
                curve.width
            );
            if !curve.name.is_empty() {
                let _ = writeln!(
                    svg,
                    "<text x=\"{}\" y=\"{}\" text-anchor=\"end\" fill=\"{}\">{}</text>",
                    right - 6.0,
                    top + 12.0 + 18.0 * names,
                    curve.color,
                    curve.name
                );
                names += 1.0;
            }
        }
        let [middle, centre] = [(left + right) / 2.0, (top + bottom) / 2.0];
        let _ = write!(
            svg,
            "<text x=\"{middle}\" y=\"{}\" text-anchor=\"middle\">{}</text>\
             <text x=\"14\" y=\"{centre}\" transform=\"rotate(-90 14 {centre})\" text-anchor=\"middle\">{}</text>\n</svg>\n",
            HEIGHT - 12.0,
            self.across,
            self.upwards
        );
        svg
    }

    fn height(&self, value: f64) -> f64 {
        match self.scale {
            Upwards::To(_) => value,
            Upwards::Logarithmic => value.log10(),
        }
    }

    /// Zero has no logarithm.
    fn shows(&self, &(across, value): &(f64, f64)) -> bool {
        across.is_finite() && self.height(value).is_finite()
    }

    /// Heights at the bottom and at the top.
    fn range(&self) -> (f64, f64) {
        match self.scale {
            Upwards::To(top) => (0.0, top),
            Upwards::Logarithmic => {
                let all = || self.curves.iter().flat_map(|curve| &curve.points);
                let heights = || all().filter(|p| self.shows(p)).map(|p| self.height(p.1));
                let high = heights().reduce(f64::max).unwrap_or(0.0).ceil();
                let low = heights().reduce(f64::min).unwrap_or(-1.0).floor();
                (low.min(high - 1.0), high)
            }
        }
    }

    /// Marked heights, and what is written there.
    fn marks(&self) -> Vec<(f64, String)> {
        match self.scale {
            Upwards::To(_) => {
                (0..=4).map(|i| f64::from(i) / 4.0).map(|h| (h, h.to_string())).collect()
            }
            Upwards::Logarithmic => {
                let (low, high) = self.range();
                let powers = low as i32..=high as i32;
                powers.map(|power| (f64::from(power), format!("1e{power}"))).collect()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_of_any_length_are_finite() {
        for length in [0, 1, 2, 50] {
            let points: Vec<(f64, f64)> =
                (0..length).map(|i| (f64::from(i), 1.0 / f64::from(i + 1))).collect();
            let none = points.iter().map(|&(x, _)| (x, 0.0)).collect();
            for scale in [Upwards::Logarithmic, Upwards::To(1.05)] {
                let curves = [("a", &points), ("", &none)].map(|(name, points)| Curve {
                    name,
                    color: "#444",
                    width: 1.0,
                    dashed: name.is_empty(),
                    points: points.clone(),
                });
                let last = f64::from(length - 1);
                let chart = Chart { across: "x", last, upwards: "y", scale, curves: curves.into() };
                let svg = chart.svg();
                assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
                assert_eq!(svg.matches("<polyline").count(), 2);
                assert_eq!(svg.matches(">a<").count(), 1);
            }
        }
    }
}
