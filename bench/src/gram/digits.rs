//! Correct digits of coefficients on the NIST data.

use std::path::Path;

use super::Turns;
use super::nist::NistSet;
use super::ours::Task;
use crate::Result;
use crate::exchange::{get_vector, put, put_vector};
use crate::plant::Part;

/// Methods of bench/rivals/gram.py.
const RIVALS: [&str; 6] = [
    "numpy-lstsq",
    "numpy-lstsq-rcond-0",
    "scipy-gelsy",
    "statsmodels-pinv",
    "statsmodels-qr",
    "numpy-normal-equations",
];

/// Digits of certified values.
const MOST: f64 = 15.0;

/// Returns the correct digits of the worst coefficient of each set, where all contenders get the
/// same columns in f64: against the certified values, and against the exact solution for these
/// columns.
///
/// # Errors
/// When a file can't be read or written, or no contender has a solution.
pub fn digits(turns: &Turns) -> Result<Vec<Part>> {
    let sets = NistSet::all()?;
    let folder = tempfile::tempdir()?;
    for set in &sets {
        put(folder.path(), &format!("{}-a", set.name), set.design.as_ref())?;
        put_vector(folder.path(), &format!("{}-b", set.name), &set.response)?;
    }
    let once = Turns { repeat: 1, ..turns.clone() };
    let names: Vec<_> =
        once.run(Task::Digits, folder.path(), &RIVALS)?.iter().map(|runs| runs.name).collect();
    let mut certified = part("digits", "of the certified values, at most 15", &names);
    let mut rounded = part("digits-f64", "of the exact solution for columns in f64", &names);
    certified.columns.push("exact solution for columns in f64".into());
    for set in &sets {
        let [mut of_certified, mut of_rounded] = [Vec::new(), Vec::new()];
        for name in &names {
            let x = solution(folder.path(), &set.name, name)?;
            of_certified.push(correct_digits(&x, &set.certified.coefficients));
            of_rounded.push(correct_digits(&x, &set.rounded.coefficients));
        }
        of_certified.push(correct_digits(&set.rounded.coefficients, &set.certified.coefficients));
        certified.rows.push((set.name.clone(), of_certified));
        rounded.rows.push((set.name.clone(), of_rounded));
    }
    Ok(vec![certified, rounded])
}

fn part(figure: &'static str, of: &str, names: &[&str]) -> Part {
    let title = format!("correct digits of the worst coefficient, {of}");
    let columns = names.iter().map(|name| (*name).to_owned()).collect();
    Part { figure, title, columns, ..Part::default() }
}

fn solution(folder: &Path, set: &str, method: &str) -> Result<Vec<f64>> {
    get_vector(folder, &format!("{set}-{method}"))
}

/// Returns `min -log10(|x - truth| / |truth|)` over the entries, at most 15; 0 where an entry is
/// not finite.
fn correct_digits(x: &[f64], truth: &[f64]) -> f64 {
    let of = |(x, truth): (&f64, &f64)| {
        let digits = -((x - truth) / truth).abs().log10();
        if digits.is_nan() { 0.0 } else { digits }
    };
    x.iter().zip(truth).map(of).fold(MOST, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_are_those_of_the_worst_entry() {
        assert_eq!(correct_digits(&[1.0, 2.0], &[1.0, 2.0]), 15.0);
        let digits = correct_digits(&[1.0, 2.002, 3.0], &[1.0, 2.0, 3.0 + 1e-9]);
        assert!((digits - 3.0).abs() < 1e-9, "{digits}");
        assert_eq!(correct_digits(&[1.0, f64::NAN], &[1.0, 2.0]), 0.0);
        assert_eq!(correct_digits(&[11.0], &[1.0]), -1.0);
    }

    #[test]
    fn sets_have_a_coefficient_for_each_column_and_a_response_for_each_row() {
        let sets = NistSet::all().unwrap();
        assert_eq!(sets.len(), 11);
        for set in sets {
            let columns = set.design.ncols();
            for solution in [&set.certified, &set.rounded] {
                assert_eq!(solution.coefficients.len(), columns, "{}", set.name);
                assert_eq!(solution.deviations.len(), columns, "{}", set.name);
            }
            assert_eq!(set.response.len(), set.design.nrows(), "{}", set.name);
            let limit = correct_digits(&set.rounded.coefficients, &set.certified.coefficients);
            let expected = if set.name == "filip" { 7.9 } else { 13.2 };
            assert!(limit > expected, "{}: {limit}", set.name);
        }
    }
}
