//! The result of one figure.

use crate::curves::Plot;

/// A table, and curves.
#[derive(Debug, Clone, Default)]
pub struct Part {
    /// The figure of the thesis, or `race`.
    pub figure: &'static str,
    /// The title.
    pub title: String,
    /// Names of the columns of numbers.
    pub columns: Vec<String>,
    /// A name and numbers; NaN for missing ones.
    pub rows: Vec<(String, Vec<f64>)>,
    /// Curves.
    pub plots: Vec<Plot>,
}

impl Part {
    /// Returns the part as Markdown.
    pub fn markdown(&self) -> String {
        let mut out = format!("**{}**: {}\n\n| | ", self.figure, self.title);
        out += &self.columns.join(" | ");
        out += &format!(" |\n|{}\n", "---|".repeat(self.columns.len() + 1));
        for (name, values) in &self.rows {
            let cells: Vec<_> = values.iter().map(|x| number(*x)).collect();
            out += &format!("| {name} | {} |\n", cells.join(" | "));
        }
        out
    }

    /// Returns the lines of a record.
    pub fn lines(&self) -> Vec<String> {
        let mut lines = Vec::new();
        for (name, values) in &self.rows {
            for (column, value) in self.columns.iter().zip(values).filter(|(_, x)| !x.is_nan()) {
                let [name, column] = [name, column].map(|text| text.replace(',', ";"));
                lines.push(format!("{},{name},{column},{value:.6e}", self.figure));
            }
        }
        lines
    }
}

fn number(x: f64) -> String {
    match x.abs() {
        _ if x.is_nan() => String::new(),
        0.0 => "0".into(),
        size if (1e-2..1e5).contains(&size) => format!("{x:.4}"),
        _ => format!("{x:.2e}"),
    }
}
