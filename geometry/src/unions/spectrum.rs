use super::network::K;
use catamaran::base::{Error, Result};

/// Eigenvalues must lie between this and its inverse, so that computations neither overflow nor
/// underflow.
const LEAST: f64 = 1e-150;

/// Checks that `values` are [`K`] Dirichlet eigenvalues: positive, finite and ascending.
pub(super) fn check(what: &'static str, values: &[f64]) -> Result<[f64; K]> {
    let Ok(spectrum) = <[f64; K]>::try_from(values) else {
        return Err(Error::Shape { what, expected: (K, 1), got: (values.len(), 1) });
    };
    if let Some(i) = values.iter().position(|x| !x.is_finite()) {
        return Err(Error::NonFinite { what, index: (i, 0) });
    }
    let refuse = |why: String| Err(Error::Argument { what, why });
    if let Some(i) = values.iter().position(|x| *x <= 0.0) {
        return refuse(format!(
            "Dirichlet eigenvalues must be positive, but number {i} (from 0) is {:e}",
            values[i]
        ));
    }
    if let Some(i) = (1..K).find(|&i| values[i] < values[i - 1]) {
        return refuse(format!(
            "must ascend, but {:e} at {i} follows {:e}",
            values[i],
            values[i - 1]
        ));
    }
    if values[0] < LEAST || values[K - 1] > 1.0 / LEAST {
        return refuse(format!("must lie between {LEAST:e} and {:e}", 1.0 / LEAST));
    }
    Ok(spectrum)
}

/// Returns `(1 - t) first + t second`, a spectrum between the two for t in [0, 1] (thesis, section
/// 2.6.2).
///
/// ```
/// use catamaran_geometry::unions::{K, interpolate};
///
/// let first: Vec<f64> = (1..=K).map(|k| 40.0 * k as f64).collect();
/// let second: Vec<f64> = (1..=K).map(|k| 80.0 * k as f64).collect();
/// assert_eq!(interpolate(&first, &second, 0.5)?[2], 180.0);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// As [`SpectralUnion::predict`](super::SpectralUnion::predict); [`Error::Argument`] for t outside
/// of [0, 1].
pub fn interpolate(first: &[f64], second: &[f64], t: f64) -> Result<[f64; K]> {
    let (first, second) = (check("first", first)?, check("second", second)?);
    if !(0.0..=1.0).contains(&t) {
        return Err(Error::Argument { what: "t", why: format!("must be in [0, 1], is {t}") });
    }
    Ok(std::array::from_fn(|i| (1.0 - t) * first[i] + t * second[i]))
}

/// Returns the non-decreasing sequence nearest to `values` in the maximum norm: entry i is half the
/// sum of the largest value up to i and the smallest value from i on. Rounding does not break the
/// order. If an ascending sequence bounds `values`, it bounds the result, too.
pub(super) fn ascending(values: &[f64; K]) -> [f64; K] {
    let mut above = *values;
    for i in 1..K {
        above[i] = above[i].max(above[i - 1]);
    }
    let mut below = *values;
    for i in (1..K).rev() {
        below[i - 1] = below[i - 1].min(below[i]);
    }
    std::array::from_fn(|i| 0.5 * (above[i] + below[i]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use catamaran::base::Rng;

    fn squares() -> [f64; K] {
        std::array::from_fn(|i| ((i + 1) * (i + 1)) as f64)
    }

    #[test]
    fn what_is_no_spectrum_is_named() {
        let with = |i: usize, x: f64| {
            let mut values = squares();
            values[i] = x;
            check("first", &values).map_err(|e| e.to_string())
        };
        assert!(with(0, 1.0).is_ok());
        assert!(with(3, f64::NAN).unwrap_err().starts_with("first: not finite at row 3"));
        assert!(with(0, 0.0).unwrap_err().contains("number 0 (from 0) is 0e0"));
        assert!(with(0, -1.0).unwrap_err().contains("positive"));
        assert!(with(5, 3.0).unwrap_err().contains("must ascend, but 3e0 at 5"));
        assert!(with(19, 1e200).unwrap_err().contains("between"));
        assert!(matches!(check("b", &[1.0; 19]), Err(Error::Shape { got: (19, 1), .. })));
    }

    #[test]
    fn interpolation_goes_from_one_to_the_other() {
        let (a, b) = (squares(), squares().map(|x| 3.0 * x));
        assert_eq!(interpolate(&a, &b, 0.0).unwrap(), a);
        assert_eq!(interpolate(&a, &b, 1.0).unwrap(), b);
        assert_eq!(interpolate(&a, &b, 0.5).unwrap(), squares().map(|x| 2.0 * x));
        assert!(interpolate(&a, &b, 1.5).is_err() && interpolate(&a, &b, f64::NAN).is_err());
    }

    #[test]
    fn sequences_are_made_ascending_and_no_farther_from_an_ascending_one() {
        let mut rng = Rng::new(1);
        for _ in 0..200 {
            let truth = squares();
            let noisy = truth.map(|x| x + 30.0 * rng.normal());
            let found = ascending(&noisy);
            assert!(found.is_sorted());
            let error = |values: &[f64; K]| {
                values.iter().zip(truth).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
            };
            assert!(error(&found) <= error(&noisy));
            assert_eq!(ascending(&found), found);
        }
        assert_eq!(ascending(&squares()), squares());
    }
}
