//! What is measured, as lines of the screen and of the record.

use std::fmt;

use catamaran::ata::distributed::{Machine, choose, lower_bound, predict, proposition_8_3};
use catamaran_bench::input::Shape;
use catamaran_bench::race::{Outcome, median};

use crate::job::Job;

/// Seconds of one repetition, each the largest of all ranks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Times {
    /// In local products.
    pub compute: f64,
    /// Beyond them: what of the communication is not hidden behind them, waiting for others, sums and copies.
    pub communication: f64,
    /// From the moment when all ranks are there to the end of the last one.
    pub wall: f64,
}

impl Times {
    /// The median of each.
    pub fn median(all: &[Self]) -> Self {
        let of = |time: fn(&Self) -> f64| median(all.iter().map(time).collect());
        Self {
            compute: of(|times| times.compute),
            communication: of(|times| times.communication),
            wall: of(|times| times.wall),
        }
    }
}

/// What a rank communicates.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Cost {
    /// Entries of matrices.
    pub words: f64,
    /// Messages.
    pub messages: f64,
}

/// What was counted in one repetition.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Counted {
    /// What a rank sends or, if that is more, receives; the largest of all ranks.
    pub most: Cost,
    /// What this rank sends and receives.
    pub both_ways: Cost,
}

/// What was counted, on rank 0, beside the plan, the lower bound, and AtA-D's formula.
pub fn costs(job: &Job, ranks: usize, counted: &Counted) -> String {
    let Job { mode, shape: Shape { m, n }, .. } = *job;
    let Counted { most, both_ways } = counted;
    let planned = predict(mode, ranks, m, n, &Machine::default());
    let least = lower_bound(ranks, m, n);
    let (messages, words) = proposition_8_3(ranks, m, n);
    let times = if least.words > 0.0 { most.words / least.words } else { 1.0 };
    format!(
        "per rank         words   messages\n\
         counted   {:>12.0} {:>10.0}   sent or received, the rank with most: {times:.2} x the bound\n\
         planned   {:>12.0} {:>10.0}\n\
         bound     {:>12.0}              at least, in {} dimensions\n\
         rank 0    {:>12.0} {:>10.0}   counted, both ways\n\
         AtA-D     {words:>12.0} {messages:>10.0}   rank 0 of mode root, both ways, by proposition 8.3",
        most.words,
        most.messages,
        planned.words,
        planned.messages,
        least.words,
        least.dimensions,
        both_ways.words,
        both_ways.messages,
    )
}

/// What to say when another mode with A and C at the same place should be faster by a tenth or more.
pub fn note_of_faster_mode(job: &Job, ranks: usize) -> Option<String> {
    let Job { mode, shape: Shape { m, n }, .. } = *job;
    let machine = Machine::default();
    let best = choose(ranks, m, n, &machine, mode.place());
    let [own, least] = [mode, best].map(|mode| predict(mode, ranks, m, n, &machine).seconds);
    (least < 0.9 * own).then(|| {
        format!(
            "note      mode {best} should be faster here: {:.2} of the time, as predicted",
            least / own
        )
    })
}

/// The column names of [`line()`].
pub const HEADER: &str = "\
 rep  compute s   commun. s      wall s  GFLOP/s  % peak |     rival s  GFLOP/s  ratio";

/// A repetition, or `median`.
pub fn line(name: &str, job: &Job, times: &Times, peak: f64, rival: Option<(f64, f64)>) -> String {
    let Times { compute, communication, wall } = times;
    let speed = job.flops() / wall / 1e9;
    let mut line = format!(
        "{name:>4} {compute:>10.6}  {communication:>10.6}  {wall:>10.6}  {speed:>7.1}  {:>6.1} |",
        100.0 * speed / peak
    );
    if let Some((seconds, ratio)) = rival {
        line += &format!("  {seconds:>10.6}  {:>7.1}  {ratio:>5.3}", job.flops() / seconds / 1e9);
    }
    line
}

/// One race, for the record.
pub struct Row<'a> {
    /// What was computed.
    pub job: &'a Job,
    /// How many ranks.
    pub ranks: usize,
    /// `f32` or `f64`.
    pub scalar: &'static str,
    /// Our wall times.
    pub ours: &'a Outcome,
    /// The rival's, and how it distributed its matrices.
    pub rival: Option<(Outcome, String)>,
    /// Largest difference of the two results, relative to the largest entry.
    pub error: Option<f64>,
    /// Words of ours: see [`Counted::most`].
    pub words: f64,
}

impl Row<'_> {
    /// The column names; the first [`Row::KEYS`] say what a row is about.
    pub const HEADER: &'static str =
        "mode,ranks,threads,m,n,type,repetitions,ours_s,rival_s,ratio,error,words,bound,rival";
    /// See [`Row::HEADER`].
    pub const KEYS: usize = 6;
}

impl fmt::Display for Row<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { job, ranks, scalar, ours, .. } = self;
        let Job { shape, threads, .. } = job;
        write!(f, "{},{ranks},{threads},{},{},{scalar},", job.way(), shape.m, shape.n)?;
        write!(f, "{},{:.6e},", ours.seconds.len(), ours.median())?;
        match &self.rival {
            Some((rival, _)) => write!(f, "{:.6e},{:.4},", rival.median(), ours.ratio_to(rival))?,
            None => write!(f, ",,")?,
        }
        if let Some(error) = self.error {
            write!(f, "{error:.3e}")?;
        }
        let bound = lower_bound(*ranks, shape.m, shape.n).words;
        write!(f, ",{:.0},{bound:.0},", self.words)?;
        self.rival.as_ref().map_or(Ok(()), |(_, distribution)| write!(f, "{distribution}"))
    }
}

/// The largest difference of `ours`, row-major, and `rival`, column-major, in the lower triangles, relative to the
/// largest entry of the rival's; NaN if there is one.
pub fn difference<T: catamaran::Real>(n: usize, ours: &[T], rival: &[T]) -> f64 {
    let (mut most, mut largest) = (0.0_f64, 0.0_f64);
    for i in 0..n {
        for j in 0..=i {
            let (x, y) = (ours[i * n + j].to_f64(), rival[i + j * n].to_f64());
            let distance = (x - y).abs();
            most = if distance > most || distance.is_nan() { distance } else { most };
            largest = largest.max(y.abs());
        }
    }
    if most == 0.0 { 0.0 } else { most / largest }
}
