//! The eigenpairs nearest to a requested shift, which may be an eigenvalue or near one.

use super::certificate::{is_complete_around, is_complete_from_below};
use super::eigenpairs::Eigenpairs;
use super::lanczos::{Krylov, Nearby, WIDTH};
use super::options::EigenOptions;
use super::problem::Problem;
use super::space::Inverse;
use crate::base::{Error, Result};

/// Distance of sigma from an eigenvalue, relative to that of others, below which solutions consist
/// of its eigenvector so much that rounding spoils the others.
const NEAR: f64 = 1e-4;

/// How far beside such a shift `W - sigma M` is factorized, relative to the same distance.
const BESIDE: f64 = 1e-2;

/// Largest such distance of sigma from the shift that is not made smaller.
const FAR: f64 = 1e-1;

/// Distances from the shift that count as zero, in units of s.
const ZERO: f64 = 1e-9;

/// Smallest distance of sigma from the shift, relative to the shift.
const ROUNDING: f64 = 1e-12;

/// Largest number of places beside the shift that are tried.
const TRIES: usize = 4;

/// Computes the `options.k` pairs nearest to a shift. If it is an eigenvalue or near one, the
/// factor is that of a sigma beside it, and the pairs are still those nearest to the shift: the
/// iteration goes on until all pairs that can be among them have converged.
pub(crate) fn around(
    problem: &Problem<'_>,
    shift: f64,
    options: &EigenOptions<'_>,
) -> Result<Eigenpairs> {
    let mut step: f64 = 0.0;
    for attempt in 0..=TRIES {
        let sigma = shift - step;
        // The next one if sigma is an eigenvalue.
        let mut next = if step == 0.0 { BESIDE * problem.scale } else { 0.6 * step };
        if let Some(factor) = problem.regular(sigma)? {
            options.progress.report(0.02)?;
            if let Some((krylov, nearby)) = probe(problem, sigma, &*factor, options)? {
                let others = others(&nearby, problem.scale);
                // Farther away no place is tried, however far the others are.
                let is_farthest = step >= BESIDE * problem.scale && nearby.clearance >= 0.5 * step;
                let is_clear =
                    (nearby.clearance >= NEAR * others || is_farthest) && step <= FAR * others;
                if is_clear || attempt == TRIES {
                    return find(problem, krylov, sigma, factor, options)
                        .map_err(|error| if step == 0.0 { error } else { beside(error, shift) });
                }
                let better = BESIDE * others.min(problem.scale);
                if !(0.5..2.0).contains(&(better / step)) {
                    next = better;
                }
            }
        }
        step = next.max(ROUNDING * shift.abs());
    }
    let why = format!("{shift:e} is an eigenvalue up to rounding, as are numbers beside it");
    Err(Error::Argument { what: "shift", why })
}

/// Starts a run, and returns its space and what it tells about the eigenvalues near sigma; `None`
/// where solutions overflow.
fn probe<'a>(
    problem: &'a Problem<'_>,
    sigma: f64,
    factor: &dyn Inverse,
    options: &'a EigenOptions<'_>,
) -> Result<Option<(Krylov<'a>, Nearby)>> {
    let started = problem.start(sigma, factor, options).and_then(|mut krylov| {
        let nearby = krylov.probe(factor)?;
        Ok((krylov, nearby))
    });
    match started {
        Ok(started) => Ok(Some(started)),
        Err(Error::NotConverged { .. }) => Ok(None),
        Err(error) => Err(error),
    }
}

/// Returns the distance from the shift of the eigenvalues beside one that the shift may be near to:
/// the ninth, as a block finds up to eight equal ones, or the next that is not as good as zero.
fn others(nearby: &Nearby, scale: f64) -> f64 {
    let beyond = nearby.from_shift.iter().skip(WIDTH);
    beyond.copied().find(|distance| *distance > ZERO * scale).unwrap_or(scale)
}

/// Continues a run that [`probe`] started.
fn find(
    problem: &Problem<'_>,
    krylov: Krylov<'_>,
    sigma: f64,
    factor: Box<dyn Inverse + '_>,
    options: &EigenOptions<'_>,
) -> Result<Eigenpairs> {
    let shift = options.shift.unwrap_or(sigma);
    // From beside a shift, the nearest eigenvalues need not be the lowest ones.
    let from_below = factor.is_positive() && sigma == shift;
    let below = |value| problem.below(value);
    problem.finish(krylov, sigma, factor, options, |values| match options.verify_count {
        true if from_below => is_complete_from_below(values, problem.scale, below),
        true => is_complete_around(values, shift, problem.scale, below),
        false => Ok(true),
    })
}

/// Returns the error of a run beside the shift.
fn beside(error: Error, shift: f64) -> Error {
    match error {
        Error::NotConverged { .. } => {
            let why = format!("{shift:e} is an eigenvalue or near one, and beside it: {error}");
            Error::Argument { what: "shift", why }
        }
        error => error,
    }
}

#[cfg(test)]
mod tests {
    use sprs::CsMat;

    use super::*;
    use crate::base::Par;
    use crate::sparse::Mass;
    use crate::sparse::path::path;
    use crate::sparse::space::WholePencil;

    #[test]
    fn a_run_that_was_probed_is_the_same_bit_for_bit() {
        let n = 300;
        let (w, mass) = (path(n), Mass::identity(n));
        let pencil = WholePencil { stiffness: w.view(), mass: &mass };
        let problem = Problem::whole(&pencil).unwrap();
        for shift in [0.5, -0.3, 3.99] {
            for k in [1, 5, 60] {
                let options = EigenOptions::new().k(k).shift(shift).par(Par::Seq);
                let factor = problem.any(shift).unwrap();
                let plain = problem.nearest(shift, factor, &options, |_| Ok(true)).unwrap();
                let probed = around(&problem, shift, &options).unwrap();
                assert_eq!(plain.values, probed.values, "{k} near {shift}");
                assert_eq!(plain.vectors, probed.vectors, "{k} near {shift}");
                assert_eq!(plain.residuals, probed.residuals, "{k} near {shift}");
                assert_eq!(plain.solves, probed.solves, "{k} near {shift}");
            }
        }
    }

    #[test]
    fn a_shift_beside_more_equal_eigenvalues_than_the_basis_holds_finds_some_of_them() {
        // 1, and 300 times 2.
        let n = 301;
        let entries = (0..n).map(|i| if i == 0 { 1.0 } else { 2.0 }).collect();
        let w = CsMat::new((n, n), (0..=n).collect(), (0..n).collect(), entries);
        let mass = Mass::identity(n);
        let pencil = WholePencil { stiffness: w.view(), mass: &mass };
        let problem = Problem::whole(&pencil).unwrap();
        for (shift, expected) in [(1.0, [1.0, 2.0, 2.0]), (2.0, [2.0, 2.0, 2.0])] {
            let options = EigenOptions::new().k(3).shift(shift).par(Par::Seq);
            let values = around(&problem, shift, &options).unwrap().values;
            assert_eq!(values.len(), 3);
            for (value, expected) in values.iter().zip(expected) {
                assert!((value - expected).abs() < 1e-9, "{values:?} near {shift}");
            }
        }
    }

    #[test]
    fn a_cluster_beyond_the_pairs_that_are_wanted_need_not_converge() {
        // 0, which is the shift, 0.999, and 300 from -0.99901 to -0.99904: from a sigma below 0
        // they are as near as 0.999.
        let n = 302;
        let cluster = (0..300).map(|i| -0.99901 - 1e-7 * f64::from(i));
        let entries = [0.0, 0.999].into_iter().chain(cluster).collect();
        let w = CsMat::new((n, n), (0..=n).collect(), (0..n).collect(), entries);
        let mass = Mass::identity(n);
        let pencil = WholePencil { stiffness: w.view(), mass: &mass };
        let problem = Problem::whole(&pencil).unwrap();
        // The nearest ones, ascending; those of the cluster are found where they are wanted.
        let all = [-0.9990102, -0.9990101, -0.99901, 0.0, 0.999];
        for (k, expected) in [(2, &all[3..]), (3, &all[2..]), (5, &all[..])] {
            let options = EigenOptions::new().k(k).shift(0.0).par(Par::Seq);
            let values = around(&problem, 0.0, &options).unwrap().values;
            assert_eq!(values.len(), k);
            let is_close = |(x, y): (&f64, &f64)| (x - y).abs() < 1e-9;
            assert!(values.iter().zip(expected).all(is_close), "{k}: {values:?}");
        }
    }

    #[test]
    fn a_long_path_has_the_pair_nearest_to_its_least_eigenvalue() {
        let n = 100_000;
        let (w, mass) = (path(n), Mass::identity(n));
        let pencil = WholePencil { stiffness: w.view(), mass: &mass };
        let problem = Problem::whole(&pencil).unwrap();
        let options = EigenOptions::new().k(1).shift(0.0).par(Par::Seq);
        let pairs = around(&problem, 0.0, &options).unwrap();
        // The next one is 1e-9.
        assert!(pairs.values[0].abs() < 1e-12, "{:?}", pairs.values);
        let root = (n as f64).sqrt().recip();
        let turned = pairs.vectors[(0, 0)].signum();
        assert!((0..n).all(|i| (turned * pairs.vectors[(i, 0)] - root).abs() < 1e-4 * root));
    }

    #[test]
    fn the_eigenvalues_beside_a_shift_are_beyond_those_at_the_shift() {
        let nearby = |zeros: usize| {
            let from_shift = (0..16).map(|i| if i < zeros { 1e-14 } else { i as f64 }).collect();
            others(&Nearby { clearance: 1.0, from_shift }, 0.5)
        };
        assert_eq!(nearby(0), 8.0);
        assert_eq!(nearby(3), 8.0);
        assert_eq!(nearby(12), 12.0);
        assert_eq!(nearby(16), 0.5);
    }
}
