//! Tables of errors: a row for each function, a column for each method, with those of the thesis.

use super::prods::Sweep;
use super::signals::NAMES;

/// A table of the thesis, with our values.
#[derive(Debug, Clone)]
pub struct Table {
    /// Its number in the thesis.
    pub number: &'static str,
    /// The title.
    pub title: String,
    /// The methods.
    pub columns: Vec<&'static str>,
    /// Our errors, a row for each function.
    pub ours: Vec<Vec<f64>>,
    /// The errors of the thesis, in per cent; NaN for missing ones.
    pub thesis: Vec<Vec<f64>>,
    /// Errors of "prods" with other tolerances.
    pub sweep: Sweep,
}

/// Position at which "prods" and "best" are inserted: after "K".
const PRODS: usize = 1;

impl Table {
    /// Creates a table from errors whose last columns are those of "prods" by tolerance. `columns`
    /// and `thesis` do not include "best", the least of these errors, which is inserted after
    /// "prods".
    pub fn new(
        (number, title): (&'static str, String),
        columns: &[&'static str],
        mut errors: Vec<Vec<f64>>,
        thesis: impl Iterator<Item = Vec<f64>>,
        published: f64,
    ) -> Self {
        let sweep = Sweep::split(published, &mut errors);
        for (function, row) in errors.iter_mut().enumerate() {
            row.splice(PRODS..PRODS, [sweep.published(function), sweep.best(function)]);
        }
        let mut columns = columns.to_vec();
        columns.insert(PRODS + 1, "prods best");
        let with_best = |mut row: Vec<f64>| {
            row.insert(PRODS + 1, f64::NAN);
            row
        };
        let thesis = thesis.map(with_best).collect();
        Self { number, title, columns, ours: errors, thesis, sweep }
    }

    /// Returns the table as Markdown: ours, with the thesis' in brackets, in per cent; then "prods"
    /// by tolerance.
    pub fn markdown(&self) -> String {
        let mut out = format!("**Table {}**: {}\n\n|  | ", self.number, self.title);
        out += &self.columns.join(" | ");
        out += &format!(" |\n|{}\n", "---|".repeat(self.columns.len() + 1));
        for ((name, ours), thesis) in NAMES.iter().zip(&self.ours).zip(&self.thesis) {
            let cells: Vec<_> = (ours.iter().zip(thesis))
                .map(|(ours, thesis)| match thesis.is_nan() {
                    true => format!("{:.1}", 100.0 * ours),
                    false => format!("{:.1} [{thesis:.1}]", 100.0 * ours),
                })
                .collect();
            out += &format!("| {name} | {} |\n", cells.join(" | "));
        }
        out += &format!(
            "\n*prods* of table {} by tolerance, the published one first\n\n| tolerance | ",
            self.number
        );
        out += &NAMES.join(" | ");
        out += &format!(" |\n|{}\n", "---|".repeat(NAMES.len() + 1));
        for (tolerance, errors) in self.sweep.tolerances.iter().zip(&self.sweep.errors) {
            let cells: Vec<_> = errors.iter().map(|&error| per_cent(error)).collect();
            out += &format!("| {tolerance:.1e} | {} |\n", cells.join(" | "));
        }
        out
    }

    /// Returns the lines of a record: table, function, method, our error, the thesis'.
    pub fn lines(&self) -> Vec<String> {
        let mut lines = Vec::new();
        for (f, name) in NAMES.iter().enumerate() {
            for (c, column) in self.columns.iter().enumerate() {
                let (ours, thesis) = (self.ours[f][c], self.thesis[f][c] / 100.0);
                let thesis = if thesis.is_nan() { String::new() } else { format!("{thesis:.4}") };
                lines.push(format!("{},{name},{column},{ours:.4},{thesis}", self.number));
            }
            for (tolerance, errors) in self.sweep.tolerances.iter().zip(&self.sweep.errors) {
                let error = errors[f];
                lines.push(format!("{},{name},prods {tolerance:e},{error:.4},", self.number));
            }
        }
        lines
    }
}

/// Formats an error in per cent; errors beyond use are given by their power of ten.
fn per_cent(error: f64) -> String {
    let error = 100.0 * error;
    if error < 1e4 { format!("{error:.1}") } else { format!("{error:.0e}") }
}

/// Returns the means of the same entries.
pub fn average(tables: &[Vec<Vec<f64>>]) -> Vec<Vec<f64>> {
    let count = tables.len() as f64;
    let Some(first) = tables.first() else { return Vec::new() };
    let mean = |f: usize, c: usize| tables.iter().map(|table| table[f][c]).sum::<f64>() / count;
    (0..first.len()).map(|f| (0..first[f].len()).map(|c| mean(f, c)).collect()).collect()
}

/// Returns the mean of relative errors of several functions, without those of functions that are
/// zero.
pub fn mean(errors: &[f64]) -> f64 {
    let finite: Vec<_> = errors.iter().copied().filter(|e| e.is_finite()).collect();
    finite.iter().sum::<f64>() / finite.len().max(1) as f64
}
