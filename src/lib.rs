//! **Catamaran** computes symmetric products `C := alpha A^T A + beta C` of any matrix, at scale,
//! and builds solves, eigenpairs and bases on them.
//!
//! ```
//! use catamaran::prelude::*;
//!
//! let a = Mat::<f64>::from_fn(5, 3, |i, j| (i + 2 * j) as f64);
//! let mut c = ata(&a)?;
//! assert_eq!(c[(2, 1)], a.col(2).transpose() * a.col(1));
//!
//! // Options, factors, and memory of the caller: C := 2 A^T A - C, on one thread.
//! let options = AtaOptions::new().threads(1).uplo(Uplo::Both);
//! ata_into(2.0, a.as_ref(), -1.0, c.as_mut(), &options)?;
//! assert_eq!(c, ata(&a)?);
//! # Ok::<(), Error>(())
//! ```
//!
//! [`ata()`] takes proven bilinear schemes (the 2 x 2 recursion over Strassen of the thesis, RXTX,
//! KGP), integer products modulo small coprime numbers, or the classical algorithm, whichever the
//! planner expects to be fastest. The arithmetic runs in kernels written in Rust or in any BLAS.
//!
//! # Modules
//!
//! Imports between modules run one way; a test checks that.
//!
//! | Module | Content |
//! |---|---|
//! | [`base`] | scalars, errors, threads, progress, workspaces, random numbers |
//! | [`kernel`] | kernels for each instruction set |
//! | [`blas`] | back ends: the kernels of this crate, or a BLAS that is loaded at run time |
//! | [`product`] | A^T A, A A^T, A^T B, A^H A, A^H B, sparse A, plans, the exact path, checks |
//! | [`rows`] | A^T A of rows from anywhere, in sums that can be saved, continued and merged |
//! | [`dense`] | small dense factorizations |
//! | [`solve`] | least squares, principal components, singular values, in extended precision |
//! | [`sparse`] | Cholesky factorizations and eigenpairs of sparse matrices |
//! | [`ortho`] | Gram-Schmidt, Cholesky QR, rank-revealing bases |
//! | [`io`] | matrix files: `.npy`, `.npz`, `.mtx`, text tables, Parquet, Arrow, HDF5 |
//! | [`ranks`] | the same over many machines: plans, and their execution (feature `mpi`) |
//!
//! Meshes, spectra of surfaces, decimation and curves are in the crate `catamaran-geometry`, plants
//! and textures in `catamaran-simulation`, the C interface in `catamaran-capi`.
//!
//! # Features
//!
//! None is on by default. All but `columnar` need a library of the system.
//!
//! | Feature | Adds |
//! |---|---|
//! | `openblas` | OpenBLAS, linked at build time (`blas::openblas`) |
//! | `mpi` | the execution in [`ranks`], over the MPI of the system |
//! | `hdf5` | rows and arrays in HDF5 files |
//! | `columnar` | tables in Parquet and Arrow files, and files packed by Zstandard |

#![cfg_attr(docsrs, feature(doc_cfg))]

pub mod base;
pub mod blas;
pub mod kernel;
pub mod prelude;
pub mod product;
pub mod rows;

pub mod dense;
pub mod io;
pub mod ortho;
pub mod ranks;
pub mod solve;
pub mod sparse;

/// The matrix library whose views ([`faer::MatRef`], [`faer::MatMut`]) the API takes.
pub use faer;

pub use base::{Error, Par, Real, Result};
pub use product::{
    Accuracy, AtaOptions, Plan, SchemeChoice, Uplo, aat, aat_into, aha, aha_into, ahb, ahb_into,
    ata, ata_into, atb, atb_into,
};

/// Compiles the code of the guide as documentation tests.
#[cfg(doctest)]
#[doc = include_str!("../docs/guide/rust.md")]
struct Guide;

/// The structs of options and their fields, for the other crates of this workspace: no part of the
/// interface.
#[doc(hidden)]
pub const OPTIONS: &[(&str, &[base::Field])] = &[
    ("product::AtaOptions", AtaOptions::FIELDS),
    ("rows::RowOptions", rows::RowOptions::<f64>::FIELDS),
    ("solve::LeastSquaresOptions", solve::LeastSquaresOptions::FIELDS),
    ("solve::PrincipalComponentsOptions", solve::PrincipalComponentsOptions::FIELDS),
    ("sparse::CholeskyOptions", sparse::CholeskyOptions::FIELDS),
    ("sparse::EigenOptions", sparse::EigenOptions::FIELDS),
    ("ortho::GramSchmidtOptions", ortho::GramSchmidtOptions::FIELDS),
    ("io::ReadOptions", io::ReadOptions::FIELDS),
    ("io::SourceOptions", io::SourceOptions::FIELDS),
    ("io::TableOptions", io::TableOptions::FIELDS),
];
