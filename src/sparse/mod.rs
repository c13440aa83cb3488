//! Sparse symmetric matrices: inner products and eigenpairs.

mod mass;

pub use mass::Mass;
/// The sparse matrix, by rows, from crate sprs.
pub use sprs::{CsMat, CsMatView};
