//! Sparse symmetric matrices: inner products, products and eigenpairs (docs/algorithms/eigen.md).

mod certificate;
mod check;
mod cholesky;
mod components;
mod eigs;
mod lanczos;
mod mass;
mod problem;
mod product;
mod shifted;
mod slices;
mod small;

pub(crate) use cholesky::Symbolic;
pub use eigs::{EigenOptions, Eigenpairs, eigs};
pub use mass::Mass;
pub use product::multiply;
pub use slices::eigs_sliced;
/// The sparse matrix, by rows, from crate sprs.
pub use sprs::{CsMat, CsMatView};
