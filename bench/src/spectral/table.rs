//! Tables of errors: a row for each function, a column for each method, beside those of the thesis.

use super::signals::NAMES;

/// A table of the thesis, and ours.
#[derive(Debug, Clone)]
pub struct Table {
    /// Its number in the thesis.
    pub number: &'static str,
    /// What was done to what.
    pub title: String,
    /// The methods.
    pub columns: &'static [&'static str],
    /// Our errors, a row for each of the functions.
    pub ours: Vec<Vec<f64>>,
    /// Those of the thesis, in per cent; NaN where it has none.
    pub thesis: Vec<Vec<f64>>,
}

impl Table {
    /// As text in Markdown: ours, with the thesis' in brackets, in per cent.
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
        out
    }

    /// Lines of a record: table, function, method, our error, the thesis'.
    pub fn lines(&self) -> Vec<String> {
        let mut lines = Vec::new();
        for (f, name) in NAMES.iter().enumerate() {
            for (c, column) in self.columns.iter().enumerate() {
                let (ours, thesis) = (self.ours[f][c], self.thesis[f][c] / 100.0);
                let thesis = if thesis.is_nan() { String::new() } else { format!("{thesis:.4}") };
                lines.push(format!("{},{name},{column},{ours:.4},{thesis}", self.number));
            }
        }
        lines
    }
}

/// The means of the same entries.
pub fn average(tables: &[Vec<Vec<f64>>]) -> Vec<Vec<f64>> {
    let count = tables.len() as f64;
    let Some(first) = tables.first() else { return Vec::new() };
    let mean = |f: usize, c: usize| tables.iter().map(|table| table[f][c]).sum::<f64>() / count;
    (0..first.len()).map(|f| (0..first[f].len()).map(|c| mean(f, c)).collect()).collect()
}

/// The mean of relative errors of several functions; those of functions that are zero don't count.
pub fn mean(errors: &[f64]) -> f64 {
    let finite: Vec<_> = errors.iter().copied().filter(|e| e.is_finite()).collect();
    finite.iter().sum::<f64>() / finite.len().max(1) as f64
}
