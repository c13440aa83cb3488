//! Gram-Schmidt in an M-inner product, blocked, with rank detection; Cholesky QR
//! (docs/algorithms/eigen.md).

mod cholesky_qr;
mod gram_schmidt;
mod inner;
mod panel;
mod rank_revealing;
mod scale;

pub use cholesky_qr::cholesky_qr;
#[cfg(feature = "mpi")]
pub(crate) use gram_schmidt::gram_schmidt_of;
pub use gram_schmidt::{
    GramSchmidtOptions, Orthonormal, TriangularFactor, gram_schmidt, gram_schmidt_in_place,
};
pub use rank_revealing::{rank_revealing, rank_revealing_in_place};

// For the other crates of this workspace: no part of the interface.
#[doc(hidden)]
pub use cholesky_qr::cholesky_qr_of;
