//! What is printed of C when no file is written.

use anyhow::Result;
use catamaran::Uplo;
use catamaran::blas::BlasReal;
use catamaran::faer::MatRef;

use crate::report::{report, row, status};

/// Most rows and columns of a matrix that is printed.
pub const PRINTED: usize = 10;

/// Prints C if it is small, or else what its entries are like.
pub fn show<T: BlasReal>(c: MatRef<'_, T>, uplo: Uplo) -> Result<()> {
    let (rows, n) = (c.nrows(), c.ncols());
    if n > PRINTED {
        summarize(c, uplo)?;
        return status!("hint", option = "-o"; "-o FILE writes all {n} x {n} entries");
    }
    for i in 0..rows {
        let entries: Vec<f64> = (0..n).map(|j| c[(i, j)].to_f64()).collect();
        let cells: Vec<String> = entries.iter().map(|&x| format!("{:>12}", digits(x))).collect();
        row!("row", number = i, entries = entries; "{}", cells.join(" "))?;
    }
    status!("hint", option = "-o"; "-o FILE writes all digits")
}

/// Prints the ranges of the entries on the diagonal and beside it, and the Frobenius norm of the
/// whole symmetric matrix.
fn summarize<T: BlasReal>(c: MatRef<'_, T>, uplo: Uplo) -> Result<()> {
    let (mut diagonal, mut others) = (Range::default(), Range::default());
    let mut norm = Norm::default();
    for j in 0..c.ncols() {
        let of_diagonal = c[(j, j)].to_f64();
        diagonal.add(of_diagonal);
        norm.add(of_diagonal, 1.0);
        for i in j + 1..c.ncols() {
            let entry = if uplo == Uplo::Upper { c[(j, i)] } else { c[(i, j)] }.to_f64();
            others.add(entry);
            norm.add(entry, 2.0);
        }
    }
    let Range { least, largest, missing } = diagonal;
    report!("diagonal", least = least, largest = largest, nan = missing; "{}", diagonal.text())?;
    let Range { least, largest, missing } = others;
    report!("others", least = least, largest = largest, nan = missing; "{}", others.text())?;
    let norm = norm.value();
    report!("norm", frobenius = norm; "{} (Frobenius)", digits(norm))
}

/// The range of some numbers.
struct Range {
    least: f64,
    largest: f64,
    /// The numbers that are NaN.
    missing: usize,
}

impl Default for Range {
    fn default() -> Self {
        Self { least: f64::INFINITY, largest: f64::NEG_INFINITY, missing: 0 }
    }
}

impl Range {
    fn add(&mut self, x: f64) {
        self.least = self.least.min(x);
        self.largest = self.largest.max(x);
        self.missing += usize::from(x.is_nan());
    }

    fn text(&self) -> String {
        let missing = match self.missing {
            0 => String::new(),
            count => format!(", {count} NaN"),
        };
        match self.least <= self.largest {
            true => format!("{} to {}{missing}", digits(self.least), digits(self.largest)),
            false => format!("no number{missing}"),
        }
    }
}

/// The root of a sum of squares, which may be out of range themselves.
#[derive(Default)]
struct Norm {
    scale: f64,
    sum: f64,
}

impl Norm {
    /// Adds a number, `times` times.
    fn add(&mut self, x: f64, times: f64) {
        let size = x.abs();
        if size == 0.0 {
            return;
        }
        if size > self.scale {
            self.sum *= (self.scale / size).powi(2);
            self.scale = size;
        }
        // Infinities and NaN stay what they are.
        self.sum += if size == self.scale { times } else { times * (size / self.scale).powi(2) };
    }

    fn value(&self) -> f64 {
        self.scale * self.sum.sqrt()
    }
}

/// Formats a number in six digits; whole numbers of up to nine digits are exact.
pub fn digits(x: f64) -> String {
    if x == x.trunc() && x.abs() < 1e9 {
        return format!("{}", x + 0.0);
    }
    match x.abs() {
        size if (1e-4..1e6).contains(&size) => {
            format!("{x:.*}", (5 - size.log10().floor() as i32).max(0) as usize)
        }
        size if size.is_finite() => format!("{x:.5e}"),
        _ => x.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_six_digits() {
        let cases = [
            (0.0, "0"),
            (-0.0, "0"),
            (14.0, "14"),
            (-123_456_789.0, "-123456789"),
            (1.0 / 3.0, "0.333333"),
            (1234.5678, "1234.57"),
            (123_456.7, "123457"),
            (1.5e9, "1.50000e9"),
            (-1.25e-7, "-1.25000e-7"),
            (f64::NAN, "NaN"),
            (f64::NEG_INFINITY, "-inf"),
        ];
        for (x, text) in cases {
            assert_eq!(digits(x), text);
        }
    }

    #[test]
    fn norms_and_ranges_of_any_size() {
        let norm = |entries: &[f64]| {
            let mut norm = Norm::default();
            entries.iter().for_each(|&x| norm.add(x, 1.0));
            norm.value()
        };
        assert_eq!(norm(&[3.0, -4.0]), 5.0);
        assert_eq!(norm(&[]), 0.0);
        assert!((norm(&[3e200, 0.0, 4e200]) / 5e200 - 1.0).abs() < 1e-15);
        assert!((norm(&[4e-200, 3e-200]) / 5e-200 - 1.0).abs() < 1e-15);
        assert!(norm(&[1.0, f64::NAN, 2.0]).is_nan());
        assert_eq!(norm(&[1.0, f64::INFINITY, 1.0, f64::NEG_INFINITY]), f64::INFINITY);
        let mut range = Range::default();
        assert_eq!(range.text(), "no number");
        [2.0, f64::NAN, -1.0].into_iter().for_each(|x| range.add(x));
        assert_eq!(range.text(), "-1 to 2, 1 NaN");
    }
}
