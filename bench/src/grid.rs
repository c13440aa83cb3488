//! The grid: many shapes of A, with this library against the best rival at each of them.

use std::fmt;

use catamaran::Plan;

use crate::input::Shape;
use crate::product::Operation;
use crate::race::Outcome;

/// The default grid: for each n the values of m. In f64 it should take about a quarter of an hour
/// with one and with two threads, on cores of 100 GFLOP/s: over half of the time is spent on the
/// five shapes of 1e11 operations and more. Some sides are no powers of two on purpose.
const GRID: [(usize, &[usize]); 24] = [
    (16, &[16, 128, 1024, 16_000, 160_000]),
    (32, &[2, 32, 320, 3200, 320_000]),
    (50, &[50, 500, 50_000]),
    (64, &[4, 16, 64, 256, 4096, 640_000]),
    (100, &[25, 100, 1000, 10_000, 1_000_000]),
    (128, &[8, 128, 512, 8192, 128_000]),
    (200, &[200, 2000, 200_000]),
    (256, &[16, 64, 256, 1024, 16_384, 256_000]),
    (333, &[111, 333, 3330]),
    (512, &[32, 128, 512, 2048, 32_768]),
    (768, &[192, 768, 7680]),
    (1000, &[1000, 10_000, 100_000]),
    (1024, &[64, 256, 1024, 4096]),
    (1500, &[400, 1500, 6000]),
    (2048, &[128, 512, 2048, 8192]),
    (2500, &[30_000]),
    (3000, &[750, 3000]),
    (4096, &[256, 1024, 4096]),
    (5000, &[500]),
    (6000, &[1500]),
    (8192, &[512, 8192]),
    (10_000, &[700]),
    (12_288, &[768]),
    (16_384, &[1024]),
];

/// Returns the shapes of the default grid.
pub fn shapes() -> Vec<Shape> {
    let of_n = |(n, rows): &(usize, &[usize])| {
        let n = *n;
        rows.iter().map(|&m| Shape { m, n }).collect::<Vec<_>>()
    };
    GRID.iter().flat_map(of_n).collect()
}

/// Ratio of times above which this library is behind: smaller differences are noise.
pub const BEHIND: f64 = 1.03;

/// One shape, type and thread count.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Shape of A.
    pub shape: Shape,
    /// `f32` or `f64`.
    pub scalar: &'static str,
    /// Threads.
    pub threads: usize,
    /// Repetitions measured.
    pub repetitions: usize,
    /// Median seconds of our calls.
    pub seconds: f64,
    /// Our effective speed: `m n^2 / seconds`.
    pub gflops: f64,
    /// The rival with the least median.
    pub rival: String,
    /// Its median seconds.
    pub rival_seconds: f64,
    /// Ratio of our time to the rival's; the median of paired ratios.
    pub ratio: f64,
    /// The scheme of our plan ([`catamaran::Plan::scheme`]).
    pub scheme: String,
    /// The instruction set of our kernels, or `-`.
    pub isa: String,
    /// Our largest error, relative to the largest norms of columns of A.
    pub error: f64,
    /// The rival's largest error.
    pub rival_error: f64,
}

/// The column names of the record.
pub const CSV_HEADER: &str = "m,n,type,threads,repetitions,median_s,gflops,rival,rival_median_s,time_ratio,scheme,isa,error,rival_error";

/// Returns the column names on the screen.
pub fn header() -> String {
    format!(
        "{:>8} {:>6} {:>4} {:>2} {:>4} {:>10} {:>8}  {:<16} {:>10} {:>6}  {:<20} {:<8} {:>9} {:>9}",
        "m",
        "n",
        "type",
        "th",
        "reps",
        "median s",
        "GFLOP/s",
        "best rival",
        "median s",
        "ratio",
        "scheme",
        "isa",
        "error",
        "rival's"
    )
}

/// Returns the rival with the least median among those that were not dropped.
pub fn best_rival(outcomes: &[Outcome]) -> Option<&Outcome> {
    let rivals = || outcomes.iter().filter(|o| o.is_rival && !o.seconds.is_empty());
    let most = rivals().map(|o| o.seconds.len()).max()?;
    rivals().filter(|o| o.seconds.len() == most).min_by(|x, y| x.median().total_cmp(&y.median()))
}

/// Returns the row of one race, in which ours followed this plan; `None` when ours or all rivals
/// were not measured.
pub fn row(
    outcomes: &[Outcome],
    plan: Option<&Plan>,
    shape: Shape,
    scalar: &'static str,
    threads: usize,
) -> Option<Row> {
    let rival = best_rival(outcomes)?;
    let ours = outcomes.iter().find(|o| !o.is_rival)?;
    Some(Row {
        shape,
        scalar,
        threads,
        repetitions: ours.seconds.len(),
        seconds: ours.median(),
        gflops: Operation::Syrk.flops(shape) / ours.median() / 1e9,
        rival: rival.contender.clone(),
        rival_seconds: rival.median(),
        ratio: rival.ratio_to(ours),
        scheme: plan.map_or("-".into(), Plan::scheme),
        isa: plan.and_then(Plan::isa).unwrap_or("-").into(),
        error: ours.error,
        rival_error: rival.error,
    })
}

impl Row {
    /// Returns a line of the record.
    pub fn csv(&self) -> String {
        let Self { shape: Shape { m, n }, scalar, threads, repetitions, .. } = self;
        let Self { rival, scheme, isa, .. } = self;
        format!(
            "{m},{n},{scalar},{threads},{repetitions},{:.4e},{:.2},{rival},{:.4e},{:.4},{scheme},{isa},\
             {:.3e},{:.3e}",
            self.seconds, self.gflops, self.rival_seconds, self.ratio, self.error, self.rival_error
        )
    }
}

impl fmt::Display for Row {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { shape: Shape { m, n }, scalar, threads, repetitions, .. } = self;
        let Self { rival, scheme, isa, .. } = self;
        write!(
            f,
            "{m:>8} {n:>6} {scalar:>4} {threads:>2} {repetitions:>4} {:>10.3e} {:>8.1}  \
             {rival:<16} {:>10.3e} {:>6.3}  {scheme:<20} {isa:<8} {:>9.2e} {:>9.2e}",
            self.seconds, self.gflops, self.rival_seconds, self.ratio, self.error, self.rival_error
        )
    }
}

/// A summary of many rows.
#[derive(Debug, Clone, PartialEq)]
pub struct Summary {
    /// Number of rows.
    pub rows: usize,
    /// Geometric mean of the time ratios.
    pub mean: f64,
    /// The largest time ratio.
    pub worst: f64,
    /// The shape of the largest ratio.
    pub worst_shape: Shape,
    /// Rows above [`BEHIND`].
    pub behind: usize,
}

/// Summarizes rows; returns `None` without rows.
pub fn summarize<'a>(rows: impl IntoIterator<Item = &'a Row>) -> Option<Summary> {
    let rows: Vec<_> = rows.into_iter().collect();
    let worst = rows.iter().max_by(|x, y| x.ratio.total_cmp(&y.ratio))?;
    let logarithms: f64 = rows.iter().map(|r| r.ratio.ln()).sum();
    Some(Summary {
        rows: rows.len(),
        mean: (logarithms / rows.len() as f64).exp(),
        worst: worst.ratio,
        worst_shape: worst.shape,
        behind: rows.iter().filter(|r| r.ratio > BEHIND).count(),
    })
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { rows, mean, worst, worst_shape, behind } = self;
        write!(
            f,
            "geometric mean {mean:.3}, worst {worst:.3} ({worst_shape}), {behind} of {rows} shapes \
             above {BEHIND}"
        )
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    pub(crate) fn example(shape: Shape, threads: usize, ratio: f64) -> Row {
        Row {
            shape,
            scalar: "f64",
            threads,
            repetitions: 5,
            seconds: 2e-6,
            gflops: 60.0,
            rival: "openblas gemm".into(),
            rival_seconds: 1e-6,
            ratio,
            scheme: "kgp4 + strassen".into(),
            isa: "avx512".into(),
            error: 1e-16,
            rival_error: 2e-16,
        }
    }

    fn outcome(contender: &str, seconds: &[f64]) -> Outcome {
        Outcome {
            contender: contender.into(),
            is_rival: contender != "ours",
            seconds: seconds.into(),
            error: 1e-16,
        }
    }

    #[test]
    fn the_grid_is_wide_and_affordable() {
        let shapes = shapes();
        assert!(shapes.len() >= 60, "{}", shapes.len());
        for (i, shape) in shapes.iter().enumerate() {
            let Shape { m, n } = *shape;
            assert!((16..=16_384).contains(&n), "{shape}");
            assert!(16 * m >= n && m <= 10_000 * n, "{shape}");
            assert!(8 * m * n <= 1_500_000_000, "{shape}: A is too large");
            assert!(Operation::Syrk.flops(*shape) <= 6e11, "{shape}: takes too long");
            assert!(!shapes[..i].contains(shape), "{shape} twice");
        }
        assert!(shapes.contains(&Shape { m: 1_000_000, n: 100 }));
        let work: f64 = shapes.iter().map(|s| Operation::Syrk.flops(*s)).sum();
        assert!(work < 2e12, "{work:e}");
    }

    #[test]
    fn the_best_rival_has_the_least_median_and_was_never_dropped() {
        let ours = outcome("ours", &[1.0, 1.0, 1.0]);
        let outcomes = [
            outcome("lucky once", &[1.5, 4.0, 4.0]),
            outcome("best", &[2.0, 2.0, 3.0]),
            outcome("dropped", &[1.9]),
            ours.clone(),
        ];
        assert_eq!(best_rival(&outcomes).unwrap().contender, "best");
        let row = row(&outcomes, None, Shape { m: 1000, n: 1000 }, "f64", 1).unwrap();
        assert_eq!((row.rival.as_str(), row.seconds, row.rival_seconds), ("best", 1.0, 2.0));
        assert_eq!((row.ratio, row.gflops), (0.5, 1.0));
        assert_eq!(best_rival(&[ours, outcome("late", &[])]), None);
    }

    #[test]
    fn ratios_have_a_geometric_mean_and_a_worst() {
        let shapes = [16, 32, 64].map(|n| Shape { m: n, n });
        let rows = [(0, 0.5), (1, 4.0), (2, 0.5)].map(|(i, r)| example(shapes[i], 1, r));
        let summary = summarize(&rows).unwrap();
        assert!((summary.mean - 1.0).abs() < 1e-15);
        assert_eq!((summary.rows, summary.worst, summary.behind), (3, 4.0, 1));
        assert_eq!(summary.worst_shape, shapes[1]);
        assert_eq!(summarize([]), None);
    }

    #[test]
    fn lines_have_the_columns_of_their_header() {
        let row = example(Shape { m: 64, n: 16 }, 2, 1.25);
        assert_eq!(
            row.csv(),
            "64,16,f64,2,5,2.0000e-6,60.00,openblas gemm,1.0000e-6,1.2500,\
             kgp4 + strassen,avx512,1.000e-16,2.000e-16"
        );
        assert_eq!(row.csv().split(',').count(), CSV_HEADER.split(',').count());
        assert_eq!(row.to_string().len(), header().len());
    }
}
