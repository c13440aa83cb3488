//! Vectors of which this process may have some rows only: what the iterations ask of those who
//! know.

use std::ops::Range;

use faer::{MatMut, MatRef};
use sprs::CsMatView;

use super::Mass;
use super::product::{multiply_by_differences, multiply_magnitudes, multiply_symmetric_or_rows};
use crate::base::{Par, Result};

/// An inner product of vectors whose rows may be spread over processes.
pub(crate) trait InnerSpace {
    /// Entries of a vector, on all processes.
    fn dimension(&self) -> usize;

    /// Those that this process has.
    fn rows(&self) -> Range<usize>;

    /// Their masses, if these are lumped.
    fn masses(&self) -> Option<&[f64]>;

    /// `Y := M X`, of the rows that are here.
    fn apply_mass(&self, x: MatRef<'_, f64>, y: MatMut<'_, f64>, par: Par) -> Result<()>;

    /// Adds what the other processes have; the same on all of them.
    fn sum(&self, partial: MatMut<'_, f64>) -> Result<()>;

    /// [`InnerSpace::sum`] of a symmetric matrix, of which only the lower triangle need be right.
    fn sum_symmetric(&self, partial: MatMut<'_, f64>) -> Result<()> {
        self.sum(partial)
    }
}

/// `W phi = lambda M phi` for such vectors.
pub(crate) trait Pencil {
    /// The inner product of M.
    fn inner(&self) -> &dyn InnerSpace;

    /// `Y := W X`, of the rows that are here.
    fn apply_stiffness(&self, x: MatRef<'_, f64>, y: MatMut<'_, f64>, par: Par) -> Result<()>;

    /// [`Pencil::apply_stiffness`] by differences of entries: exact for the constants that a
    /// Laplacian with huge weights takes to nothing.
    fn apply_differences(&self, x: MatRef<'_, f64>, y: MatMut<'_, f64>, par: Par) -> Result<()>;

    /// `Y := |W| |X|`, of the rows that are here.
    fn apply_magnitudes(&self, x: MatRef<'_, f64>, y: MatMut<'_, f64>) -> Result<()>;
}

/// `W - sigma M` for every sigma, of which each process may hold a part. All processes call the
/// same functions in the same order, and get the same answers.
pub(crate) trait Shifts {
    /// Bytes that a factorisation takes, and those that are there anyway.
    fn bytes(&self) -> usize;

    /// The factorisation of the matrix, if it is positive definite.
    fn positive(&self, sigma: f64) -> Result<Option<Box<dyn Inverse + '_>>>;

    /// The factorisation of the matrix with pivots.
    fn indefinite(&self, sigma: f64) -> Result<Box<dyn Inverse + '_>>;
}

/// A symmetric matrix A that is factorised.
pub(crate) trait Inverse {
    /// `X := A^-1 X`, of the rows that are here; the same for every `par`, bit for bit.
    fn solve(&self, x: MatMut<'_, f64>, par: Par) -> Result<()>;

    /// The number of negative eigenvalues of A, by Sylvester's law of inertia.
    fn below_zero(&self) -> usize;

    /// Whether A was found positive definite: there were no pivots.
    fn is_positive(&self) -> bool;

    /// Whether the factor is finite: a singular matrix leaves a zero for a pivot.
    fn is_finite(&self) -> bool;
}

/// All rows are here.
impl InnerSpace for Mass {
    fn dimension(&self) -> usize {
        self.len()
    }

    fn rows(&self) -> Range<usize> {
        0..self.len()
    }

    fn masses(&self) -> Option<&[f64]> {
        match self {
            Self::Lumped(masses) => Some(masses),
            Self::Full(_) => None,
        }
    }

    fn apply_mass(&self, x: MatRef<'_, f64>, y: MatMut<'_, f64>, par: Par) -> Result<()> {
        self.multiply(x, y, par)
    }

    fn sum(&self, _: MatMut<'_, f64>) -> Result<()> {
        Ok(())
    }
}

/// Matrices that are here as a whole.
pub(crate) struct WholePencil<'a> {
    pub stiffness: CsMatView<'a, f64>,
    pub mass: &'a Mass,
}

impl Pencil for WholePencil<'_> {
    fn inner(&self) -> &dyn InnerSpace {
        self.mass
    }

    fn apply_stiffness(&self, x: MatRef<'_, f64>, y: MatMut<'_, f64>, par: Par) -> Result<()> {
        multiply_symmetric_or_rows(self.stiffness, x, y, par);
        Ok(())
    }

    fn apply_differences(&self, x: MatRef<'_, f64>, y: MatMut<'_, f64>, par: Par) -> Result<()> {
        multiply_by_differences(self.stiffness, x, y, par);
        Ok(())
    }

    fn apply_magnitudes(&self, x: MatRef<'_, f64>, y: MatMut<'_, f64>) -> Result<()> {
        multiply_magnitudes(self.stiffness, x, y);
        Ok(())
    }
}
