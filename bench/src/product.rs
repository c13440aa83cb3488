//! What is computed: a product of given operands, all of them row-major.

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
    /// Its formula.
    pub fn formula(self) -> &'static str {
        match self {
            Self::Syrk => "A^T A",
            Self::Gemm => "A^T B",
        }
    }

    /// The routine of BLAS that computes it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Syrk => "syrk",
            Self::Gemm => "gemm",
        }
    }

    /// Operations of the classical algorithm: m n^2 or 2 m n^2.
    pub fn flops(self, Shape { m, n }: Shape) -> f64 {
        let square = m as f64 * n as f64 * n as f64;
        match self {
            Self::Syrk => square,
            Self::Gemm => 2.0 * square,
        }
    }

    /// Entries of C that are computed.
    pub fn entries(self, n: usize) -> usize {
        match self {
            Self::Syrk => n * (n + 1) / 2,
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
    /// A^T A; A m x n.
    pub fn syrk(shape: Shape, a: &'a [T]) -> Self {
        Self { operation: Operation::Syrk, shape, operands: [a, a] }
    }

    /// A^T B; A and B m x n.
    pub fn gemm(shape: Shape, a: &'a [T], b: &'a [T]) -> Self {
        Self { operation: Operation::Gemm, shape, operands: [a, b] }
    }

    /// Its kind.
    pub fn operation(&self) -> Operation {
        self.operation
    }

    /// Shape of A, and of B.
    pub fn shape(&self) -> Shape {
        self.shape
    }

    /// A and B, which is A in A^T A.
    pub fn operands(&self) -> [&'a [T]; 2] {
        self.operands
    }

    /// Views of [`Self::operands`].
    pub fn views(&self) -> [MatRef<'a, T>; 2] {
        let Shape { m, n } = self.shape;
        self.operands.map(|x| MatRef::from_row_major_slice(x, m, n))
    }
}
