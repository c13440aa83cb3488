//! Spectral unions of partial shapes (thesis, chapter 2): the spectrum of a part of a surface,
//! the spectrum of a union predicted from those of its parts, signatures, retrieval.
//!
//! See docs/algorithms/unions.md for the mathematics.

mod features;
mod localizer;
mod metric;
mod model;
pub mod network;
mod ood;
mod partial;
mod shape_dna;
mod spectrum;
mod tensors;
#[cfg(test)]
mod tests;

pub use features::PartFeatures;
pub use localizer::{Localizer, LocalizerOn};
pub use metric::{MetricOptions, RetrievalMetric};
pub use model::{Scaling, SpectralUnion};
pub use network::K;
pub use ood::OodDetector;
pub use partial::{PartSpectra, cloud_spectrum};
pub use shape_dna::{Match, ShapeDnaOptions, retrieve, shape_dna};
pub use spectrum::interpolate;
