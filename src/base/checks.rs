//! Checks of arguments.

use std::fmt::Display;

use super::error::{Error, Result};
use super::scalar::Real;

/// Checks that `value` is finite and above 0.
///
/// # Errors
/// [`Error::Argument`] of `what` otherwise.
pub fn positive(what: &'static str, value: f64) -> Result<()> {
    if value > 0.0 && value.is_finite() {
        return Ok(());
    }
    Err(Error::Argument { what, why: format!("must be positive and finite, is {}", short(value)) })
}

/// Checks that `value` is finite and at least 0.
///
/// # Errors
/// [`Error::Argument`] of `what` otherwise.
pub fn at_least_zero(what: &'static str, value: f64) -> Result<()> {
    if value >= 0.0 && value.is_finite() {
        return Ok(());
    }
    Err(Error::Argument {
        what,
        why: format!("must be finite and at least 0, is {}", short(value)),
    })
}

/// Checks that `value` is finite.
///
/// # Errors
/// [`Error::Argument`] of `what` otherwise.
pub fn finite(what: &'static str, value: f64) -> Result<()> {
    if value.is_finite() {
        return Ok(());
    }
    Err(Error::Argument { what, why: format!("must be finite, is {value}") })
}

/// Checks that `value` is from `low` to `high`.
///
/// # Errors
/// [`Error::Argument`] of `what` otherwise.
pub fn within<T>(what: &'static str, value: T, low: T, high: T) -> Result<()>
where
    T: Copy + PartialOrd + Display,
{
    if (low..=high).contains(&value) {
        return Ok(());
    }
    let [low, high, value] = [low, high, value].map(short);
    Err(Error::Argument { what, why: format!("must be from {low} to {high}, is {value}") })
}

/// Checks that `value` is above `low` and at most `high`.
///
/// # Errors
/// [`Error::Argument`] of `what` otherwise.
pub fn above(what: &'static str, value: f64, low: f64, high: f64) -> Result<()> {
    if value > low && value <= high {
        return Ok(());
    }
    let [low, high, value] = [low, high, value].map(short);
    let why = format!("must be above {low} and at most {high}, is {value}");
    Err(Error::Argument { what, why })
}

/// Checks that `value` is at least `least`.
///
/// # Errors
/// [`Error::Argument`] of `what` otherwise.
pub fn at_least(what: &'static str, value: usize, least: usize) -> Result<()> {
    if value >= least {
        return Ok(());
    }
    Err(Error::Argument { what, why: format!("must be at least {least}, is {value}") })
}

/// Most digits and signs of a number without an exponent, for which all 64-bit integers are short.
const LONGEST: usize = 20;

/// Formats a number for a message: with an exponent where it would be long without one.
fn short(value: impl Display) -> String {
    let plain = value.to_string();
    match plain.parse::<f64>() {
        Ok(number) if plain.len() > LONGEST => format!("{number:e}"),
        _ => plain,
    }
}

/// Checks that there are `count` finite weights, if any.
///
/// # Errors
/// [`Error::Shape`] for another number of them, [`Error::NonFinite`] otherwise.
pub(crate) fn finite_weights<T: Real>(count: usize, weights: Option<&[T]>) -> Result<()> {
    let Some(weights) = weights else { return Ok(()) };
    Error::check_shape("weights", (count, 1), (weights.len(), 1))?;
    match weights.iter().position(|w| !w.is_finite()) {
        Some(i) => Err(Error::NonFinite { what: "weights", index: (i, 0) }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_hundreds_of_digits_are_written_with_an_exponent() {
        let why = |done: Result<()>| done.unwrap_err().to_string();
        let far = why(within("x", 1e300, -1e9, 1e9));
        assert_eq!(far, "x: must be from -1000000000 to 1000000000, is 1e300");
        assert_eq!(why(within("x", 1e-30_f32, 0.5, 1.0)), "x: must be from 0.5 to 1, is 1e-30");
        assert_eq!(why(within("x", 0.0, 1.5e-30, 1.0)), "x: must be from 1.5e-30 to 1, is 0");
        assert_eq!(
            why(above("x", 2.5e99, 0.0, 1.0)),
            "x: must be above 0 and at most 1, is 2.5e99"
        );
        assert_eq!(why(positive("x", -1e100)), "x: must be positive and finite, is -1e100");
        assert_eq!(why(at_least_zero("x", -1e100)), "x: must be finite and at least 0, is -1e100");
        assert_eq!(why(finite("x", f64::NAN)), "x: must be finite, is NaN");
        let most = u64::MAX;
        assert_eq!(why(within("x", most, 0, 1)), format!("x: must be from 0 to 1, is {most}"));
    }
}
