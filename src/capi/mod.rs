//! The C ABI: `include/catamaran.h` is generated from this module by `cargo xtask header`.
//!
//! One file per area; every export that can fail passes through `boundary`, and only `pointer`
//! makes views of what C points to. Nothing here is meant to be called from Rust.

#![allow(non_camel_case_types)] // the names are those of the C header

mod accumulator;
mod aha;
mod ata;
mod ata_params;
mod ata_sparse;
mod atb;
mod backend;
mod basis;
mod boundary;
mod curve;
mod decimation;
mod device;
mod eigs;
#[cfg(feature = "mpi")]
mod entries;
mod gram;
mod internal;
mod layout;
mod lstsq;
mod map;
mod memory;
mod mesh;
mod message;
mod mpi;
mod newton;
mod ortho;
mod outputs;
mod params;
mod pca;
mod plant;
mod pointer;
mod progress;
#[cfg(feature = "mpi")]
mod ranks;
mod rods;
mod rows;
mod shape_dna;
mod slime;
mod status;
mod transfer;
mod unions;
mod verify;
mod version;
mod world;

pub use accumulator::*;
pub use aha::*;
pub use ata::*;
pub use ata_params::*;
pub use ata_sparse::*;
pub use atb::*;
pub use backend::*;
pub use basis::*;
pub use curve::*;
pub use decimation::*;
pub use device::*;
pub use eigs::*;
pub use gram::*;
pub use internal::*;
pub use layout::*;
pub use lstsq::*;
pub use map::*;
pub use memory::*;
pub use mesh::*;
pub use mpi::*;
pub use newton::*;
pub use ortho::*;
pub use pca::*;
pub use plant::*;
pub use progress::*;
pub use rods::*;
pub use rows::*;
pub use shape_dna::*;
pub use slime::*;
pub use status::*;
pub use transfer::*;
pub use unions::*;
pub use verify::*;
pub use version::*;
pub use world::*;
