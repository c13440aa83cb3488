use crate::base::{Error, Result};
use crate::product::schemes::ProductKind;

/// What a product computes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Op {
    /// The lower triangle of A^T A.
    Syrk,
    /// The lower triangle of A^T B.
    Gemmt,
    /// A^T B.
    Gemm,
}

impl Op {
    /// Returns whether only the lower triangle of the result is computed.
    pub fn symmetric(self) -> bool {
        self != Self::Gemm
    }

    /// Returns what a product of a scheme becomes inside a node of this kind: without A = B there
    /// are no squares.
    pub fn of_product(self, kind: ProductKind) -> Self {
        match (kind, self) {
            (ProductKind::Gemm, _) => Self::Gemm,
            (ProductKind::SyrkFull, Self::Syrk) => Self::Syrk,
            (ProductKind::SyrkFull, _) => Self::Gemm,
            (ProductKind::Syrk, Self::Syrk) => Self::Syrk,
            (ProductKind::Syrk | ProductKind::Gemmt, _) => Self::Gemmt,
        }
    }
}

/// An operation on A m x n and B m x k, which gives C n x k.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Problem {
    pub op: Op,
    pub m: usize,
    pub n: usize,
    pub k: usize,
}

impl Problem {
    /// Creates the problem after a check of its sizes.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`] for matrices that no memory holds, before their sizes overflow.
    pub fn new(op: Op, m: usize, n: usize, k: usize) -> Result<Self> {
        const MAX_ENTRIES: usize = isize::MAX as usize / 64;
        for (rows, cols) in [(m, n), (m, k), (n, k)] {
            if rows.checked_mul(cols).is_none_or(|entries| entries > MAX_ENTRIES) {
                let bytes = rows.saturating_mul(cols).saturating_mul(4);
                return Err(Error::OutOfMemory { bytes });
            }
        }
        Ok(Self { op, m, n, k })
    }

    /// Returns whether A serves as both operands.
    pub fn same(&self) -> bool {
        self.op == Op::Syrk
    }
}
