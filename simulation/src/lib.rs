//! Simulation of **Catamaran**: slime moulds and Newton fractals on surfaces, and plants that wilt.

#![cfg_attr(docsrs, feature(doc_cfg))]

pub mod plant;
pub mod texture;

#[cfg(feature = "opencl")]
pub mod opencl;
