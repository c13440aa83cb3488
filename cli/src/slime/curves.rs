//! Coverage and presence over time (thesis, figure 3.8), as CSV and SVG.

use std::fmt::Write as _;
use std::io::Write as _;

use anyhow::Result;
use catamaran::io::Output;
use catamaran::texture::slime::Coverage;

const WIDTH: f64 = 760.0;
const HEIGHT: f64 = 420.0;
/// Left, right, top and bottom of the axes.
const FRAME: [f64; 4] = [60.0, 740.0, 20.0, 370.0];

/// Colours of species, again from the first when there are more.
const COLORS: [&str; 6] = ["#b91c1c", "#15803d", "#1d4ed8", "#a16207", "#7e22ce", "#0e7490"];

/// A moment: seconds of the simulation, and the coverage of each species.
pub type Moment = (f64, Vec<Coverage>);

/// A row a moment.
pub fn write_csv(mut output: Output, moments: &[Moment]) -> Result<()> {
    let mut text = String::from("seconds");
    for s in 0..moments.first().map_or(0, |m| m.1.len()) {
        let _ = write!(text, ",coverage{s},presence{s}");
    }
    text.push('\n');
    for (seconds, all) in moments {
        let _ = write!(text, "{seconds}");
        for one in all {
            let _ = write!(text, ",{},{}", one.coverage, one.presence);
        }
        text.push('\n');
    }
    output.write_all(text.as_bytes()).map_err(|e| output.error(&e))?;
    Ok(output.commit()?)
}

/// A picture: coverage as lines, presence dashed.
pub fn write_svg(mut output: Output, moments: &[Moment]) -> Result<()> {
    let svg = svg(moments);
    output.write_all(svg.as_bytes()).map_err(|e| output.error(&e))?;
    Ok(output.commit()?)
}

/// The picture; also for a page.
pub fn svg(moments: &[Moment]) -> String {
    let [left, right, top, bottom] = FRAME;
    let last = moments.last().map_or(1.0, |m| m.0).max(f64::MIN_POSITIVE);
    let at = |seconds: f64, part: f64| {
        (left + (right - left) * seconds / last, bottom - (bottom - top) * part.clamp(0.0, 1.0))
    };
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" font-family=\"sans-serif\" \
         font-size=\"13\" fill=\"#444\">\n<rect width=\"{WIDTH}\" height=\"{HEIGHT}\" fill=\"white\"/>\n"
    );
    for i in 0..=4 {
        let part = f64::from(i) / 4.0;
        let ((_, y), (x, _)) = (at(0.0, part), at(last * part, 0.0));
        let _ = writeln!(
            svg,
            "<path d=\"M{left} {y:.1}H{right}M{x:.1} {bottom}v5\" stroke=\"#ddd\"/>\
             <text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{part}</text>\
             <text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>",
            left - 8.0,
            y + 4.0,
            bottom + 20.0,
            (10.0 * last * part).round() / 10.0
        );
    }
    let mut line = |value: &dyn Fn(&[Coverage]) -> f64, color: &str, dashes: &str| {
        let mut points = String::new();
        for (seconds, all) in moments {
            let (x, y) = at(*seconds, value(all));
            let _ = write!(points, "{x:.1},{y:.1} ");
        }
        let _ = writeln!(
            svg,
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"2\" stroke-dasharray=\"{dashes}\"/>",
            points.trim_end()
        );
    };
    for s in 0..moments.first().map_or(0, |m| m.1.len()) {
        let color = COLORS[s % COLORS.len()];
        line(&|all| all[s].coverage, color, "");
        line(&|all| all[s].presence, color, "6 4");
    }
    let _ = write!(
        svg,
        "<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">seconds</text>\
         <text x=\"14\" y=\"{}\" transform=\"rotate(-90 14 {})\" text-anchor=\"middle\">coverage, and presence (dashed)</text>\n</svg>\n",
        (left + right) / 2.0,
        HEIGHT - 12.0,
        (top + bottom) / 2.0,
        (top + bottom) / 2.0
    );
    svg
}
