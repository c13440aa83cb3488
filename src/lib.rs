//! **Catamaran**: A^T A, and what stands on it, at scale.
//!
//! The centre is the symmetric product `C := alpha A^T A + beta C` ([`ata()`]), computed by proven
//! bilinear schemes (the 2 x 2 recursion over Strassen of the thesis, RXTX, KGP, ...) above any
//! BLAS, or above a pure-Rust kernel when there is none.
//!
//! ```
//! use catamaran::{ata, AtaOptions, faer::Mat};
//!
//! let a = Mat::<f64>::from_fn(5, 3, |i, j| (i + 2 * j) as f64);
//! let mut c = Mat::<f64>::zeros(3, 3);
//! ata(1.0, a.as_ref(), 0.0, c.as_mut(), &AtaOptions::default())?;
//! assert_eq!(c[(2, 1)], a.col(2).transpose() * a.col(1));
//! # Ok::<(), catamaran::Error>(())
//! ```
//!
//! The layers, from the bottom: [`base`] (scalars, errors, workspaces, threads), [`kernel`]
//! (arithmetic per instruction set), [`blas`] (back ends), [`ata`](mod@ata) (schemes, plans,
//! execution, the exact path, checks), [`dense`] (what is dense and small), [`sparse`] (eigenpairs), [`ortho`] (Gram-Schmidt), [`mesh`] (triangle meshes),
//! [`io`] (matrix files), [`spectral`] (eigenproducts, functional maps), [`plant`] (water and wilting), [`decimate`]
//! (uniform decimation), [`curve`] (curves through samples), [`texture`] (slime moulds and fractals),
//! [`unions`] (spectral unions of parts), `mpi` (many machines), `opencl` (devices) and the C ABI `capi`,
//! features of these names. A layer imports only the layers below it; a test says so.

pub mod base;

pub mod kernel;

pub mod blas;

pub mod ata;

pub mod dense;

pub mod sparse;

pub mod ortho;

pub mod mesh;

pub mod io;

pub mod spectral;

pub mod curve;
pub mod decimate;
pub mod plant;
pub mod texture;
pub mod unions;

#[cfg(feature = "mpi")]
pub mod mpi;

#[cfg(feature = "opencl")]
pub mod opencl;

#[cfg(feature = "capi")]
pub mod capi;

/// The matrix library whose views ([`faer::MatRef`], [`faer::MatMut`]) the API takes.
pub use faer;

pub use ata::{
    Accuracy, AtaOptions, Plan, SchemeChoice, Uplo, aat, aat_scratch_len, aat_with_scratch, ata,
    ata_scratch_len, ata_with_scratch, atb, atb_scratch_len, atb_with_scratch,
};
pub use base::{Error, Par, Real, Result};
