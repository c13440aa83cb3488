//! Sparse symmetric matrices: inner products, products and eigenpairs (docs/algorithms/eigen.md).

mod certificate;
mod check;
mod cholesky;
mod components;
mod eigs;
mod lanczos;
mod mass;
mod product;
mod shifted;
mod small;

pub use eigs::{EigenOptions, Eigenpairs, eigs};
pub use mass::Mass;
pub use product::multiply;
/// The sparse matrix, by rows, from crate sprs.
pub use sprs::{CsMat, CsMatView};
