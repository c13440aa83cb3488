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
    Err(Error::Argument { what, why: format!("must be positive and finite, is {value}") })
}

/// Checks that `value` is finite and at least 0.
///
/// # Errors
/// [`Error::Argument`] of `what` otherwise.
pub fn at_least_zero(what: &'static str, value: f64) -> Result<()> {
    if value >= 0.0 && value.is_finite() {
        return Ok(());
    }
    Err(Error::Argument { what, why: format!("must be finite and at least 0, is {value}") })
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
