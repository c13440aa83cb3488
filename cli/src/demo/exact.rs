//! The station of the exact path: the same bytes in whatever order, and errors beside the classical
//! ones.

use std::thread;
use std::time::Instant;

use anyhow::Result;
use catamaran::base::{Rng, available_cores};
use catamaran::blas;
use catamaran::faer::{Mat, MatRef};
use catamaran::kernel::int8::Isa;
use catamaran::{Accuracy, AtaOptions, Par, SchemeChoice};
use catamaran_charts::{Bar as ChartBar, bars as draw_bars};

use super::page::{Figure, Station, Table};
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
    let reference = Reference::new(a);
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
        let typical = (squares / entries(side) as f64).sqrt();
        outcomes.push(Outcome { way, seconds, largest, typical });
        bar.step(0.3 + 0.1 * outcomes.len() as f64)?;
    }
    let changes = changes(a)?;
    drop(bar);
    Ok(describe(&outcomes, &changes, side, scale))
}

/// The lower triangle of A^T A.
fn product(way: &Way, a: MatRef<'_, f64>, par: Par) -> Result<Mat<f64>> {
    progress::check()?;
    let Way { scheme, accuracy, .. } = *way;
    let options =
        AtaOptions::new().scheme(scheme).accuracy(accuracy).par(par).backend(blas::tuned());
    let mut c = Mat::zeros(a.ncols(), a.ncols());
    catamaran::ata(1.0, a, 0.0, c.as_mut(), &options)?;
    Ok(c)
}

/// The same product with other threads, in another layout, and with the rows in another order.
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
) -> Station {
    let [classical, _, exact, _] = outcomes else { unreachable!("one outcome a way") };
    let isa = Isa::best();
    let ratio = exact.seconds / classical.seconds;
    let speed = match isa {
        Isa::Amx => format!(
            "The matrix tiles of this CPU (<code>amx</code>) compute it in {ratio:.2} of the time of \
             the classical one; the larger the matrix, the better for them."
        ),
        _ => format!(
            "This machine has no AMX, whose matrix tiles make it the faster way: through \
             <code>{}</code> it takes {ratio:.1} times as long as the classical one here, and is \
             worth asking for (<code>--reproducible</code>, <code>--accuracy max</code>) for its \
             bytes and its errors only.",
            isa.name()
        ),
    };
    let total = entries(side);
    let most = |of: fn(&Change) -> usize| changes.iter().map(of).max().unwrap_or(0);
    let percent = |count: usize| match count {
        0 => "0".to_owned(),
        count => format!("{count} ({:.0} %)", 100.0 * count as f64 / total as f64),
    };
    let unit = "u |a<sub>i</sub>| |a<sub>j</sub>|";
    let figure = |o: &Outcome| Figure {
        body: format!(
            "<img src=\"{}\" width=\"512\" height=\"512\" alt=\"Heat map of errors, {}\">\n\
             <div class=\"legend\"><span>2<sup>&minus;{}</sup></span>\
             <i style=\"background:{}\"></i><span>2<sup>{HIGH}</sup></span></div>",
            o.way.picture,
            o.way.name,
            -LOW,
            scale.css()
        ),
        caption: match o.way.picture {
            "error-classical.png" => format!(
                "Classical: the error of each entry of C, in units of {unit} (u = \
                 2<sup>&minus;53</sup>). Every sum is rounded {side} times, and the larger its \
                 terms, the more."
            ),
            "error-13.png" => "Exact, N = 13, in the same colours: the rounding of the columns to \
                               integers hides everything else."
                .into(),
            "error-14.png" => "Exact, N = 14: that is a fourteenth of it, and the rounding of the \
                               largest entries shows."
                .into(),
            _ => "Exact, N = 15: what remains is the rounding of each entry of C, in steps where \
                  its exponent changes."
                .to_owned(),
        },
        wide: false,
    };
    let bars: Vec<ChartBar> = outcomes
        .iter()
        .map(|o| ChartBar {
            name: o.way.name.into(),
            value: o.largest,
            label: format!("{:.2}", o.largest),
            color: if o.way.picture == exact.way.picture { OWN } else { OTHERS },
        })
        .collect();
    let bars = Figure {
        body: draw_bars(&bars, "largest error, in units of u |a_i| |a_j|"),
        caption:
            "Largest error of all entries. Shorter is better; a correctly rounded C would have \
                  1 at most."
                .into(),
        wide: true,
    };
    Station {
        id: "exact",
        title: "Exact A<sup>T</sup>A",
        text: format!(
            "<p>Sums in floating point depend on their order. The exact path rounds every column of \
             A to integers, multiplies those modulo N numbers of 8 bits, puts the products together \
             by the Chinese remainder theorem, and rounds once more: nothing between is rounded, so \
             nothing depends on the order of the work. Here {side} samples of {side} sensors, as \
             above, are multiplied both ways.</p>\n<p>{speed}</p>"
        ),
        numbers: vec![
            (most(|c| c.exact).to_string(), "entries of the exact C that another order changes"),
            (
                format!("{:.0} %", 100.0 * most(|c| c.classical) as f64 / total as f64),
                "of those of the classical C",
            ),
            (
                format!("{:.1} &times;", classical.largest / exact.largest),
                "the largest error, classical over exact (N = 14)",
            ),
            (format!("{:.0} ms", exact.seconds * 1e3), "for the exact C (N = 14)"),
        ],
        figures: outcomes.iter().map(figure).chain([bars]).collect(),
        tables: vec![
            Table {
                caption: format!(
                    "Entries with other bytes than in the product on all {} cores of A column by \
                     column, of {total} in the lower triangle. Threads, layout and CPU never change \
                     a byte of the exact C; the order of the rows does when it takes the norm of a \
                     column, known to about a millionth, across a step of the scale.",
                    available_cores()
                ),
                head: vec!["", "classical", "exact, N = 14"],
                text_columns: 1,
                rows: changes
                    .iter()
                    .map(|c| vec![c.name.clone(), percent(c.classical), percent(c.exact)])
                    .collect(),
            },
            Table {
                caption: format!(
                    "Errors of all entries against integer arithmetic in 128 bits, which A allows: \
                     it is rounded to multiples of 2<sup>&minus;56</sup>. In units of {unit}. Times \
                     are the best of {RUNS}, with <code>{}</code>.",
                    isa.name()
                ),
                head: vec!["", "", "max error", "rms error", "ms", "&times; classical"],
                text_columns: 2,
                rows: outcomes
                    .iter()
                    .map(|o| {
                        vec![
                            o.way.name.into(),
                            o.way.about.into(),
                            format!("{:.3}", o.largest),
                            format!("{:.4}", o.typical),
                            format!("{:.1}", o.seconds * 1e3),
                            format!("{:.2}", o.seconds / classical.seconds),
                        ]
                    })
                    .collect(),
            },
        ],
    }
}

/// Rows and columns of the lower triangle.
fn lower(n: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..n).flat_map(move |j| (j..n).map(move |i| (i, j)))
}

/// How many there are.
fn entries(n: usize) -> usize {
    n * (n + 1) / 2
}

/// A^T A without any error: the lower triangle of the product of the integers `GRID * A`.
struct Reference {
    columns: Vec<Vec<i128>>,
    norms: Vec<f64>,
}

impl Reference {
    fn new(a: MatRef<'_, f64>) -> Self {
        let n = a.ncols();
        let integers: Vec<Vec<i64>> =
            a.col_iter().map(|column| column.iter().map(|x| (x * GRID) as i64).collect()).collect();
        let dot = |x: &[i64], y: &[i64]| -> i128 {
            x.iter().zip(y).map(|(&x, &y)| i128::from(x) * i128::from(y)).sum()
        };
        let mut columns = vec![Vec::new(); n];
        // Every so manieth column: the first ones are the longest.
        let threads = available_cores();
        let mut shares: Vec<Vec<_>> = (0..threads).map(|_| Vec::new()).collect();
        for (j, column) in columns.iter_mut().enumerate() {
            shares[j % threads].push((j, column));
        }
        let integers = &integers;
        thread::scope(|scope| {
            for share in shares {
                scope.spawn(move || {
                    for (j, column) in share {
                        *column = (j..n).map(|i| dot(&integers[i], &integers[j])).collect();
                    }
                });
            }
        });
        let norms = columns.iter().map(|column| (column[0] as f64).sqrt() / GRID).collect();
        Self { columns, norms }
    }

    /// |C - A^T A| in units of u |a_i| |a_j|, in the lower triangle.
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
