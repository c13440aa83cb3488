//! Which of several minima is the best, and which the measurements don't tell from it.

use super::super::levenberg::{Minimum, minimize};
use crate::base::{Error, Progress, Result};

/// Of a sum of squares above the least, as a multiple of the variance of a residual: what a
/// likelihood ratio of two parameters exceeds in one of twenty cases (chi^2 with 2 degrees).
const AS_GOOD: f64 = 5.99;

/// Minima are the same if each parameter differs by no more than this, or by three standard errors.
const SAME: f64 = 1e-3;

/// Returns the minima that descents from several starts reach; an error only if none reaches one.
pub(super) fn from_starts<S: AsRef<[f64]>>(
    starts: impl ExactSizeIterator<Item = Result<S>>,
    residuals: &dyn Fn(&[f64]) -> Result<Vec<f64>>,
    bounds: &[[f64; 2]],
    progress: Progress<'_>,
) -> Result<Vec<Minimum>> {
    let (mut minima, mut failure) = (Vec::new(), None);
    let count = starts.len() as f64;
    for (i, start) in starts.enumerate() {
        let progress = progress.part(i as f64 / count..(i + 1) as f64 / count);
        match minimize(residuals, start?.as_ref(), bounds, progress) {
            Ok(minimum) => minima.push(minimum),
            Err(error @ Error::NotConverged { .. }) => failure = Some(error),
            Err(error) => return Err(error),
        }
    }
    match failure {
        Some(error) if minima.is_empty() => Err(error),
        _ => Ok(minima),
    }
}

/// Returns the best of some minima, and those away from it that fit as well, the better ones first,
/// each once; the first `compared` parameters tell minima apart. `None` without minima.
pub(super) fn told_apart(
    mut minima: Vec<Minimum>,
    residuals: usize,
    compared: usize,
) -> Option<(Minimum, Vec<Minimum>)> {
    minima.sort_by(|a, b| a.sum.total_cmp(&b.sum));
    let mut minima = minima.into_iter();
    let best = minima.next()?;
    let freedom = residuals.saturating_sub(best.parameters.len()).max(1) as f64;
    let limit = best.sum * (1.0 + AS_GOOD / freedom);
    let mut others: Vec<Minimum> = Vec::new();
    for minimum in minima.take_while(|m| m.sum <= limit) {
        // What the best one's errors cover is no news; of two others the vaguer one decides.
        let is_known = |other: &Minimum| {
            is_near(other, &minimum, compared) || is_near(&minimum, other, compared)
        };
        if !is_near(&best, &minimum, compared) && !others.iter().any(is_known) {
            others.push(minimum);
        }
    }
    Some((best, others))
}

/// Whether a minimum is within the errors of another one.
fn is_near(of: &Minimum, minimum: &Minimum, compared: usize) -> bool {
    (0..compared).all(|i| {
        // NaN: at a bound.
        let error = if of.errors[i].is_nan() { 0.0 } else { of.errors[i] };
        (of.parameters[i] - minimum.parameters[i]).abs() <= SAME.max(3.0 * error)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn minimum(parameters: [f64; 2], error: f64, sum: f64) -> Minimum {
        Minimum {
            parameters: parameters.into(),
            errors: vec![error; 2],
            deviation: sum.sqrt(),
            sum,
        }
    }

    #[test]
    fn only_minima_away_from_the_best_that_fit_as_well_are_others() {
        let minima = vec![
            minimum([5.0, 0.0], 0.1, 1.2),
            minimum([0.2, 0.1], 0.1, 1.01), // within three errors of the best
            minimum([0.0, 0.0], 0.1, 1.0),
            minimum([3.0, 0.0], 0.1, 1.1),
            minimum([3.1, 0.0], 0.1, 1.12), // the same as the one before
            minimum([9.0, 0.0], 0.1, 2.0),  // fits worse
        ];
        let (best, others) = told_apart(minima.clone(), 12, 2).unwrap();
        assert_eq!(best.parameters, [0.0, 0.0]);
        let found: Vec<f64> = others.iter().map(|m| m.parameters[0]).collect();
        assert_eq!(found, [3.0, 5.0]);
        // Of many residuals the same differences tell more.
        assert!(told_apart(minima, 1000, 2).unwrap().1.is_empty());
        assert!(told_apart(vec![], 12, 2).is_none());
        // A vague one is not counted again where another one is within its errors.
        let vague = vec![
            minimum([0.0, 0.0], 0.1, 1.0),
            minimum([3.0, 0.0], 0.1, 1.1),
            minimum([5.0, 0.0], 2.0, 1.15),
        ];
        assert_eq!(told_apart(vague, 12, 2).unwrap().1.len(), 1);
    }

    #[test]
    fn what_the_data_do_not_tell_makes_no_minimum_of_its_own() {
        let minima = vec![minimum([0.0, 1.0], f64::INFINITY, 1.0), minimum([0.0, 7.0], 0.1, 1.0)];
        assert!(told_apart(minima, 12, 2).unwrap().1.is_empty());
        let at_bound = vec![minimum([0.0, 1.0], f64::NAN, 1.0), minimum([0.0, 7.0], 0.1, 1.0)];
        assert_eq!(told_apart(at_bound, 12, 2).unwrap().1.len(), 1);
    }
}
