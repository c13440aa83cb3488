//! A race as a line of a table, which `--csv` and `--record` write.

use std::fmt;

use catamaran::ranks::plan::{Machine, Mode, lower_bound, predict, proposition_8_3};
use catamaran_bench::input::Shape;
use catamaran_bench::race::Outcome;

use crate::job::Job;
use crate::report::{Counted, Times};

/// One race.
pub struct Row<'a> {
    /// What was computed.
    pub job: &'a Job,
    /// Number of ranks.
    pub ranks: usize,
    /// `f32` or `f64`.
    pub scalar: &'static str,
    /// Our wall times.
    pub ours: &'a Outcome,
    /// Medians of ours.
    pub times: Times,
    /// Speed limit of all ranks in GFLOP/s.
    pub peak: f64,
    /// The rival's wall times, and how it distributed its matrices.
    pub rival: Option<(Outcome, String)>,
    /// Residual of the random vectors.
    pub residual: Option<f64>,
    /// Largest difference of the two results, relative to the largest entry.
    pub error: Option<f64>,
    /// Whether all checks passed, if there were any.
    pub passed: Option<bool>,
    /// Words and messages of one repetition of ours.
    pub counted: Counted,
}

impl Row<'_> {
    /// The column names; the first [`Row::KEYS`] identify a row.
    pub const HEADER: &'static str = "mode,ranks,threads,m,n,type,repetitions,\
        ours_s,compute_s,communication_s,gflops,percent_of_peak,rival_s,ratio,rival,\
        residual,error,check,words,planned_words,bound,messages,planned_messages,\
        rank_0_words,proposition_8_3_words,rank_0_messages,proposition_8_3_messages";
    /// Number of columns that identify a row; see [`Row::HEADER`].
    pub const KEYS: usize = 6;
}

impl fmt::Display for Row<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { job, ranks, scalar, ours, times, .. } = self;
        let Job { mode, shape: Shape { m, n }, threads, .. } = **job;
        let seconds = ours.median();
        let gflops = job.flops() / seconds / 1e9;
        write!(f, "{},{ranks},{threads},{m},{n},{scalar},{},", job.way(), ours.seconds.len())?;
        write!(f, "{seconds:.6e},{:.6e},{:.6e},", times.compute, times.communication)?;
        write!(f, "{gflops:.2},{:.2},", 100.0 * gflops / self.peak)?;
        match &self.rival {
            Some((rival, distribution)) => {
                let (seconds, ratio) = (rival.median(), ours.ratio_to(rival));
                write!(f, "{seconds:.6e},{ratio:.4},{distribution},")?;
            }
            None => f.write_str(",,,")?,
        }
        let number =
            |value: Option<f64>| value.map_or(String::new(), |value| format!("{value:.3e}"));
        let check = self.passed.map_or("", |passed| if passed { "passed" } else { "failed" });
        write!(f, "{},{},{check},", number(self.residual), number(self.error))?;
        let Counted { most, both_ways } = self.counted;
        let planned = predict(mode, *ranks, m, n, &Machine::default());
        let bound = lower_bound(*ranks, m, n).words;
        write!(f, "{:.0},{:.0},{bound:.0},", most.words, planned.words)?;
        write!(f, "{:.0},{:.0},", most.messages, planned.messages)?;
        // The proposition applies to AtA-D only.
        let proposition = (mode == Mode::Tree).then(|| proposition_8_3(*ranks, m, n));
        let whole = |value: Option<f64>| value.map_or(String::new(), |value| format!("{value:.0}"));
        let (words, messages) = (proposition.map(|p| p.1), proposition.map(|p| p.0));
        write!(f, "{:.0},{},", both_ways.words, whole(words))?;
        write!(f, "{:.0},{}", both_ways.messages, whole(messages))
    }
}

#[cfg(test)]
mod tests {
    use catamaran::SchemeChoice;

    use super::*;

    fn outcome(seconds: f64) -> Outcome {
        Outcome { contender: String::new(), is_rival: false, seconds: vec![seconds], error: 0.0 }
    }

    fn row<'a>(job: &'a Job, ours: &'a Outcome) -> Row<'a> {
        let times = Times { compute: 0.25, communication: 0.25, wall: 0.5 };
        let counted = Counted::default();
        let (rival, residual, error, passed) = (None, None, None, None);
        let (ranks, scalar, peak) = (6, "f64", 4.0);
        Row { job, ranks, scalar, ours, times, peak, rival, residual, error, passed, counted }
    }

    #[test]
    fn a_row_has_a_field_for_every_column() {
        let columns: Vec<_> = Row::HEADER.split(',').collect();
        let ours = outcome(0.5);
        for (_, mode) in Mode::NAMES {
            let shape = Shape { m: 1000, n: 1000 };
            let job = Job { mode, shape, seed: 1, threads: 2, scheme: SchemeChoice::Auto };
            let line = row(&job, &ours).to_string();
            let fields: Vec<_> = line.split(',').collect();
            assert_eq!(fields.len(), columns.len());
            let field = |name| fields[columns.iter().position(|c| *c == name).unwrap()];
            assert_eq!((field("gflops"), field("percent_of_peak")), ("2.00", "50.00"));
            assert_eq!(field("proposition_8_3_messages").is_empty(), mode != Mode::Tree);

            let rival = Some((outcome(1.0), "A 1x2 NB 64".into()));
            let (residual, error, passed) = (Some(1e-12), Some(1e-16), Some(true));
            let full = Row { rival, residual, error, passed, ..row(&job, &ours) }.to_string();
            assert_eq!(full.split(',').count(), columns.len());
            assert!(full.contains(",2.0000,A 1x2 NB 64,1.000e-12,1.000e-16,passed,"), "{full}");
        }
    }

    #[test]
    fn the_guide_has_every_column() {
        let guide = include_str!("../../../../docs/guide/cluster.md");
        let missing = Row::HEADER.split(',').find(|name| !guide.contains(&format!("`{name}`")));
        assert_eq!(missing, None);
    }
}
