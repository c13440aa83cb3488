//! Formats the measurements as lines of the screen.

use catamaran::ranks::plan::{Machine, choose, lower_bound, predict, proposition_8_3};
use catamaran_bench::input::Shape;
use catamaran_bench::race::median;

use crate::checks::{Check, verdict};
use crate::job::Job;
use crate::row::Row;

/// Seconds of one repetition, each the largest over all ranks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Times {
    /// Seconds in local products.
    pub compute: f64,
    /// Seconds outside of them: communication that is not hidden behind products, waiting for
    /// others, sums and copies.
    pub communication: f64,
    /// Seconds from the moment when all ranks are ready to the end of the last one.
    pub wall: f64,
}

impl Times {
    /// Returns the median of each.
    pub fn median(all: &[Self]) -> Self {
        let of = |time: fn(&Self) -> f64| median(all.iter().map(time).collect());
        Self {
            compute: of(|times| times.compute),
            communication: of(|times| times.communication),
            wall: of(|times| times.wall),
        }
    }
}

/// The communication of a rank.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Cost {
    /// Number of entries of matrices.
    pub words: f64,
    /// Number of messages.
    pub messages: f64,
}

/// The traffic of one repetition.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Counted {
    /// Words and messages that a rank sends or, if that is more, receives; the largest over all
    /// ranks.
    pub most: Cost,
    /// Words and messages that this rank sends and receives.
    pub both_ways: Cost,
}

/// Returns the traffic, on rank 0, in comparison with the plan, the lower bound, and AtA-D's
/// formula.
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

/// Returns a line about the planned memory of the rank that needs the most.
pub fn memory_line<T>(job: &Job, ranks: usize) -> String {
    let Job { mode, shape: Shape { m, n }, .. } = *job;
    let words = predict(mode, ranks, m, n, &Machine::default()).memory;
    let gib = words * size_of::<T>() as f64 / (1_u64 << 30) as f64;
    format!("memory    {gib:.3} GiB on the rank with most: A, C and what travels, as planned")
}

/// Returns a note when another mode with A and C at the same place should be faster by a tenth or
/// more.
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

/// Returns the line of a repetition, or of the `median`.
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

/// Returns the largest difference of `ours`, row-major, and `rival`, column-major, in the lower
/// triangles, relative to the largest entry of the rival's; NaN if there is one.
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

/// A separator of the summary.
const DOUBLE: &str =
    "================================================================================";
const SINGLE: &str =
    "--------------------------------------------------------------------------------";

/// Returns the results of the whole run, in the style of HPL: the last lines of the output.
pub fn summary(row: &Row<'_>, checks: &[Check]) -> String {
    let Row { job, ranks, scalar, times, counted, .. } = row;
    let Job { shape: Shape { m, n }, threads, .. } = *job;
    let seconds = row.ours.median();
    let gflops = job.flops() / seconds / 1e9;
    let mut text = format!(
        "{DOUBLE}\n\
         mode                m        n type  ranks threads      time s   GFLOP/s  % peak\n\
         {SINGLE}\n\
         {:<12} {m:>8} {n:>8} {scalar:>4} {ranks:>6} {threads:>7} {seconds:>11.6} {gflops:>9.1} {:>7.1}\n",
        job.way(),
        100.0 * gflops / row.peak,
    );
    text += &format!(
        "compute {:.6} s, communication {:.6} s; {:.0} words in {:.0} messages\n",
        times.compute, times.communication, counted.most.words, counted.most.messages,
    );
    if let Some((rival, distribution)) = &row.rival {
        let (seconds, ratio) = (rival.median(), row.ours.ratio_to(rival));
        let gflops = job.flops() / seconds / 1e9;
        text += &format!(
            "pdsyrk {seconds:.6} s, {gflops:.1} GFLOP/s ({distribution}); ratio {ratio:.3}\n"
        );
    }
    text += &format!("{SINGLE}\n");
    for check in checks {
        text += &format!("{check}\n");
    }
    let result = row.passed.map_or("not checked (--check)", verdict);
    text + &format!("result: {result}\n{DOUBLE}")
}
