//! Curves of water over time, as SVG.

use std::fmt::Write as _;
use std::io::Write as _;

use anyhow::Result;
use catamaran::io::Output;
use catamaran::plant::Plant;

use super::Simulation;

const WIDTH: f64 = 760.0;
const HEIGHT: f64 = 420.0;
/// Left, right, top and bottom of the axes.
const FRAME: [f64; 4] = [60.0, 740.0, 20.0, 370.0];

/// The relative water content of leaves, stem and the whole plant, and that of some nodes.
pub fn write(mut output: Output, plant: &Plant, simulation: &Simulation) -> Result<()> {
    let svg = svg(plant, simulation);
    output.write_all(svg.as_bytes()).map_err(|e| output.error(&e))?;
    Ok(output.commit()?)
}

/// The picture; also for a page.
pub fn svg(plant: &Plant, simulation: &Simulation) -> String {
    let [left, right, top, bottom] = FRAME;
    let last = simulation.hours.last().copied().unwrap_or(1.0).max(f64::MIN_POSITIVE);
    let at = |hours: f64, w: f64| {
        (left + (right - left) * hours / last, bottom - (bottom - top) * w.clamp(0.0, 1.05) / 1.05)
    };
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" font-family=\"sans-serif\" \
         font-size=\"13\" fill=\"#444\">\n<rect width=\"{WIDTH}\" height=\"{HEIGHT}\" fill=\"white\"/>\n"
    );
    for i in 0..=4 {
        let w = f64::from(i) / 4.0;
        let (_, y) = at(0.0, w);
        let (x, _) = at(last * w, 0.0);
        let _ = writeln!(
            svg,
            "<path d=\"M{left} {y:.1}H{right}M{x:.1} {bottom}v5\" stroke=\"#ddd\"/>\
             <text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{w}</text>\
             <text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>",
            left - 8.0,
            y + 4.0,
            bottom + 20.0,
            (10.0 * last * w).round() / 10.0
        );
    }
    let leaf = |v: usize| plant.segments()[v].leaf;
    // A few nodes, evenly over their numbers, behind the means.
    let some = (0..12).map(|i| i * plant.len() / 12);
    for v in some {
        curve(&mut svg, simulation, &at, "#cbd5e1", 1.0, &|u| u == v);
    }
    type Group<'a> = &'a dyn Fn(usize) -> bool;
    let groups: [(&str, &str, Group<'_>); 3] = [
        ("leaves", "#16a34a", &leaf),
        ("stem", "#b45309", &|v| !leaf(v)),
        ("all", "#1d4ed8", &|_| true),
    ];
    for (i, (name, color, group)) in groups.into_iter().enumerate() {
        curve(&mut svg, simulation, &at, color, 2.0, group);
        let y = top + 12.0 + 18.0 * i as f64;
        let _ = writeln!(
            svg,
            "<text x=\"{}\" y=\"{y}\" text-anchor=\"end\" fill=\"{color}\">{name}</text>",
            right - 6.0
        );
    }
    let _ = writeln!(
        svg,
        "<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">hours</text>\
         <text x=\"14\" y=\"{}\" transform=\"rotate(-90 14 {})\" text-anchor=\"middle\">relative water content</text>\n</svg>",
        (left + right) / 2.0,
        HEIGHT - 12.0,
        (top + bottom) / 2.0,
        (top + bottom) / 2.0
    );
    svg
}

fn curve(
    svg: &mut String,
    simulation: &Simulation,
    at: &dyn Fn(f64, f64) -> (f64, f64),
    color: &str,
    width: f64,
    group: &dyn Fn(usize) -> bool,
) {
    let members: Vec<usize> = (0..simulation.full.len()).filter(|&v| group(v)).collect();
    if members.is_empty() {
        return;
    }
    let sum = |values: &[f64]| members.iter().map(|&v| values[v]).sum::<f64>();
    let full = sum(&simulation.full);
    let mut points = String::new();
    for (hours, water) in simulation.hours.iter().zip(&simulation.water) {
        let (x, y) = at(*hours, sum(water) / full);
        let _ = write!(points, "{x:.1},{y:.1} ");
    }
    let _ = writeln!(
        svg,
        "<polyline points=\"{}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"{width}\"/>",
        points.trim_end()
    );
}
