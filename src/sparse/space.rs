//! Interfaces of vectors and matrices that may be distributed over processes by rows.

use std::ops::Range;

use faer::{MatMut, MatRef};
use sprs::CsMatView;

use super::Mass;
use super::product::{multiply_by_differences, multiply_magnitudes, multiply_symmetric_or_rows};
use crate::base::{Par, Result};

/// An inner product of vectors whose rows may be spread over processes.
pub trait InnerSpace {
    /// Returns the number of entries of a vector, on all processes.
    fn dimension(&self) -> usize;

    /// Returns the rows of this process.
    fn rows(&self) -> Range<usize>;

    /// Returns the masses of these rows, if the mass is lumped.
    fn masses(&self) -> Option<&[f64]>;

    /// Computes `Y := M X`, of the rows of this process.
    ///
    /// # Errors
    /// Those of the communication, and `Error::Cancelled`.
    fn apply_mass(&self, x: MatRef<'_, f64>, y: MatMut<'_, f64>, par: Par) -> Result<()>;

    /// Adds the partial sums of the other processes; all processes get the same sum.
    ///
    /// # Errors
    /// Those of the communication, and `Error::Cancelled`.
    fn sum(&self, partial: MatMut<'_, f64>) -> Result<()>;

    /// Computes [`InnerSpace::sum`] of a symmetric matrix; only its lower triangle must be right.
    ///
    /// # Errors
    /// Those of the communication, and `Error::Cancelled`.
    fn sum_symmetric(&self, partial: MatMut<'_, f64>) -> Result<()> {
        self.sum(partial)
    }
}

/// The pencil of `W phi = lambda M phi`, for vectors that may be distributed.
pub(crate) trait Pencil {
    /// Returns the inner product of M.
    fn inner(&self) -> &dyn InnerSpace;

    /// Computes `Y := W X`, of the rows of this process.
    fn apply_stiffness(&self, x: MatRef<'_, f64>, y: MatMut<'_, f64>, par: Par) -> Result<()>;

    /// Computes [`Pencil::apply_stiffness`] by differences of entries: exact for the constants that
    /// a Laplacian with huge weights maps to zero.
    fn apply_differences(&self, x: MatRef<'_, f64>, y: MatMut<'_, f64>, par: Par) -> Result<()>;

    /// Computes `Y := |W| |X|`, of the rows of this process.
    fn apply_magnitudes(&self, x: MatRef<'_, f64>, y: MatMut<'_, f64>) -> Result<()>;
}

/// The matrices `W - sigma M` for every sigma, of which each process may hold a part. All processes
/// call the same functions in the same order, and get the same results.
pub(crate) trait Shifts {
    /// Returns the bytes that a factorization takes, and those that are allocated anyway.
    fn bytes(&self) -> usize;

    /// Factorizes the matrix; returns `None` unless it is positive definite.
    fn positive(&self, sigma: f64) -> Result<Option<Box<dyn Inverse + '_>>>;

    /// Factorizes the matrix with pivots.
    fn indefinite(&self, sigma: f64) -> Result<Box<dyn Inverse + '_>>;
}

/// A symmetric matrix A that is factorized.
pub trait Inverse {
    /// Computes `X := A^-1 X`, of the rows of this process; the same for every `par`, bit for bit.
    ///
    /// # Errors
    /// Those of the communication, and `Error::Cancelled`.
    fn solve(&self, x: MatMut<'_, f64>, par: Par) -> Result<()>;

    /// Returns the number of negative eigenvalues of A, by Sylvester's law of inertia.
    fn below_zero(&self) -> usize;

    /// Returns whether A was found positive definite, without pivots.
    fn is_positive(&self) -> bool;

    /// Returns whether the factor is finite: a singular matrix leaves a zero for a pivot.
    fn is_finite(&self) -> bool;
}

/// All rows are on this process.
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

/// Matrices whose rows are all on this process.
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
