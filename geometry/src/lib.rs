//! Geometry of **Catamaran**: triangle meshes and their spectra, decimation, and curves.
//!
//! ```
//! use catamaran_geometry::{mesh::families, prelude::*};
//!
//! let operator = laplacian(&families::icosphere(3)?, &LaplacianOptions::new())?;
//! let pairs = eigs(operator.stiffness.view(), &operator.mass, &EigenOptions::new().k(4))?;
//! assert!((pairs.values[3] - 2.0).abs() < 0.02); // l (l + 1) on the unit sphere
//! # Ok::<(), Error>(())
//! ```
//!
//! | Module | Content | Feature |
//! |---|---|---|
//! | [`mesh`] | files, topology, repair, distances, Laplacians | |
//! | [`spectral`] | eigenproducts, filters, functional maps, descriptors | |
//! | [`decimate`] | uniform decimation, farthest points | |
//! | [`curve`] | curves through unordered samples, regions | |
//! | `unions` | spectra of unions of parts, by a network with 1.8 MB of weights | `unions` |
//!
//! Errors, threads, progress and sparse matrices are those of the crate [`catamaran`].

#![cfg_attr(docsrs, feature(doc_cfg))]

pub mod curve;
pub mod decimate;
pub mod mesh;
pub mod prelude;
pub mod spectral;

#[cfg(feature = "unions")]
pub mod unions;

/// The structs of options and their fields, for the other crates of this workspace: no part of the
/// interface.
#[doc(hidden)]
pub const OPTIONS: &[(&str, &[catamaran::base::Field])] = &[
    ("mesh::LaplacianOptions", mesh::LaplacianOptions::FIELDS),
    ("mesh::HeatOptions", mesh::HeatOptions::FIELDS),
    ("mesh::CloudOptions", mesh::CloudOptions::FIELDS),
    ("mesh::RepairOptions", mesh::RepairOptions::FIELDS),
    ("mesh::io::Material", mesh::io::Material::FIELDS),
    ("spectral::ProductBasisOptions", spectral::ProductBasisOptions::FIELDS),
    ("spectral::ShapeOptions", spectral::ShapeOptions::FIELDS),
    ("decimate::DecimateOptions", decimate::DecimateOptions::FIELDS),
    ("curve::CurveOptions", curve::CurveOptions::FIELDS),
    #[cfg(feature = "unions")]
    ("unions::ShapeDnaOptions", unions::ShapeDnaOptions::FIELDS),
    #[cfg(feature = "unions")]
    ("unions::MetricOptions", unions::MetricOptions::FIELDS),
];

#[cfg(all(test, debug_assertions, feature = "unions"))]
mod interruption;
