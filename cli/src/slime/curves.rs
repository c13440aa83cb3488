//! Coverage and presence over time (thesis, figure 3.8), as CSV and SVG.

use std::fmt::Write as _;
use std::io::Write as _;

use anyhow::Result;
use catamaran::io::Output;
use catamaran::texture::slime::Coverage;

use crate::picture::{Chart, Curve, Upwards};

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
    output.write_all(text.as_bytes()).map_err(|e| output.error(e))?;
    Ok(output.commit()?)
}

/// A picture: coverage as lines, presence dashed.
pub fn chart(moments: &[Moment]) -> Chart<'static> {
    let curve = |color, dashed, value: &dyn Fn(&[Coverage]) -> f64| Curve {
        name: "",
        color,
        width: 2.0,
        dashed,
        points: moments.iter().map(|(seconds, all)| (*seconds, value(all))).collect(),
    };
    let species = 0..moments.first().map_or(0, |moment| moment.1.len());
    let curves = species.flat_map(|s| {
        let color = COLORS[s % COLORS.len()];
        [curve(color, false, &|all| all[s].coverage), curve(color, true, &|all| all[s].presence)]
    });
    Chart {
        across: "seconds",
        last: moments.last().map_or(1.0, |moment| moment.0),
        upwards: "coverage, and presence (dashed)",
        scale: Upwards::To(1.0),
        curves: curves.collect(),
    }
}
