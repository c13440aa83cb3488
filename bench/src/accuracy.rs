//! Errors of contenders, entry by entry, as rows of the table on the screen and of the record.

use crate::input::{Distribution, Shape};
use crate::reference::EntryError;

/// Errors over the lower triangle of a result.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Errors {
    /// The largest error.
    pub largest: f64,
    /// The mean error.
    pub mean: f64,
}

/// Summarizes a sample of the lower triangle of an n x n matrix. The diagonal and the rest enter
/// the mean each by its share of the triangle, whatever its share of the sample.
pub fn summarize(sample: &[EntryError], n: usize) -> Errors {
    let mean_of = |diagonal: bool| {
        let found = sample.iter().filter(|e| (e.row == e.column) == diagonal);
        let (sum, count) = found.fold((0.0, 0.0), |(sum, count), e| (sum + e.error, count + 1.0));
        if count == 0.0 { 0.0 } else { sum / count }
    };
    let rest = (n - 1) as f64 / 2.0;
    Errors {
        largest: sample.iter().map(|e| e.error).fold(0.0, f64::max),
        mean: (mean_of(true) + rest * mean_of(false)) / (1.0 + rest),
    }
}

/// One contender at one shape, type and distribution.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Shape of A.
    pub shape: Shape,
    /// `f32` or `f64`.
    pub scalar: &'static str,
    /// Distribution of the entries of A.
    pub distribution: Distribution,
    /// Name of the contender.
    pub contender: String,
    /// Errors of the contender.
    pub errors: Errors,
    /// Largest error over that of the reference contender.
    pub ratio: f64,
}

/// The column names of the record.
pub const CSV_HEADER: &str = "m,n,type,distribution,contender,max_error,mean_error,max_ratio";

/// Returns the column names on the screen.
pub fn header() -> String {
    format!(
        "{:>8} {:>6} {:>4} {:<12} {:<24} {:>9} {:>9} {:>7}",
        "m", "n", "type", "distribution", "contender", "max", "mean", "max/y"
    )
}

impl Row {
    /// Returns a line of the record.
    pub fn csv(&self) -> String {
        let Self { shape: Shape { m, n }, scalar, distribution, contender, errors, ratio } = self;
        format!(
            "{m},{n},{scalar},{distribution},{contender},{:.3e},{:.3e},{ratio:.3}",
            errors.largest, errors.mean
        )
    }
}

impl std::fmt::Display for Row {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { shape: Shape { m, n }, scalar, distribution, contender, errors, ratio } = self;
        write!(
            f,
            "{m:>8} {n:>6} {scalar:>4} {distribution:<12} {contender:<24} {:>9.2e} {:>9.2e} \
             {ratio:>7.3}",
            errors.largest, errors.mean
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn summary<const K: usize>(sample: [(usize, usize, f64); K], n: usize) -> Errors {
        summarize(&sample.map(|(row, column, error)| EntryError { row, column, error }), n)
    }

    #[test]
    fn the_mean_is_that_of_the_triangle() {
        let whole = [(0, 0, 4.0), (1, 0, 1.0), (1, 1, 7.0)];
        assert_eq!(summary(whole, 2), Errors { largest: 7.0, mean: 4.0 });
        // A diagonal that is sampled too often does not bias the mean.
        let sample = [(0, 0, 6.0), (1, 1, 6.0), (2, 2, 6.0), (2, 0, 2.0)];
        assert_eq!(summary(sample, 3), Errors { largest: 6.0, mean: 4.0 });
        assert_eq!(summary([(0, 0, 3.0)], 1), Errors { largest: 3.0, mean: 3.0 });
    }

    #[test]
    fn lines_have_the_columns_of_their_header() {
        let row = Row {
            shape: Shape { m: 30, n: 20 },
            scalar: "f64",
            distribution: Distribution::Graded,
            contender: "mkl".into(),
            errors: Errors { largest: 2e-16, mean: 1e-17 },
            ratio: 1.0,
        };
        assert_eq!(row.csv(), "30,20,f64,graded,mkl,2.000e-16,1.000e-17,1.000");
        assert_eq!(row.csv().split(',').count(), CSV_HEADER.split(',').count());
        assert_eq!(row.to_string().len(), header().len());
    }
}
