//! The computed product and its operands, all of them row-major.

use catamaran::base::triangle_len;
use faer::MatRef;

use crate::input::Shape;

/// The kind of product.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Operation {
    /// The lower triangle of C := A^T A.
    Syrk,
    /// All of C := A^T B, B of the shape of A.
    Gemm,
}

impl Operation {
    /// Returns the formula of the product.
    pub fn formula(self) -> &'static str {
        match self {
            Self::Syrk => "A^T A",
            Self::Gemm => "A^T B",
        }
    }

    /// Returns the routine of BLAS that computes the product.
    pub fn name(self) -> &'static str {
        match self {
            Self::Syrk => "syrk",
            Self::Gemm => "gemm",
        }
    }

    /// Returns the number of operations of the classical algorithm: m n^2 or 2 m n^2.
    pub fn flops(self, Shape { m, n }: Shape) -> f64 {
        let square = m as f64 * n as f64 * n as f64;
        match self {
            Self::Syrk => square,
            Self::Gemm => 2.0 * square,
        }
    }

    /// Returns the number of entries of C that are computed.
    pub fn entries(self, n: usize) -> usize {
        match self {
            Self::Syrk => triangle_len(n),
            Self::Gemm => n * n,
        }
    }
}

/// A product and its operands.
#[derive(Clone, Copy)]
pub struct Product<'a, T> {
    operation: Operation,
    shape: Shape,
    operands: [&'a [T]; 2],
}

impl<'a, T> Product<'a, T> {
    /// Creates the product A^T A; A is m x n.
    pub fn syrk(shape: Shape, a: &'a [T]) -> Self {
        Self { operation: Operation::Syrk, shape, operands: [a, a] }
    }

    /// Creates the product A^T B; A and B are m x n.
    pub fn gemm(shape: Shape, a: &'a [T], b: &'a [T]) -> Self {
        Self { operation: Operation::Gemm, shape, operands: [a, b] }
    }

    /// Returns the kind of product.
    pub fn operation(&self) -> Operation {
        self.operation
    }

    /// Returns the shape of A and of B.
    pub fn shape(&self) -> Shape {
        self.shape
    }

    /// Returns A and B, which is A in A^T A.
    pub fn operands(&self) -> [&'a [T]; 2] {
        self.operands
    }

    /// Returns views of [`Self::operands`].
    pub fn views(&self) -> [MatRef<'a, T>; 2] {
        let Shape { m, n } = self.shape;
        self.operands.map(|x| MatRef::from_row_major_slice(x, m, n))
    }
}
