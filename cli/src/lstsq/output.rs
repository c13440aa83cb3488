//! Prints and writes the results of `lstsq`.

use std::fmt::Write as _;
use std::io::Write as _;

use anyhow::Result;
use catamaran::io::{Array, Output, write_arrays};
use catamaran::solve::LeastSquares;

use crate::gram::SHOWN;
use crate::report::{head, report, row, shown, status};

/// A solution, and the names of its columns.
pub struct Solution {
    /// The solution.
    pub found: LeastSquares,
    /// Names of the n columns of A.
    pub columns: Vec<String>,
    /// Names of the k targets.
    pub targets: Vec<String>,
    /// Whether a constant was fitted.
    pub intercept: bool,
    /// Rows of A.
    pub rows: u64,
}

impl Solution {
    /// Prints the tables of coefficients, and a summary of all targets.
    pub fn print(&self) -> Result<()> {
        let found = &self.found;
        for q in 0..self.targets.len() {
            self.print_target(q)?;
        }
        let (rank, n, freedom) = (found.rank, self.columns.len(), found.degrees_of_freedom);
        report!("rows", count = self.rows; "{}", self.rows)?;
        report!("rank", rank = rank, columns = n; "{rank} of {n} columns")?;
        report!("freedom", degrees_of_freedom = freedom; "{freedom} degrees")?;
        report!("condition", condition = found.condition; "{:.3e}", found.condition)?;
        // Rounded down, to print no digit that is not there.
        let digits = (10.0 * found.digits).floor() / 10.0;
        report!("digits", digits = digits; "{digits:.1} correct digits of the coefficients")
    }

    fn print_target(&self, q: usize) -> Result<()> {
        let (found, target) = (&self.found, &self.targets[q]);
        let constant =
            self.intercept.then(|| ("intercept", found.intercepts[q], found.intercept_errors[q]));
        let coefficients = self.columns.iter().enumerate().map(|(j, name)| {
            (name.as_str(), found.coefficients[(j, q)], found.standard_errors[(j, q)])
        });
        let lines = constant.into_iter().chain(coefficients);
        let width = lines.clone().take(SHOWN).map(|line| line.0.chars().count()).max();
        let width = width.unwrap_or(0).max("column".len());
        if self.targets.len() > 1 {
            head(format_args!("{:12}{target}", "target"))?;
        }
        let [value, error, t] = ["coefficient", "standard error", "t"];
        head(format_args!("{:width$}  {value:>23}  {error:>14}  {t:>12}", "column"))?;
        for (name, value, error) in lines.clone().take(shown(SHOWN)) {
            let t = ratio(value, error);
            row!(
                "coefficient",
                target = target,
                column = name,
                value = value,
                standard_error = error,
                t = value / error;
                "{name:width$}  {value:>23.15e}  {error:>14.6e}  {t:>12}"
            )?;
        }
        let count = lines.count();
        if count > SHOWN {
            head(format_args!("... and {} more", count - SHOWN))?;
        }
        let about = if self.intercept { "" } else { " about zero" };
        let (r_squared, norm) = (found.r_squared[q], found.residual_norms[q]);
        report!(
            "r_squared": "R^2",
            target = target,
            r_squared = r_squared,
            about_zero = !self.intercept;
            "{r_squared:.15}{about}"
        )?;
        report!("residual", target = target, norm = norm; "norm {norm:.15e}")
    }

    /// Writes the solution as arrays, in the format that the name selects.
    pub fn write_arrays(&self, output: Output) -> Result<()> {
        let path = output.path().display().to_string();
        let found = &self.found;
        let freedom = [found.degrees_of_freedom as usize];
        let (x, low) = (found.coefficients.as_ref(), found.coefficients_low.as_ref());
        let mut arrays = vec![
            ("x", Array::Matrix(x)),
            ("x_low", Array::Matrix(low)),
            ("standard_error", Array::Matrix(found.standard_errors.as_ref())),
            ("residual_norm", Array::Vector(&found.residual_norms)),
            ("r_squared", Array::Vector(&found.r_squared)),
        ];
        if self.intercept {
            arrays.push(("intercept", Array::Vector(&found.intercepts)));
            arrays.push(("intercept_error", Array::Vector(&found.intercept_errors)));
        }
        let (rank, condition, digits) = ([found.rank], [found.condition], [found.digits]);
        arrays.extend([
            ("rank", Array::Indices(&rank)),
            ("dependent", Array::Indices(&found.dependent)),
            ("degrees_of_freedom", Array::Indices(&freedom)),
            ("condition", Array::Vector(&condition)),
            ("digits", Array::Vector(&digits)),
        ]);
        write_arrays(output, &arrays)?;
        status!("written", path = path; "{path}")
    }

    /// Writes the solution as JSON.
    pub fn write_json(&self, mut output: Output) -> Result<()> {
        let path = output.path().display().to_string();
        output.write_all(self.json().as_bytes()).map_err(|e| output.error(e))?;
        output.commit()?;
        status!("written", path = path; "{path}")
    }

    fn json(&self) -> String {
        let found = &self.found;
        let mut targets = Vec::with_capacity(self.targets.len());
        for (q, name) in self.targets.iter().enumerate() {
            let mut text = format!("    {{\n      \"name\": {},\n", quoted(name));
            let x = found.coefficients.col(q).iter().copied();
            let errors = found.standard_errors.col(q).iter().copied();
            let _ = writeln!(text, "      \"x\": {},", list(x.map(number)));
            let _ = writeln!(text, "      \"standard_error\": {},", list(errors.map(number)));
            if self.intercept {
                let (value, error) = (found.intercepts[q], found.intercept_errors[q]);
                let _ = writeln!(text, "      \"intercept\": {},", number(value));
                let _ = writeln!(text, "      \"intercept_error\": {},", number(error));
            }
            let _ = writeln!(text, "      \"r_squared\": {},", number(found.r_squared[q]));
            let norm = number(found.residual_norms[q]);
            let _ = write!(text, "      \"residual_norm\": {norm}\n    }}");
            targets.push(text);
        }
        format!(
            "{{\n  \"columns\": {},\n  \"targets\": [\n{}\n  ],\n  \"rows\": {},\n  \
             \"rank\": {},\n  \"dependent\": {},\n  \"degrees_of_freedom\": {},\n  \"condition\": {},\n  \
             \"digits\": {}\n}}\n",
            list(self.columns.iter().map(|name| quoted(name))),
            targets.join(",\n"),
            self.rows,
            found.rank,
            list(found.dependent.iter().map(usize::to_string)),
            found.degrees_of_freedom,
            number(found.condition),
            number(found.digits),
        )
    }
}

/// Formats a coefficient over its standard error; a dash if the quotient is not finite.
fn ratio(value: f64, error: f64) -> String {
    match value / error {
        t if !t.is_finite() => "-".into(),
        t if t.abs() < 1e6 => format!("{t:.3}"),
        t => format!("{t:.3e}"),
    }
}

fn list(items: impl Iterator<Item = String>) -> String {
    format!("[{}]", items.collect::<Vec<_>>().join(", "))
}

/// Formats a number so that it reads back as the same; `null` for NaN and infinities, which JSON
/// does not have.
fn number(value: f64) -> String {
    if value.is_finite() { format!("{value:?}") } else { "null".into() }
}

fn quoted(text: &str) -> String {
    let mut quoted = String::from('"');
    for c in text.chars() {
        match c {
            '"' | '\\' => quoted.extend(['\\', c]),
            c if c.is_control() => {
                let _ = write!(quoted, "\\u{:04x}", u32::from(c));
            }
            c => quoted.push(c),
        }
    }
    quoted + "\""
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_and_numbers_are_json() {
        assert_eq!(quoted("a \"b\" \\ \t"), "\"a \\\"b\\\" \\\\ \\u0009\"");
        assert_eq!([number(0.1), number(f64::NAN), number(1e300)], ["0.1", "null", "1e300"]);
        assert_eq!([ratio(1.0, 0.0), ratio(3.0, -2.0)], ["-", "-1.500"]);
    }
}
