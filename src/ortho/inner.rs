use faer::prelude::{IntoConst, Reborrow, ReborrowMut};
use faer::{Mat, MatMut, MatRef};

use crate::base::{Error, Par, Result};
use crate::dense::{ROW_BLOCK, for_row_blocks, zeros};
use crate::product::{AtaOptions, SchemeChoice, Uplo, ata_into, atb_into};
use crate::sparse::InnerSpace;

/// An inner product and its work memory. For lumped masses, vectors are scaled by the square roots
/// of the masses during a computation, so that only a full mass is ever multiplied.
pub(super) struct Inner<'a> {
    space: &'a dyn InnerSpace,
    par: Par,
    products: AtaOptions<'a>,
    /// M X, for a full mass.
    weighted: Mat<f64>,
}

impl<'a> Inner<'a> {
    /// Creates an inner product for blocks of at most `width` columns.
    pub fn new(space: &'a dyn InnerSpace, width: usize, par: Par) -> Result<Self> {
        let width = if space.masses().is_none() { width } else { 0 };
        // For a tall matrix with a narrow one the exact path needs residues as large as the tall
        // matrix, and gains nothing.
        let scheme = SchemeChoice::Float;
        let products = AtaOptions { par, scheme, uplo: Uplo::Both, ..AtaOptions::default() };
        Ok(Self { space, par, products, weighted: zeros(space.rows().len(), width)? })
    }

    /// Returns how many threads products may use.
    pub fn par(&self) -> Par {
        self.par
    }

    /// Scales the rows of A by the square roots of lumped masses.
    pub fn enter(&self, a: MatMut<'_, f64>) {
        self.scale(a, f64::sqrt);
    }

    /// Undoes [`Inner::enter`].
    pub fn leave(&self, a: MatMut<'_, f64>) {
        self.scale(a, |m| m.sqrt().recip());
    }

    fn scale(&self, a: MatMut<'_, f64>, factor: impl Fn(f64) -> f64 + Sync) {
        let Some(masses) = self.space.masses() else { return };
        for_row_blocks(a, ROW_BLOCK, self.par, |first, mut a| {
            for j in 0..a.ncols() {
                for i in 0..a.nrows() {
                    a[(i, j)] *= factor(masses[first + i]);
                }
            }
        });
    }

    /// Returns `M X`, or X itself where the scaling by [`Inner::enter`] stands for M.
    pub fn weigh<'x>(&'x mut self, x: MatRef<'x, f64>) -> Result<MatRef<'x, f64>> {
        if self.space.masses().is_some() {
            return Ok(x);
        }
        let mut weighted = self.weighted.as_mut().subcols_mut(0, x.ncols());
        self.space.apply_mass(x, weighted.rb_mut(), self.par)?;
        Ok(weighted.into_const())
    }

    /// Removes from X its projection onto the orthonormal columns of Q, and returns the
    /// coefficients `Q^T M X`.
    pub fn project(&mut self, q: MatRef<'_, f64>, mut x: MatMut<'_, f64>) -> Result<Mat<f64>> {
        let mut coefficients = zeros(q.ncols(), x.ncols())?;
        if q.ncols() == 0 || x.ncols() == 0 {
            return Ok(coefficients);
        }
        let (space, products) = (self.space, self.products.clone());
        let weighted = self.weigh(x.rb())?;
        atb_into(1.0, q, weighted, 0.0, coefficients.as_mut(), &products)?;
        space.sum(coefficients.as_mut())?;
        atb_into(-1.0, q.transpose(), coefficients.as_ref(), 1.0, x.rb_mut(), &products)?;
        Ok(coefficients)
    }

    /// Computes `X^T M X`.
    pub fn gram(&mut self, x: MatRef<'_, f64>) -> Result<Mat<f64>> {
        let mut gram = zeros(x.ncols(), x.ncols())?;
        if x.ncols() == 0 {
            return Ok(gram);
        }
        let (space, products) = (self.space, self.products.clone());
        match space.masses() {
            Some(_) => ata_into(1.0, x, 0.0, gram.as_mut(), &products)?,
            None => {
                let weighted = self.weigh(x)?;
                atb_into(1.0, x, weighted, 0.0, gram.as_mut(), &products)?;
            }
        }
        space.sum_symmetric(gram.as_mut())?;
        Ok(gram)
    }

    /// Computes the lengths of the columns of X.
    pub fn lengths(&mut self, x: MatRef<'_, f64>) -> Result<Vec<f64>> {
        let space = self.space;
        let weighted = self.weigh(x)?;
        let mut squares = Mat::from_fn(x.ncols(), 1, |j, _| dot(x, j, weighted, j));
        space.sum(squares.as_mut())?;
        check_squares(squares.col(0).iter().copied())?;
        Ok(squares.col(0).iter().map(|square| square.max(0.0).sqrt()).collect())
    }

    /// Computes `x_i^T M x_j` of two columns.
    pub fn overlap(&mut self, x: MatRef<'_, f64>, i: usize, j: usize) -> Result<f64> {
        let space = self.space;
        let mut product = dot(x, i, self.weigh(x.subcols(j, 1))?, 0);
        space.sum(MatMut::from_column_major_slice_mut(std::slice::from_mut(&mut product), 1, 1))?;
        Ok(product)
    }

    /// Computes `Y := Y + A B` for small matrices.
    pub fn add_product(
        &self,
        y: MatMut<'_, f64>,
        a: MatRef<'_, f64>,
        b: MatRef<'_, f64>,
    ) -> Result<()> {
        if a.nrows() == 0 || a.ncols() == 0 || b.ncols() == 0 {
            return Ok(());
        }
        atb_into(1.0, a.transpose(), b, 1.0, y, &self.products)
    }
}

/// Returns the scalar product of column i of x and column j of y.
fn dot(x: MatRef<'_, f64>, i: usize, y: MatRef<'_, f64>, j: usize) -> f64 {
    /// Partial sums side by side.
    const LANES: usize = 8;
    let (x, y) = (x.col(i), y.col(j));
    let (Some(a), Some(b)) = (x.try_as_col_major(), y.try_as_col_major()) else {
        return x.iter().zip(y.iter()).map(|(a, b)| a * b).sum();
    };
    let (a, a_rest) = a.as_slice().as_chunks::<LANES>();
    let (b, b_rest) = b.as_slice().as_chunks::<LANES>();
    let mut sums = [0.0; LANES];
    for (a, b) in a.iter().zip(b) {
        for l in 0..LANES {
            sums[l] += a[l] * b[l];
        }
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
    sums.iter().sum::<f64>() + rest
}

/// Checks that A is finite; the error names the first entry that is not.
pub(super) fn check_finite(a: MatRef<'_, f64>) -> Result<()> {
    for j in 0..a.ncols() {
        if let Some(i) = a.col(j).iter().position(|x| !x.is_finite()) {
            return Err(Error::NonFinite { what: "A", index: (i, j) });
        }
    }
    Ok(())
}

/// Checks squares of lengths of columns whose entries are not far from 1: only masses can make them
/// overflow.
pub(super) fn check_squares(mut squares: impl Iterator<Item = f64>) -> Result<()> {
    if squares.all(f64::is_finite) {
        return Ok(());
    }
    Err(Error::Argument { what: "mass", why: "so large that squares of lengths overflow".into() })
}
