//! Nonlinear least squares with bounds: the method of Levenberg (1944) and Marquardt (1963),
//! projected onto a box.

use faer::Mat;

use catamaran::base::{Error, Progress, Result};
use catamaran::dense;

/// Half of the interval of central differences, in the units of parameters, which are of order 1.
const DIFFERENCE: f64 = 1e-4;

/// A change of all parameters at which the iteration stops.
const SMALL: f64 = 1e-11;

/// The largest change of a parameter in a step, within which the linear model is trusted.
const LARGEST_STEP: f64 = 1.0;

const MAX_ITERATIONS: usize = 200;

/// The minimum of a sum of squares.
#[derive(Debug, Clone)]
pub(super) struct Minimum {
    pub parameters: Vec<f64>,
    /// Standard deviations of parameters; infinite where the data do not determine them, NaN at a
    /// bound.
    pub errors: Vec<f64>,
    /// The standard deviation of a residual.
    pub deviation: f64,
    /// The sum of squares.
    pub sum: f64,
}

/// The residuals as a function of the parameters.
pub(super) type Residuals<'a> = &'a dyn Fn(&[f64]) -> Result<Vec<f64>>;

/// Finds the minimum of the sum of squares near `start`, between bounds, by central differences. In
/// each step, parameters at a bound that would leave the box stay.
///
/// # Errors
/// Those of residuals; [`Error::Argument`] unless there are more residuals than parameters;
/// [`Error::NotConverged`], [`Error::Cancelled`].
pub(super) fn minimize(
    residuals: Residuals<'_>,
    start: &[f64],
    bounds: &[[f64; 2]],
    progress: Progress<'_>,
) -> Result<Minimum> {
    let mut x: Vec<f64> =
        start.iter().zip(bounds).map(|(x, [low, high])| x.clamp(*low, *high)).collect();
    let mut r = residuals(&x)?;
    if r.len() <= x.len() {
        let why = format!("must be more than {}, are {}", x.len(), r.len());
        return Err(Error::Argument { what: "measurements", why });
    }
    let mut damping = 1e-3;
    for iteration in 0..MAX_ITERATIONS {
        progress.report(iteration as f64 / MAX_ITERATIONS as f64)?;
        let jacobian = jacobian(residuals, &x, bounds)?;
        let gradient: Vec<f64> = jacobian.iter().map(|column| product(column, &r)).collect();
        let free: Vec<usize> = (0..x.len())
            .filter(|&i| {
                let [low, high] = bounds[i];
                !(x[i] <= low && gradient[i] > 0.0 || x[i] >= high && gradient[i] < 0.0)
            })
            .collect();
        let finished = |x: Vec<f64>, r: &[f64]| {
            let freedom = (r.len() - free.len()) as f64;
            let sum = product(r, r);
            let deviation = (sum / freedom).sqrt();
            let errors = errors(&jacobian, &free, deviation);
            Minimum { parameters: x, errors, deviation, sum }
        };
        loop {
            let step = step(&jacobian, &gradient, &free, damping)?;
            let mut next = x.clone();
            for (&i, d) in free.iter().zip(&step) {
                let d = d.clamp(-LARGEST_STEP, LARGEST_STEP);
                next[i] = (x[i] + d).clamp(bounds[i][0], bounds[i][1]);
            }
            let moved = x.iter().zip(&next).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            if moved <= SMALL {
                return Ok(finished(x, &r));
            }
            let tried = residuals(&next)?;
            if product(&tried, &tried) < product(&r, &r) {
                (x, r) = (next, tried);
                damping = (0.1 * damping).max(1e-12);
                break;
            }
            damping *= 8.0;
        }
    }
    Err(Error::NotConverged { iterations: MAX_ITERATIONS, residual: product(&r, &r).sqrt() })
}

fn product(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Returns the derivatives of the residuals, a column for each parameter.
fn jacobian(residuals: Residuals<'_>, x: &[f64], bounds: &[[f64; 2]]) -> Result<Vec<Vec<f64>>> {
    let mut columns = Vec::with_capacity(x.len());
    for i in 0..x.len() {
        let at = |shift: f64| -> Result<(f64, Vec<f64>)> {
            let mut x = x.to_vec();
            x[i] = (x[i] + shift).clamp(bounds[i][0], bounds[i][1]);
            Ok((x[i], residuals(&x)?))
        };
        let ((low, below), (high, above)) = (at(-DIFFERENCE)?, at(DIFFERENCE)?);
        let width = (high - low).max(f64::MIN_POSITIVE);
        columns.push(above.iter().zip(&below).map(|(a, b)| (a - b) / width).collect());
    }
    Ok(columns)
}

/// Returns the step of the free parameters: `(J^T J + damping diag(J^T J)) step = -J^T r`.
fn step(jacobian: &[Vec<f64>], gradient: &[f64], free: &[usize], damping: f64) -> Result<Vec<f64>> {
    let mut right = Mat::from_fn(free.len(), 1, |i, _| -gradient[free[i]]);
    let mut matrix = squared(jacobian, free);
    for i in 0..free.len() {
        // A parameter that changes no residual does not move.
        let own = matrix[(i, i)];
        matrix[(i, i)] = if own > 0.0 { own * (1.0 + damping) } else { 1.0 };
    }
    if free.is_empty() || dense::cholesky(matrix.as_mut())?.is_err() {
        return Ok(vec![0.0; free.len()]);
    }
    dense::lower_solve_in_place(matrix.as_ref(), right.as_mut());
    dense::upper_solve_in_place(matrix.transpose(), right.as_mut());
    Ok((0..free.len()).map(|i| right[(i, 0)]).collect())
}

/// Returns `J^T J` for some parameters.
fn squared(jacobian: &[Vec<f64>], free: &[usize]) -> Mat<f64> {
    let entry = |i: usize, j: usize| product(&jacobian[free[i]], &jacobian[free[j]]);
    Mat::from_fn(free.len(), free.len(), entry)
}

/// Returns the square roots of the diagonal of `deviation^2 (J^T J)^-1`, computed with columns of
/// length 1.
fn errors(jacobian: &[Vec<f64>], free: &[usize], deviation: f64) -> Vec<f64> {
    let mut errors = vec![f64::NAN; jacobian.len()];
    free.iter().for_each(|&i| errors[i] = f64::INFINITY);
    let known: Vec<usize> =
        free.iter().copied().filter(|&i| product(&jacobian[i], &jacobian[i]) > 0.0).collect();
    let lengths: Vec<f64> = known.iter().map(|&i| norm(&jacobian[i])).collect();
    let square = squared(jacobian, &known);
    let mut matrix =
        Mat::from_fn(known.len(), known.len(), |i, j| square[(i, j)] / (lengths[i] * lengths[j]));
    if known.is_empty() || !matches!(dense::cholesky(matrix.as_mut()), Ok(Ok(_))) {
        return errors;
    }
    let mut inverse = Mat::<f64>::identity(known.len(), known.len());
    dense::lower_solve_in_place(matrix.as_ref(), inverse.as_mut());
    for (k, &i) in known.iter().enumerate() {
        let variance: f64 = (0..known.len()).map(|j| inverse[(j, k)].powi(2)).sum();
        errors[i] = deviation * variance.sqrt() / lengths[k];
    }
    errors
}

fn norm(a: &[f64]) -> f64 {
    product(a, a).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use catamaran::base::Rng;

    const FREE: [[f64; 2]; 2] = [[f64::NEG_INFINITY, f64::INFINITY]; 2];

    /// Returns `y = a exp(-b t)` at 12 times, with noise.
    fn decay(a: f64, b: f64, noise: f64, rng: &mut Rng) -> Vec<[f64; 2]> {
        let time = |i: usize| 0.25 * i as f64;
        (0..12).map(|i| [time(i), a * (-b * time(i)).exp() + noise * rng.normal()]).collect()
    }

    fn fit(data: &[[f64; 2]], bounds: &[[f64; 2]]) -> Minimum {
        let residuals =
            |x: &[f64]| Ok(data.iter().map(|[t, y]| y - x[0] * (-x[1] * t).exp()).collect());
        minimize(&residuals, &[1.0, 0.1], bounds, Progress::none()).unwrap()
    }

    #[test]
    fn exact_data_give_back_their_parameters() {
        let found = fit(&decay(2.0, 0.7, 0.0, &mut Rng::new(0)), &FREE);
        assert!((found.parameters[0] - 2.0).abs() < 1e-10, "{:?}", found.parameters);
        assert!((found.parameters[1] - 0.7).abs() < 1e-10);
    }

    #[test]
    fn standard_errors_are_the_scatter_of_many_fits() {
        let mut rng = Rng::new(5);
        let fits: Vec<Minimum> =
            (0..400).map(|_| fit(&decay(2.0, 0.7, 0.02, &mut rng), &FREE)).collect();
        for (i, truth) in [2.0, 0.7].into_iter().enumerate() {
            let mean = |f: &dyn Fn(&Minimum) -> f64| fits.iter().map(f).sum::<f64>() / 400.0;
            let scatter = mean(&|x| (x.parameters[i] - truth).powi(2)).sqrt();
            let stated = mean(&|x| x.errors[i].powi(2)).sqrt();
            // The deviation of 400 samples has a relative error of 1 / sqrt(800) = 3.5 %.
            assert!((stated / scatter - 1.0).abs() < 0.12, "{i}: {stated} {scatter}");
        }
    }

    #[test]
    fn a_bound_holds_and_the_others_are_the_best_there() {
        let data = decay(2.0, 0.7, 0.0, &mut Rng::new(0));
        let found = fit(&data, &[[0.0, 1.5], FREE[1]]);
        assert_eq!(found.parameters[0], 1.5);
        assert!(found.errors[0].is_nan() && found.errors[1] > 0.0);
        // The derivative with respect to the other parameter is 0.
        let slope = |b: f64| -> f64 {
            let of = |[t, y]: &[f64; 2]| (y - 1.5 * (-b * t).exp()) * 1.5 * t * (-b * t).exp();
            data.iter().map(of).sum()
        };
        assert!(slope(found.parameters[1]).abs() < 1e-8, "{}", slope(found.parameters[1]));
    }

    #[test]
    fn what_no_residual_depends_on_stays_and_has_no_error_bar() {
        let residuals = |x: &[f64]| Ok(vec![x[0] - 1.0, x[0] - 2.0, x[0] - 3.0]);
        let found = minimize(&residuals, &[0.0, 7.0], &FREE, Progress::none()).unwrap();
        // A sum of squares determines parameters to the square root of the rounding error.
        assert!((found.parameters[0] - 2.0).abs() < 1e-7 && found.parameters[1] == 7.0);
        assert_eq!(found.errors[1], f64::INFINITY);
        let few = minimize(&residuals, &[0.0; 3], &[FREE[0]; 3], Progress::none());
        assert!(few.is_err_and(|e| e.to_string().contains("more than 3")));
    }
}
