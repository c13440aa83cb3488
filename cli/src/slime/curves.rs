//! Coverage and presence over time (thesis, figure 3.8), as CSV and SVG.

use std::fmt::Write as _;
use std::io::Write as _;

use anyhow::Result;
use catamaran::io::Output;
use catamaran_charts::{Axis, Chart, Line, Series};
use catamaran_simulation::texture::slime::Coverage;

/// A moment: seconds of the simulation, and the coverage of each species.
pub type Moment = (f64, Vec<Coverage>);

/// Writes a row for each moment.
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
    output.write_all(text.as_bytes()).map_err(|e| output.error(e))?;
    Ok(output.commit()?)
}

/// Draws coverage as lines and presence as dashes.
pub fn chart(moments: &[Moment]) -> Chart {
    let curve = |color, line, value: &dyn Fn(&[Coverage]) -> f64| {
        let points = moments.iter().map(|(seconds, all)| (*seconds, value(all))).collect();
        Series { line, ..Series::curve("", color, points) }
    };
    let species = 0..moments.first().map_or(0, |moment| moment.1.len());
    let series = species.flat_map(|s| {
        let color = Series::color(s);
        let coverage = curve(color, Line::Solid, &|all| all[s].coverage);
        [coverage, curve(color, Line::Dashed, &|all| all[s].presence)]
    });
    Chart::new(
        Axis::linear("seconds").range(0.0, moments.last().map_or(1.0, |moment| moment.0)),
        Axis::linear("coverage, and presence (dashed)").range(0.0, 1.0),
        series.collect(),
    )
}
