//! A learning curve as SVG.

use std::fmt::Write as _;
use std::io::Write as _;

use anyhow::Result;
use catamaran::io::Output;
use catamaran_training::train::Epoch;

/// Left, right, top and bottom of the axes.
const FRAME: [f64; 4] = [60.0, 740.0, 20.0, 370.0];

/// Errors over epochs, on a logarithmic axis.
pub fn write(mut output: Output, history: &[Epoch]) -> Result<()> {
    let svg = svg(history);
    output.write_all(svg.as_bytes()).map_err(|e| output.error(&e))?;
    Ok(output.commit()?)
}

fn svg(history: &[Epoch]) -> String {
    let [left, right, top, bottom] = FRAME;
    let mut svg = String::from(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 760 420\" font-family=\"sans-serif\" \
         font-size=\"13\" fill=\"#444\">\n<rect width=\"760\" height=\"420\" fill=\"white\"/>\n",
    );
    let shown = |of: fn(&Epoch) -> f64| {
        let points = history.iter().enumerate().map(move |(i, epoch)| (i as f64, of(epoch)));
        points.filter(|(_, error)| *error > 0.0 && error.is_finite())
    };
    let both = || shown(|epoch| epoch.training).chain(shown(|epoch| epoch.validation));
    let largest = both().map(|(_, e)| e).fold(1e-3, f64::max).log10().ceil();
    let smallest = both().map(|(_, e)| e).fold(1.0, f64::min).log10().floor().min(largest - 1.0);
    let last = history.len().saturating_sub(1).max(1) as f64;
    let height = |log: f64| bottom - (bottom - top) * (log - smallest) / (largest - smallest);
    for power in smallest as i32..=largest as i32 {
        let y = height(f64::from(power));
        let _ = writeln!(
            svg,
            "<path d=\"M{left} {y:.1}H{right}\" stroke=\"#ddd\"/><text x=\"{:.1}\" y=\"{:.1}\" \
             text-anchor=\"end\">1e{power}</text>",
            left - 8.0,
            y + 4.0
        );
    }
    type Curve = (&'static str, &'static str, fn(&Epoch) -> f64);
    let curves: [Curve; 2] = [
        ("training", "#1d4ed8", |epoch| epoch.training),
        ("pairs to choose by", "#b45309", |epoch| epoch.validation),
    ];
    for (i, (name, color, of)) in curves.into_iter().enumerate() {
        let mut points = String::new();
        for (epoch, error) in shown(of) {
            let x = left + (right - left) * epoch / last;
            let _ = write!(points, "{x:.1},{:.1} ", height(error.log10()));
        }
        let _ = writeln!(
            svg,
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"2\"/>\
             <text x=\"{}\" y=\"{}\" text-anchor=\"end\" fill=\"{color}\">{name}</text>",
            points.trim_end(),
            right - 6.0,
            top + 12.0 + 18.0 * i as f64
        );
    }
    let _ = writeln!(
        svg,
        "<text x=\"{right}\" y=\"408\" text-anchor=\"end\">mean error of logarithms over {} epochs</text>\n</svg>",
        history.len()
    );
    svg
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_of_any_length_are_finite() {
        for length in [0, 1, 2, 50] {
            let epoch = |i: usize| Epoch { training: 1.0 / (i + 1) as f64, validation: 0.0 };
            let history: Vec<Epoch> = (0..length).map(epoch).collect();
            let svg = svg(&history);
            assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
            assert_eq!(svg.matches("<polyline").count(), 2);
        }
    }
}
