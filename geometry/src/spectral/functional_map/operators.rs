//! Multiplications by functions as operators with which a functional map commutes (Nogneng and
//! Ovsjanikov 2017).

use faer::{Mat, MatRef};

use crate::spectral::basis::{Basis, times_mass};
use crate::spectral::dense;
use catamaran::base::{Error, Par, Progress, Result};

/// Relative residual at which the equations count as solved, and the maximum number of iterations.
const SOLVED: f64 = 1e-10;
const ITERATIONS: usize = 4000;

/// Multiplication by a function on the source, and by the corresponding function on the target, and
/// the weight of `|C D - D' C|^2`.
pub(super) struct Operators {
    pub source: Mat<f64>,
    pub target: Mat<f64>,
    pub weight: f64,
}

/// Returns the matrix of multiplication by f, in coefficients: `Phi^T M diag(f) Phi`.
pub(super) fn multiplication(basis: &Basis, f: MatRef<'_, f64>, par: Par) -> Result<Mat<f64>> {
    let phi = basis.functions();
    let products = Mat::from_fn(phi.nrows(), phi.ncols(), |i, j| f[(i, 0)] * phi[(i, j)]);
    let weighted = times_mass(basis.mass(), products.as_ref(), par)?;
    dense::transposed_product(phi, weighted.as_ref(), par)
}

/// The equations of the C that minimizes
/// `|C A - B|^2 + sum of weights_ij C_ij^2 + sum over operators`. The first `known` columns keep
/// their values of the first guess. The solver is the method of conjugate gradients, preconditioned
/// by the diagonal.
pub(super) struct Equations<'a> {
    /// `A A^T`.
    pub gram: Mat<f64>,
    /// `B A^T`.
    pub right: Mat<f64>,
    pub weights: Mat<f64>,
    pub operators: &'a [Operators],
    pub known: usize,
}

impl Equations<'_> {
    /// Solves the coupled equations by conjugate gradients, from a guess.
    pub fn solve(&self, guess: Mat<f64>, progress: Progress<'_>) -> Result<Mat<f64>> {
        let free = |mut x: Mat<f64>| {
            x.as_mut().subcols_mut(0, self.known).fill(0.0);
            x
        };
        let mut c = guess;
        let size = self.right.norm_l2();
        let mut residual = free(&self.right - self.image(c.as_ref())?);
        let diagonal = self.diagonal();
        let precondition =
            |r: &Mat<f64>| Mat::from_fn(r.nrows(), r.ncols(), |i, j| r[(i, j)] / diagonal[(i, j)]);
        let mut direction = precondition(&residual);
        let mut energy = inner(&residual, &direction);
        let mut reached = 0.0;
        for _ in 0..ITERATIONS {
            let length = residual.norm_l2();
            if length <= SOLVED * size {
                progress.report(1.0)?;
                return Ok(c);
            }
            // The residual falls by about the same factor in most iterations, but not in all.
            reached = ((length / size).ln() / SOLVED.ln()).min(1.0).max(reached);
            progress.report(reached)?;
            let image = free(self.image(direction.as_ref())?);
            let step = energy / inner(&direction, &image);
            c += faer::Scale(step) * &direction;
            residual -= faer::Scale(step) * &image;
            let next = precondition(&residual);
            let before = std::mem::replace(&mut energy, inner(&residual, &next));
            direction = next + faer::Scale(energy / before) * &direction;
        }
        let residual = residual.norm_l2() / size;
        Err(Error::NotConverged { iterations: ITERATIONS, residual })
    }

    /// Returns half of the gradient of the quadratic part.
    fn image(&self, c: MatRef<'_, f64>) -> Result<Mat<f64>> {
        let product = |a: MatRef<'_, f64>, b: MatRef<'_, f64>| dense::product(a, b, Par::Seq);
        let mut image = product(c, self.gram.as_ref())?;
        for j in 0..c.ncols() {
            for i in 0..c.nrows() {
                image[(i, j)] += self.weights[(i, j)] * c[(i, j)];
            }
        }
        for Operators { source, target, weight } in self.operators {
            let gap = product(c, source.as_ref())? - product(target.as_ref(), c)?;
            let gap = faer::Scale(*weight) * gap;
            image += product(gap.as_ref(), source.transpose())?;
            image -= product(target.transpose(), gap.as_ref())?;
        }
        Ok(image)
    }

    /// Returns the diagonal of the equations, as a matrix of the shape of C.
    fn diagonal(&self) -> Mat<f64> {
        let (l, k) = self.right.shape();
        let mut diagonal = Mat::from_fn(l, k, |i, j| self.gram[(j, j)] + self.weights[(i, j)]);
        for Operators { source, target, weight } in self.operators {
            let own: Vec<f64> = (0..k).map(|j| source.row(j).squared_norm_l2()).collect();
            let other: Vec<f64> = (0..l).map(|i| target.col(i).squared_norm_l2()).collect();
            for j in 0..k {
                for i in 0..l {
                    let both = source[(j, j)] * target[(i, i)];
                    diagonal[(i, j)] += weight * (own[j] + other[i] - 2.0 * both);
                }
            }
        }
        diagonal
    }
}

fn inner(a: &Mat<f64>, b: &Mat<f64>) -> f64 {
    (0..a.ncols()).map(|j| a.col(j).transpose() * b.col(j)).sum()
}
