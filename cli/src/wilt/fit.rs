//! `wilt --fit`: fits the constants of a plant to measurements.

use std::collections::BTreeMap;
use std::io::Write;

use anyhow::{Context, Result, bail};
use catamaran::base::Progress;
use catamaran::io::Output;
use catamaran_charts::{Axis, Chart, Line, Series};
use catamaran_simulation::plant::{Estimate, Fit, FitOptions, Mark, Measurements, Plant, fit};

use crate::input::TextFile;
use crate::parse;
use crate::picture::write_chart;
use crate::progress::Bar;
use crate::report::{head, report};

/// A gram per hour in kg per second.
const GRAM_PER_HOUR: f64 = 1.0 / 3.6e6;

/// The names of the files.
pub const NAMES: [&str; 3] = ["fit.csv", "fitted.csv", "fit.svg"];

/// The content of a column of a table.
enum Column {
    Hours,
    Grams,
    /// The height of the highest point, in metres.
    Height,
    /// The height of the node of this mark, in metres.
    Mark(usize),
}

/// Reads the columns `time_h,weight_g`, and heights in further columns: `height_m`, `node_12_m`.
pub fn read(table: &TextFile) -> Result<Measurements> {
    let (text, name) = (table.read()?, table.name());
    let mut measured = Measurements::default();
    let (mut columns, mut hours) = (Vec::new(), 0.0);
    for (i, line) in text.lines().enumerate() {
        let cells: Vec<&str> = line.trim().split(',').map(str::trim).collect();
        if i == 0 {
            columns = header(&cells, &mut measured).with_context(|| format!("{name}: line 1"))?;
            continue;
        }
        if cells == [""] {
            continue;
        }
        let numbers: Option<Vec<f64>> = cells.iter().map(|cell| parse::finite(cell).ok()).collect();
        let Some(numbers) = numbers.filter(|numbers| numbers.len() == columns.len()) else {
            let count = columns.len();
            bail!("{name}: line {}: expected {count} finite numbers, not {line:?}", i + 1);
        };
        let before = std::mem::replace(&mut hours, numbers[0]);
        if hours < before {
            let why = format!("time_h must ascend from 0, not from {before} to {hours}");
            bail!("{name}: line {}: {why}", i + 1);
        }
        for (column, number) in columns.iter().zip(numbers) {
            match column {
                Column::Hours => measured.seconds.push(3600.0 * number),
                Column::Grams => measured.weights.push(1e-3 * number),
                Column::Height => measured.heights.push(number),
                Column::Mark(mark) => measured.marks[*mark].heights.push(number),
            }
        }
    }
    Ok(measured)
}

fn header(cells: &[&str], measured: &mut Measurements) -> Result<Vec<Column>> {
    let mut columns = Vec::new();
    for (i, cell) in cells.iter().enumerate() {
        let node = cell.strip_prefix("node_").and_then(|cell| cell.strip_suffix("_m"));
        columns.push(match (i, *cell, node.map(str::parse)) {
            (0, "time_h", _) => Column::Hours,
            (1, "weight_g", _) => Column::Grams,
            (2, "height_m", _) => Column::Height,
            (2.., _, Some(Ok(node))) => {
                measured.marks.push(Mark { node, heights: vec![] });
                Column::Mark(measured.marks.len() - 1)
            }
            _ => bail!(
                "expected time_h,weight_g, then height_m or columns such as node_12_m, not {cell:?} \
                 (tables of leaves need --weather)"
            ),
        });
    }
    if columns.len() < 2 {
        bail!("expected the columns time_h,weight_g");
    }
    Ok(columns)
}

/// The result of a fit, and the measurements.
pub struct Fitted<'a> {
    measured: &'a Measurements,
    found: Fit,
    /// The names of the steepnesses.
    classes: Vec<String>,
}

/// Fits the constants and reports them. `classes` are the names of the steepnesses; errors begin
/// with `what`.
pub fn run<'a>(
    plant: &Plant,
    measured: &'a Measurements,
    options: FitOptions<'_>,
    classes: Vec<String>,
    what: &str,
) -> Result<Fitted<'a>> {
    let bar = Bar::new("fitting");
    let update = |done| bar.update(done);
    let found = fit(plant, measured, &options.progress(Progress::new(&update)))
        .with_context(|| what.to_owned())?;
    drop(bar);
    for (name, Estimate { value, error }, unit) in constants(&found, &classes) {
        let spread = match error {
            e if e.is_nan() => "at a bound".into(),
            e if e.is_infinite() => "not determined by the measurements".into(),
            e => format!("+- {e:.2e}"),
        };
        report!(
            "constant": name,
            name = name,
            value = value,
            standard_error = error,
            unit = unit;
            "{value:.6e} {unit}, {spread}"
        )?;
    }
    let height = match found.steepness.is_empty() {
        false => format!(", {:.2} mm of a height", 1e3 * found.height_deviation),
        true => String::new(),
    };
    let grams = 1e3 * found.weight_deviation;
    report!(
        "deviation",
        weight_grams = grams,
        height_millimeters = (!height.is_empty()).then_some(1e3 * found.height_deviation);
        "{grams:.4} g of a weight{height}"
    )?;
    let others = others(&found, &classes);
    for (i, constants) in others.iter().enumerate() {
        let one = |(name, value, unit): &(&str, f64, &str)| match *unit {
            "1" => format!("{name} {value:.4e}"),
            unit => format!("{name} {value:.4} {unit}"),
        };
        let texts: Vec<String> = constants.iter().map(one).collect();
        let values: BTreeMap<&str, f64> =
            constants.iter().map(|&(name, value, _)| (name, value)).collect();
        report!(
            "minimum": "warning",
            number = i + 2,
            constants = values;
            "minimum {} fits as well: {}",
            i + 2,
            texts.join(", ")
        )?;
    }
    if !others.is_empty() {
        let what = "standard errors are those of the first minimum alone";
        head(format_args!("{:12}{what}", ""))?;
    }
    Ok(Fitted { measured, found, classes })
}

impl Fitted<'_> {
    /// Writes the constants, the measurements beside the model, and a picture of both.
    pub fn write(&self, file: impl Fn(&str) -> Result<Output>) -> Result<()> {
        let mut text = "constant,value,standard_error,unit\n".to_string();
        for (name, Estimate { value, error }, unit) in constants(&self.found, &self.classes) {
            text += &format!("{name},{value},{error},{unit}\n");
        }
        for (i, constants) in others(&self.found, &self.classes).iter().enumerate() {
            for (name, value, unit) in constants {
                text += &format!("{name} of minimum {},{value},,{unit}\n", i + 2);
            }
        }
        write(file(NAMES[0])?, &text)?;
        write(file(NAMES[1])?, &table(self.measured, &self.found))?;
        write_chart(file(NAMES[2])?, &chart(self.measured, &self.found))
    }
}

/// Writes a text.
pub fn write(mut output: Output, text: &str) -> Result<()> {
    output.write_all(text.as_bytes()).map_err(|e| output.error(e))?;
    Ok(output.commit()?)
}

/// Returns the constants in the units of the options.
fn constants<'a>(found: &Fit, classes: &'a [String]) -> Vec<(&'a str, Estimate, &'static str)> {
    let times = |e: Estimate, s: f64| Estimate { value: e.value * s, error: e.error * s };
    let mut constants = vec![
        ("delta", times(found.loss, 1.0 / GRAM_PER_HOUR), "g/(h m^2)"),
        ("chi", found.scale, "1"),
        ("weight", times(found.weight, 1e3), "g"),
    ];
    let steepness = classes.iter().zip(&found.steepness);
    constants.extend(steepness.map(|(name, kappa)| (name.as_str(), *kappa, "1")));
    constants
}

/// Returns names, values and units of the other minima, one after the other.
fn others<'a>(found: &Fit, classes: &'a [String]) -> Vec<Vec<(&'a str, f64, &'static str)>> {
    let water = found.other_water.iter().map(|other| {
        vec![
            ("delta", other.loss / GRAM_PER_HOUR, "g/(h m^2)"),
            ("chi", other.scale, "1"),
            ("weight", 1e3 * other.weight, "g"),
        ]
    });
    let steepness = found.other_steepness.iter().map(|other| {
        classes.iter().zip(&other.steepness).map(|(name, k)| (name.as_str(), *k, "1")).collect()
    });
    water.chain(steepness).collect()
}

/// Returns the measurements beside the model, as CSV.
fn table(measured: &Measurements, found: &Fit) -> String {
    let has_heights = !measured.heights.is_empty();
    let mut text = "time_h,weight_g,model_g".to_string();
    text += if has_heights { ",height_m,model_m" } else { "" };
    text.extend(measured.marks.iter().map(|mark| format!(",node_{0}_m,model_{0}_m", mark.node)));
    text.push('\n');
    for i in 0..measured.seconds.len() {
        let hours = measured.seconds[i] / 3600.0;
        text += &format!("{hours},{},{}", 1e3 * measured.weights[i], 1e3 * found.weights[i]);
        if has_heights {
            text += &format!(",{},{}", measured.heights[i], found.heights[i]);
        }
        for (mark, model) in measured.marks.iter().zip(&found.marks) {
            text += &format!(",{},{}", mark.heights[i], model[i]);
        }
        text.push('\n');
    }
    text
}

/// Draws weights between the lightest and the heaviest, and heights as fractions of the tallest.
fn chart(measured: &Measurements, found: &Fit) -> Chart {
    let heaviest = measured.weights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let lightest = measured.weights.iter().copied().fold(f64::INFINITY, f64::min);
    let hours: Vec<f64> = measured.seconds.iter().map(|s| s / 3600.0).collect();
    let weight = |w: f64| (w - lightest) / (heaviest - lightest);
    let marks = || measured.marks.iter().map(|mark| &mark.heights);
    let all = measured.heights.iter().chain(marks().flatten());
    let tallest = all.copied().fold(f64::MIN_POSITIVE, f64::max);
    let height = |h: f64| h / tallest;
    let curve = |name, color, line, values: &[f64], part: &dyn Fn(f64) -> f64| {
        let points = hours.iter().zip(values).map(|(h, x)| (*h, part(*x))).collect();
        Series { line, ..Series::curve(name, color, points) }
    };
    let (fitted, dashed) = (Line::Solid, Line::Dashed);
    let mut curves = vec![
        curve("weight, fitted", [0xea, 0x58, 0x0c], fitted, &found.weights, &weight),
        curve("weight, measured", [0x1d, 0x4e, 0xd8], dashed, &measured.weights, &weight),
    ];
    if !measured.heights.is_empty() {
        curves.push(curve("height, fitted", [0x16, 0xa3, 0x4a], fitted, &found.heights, &height));
        let heights = &measured.heights;
        curves.push(curve("height, measured", [0x11, 0x18, 0x27], dashed, heights, &height));
    }
    for (i, (model, heights)) in found.marks.iter().zip(marks()).enumerate() {
        let [of_model, of_plant] = match i {
            0 => ["marks, fitted", "marks, measured"],
            _ => [""; 2],
        };
        curves.push(curve(of_model, [0x86, 0xef, 0xac], fitted, model, &height));
        curves.push(curve(of_plant, [0x9c, 0xa3, 0xaf], dashed, heights, &height));
    }
    Chart::new(
        Axis::linear("hours").range(0.0, hours.last().copied().unwrap_or(1.0)),
        Axis::linear("weight above the least, and height, as parts").range(0.0, 1.05),
        curves,
    )
}
