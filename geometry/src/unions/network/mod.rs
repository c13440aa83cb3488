//! The network behind [`SpectralUnion`](super::SpectralUnion): its parameters and its forward pass,
//! generic over the scalar. The forward pass keeps the intermediate results for back-propagation in
//! the workspace member `training`.
//!
//! Source: thesis, section 2.4 (a commutative sum between an encoder and a decoder); each part is
//! encoded separately, as for sets (Zaheer et al. 2017); the layers are gated residual perceptrons
//! with normalization first (Shazeer 2020, Xiong et al. 2020), not attention:
//! docs/algorithms/unions.md.

mod forward;
mod kernel;
mod layout;
mod quantize;

pub use forward::{LayerTape, Tape, forward, sigmoid};
pub use kernel::{Number, gemm, normalize, sum};
pub use layout::{Architecture, LayerLayout, Parameter, ParameterLayout};
pub use quantize::quantize;
pub(super) use quantize::{column_units, from_integers, is_quantized, to_integers};

/// The number of eigenvalues of a spectrum.
pub const K: usize = 20;

/// The number of features of each eigenvalue of a part: see [`PartFeatures`](super::PartFeatures).
pub const FEATURES: usize = 2;

/// Number of doublings of the logarithm whose sines and cosines the first layer reads, so that it
/// can distinguish eigenvalues in a narrow range.
const OCTAVES: usize = 3;

/// The number of inputs of the first layer for each eigenvalue: the features, and sines and cosines
/// of the logarithm and of its doublings.
pub const INPUTS: usize = FEATURES + 2 * OCTAVES;
