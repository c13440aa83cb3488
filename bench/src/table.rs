//! Outcomes of a race as rows of the table on the screen and of the record.

use crate::input::Shape;
use crate::product::Operation;
use crate::race::Outcome;

/// One contender at one shape, type and thread count.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Shape of A.
    pub shape: Shape,
    /// `f32` or `f64`.
    pub scalar: &'static str,
    /// Threads.
    pub threads: usize,
    /// Name of the contender.
    pub contender: String,
    /// Repetitions measured.
    pub repetitions: usize,
    /// Median seconds of a call.
    pub seconds: f64,
    /// Seconds of the fastest repetition.
    pub best: f64,
    /// Effective speed: the operations of the classical algorithm over the median seconds.
    pub gflops: f64,
    /// Speed relative to the reference contender; the median of paired ratios.
    pub ratio: f64,
    /// Ratio of the fastest time of the reference contender to that of this one.
    pub best_ratio: f64,
    /// Largest error, relative to the largest norms of columns of A and B.
    pub error: f64,
    /// Error over that of the reference contender.
    pub error_ratio: f64,
}

/// The column names of the record.
pub const CSV_HEADER: &str = "m,n,type,threads,contender,repetitions,median_s,best_s,gflops,ratio,best_ratio,error,error_ratio";

/// Returns the column names on the screen.
pub fn header() -> String {
    format!(
        "{:>8} {:>6} {:>4} {:>2}  {:<24} {:>4} {:>10} {:>8} {:>6} {:>6} {:>9} {:>6}",
        "m",
        "n",
        "type",
        "th",
        "contender",
        "reps",
        "median s",
        "GFLOP/s",
        "ratio",
        "best",
        "error",
        "err/y"
    )
}

/// Returns the rows of one race; `yardstick` is the index of the contender to which ratios refer.
pub fn rows(
    outcomes: &[Outcome],
    operation: Operation,
    shape: Shape,
    scalar: &'static str,
    threads: usize,
    yardstick: usize,
) -> Vec<Row> {
    let yardstick = &outcomes[yardstick];
    outcomes
        .iter()
        .map(|o| Row {
            shape,
            scalar,
            threads,
            contender: o.contender.clone(),
            repetitions: o.seconds.len(),
            seconds: o.median(),
            best: o.best(),
            gflops: operation.flops(shape) / o.median() / 1e9,
            ratio: o.ratio_to(yardstick),
            best_ratio: yardstick.best() / o.best(),
            error: o.error,
            error_ratio: o.error / yardstick.error,
        })
        .collect()
}

impl Row {
    /// Returns a line of the record.
    pub fn csv(&self) -> String {
        let Self { shape: Shape { m, n }, scalar, threads, contender, repetitions, .. } = self;
        format!(
            "{m},{n},{scalar},{threads},{contender},{repetitions},\
             {:.6e},{:.6e},{:.2},{:.4},{:.4},{:.3e},{:.3}",
            self.seconds,
            self.best,
            self.gflops,
            self.ratio,
            self.best_ratio,
            self.error,
            self.error_ratio
        )
    }
}

impl std::fmt::Display for Row {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { shape: Shape { m, n }, scalar, threads, contender, repetitions, .. } = self;
        write!(
            f,
            "{m:>8} {n:>6} {scalar:>4} {threads:>2}  {contender:<24} {repetitions:>4} {:>10.6} \
             {:>8.1} {:>6.3} {:>6.3} {:>9.2e} {:>6.2}",
            self.seconds, self.gflops, self.ratio, self.best_ratio, self.error, self.error_ratio
        )
    }
}
