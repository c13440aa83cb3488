//! Prints and writes the results of `lstsq`.

use std::fmt::Write as _;
use std::io::Write as _;

use anyhow::Result;
use catamaran::faer::Mat;
use catamaran::io::{Array, Output, write_arrays};
use catamaran::solve::LeastSquares;

use super::design::Term;
use super::names::Place;
use crate::gram::SHOWN;
use crate::report::{head, report, row, shown, status};

/// A solution, and the names of its columns.
pub struct Solution {
    /// The solution.
    pub found: LeastSquares,
    /// Names of the n columns of A.
    pub columns: Vec<String>,
    /// The columns of A.
    pub terms: Vec<Term>,
    /// Names of the k targets.
    pub targets: Vec<String>,
    /// Whether a constant was fitted.
    pub intercept: bool,
    /// Rows of A that were used.
    pub rows: u64,
    /// Rows of A that were left out.
    pub dropped: u64,
    /// The confidence of intervals, if there are any.
    pub confidence: Option<f64>,
    /// Whether the covariance of the coefficients is written.
    pub covariance: bool,
}

/// Numbers for each coefficient: intercepts (k, or none) and those of columns (n x k).
struct Numbers {
    intercepts: Vec<f64>,
    columns: Mat<f64>,
}

impl Numbers {
    /// Returns the numbers of a target, that of the intercept first.
    fn of(&self, q: usize) -> impl Iterator<Item = f64> + '_ {
        self.intercepts.get(q).into_iter().chain(self.columns.col(q).iter()).copied()
    }
}

/// The statistics of a solution, by the names of their arrays.
struct Statistics {
    t: Numbers,
    p: Numbers,
    /// Lower and upper ends, with a confidence.
    ends: Option<[Numbers; 2]>,
}

impl Statistics {
    fn new(found: &LeastSquares, confidence: Option<f64>) -> Result<Self> {
        let ends = |confidence| -> Result<_> {
            let own = found.intercept_intervals(confidence)?;
            let [lower, upper] = found.confidence_intervals(confidence)?;
            let end = |which: usize, columns| Numbers {
                intercepts: own.iter().map(|ends| ends[which]).collect(),
                columns,
            };
            Ok([end(0, lower), end(1, upper)])
        };
        Ok(Self {
            t: Numbers {
                intercepts: found.intercept_t_statistics(),
                columns: found.t_statistics()?,
            },
            p: Numbers { intercepts: found.intercept_p_values(), columns: found.p_values()? },
            ends: confidence.map(ends).transpose()?,
        })
    }

    /// Returns the names of the numbers, and the numbers.
    fn named(&self) -> Vec<(&'static str, &Numbers)> {
        let mut named = vec![("t", &self.t), ("p", &self.p)];
        if let Some([lower, upper]) = &self.ends {
            named.extend([("lower", lower), ("upper", upper)]);
        }
        named
    }
}

impl Solution {
    /// Prints the tables of coefficients, and a summary of all targets.
    pub fn print(&self) -> Result<()> {
        let found = &self.found;
        let statistics = Statistics::new(found, self.confidence)?;
        for q in 0..self.targets.len() {
            self.print_target(q, &statistics)?;
        }
        let (rank, n, freedom) = (found.rank, self.columns.len(), found.degrees_of_freedom);
        let left_out = match self.dropped {
            0 => String::new(),
            dropped => format!(", {dropped} left out"),
        };
        report!("rows", count = self.rows, left_out = self.dropped; "{}{left_out}", self.rows)?;
        let observations = found.observations;
        if observations != self.rows {
            report!("observations": "weighted", count = observations; "{observations} rows")?;
        }
        report!("rank", rank = rank, columns = n; "{rank} of {n} columns")?;
        report!("freedom", degrees_of_freedom = freedom; "{freedom} degrees")?;
        report!("condition", condition = found.condition; "{:.3e}", found.condition)?;
        // Rounded down, to print no digit that is not there.
        let digits = (10.0 * found.digits).floor() / 10.0;
        report!("digits", digits = digits; "{digits:.1} correct digits of the coefficients")
    }

    fn print_target(&self, q: usize, statistics: &Statistics) -> Result<()> {
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
        let ends = statistics.ends.as_ref().map_or_else(Vec::new, |[lower, upper]| {
            lower.of(q).zip(upper.of(q)).map(|(lower, upper)| [lower, upper]).collect()
        });
        let [value, error, t, p] = ["coefficient", "standard error", "t", "p"];
        let interval = match ends.is_empty() {
            true => String::new(),
            false => format!("  {:>14}  {:>14}", "lower", "upper"),
        };
        head(format_args!(
            "{:width$}  {value:>23}  {error:>14}  {t:>12}  {p:>10}{interval}",
            "column"
        ))?;
        let tests = statistics.t.of(q).zip(statistics.p.of(q));
        for (i, (line, (t, p))) in lines.clone().zip(tests).take(shown(SHOWN)).enumerate() {
            let (name, value, error) = line;
            let interval = ends.get(i).map_or_else(String::new, |[lower, upper]| {
                format!("  {lower:>14.6e}  {upper:>14.6e}")
            });
            let (t_text, p_text) = (ratio(t), probability(p));
            row!(
                "coefficient",
                target = target,
                column = name,
                value = value,
                standard_error = error,
                t = t,
                p = p,
                lower = ends.get(i).map(|ends| ends[0]),
                upper = ends.get(i).map(|ends| ends[1]);
                "{name:width$}  {value:>23.15e}  {error:>14.6e}  {t_text:>12}  \
                 {p_text:>10}{interval}"
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
        let adjusted = found.adjusted_r_squared()[q];
        report!("adjusted", target = target, r_squared = adjusted; "{adjusted:.15}{about}")?;
        let (f, p) = (found.f_statistics[q], found.f_p_values()[q]);
        if !f.is_nan() {
            let (rank, freedom) = (found.rank, found.degrees_of_freedom);
            let (f_text, p_text) = (ratio(f), probability(p));
            report!(
                "f_statistic": "F",
                target = target,
                f = f,
                p = p;
                "{f_text} with {rank} and {freedom} degrees of freedom, p {p_text}"
            )?;
        }
        let deviation = found.residual_deviations()[q];
        report!("residual", target = target, norm = norm; "norm {norm:.15e}")?;
        report!("deviation", target = target, of_residual = deviation; "{deviation:.15e}")
    }

    /// Writes the solution as arrays, in the format that the name selects.
    pub fn write_arrays(&self, output: Output) -> Result<()> {
        let path = output.path().display().to_string();
        let found = &self.found;
        let statistics = Statistics::new(found, self.confidence)?;
        let freedom = [found.degrees_of_freedom as usize];
        let observations = [found.observations as usize];
        let (deviations, adjusted) = (found.residual_deviations(), found.adjusted_r_squared());
        let f_p = found.f_p_values();
        let covariance = self.stacked_covariance()?;
        let (x, low) = (found.coefficients.as_ref(), found.coefficients_low.as_ref());
        let mut arrays = vec![
            ("x", Array::Matrix(x)),
            ("x_low", Array::Matrix(low)),
            ("standard_error", Array::Matrix(found.standard_errors.as_ref())),
            ("residual_norm", Array::Vector(&found.residual_norms)),
            ("residual_deviation", Array::Vector(&deviations)),
            ("r_squared", Array::Vector(&found.r_squared)),
            ("adjusted_r_squared", Array::Vector(&adjusted)),
            ("f_statistic", Array::Vector(&found.f_statistics)),
            ("f_p", Array::Vector(&f_p)),
        ];
        for (name, numbers) in statistics.named() {
            arrays.push((name, Array::Matrix(numbers.columns.as_ref())));
        }
        if self.intercept {
            arrays.push(("intercept", Array::Vector(&found.intercepts)));
            arrays.push(("intercept_error", Array::Vector(&found.intercept_errors)));
            for (name, numbers) in statistics.named() {
                arrays.push((of_intercept(name), Array::Vector(&numbers.intercepts)));
            }
        }
        if let Some(covariance) = &covariance {
            arrays.push(("covariance", Array::Matrix(covariance.as_ref())));
        }
        let (rank, condition, digits) = ([found.rank], [found.condition], [found.digits]);
        arrays.extend([
            ("rank", Array::Indices(&rank)),
            ("dependent", Array::Indices(&found.dependent)),
            ("observations", Array::Indices(&observations)),
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
        output.write_all(self.json()?.as_bytes()).map_err(|e| output.error(e))?;
        output.commit()?;
        status!("written", path = path; "{path}")
    }

    /// Returns the covariances of all targets, one below the other, if they are wanted.
    fn stacked_covariance(&self) -> Result<Option<Mat<f64>>> {
        if !self.covariance {
            return Ok(None);
        }
        let size = self.columns.len() + usize::from(self.intercept);
        let mut all = Mat::zeros(size * self.targets.len(), size);
        for q in 0..self.targets.len() {
            let covariance = self.found.covariance(q)?;
            all.as_mut().subrows_mut(q * size, size).copy_from(&covariance);
        }
        Ok(Some(all))
    }

    fn json(&self) -> Result<String> {
        let found = &self.found;
        let statistics = Statistics::new(found, self.confidence)?;
        let mut targets = Vec::with_capacity(self.targets.len());
        for (q, name) in self.targets.iter().enumerate() {
            let mut text = format!("    {{\n      \"name\": {},\n", quoted(name));
            let mut line = |name: &str, value: String| {
                let _ = writeln!(text, "      \"{name}\": {value},");
            };
            for (name, matrix) in [
                ("x", &found.coefficients),
                ("x_low", &found.coefficients_low),
                ("standard_error", &found.standard_errors),
            ] {
                line(name, list(matrix.col(q).iter().copied().map(number)));
            }
            for (name, numbers) in statistics.named() {
                line(name, list(numbers.columns.col(q).iter().copied().map(number)));
            }
            if self.intercept {
                line("intercept", number(found.intercepts[q]));
                line("intercept_error", number(found.intercept_errors[q]));
                for (name, numbers) in statistics.named() {
                    line(of_intercept(name), number(numbers.intercepts[q]));
                }
            }
            if self.covariance {
                line("covariance", matrix(&found.covariance(q)?));
            }
            line("r_squared", number(found.r_squared[q]));
            line("adjusted_r_squared", number(found.adjusted_r_squared()[q]));
            line("f_statistic", number(found.f_statistics[q]));
            line("f_p", number(found.f_p_values()[q]));
            line("residual_deviation", number(found.residual_deviations()[q]));
            let norm = number(found.residual_norms[q]);
            let _ = write!(text, "      \"residual_norm\": {norm}\n    }}");
            targets.push(text);
        }
        let mut fields = vec![
            ("columns", list(self.columns.iter().map(|name| quoted(name)))),
            ("terms", list(self.terms.iter().map(term))),
            ("targets", format!("[\n{}\n  ]", targets.join(",\n"))),
            ("confidence", self.confidence.map_or("null".into(), number)),
            ("rows", self.rows.to_string()),
            ("left_out", self.dropped.to_string()),
            ("observations", found.observations.to_string()),
            ("rank", found.rank.to_string()),
            ("dependent", list(found.dependent.iter().map(usize::to_string))),
            ("degrees_of_freedom", found.degrees_of_freedom.to_string()),
            ("condition", number(found.condition)),
            ("digits", number(found.digits)),
        ];
        if let Some(uncertainty) = found.model().uncertainty.filter(|_| self.covariance) {
            fields.extend([
                ("root", matrix(&uncertainty.root.to_owned())),
                ("mean", list(uncertainty.mean.iter().copied().map(number))),
                // Infinite without an intercept.
                ("weight", number(uncertainty.weight)),
            ]);
        }
        let lines = fields.iter().map(|(name, value)| format!("  \"{name}\": {value}"));
        Ok(format!("{{\n{}\n}}\n", lines.collect::<Vec<_>>().join(",\n")))
    }
}

/// Returns the name of an array of intercepts.
fn of_intercept(name: &str) -> &'static str {
    match name {
        "t" => "intercept_t",
        "p" => "intercept_p",
        "lower" => "intercept_lower",
        _ => "intercept_upper",
    }
}

/// Returns a term as JSON.
fn term(term: &Term) -> String {
    let column = quoted(&term.column);
    let place = match term.place {
        Place::Name => String::new(),
        Place::Unnamed => ", \"name\": \"\"".into(),
        Place::Number(number) => format!(", \"number\": {number}"),
    };
    let levels = match term.levels.is_empty() {
        true => String::new(),
        false => {
            let levels = list(term.levels.iter().map(|level| quoted(level)));
            format!(", \"levels\": {levels}")
        }
    };
    format!("{{\"column\": {column}{place}{levels}}}")
}

/// Returns a matrix as JSON: a list of its rows.
fn matrix(matrix: &Mat<f64>) -> String {
    list(matrix.row_iter().map(|row| list(row.iter().copied().map(number))))
}

/// Formats a statistic; a dash if it is not finite.
fn ratio(statistic: f64) -> String {
    match statistic {
        t if !t.is_finite() => "-".into(),
        t if t.abs() < 1e6 => format!("{t:.3}"),
        t => format!("{t:.3e}"),
    }
}

/// Formats a p value; a dash if it is NaN.
fn probability(p: f64) -> String {
    match p {
        p if p.is_nan() => "-".into(),
        p if p >= 1e-3 || p == 0.0 => format!("{p:.4}"),
        p => format!("{p:.2e}"),
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
        assert_eq!([ratio(1.0 / 0.0), ratio(3.0 / -2.0)], ["-", "-1.500"]);
        assert_eq!([probability(f64::NAN), probability(0.0314159)], ["-", "0.0314"]);
        assert_eq!([probability(0.0), probability(1.1196e-6)], ["0.0000", "1.12e-6"]);
    }
}
