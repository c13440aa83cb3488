//! The C ABI: `include/catamaran.h` is generated from this module by `cargo xtask header`.
//!
//! One file per area; every export that can fail passes through `boundary`, and only `pointer`
//! makes views of memory of C. Nothing here is meant to be called from Rust.
//!
//! The products need the feature `capi-ata`, all chapters `capi`, and the functions of MPI also
//! `mpi`. `absent` has functions of the same names for absent features.

#![allow(non_camel_case_types)] // the names are those of the C header

#[cfg(not(all(feature = "capi", feature = "mpi")))]
mod absent;
mod aha;
mod ata;
mod ata_params;
mod atb;
mod backend;
mod boundary;
#[cfg(any(debug_assertions, test))]
mod internal;
mod layout;
mod memory;
mod message;
mod params;
mod pointer;
mod progress;
mod regions;
mod rows;
mod status;
mod verify;
mod version;

#[cfg(feature = "capi")]
mod accumulator;
#[cfg(feature = "capi")]
mod ata_sparse;
#[cfg(feature = "capi")]
mod basis;
#[cfg(feature = "capi")]
mod curve;
#[cfg(feature = "capi")]
mod decimation;
#[cfg(feature = "capi")]
mod device;
#[cfg(feature = "capi")]
mod eigs;
#[cfg(feature = "capi")]
mod gram;
#[cfg(feature = "capi")]
mod lstsq;
#[cfg(feature = "capi")]
mod map;
#[cfg(feature = "capi")]
mod mesh;
#[cfg(feature = "capi")]
mod newton;
#[cfg(feature = "capi")]
mod ortho;
#[cfg(feature = "capi")]
mod outputs;
#[cfg(feature = "capi")]
mod pca;
#[cfg(feature = "capi")]
mod plant;
#[cfg(feature = "capi")]
mod rods;
#[cfg(feature = "capi")]
mod shape_dna;
#[cfg(feature = "capi")]
mod slime;
#[cfg(feature = "capi")]
mod transfer;
#[cfg(feature = "capi")]
mod unions;

#[cfg(all(feature = "capi", feature = "mpi"))]
mod entries;
#[cfg(all(feature = "capi", feature = "mpi"))]
mod mpi;
#[cfg(all(feature = "capi", feature = "mpi"))]
mod ranks;
#[cfg(all(feature = "capi", feature = "mpi"))]
mod world;

#[cfg(not(all(feature = "capi", feature = "mpi")))]
pub use absent::*;
pub use aha::*;
pub use ata::*;
pub use ata_params::*;
pub use atb::*;
pub use backend::*;
#[cfg(any(debug_assertions, test))]
pub use internal::*;
pub use layout::*;
pub use memory::*;
pub use progress::*;
pub use rows::*;
pub use status::*;
pub use verify::*;
pub use version::*;

#[cfg(feature = "capi")]
pub use accumulator::*;
#[cfg(feature = "capi")]
pub use ata_sparse::*;
#[cfg(feature = "capi")]
pub use basis::*;
#[cfg(feature = "capi")]
pub use curve::*;
#[cfg(feature = "capi")]
pub use decimation::*;
#[cfg(feature = "capi")]
pub use device::*;
#[cfg(feature = "capi")]
pub use eigs::*;
#[cfg(feature = "capi")]
pub use gram::*;
#[cfg(feature = "capi")]
pub use lstsq::*;
#[cfg(feature = "capi")]
pub use map::*;
#[cfg(feature = "capi")]
pub use mesh::*;
#[cfg(feature = "capi")]
pub use newton::*;
#[cfg(feature = "capi")]
pub use ortho::*;
#[cfg(feature = "capi")]
pub use pca::*;
#[cfg(feature = "capi")]
pub use plant::*;
#[cfg(feature = "capi")]
pub use rods::*;
#[cfg(feature = "capi")]
pub use shape_dna::*;
#[cfg(feature = "capi")]
pub use slime::*;
#[cfg(feature = "capi")]
pub use transfer::*;
#[cfg(feature = "capi")]
pub use unions::*;

#[cfg(all(feature = "capi", feature = "mpi"))]
pub use mpi::*;
#[cfg(all(feature = "capi", feature = "mpi"))]
pub use world::*;

#[cfg(all(test, not(feature = "capi")))]
mod tests {
    use std::ffi::CStr;

    #[test]
    fn functions_of_absent_features_say_so() {
        let null = std::ptr::null_mut();
        // SAFETY: the function does not read its arguments.
        let status = unsafe { super::cata_device_count(null) };
        assert_eq!(status, super::CATA_ERR_UNSUPPORTED);
        // SAFETY: NUL-terminated, and no call of this thread fails before it is read.
        let message = unsafe { CStr::from_ptr(super::cata_last_error_message()) };
        assert_eq!(message, c"built without the feature capi");
        assert_eq!(super::cata_capabilities() & super::CATA_CAP_CHAPTERS, 0);
    }
}
