//! Races of `catamaran::ata_into` and `catamaran::atb_into` against other libraries on the same
//! machine, their errors in comparison, and the parts of both.
//!
//! See README.md of this package for how to run it and what the columns mean.

pub mod accuracy;
pub mod batch;
pub mod chart;
pub mod child;
pub mod contender;
pub mod curves;
#[cfg(feature = "chapters")]
pub mod decimate;
pub mod double;
pub mod exchange;
#[cfg(feature = "chapters")]
pub mod gram;
pub mod grid;
pub mod host;
pub mod input;
pub mod library;
pub mod peak;
#[cfg(feature = "chapters")]
pub mod plant;
pub mod product;
pub mod race;
pub mod record;
pub mod reference;
pub mod scale;
pub mod scatter;
#[cfg(feature = "chapters")]
pub mod spectral;
#[cfg(feature = "chapters")]
pub mod surface_curves;
pub mod table;
#[cfg(feature = "chapters")]
pub mod textures;

/// The result of all functions here; the message of an error is all that users need.
pub type Result<T> = std::result::Result<T, Box<dyn std::error::Error + Send + Sync>>;
