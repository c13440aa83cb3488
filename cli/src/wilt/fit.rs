//! `wilt --fit`: the constants of a plant from what was weighed.

use std::io::{BufRead, BufReader, Write};
use std::path::Path;

use anyhow::{Context, Result, bail};
use catamaran::base::Progress;
use catamaran::io::Output;
use catamaran::plant::{Estimate, Fit, FitOptions, Measurements, Plant, fit};

use crate::picture::{Chart, Curve, Upwards, write_chart};
use crate::progress::Bar;
use crate::report::report;

/// A gram per hour in kg per second.
const GRAM_PER_HOUR: f64 = 1.0 / 3.6e6;

/// The names of the files.
pub const NAMES: [&str; 3] = ["fit.csv", "fitted.csv", "fit.svg"];

/// Reads `time_h,weight_g` or `time_h,weight_g,height_m`.
pub fn read(path: &Path) -> Result<Measurements> {
    let name = path.display();
    let file = std::fs::File::open(path).with_context(|| name.to_string())?;
    let mut measured = Measurements::default();
    let mut columns = 0;
    for (i, line) in BufReader::new(file).lines().enumerate() {
        let line = line.with_context(|| name.to_string())?;
        let cells: Vec<&str> = line.trim().split(',').map(str::trim).collect();
        if i == 0 {
            columns = match cells[..] {
                ["time_h", "weight_g"] => 2,
                ["time_h", "weight_g", "height_m"] => 3,
                _ => bail!("{name}: line 1: expected time_h,weight_g or time_h,weight_g,height_m"),
            };
            continue;
        }
        if cells == [""] {
            continue;
        }
        let numbers: Option<Vec<f64>> = cells.iter().map(|cell| cell.parse().ok()).collect();
        match numbers.as_deref() {
            Some(&[hours, grams]) if columns == 2 => add(&mut measured, hours, grams, None),
            Some(&[hours, grams, metres]) if columns == 3 => {
                add(&mut measured, hours, grams, Some(metres));
            }
            _ => bail!("{name}: line {}: expected {columns} numbers: {line:?}", i + 1),
        }
    }
    Ok(measured)
}

fn add(measured: &mut Measurements, hours: f64, grams: f64, height: Option<f64>) {
    measured.seconds.push(3600.0 * hours);
    measured.weights.push(1e-3 * grams);
    measured.heights.extend(height);
}

/// What was fitted to what was measured.
pub struct Fitted<'a> {
    measured: &'a Measurements,
    found: Fit,
}

/// Fits and reports.
pub fn run<'a>(
    plant: &Plant,
    measured: &'a Measurements,
    options: FitOptions<'_>,
) -> Result<Fitted<'a>> {
    let bar = Bar::new("fitting");
    let update = |done| bar.update(done);
    let found = fit(plant, measured, &options.progress(Progress::new(&update)))?;
    drop(bar);
    for (name, Estimate { value, error }, unit) in constants(&found) {
        let spread = match error {
            e if e.is_nan() => "at a bound".into(),
            e if e.is_infinite() => "not told by the measurements".into(),
            e => format!("+- {e:.2e}"),
        };
        report(format_args!("{name:<9} {value:.6e} {unit}, {spread}"))?;
    }
    let height = match found.steepness {
        Some(_) => format!(", {:.2} mm of a height", 1e3 * found.height_deviation),
        None => String::new(),
    };
    report(format_args!("deviation {:.4} g of a weight{height}", 1e3 * found.weight_deviation))?;
    Ok(Fitted { measured, found })
}

impl Fitted<'_> {
    /// Writes the constants, the measurements beside the model, and a picture of these.
    pub fn write(&self, file: impl Fn(&str) -> catamaran::Result<Output>) -> Result<()> {
        let mut text = "constant,value,standard_error,unit\n".to_string();
        for (name, Estimate { value, error }, unit) in constants(&self.found) {
            text += &format!("{name},{value},{error},{unit}\n");
        }
        write(file(NAMES[0])?, &text)?;
        write(file(NAMES[1])?, &table(self.measured, &self.found))?;
        write_chart(file(NAMES[2])?, &chart(self.measured, &self.found))
    }
}

fn write(mut output: Output, text: &str) -> Result<()> {
    output.write_all(text.as_bytes()).map_err(|e| output.error(e))?;
    Ok(output.commit()?)
}

/// In the units of the options.
fn constants(found: &Fit) -> Vec<(&'static str, Estimate, &'static str)> {
    let times = |e: Estimate, s: f64| Estimate { value: e.value * s, error: e.error * s };
    let mut constants = vec![
        ("delta", times(found.loss, 1.0 / GRAM_PER_HOUR), "g/(h m^2)"),
        ("chi", found.scale, "1"),
        ("weight", times(found.weight, 1e3), "g"),
    ];
    constants.extend(found.steepness.map(|kappa| ("kappa", kappa, "1")));
    constants
}

/// What was measured beside the model.
fn table(measured: &Measurements, found: &Fit) -> String {
    let has_heights = !measured.heights.is_empty();
    let mut text = "time_h,weight_g,model_g".to_string();
    text += if has_heights { ",height_m,model_m\n" } else { "\n" };
    for i in 0..measured.seconds.len() {
        let hours = measured.seconds[i] / 3600.0;
        text += &format!("{hours},{},{}", 1e3 * measured.weights[i], 1e3 * found.weights[i]);
        if has_heights {
            text += &format!(",{},{}", measured.heights[i], found.heights[i]);
        }
        text.push('\n');
    }
    text
}

/// Weights between the lightest and the heaviest, and heights as parts of the first.
fn chart(measured: &Measurements, found: &Fit) -> Chart<'static> {
    let heaviest = measured.weights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let lightest = measured.weights.iter().copied().fold(f64::INFINITY, f64::min);
    let hours: Vec<f64> = measured.seconds.iter().map(|s| s / 3600.0).collect();
    let weight = |w: f64| (w - lightest) / (heaviest - lightest);
    let tallest = measured.heights.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    let curve = |name, color, dashed, values: &[f64], part: &dyn Fn(f64) -> f64| Curve {
        name,
        color,
        width: 2.0,
        dashed,
        points: hours.iter().zip(values).map(|(h, x)| (*h, part(*x))).collect(),
    };
    let mut curves = vec![
        curve("weight, fitted", "#ea580c", false, &found.weights, &weight),
        curve("weight, measured", "#1d4ed8", true, &measured.weights, &weight),
    ];
    if !measured.heights.is_empty() {
        let height = |h: f64| h / tallest;
        curves.push(curve("height, fitted", "#16a34a", false, &found.heights, &height));
        curves.push(curve("height, measured", "#111827", true, &measured.heights, &height));
    }
    Chart {
        across: "hours",
        last: hours.last().copied().unwrap_or(1.0),
        upwards: "weight above the least, and height, as parts",
        scale: Upwards::To(1.05),
        curves,
    }
}
