//! The race: every contender runs once per repetition, in rotating order, on the same operands, so
//! that disturbances of the machine affect all of them alike.

use std::time::{Duration, Instant};

use catamaran::base::ThreadPool;
use faer::MatMut;

use crate::Result;
use crate::contender::{Contender, Scalar};
use crate::input::Shape;
use crate::product::Product;
use crate::reference::Reference;

/// The rules of a race.
pub struct Rules {
    /// Number of repetitions.
    pub repeat: usize,
    /// A repetition starts only if it is expected to end by then.
    pub deadline: Option<Instant>,
    /// A rival that is slower than the fastest one by more than this factor takes no part in
    /// further repetitions; `None` if all rivals take part in all of them.
    pub patience: Option<f64>,
}

impl Rules {
    /// Returns whether the deadline has passed.
    pub fn time_is_up(&self) -> bool {
        self.deadline.is_some_and(|d| Instant::now() > d)
    }
}

/// The outcome for one contender.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// Name of the contender.
    pub contender: String,
    /// Whether the contender is not this library.
    pub is_rival: bool,
    /// Seconds per call, one for each repetition in which the contender took part: the first ones.
    pub seconds: Vec<f64>,
    /// Largest relative error of any of its runs.
    pub error: f64,
}

/// Least length of a timed sample: shorter calls are repeated within it.
pub(crate) const SAMPLE_SECONDS: f64 = 0.05;
/// Least length of a run that measures how long a call takes.
const TRIAL_SECONDS: f64 = 1e-3;
/// Seconds of samples of a rival before it may count as too slow: two short samples or a long one.
const FAIR_SECONDS: f64 = 1.5 * SAMPLE_SECONDS;
/// Time after which the threads of the previous contender are asleep.
pub(crate) const PAUSE: Duration = Duration::from_millis(20);
/// Side of the leading blocks of A and B on which all contenders warm up.
const WARM_UP_SIDE: usize = 1024;

/// Runs the race. Near the deadline, it returns fewer repetitions, or none.
///
/// # Errors
/// A wrong result ends the race.
pub fn race<T: Scalar>(
    contenders: &[Contender],
    product: Product<'_, T>,
    threads: usize,
    team: &ThreadPool,
    reference: &Reference,
    rules: &Rules,
) -> Result<Vec<Outcome>> {
    let (operation, shape) = (product.operation(), product.shape());
    let Shape { m, n } = shape;
    let views = product.views();
    let mut c = vec![T::ONE; n * n];
    let late = |expected: f64| {
        rules.deadline.is_some_and(|d| Instant::now() + Duration::from_secs_f64(expected) > d)
    };

    let mut outcomes: Vec<_> = contenders
        .iter()
        .map(|x| Outcome {
            contender: x.to_string(),
            is_rival: x.is_rival(),
            seconds: vec![],
            error: 0.0,
        })
        .collect();
    let corner = Shape { m: m.min(WARM_UP_SIDE), n: n.min(WARM_UP_SIDE) };
    let corners = views.map(|x| x.submatrix(0, 0, corner.m, corner.n));
    let mut calls = Vec::with_capacity(contenders.len());
    let mut round_seconds = 0.0;
    for contender in contenders {
        let mut c = MatMut::from_row_major_slice_mut(&mut c, n, n);
        let mut seconds = |calls: usize| {
            let c = c.as_mut().submatrix_mut(0, 0, corner.n, corner.n);
            let time = contender.run(operation, corners, c, calls, threads, team);
            time.map(|t| t.as_secs_f64() / calls as f64)
        };
        // The first call includes the creation of threads and buffers.
        seconds(1)?;
        let rough = seconds(1)?;
        let trial = seconds(calls_within(TRIAL_SECONDS, rough))?;
        let one_call = trial * operation.flops(shape) / operation.flops(corner);
        calls.push(calls_within(SAMPLE_SECONDS, one_call));
        round_seconds += one_call * calls[calls.len() - 1] as f64;
    }

    let mut racing: Vec<_> = (0..contenders.len()).collect();
    for round in 0..rules.repeat {
        if late(round_seconds) {
            break;
        }
        let start = Instant::now();
        for turn in 0..racing.len() {
            let i = racing[(round + turn) % racing.len()];
            reference.poison(&mut c);
            std::thread::sleep(PAUSE);
            let view = MatMut::from_row_major_slice_mut(&mut c, n, n);
            let time = contenders[i].run(operation, views, view, calls[i], threads, team)?;
            let error = reference
                .check(&c)
                .map_err(|e| format!("{}, {shape}, {}: {e}", contenders[i], T::NAME))?;
            outcomes[i].seconds.push(time.as_secs_f64() / calls[i] as f64);
            outcomes[i].error = outcomes[i].error.max(error);
        }
        round_seconds = start.elapsed().as_secs_f64();
        if let Some(patience) = rules.patience {
            let slow = too_slow(&outcomes, &calls, patience);
            racing.retain(|&i| !slow[i]);
        }
    }
    Ok(outcomes)
}

/// Returns which outcomes, from this number of calls per sample, are those of rivals slower than
/// the fastest rival by more than `patience`.
fn too_slow(outcomes: &[Outcome], calls: &[usize], patience: f64) -> Vec<bool> {
    let rivals = outcomes.iter().filter(|o| o.is_rival);
    let least = rivals.map(Outcome::best).fold(f64::INFINITY, f64::min);
    let slow = |(o, &calls): (&Outcome, &usize)| {
        let sampled = o.seconds.iter().sum::<f64>() * calls as f64;
        o.is_rival && sampled >= FAIR_SECONDS && o.best() > patience * least
    };
    outcomes.iter().zip(calls).map(slow).collect()
}

/// Returns how many calls of `one_call` seconds last `seconds`, at least one. A call takes at least
/// the resolution of the clock.
pub(crate) fn calls_within(seconds: f64, one_call: f64) -> usize {
    (seconds / one_call.max(1e-7)).ceil() as usize
}

impl Outcome {
    /// Returns the median seconds.
    pub fn median(&self) -> f64 {
        median(self.seconds.clone())
    }

    /// Returns the seconds of the fastest repetition, which other programs disturbed least.
    pub fn best(&self) -> f64 {
        self.seconds.iter().copied().fold(f64::NAN, f64::min)
    }

    /// Returns the speed relative to `other`: the median over the repetitions, each of which
    /// measured both.
    pub fn ratio_to(&self, other: &Self) -> f64 {
        median(self.seconds.iter().zip(&other.seconds).map(|(own, other)| other / own).collect())
    }
}

/// Returns the median; NaN for no values.
pub fn median(mut values: Vec<f64>) -> f64 {
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
        Outcome { contender: String::new(), is_rival: true, seconds: seconds.into(), error: 0.0 }
    }

    #[test]
    fn slow_rivals_are_found_after_enough_samples() {
        let ours = Outcome { is_rival: false, ..outcome(&[9.0]) };
        let rivals = [outcome(&[1.0]), outcome(&[1.4]), outcome(&[7.0, 1.6])];
        let outcomes = [&[ours], &rivals[..]].concat();
        assert_eq!(too_slow(&outcomes, &[1; 4], 1.5), [false, false, false, true]);
        let short = [outcome(&[1e-3]), outcome(&[3e-3]), outcome(&[3e-3, 3e-3])];
        assert_eq!(too_slow(&short, &[50, 17, 17], 1.5), [false, false, true]);
    }

    #[test]
    fn samples_have_at_least_one_call() {
        assert_eq!(calls_within(0.5, 0.125), 4);
        assert_eq!(calls_within(0.5, 0.3), 2);
        assert_eq!(calls_within(0.5, 7.0), 1);
        assert!(calls_within(1e-3, 0.0) <= 10_001);
    }

    #[test]
    fn ratios_are_paired() {
        let (own, other) = (outcome(&[1.0, 4.0, 2.0]), outcome(&[2.0, 8.0, 2.0]));
        assert_eq!(own.median(), 2.0);
        assert_eq!(own.ratio_to(&other), 2.0);
        assert_eq!(own.best(), 1.0);
        assert!(outcome(&[]).median().is_nan());
    }

    const SHAPE: Shape = Shape { m: 30, n: 7 };

    fn small(product: Product<'_, f64>, answer_to: Product<'_, f64>) -> Result<Vec<Outcome>> {
        let reference = Reference::new(&answer_to, 1, 1);
        let team = ThreadPool::new(1, Pin::No)?;
        let rules = Rules { repeat: 3, deadline: None, patience: None };
        let ours = Contender::Ours { name: "auto/native".into(), options: Box::default() };
        race(&[Contender::Faer, ours], product, 1, &team, &reference, &rules)
    }

    #[test]
    fn right_results_race_and_wrong_ones_abort() {
        let [a, b] = [1, 2].map(|seed| matrix::<f64>(SHAPE, Distribution::Uniform, seed));
        let symmetric = [Product::syrk(SHAPE, &a), Product::syrk(SHAPE, &b)];
        let general = [Product::gemm(SHAPE, &a, &b), Product::gemm(SHAPE, &b, &a)];
        for [product, other] in [symmetric, general] {
            let outcomes = small(product, product).unwrap();
            assert!(outcomes.iter().all(|o| o.seconds.len() == 3));
            assert!(small(product, other).unwrap_err().to_string().contains("wrong result"));
        }
    }
}
