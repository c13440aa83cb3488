//! The smallest eigenpairs of a large pencil from those of a small one.

use faer::Mat;
use sprs::{CsMat, CsMatView};

use super::Mass;
use super::certificate::{ROUNDINGS, certify};
use super::eigenpairs::{Eigenpairs, ascending};
use super::eigs::{check, eigs};
use super::options::EigenOptions;
use super::problem::scale;
use super::product::multiply_symmetric_or_rows;
use super::space::{Pencil, WholePencil};
use crate::base::{Error, Par, Result};
use crate::dense::{
    ROW_BLOCK, SymmetricEigen, cholesky, divide_by_upper, for_row_blocks, lower_solve_in_place,
    multiply_in_place, symmetric_eigen, transposed_product, zeros,
};

/// Steps of smoothing after the small problem. Each costs about k products with W and M and takes the
/// errors of eigenvalues down, to an eighth after two and a fourteenth after four on the armadillo.
const STEPS: usize = 4;

/// The k smallest eigenpairs of `W phi = lambda M phi`, approximately and without a factorisation of
/// anything of W's size.
///
/// W and M are as for [`eigs`]; `prolongation` (n x c, by rows, c below n) takes functions
/// on a coarse space to those on the fine one, for instance the weights of a decimation. First come
/// the eigenpairs of `P^T W P` and `P^T M P` (Galerkin), then four steps that smooth the
/// vectors by a Jacobi iteration with the sums of magnitudes of the rows of W (Baker, Falgout, Kolev
/// and Yang 2011), each followed by the Rayleigh-Ritz procedure in their span, which has more than k
/// dimensions.
///
/// Eigenvalues are those of a projection, so the i-th is never below the i-th of the pencil. How far
/// above depends on P; [`Eigenpairs::residuals`] bounds it from the result alone, but widely:
/// they are often a hundred times the relative errors of the eigenvalues. `options.tolerance` is
/// not asked of them; `options.max_restarts` and the seed are those of the coarse problem. The result
/// is the same, bit for bit, for every `options.par`. Memory: `5 k / 4 + 20` vectors of n, and
/// what the coarse problem takes.
///
/// ```
/// use catamaran::{prelude::*, decimate::{DecimateOptions, decimate}, mesh::families};
/// use catamaran::sparse::eigs_two_level;
///
/// let mesh = families::icosphere(4)?;
/// let Laplacian { stiffness, mass, .. } = laplacian(&mesh, &LaplacianOptions::new())?;
/// let small = decimate(&mesh, 300, &DecimateOptions::new())?;
/// let weights = small.weights(&mesh, Par::all())?;
/// let options = EigenOptions::new().k(9);
/// let found = eigs_two_level(stiffness.view(), &mass, weights.view(), &options)?;
/// let exact = eigs(stiffness.view(), &mass, &options)?;
/// assert!((found.values[8] / exact.values[8] - 1.0).abs() < 2e-3);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// Those of [`eigs`] for W, M and the options; [`Error::Shape`], [`Error::NonFinite`] and
/// [`Error::Argument`] of "prolongation", or of "shift", "verify_count" (neither makes sense here) and
/// "k", when the coarse space has fewer dimensions.
pub fn eigs_two_level(
    stiffness: CsMatView<'_, f64>,
    mass: &Mass,
    prolongation: CsMatView<'_, f64>,
    options: &EigenOptions<'_>,
) -> Result<Eigenpairs> {
    check(stiffness, mass, options)?;
    let coarse_space = used_columns(stiffness.rows(), prolongation, options)?;
    let p = coarse_space.view();
    let k = options.k;
    // The span should hold what the last pairs would otherwise be mixed with.
    let spanned = (k + 8.max(k / 4)).min(p.cols());
    let progress = options.progress;
    progress.report(0.02)?;
    let (mut small_stiffness, small_mass) =
        (congruent(p, stiffness), congruent(p, full(mass).view()));
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

    let smoother = Smoother::new(stiffness, mass, par);
    let mut values = small.values;
    let mut images = [zeros(n, spanned)?, zeros(n, spanned)?];
    for step in 0..STEPS {
        smoother.apply(&values, &mut vectors, &mut images)?;
        values = smoother.rotate(&mut vectors, &mut images)?;
        progress.report(0.5 + 0.45 * (step + 1) as f64 / STEPS as f64)?;
    }
    let (pencil, found) = (WholePencil { stiffness, mass }, vectors.as_ref().subcols(0, k));
    let scale = scale(stiffness, mass);
    let certificate = certify(&pencil, stiffness, &values[..k], found, scale, ROUNDINGS, options)?;
    progress.report(1.0)?;
    Ok(ascending(&values[..k], found, &certificate.residuals, small.solves, true))
}

/// The prolongation without columns of zeros only, which have no mass.
fn used_columns(
    n: usize,
    prolongation: CsMatView<'_, f64>,
    options: &EigenOptions<'_>,
) -> Result<CsMat<f64>> {
    let refuse = |what, why: String| Err(Error::Argument { what, why });
    if options.shift.is_some() {
        return refuse("shift", "two levels find the smallest eigenvalues only".into());
    }
    if options.verify_count {
        return refuse("verify_count", "what two levels find is approximate".into());
    }
    Error::check_shape("prolongation", (n, prolongation.cols()), prolongation.shape())?;
    if !prolongation.is_csr() {
        return refuse("prolongation", "must be stored by rows".into());
    }
    let mut used = vec![false; prolongation.cols()];
    for (i, row) in prolongation.outer_iterator().enumerate() {
        for (j, &x) in row.iter() {
            if !x.is_finite() {
                return Err(Error::NonFinite { what: "prolongation", index: (i, j) });
            }
            used[j] |= x != 0.0;
        }
    }
    let mut count = 0;
    let place: Vec<usize> = used
        .iter()
        .map(|&used| {
            count += usize::from(used);
            count
        })
        .collect();
    if options.k > count {
        let why = format!("{} eigenpairs from a coarse space of {count} dimensions", options.k);
        return refuse("k", why);
    }
    let entries = prolongation
        .outer_iterator()
        .flat_map(|row| row.iter().map(|(j, &x)| (j, x)).collect::<Vec<_>>());
    let (columns, values) =
        entries.filter(|(_, x)| *x != 0.0).map(|(j, x)| (place[j] - 1, x)).unzip();
    let mut starts = vec![0];
    for row in prolongation.outer_iterator() {
        let before = starts[starts.len() - 1];
        starts.push(before + row.iter().filter(|(_, x)| **x != 0.0).count());
    }
    Ok(CsMat::new((n, count), starts, columns, values))
}

/// `P^T A P`, symmetric to the bit.
fn congruent(p: CsMatView<'_, f64>, a: CsMatView<'_, f64>) -> CsMat<f64> {
    let transposed = p.transpose_view().to_csr();
    let by_rows = if a.is_csr() { a.to_owned() } else { a.transpose_view().to_owned() };
    let product = (&(&transposed * &by_rows) * &p).to_csr();
    let mirrored = product.transpose_view().to_csr();
    let mut sum = &product + &mirrored;
    sum.scale(0.5);
    sum
}

/// Adds a little to the diagonal, so that combinations of columns of the prolongation that are zero
/// have eigenvalues, and large ones. They exist where the coarse mesh is finer than the fine one.
/// The fine space knows nothing of it.
fn lift(matrix: &mut CsMat<f64>) {
    const PART: f64 = 1e-9;
    for i in 0..matrix.rows() {
        if let Some(x) = matrix.get_mut(i, i) {
            *x *= 1.0 + PART;
        }
    }
}

/// M as a sparse matrix.
fn full(mass: &Mass) -> CsMat<f64> {
    match mass {
        Mass::Full(matrix) => matrix.clone(),
        Mass::Lumped(masses) => {
            let n = masses.len();
            CsMat::new((n, n), (0..=n).collect(), (0..n).collect(), masses.clone())
        }
    }
}

/// Makes approximate eigenvectors better.
struct Smoother<'a> {
    pencil: WholePencil<'a>,
    /// For each row of W a step, over the sum of its magnitudes.
    steps: Vec<f64>,
    par: Par,
}

impl<'a> Smoother<'a> {
    fn new(stiffness: CsMatView<'a, f64>, mass: &'a Mass, par: Par) -> Self {
        /// Below 2 it converges for every W; errors that change from row to row fall fastest at
        /// about this.
        const STEP: f64 = 1.2;
        let sum = |row: sprs::CsVecView<'_, f64>| row.data().iter().map(|x| x.abs()).sum::<f64>();
        let step = |sum: f64| if sum > 0.0 { STEP / sum } else { 0.0 };
        let steps = stiffness.outer_iterator().map(|row| step(sum(row))).collect();
        Self { pencil: WholePencil { stiffness, mass }, steps, par }
    }

    /// `x -= S (W x - lambda M x)` for each vector x and its value.
    fn apply(
        &self,
        values: &[f64],
        vectors: &mut Mat<f64>,
        images: &mut [Mat<f64>; 2],
    ) -> Result<()> {
        self.multiply(vectors, images)?;
        let [w, m] = &*images;
        for_row_blocks(vectors.as_mut(), ROW_BLOCK, self.par, |first, mut x| {
            for (j, value) in values.iter().enumerate() {
                for i in 0..x.nrows() {
                    let row = first + i;
                    x[(i, j)] -= self.steps[row] * (w[(row, j)] - value * m[(row, j)]);
                }
            }
        });
        Ok(())
    }

    /// `W X` and `M X`.
    fn multiply(&self, x: &Mat<f64>, [w, m]: &mut [Mat<f64>; 2]) -> Result<()> {
        self.pencil.apply_stiffness(x.as_ref(), w.as_mut(), self.par)?;
        self.pencil.inner().apply_mass(x.as_ref(), m.as_mut(), self.par)
    }

    /// Turns the vectors into the eigenvectors of the projection to their span; its eigenvalues.
    fn rotate(&self, vectors: &mut Mat<f64>, images: &mut [Mat<f64>; 2]) -> Result<Vec<f64>> {
        self.multiply(vectors, images)?;
        let [w, m] = &*images;
        let product = |y: &Mat<f64>| transposed_product(vectors.as_ref(), y.as_ref(), self.par);
        let (mut projected, mut gram) = (product(w), product(m));
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
        divide_by_upper(vectors.as_mut(), l, self.par);
        multiply_in_place(vectors.as_mut(), turn.as_ref(), self.par);
        Ok(values)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Rng;

    /// The Laplacian of a path of n rows.
    fn path(n: usize) -> CsMat<f64> {
        let mut entries = sprs::TriMat::new((n, n));
        for i in 1..n {
            for (a, b, x) in [(i, i, 1.0), (i - 1, i - 1, 1.0), (i, i - 1, -1.0), (i - 1, i, -1.0)]
            {
                entries.add_triplet(a, b, x);
            }
        }
        entries.to_csr()
    }

    /// Linear interpolation from every `width`-th row; the last column is of zeros only.
    fn interpolation(n: usize, width: usize) -> CsMat<f64> {
        let coarse = n.div_ceil(width) + 2;
        let mut entries = sprs::TriMat::new((n, coarse));
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
        let gram = transposed_product(found.vectors.as_ref(), found.vectors.as_ref(), Par::Seq);
        assert!(gram.norm_max() < 1.1, "masses are 1 and more");
        let again = eigs_two_level(w.view(), &mass, p.view(), &options(12, 3)).unwrap();
        assert_eq!((found.values, found.vectors), (again.values, again.vectors));
    }

    #[test]
    fn a_full_mass_and_all_of_the_fine_space_give_the_exact_values() {
        let n = 90;
        let w = path(n);
        let mut entries = sprs::TriMat::new((n, n));
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
        let (mut twice, columns) = (sprs::TriMat::new((n, 2 * p.cols())), p.cols());
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
