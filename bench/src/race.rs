//! The race: every contender once per repetition, in rotating order, on the same A, so that what
//! the machine does meanwhile strikes all of them alike.

use std::time::{Duration, Instant};

use catamaran::base::Team;
use faer::{MatMut, MatRef};

use crate::Result;
use crate::contender::{Contender, Scalar};
use crate::input::Shape;
use crate::reference::Reference;

/// How a race is run.
pub struct Rules {
    /// Repetitions.
    pub repeat: usize,
    /// No repetition starts that is not expected to end by then.
    pub deadline: Option<Instant>,
}

/// The outcome for one contender.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// Its name.
    pub contender: String,
    /// Seconds per call, one per repetition.
    pub seconds: Vec<f64>,
    /// Largest relative error of any of its runs.
    pub error: f64,
}

/// Length of a timed sample, at least: shorter calls are repeated within it.
const SAMPLE_SECONDS: f64 = 0.05;
const MOST_CALLS: f64 = 64.0;
/// Threads of the contender before are asleep after this.
const PAUSE: Duration = Duration::from_millis(20);
/// Side of the leading block of A that everyone warms up on.
const WARM_UP_SIDE: usize = 1024;

/// Runs the race. Fewer repetitions, even none, come back when the deadline is near.
///
/// # Errors
/// A wrong result ends the race.
pub fn race<T: Scalar>(
    contenders: &[Contender],
    a: &[T],
    shape: Shape,
    threads: usize,
    team: &Team,
    reference: &Reference,
    rules: &Rules,
) -> Result<Vec<Outcome>> {
    let Shape { m, n } = shape;
    let a = MatRef::from_row_major_slice(a, m, n);
    let mut c = vec![T::ONE; n * n];
    let late = |expected: f64| {
        rules.deadline.is_some_and(|d| Instant::now() + Duration::from_secs_f64(expected) > d)
    };

    let mut outcomes: Vec<_> = contenders
        .iter()
        .map(|x| Outcome { contender: x.to_string(), seconds: vec![], error: 0.0 })
        .collect();
    let (rows, cols) = (m.min(WARM_UP_SIDE), n.min(WARM_UP_SIDE));
    let mut fastest = f64::INFINITY;
    for contender in contenders {
        let corner = a.submatrix(0, 0, rows, cols);
        let mut c = MatMut::from_row_major_slice_mut(&mut c, n, n);
        // The first call pays for threads and buffers.
        for _ in 0..2 {
            let c = c.as_mut().submatrix_mut(0, 0, cols, cols);
            let time = contender.run(corner, c, 1, threads, team)?;
            fastest = fastest.min(time.as_secs_f64());
        }
    }
    let work = |m: usize, n: usize| m as f64 * n as f64 * n as f64;
    let one_call = fastest * work(m, n) / work(rows, cols);
    let calls = (SAMPLE_SECONDS / one_call).ceil().clamp(1.0, MOST_CALLS) as usize;

    let mut round_seconds = contenders.len() as f64 * one_call * calls as f64;
    for round in 0..rules.repeat {
        if late(round_seconds) {
            break;
        }
        let start = Instant::now();
        for turn in 0..contenders.len() {
            let i = (round + turn) % contenders.len();
            reference.poison(&mut c);
            std::thread::sleep(PAUSE);
            let view = MatMut::from_row_major_slice_mut(&mut c, n, n);
            let time = contenders[i].run(a, view, calls, threads, team)?;
            let error = reference
                .check(&c)
                .map_err(|e| format!("{}, {shape}, {}: {e}", contenders[i], T::NAME))?;
            outcomes[i].seconds.push(time.as_secs_f64() / calls as f64);
            outcomes[i].error = outcomes[i].error.max(error);
        }
        round_seconds = start.elapsed().as_secs_f64();
    }
    Ok(outcomes)
}

impl Outcome {
    /// Median seconds.
    pub fn median(&self) -> f64 {
        median(self.seconds.clone())
    }

    /// Seconds of the fastest repetition, which other programs disturbed least.
    pub fn best(&self) -> f64 {
        self.seconds.iter().copied().fold(f64::NAN, f64::min)
    }

    /// How many times faster than `other`: the median over the repetitions, each of which saw both.
    pub fn ratio_to(&self, other: &Self) -> f64 {
        median(self.seconds.iter().zip(&other.seconds).map(|(own, other)| other / own).collect())
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    match values.len() {
        0 => f64::NAN,
        len if len % 2 == 1 => values[len / 2],
        len => 0.5 * (values[len / 2 - 1] + values[len / 2]),
    }
}

#[cfg(test)]
mod tests {
    use catamaran::base::Pin;

    use super::*;
    use crate::input::{Distribution, matrix};

    fn outcome(seconds: &[f64]) -> Outcome {
        Outcome { contender: String::new(), seconds: seconds.into(), error: 0.0 }
    }

    #[test]
    fn ratios_are_paired() {
        let (own, other) = (outcome(&[1.0, 4.0, 2.0]), outcome(&[2.0, 8.0, 2.0]));
        assert_eq!(own.median(), 2.0);
        assert_eq!(own.ratio_to(&other), 2.0);
        assert_eq!(own.best(), 1.0);
        assert!(outcome(&[]).median().is_nan());
    }

    fn small(a: &[f64], answer_to: &[f64]) -> Result<Vec<Outcome>> {
        let shape = Shape { m: 30, n: 7 };
        let reference = Reference::new(answer_to, shape, 1);
        let team = Team::new(1, Pin::No)?;
        let rules = Rules { repeat: 3, deadline: None };
        race(&[Contender::Faer], a, shape, 1, &team, &reference, &rules)
    }

    #[test]
    fn right_results_race_and_wrong_ones_abort() {
        let shape = Shape { m: 30, n: 7 };
        let a = matrix::<f64>(shape, Distribution::Uniform, 1);
        let outcomes = small(&a, &a).unwrap();
        assert_eq!(outcomes[0].seconds.len(), 3);
        let other = matrix::<f64>(shape, Distribution::Uniform, 2);
        assert!(small(&a, &other).unwrap_err().to_string().contains("wrong result"));
    }
}
