//! Geometry of **Catamaran**: meshes, spectra, decimation, curves, spectra of unions of parts.

#![cfg_attr(docsrs, feature(doc_cfg))]

pub mod curve;
pub mod decimate;
pub mod mesh;
pub mod spectral;

#[cfg(feature = "unions")]
pub mod unions;

#[cfg(all(test, debug_assertions, feature = "unions"))]
mod interruption;
