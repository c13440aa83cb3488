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

/// The structs of options and their fields, for the other crates of this workspace: no part of the
/// interface.
#[doc(hidden)]
pub const OPTIONS: &[(&str, &[catamaran::base::Field])] = &[
    ("plant::families::GrowthOptions", plant::families::GrowthOptions::FIELDS),
    ("plant::ReadOptions", plant::ReadOptions::FIELDS),
    ("plant::WaterOptions", plant::WaterOptions::FIELDS),
    ("plant::Stomata", plant::Stomata::FIELDS),
    ("plant::CurveOptions", plant::CurveOptions::FIELDS),
    ("plant::RodOptions", plant::RodOptions::FIELDS),
    ("plant::RelaxOptions", plant::RelaxOptions::FIELDS),
    ("plant::MotionOptions", plant::MotionOptions::FIELDS),
    ("plant::WiltOptions", plant::WiltOptions::FIELDS),
    ("plant::Wind", plant::Wind::FIELDS),
    ("plant::SwayOptions", plant::SwayOptions::FIELDS),
    ("plant::FitOptions", plant::FitOptions::FIELDS),
    ("plant::LeafOptions", plant::LeafOptions::FIELDS),
    ("texture::Finish", texture::Finish::FIELDS),
    ("texture::newton::NewtonOptions", texture::newton::NewtonOptions::FIELDS),
    ("texture::slime::Options", texture::slime::Options::FIELDS),
];
