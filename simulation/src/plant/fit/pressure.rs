use super::found::Estimate;
use super::minima::from_starts;
use catamaran::base::{Error, Progress, Result};

/// Fewest points of a curve: one more than its constants, and one to judge them by.
const FEWEST: usize = 6;

/// Finds the turgor loss point: the relative water content at which a leaf loses the pressure of
/// its cells. `curve` has the relative water content and the water potential, below 0, in any unit,
/// of one leaf. With the osmotic pressure p of full cells, the apoplastic fraction a, the modulus m
/// and the turgor loss point t the potential is
///
/// `-p (1 - a) / (w - a) + m max(w - t, 0)`
///
/// (Tyree and Hammel 1972, with a linear pressure of cells).
///
/// ```
/// use catamaran_simulation::plant::turgor_loss_point;
///
/// let potential = |w: f64| -1.2 * 0.8 / (w - 0.2) + 8.0 * (w - 0.87_f64).max(0.0);
/// let curve: Vec<[f64; 2]> =
///     (0..12).map(|i| 0.7 + 0.026 * f64::from(i)).map(|w| [w, potential(w)]).collect();
/// let found = turgor_loss_point(&curve)?;
/// assert!((found.value - 0.87).abs() < 1e-4);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Argument`] for fewer than 6 points, or for points out of range;
/// [`Error::NotConverged`] where the curve has no turgor loss point.
pub fn turgor_loss_point(curve: &[[f64; 2]]) -> Result<Estimate> {
    /// Start values of t, from which the descents begin.
    const STARTS: [f64; 3] = [0.8, 0.85, 0.9];
    /// The unit of t and a, so that parameters are of order 1.
    const UNIT: f64 = 0.1;
    let refused = |why: String| Err(Error::Argument { what: "pressure-volume curve", why });
    if curve.len() < FEWEST {
        return refused(format!("must have at least {FEWEST} points, has {}", curve.len()));
    }
    for (i, [water, potential]) in curve.iter().enumerate() {
        if !(*water > 0.3 && *water < 1.1) {
            let range = "must be from 0.3 to 1.1";
            return refused(format!("relative water content {i} {range}, is {water}"));
        }
        if !(*potential < 0.0 && potential.is_finite()) {
            return refused(format!("water potential {i} must be below 0, is {potential}"));
        }
    }
    let driest = curve.iter().map(|point| point[0]).fold(f64::INFINITY, f64::min);
    let size = curve.iter().map(|point| -point[1]).sum::<f64>() / curve.len() as f64;
    let residuals = |x: &[f64]| {
        let (osmotic, apoplast) = (x[0].exp(), UNIT * x[1]);
        let (modulus, point) = (x[2].exp(), UNIT * x[3]);
        let of = |[w, potential]: &[f64; 2]| {
            let model =
                -osmotic * (1.0 - apoplast) / (w - apoplast) + modulus * (w - point).max(0.0);
            model - potential / size
        };
        Ok(curve.iter().map(of).collect())
    };
    // A straight line through the dry part may have its root below 0 by errors of measurement.
    let apoplast = [-0.5, 0.95 * driest].map(|a| a / UNIT);
    let bounds = [[-3.0, 3.0], apoplast, [-3.0, 6.0], [driest / UNIT, 1.0 / UNIT]];
    let starts = STARTS.iter().map(|t| Ok([0.0, 0.1 / UNIT, 1.8, t / UNIT]));
    let minima = from_starts(starts, &residuals, &bounds, Progress::none())?;
    let best = minima.into_iter().min_by(|a, b| a.sum.total_cmp(&b.sum));
    match best {
        Some(best) if best.errors[3].is_finite() => {
            Ok(Estimate { value: UNIT * best.parameters[3], error: UNIT * best.errors[3] })
        }
        best => {
            let residual = best.map_or(f64::NAN, |best| best.sum.sqrt());
            Err(Error::NotConverged { iterations: 0, residual })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use catamaran::base::Rng;

    #[test]
    fn noisy_curves_give_back_the_point_within_its_error() {
        let mut rng = Rng::new(7);
        for point in [0.82, 0.88, 0.92] {
            let mut curve = Vec::new();
            for i in 0..20 {
                let w = 0.68 + 0.016 * f64::from(i);
                let exact = -1.1 * 0.75 / (w - 0.25) + 5.0 * (w - point).max(0.0);
                curve.push([w, exact + 0.01 * rng.normal()]);
            }
            let found = turgor_loss_point(&curve).unwrap();
            assert!((found.value - point).abs() < 3.0 * found.error, "{found:?} {point}");
            assert!(found.error < 0.02);
        }
    }

    #[test]
    fn curves_without_the_point_and_impossible_points_are_refused() {
        let says = |curve: &[[f64; 2]], part: &str| {
            let refused = turgor_loss_point(curve).unwrap_err().to_string();
            assert!(refused.contains(part), "{refused}");
        };
        says(&[[0.9, -1.0]; 5], "at least 6 points, has 5");
        says(&[[0.9, 1.0]; 6], "water potential 0 must be below 0, is 1");
        says(&[[1.5, -1.0]; 6], "relative water content 0 must be from 0.3 to 1.1, is 1.5");
    }
}
