//! The station of least squares: polynomials through whole numbers, solved in three ways.

use anyhow::Result;
use catamaran::faer::linalg::solvers::{Llt, Qr, SolveCore, SolveLstsqCore};
use catamaran::faer::{Conj, Mat, MatRef, Side};
use catamaran::solve::{LeastSquaresOptions, lstsq};
use catamaran_charts::{Axis, Chart, Rgb, Series, svg};
use minijinja::context;
use minijinja::value::Value;

use super::Site;
use super::page::Station;
use crate::progress::Bar;

/// Points t = 0, 1, ... of the polynomials.
const POINTS: usize = 21;
/// Degrees for which powers of t and their sums are whole numbers below 2^53.
const MOST: usize = 11;
/// What stands for an error of zero in the picture: half a unit roundoff.
const NO_ERROR: f64 = f64::EPSILON / 4.0;

/// Solves `min |A x - b|`; `None` where the way breaks down.
type Solve = fn(MatRef<'_, f64>, MatRef<'_, f64>) -> Result<Option<Mat<f64>>>;

/// A way to solve.
struct Way {
    name: &'static str,
    color: Rgb,
    solve: Solve,
}

/// Later ones are drawn above.
const WAYS: [Way; 3] = [
    Way { name: "normal equations", color: [0xb4, 0x44, 0x3c], solve: normal_equations },
    Way { name: "QR", color: [0x8a, 0x8a, 0x8a], solve: qr },
    Way { name: "catamaran::solve::lstsq", color: [0x1f, 0x6f, 0xb4], solve: ours },
];

/// The fit of one degree: the condition number of its columns, and the largest relative error of a
/// coefficient in each way; none where the way gives no solution.
struct Fit {
    degree: usize,
    condition: f64,
    errors: [Option<f64>; WAYS.len()],
}

/// Computes and describes it.
pub fn station(_: &Site<'_>) -> Result<Station> {
    let bar = Bar::new("least squares");
    let mut fits = Vec::new();
    for degree in 1..=MOST {
        fits.push(fit(degree)?);
        bar.step(degree as f64 / MOST as f64)?;
    }
    drop(bar);
    describe(&fits)
}

/// Returns the polynomial with coefficients 1 through its own values (as NIST's data set Wampler1).
fn fit(degree: usize) -> Result<Fit> {
    let a = Mat::from_fn(POINTS, degree + 1, |t, power| (t as f64).powi(power as i32));
    let b = Mat::from_fn(POINTS, 1, |t, _| a.row(t).iter().sum());
    let condition = lstsq(a.as_ref(), b.as_ref(), None, &LeastSquaresOptions::new())?.condition;
    let mut errors = [None; WAYS.len()];
    for (way, error) in WAYS.iter().zip(&mut errors) {
        let solution = (way.solve)(a.as_ref(), b.as_ref())?;
        *error = solution.map(|x| x.col(0).iter().map(|x| (x - 1.0).abs()).fold(0.0, f64::max));
    }
    Ok(Fit { degree, condition, errors })
}

/// Solves by a Cholesky factor of A^T A in f64, which may break down.
fn normal_equations(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> Result<Option<Mat<f64>>> {
    let (gram, mut x) = (a.transpose() * a, a.transpose() * b);
    let Ok(factor) = Llt::new(gram.as_ref(), Side::Lower) else { return Ok(None) };
    factor.solve_in_place_with_conj(Conj::No, x.as_mut());
    Ok(Some(x))
}

/// Solves by Householder's QR factors of A.
fn qr(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> Result<Option<Mat<f64>>> {
    let mut x = b.to_owned();
    Qr::new(a).solve_lstsq_in_place_with_conj(Conj::No, x.as_mut());
    Ok(Some(x.subrows(0, a.ncols()).to_owned()))
}

fn ours(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> Result<Option<Mat<f64>>> {
    Ok(Some(lstsq(a, b, None, &LeastSquaresOptions::new())?.coefficients))
}

fn describe(fits: &[Fit]) -> Result<Station> {
    let row = |fit: &Fit| {
        context! {
            degree => fit.degree,
            condition => format!("{:.1e}", fit.condition),
            digits => correct_digits(&fit.errors),
        }
    };
    let values = context! {
        last_point => POINTS - 1,
        // Of the highest degree.
        digits => fits.last().map(|fit| correct_digits(&fit.errors)),
        errors => chart_of_errors(fits),
        fits => fits.iter().map(row).collect::<Vec<_>>(),
    };
    let template = include_str!("stations/gram.html");
    Station::new("gram", "Least squares from A<sup>T</sup>A", template, values)
}

fn chart_of_errors(fits: &[Fit]) -> String {
    let curve = |(k, way): (usize, &Way)| {
        let error = |fit: &Fit| Some((fit.degree as f64, fit.errors[k]?.clamp(NO_ERROR, 1.0)));
        Series::curve(way.name, way.color, fits.iter().filter_map(error).collect())
    };
    let chart = Chart::new(
        Axis::whole("degree"),
        Axis::log10("largest relative error"),
        WAYS.iter().enumerate().map(curve).collect(),
    );
    svg(&[chart])
}

/// Returns the correct decimal digits in each way, from its error.
fn correct_digits(errors: &[Option<f64>; WAYS.len()]) -> Value {
    let [normal_equations, qr, ours] = errors.map(|error| match error {
        None => "breaks down".into(),
        Some(0.0) => "all".into(),
        Some(error) => format!("{:.1}", (-error.log10()).max(0.0)),
    });
    context! { normal_equations, qr, ours }
}
