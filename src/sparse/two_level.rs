//! The smallest eigenpairs of a large pencil from those of a small one.

use faer::{Mat, MatRef};
use sprs::{CsMat, CsMatView, TriMat};

use super::Mass;
use super::certificate::{ROUNDINGS, certify};
use super::eigenpairs::{Eigenpairs, ascending};
use super::eigs::{check, eigs};
use super::options::EigenOptions;
use super::problem::{scale, without_negative};
use super::product::multiply_symmetric_or_rows;
use super::space::{Pencil, WholePencil};
use crate::base::{Error, Par, Result};
use crate::dense::{
    ROW_BLOCK, SymmetricEigen, cholesky, divide_by_upper, for_row_blocks, lower_solve_in_place,
    multiply_in_place, symmetric_eigen, transposed_product, zeros,
};

/// Steps of smoothing after the small problem. Each costs about k products with W and M. On the
/// armadillo, errors of eigenvalues fall to an eighth after two steps and to a fourteenth after
/// four.
const STEPS: usize = 4;

/// Computes the k smallest eigenpairs of `W phi = lambda M phi` approximately, without a
/// factorization of a matrix of W's size.
///
/// W and M are as for [`eigs`]; `prolongation` (n x c, by rows, c below n) takes functions on a
/// coarse space to those on the fine one, for instance the weights of a decimation. First come the
/// eigenpairs of `P^T W P` and `P^T M P` (Galerkin), then four steps that smooth the vectors by a
/// Jacobi iteration with the sums of magnitudes of the rows of W (Baker, Falgout, Kolev and Yang
/// 2011), each followed by the Rayleigh-Ritz procedure in their span, which has more than k
/// dimensions.
///
/// Eigenvalues are those of a projection, so the i-th is never below the i-th of the pencil. The
/// difference depends on P and on W: about 0.1 % for scans with even triangles, several per cent
/// for long thin ones (docs/algorithms/eigen.md). [`Eigenpairs::residuals`] bounds it from the
/// result alone, but widely: they may be a thousand times the relative errors of the eigenvalues.
/// `options.tolerance` does not apply to them; `options.max_restarts` and the seed are those of the
/// coarse problem. The result is the same, bit for bit, for every `options.par`. Memory: `k +
/// max(8, k / 4) + 64` vectors of n, the result, and what the coarse problem takes.
///
/// ```
/// use catamaran::prelude::*;
/// use catamaran::sparse::{Mass, eigs_two_level};
///
/// // A ring of 200 nodes: eigenvalues 2 - 2 cos(2 pi j / 200), for j and -j.
/// # let mut ring = sprs::TriMat::new((200, 200));
/// # for (i, j) in (0..200).map(|i| (i, (i + 1) % 200)) {
/// #     for (i, j, x) in [(i, i, 1.0), (j, j, 1.0), (i, j, -1.0), (j, i, -1.0)] {
/// #         ring.add_triplet(i, j, x);
/// #     }
/// # }
/// # let (ring, mass) = (ring.to_csr::<usize>(), Mass::identity(200));
/// // Every fourth node, and linear functions between them.
/// let mut weights = sprs::TriMat::new((200, 50));
/// for i in 0..200 {
///     let part = (i % 4) as f64 / 4.0;
///     weights.add_triplet(i, i / 4, 1.0 - part);
///     weights.add_triplet(i, (i / 4 + 1) % 50, part);
/// }
/// let weights = weights.to_csr::<usize>();
/// let options = EigenOptions::new().k(9);
/// let found = eigs_two_level(ring.view(), &mass, weights.view(), &options)?;
/// let exact = eigs(ring.view(), &mass, &options)?;
/// assert!((found.values[8] / exact.values[8] - 1.0).abs() < 2e-3);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// Those of [`eigs`] for W, M and the options; [`Error::Shape`], [`Error::NonFinite`] and
/// [`Error::Argument`] of "prolongation", or of "shift", "verify_count" (neither makes sense here)
/// and "k", when the coarse space has fewer dimensions.
pub fn eigs_two_level(
    stiffness: CsMatView<'_, f64>,
    mass: &Mass,
    prolongation: CsMatView<'_, f64>,
    options: &EigenOptions<'_>,
) -> Result<Eigenpairs> {
    options.progress.watch(|| find(stiffness, mass, prolongation, options))
}

fn find(
    stiffness: CsMatView<'_, f64>,
    mass: &Mass,
    prolongation: CsMatView<'_, f64>,
    options: &EigenOptions<'_>,
) -> Result<Eigenpairs> {
    check(stiffness, mass, options)?;
    check_options(options)?;
    let coarse_space = used_columns(stiffness.rows(), prolongation, options.k)?;
    let p = coarse_space.view();
    let k = options.k;
    // More vectors than k: the last pairs would be mixed with those of the missing directions.
    let spanned = (k + 8.max(k / 4)).min(p.cols());
    let progress = options.progress;
    progress.report(0.02)?;
    let transposed = p.transpose_view().to_csr();
    let coarse = |a: CsMatView<'_, f64>| congruent(p, transposed.view(), a);
    let (mut small_stiffness, small_mass) = (coarse(stiffness), coarse(full(mass).view()));
    lift(&mut small_stiffness);
    let small_options = EigenOptions {
        k: spanned,
        tolerance: 1e-6,
        progress: progress.part(0.05..0.5),
        ..options.clone()
    };
    let small = eigs(small_stiffness.view(), &Mass::Full(small_mass), &small_options)?;
    let (n, par) = (stiffness.rows(), options.par);
    let mut vectors = zeros(n, spanned)?;
    multiply_symmetric_or_rows(p, small.vectors.as_ref(), vectors.as_mut(), par);

    let mut smoother = Smoother::new(stiffness, mass, spanned, par)?;
    let mut values = small.values;
    for step in 0..STEPS {
        smoother.apply(&values, &mut vectors)?;
        values = smoother.rotate(&mut vectors)?;
        progress.report(0.5 + 0.45 * (step + 1) as f64 / STEPS as f64)?;
    }
    let (pencil, found) = (WholePencil { stiffness, mass }, vectors.as_ref().subcols(0, k));
    let scale = scale(stiffness, mass);
    let certificate = certify(&pencil, &values[..k], found, scale, ROUNDINGS, options)?;
    let mut pairs = ascending(&values[..k], found, &certificate.residuals, small.solves, par)?;
    without_negative(&pencil, &mut pairs, scale, options)?;
    progress.report(1.0)?;
    Ok(pairs)
}

/// Rejects options that have no meaning for two levels.
fn check_options(options: &EigenOptions<'_>) -> Result<()> {
    let refuse = |what, why: &str| Err(Error::Argument { what, why: why.into() });
    if options.shift.is_some() {
        return refuse("shift", "not supported: two levels find the smallest eigenvalues only");
    }
    if options.verify_count {
        return refuse("verify_count", "not supported: the values of two levels are approximate");
    }
    Ok(())
}

/// Returns the prolongation, to n rows, without columns of zeros only, which have no mass. At least
/// k columns must remain.
fn used_columns(n: usize, prolongation: CsMatView<'_, f64>, k: usize) -> Result<CsMat<f64>> {
    let columns = prolongation.cols();
    Error::check_shape("prolongation", (n, columns), prolongation.shape())?;
    if !prolongation.is_csr() {
        return Err(Error::Argument { what: "prolongation", why: "must be stored by rows".into() });
    }
    let mut used = vec![false; columns];
    for (i, row) in prolongation.outer_iterator().enumerate() {
        for (j, &x) in row.iter() {
            if !x.is_finite() {
                return Err(Error::NonFinite { what: "prolongation", index: (i, j) });
            }
            used[j] |= x != 0.0;
        }
    }
    let used: Vec<usize> = (0..columns).filter(|&j| used[j]).collect();
    if k > used.len() {
        let why = format!("{k} eigenpairs from a coarse space of {} dimensions", used.len());
        return Err(Error::Argument { what: "k", why });
    }
    let mut chosen = TriMat::new((columns, used.len()));
    used.iter().enumerate().for_each(|(place, &j)| chosen.add_triplet(j, place, 1.0));
    Ok(&prolongation * &chosen.to_csr::<usize>())
}

/// Computes `P^T A P`, symmetric to the bit, of P and its transpose by rows.
fn congruent(
    p: CsMatView<'_, f64>,
    transposed: CsMatView<'_, f64>,
    a: CsMatView<'_, f64>,
) -> CsMat<f64> {
    let by_rows = if a.is_csr() { a.to_owned() } else { a.transpose_view().to_owned() };
    let product = (&(&transposed * &by_rows) * &p).to_csr();
    let mirrored = product.transpose_view().to_csr();
    let mut sum = &product + &mirrored;
    sum.scale(0.5);
    sum
}

/// Adds a little to the diagonal, so that combinations of columns of the prolongation that are zero
/// have large eigenvalues. Such combinations exist where the coarse mesh is finer than the fine
/// one. The matrices of the fine space do not change.
fn lift(matrix: &mut CsMat<f64>) {
    const PART: f64 = 1e-9;
    for i in 0..matrix.rows() {
        if let Some(x) = matrix.get_mut(i, i) {
            *x *= 1.0 + PART;
        }
    }
}

/// Returns M as a sparse matrix.
fn full(mass: &Mass) -> CsMat<f64> {
    match mass {
        Mass::Full(matrix) => matrix.clone(),
        Mass::Lumped(masses) => {
            let n = masses.len();
            CsMat::new((n, n), (0..=n).collect(), (0..n).collect(), masses.clone())
        }
    }
}

/// Vectors that are multiplied with W and M together.
const PANEL: usize = 32;

/// Smooths approximate eigenvectors.
struct Smoother<'a> {
    pencil: WholePencil<'a>,
    /// For each row of W, the step divided by the sum of its magnitudes.
    steps: Vec<f64>,
    /// The products of W and M with a panel of vectors.
    images: [Mat<f64>; 2],
    par: Par,
}

impl<'a> Smoother<'a> {
    fn new(
        stiffness: CsMatView<'a, f64>,
        mass: &'a Mass,
        vectors: usize,
        par: Par,
    ) -> Result<Self> {
        /// Below 2 the iteration converges for every W; errors that change from row to row fall
        /// fastest at about this value.
        const STEP: f64 = 1.2;
        let sum = |row: sprs::CsVecView<'_, f64>| row.data().iter().map(|x| x.abs()).sum::<f64>();
        let step = |sum: f64| if sum > 0.0 { STEP / sum } else { 0.0 };
        let steps = stiffness.outer_iterator().map(|row| step(sum(row))).collect();
        let (n, width) = (stiffness.rows(), PANEL.min(vectors));
        let images = [zeros(n, width)?, zeros(n, width)?];
        Ok(Self { pencil: WholePencil { stiffness, mass }, steps, images, par })
    }

    /// Computes `x -= S (W x - lambda M x)` for each vector x and its value.
    fn apply(&mut self, values: &[f64], vectors: &mut Mat<f64>) -> Result<()> {
        for (panel, values) in values.chunks(PANEL).enumerate() {
            let columns = panel * PANEL..panel * PANEL + values.len();
            let [w, m] = images_of(
                &self.pencil,
                &mut self.images,
                vectors.as_ref().subcols(columns.start, columns.len()),
                self.par,
            )?;
            let steps = &self.steps;
            let x = vectors.as_mut().subcols_mut(columns.start, columns.len());
            for_row_blocks(x, ROW_BLOCK, self.par, |first, mut x| {
                for (j, value) in values.iter().enumerate() {
                    for i in 0..x.nrows() {
                        let row = first + i;
                        x[(i, j)] -= steps[row] * (w[(row, j)] - value * m[(row, j)]);
                    }
                }
            });
        }
        Ok(())
    }

    /// Turns the vectors into the eigenvectors of the projection to their span; returns its
    /// eigenvalues.
    fn rotate(&mut self, vectors: &mut Mat<f64>) -> Result<Vec<f64>> {
        let (x, count, par) = (vectors.as_ref(), vectors.ncols(), self.par);
        let (mut projected, mut gram) = (zeros(count, count)?, zeros(count, count)?);
        for first in (0..count).step_by(PANEL) {
            let width = PANEL.min(count - first);
            let panel = x.subcols(first, width);
            let [w, m] = images_of(&self.pencil, &mut self.images, panel, par)?;
            for (product, image) in [(&mut projected, w), (&mut gram, m)] {
                let columns = transposed_product(x, image, par)?;
                product.as_mut().subcols_mut(first, width).copy_from(&columns);
            }
        }
        let not_a_basis = |i| Error::Argument {
            what: "prolongation",
            why: format!("direction {i} of its coarse space depends on the others"),
        };
        cholesky(gram.as_mut())?.map_err(not_a_basis)?;
        let l = gram.as_ref();
        // L^-1 A L^-T, of which the lower triangle is read.
        lower_solve_in_place(l, projected.as_mut());
        lower_solve_in_place(l, projected.as_mut().transpose_mut());
        let SymmetricEigen { values, vectors: turn } = symmetric_eigen(projected.as_ref())?;
        divide_by_upper(vectors.as_mut(), l, par)?;
        multiply_in_place(vectors.as_mut(), turn.as_ref(), par)?;
        Ok(values)
    }
}

/// Computes `W X` and `M X` of at most [`PANEL`] vectors.
fn images_of<'m>(
    pencil: &WholePencil<'_>,
    [w, m]: &'m mut [Mat<f64>; 2],
    x: MatRef<'_, f64>,
    par: Par,
) -> Result<[MatRef<'m, f64>; 2]> {
    let width = x.ncols();
    pencil.apply_stiffness(x, w.as_mut().subcols_mut(0, width), par)?;
    pencil.inner().apply_mass(x, m.as_mut().subcols_mut(0, width), par)?;
    Ok([w, m].map(|image| image.as_ref().subcols(0, width)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Rng;
    use crate::sparse::path::path;

    /// Returns the linear interpolation from every `width`-th row, and a last column of zeros.
    fn interpolation(n: usize, width: usize) -> CsMat<f64> {
        let coarse = n.div_ceil(width) + 2;
        let mut entries = TriMat::new((n, coarse));
        for i in 0..n {
            let part = (i % width) as f64 / width as f64;
            entries.add_triplet(i, i / width, 1.0 - part);
            entries.add_triplet(i, i / width + 1, part);
        }
        entries.to_csr()
    }

    fn options(k: usize, threads: usize) -> EigenOptions<'static> {
        EigenOptions::new().k(k).threads(threads)
    }

    #[test]
    fn values_are_little_above_the_true_ones_and_bits_do_not_depend_on_threads() {
        let n = 1500;
        let (w, mass) = (path(n), Mass::Lumped((0..n).map(|i| 1.0 + (i % 3) as f64).collect()));
        let p = interpolation(n, 12);
        let exact = eigs(w.view(), &mass, &options(12, 1)).unwrap();
        let found = eigs_two_level(w.view(), &mass, p.view(), &options(12, 1)).unwrap();
        for i in 1..12 {
            let error = found.values[i] / exact.values[i] - 1.0;
            assert!((-1e-9..5e-3).contains(&error), "{i}: {error:e}");
        }
        assert!(found.values[0].abs() < 1e-12);
        let found_vectors = found.vectors.as_ref();
        let gram = transposed_product(found_vectors, found_vectors, Par::Seq).unwrap();
        assert!(gram.norm_max() < 1.1, "masses are 1 and more");
        let again = eigs_two_level(w.view(), &mass, p.view(), &options(12, 3)).unwrap();
        assert_eq!((found.values, found.vectors), (again.values, again.vectors));
    }

    #[test]
    fn a_full_mass_and_all_of_the_fine_space_give_the_exact_values() {
        let n = 90;
        let w = path(n);
        let mut entries = TriMat::new((n, n));
        for i in 0..n {
            entries.add_triplet(i, i, 4.0);
            if i > 0 {
                entries.add_triplet(i, i - 1, 1.0);
                entries.add_triplet(i - 1, i, 1.0);
            }
        }
        let mass = Mass::Full(entries.to_csr());
        let exact = eigs(w.view(), &mass, &options(5, 1)).unwrap();
        let found = eigs_two_level(w.view(), &mass, CsMat::eye(n).view(), &options(5, 2)).unwrap();
        for i in 0..5 {
            assert!((found.values[i] - exact.values[i]).abs() < 1e-10);
        }
    }

    #[test]
    fn columns_that_depend_on_each_other_do_not_matter() {
        let n = 600;
        let (w, mass) = (path(n), Mass::identity(n));
        let p = interpolation(n, 6);
        let (mut twice, columns) = (TriMat::new((n, 2 * p.cols())), p.cols());
        for (x, (i, j)) in p.iter() {
            twice.add_triplet(i, j, *x);
            if j % 3 > 0 {
                twice.add_triplet(i, columns + j, 1e-8 * x);
            }
        }
        let values = |p: &CsMat<f64>| {
            eigs_two_level(w.view(), &mass, p.view(), &options(8, 1)).unwrap().values
        };
        let (once, twice) = (values(&p), values(&twice.to_csr()));
        for i in 1..8 {
            assert!((twice[i] / once[i] - 1.0).abs() < 1e-6, "{i}: {} and {}", once[i], twice[i]);
        }
    }

    #[test]
    fn what_makes_no_sense_is_refused_by_name() {
        let (w, mass) = (path(30), Mass::identity(30));
        let p = interpolation(30, 5);
        let refused = |p: &CsMat<f64>, options: &EigenOptions<'_>| {
            eigs_two_level(w.view(), &mass, p.view(), options).unwrap_err().to_string()
        };
        let mut rng = Rng::new(3);
        let mut spoilt = p.clone();
        let place = (rng.bits() % spoilt.nnz() as u64) as usize;
        spoilt.data_mut()[place] = f64::NAN;
        for (p, options, named) in [
            (&p, options(2, 1).shift(1.0), "shift"),
            (&p, options(2, 1).verify_count(true), "verify_count"),
            (&p, options(9, 1), "k"),
            (&interpolation(31, 5), options(2, 1), "prolongation"),
            (&p.to_csc(), options(2, 1), "prolongation"),
            (&spoilt, options(2, 1), "prolongation"),
        ] {
            let message = refused(p, &options);
            assert!(message.contains(named), "{message}");
        }
    }
}
