use std::ops::Range;

use faer::Mat;
use sprs::CsMatView;

use super::Mass;
use super::around::around;
use super::certificate::{Certificate, ROUNDINGS, certify, is_complete_from_below};
use super::check::check_symmetric;
use super::components::null_components;
use super::eigenpairs::{Eigenpairs, ascending};
use super::lanczos::{WIDTH, basis_size};
use super::options::EigenOptions;
use super::problem::{Problem, not_semi_definite, scale};
use super::small::dense_pairs;
use super::space::{Pencil, WholePencil};
use crate::base::{Result, check_request};
use crate::dense::filled;

/// Computes the k smallest eigenvalues of `W phi = lambda M phi`, or the k eigenvalues nearest to a
/// shift, and their eigenvectors.
///
/// W (n x n) is symmetric, all entries stored, by rows or by columns; positive semi-definite unless
/// a shift is given. Shift-invert block Lanczos with thick restart (Wu and Simon 2000; Grimes,
/// Lewis and Simon 1994) on a sparse Cholesky factorization of `W - sigma M`. Without a shift,
/// `sigma = -s`, where n s is the median of `W_ii / M_ii`: for a surface of area A of equilateral
/// triangles `s = 2 sqrt(3) / A`, the size of its first eigenvalues. With a shift, sigma is the
/// shift, or a number beside it if the shift is an eigenvalue or near one, or `-s` if the shift and
/// -s are below all eigenvalues. Null vectors that are constant on components of the graph of W are
/// not iterated, however many there are ([`free_components`](super::free_components) counts them):
/// their eigenvalues are 0. Other eigenvalues of more than 8 dimensions are complete only under
/// [`EigenOptions::verify_count`]. Without a shift, eigenvalues that rounding or the tolerance
/// (relative to s) leaves below 0 are returned as 0, and smaller ones are an error; where all k
/// pairs are null vectors, one more factorization looks for these.
///
/// The result is the same, bit for bit, for every `options.par`. Memory: about `2 k + 80` vectors
/// of n, the result, and the factor.
///
/// ```
/// use catamaran::prelude::*;
/// use catamaran::sparse::Mass;
///
/// // A ring of 100 nodes: eigenvalues 2 - 2 cos(2 pi j / 100), for j and -j.
/// let mut ring = sprs::TriMat::new((100, 100));
/// for (i, j) in (0..100).map(|i| (i, (i + 1) % 100)) {
///     for (i, j, x) in [(i, i, 1.0), (j, j, 1.0), (i, j, -1.0), (j, i, -1.0)] {
///         ring.add_triplet(i, j, x);
///     }
/// }
/// let (ring, mass) = (ring.to_csr::<usize>(), Mass::identity(100));
/// let pairs = eigs(ring.view(), &mass, &EigenOptions::new().k(3))?;
/// assert!(pairs.values[0].abs() < 1e-9); // constants
/// assert!((pairs.values[2] - 0.003946543).abs() < 1e-9);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Shape`], [`Error::NonFinite`] and [`Error::Argument`] name W ("stiffness"), "mass" or
/// the option at fault; [`Error::OutOfMemory`], [`Error::Cancelled`]; [`Error::NotConverged`] with
/// the restarts done and the largest residual, or [`Error::Argument`] of "shift" where the shift is
/// an eigenvalue or near one.
///
/// [`Error::Shape`]: crate::Error::Shape
/// [`Error::NonFinite`]: crate::Error::NonFinite
/// [`Error::Argument`]: crate::Error::Argument
/// [`Error::OutOfMemory`]: crate::Error::OutOfMemory
/// [`Error::Cancelled`]: crate::Error::Cancelled
/// [`Error::NotConverged`]: crate::Error::NotConverged
pub fn eigs(
    stiffness: CsMatView<'_, f64>,
    mass: &Mass,
    options: &EigenOptions<'_>,
) -> Result<Eigenpairs> {
    options.progress.watch(|| find(stiffness, mass, options))
}

fn find(
    stiffness: CsMatView<'_, f64>,
    mass: &Mass,
    options: &EigenOptions<'_>,
) -> Result<Eigenpairs> {
    check(stiffness, mass, options)?;
    let pencil = WholePencil { stiffness, mass };
    if let Some(pairs) = without_iteration(&pencil, stiffness, mass, options)? {
        return Ok(pairs);
    }
    let problem = Problem::whole(&pencil)?;
    options.progress.report(0.01)?;
    one_window(&problem, options)
}

/// Returns the pairs where none are wanted or the matrices are small. The matrices, which have been
/// checked, are those of the pencil, with all rows.
pub(crate) fn without_iteration(
    pencil: &dyn Pencil,
    stiffness: CsMatView<'_, f64>,
    mass: &Mass,
    options: &EigenOptions<'_>,
) -> Result<Option<Eigenpairs>> {
    if options.k == 0 {
        let vectors = Mat::zeros(pencil.inner().rows().len(), 0);
        return Ok(Some(Eigenpairs { values: vec![], vectors, residuals: vec![], solves: 0 }));
    }
    match is_dense(options.k, stiffness.rows()) {
        true => small(pencil, stiffness, mass, options).map(Some),
        false => Ok(None),
    }
}

/// Returns whether k pairs of n x n matrices are found without iteration.
pub(crate) fn is_dense(k: usize, n: usize) -> bool {
    k == 0 || basis_size(k) + 2 * WIDTH > n
}

/// Checks the matrices and the options.
pub(crate) fn check(
    stiffness: CsMatView<'_, f64>,
    mass: &Mass,
    options: &EigenOptions<'_>,
) -> Result<()> {
    let n = stiffness.rows();
    check_symmetric("stiffness", stiffness)?;
    mass.check(n)?;
    options.check(n)
}

/// Computes all pairs at once.
pub(crate) fn one_window(problem: &Problem<'_>, options: &EigenOptions<'_>) -> Result<Eigenpairs> {
    let (n, size) = (problem.pencil.inner().rows().len(), basis_size(options.k));
    let request = format_args!("{} eigenpairs of {n} x {n} matrices", options.k);
    check_request("k", request, (n as f64 * size as f64) * size_of::<f64>() as f64)?;
    let pairs = match options.shift {
        Some(shift) if is_below_all(problem, shift)? => {
            // Not without a shift: W need not be semi-definite.
            lowest(problem, &EigenOptions { shift: Some(-problem.scale), ..options.clone() })
        }
        Some(shift) => around(problem, shift, options),
        None => lowest(problem, options),
    }?;
    options.progress.report(1.0)?;
    Ok(pairs)
}

/// Returns whether a shift is below all eigenvalues, by more than s: those nearest to it are the
/// smallest ones then. From `-s` they are found even where the shift is so far away that their
/// distances from it hardly differ. `W + s M` is positive definite just if all exceed `-s`.
fn is_below_all(problem: &Problem<'_>, shift: f64) -> Result<bool> {
    match shift < -problem.scale {
        true => problem.all_exceed(-problem.scale),
        false => Ok(false),
    }
}

/// Computes the smallest eigenvalues.
fn lowest(problem: &Problem<'_>, options: &EigenOptions<'_>) -> Result<Eigenpairs> {
    let sigma = -problem.scale;
    let factor = problem.positive(sigma)?;
    options.progress.report(0.02)?;
    let below = |value| problem.below(value);
    problem.nearest(sigma, factor, options, |values| match options.verify_count {
        true => is_complete_from_below(values, problem.scale, below),
        false => Ok(true),
    })
}

/// Matrices of n x n entries that a dense problem holds: its two, the factor and the vectors.
const DENSE: f64 = 4.0;

/// Largest rounding error of an eigenvalue of a dense problem, in units of the largest eigenvalue,
/// with a wide margin: huge weights beside small ones make it larger than the s of the others.
const ROUNDED: f64 = 1e-9;

/// Computes all pairs as a dense problem, and returns the wanted ones.
fn small(
    pencil: &dyn Pencil,
    stiffness: CsMatView<'_, f64>,
    mass: &Mass,
    options: &EigenOptions<'_>,
) -> Result<Eigenpairs> {
    let n = stiffness.rows();
    let request = format_args!("{} of {n} eigenpairs, as a dense problem", options.k);
    check_request("k", request, DENSE * (n as f64).powi(2) * size_of::<f64>() as f64)?;
    let (values, vectors) = dense_pairs(stiffness, mass, options)?;
    let scale = scale(stiffness, mass);
    let largest = values.iter().fold(0.0f64, |largest, value| largest.max(value.abs()));
    let negligible = (options.tolerance * scale).max(ROUNDED * largest);
    if options.shift.is_none() && values[0] < -negligible {
        return Err(not_semi_definite());
    }
    let kept = match options.shift {
        Some(shift) => nearest(&values, shift, options.k),
        None => 0..options.k,
    };
    let mut values = values[kept.clone()].to_vec();
    if options.shift.is_none() {
        // The values of constants on components are zero, not rounding errors.
        let free = null_components(stiffness, mass).len().min(options.k);
        values[..free].fill(0.0);
        values.iter_mut().for_each(|value| *value = value.max(0.0));
    }
    let rows = pencil.inner().rows();
    let vectors = filled(rows.len(), options.k, |i, j| vectors[(rows.start + i, kept.start + j)])?;
    let vectors = vectors.as_ref();
    let Certificate { residuals, .. } =
        certify(pencil, &values, vectors, scale, ROUNDINGS, options)?;
    options.progress.report(1.0)?;
    ascending(&values, vectors, &residuals, 0, options.par)
}

/// Returns the places of the `k` of ascending values that are nearest to a shift. Distances are
/// compared across the shift only: from a shift far away, rounding makes them equal.
fn nearest(values: &[f64], shift: f64, k: usize) -> Range<usize> {
    let mut end = values.partition_point(|value| *value < shift);
    let mut start = end;
    while end - start < k {
        let below = start.checked_sub(1).map(|i| shift - values[i]);
        let is_below = match (below, values.get(end)) {
            (Some(below), Some(above)) => below <= above - shift,
            (below, _) => below.is_some(),
        };
        if is_below {
            start -= 1;
        } else {
            end += 1;
        }
    }
    start..end
}

#[cfg(test)]
mod tests {
    use sprs::{CsMat, TriMat};

    use super::*;
    use crate::base::Error;
    use crate::sparse::path::path;

    #[test]
    fn indefinite_matrices_need_a_shift_whatever_their_size() {
        for n in [1, 3, 500] {
            let entries = (0..n).map(|i| if i == 0 { -2.0 } else { 1.0 + i as f64 }).collect();
            let w = CsMat::new((n, n), (0..=n).collect(), (0..n).collect(), entries);
            let (mass, options) = (Mass::identity(n), EigenOptions::new().k(1));
            match eigs(w.view(), &mass, &options) {
                Err(Error::Argument { what: "stiffness", why }) => {
                    assert_eq!(why, "not positive semi-definite, which needs a shift");
                }
                other => panic!("n = {n}: {other:?}"),
            }
            let found = eigs(w.view(), &mass, &options.shift(-2.1)).unwrap();
            assert!((found.values[0] + 2.0).abs() < 1e-9, "n = {n}: {:?}", found.values);
        }
    }

    /// Returns a diagonal matrix.
    fn diagonal(entries: Vec<f64>) -> CsMat<f64> {
        let n = entries.len();
        CsMat::new((n, n), (0..=n).collect(), (0..n).collect(), entries)
    }

    #[test]
    fn negative_eigenvalues_above_the_first_shift_are_no_rounding_errors() {
        // The scales are 2 / 4 and 250 / 500.
        for (n, least) in [(4, -1e-3), (4, -1e-7), (500, -0.1), (500, -1e-7)] {
            let w = diagonal((0..n).map(|i| if i == 0 { least } else { i as f64 }).collect());
            let (mass, options) = (Mass::identity(n), EigenOptions::new().k(1));
            let refused = eigs(w.view(), &mass, &options).unwrap_err().to_string();
            assert!(refused.contains("not positive semi-definite"), "n = {n}: {refused}");
            // A shift beside it, and one below -s, from where the iteration starts at -s.
            for shift in [-0.2, -3.0] {
                let found = eigs(w.view(), &mass, &options.clone().shift(shift)).unwrap();
                assert!((found.values[0] - least).abs() < 1e-9, "n = {n}: {:?}", found.values);
            }
        }
    }

    #[test]
    fn negative_eigenvalues_are_seen_where_null_vectors_are_all_that_is_wanted() {
        // A path with a constant null vector, and a row of its own; the scale is 2 / 500.
        let n = 500;
        for (last, is_semi_definite) in [(-2e-3, false), (-1e-7, false), (0.0, true), (1.0, true)] {
            let mut entries = TriMat::new((n, n));
            path(n - 1).iter().for_each(|(&x, (i, j))| entries.add_triplet(i, j, x));
            entries.add_triplet(n - 1, n - 1, last);
            let (w, mass) = (entries.to_csr::<usize>(), Mass::identity(n));
            match eigs(w.view(), &mass, &EigenOptions::new().k(1)) {
                Ok(found) => assert!(is_semi_definite && found.values == [0.0], "{last:e}"),
                Err(refused) => {
                    let said = refused.to_string();
                    assert!(
                        !is_semi_definite && said.contains("semi-definite"),
                        "{last:e}: {said}"
                    );
                }
            }
        }
    }

    #[test]
    fn accuracy_does_not_depend_on_the_unit_of_length() {
        let n = 400;
        let w = path(n);
        for exponent in [-40, -20, 0, 20, 40] {
            // Masses of surfaces are areas.
            let mass = Mass::Lumped(vec![2f64.powi(exponent); n]);
            let found = eigs(w.view(), &mass, &EigenOptions::new().k(100)).unwrap();
            for (j, &value) in found.values.iter().enumerate() {
                let half = std::f64::consts::PI * j as f64 / (2 * n) as f64;
                let expected = 4.0 * half.sin().powi(2);
                let error = (value * 2f64.powi(exponent) - expected).abs();
                assert!(error < 1e-13, "2^{exponent}, {j}: {error:e}");
            }
            let worst = found.residuals.iter().copied().fold(0.0, f64::max);
            assert!(worst < 1e-10, "2^{exponent}: {worst:e}");
        }
    }

    #[test]
    fn what_the_tolerance_leaves_below_zero_becomes_zero_with_the_residual_of_zero() {
        for n in [4, 500] {
            // s / 1000 below zero.
            let w = diagonal((0..n).map(|i| if i == 0 { -5e-4 } else { i as f64 }).collect());
            let options = EigenOptions::new().k(1).tolerance(1e-2);
            let found = eigs(w.view(), &Mass::identity(n), &options).unwrap();
            assert_eq!(found.values, [0.0], "n = {n}");
            assert!((5e-4..2e-2).contains(&found.residuals[0]), "n = {n}: {:?}", found.residuals);
        }
    }

    #[test]
    fn semi_definite_matrices_have_no_negative_eigenvalue() {
        // The Laplacian of a path between diagonal matrices: the null vector is not constant.
        for n in [4, 60, 500] {
            let (mut w, size) = (path(n), |i: usize| (1 + i % 7) as f64);
            let places: Vec<_> = w.iter().map(|(_, (i, j))| (i, j)).collect();
            for (x, (i, j)) in w.data_mut().iter_mut().zip(places) {
                *x *= size(i) * size(j);
            }
            for tolerance in [1e-11, 1e-9, 1e-2] {
                let options = EigenOptions::new().k(2).tolerance(tolerance);
                let found = eigs(w.view(), &Mass::identity(n), &options).unwrap().values;
                assert!((0.0..tolerance).contains(&found[0]), "n = {n}: {found:?}");
            }
        }
    }

    #[test]
    fn a_shift_far_below_all_eigenvalues_finds_the_smallest_ones() {
        // Distances from -1 differ by 4e-8 at most; eigenvalues are 4 sin^2(pi j / 2 n).
        let n = 50_000;
        let (w, mass) = (path(n), Mass::identity(n));
        let options = EigenOptions::new().k(3).shift(-1.0);
        let found = eigs(w.view(), &mass, &options).unwrap().values;
        for (j, value) in found.iter().enumerate() {
            let angle = std::f64::consts::FRAC_PI_2 * j as f64 / n as f64;
            assert!((value - 4.0 * angle.sin().powi(2)).abs() < 1e-13, "{found:?}");
        }
    }

    #[test]
    fn the_nearest_values_are_found_from_any_distance() {
        let values = [0.0, 1.0, 1.0, 3.0, 7.0];
        for (shift, k, expected) in [
            (1e300, 2, 3..5),
            (-1e300, 2, 0..2),
            (1.0, 2, 1..3),
            (2.0, 2, 1..3),
            (2.5, 1, 3..4),
            (2.5, 3, 1..4),
            (8.0, 5, 0..5),
            (0.0, 0, 0..0),
        ] {
            assert_eq!(nearest(&values, shift, k), expected, "{k} near {shift:e}");
        }
    }
}
