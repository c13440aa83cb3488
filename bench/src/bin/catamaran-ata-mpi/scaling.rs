//! `--scaling`: the product on 1, 2, 4, ... ranks of the job, once of the same size (strong) and
//! once with as many rows for each rank (weak).

use std::fmt;

use catamaran::ranks::{MpiReal, World};
use catamaran_bench::Result;
use catamaran_bench::curves::{Plot, svg};
use catamaran_bench::input::Shape;
use catamaran_bench::race::median;
use mpi::topology::{Color, SimpleCommunicator};
use mpi::traits::Communicator;

use crate::arguments::Arguments;
use crate::job::Job;
use crate::ours::Ours;
use crate::ranks::Ranks;

/// The column names of the table.
pub const HEADER: &str = "kind,mode,ranks,threads,m,n,type,seconds,gflops,speedup,efficiency";

/// The kinds of scaling: the same rows on all numbers of ranks, or as many rows for each rank.
const KINDS: [&str; 2] = ["strong", "weak"];

/// One product on some of the ranks.
pub struct Point {
    kind: &'static str,
    job: Job,
    ranks: usize,
    scalar: &'static str,
    /// Seconds of wall time, the median of the repetitions.
    seconds: f64,
    /// Speed over that of one rank.
    speedup: f64,
}

impl Point {
    /// Returns the effective speed in GFLOP/s.
    fn gflops(&self) -> f64 {
        self.job.flops() / self.seconds / 1e9
    }

    /// Returns the speedup over the number of ranks.
    fn efficiency(&self) -> f64 {
        self.speedup / self.ranks as f64
    }

    /// Returns the line of the table.
    pub fn csv(&self) -> String {
        let Self { kind, job, ranks, scalar, seconds, speedup } = self;
        let Job { shape: Shape { m, n }, threads, .. } = *job;
        let (way, gflops, efficiency) = (job.way(), self.gflops(), self.efficiency());
        format!(
            "{kind},{way},{ranks},{threads},{m},{n},{scalar},{seconds:.6e},{gflops:.2},\
             {speedup:.4},{efficiency:.4}"
        )
    }
}

impl fmt::Display for Point {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { kind, job, ranks, seconds, speedup, .. } = self;
        let Shape { m, n } = job.shape;
        let (gflops, percent) = (self.gflops(), 100.0 * self.efficiency());
        write!(
            f,
            "{kind:<8}{ranks:>6} {m:>10} {n:>8} {seconds:>11.6} {gflops:>9.1} {speedup:>8.2} \
             {percent:>12.1}"
        )
    }
}

/// The column names of the lines on the screen.
pub const TITLE: &str =
    "scaling  ranks          m        n      time s   GFLOP/s  speedup  efficiency %";

/// Measures all products, and calls `tell` for each. Of a file, weak scaling takes the first rows.
/// All ranks call this function, and those that have no part in a product wait for its end.
///
/// # Errors
/// On all ranks if any rank has an error.
pub fn measure<T: MpiReal>(
    arguments: &Arguments,
    job: Job,
    ranks: &Ranks<'_>,
    scalar: &'static str,
    tell: impl Fn(&Point),
) -> Result<Vec<Point>> {
    let mut points = Vec::<Point>::new();
    for count in counts(ranks.count()) {
        let takes_part = ranks.own() < count;
        let part = ranks.0.split_by_color(Color::with_value(i32::from(takes_part)));
        for kind in KINDS {
            let job = Job { shape: shape(kind, job.shape, count, ranks.count()), ..job };
            let own = match part.as_ref().filter(|_| takes_part) {
                Some(part) => seconds::<T>(arguments, job, part),
                None => Ok(0.0),
            };
            let seconds = ranks.largest(ranks.agree(own)?);
            let mut point = Point { kind, job, ranks: count, scalar, seconds, speedup: 1.0 };
            if let Some(first) = points.iter().find(|first| first.kind == kind) {
                point.speedup = point.gflops() / first.gflops();
            }
            tell(&point);
            points.push(point);
        }
    }
    Ok(points)
}

/// Returns the powers of two below the number of all ranks, and that number.
fn counts(all: usize) -> Vec<usize> {
    let powers = std::iter::successors(Some(1), |power| Some(2 * power));
    powers.take_while(|&power| power < all).chain([all]).collect()
}

/// Returns the shape on `count` of `all` ranks; all of them have the whole `shape` in both kinds.
fn shape(kind: &str, shape: Shape, count: usize, all: usize) -> Shape {
    match kind {
        "weak" => Shape { m: (shape.m * count).div_ceil(all), ..shape },
        _ => shape,
    }
}

/// Returns the median of the seconds of the product on the ranks of `part`.
fn seconds<T: MpiReal>(arguments: &Arguments, job: Job, part: &SimpleCommunicator) -> Result<f64> {
    let ranks = Ranks(part);
    let world = World::new(part)?;
    let mut ours = ranks.agree(Ours::<T>::new(&world, job, arguments.file.as_deref()))?;
    // The first run includes the creation of threads and buffers.
    ours.run()?;
    let mut all = Vec::new();
    for _ in 0..arguments.repeat {
        ours.forget();
        let (wall, done) = ranks.time(|| ours.run());
        done?;
        all.push(ranks.largest(wall));
    }
    Ok(median(all))
}

/// Draws the speedup and the efficiency over the number of ranks.
pub fn picture(points: &[Point]) -> String {
    let ideal = points.iter().filter(|point| point.kind == KINDS[0]);
    let ideal = ideal.map(|point| (point.ranks as f64, point.ranks as f64)).collect();
    let mut speedup = curves(points, |point| point.speedup);
    speedup.push(("ideal".to_owned(), ideal));
    let efficiency = curves(points, |point| 100.0 * point.efficiency());
    let panels = [("speed over one rank", speedup), ("efficiency, %", efficiency)];
    svg(&panels.map(|(title, series)| Plot {
        title: title.into(),
        across: "ranks".into(),
        logarithmic: false,
        scattered: false,
        series,
    }))
}

/// Returns a curve of values over the number of ranks for each kind.
fn curves(points: &[Point], value: impl Fn(&Point) -> f64) -> Vec<(String, Vec<(f64, f64)>)> {
    let curve = |kind: &'static str| {
        let own = points.iter().filter(|point| point.kind == kind);
        (kind.to_owned(), own.map(|point| (point.ranks as f64, value(point))).collect())
    };
    KINDS.map(curve).to_vec()
}

#[cfg(test)]
mod tests {
    use catamaran::SchemeChoice;
    use catamaran::ranks::plan::Mode;

    use super::*;

    fn point(kind: &'static str, ranks: usize, m: usize, seconds: f64, speedup: f64) -> Point {
        let shape = Shape { m, n: 100 };
        let (mode, scheme) = (Mode::Rows, SchemeChoice::Auto);
        let job = Job { mode, shape, seed: 1, threads: 2, scheme };
        Point { kind, job, ranks, scalar: "f64", seconds, speedup }
    }

    #[test]
    fn powers_of_two_and_all_ranks_are_measured() {
        assert_eq!(counts(1), [1]);
        assert_eq!(counts(4), [1, 2, 4]);
        assert_eq!(counts(6), [1, 2, 4, 6]);
    }

    #[test]
    fn weak_scaling_ends_with_the_product_of_strong_scaling() {
        let whole = Shape { m: 1000, n: 7 };
        assert_eq!(shape("strong", whole, 2, 3), whole);
        assert_eq!(shape("weak", whole, 1, 3), Shape { m: 334, n: 7 });
        assert_eq!(shape("weak", whole, 3, 3), whole);
    }

    #[test]
    fn a_line_has_a_field_for_every_column() {
        let line = point("strong", 4, 1000, 0.5, 3.0).csv();
        assert_eq!(line, "strong,rows,4,2,1000,100,f64,5.000000e-1,0.02,3.0000,0.7500");
        assert_eq!(line.split(',').count(), HEADER.split(',').count());
    }

    #[test]
    fn the_picture_has_both_kinds_and_the_ideal() {
        let points = [
            point("strong", 1, 1000, 1.0, 1.0),
            point("weak", 1, 500, 0.5, 1.0),
            point("strong", 2, 1000, 0.6, 1.67),
            point("weak", 2, 1000, 0.6, 1.67),
        ];
        let picture = picture(&points);
        for text in ["speed over one rank", "efficiency, %", "strong", "weak", "ideal"] {
            assert!(picture.contains(&format!("\n{text}\n")), "{text}");
        }
    }

    #[test]
    fn the_guide_has_every_column() {
        let guide = include_str!("../../../../docs/guide/cluster.md");
        let missing = HEADER.split(',').find(|name| !guide.contains(&format!("`{name}`")));
        assert_eq!(missing, None);
    }
}
