//! Selects the best of several minima, and those that the measurements do not distinguish from it.

use super::levenberg::{Minimum, minimize};
use catamaran::base::{Error, Progress, Result};

/// Difference of a sum of squares from the least one, relative to the variance of a residual, that
/// a likelihood ratio of two parameters exceeds in one of twenty cases (chi^2 with 2 degrees of
/// freedom).
const AS_GOOD: f64 = 5.99;

/// Minima are equal if each parameter differs by no more than this, or by three standard errors.
const SAME: f64 = 1e-3;

/// Returns the minima that descents from several starts reach; returns an error only if none
/// reaches one.
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

/// Returns the best of some minima, and other minima that fit equally well, the better ones first,
/// each once. Minima are compared by their first `compared` parameters. Returns `None` without
/// minima.
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
        // A minimum within the errors of the best one is not another minimum; of two others, the
        // larger errors decide.
        let is_known = |other: &Minimum| {
            is_near(other, &minimum, compared) || is_near(&minimum, other, compared)
        };
        if !is_near(&best, &minimum, compared) && !others.iter().any(is_known) {
            others.push(minimum);
        }
    }
    Some((best, others))
}

/// Returns whether a minimum is within the errors of another one.
fn is_near(of: &Minimum, minimum: &Minimum, compared: usize) -> bool {
    (0..compared).all(|i| {
        // NaN marks a parameter at a bound.
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
            minimum([3.1, 0.0], 0.1, 1.12), // the same as the previous one
            minimum([9.0, 0.0], 0.1, 2.0),  // fits worse
        ];
        let (best, others) = told_apart(minima.clone(), 12, 2).unwrap();
        assert_eq!(best.parameters, [0.0, 0.0]);
        let found: Vec<f64> = others.iter().map(|m| m.parameters[0]).collect();
        assert_eq!(found, [3.0, 5.0]);
        // With many residuals, the same differences distinguish minima better.
        assert!(told_apart(minima, 1000, 2).unwrap().1.is_empty());
        assert!(told_apart(vec![], 12, 2).is_none());
        // A minimum with large errors is not counted again if another one is within its errors.
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
