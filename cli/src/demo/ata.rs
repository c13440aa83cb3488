//! The station of A^T A: every scheme on one matrix of signals.

use std::f64::consts::TAU;
use std::time::Instant;

use anyhow::{Context, Result};
use catamaran::base::{Real, Rng};
use catamaran::blas;
use catamaran::faer::prelude::Reborrow;
use catamaran::faer::{Mat, MatRef};
use catamaran::product::{Node, verify};
use catamaran::{Accuracy, AtaOptions, Par, SchemeChoice, Uplo};
use catamaran_charts::{Bar as ChartBar, bars as draw_bars};
use minijinja::context;
use minijinja::value::Value;

use super::page::Station;
use super::{OTHERS, OWN, Site, task_tree};
use crate::picture;
use crate::progress::Bar;

/// Samples in time, and sensors.
const SIDE: usize = 2048;
/// The same when small inputs are wanted.
const SMALL_SIDE: usize = 320;
/// Runs of each scheme; the fastest counts.
const RUNS: usize = 2;
/// Rows of C whose entries are compared with a reference.
const CHECKED_ROWS: usize = 16;
/// Smallest blocks of the schemes asked for by name, so that each shows at this size.
const LEAF: usize = 256;
/// Rounds of the random check.
const ROUNDS: u32 = 20;
/// Processes in the picture of the task tree.
const PROCESSES: usize = 16;

/// One line of the table.
struct Outcome {
    name: &'static str,
    seconds: f64,
    error: f64,
    passed: bool,
}

impl Outcome {
    /// Returns the effective GFLOP/s for a square matrix of this side.
    fn rate(&self, side: usize) -> String {
        format!("{:.1}", self.gflops(side))
    }

    fn gflops(&self, side: usize) -> f64 {
        (side as f64).powi(3) / self.seconds / 1e9
    }
}

/// Computes and describes it.
pub fn station(site: &Site<'_>) -> Result<Station> {
    let bar = Bar::new("A^T A");
    let side = if site.small { SMALL_SIDE } else { SIDE };
    let a = signals(side, side);
    let a = a.as_ref();
    let mut rng = Rng::new(3);
    let checked: Vec<usize> =
        (0..CHECKED_ROWS).map(|_| (rng.uniform() * side as f64) as usize).collect();
    let reference = reference(a, &checked);

    let mut c = Mat::<f64>::zeros(side, side);
    let mut outcomes = Vec::new();
    for (done, (name, scheme)) in SchemeChoice::NAMES.into_iter().enumerate() {
        let mut options = AtaOptions::new().uplo(Uplo::Both).scheme(scheme).backend(blas::tuned());
        let fast =
            [SchemeChoice::Winograd, SchemeChoice::Rxtx, SchemeChoice::Kgp4, SchemeChoice::Kgp3];
        if fast.contains(&scheme) {
            options.leaf = Some(LEAF);
            options.accuracy = Accuracy::Fast;
        }
        let mut seconds = f64::INFINITY;
        for run in 0..RUNS {
            let start = Instant::now();
            catamaran::ata_into(1.0, a, 0.0, c.as_mut(), &options)?;
            seconds = seconds.min(start.elapsed().as_secs_f64());
            bar.step((done * RUNS + run + 1) as f64 / (SchemeChoice::NAMES.len() * RUNS) as f64)?;
        }
        let mut error = 0.0_f64;
        for (r, &i) in checked.iter().enumerate() {
            for j in 0..side {
                error = error.max((c[(i, j)] - reference[(r, j)]).abs());
            }
        }
        let passed = verify(1.0, a, c.rb(), Uplo::Both, ROUNDS, 1)?.passed;
        outcomes.push(Outcome { name, seconds, error, passed });
    }
    let scale = picture::write(site.file("ata.png")?, c.rb(), |i, j| (i, j))?;
    drop(bar);
    describe(&outcomes, side, scale)
}

fn describe(outcomes: &[Outcome], side: usize, scale: picture::Scale) -> Result<Station> {
    let auto = outcomes.iter().find(|o| o.name == "auto").context("no automatic plan")?;
    let classical = outcomes.iter().find(|o| o.name == "classical").map_or(1.0, |o| o.error);
    let rows = outcomes.iter().map(|o| row(o, side, classical));
    let values = context! {
        side,
        auto => context! {
            milliseconds => format!("{:.0}", auto.seconds * 1e3),
            rate => auto.rate(side),
        },
        threads => Par::all().threads(),
        legend => context! {
            low => if scale == picture::Scale::Diverging { "&minus;1" } else { "0" },
            colors => scale.css(),
        },
        task_tree => task_tree::draw(&Node::symmetric(side, PROCESSES), side, PROCESSES),
        processes => PROCESSES,
        rates => chart_of_rates(outcomes, side),
        runs => RUNS,
        leaf => LEAF,
        checked_rows => CHECKED_ROWS,
        rounds => ROUNDS,
        outcomes => rows.collect::<Vec<_>>(),
    };
    Station::new("ata", "A<sup>T</sup>A", include_str!("stations/ata.html"), values)
}

/// Returns a row of the table; `classical` is the error of the classical scheme.
fn row(outcome: &Outcome, side: usize, classical: f64) -> Value {
    context! {
        name => outcome.name,
        about => about(outcome.name),
        milliseconds => format!("{:.1}", outcome.seconds * 1e3),
        rate => outcome.rate(side),
        error => format!("{:.1e}", outcome.error),
        to_classical => format!("{:.2}", outcome.error / classical),
        passed => outcome.passed,
    }
}

fn chart_of_rates(outcomes: &[Outcome], side: usize) -> String {
    let bar = |o: &Outcome| ChartBar {
        name: o.name.into(),
        value: o.gflops(side),
        label: o.rate(side),
        color: if o.name == "auto" { OWN } else { OTHERS },
    };
    draw_bars(&outcomes.iter().map(bar).collect::<Vec<_>>(), "effective GFLOP/s")
}

fn about(name: &str) -> &'static str {
    match name {
        "auto" => "what the planner expects to be fastest",
        "classical" => "no fast products",
        "ata2" => "2 &times; 2 recursion over Strassen, as in the thesis",
        "winograd" => "2 &times; 2 recursion over Winograd&rsquo;s variant",
        "rxtx" => "4 &times; 4 RXTX over Winograd",
        "kgp" => "sparse 4 &times; 4 scheme of Khoruzhii, Gel&szlig; and Pokutta",
        "kgp3" => "their 3 &times; 3 scheme",
        "exact" => "integer products modulo 14 small numbers: the same bytes on every machine",
        _ => "",
    }
}

/// Recordings of `m` samples by `n` sensors on a line: broad, middling and narrow sources, most of
/// them heard in a second place with opposite sign, and noise.
pub fn signals(m: usize, n: usize) -> Mat<f64> {
    struct Source {
        places: [(f64, f64); 2],
        width: f64,
        frequency: f64,
        phase: f64,
    }
    let mut rng = Rng::new(11);
    let mut sources = Vec::new();
    for (count, width) in [(4, 0.08), (14, 0.025), (48, 0.006)] {
        for k in 0..count {
            let place = (k as f64 + rng.uniform()) / count as f64;
            let echo = if k % 3 < 2 { rng.sign() * (0.6 + 0.4 * rng.uniform()) } else { 0.0 };
            sources.push(Source {
                places: [(place, 1.0), (rng.uniform(), echo)],
                width,
                frequency: 2.0 + 60.0 * rng.uniform(),
                phase: TAU * rng.uniform(),
            });
        }
    }
    let gains = Mat::from_fn(sources.len(), n, |k, j| {
        let source = &sources[k];
        let gain = |(place, gain): (f64, f64)| {
            let distance = (j as f64 / n as f64 - place) / source.width;
            gain * (-0.5 * distance * distance).exp()
        };
        source.places.map(gain).iter().sum::<f64>()
    });
    let waves = Mat::from_fn(m, sources.len(), |i, k| {
        let source = &sources[k];
        (TAU * source.frequency * i as f64 / m as f64 + source.phase).sin()
    });
    let clean = waves * gains;
    Mat::from_fn(m, n, |i, j| clean[(i, j)] + 0.12 * rng.normal())
}

/// Computes the rows `checked` of A^T A in twice the working precision (Ogita, Rump and Oishi 2005,
/// Dot2).
fn reference(a: MatRef<'_, f64>, checked: &[usize]) -> Mat<f64> {
    Mat::from_fn(checked.len(), a.ncols(), |r, j| {
        let (mut sum, mut rest) = (f64::ZERO, f64::ZERO);
        for i in 0..a.nrows() {
            let (x, y) = (a[(i, checked[r])], a[(i, j)]);
            let product = x * y;
            let total = sum + product;
            let virtual_part = total - sum;
            rest +=
                (sum - (total - virtual_part)) + (product - virtual_part) + x.mul_add(y, -product);
            sum = total;
        }
        sum + rest
    })
}
