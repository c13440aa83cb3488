//! Simulation of **Catamaran**: slime moulds and Newton fractals on surfaces, and plants that wilt.
//!
//! | Module | Content | Feature |
//! |---|---|---|
//! | [`plant`] | water in plants, and rods that wilt | |
//! | [`texture`] | slime moulds and Newton fractals, as textures and materials | |
//! | `opencl` | their kernels on OpenCL devices | `opencl` |
//!
//! Errors, threads and progress are those of the crate [`catamaran`], meshes those of
//! [`catamaran_geometry`].

#![cfg_attr(docsrs, feature(doc_cfg))]

pub mod plant;
pub mod texture;

#[cfg(feature = "opencl")]
pub mod opencl;
