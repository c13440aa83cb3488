//! Eigenpairs of sparse pencils, sparse Cholesky factorizations and orthonormal bases.

mod cholesky;
#[path = "../common/mod.rs"]
mod common;
mod ortho;
mod sparse;
