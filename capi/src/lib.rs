//! The C ABI: `include/catamaran.h` is generated from this crate by `cargo xtask header`.
//!
//! One file per area; every export that can fail passes through `boundary`, and only `pointer`
//! makes views of memory of C. Nothing here is meant to be called from Rust.
//!
//! All but the products need the feature `chapters` (default), the functions of MPI also `mpi`;
//! `absent` has functions of the same names for absent features.
//!
//! # Safety of this module
//!
//! The header states what callers of C owe the library. `SAFETY` comments name the part that a
//! place uses, and the arguments:
//!
//! - **`memory`**: an array that the header describes has so many elements, of which inputs can be
//!   read and outputs also written during the call, and no other thread writes inputs or uses
//!   outputs. The functions of `pointer` refuse NULL where there are elements, pointers that are
//!   not aligned, extents beyond the address space and, by `regions`, outputs that overlap another
//!   argument. Whether the memory exists is the caller's part.
//! - **`handles`**: a handle is NULL, which is refused or does nothing, or came from a constructor
//!   and has not been freed; nobody else, a callback of the call included, uses one that is taken
//!   without `const`, or frees one. The crate does not look behind the pointer before it is
//!   compared with NULL. `known` takes only what threads may share.
//! - **`structs`**: a struct of parameters or results is NULL where it may be, or has as many bytes
//!   as its first field, `struct_size`, says. `params` checks the size and touches no more bytes,
//!   and all fields may be 0. Pointers inside follow their own clause.
//! - **`texts`**: a text is NULL, which is refused or means the default, or ends with a NUL and is
//!   not written during the call. It is copied at once (`utf8`, `path`).
//! - **`callbacks`**: a callback does not unwind or jump out, and takes its `user` on any thread,
//!   one call at a time. Only `progress` and `sink` call one.
//! - **`passed on`**: the named function has the contract of the function that calls it, and gets
//!   its arguments as they are, or those parts of them that it describes.

#![allow(non_camel_case_types)] // the names are those of the C header

#[cfg(not(feature = "mpi"))]
mod absent;
mod aha;
mod ata;
mod ata_batched;
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

#[cfg(feature = "chapters")]
mod accumulator;
#[cfg(feature = "chapters")]
mod ata_plan;
#[cfg(feature = "chapters")]
mod ata_sparse;
#[cfg(feature = "chapters")]
mod basis;
#[cfg(feature = "chapters")]
mod cholesky;
#[cfg(feature = "chapters")]
mod curve;
#[cfg(feature = "chapters")]
mod decimation;
#[cfg(all(feature = "chapters", test))]
mod defaults;
#[cfg(feature = "chapters")]
mod descriptor;
#[cfg(feature = "chapters")]
mod device;
#[cfg(feature = "chapters")]
mod distance;
#[cfg(feature = "chapters")]
mod drawing;
#[cfg(feature = "chapters")]
mod eigs;
#[cfg(feature = "chapters")]
mod filter;
#[cfg(feature = "chapters")]
mod generated;
#[cfg(feature = "chapters")]
mod gram;
#[cfg(feature = "chapters")]
mod laplacian;
#[cfg(feature = "chapters")]
mod lstsq;
#[cfg(feature = "chapters")]
mod map;
#[cfg(feature = "chapters")]
mod measures;
#[cfg(feature = "chapters")]
mod mesh;
#[cfg(feature = "chapters")]
mod mesh_attributes;
#[cfg(feature = "chapters")]
mod mesh_file;
#[cfg(feature = "chapters")]
mod newton;
#[cfg(feature = "chapters")]
mod ortho;
#[cfg(feature = "chapters")]
mod outputs;
#[cfg(feature = "chapters")]
mod pca;
#[cfg(feature = "chapters")]
mod plant;
#[cfg(feature = "chapters")]
mod repair;
#[cfg(feature = "chapters")]
mod rods;
#[cfg(feature = "chapters")]
mod shape;
#[cfg(feature = "chapters")]
mod shape_dna;
#[cfg(feature = "chapters")]
mod slime;
#[cfg(feature = "chapters")]
mod surface_region;
#[cfg(feature = "chapters")]
mod table;
#[cfg(feature = "chapters")]
mod topology;
#[cfg(feature = "chapters")]
mod transfer;
#[cfg(feature = "chapters")]
mod unions;

#[cfg(feature = "mpi")]
mod entries;
#[cfg(feature = "mpi")]
mod mpi;
#[cfg(feature = "mpi")]
mod ranks;
#[cfg(feature = "mpi")]
mod world;

#[cfg(not(feature = "mpi"))]
pub use absent::*;
pub use aha::*;
pub use ata::*;
pub use ata_batched::*;
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

#[cfg(feature = "chapters")]
pub use accumulator::*;
#[cfg(feature = "chapters")]
pub use ata_plan::*;
#[cfg(feature = "chapters")]
pub use ata_sparse::*;
#[cfg(feature = "chapters")]
pub use basis::*;
#[cfg(feature = "chapters")]
pub use cholesky::*;
#[cfg(feature = "chapters")]
pub use curve::*;
#[cfg(feature = "chapters")]
pub use decimation::*;
#[cfg(feature = "chapters")]
pub use descriptor::*;
#[cfg(feature = "chapters")]
pub use device::*;
#[cfg(feature = "chapters")]
pub use distance::*;
#[cfg(feature = "chapters")]
pub use drawing::*;
#[cfg(feature = "chapters")]
pub use eigs::*;
#[cfg(feature = "chapters")]
pub use filter::*;
#[cfg(feature = "chapters")]
pub use generated::*;
#[cfg(feature = "chapters")]
pub use gram::*;
#[cfg(feature = "chapters")]
pub use laplacian::*;
#[cfg(feature = "chapters")]
pub use lstsq::*;
#[cfg(feature = "chapters")]
pub use map::*;
#[cfg(feature = "chapters")]
pub use measures::*;
#[cfg(feature = "chapters")]
pub use mesh::*;
#[cfg(feature = "chapters")]
pub use mesh_attributes::*;
#[cfg(feature = "chapters")]
pub use mesh_file::*;
#[cfg(feature = "chapters")]
pub use newton::*;
#[cfg(feature = "chapters")]
pub use ortho::*;
#[cfg(feature = "chapters")]
pub use pca::*;
#[cfg(feature = "chapters")]
pub use plant::*;
#[cfg(feature = "chapters")]
pub use repair::*;
#[cfg(feature = "chapters")]
pub use rods::*;
#[cfg(feature = "chapters")]
pub use shape::*;
#[cfg(feature = "chapters")]
pub use shape_dna::*;
#[cfg(feature = "chapters")]
pub use slime::*;
#[cfg(feature = "chapters")]
pub use surface_region::*;
#[cfg(feature = "chapters")]
pub use table::*;
#[cfg(feature = "chapters")]
pub use topology::*;
#[cfg(feature = "chapters")]
pub use transfer::*;
#[cfg(feature = "chapters")]
pub use unions::*;

#[cfg(feature = "mpi")]
pub use mpi::*;
#[cfg(feature = "mpi")]
pub use world::*;

#[cfg(all(test, not(feature = "chapters")))]
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
        let expected = c"built without the feature chapters (CMake: CATAMARAN_CHAPTERS=ON)";
        assert_eq!(message, expected);
        assert_eq!(super::cata_capabilities() & super::CATA_CAP_CHAPTERS, 0);
    }
}
