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
mod space;

#[cfg(feature = "mpi")]
pub(crate) use check::{check_mirrored, check_symmetric};
#[cfg(feature = "mpi")]
pub(crate) use eigs::eigs_of;
pub use eigs::{EigenOptions, Eigenpairs, eigs};
pub use mass::Mass;
pub use product::multiply;
pub(crate) use space::InnerSpace;
#[cfg(feature = "mpi")]
pub(crate) use space::Pencil;
/// The sparse matrix, by rows, from crate sprs.
pub use sprs::{CsMat, CsMatView};
