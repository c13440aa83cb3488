//! Eigenpairs of sparse pencils and orthonormal bases.

#[path = "../common/mod.rs"]
mod common;
mod ortho;
mod sparse;
