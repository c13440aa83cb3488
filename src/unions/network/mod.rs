//! The transformer behind [`SpectralUnion`](super::SpectralUnion): its parameters and its forward pass, generic over the scalar,
//! with everything kept that back-propagation (the workspace member `training`) needs.
//!
//! Source: thesis, section 2.4, with the pre-norm layers of Xiong et al. 2020. Departures: docs/decisions/0026.

mod forward;
mod kernel;
mod places;

pub use forward::{LayerTape, Tape, forward};
pub use kernel::{Number, gemm, normalize, sum};
pub use places::{Architecture, LayerPlaces, Place, Places};

/// Eigenvalues of a spectrum, and so tokens of a sequence.
pub const K: usize = 20;

/// Numbers that a token begins with: see [`Question`](super::Question).
pub const FEATURES: usize = 4;
