//! The station of the exact path: the same bytes in whatever order, and errors beside the classical
//! ones.

use std::thread;
use std::time::Instant;

use anyhow::{Context as _, Result};
use catamaran::base::{Rng, available_cores, triangle_len};
use catamaran::blas;
use catamaran::faer::{Mat, MatRef};
use catamaran::kernel::int8::IntegerIsa;
use catamaran::{Accuracy, AtaOptions, Par, SchemeChoice};
use catamaran_charts::{Bar as ChartBar, bars as draw_bars};
use minijinja::context;
use minijinja::value::Value;

use super::page::Station;
use super::{OTHERS, OWN, Site, ata};
use crate::picture;
use crate::progress::{self, Bar};

/// Samples in time, and sensors.
const SIDE: usize = 1024;
/// The same when small inputs are wanted.
const SMALL_SIDE: usize = 256;
/// Runs of each product; the fastest counts.
const RUNS: usize = 3;
/// A is rounded to multiples of 2^-56, so that sums of products are exact in 128 bits.
const GRID: f64 = (1_u64 << 56) as f64;
/// Unit roundoff.
const UNIT: f64 = f64::EPSILON / 2.0;
/// Errors that the pictures tell apart: from 2^LOW to 2^HIGH units.
const LOW: i32 = -4;
const HIGH: i32 = 4;

/// A way to compute C.
struct Way {
    name: &'static str,
    about: &'static str,
    picture: &'static str,
    scheme: SchemeChoice,
    accuracy: Accuracy,
}

const CLASSICAL: Way = Way {
    name: "classical",
    about: "sums in double precision",
    picture: "error-classical.png",
    scheme: SchemeChoice::Classical,
    accuracy: Accuracy::Default,
};

/// The numbers of moduli are those of [`Accuracy`].
const EXACT: [Way; 3] = [
    Way {
        name: "exact, N = 13",
        about: "<code>--scheme exact --accuracy fast</code>",
        picture: "error-13.png",
        scheme: SchemeChoice::Exact,
        accuracy: Accuracy::Fast,
    },
    Way {
        name: "exact, N = 14",
        about: "<code>--scheme exact</code>",
        picture: "error-14.png",
        scheme: SchemeChoice::Exact,
        accuracy: Accuracy::Default,
    },
    Way {
        name: "exact, N = 15",
        about: "<code>--accuracy max</code>",
        picture: "error-15.png",
        scheme: SchemeChoice::Exact,
        accuracy: Accuracy::Max,
    },
];

/// One line of the table of errors, in units of u |a_i| |a_j|.
struct Outcome {
    way: &'static Way,
    seconds: f64,
    largest: f64,
    /// Root of the mean square.
    typical: f64,
}

/// The same product in another order, and how many entries of C came out otherwise.
struct Change {
    name: String,
    classical: usize,
    exact: usize,
}

/// Computes and describes it.
pub fn station(site: &Site<'_>) -> Result<Station> {
    let bar = Bar::new("exact");
    let side = if site.small { SMALL_SIDE } else { SIDE };
    let mut a = ata::signals(side, side);
    a.col_iter_mut().for_each(|column| {
        column.iter_mut().for_each(|x| *x = (*x * GRID).round() / GRID);
    });
    let a = a.as_ref();
    let reference = Reference::new(a)?;
    bar.step(0.3)?;

    let mut outcomes = Vec::new();
    let mut scale = picture::Scale::Sequential;
    for way in [&CLASSICAL].into_iter().chain(&EXACT) {
        let (mut c, mut seconds) = (Mat::zeros(0, 0), f64::INFINITY);
        for _ in 0..RUNS {
            let start = Instant::now();
            c = product(way, a, Par::all())?;
            seconds = seconds.min(start.elapsed().as_secs_f64());
        }
        let errors = reference.errors(c.as_ref());
        let level = |i: usize, j: usize| {
            let error = errors[(i.max(j), i.min(j))];
            (error.log2() - f64::from(LOW)) / f64::from(HIGH - LOW)
        };
        scale = picture::levels(site.file(way.picture)?, side, level)?;
        let (mut largest, mut squares) = (0.0_f64, 0.0);
        for (i, j) in lower(side) {
            largest = largest.max(errors[(i, j)]);
            squares += errors[(i, j)].powi(2);
        }
        let typical = (squares / triangle_len(side) as f64).sqrt();
        outcomes.push(Outcome { way, seconds, largest, typical });
        bar.step(0.3 + 0.1 * outcomes.len() as f64)?;
    }
    let changes = changes(a)?;
    drop(bar);
    describe(&outcomes, &changes, side, scale)
}

/// Returns the lower triangle of A^T A.
fn product(way: &Way, a: MatRef<'_, f64>, par: Par) -> Result<Mat<f64>> {
    progress::check()?;
    let Way { scheme, accuracy, .. } = *way;
    let options =
        AtaOptions::new().scheme(scheme).accuracy(accuracy).par(par).backend(blas::tuned());
    let mut c = Mat::zeros(a.ncols(), a.ncols());
    catamaran::ata_into(1.0, a, 0.0, c.as_mut(), &options)?;
    Ok(c)
}

/// Returns the same product with other threads, in another layout, and with the rows in another
/// order.
fn changes(a: MatRef<'_, f64>) -> Result<Vec<Change>> {
    let all = Par::all();
    let [_, exact, _] = &EXACT;
    let ways = [&CLASSICAL, exact];
    let [classical, exact] = [product(ways[0], a, all)?, product(ways[1], a, all)?];
    let transposed = a.transpose().to_owned();
    let mut order: Vec<usize> = (0..a.nrows()).collect();
    let mut rng = Rng::new(5);
    for i in (1..order.len()).rev() {
        order.swap(i, (rng.uniform() * (i + 1) as f64) as usize);
    }
    // A copy: kernels may turn a view with negative strides around.
    let reversed = Mat::from_fn(a.nrows(), a.ncols(), |i, j| a[(a.nrows() - 1 - i, j)]);
    let shuffled = Mat::from_fn(a.nrows(), a.ncols(), |i, j| a[(order[i], j)]);

    let threads = |n: usize| (format!("{n} thread{}", if n == 1 { "" } else { "s" }), n);
    let mut orders: Vec<(String, MatRef<'_, f64>, Par)> = Vec::new();
    for (name, n) in [1, 2, 3].map(threads) {
        if n != available_cores() {
            orders.push((name, a, Par::Threads(n)));
        }
    }
    orders.push(("A row by row in memory".into(), transposed.transpose(), all));
    orders.push(("rows of A in reverse order".into(), reversed.as_ref(), all));
    orders.push(("rows of A shuffled".into(), shuffled.as_ref(), all));
    let differing = |c: &Mat<f64>, d: &Mat<f64>| {
        lower(a.ncols()).filter(|&at| c[at].to_bits() != d[at].to_bits()).count()
    };
    let compare = |(name, a, par)| {
        let [c, e] = [product(ways[0], a, par)?, product(ways[1], a, par)?];
        Ok(Change { name, classical: differing(&classical, &c), exact: differing(&exact, &e) })
    };
    orders.into_iter().map(compare).collect()
}

fn describe(
    outcomes: &[Outcome],
    changes: &[Change],
    side: usize,
    scale: picture::Scale,
) -> Result<Station> {
    let [classical, _, exact, _] = outcomes else { unreachable!("one outcome a way") };
    let isa = IntegerIsa::best();
    let has_tiles = isa == IntegerIsa::Amx;
    let time_ratio = exact.seconds / classical.seconds;
    let digits = if has_tiles { 2 } else { 1 };
    let total = triangle_len(side);
    let most = |of: fn(&Change) -> usize| changes.iter().map(of).max().unwrap_or(0);
    let values = context! {
        side,
        isa => isa.name(),
        has_tiles,
        time_ratio => format!("{time_ratio:.digits$}"),
        most_changed => context! {
            exact => most(|c| c.exact),
            classical => format!("{:.0}", percent(most(|c| c.classical), total)),
        },
        error_ratio => format!("{:.1}", classical.largest / exact.largest),
        milliseconds => format!("{:.0}", exact.seconds * 1e3),
        low => -LOW,
        high => HIGH,
        colors => scale.css(),
        largest_errors => chart_of_errors(outcomes, exact.way),
        cores => available_cores(),
        entries => total,
        changes => changes.iter().map(|c| row_of_change(c, total)).collect::<Vec<_>>(),
        runs => RUNS,
        outcomes => outcomes.iter().map(|o| row_of_errors(o, classical)).collect::<Vec<_>>(),
    };
    let template = include_str!("stations/exact.html");
    Station::new("exact", "Exact A<sup>T</sup>A", template, values)
}

/// Returns the largest error of each way, with one of them in the foreground.
fn chart_of_errors(outcomes: &[Outcome], foreground: &Way) -> String {
    let bar = |o: &Outcome| ChartBar {
        name: o.way.name.into(),
        value: o.largest,
        label: format!("{:.2}", o.largest),
        color: if o.way.picture == foreground.picture { OWN } else { OTHERS },
    };
    let bars: Vec<_> = outcomes.iter().map(bar).collect();
    draw_bars(&bars, "largest error, in units of u |a_i| |a_j|")
}

/// Returns a row of the table of changes, of `total` entries.
fn row_of_change(change: &Change, total: usize) -> Value {
    let shown = |count: usize| match count {
        0 => "0".to_owned(),
        count => format!("{count} ({:.0} %)", percent(count, total)),
    };
    context! {
        name => &change.name,
        classical => shown(change.classical),
        exact => shown(change.exact),
    }
}

/// Returns a row of the table of errors.
fn row_of_errors(outcome: &Outcome, classical: &Outcome) -> Value {
    context! {
        name => outcome.way.name,
        about => outcome.way.about,
        largest => format!("{:.3}", outcome.largest),
        typical => format!("{:.4}", outcome.typical),
        milliseconds => format!("{:.1}", outcome.seconds * 1e3),
        to_classical => format!("{:.2}", outcome.seconds / classical.seconds),
    }
}

fn percent(part: usize, total: usize) -> f64 {
    100.0 * part as f64 / total as f64
}

/// Rows and columns of the lower triangle.
fn lower(n: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..n).flat_map(move |j| (j..n).map(move |i| (i, j)))
}

/// A^T A without any error: the lower triangle of the product of the integers `GRID * A`.
struct Reference {
    columns: Vec<Vec<i128>>,
    norms: Vec<f64>,
}

impl Reference {
    fn new(a: MatRef<'_, f64>) -> Result<Self> {
        let n = a.ncols();
        let integers: Vec<Vec<i64>> =
            a.col_iter().map(|column| column.iter().map(|x| (x * GRID) as i64).collect()).collect();
        let dot = |x: &[i64], y: &[i64]| -> i128 {
            x.iter().zip(y).map(|(&x, &y)| i128::from(x) * i128::from(y)).sum()
        };
        let mut columns = vec![Vec::new(); n];
        // The threads take columns in turn, because the first ones are the longest.
        let threads = available_cores();
        let mut shares: Vec<Vec<_>> = (0..threads).map(|_| Vec::new()).collect();
        for (j, column) in columns.iter_mut().enumerate() {
            shares[j % threads].push((j, column));
        }
        let integers = &integers;
        thread::scope(|scope| {
            for share in shares {
                let work = move || {
                    for (j, column) in share {
                        *column = (j..n).map(|i| dot(&integers[i], &integers[j])).collect();
                    }
                };
                thread::Builder::new().spawn_scoped(scope, work).context("threads")?;
            }
            Ok::<_, anyhow::Error>(())
        })?;
        let norms = columns.iter().map(|column| (column[0] as f64).sqrt() / GRID).collect();
        Ok(Self { columns, norms })
    }

    /// Returns |C - A^T A| in units of u |a_i| |a_j|, in the lower triangle.
    fn errors(&self, c: MatRef<'_, f64>) -> Mat<f64> {
        let n = c.ncols();
        let mut errors = Mat::zeros(n, n);
        for (i, j) in lower(n) {
            // Both factors are powers of two; what is below 2^-112 does not count.
            let error = (c[(i, j)] * GRID * GRID) as i128 - self.columns[j][i - j];
            let unit = UNIT * self.norms[i] * self.norms[j];
            errors[(i, j)] = error.abs() as f64 / GRID / GRID / unit;
        }
        errors
    }
}
